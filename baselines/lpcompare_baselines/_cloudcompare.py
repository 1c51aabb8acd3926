"""CloudCompare's command line, without a window."""

from __future__ import annotations

import numpy as np

from lpcompare.geometry.scale import bounding_box_center
from lpcompare.types import Indices, Points
from lpcompare_baselines._programs import through_program

_LOW = 2**16
_QUIET = "-SILENT -AUTO_SAVE OFF -NO_TIMESTAMP -C_EXPORT_FMT PLY -PLY_EXPORT_FMT BINARY_LE -O in.ply -SS"
_TYPE = [(name, "<f4") for name in ("x", "y", "z", "scalar_low", "scalar_high")]


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
    table = np.empty(len(points), dtype=_TYPE)
    columns = [*(points - bounding_box_center(points)).T, rows % _LOW, rows // _LOW]
    for (name, _), column in zip(_TYPE, columns, strict=True):
        table[name] = column
    thinning = [*_QUIET.split(), method, f"{parameter:.9g}", "-SAVE_CLOUDS", "FILE", "out.ply"]
    kept = through_program(table, ["CloudCompare", *thinning], QT_QPA_PLATFORM="offscreen")
    low, high = (kept[name].astype(np.intp) for name in ("scalar_low", "scalar_high"))
    return np.sort(high * _LOW + low)
