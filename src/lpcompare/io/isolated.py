"""Files whose library can crash, hang or abort on damage, worked on in a child process.

pymeshlab's readers and the LAZ decompressor end the whole process on some damaged files; in a child that is
one more way in which a file cannot be read.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import InputError, Unavailable
from lpcompare.types import Indices, PointCloud

_SECONDS = 20.0
_SECONDS_PER_MIB = 2.0
_FIELDS = ("points", "normals", "colors", "faces")
_ATTRIBUTE = "attribute:"


def read(family: str, path: Path) -> PointCloud:
    """What ``read`` of a file of this folder returns.

    Raises
    ------
    InputError, Unavailable
        As the reader itself.
    ValueError
        The reader refused the file, crashed or did not come back.
    """
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        result = Path(folder) / "cloud.npz"
        _run_child(path, [family, "read", str(path), str(result)])
        with np.load(result, allow_pickle=False) as arrays:
            return unpacked({name: arrays[name] for name in arrays.files}, path.stem)


def keep_rows(family: str, source: Path, target: Path, rows: Indices) -> None:
    """Do what ``keep_rows`` of a file of this folder does; raises as `read`."""
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        np.save(Path(folder) / "rows.npy", rows)
        arguments = [family, "keep_rows", str(source), str(target), str(Path(folder) / "rows.npy")]
        _run_child(source, arguments)


def packed(cloud: PointCloud) -> dict[str, NDArray[Any]]:
    """The cloud as named arrays; the name itself is the file's."""
    arrays = {name: getattr(cloud, name) for name in _FIELDS if getattr(cloud, name) is not None}
    return arrays | {_ATTRIBUTE + name: values for name, values in cloud.attributes.items()}


def unpacked(arrays: Mapping[str, NDArray[Any]], name: str) -> PointCloud:
    """The cloud of `packed` arrays."""
    attributes = {k.removeprefix(_ATTRIBUTE): v for k, v in arrays.items() if k.startswith(_ATTRIBUTE)}
    return PointCloud(**{k: arrays[k] for k in _FIELDS if k in arrays}, attributes=attributes, name=name)


def _run_child(path: Path, arguments: list[str]) -> None:
    """Run `isolated_child`; the last line of its output is "done" or the reason of a refusal."""
    limit = _SECONDS + _SECONDS_PER_MIB * path.stat().st_size / 2**20
    command = [sys.executable, "-m", "lpcompare.io.isolated_child", *arguments]
    try:
        child = subprocess.run(command, capture_output=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"its reader did not come back within {limit:.0f} s") from error
    answer = child.stdout.decode(errors="replace").rpartition("\n")[2]
    if not answer.startswith("{"):
        raise ValueError(f"its reader crashed (exit code {child.returncode})")
    verdict = json.loads(answer)
    if verdict["error"]:
        raise {"InputError": InputError, "Unavailable": Unavailable}.get(verdict["error"], ValueError)(
            verdict["reason"]
        )
