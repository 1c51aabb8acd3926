"""Files whose library can crash, hang or abort on damage, worked on in a child process.

pymeshlab's readers and the LAZ decompressor end the whole process on some damaged files; in a child that is
one more way in which a file cannot be read. Nothing from the current folder or from Python's variables runs
in it, and it ends with its parent.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import numpy as np

from lpcompare.errors import InputError, Unavailable
from lpcompare.files import ANOTHER_TMPDIR, writing
from lpcompare.io.arrays import packed, unpacked
from lpcompare.io.rows import Damaged
from lpcompare.types import Indices, PointCloud

_SECONDS = 18.0
_SECONDS_PER_MIB = 2.0
_MEMORY_BYTES = 2 * 2**30
_MEMORY_PER_BYTE = 60
_PARENT_DEATH = 1  # of Linux's prctl
_NO_ROOM = 28
"""Exit code of a child whose answer could not be written."""

_ROOT = Path(__file__).parents[2]
_START = (
    "import sys; sys.path.append(sys.argv[1]); from lpcompare.io.isolated import main; main(*sys.argv[2:])"
)
_ERRORS = {"InputError": InputError, "Unavailable": Unavailable}


def read(family: str, path: Path) -> PointCloud:
    """What ``read`` of a file of this folder returns.

    Raises
    ------
    InputError, Unavailable
        As the reader itself.
    Damaged
        The reader refused the file, crashed or did not come back.
    """
    with tempfile.TemporaryFile() as answer:
        said = _answer(path, [family, "read", str(path)], subprocess.DEVNULL, answer)
        arrays = {name: np.load(answer, allow_pickle=False) for name in said["names"]}
        return replace(unpacked(arrays, path.stem), beside=tuple(said["beside"]))


def keep_rows(family: str, source: Path, target: Path, rows: Indices) -> tuple[str, ...]:
    """Do what ``keep_rows`` of a file of this folder does; raises as `read`."""
    with tempfile.TemporaryFile() as answer, tempfile.TemporaryFile() as given:
        with writing(Path(tempfile.gettempdir()), ANOTHER_TMPDIR):
            np.save(given, rows)
            given.seek(0)
        return tuple(_answer(source, [family, "keep_rows", str(source), str(target)], given, answer)["names"])


def _answer(path: Path, arguments: list[str], given: int | IO[bytes], answer: IO[bytes]) -> dict[str, Any]:
    """Run `main` in a child; ``answer`` begins with a line that says how it went, which is returned."""
    limit = _SECONDS + _SECONDS_PER_MIB * path.stat().st_size / 2**20
    command = [sys.executable, "-P", "-c", _START, str(_ROOT), *arguments]
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    try:
        child = subprocess.run(
            command,
            stdin=given,
            stdout=answer,
            stderr=subprocess.DEVNULL,
            env=clean,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise Damaged(f"its reader did not come back within {limit:.0f} s") from error
    if child.returncode == _NO_ROOM:
        raise InputError(f"{tempfile.gettempdir()} has no room for the points of {path}; {ANOTHER_TMPDIR}.")
    answer.seek(0)
    line = answer.readline()
    if not line.endswith(b"\n"):
        raise Damaged(f"its reader crashed (exit code {child.returncode})")
    verdict = json.loads(line)
    if verdict["error"] == "OSError":
        raise OSError(errno.EIO, verdict["reason"])
    if verdict["error"]:
        raise _ERRORS.get(verdict["error"], Damaged)(verdict["reason"])
    return verdict


def main(family: str, action: str, source: str, target: str = "") -> None:
    """Read or copy one file; the child's side of `_answer`."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    _limit(Path(source))
    sys.modules["requests"] = None  # type: ignore[assignment] # laspy would import it for files behind a URL
    names: list[str] = []
    beside: Sequence[str] = ()
    values: list[Any] = []
    error = reason = ""
    try:
        module = import_module(f"lpcompare.io.{family}")
        if action == "read":
            cloud = module.read(Path(source))
            arrays, beside = packed(cloud), cloud.beside
            names, values = list(arrays), list(arrays.values())
        else:
            names = list(module.keep_rows(Path(source), Path(target), np.load(sys.stdin.buffer)))
    except (InputError, Unavailable, Damaged) as refusal:
        error, reason = type(refusal).__name__, str(refusal)
    except OSError as failure:
        error, reason = "OSError", failure.strerror or type(failure).__name__
    except BaseException:  # a Rust panic is no Exception; a library's own text is not for people
        error, reason = "Damaged", "it is damaged, or not of this format"
    try:
        out.write(
            json.dumps({"error": error, "reason": reason, "names": names, "beside": beside}).encode() + b"\n"
        )
        for array in values:
            np.save(out, array, allow_pickle=False)
        out.close()
    except OSError:
        os._exit(_NO_ROOM)


def _limit(source: Path) -> None:
    """A damaged count must not take the machine's memory, and the child ends when its parent does."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PARENT_DEATH, signal.SIGKILL)
    try:
        import resource
    except ImportError:  # systems without such limits go without
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    own = _MEMORY_BYTES + _MEMORY_PER_BYTE * source.stat().st_size
    known = [limit for limit in (own, soft, hard) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(known), hard))
