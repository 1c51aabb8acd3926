"""MeshLab's own point cloud simplification, asked for the number at which it returns the count.

The filter guesses a Poisson disk radius from the bounding box and never corrects it: it returns a third more
points than it is asked for, and its exact-number flag has no effect. Outside the clock it is asked for fewer
until the points returned are those wanted.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lpcompare.types import Indices, Points, Simplification, Traits
from lpcompare_baselines._draws import drawn_rows, search_draw

TRAITS = Traits(
    family="spacing",
    wraps="pymeshlab generate_simplified_point_cloud",
    source="Corsini, Cignoni and Scopigno, Efficient and flexible sampling with blue noise properties of "
    "triangular meshes, IEEE TVCG 18(6), 2012",
    licence="GPL-3.0",
    exact_count=False,
    own_process=True,
)

_MOST_ASKED = 2_000_000_000
_USUAL_EXCESS = 1.36


def calibrate(points: Points, target_count: int, *, rng: np.random.Generator) -> dict[str, int]:
    """``samplenum`` and order of the points at which a draw has ``target_count`` points.

    Raises
    ------
    NotApplicable
        Fewer points are apart than are asked for.
    """

    def sample(excess: float, order_seed: int) -> Indices:
        return _sample(points, _asked(target_count, excess), order_seed)

    draw = search_draw(sample, points, target_count, _USUAL_EXCESS, rng)
    return {"samplenum": _asked(target_count, draw.size), "order_seed": draw.order_seed}


def simplified_point_cloud(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    samplenum: int,
    order_seed: int,
) -> Simplification:
    """Keep what MeshLab keeps.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to the number of distinct points.
    rng : numpy.random.Generator
        Draws ``order_seed``; in a fresh process the same seed gives the same points.
    samplenum : int
        The number that the filter is asked for; `calibrate` finds it.
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
    indices = _sample(points, samplenum, order_seed)
    return Simplification(points[indices], indices)


def _asked(target_count: int, excess: float) -> int:
    return int(min(max(round(target_count / excess), 1), _MOST_ASKED))


def _sample(points: Points, samplenum: int, order_seed: int) -> Indices:
    def thin(meshes: Any) -> None:
        meshes.generate_simplified_point_cloud(samplenum=samplenum)

    return drawn_rows(points, order_seed, thin)
