"""Boolean program with a density constraint for every neighborhood: features stay, and no region is emptied.

The program of Leal, Leal and Sanchez-Torres (2017), eqs. 21-26, with local density constraints in place of one
per cluster, as their future work asks ("uniformly distributed"); with features as in Qi, Hu and Guo (2019) it
is the boolean form of their quadratic program (`qi_graph`).

1. A point's feature f_i is its squared offset from its neighbors' weighted mean, of mean 1.
2. Each point has a neighborhood of 2 n / n_r points, which should keep 2 of them.
3. The linear relaxation for the whole cloud gives shares and a lower bound; the largest shares are kept.
4. Swaps with a falling temperature improve the selection.
5. HiGHS solves the cvxpy program of the tiles where the gap is largest, from that selection. A cloud of up to
   128 points is solved as a whole.

``info["certificates"]`` holds one `LocalCertificate` for the whole cloud: the cost, a bound that holds for every
selection of as many points, and their gap, which is a per cent or two and not zero.
"""

from __future__ import annotations

import numpy as np

from lpcompare.progress import Callback, StageClock
from lpcompare.types import Points, Simplification, Traits
from lpcompare.uniform.annealing import anneal
from lpcompare.uniform.local_density import LocalDensity, relax
from lpcompare.uniform.local_program import solve_tiles

TRAITS = Traits(
    family="ours",
    wraps="lpcompare (cvxpy, HiGHS)",
    source="Leal and others, A Linear Programming Approach for 3D Point Cloud Simplification, 2017",
)


def lp_graph(
    points: Points,
    target_count: int,
    *,
    rng: np.random.Generator,
    n_neighbors: int = 15,
    wanted: int = 2,
    price: float = 0.05,
    hole_price: float = 1.0,
    n_trials: int = 40,
    n_tiles: int = 12,
    gap: float = 5e-3,
    time_limit: float = 10.0,
    callback: Callback | None = None,
) -> Simplification:
    """Keep ``target_count`` of the points.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    target_count : int
        From 1 to n.
    rng : numpy.random.Generator
        Draws the swaps.
    n_neighbors : int, optional
        Nearest others whose mean defines a point's feature.
    wanted : int, optional
        c, the points that each neighborhood should keep; its size follows.
    price : float, optional
        p, the price of a point too many or too few in a neighborhood, in mean features.
    hole_price : float, optional
        q, what each such point after the first costs beside it.
    n_trials : int, optional
        Swaps that are tried with a temperature, per point of the cloud.
    n_tiles : int, optional
        Tiles that HiGHS solves.
    gap : float, optional
        Relative gap that counts as optimal.
    time_limit : float, optional
        Seconds per tile; at the limit the best selection so far is kept.
    callback : callable, optional
        Called with (stage, done, total).

    Returns
    -------
    Simplification
        A subset of the input; ``info`` has the certificate, its gap, and whether it is within ``gap``.
    """
    clock = StageClock(callback)
    clock.stage("graph")
    program = LocalDensity.over(
        points, target_count, n_neighbors=n_neighbors, wanted=wanted, price=price, hole_price=hole_price
    )
    clock.stage("relaxation")
    shares, multipliers = relax(program)
    mask = np.zeros(len(points), dtype=bool)
    mask[np.argsort(-shares, kind="stable")[:target_count]] = True
    clock.stage("swaps")
    mask = anneal(program, mask, n_trials, rng)
    progress = clock.stage("selection")
    mask, certificate = solve_tiles(
        program,
        points,
        mask,
        multipliers,
        n_tiles=n_tiles,
        tolerance=gap,
        time_limit=time_limit,
        progress=progress,
    )
    indices = np.flatnonzero(mask)
    info = {"certificates": (certificate,), "gap": certificate.gap, "n_certified": int(certificate.proven)}
    return Simplification(points[indices], indices, clock.stop(), info)
