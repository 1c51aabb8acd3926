"""Child processes: their limits, their clean start, and that nothing of theirs is left."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest

from lpcompare.processes import children
from lpcompare.processes.children import Children, Stopped, clean_environment, python, temporary_folder

DAEMON = (
    "import os, time\nif not os.fork():\n os.setsid()\n if not os.fork(): time.sleep(600)\n os._exit(0)\n"
)


def run(code, folder, **limits):
    chosen = {"time_limit_s": 20, "memory_limit_mib": 2000} | limits
    return Children().run(python("-c", code), folder, **chosen)


def alive(folder):
    """Processes whose current folder is this one."""
    found = []
    for process in psutil.process_iter(["cwd", "status"]):
        if process.info["cwd"] == str(folder) and process.info["status"] != psutil.STATUS_ZOMBIE:
            found.append(process.pid)
    return found


def wait_until_gone(folder, seconds=5.0):
    deadline = time.monotonic() + seconds
    while alive(folder) and time.monotonic() < deadline:
        time.sleep(0.05)
    return alive(folder) == []


def test_an_ending_has_the_exit_code_and_both_streams(tmp_path):
    ending = run("import sys; print('a'); sys.stderr.write('b\\n\\nc\\n'); sys.exit(3)", tmp_path)
    assert (ending.code, ending.limit, ending.answer) == (3, "", "a\n")
    assert ending.last_lines() == "b | c"
    assert run("import os; os.abort()", tmp_path).code == -signal.SIGABRT


def test_a_program_that_does_not_exist_is_an_ending_too(tmp_path):
    ending = Children().run(["/no/such/program"], tmp_path, time_limit_s=5, memory_limit_mib=500)
    assert ending.code == 127
    assert "No such file" in ending.errors


def test_the_time_limit_ends_the_child_and_what_it_started(tmp_path):
    began = time.monotonic()
    code = DAEMON + "import subprocess; subprocess.Popen(['sleep', '600'])\nwhile True: time.sleep(1)"
    assert run(code, tmp_path, time_limit_s=1).limit == "time"
    assert time.monotonic() - began < 10
    assert alive(tmp_path) == []


def test_a_daemon_that_left_the_session_ends_with_its_child(tmp_path):
    assert run(DAEMON, tmp_path).code == 0
    assert alive(tmp_path) == []


def test_memory_that_is_shared_or_spread_over_processes_counts(tmp_path):
    shared = "import mmap, time\nm = mmap.mmap(-1, 400 << 20)\n"
    fill = "for i in range(0, 400 << 20, 4096): m[i] = 1\ntime.sleep(600)"
    assert run(shared + fill, tmp_path, memory_limit_mib=300).limit == "memory"
    spread = "import os, time\nfor _ in range(4):\n if not os.fork(): break\n"
    assert run(spread + "b = b'x' * (100 << 20)\ntime.sleep(600)", tmp_path, memory_limit_mib=300).limit == (
        "memory"
    )


def test_what_processes_share_is_counted_once(tmp_path):
    code = "import os, time\nb = b'x' * (200 << 20)\nfor _ in range(4):\n if not os.fork(): break\n"
    assert run(code + "time.sleep(1)", tmp_path, memory_limit_mib=600).limit == ""


def test_a_lower_limit_is_never_raised(tmp_path):
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_DATA, (300 << 20,) * 2)\n"
        "from lpcompare.processes.guard import limit_memory; limit_memory(100_000)\n"
        "print(resource.getrlimit(resource.RLIMIT_DATA)[0] >> 20)"
    )
    assert run(code, tmp_path).answer == "300\n"


def test_endless_output_is_bounded(tmp_path):
    code = "import os\nwhile True: os.write(1, b'x' * 65536), os.write(2, b'y' * 65536)"
    ending = run(code, tmp_path, time_limit_s=1)
    assert len(ending.answer) <= 4 << 20
    assert len(ending.errors) <= 1 << 16


def test_nothing_of_the_current_folder_is_imported(tmp_path, monkeypatch):
    (tmp_path / "json.py").write_text("raise SystemExit('from the current folder')")
    (tmp_path / "sitecustomize.py").write_text("raise SystemExit('from the current folder')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", f"{os.pathsep}.{os.pathsep}")
    monkeypatch.setenv("PYTHONSTARTUP", str(tmp_path / "json.py"))
    assert run("import json; print(json.__file__)", tmp_path).answer.startswith(sys.base_prefix)
    assert "PYTHONSTARTUP" not in clean_environment()


def test_a_killed_guard_takes_everything_with_it(tmp_path):
    code = DAEMON + "import signal; os.kill(os.getppid(), signal.SIGKILL); time.sleep(600)"
    assert run(code, tmp_path).limit == "guard"
    assert wait_until_gone(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGKILL], ids=lambda s: s.name)
def test_after_the_end_of_the_parent_nothing_is_left(tmp_path, number):
    started = tmp_path / "started"
    code = f"{DAEMON}open({str(started)!r}, 'w').close()\nwhile True: time.sleep(1)"
    parent = (
        "from pathlib import Path; from lpcompare.processes.children import Children, python\n"
        f"Children().run(python('-c', {code!r}), Path({str(tmp_path)!r}), time_limit_s=60,"
        "memory_limit_mib=500)"
    )
    process = subprocess.Popen([sys.executable, "-P", "-c", parent])
    deadline = time.monotonic() + 20
    while not started.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    assert alive(tmp_path), "they run"
    process.send_signal(number)
    process.wait()
    assert wait_until_gone(tmp_path)


def test_stop_ends_those_who_wait(tmp_path):
    crowd, met = Children(), []

    def wait():
        try:
            crowd.run(
                python("-c", "import time; time.sleep(600)"), tmp_path, time_limit_s=60, memory_limit_mib=99
            )
        except Stopped:
            met.append("stopped")

    threads = [threading.Thread(target=wait) for _ in range(2)]
    for thread in threads:
        thread.start()
    time.sleep(0.5)
    crowd.stop()
    for thread in threads:
        thread.join(10)
    assert met == ["stopped", "stopped"]
    assert wait_until_gone(tmp_path)


def test_folders_of_killed_processes_are_removed_and_those_of_others_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(children.tempfile, "tempdir", str(tmp_path))
    hold = (
        "import time, tempfile; tempfile.tempdir = {!r}\nfrom lpcompare.processes.children import temporary_folder\n"
        "with temporary_folder() as folder: print(folder, flush=True); time.sleep(60)"
    )
    words = [sys.executable, "-P", "-c", hold.format(str(tmp_path))]
    killed, living = (subprocess.Popen(words, stdout=subprocess.PIPE, text=True) for _ in range(2))
    left, kept = (Path(process.stdout.readline().strip()) for process in (killed, living))
    killed.kill()
    killed.wait()
    (tmp_path / "lpcompare-of-another-kind").mkdir()
    with temporary_folder() as folder:
        assert folder.is_dir()
        assert not left.exists()
        assert kept.is_dir()
    assert not folder.exists()
    living.kill()
    living.wait()
    for process in (killed, living):
        process.stdout.close()
    assert (tmp_path / "lpcompare-of-another-kind").is_dir()


NURSED = """
import os, signal, sys, time
import numpy
prepared = []
def prepare(word):
    prepared.append((word, os.getpid()))
def main(deed):
    print(prepared[0][0], os.getcwd(), os.environ["TMPDIR"], file=sys.stderr)
    if deed == "asks": print(prepared[0][1])
    elif deed == "fails": raise ValueError("on purpose")
    elif deed == "ends": os._exit(3)
    elif deed == "daemon": exec(DAEMON)
    elif deed == "sleeps": time.sleep(600)
    elif deed == "fills": x = b"x" * (900 << 20)
    elif deed == "kills its guard": exec(DAEMON); os.kill(os.getppid(), signal.SIGKILL); time.sleep(600)
    elif deed == "kills both":
        exec(DAEMON); os.kill(prepared[0][1], signal.SIGKILL); os.kill(os.getppid(), signal.SIGKILL); time.sleep(600)
"""


@pytest.fixture
def nursed(tmp_path, monkeypatch):
    """Calls a module that was prepared once: `call(deed)` returns the ending."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "nursed.py").write_text(NURSED + f"DAEMON = {DAEMON!r}\n")
    monkeypatch.setenv("PYTHONPATH", str(home))
    folder = tmp_path / "here"
    folder.mkdir()
    with Children() as crowd:
        crowd.prepare("nursed", "word")

        def call(deed, **limits):
            chosen = {"time_limit_s": 20, "memory_limit_mib": 2000} | limits
            return crowd.call("nursed", deed, folder=folder, **chosen)

        call.folder, call.crowd = folder, crowd
        yield call


@pytest.mark.skipif(sys.platform != "linux", reason="children are forked on Linux only")
def test_a_prepared_module_is_prepared_once_for_all_children(nursed):
    first, second = nursed("asks"), nursed("asks")
    assert first.code == second.code == 0
    assert first.answer == second.answer
    assert first.errors.split() == ["word", str(nursed.folder), str(nursed.folder)]


@pytest.mark.skipif(sys.platform != "linux", reason="children are forked on Linux only")
def test_a_forked_child_ends_as_a_program_does(nursed):
    assert nursed("ends").code == 3
    assert nursed("fails").last_lines(1) == "ValueError: on purpose"
    assert nursed("sleeps", time_limit_s=1).limit == "time"
    assert "MemoryError" in nursed("fills", memory_limit_mib=600).errors
    assert nursed("daemon").code == 0
    assert alive(nursed.folder) == []


@pytest.mark.skipif(sys.platform != "linux", reason="children are forked on Linux only")
@pytest.mark.parametrize("deed", ["kills its guard", "kills both"])
def test_a_forked_child_that_kills_its_watchers_costs_its_own_row(nursed, deed):
    assert nursed(deed).limit == "guard"
    assert wait_until_gone(nursed.folder)
    assert nursed("asks").code == 0


@pytest.mark.skipif(sys.platform != "linux", reason="children are forked on Linux only")
def test_a_neighbor_lives_on_when_the_watchers_of_another_are_killed(nursed):
    answers = []
    thread = threading.Thread(target=lambda: answers.append(nursed("sleeps", time_limit_s=4)))
    thread.start()
    time.sleep(1)
    assert nursed("kills both").limit == "guard"
    thread.join(20)
    assert [ending.limit for ending in answers] == ["time"]


@pytest.mark.skipif(sys.platform != "linux", reason="children are forked on Linux only")
def test_stop_ends_forked_children(nursed):
    met = []

    def wait():
        try:
            nursed("sleeps")
        except Stopped:
            met.append("stopped")

    thread = threading.Thread(target=wait)
    thread.start()
    time.sleep(1)
    nursed.crowd.stop()
    thread.join(10)
    assert met == ["stopped"]
    assert wait_until_gone(nursed.folder)
