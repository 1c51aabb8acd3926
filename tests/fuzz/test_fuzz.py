"""Thousands of damaged files of every kind: a sentence or a cloud, no traceback, no hang, no full memory.

``--fuzz-seconds`` (or LPCOMPARE_FUZZ_SECONDS) is the time for all kinds together, ``--fuzz-files`` the most files of
a kind, ``--fuzz-seed`` another series. docs/reliability.md has the figures of a long run.
"""

import queue
import subprocess
import sys
import threading
from pathlib import Path

import pytest

FORMATS = (
    *(
        ".ply",
        ".obj",
        ".off",
        ".asc",
        ".csv",
        ".pts",
        ".txt",
        ".xyz",
        ".ptx",
        ".las",
        ".laz",
        ".pcd",
        ".npy",
        ".npz",
    ),
    *(".3ds", ".apts", ".ctm", ".dae", ".e57", ".glb", ".gltf", ".stl", ".tri", ".wrl", ".x3d", ".x3dv"),
)
KINDS = (*FORMATS, "study", "run.json")
HANG_SECONDS = 20
START_SECONDS = 120
MOST_MIB = 2048


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_read_or_refused(kind, tmp_path, fuzz, record_property):
    lines = list(_lines(kind, tmp_path, fuzz))
    faults = [line for line in lines if "FAULT" in line or "HANG" in line]
    counts = {word: sum(f" {word} " in line for line in lines) for word in ("read", "refused")}
    memory = next((int(line.split()[1]) for line in lines if line.startswith("MiB")), None)
    print(f"{kind}: {sum(counts.values())} files, {counts}, {memory} MiB, {len(faults)} faults")
    assert not faults, "\n".join(faults[:10])
    assert memory is not None, f"the worker died at {lines[-1:]}"
    assert memory < MOST_MIB
    assert sum(counts.values()) > 0
    record_property("files", sum(counts.values()))


def _lines(kind, folder, fuzz):
    """What the worker says; a case of more than twenty seconds ends it."""
    words = [kind, fuzz.seed, fuzz.files, fuzz.seconds / len(KINDS), folder]
    command = [sys.executable, Path(__file__).with_name("worker.py"), *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as worker:
        said, limit = queue.Queue(), START_SECONDS
        threading.Thread(target=lambda: [*map(said.put, worker.stdout), said.put("")], daemon=True).start()
        try:
            while line := said.get(timeout=limit):
                yield line
                limit = HANG_SECONDS + 5
        except queue.Empty:
            worker.kill()
            yield "HANG of more than 20 s"
        if error := worker.stderr.read():
            yield f"FAULT on standard error: {error[-2000:]}"
