"""PDAL's command line, written from its manual: ``pdal translate`` with one filter.

Manual: https://pdal.org, the pages of ``translate``, ``readers.ply``, ``writers.ply`` and of each filter. PDAL
could not be installed where this was written, so the tests run a stand-in that takes the same words.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Indices, Points
from lpcompare_baselines._programs import numbered, through_program


def translate(points: Points, name: str, **options: float) -> Indices:
    """Rows that a filter of PDAL keeps, ascending.

    The cloud goes through a file in double precision, about the centre of its bounding box. Its row numbers go
    with it as a dimension, which the filters that choose among the points keep.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    name : str
        The filter, such as "filters.sample".
    **options : float
        Its options.
    """
    table = numbered(points, "<f8", [("row", "<i4", np.arange(len(points)))])
    chosen = [f"--{name}.{option}={value:.17g}" for option, value in options.items()]
    words = [
        "pdal",
        "translate",
        "in.ply",
        "out.ply",
        name,
        *chosen,
        "--writers.ply.storage_mode=little endian",
    ]
    kept = through_program(table, words)
    field = next(field for field in kept.dtype.names or () if field.lower() == "row")
    return np.sort(kept[field].astype(np.intp))
