"""Poisson disk sampling of the points by MeshLab, at the radius that gives the count.

Corsini, Cignoni and Scopigno: no two kept points are nearer than a radius, and none could be added. MeshLab's
own search (``exactnumflag``) ends within 0.5 % and never ends when fewer distinct points exist than are
asked for; the search here is outside the clock and ends nearer.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._calibration import surface_spacing
from lpcompare_baselines._draws import drawn_rows, search_draw
from lpcompare_baselines._meshlab import finest_length, length

TRAITS = Traits(
    family="spacing",
    wraps="pymeshlab generate_sampling_poisson_disk (subsample)",
    source="Corsini, Cignoni and Scopigno, Efficient and flexible sampling with blue noise properties of "
    "triangular meshes, IEEE TVCG 18(6), 2012",
    licence="GPL-3.0",
    exact_count=False,
    own_process=True,
    in_tiles=True,
)


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, Any]:
    """Radius, in model units, and order of the points at which a draw has ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """
    sample, start = partial(_sample, points), surface_spacing(points, target_count)
    draw = search_draw(sample, points, target_count, start, rng, smallest=finest_length(points))
    return {"radius": draw.size, "order_seed": draw.order_seed}


def poisson_disk(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    radius: float,
    order_seed: int,
) -> Simplification:
    """Keep a maximal set of points that are ``radius`` apart.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws ``order_seed``; in a fresh process the same seed gives the same points.
    radius : float
        In model units; `calibrate` finds it.
    order_seed : int
        Seed of the order in which MeshLab sees the points; by default drawn from ``rng``.

    Returns
    -------
    Simplification
        A subset of the input, of about ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer distinct points exist than are asked for.
    """
    indices = _sample(points, radius, order_seed)
    return Simplification(points[indices], indices)


def _sample(points: Points, radius: float, order_seed: int) -> Indices:
    def thin(meshes: Any) -> None:
        meshes.generate_sampling_poisson_disk(subsample=True, radius=length(radius, points))

    return drawn_rows(points, order_seed, thin)
