"""Poisson disk sampling of the points by MeshLab, at the radius that gives the count.

Corsini, Cignoni and Scopigno: no two kept points are nearer than a radius, and none could be added. MeshLab's
own search (``exactnumflag``) ends within 0.5 % and never ends when fewer distinct points exist than are
asked for; the search here is outside the clock and ends nearer.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._calibration import surface_spacing
from lpcompare_baselines._draws import draw_skip, search_draw, skip_draws
from lpcompare_baselines._guards import check, check_distinct
from lpcompare_baselines._meshlab import mesh_set, ml, rows_of

TRAITS = Traits(
    wraps="pymeshlab generate_sampling_poisson_disk (subsample)",
    source="Corsini, Cignoni and Scopigno, Efficient and flexible sampling with blue noise properties of "
    "triangular meshes, IEEE TVCG 18(6), 2012",
    licence="GPL-3.0",
    exact_count=False,
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, Any]:
    """Draws to skip, and radius in model units at which the draw after them has ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check(points, target_count)
    check_distinct(points, target_count)
    start = surface_spacing(points, target_count)
    draw = search_draw(lambda size, skip: _sample(points, size, skip), len(points), target_count, start, rng)
    return {"radius": draw.size, "n_skipped": draw.n_skipped}


def poisson_disk(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    radius: float | None = None,
    n_skipped: int | None = None,
) -> Simplification:
    """Keep a maximal set of points that are ``radius`` apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws ``n_skipped``; in a fresh process the same seed gives the same points.
    radius : float, optional
        In model units; by default the one that `calibrate` finds.
    n_skipped : int, optional
        Random numbers of MeshLab's to skip.

    Returns
    -------
    Simplification
        A subset of the input, of about ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check(points, target_count)
    if radius is None:
        return poisson_disk(points, target_count, rng=rng, **calibrate(points, target_count, rng=rng))
    indices = _sample(points, radius, draw_skip(rng) if n_skipped is None else n_skipped)
    return Simplification(points[indices], indices)


def _sample(points: Points, radius: float, n_skipped: int) -> Indices:
    skip_draws(n_skipped)
    meshes = mesh_set(points)
    meshes.generate_sampling_poisson_disk(subsample=True, radius=ml.PureValue(radius))
    return rows_of(meshes)
