"""The other formats that MeshLab reads, in a child process: a damaged file can crash or hang its reader."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from lpcompare.errors import InputError
from lpcompare.io.checks import checked_points
from lpcompare.types import PointCloud

_SECONDS = 60.0
_SECONDS_PER_MIB = 2.0


def read(path: Path) -> PointCloud:
    """The layers of the file as one cloud, read by pymeshlab.

    Raises
    ------
    InputError
        pymeshlab cannot read it, crashes on it, or does not come back.
    Unavailable
        pymeshlab or one of its system libraries is missing.
    """
    with tempfile.TemporaryDirectory(prefix="lpcompare-") as folder:
        result = Path(folder) / "cloud.npz"
        _run_child(path, result)
        with np.load(result, allow_pickle=False) as arrays:
            fields = {name: arrays[name] for name in arrays.files}
    attributes = {"quality": fields["quality"]} if "quality" in fields else {}
    points = checked_points(fields["points"], path.name)
    return PointCloud(
        points, fields.get("normals"), fields.get("colors"), attributes, fields.get("faces"), path.stem
    )


def _run_child(path: Path, result: Path) -> None:
    """Let `foreign_child` write the arrays; its last line on stderr is the reason of a refusal."""
    limit = _SECONDS + _SECONDS_PER_MIB * path.stat().st_size / 2**20
    command = [sys.executable, "-m", "lpcompare.io.foreign_child", str(path.resolve()), str(result)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired as error:
        raise InputError(f"{path} cannot be read: MeshLab's reader hung for {limit:.0f} s.") from error
    if not result.is_file():
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        refused = bool(lines) and lines[-1].startswith("{")
        reason = json.loads(lines[-1])["reason"] if refused else f"crashed (exit code {done.returncode})"
        raise InputError(f"{path} cannot be read: MeshLab's reader {reason}.")
