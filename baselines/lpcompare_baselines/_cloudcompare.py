"""CloudCompare's command line, without a window."""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Points
from lpcompare_baselines._programs import numbered, through_program

_LOW = 2**16
_QUIET = "-SILENT -AUTO_SAVE OFF -NO_TIMESTAMP -C_EXPORT_FMT PLY -PLY_EXPORT_FMT BINARY_LE -O in.ply -SS"


def subsample(points: Points, method: str, parameter: float) -> Indices:
    """Rows that ``CloudCompare -SS`` keeps, ascending.

    The cloud goes through a file in single precision, about the centre of its bounding box; the row numbers go
    with it as two scalar fields, each exact in single precision.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    method : str
        "RANDOM", "SPATIAL" or "OCTREE".
    parameter : float
        Number of points, distance in model units, or level.
    """
    rows = np.arange(len(points))
    halves = [("scalar_low", "<f4", rows % _LOW), ("scalar_high", "<f4", rows // _LOW)]
    table = numbered(points, "<f4", halves)
    thinning = [*_QUIET.split(), method, f"{parameter:.9g}", "-SAVE_CLOUDS", "FILE", "out.ply"]
    kept = through_program(table, ["CloudCompare", *thinning], QT_QPA_PLATFORM="offscreen")
    low, high = (kept[name].astype(np.intp) for name in ("scalar_low", "scalar_high"))
    return np.sort(high * _LOW + low)
