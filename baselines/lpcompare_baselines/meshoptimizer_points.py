"""meshoptimizer's point simplification: one point of each occupied cell of the finest grid within the count.

The grid has a whole number of cells, so the counts come in steps, and fewer points than asked for come back.
The one kept is nearest to the mean of its cell. Coordinates are in single precision.
"""

from __future__ import annotations

import meshoptimizer  # pyright: ignore[reportMissingImports]
import numpy as np

from lpcompare.errors import NotApplicable
from lpcompare.geometry.scale import about_center
from lpcompare.types import Points, Simplification, Traits

TRAITS = Traits(
    wraps="meshoptimizer.simplify_points",
    source="Kapoulkine, meshoptimizer, https://github.com/zeux/meshoptimizer",
    licence="MIT",
    family="voxel",
    exact_count=False,
    requires=("meshoptimizer",),
    extra="meshoptimizer",
)


def meshoptimizer_points(points: Points, target_count: int, *, rng: np.random.Generator) -> Simplification:
    """Keep at most ``target_count`` points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Not used: the method is deterministic.

    Returns
    -------
    Simplification
        A subset of the input.

    Raises
    ------
    NotApplicable
        No grid has so few occupied cells.
    """
    centred = np.ascontiguousarray(about_center(points), dtype=np.float32)
    rows = np.empty(target_count, dtype=np.uint32)
    n_kept = meshoptimizer.simplify_points(rows, centred, target_vertex_count=target_count)
    if n_kept == 0:
        raise NotApplicable(f"meshoptimizer finds no grid with at most {target_count} points; ask for more.")
    indices = np.sort(rows[:n_kept].astype(np.intp))
    return Simplification(points[indices], indices)
