"""Read damaged files of one kind, one after the other; a program of its own, so that a crash costs no test.

    python tests/fuzz/worker.py KIND SEED FILES SECONDS FOLDER

Each case is a line: its number, then "read", "refused" or "FAULT" with the reason. The readers that run in a child
process run in a fork here, which starts a hundred times as fast.
"""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from mutations import mutated
from samples import samples

from lpcompare.errors import LpcompareError
from lpcompare.io import isolated, keep_rows, read, same_format

MEMORY_MIB = 2048


def forked(command, *, stdin, stdout, stderr, env, timeout, check):
    """What `subprocess.run` would do with the child of `lpcompare.io.isolated`."""
    child = os.fork()
    if not child:
        try:
            os.dup2(stdout.fileno(), 1)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            if not isinstance(stdin, int):
                os.dup2(stdin.fileno(), 0)
                sys.stdin = os.fdopen(0, closefd=False)
            isolated.main(*command[5:])
        finally:
            os._exit(1)
    end = time.monotonic() + timeout
    while not (done := os.waitpid(child, os.WNOHANG))[0]:
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            raise subprocess.TimeoutExpired(command, timeout)
        time.sleep(0.002)
    return subprocess.CompletedProcess(command, os.waitstatus_to_exitcode(done[1]))


def tried(kind, path, folder):
    """Work on one file as the command does; returns "read" or "refused", raises what should not be."""
    try:
        if kind == "study":
            from lpcompare.benchmark.study import read_study

            read_study(str(path))
        elif kind in ("run.json", "cases.jsonl"):
            from lpcompare import load_run

            assert load_run(folder).frame is not None
        else:
            cloud = read(path)
            assert cloud.points.shape == (len(cloud), 3), cloud
            copy = path.with_name(f"copy{path.suffix}")
            if same_format(path, copy):
                keep_rows(path, copy, np.arange(0, len(cloud), 3))
                assert len(read(copy)) == len(range(0, len(cloud), 3))
    except LpcompareError as error:
        said = str(error)
        assert not any(sign in said.replace(str(path), "") for sign in ("\n", "Traceback", "://")), said
        return "refused"
    return "read"


def main(kind, seed, files, seconds, folder):
    """Print a line for each file, and the largest memory in MiB at the end."""
    isolated.subprocess = type("Forked", (), {**vars(subprocess), "run": staticmethod(forked)})
    folder = Path(folder)
    given = material(kind, folder)
    names, end = sorted(given), time.monotonic() + float(seconds)
    for name, content in given.items():
        (folder / name).write_bytes(content)
    for i in range(int(files)):
        if time.monotonic() > end:
            break
        name = names[i % len(names)]
        path = folder / name
        path.write_bytes(mutated(given[name], f"{seed}:{name}:{i}"))
        print(i, name, end=" ", flush=True)
        start = time.monotonic()
        try:
            print(tried(kind, path, folder), f"{time.monotonic() - start:.2f}", flush=True)
        except BaseException as error:
            print("FAULT", type(error).__name__, " ".join(str(error).split())[:300], flush=True)
        path.write_bytes(given[name])
    largest = max(
        resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    print("MiB", largest // 1024, flush=True)


def material(kind, folder):
    """The sound files of a kind."""
    if kind in ("run.json", "cases.jsonl"):
        import lpcompare as lp

        lp.run(models=["sphere"], methods=["random_sample"], reductions=[0.9], out=folder)
        found = [folder / "run.json", *folder.glob("*.jsonl")]
        return {path.name: path.read_bytes() for path in found}
    made, ending = samples(folder), ".study.toml" if kind == "study" else kind
    (folder / "b.bin").write_bytes(made["b.bin"])
    return {name: content for name, content in made.items() if name.endswith(ending)}


if __name__ == "__main__":
    main(*sys.argv[1:])
