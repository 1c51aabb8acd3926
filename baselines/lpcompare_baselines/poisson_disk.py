"""Poisson disk sampling of the points by MeshLab, at the radius that gives the count.

Corsini, Cignoni and Scopigno: no two kept points are nearer than a radius, and none could be added. MeshLab's
own search (``exactnumflag``) ends within 0.5 % and never ends when fewer distinct points exist than are
asked for; the search here is outside the clock and ends nearer.
"""

from __future__ import annotations

import numpy as np

from lpcompare.types import Points, Simplification, Traits
from lpcompare_baselines._calibration import search_size, surface_spacing
from lpcompare_baselines._meshlab import advance_generator, check, check_distinct, mesh_set, ml, rows_of

TRAITS = Traits(
    wraps="pymeshlab generate_sampling_poisson_disk (subsample)",
    source="Corsini, Cignoni and Scopigno, Efficient and flexible sampling with blue noise properties of "
    "triangular meshes, IEEE TVCG 18(6), 2012",
    licence="GPL-3.0",
    exact_count=False,
)

_NEAR_ENOUGH = 0.0005
"""Share of the count: about the spread between two draws at one radius."""


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, float]:
    """Radius, in model units, that gives about ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    check(points, target_count)
    check_distinct(points, target_count)
    radius = search_size(
        lambda size: len(_sample(points, size)),
        target_count,
        surface_spacing(points, target_count),
        tolerance=int(_NEAR_ENOUGH * target_count),
    )
    return {"radius": radius}


def poisson_disk(
    points: Points, target_count: int, *, rng: np.random.Generator, radius: float | None = None
) -> Simplification:
    """Keep a maximal set of points that are ``radius`` apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Moves MeshLab's generator on; in a fresh process the same seed gives the same points.
    radius : float, optional
        In model units; by default the one that `calibrate` finds.

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
        radius = calibrate(points, target_count, rng=rng)["radius"]
    advance_generator(rng)
    indices = _sample(points, radius)
    return Simplification(points[indices], indices)


def _sample(points: Points, radius: float):
    meshes = mesh_set(points)
    meshes.generate_sampling_poisson_disk(subsample=True, radius=ml.PureValue(radius))
    return rows_of(meshes)
