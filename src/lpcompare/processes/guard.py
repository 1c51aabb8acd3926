"""The guard of a child process: it imports nothing else of ours.

It starts the child and adopts all that the child's descendants leave behind. It watches their time and their
memory, and ends every one of them when the child has ended, when a limit is reached, or when the process
that asked for the child is gone, however that went. `lpcompare.processes.children` runs it as a program;
`lpcompare.processes.nursery` forks it, and it forks the child.
"""

import ctypes
import json
import os
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import IO, Any, NoReturn

_LINUX = sys.platform == "linux"
_ANSWER_BYTES, _ERROR_BYTES = 4 * 2**20, 2**16
_LOOK_S, _END_S = 0.2, 4.0
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36


class Tail(threading.Thread):
    """The last bytes of a stream, which is read to its end."""

    def __init__(self, stream: IO[bytes], size: int) -> None:
        super().__init__(daemon=True)
        self._stream, self._size, self._bytes = stream, size, bytearray()
        self.start()

    def run(self) -> None:
        """Read on; forget what lies too far back."""
        while block := self._stream.read(2**16):
            self._bytes += block
            if len(self._bytes) > 2 * self._size:
                del self._bytes[: -self._size]

    def text(self) -> str:
        """What was kept; waits a moment for the rest."""
        self.join(1.0)
        return bytes(self._bytes[-self._size :]).decode("utf-8", "replace")


class Forked:
    """A child that runs a function of this process, with what `subprocess.Popen` offers of a program."""

    def __init__(self, work: Callable[[], object], prepare: Callable[[], object]) -> None:
        self.returncode: int | None = None
        (out, answer), (err, errors) = os.pipe(), os.pipe()
        self.stdout, self.stderr = open(out, "rb", 0), open(err, "rb", 0)  # noqa: SIM115 - read to the end
        self.pid = os.fork()
        if not self.pid:
            _run({0: os.open(os.devnull, os.O_RDONLY), 1: answer, 2: errors}, work, prepare)
        os.close(answer)
        os.close(errors)

    def wait(self) -> None:
        """Wait for its end."""
        self.returncode = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])

    def kill(self) -> None:
        """End it."""
        os.kill(self.pid, signal.SIGKILL)


def _run(streams: dict[int, int], work: Callable[[], object], prepare: Callable[[], object]) -> NoReturn:
    """Become the forked child."""
    code = 1
    try:
        os.setsid()
        for number, stream in streams.items():
            os.dup2(stream, number)
            os.close(stream)
        prepare()
        work()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def main() -> None:
    """Run the program that the first argument orders, and print how it ended as JSON."""

    def tell(text: bytes) -> None:
        sys.stdout.buffer.write(text)
        sys.stdout.flush()

    guard(json.loads(sys.argv[1]), sys.stdin.buffer.read, tell)


def guard(
    order: dict[str, Any],
    told: Callable[[], object],
    tell: Callable[[bytes], object],
    work: Callable[[], object] | None = None,
) -> NoReturn:
    """Run a child to its end, tell how it ended, and end this process.

    Parameters
    ----------
    order : mapping
        ``command``, ``folder``, ``time_limit_s``, ``memory_limit_mib``.
    told : callable
        Returns when the process that asked for the child is gone, or wants it ended.
    tell : callable
        Called with how it ended, as JSON.
    work : callable, optional
        What a forked child does; by default the child runs the command.
    """
    prctl(PR_SET_CHILD_SUBREAPER, 1)
    try:
        child = _start(order, work)
    except OSError as error:
        _tell(tell, 127, "", "", str(error))
    answer, errors = Tail(child.stdout, _ANSWER_BYTES), Tail(child.stderr, _ERROR_BYTES)  # type: ignore[arg-type]
    over, left_alone = threading.Event(), threading.Event()
    waiter = _in_background(lambda: (child.wait(), over.set()))
    _in_background(lambda: (told(), left_alone.set(), over.set()))
    limit = _watch(order, child.pid, over)
    code = None if limit or left_alone.is_set() else child.returncode
    _end_all(child, waiter)
    if left_alone.is_set():
        os._exit(1)
    _tell(tell, code, limit, answer.text(), errors.text())


def _tell(
    tell: Callable[[bytes], object], code: int | None, limit: str, answer: str, errors: str
) -> NoReturn:
    tell(json.dumps({"code": code, "limit": limit, "answer": answer, "errors": errors}).encode())
    os._exit(0)


def prctl(option: int, value: int) -> None:
    """Set what Linux does with this process; other systems have no such thing."""
    if _LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def _start(order: dict[str, Any], work: Callable[[], object] | None) -> subprocess.Popen[bytes] | Forked:
    def limits() -> None:
        prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        limit_memory(order["memory_limit_mib"])

    if work:
        return Forked(work, lambda: (os.chdir(order["folder"]), limits()))
    return subprocess.Popen(
        order["command"],
        cwd=order["folder"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
        start_new_session=True,
        preexec_fn=limits if os.name == "posix" else None,  # noqa: PLW1509 - there is no other thread yet
    )


def limit_memory(limit_mib: int) -> None:
    """Let allocations beyond ``limit_mib`` fail in this process; a limit that is lower already stays.

    RLIMIT_DATA counts what is allocated; RLIMIT_AS would count address space, which thread arenas and
    libraries reserve by the gigabyte without using it.
    """
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    known = [limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY]
    limit = min([limit_mib * 2**20, *known])
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _watch(order: dict[str, Any], pid: int, over: threading.Event) -> str:
    """Wait until the child has ended, and return which limit came first, or nothing."""
    deadline = monotonic() + order["time_limit_s"]
    while not over.wait(max(0.0, min(_LOOK_S, deadline - monotonic()))):
        if monotonic() >= deadline:
            return "time"
        if _memory_mib([pid, *descendants(pid)], order["memory_limit_mib"]) > order["memory_limit_mib"]:
            return "memory"
    return ""


def _memory_mib(pids: list[int], limit_mib: int) -> float:
    """Resident memory of processes in MiB, files apart; exact only above the limit.

    The quick sum counts what processes share once for each of them, the exact one shares it out.
    """
    quick = sum(_mib(pid, "status", ("RssAnon:", "RssShmem:")) for pid in pids)
    if quick <= limit_mib:
        return quick
    return sum(_mib(pid, "smaps_rollup", ("Pss_Anon:", "Pss_Shmem:")) for pid in pids)


def _mib(pid: int, file: str, fields: tuple[str, ...]) -> float:
    if not _LINUX:
        import psutil

        with suppress(psutil.Error):
            return psutil.Process(pid).memory_info().rss / 2**20
        return 0.0
    with suppress(OSError):
        lines = Path(f"/proc/{pid}/{file}").read_text(errors="replace").splitlines()
        return sum(int(line.split()[1]) for line in lines if line.startswith(fields)) / 1024
    return 0.0


def descendants(pid: int) -> list[int]:
    """Every process that one has started or adopted, and theirs."""
    found = [pid]
    for one in found:  # it grows meanwhile
        found += children(one)
    return found[1:]


def children(pid: int) -> list[int]:
    """Processes that one has started or adopted."""
    found: list[int] = []
    if not _LINUX:
        import psutil

        with suppress(psutil.Error):
            return [child.pid for child in psutil.Process(pid).children()]
        return found
    with suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            with suppress(OSError):
                found += map(int, (task / "children").read_text().split())
    return found


def _end_all(child: subprocess.Popen[bytes] | Forked, waiter: threading.Thread) -> None:
    """End the child and all that it has started; only SIGKILL ends a library that loops."""
    with suppress(OSError):
        child.kill()
    waiter.join(_END_S)
    end_processes(lambda: descendants(os.getpid()))


def end_processes(find: Callable[[], list[int]]) -> None:
    """Kill processes that this one has adopted, until ``find`` finds none; give up after seconds."""
    deadline = monotonic() + _END_S
    while (pids := find()) and monotonic() < deadline:
        for pid in pids:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
        for pid in pids:
            with suppress(ChildProcessError):
                _ = _LINUX and os.waitpid(pid, os.WNOHANG)
        sleep(0.002)


def _in_background(work: Any) -> threading.Thread:
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


if __name__ == "__main__":
    main()
