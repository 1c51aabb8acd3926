"""The program of `lp_graph` in cvxpy, solved by HiGHS tile by tile, and what is proven about the selection.

A tile is some hundred points that lie together. Its program chooses among them while all other points stay as
they are; it counts the neighborhoods that reach into the tile, whole, so that what a tile saves the cloud
saves. A cloud of one tile is solved as a whole, and HiGHS's own bound holds. Of a larger cloud, the tiles whose
part of the gap is largest are solved, one after another, and the bound is that of `LocalDensity.bound`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from lpcompare.checks import check_integer, check_number
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.paper.highs import Canonical
from lpcompare.threads import Progress
from lpcompare.types import Indices, Mask, Points, Vector
from lpcompare.uniform.local_density import LocalDensity

if TYPE_CHECKING:
    import cvxpy as cp

_TILE = 128
_FINE = 1e-6
"""Relative gap at which HiGHS stops in a tile."""


@dataclass(frozen=True)
class LocalCertificate:
    """What is proven about a selection.

    Attributes
    ----------
    cost : float
        The program's objective, recomputed in float64 from the selection; the features' mean is 1.
    bound : float
        No selection of as many points costs less.
    proof : str
        Where the bound comes from: "solver" (HiGHS solved the whole program), "relaxation" (the Lagrangian of
        the whole program), or "counting" (there was nothing to choose).
    n_points, n_keep : int
        Points to choose from, and points chosen.
    hood_size, wanted : int
        K, the points of a neighborhood, and c, those that it should keep.
    largest_miss : int
        The most points that a neighborhood has too many or too few.
    n_empty : int
        Neighborhoods that keep no point.
    tolerance : float
        Gap that counts as optimal.
    """

    cost: float
    bound: float
    proof: str
    n_points: int
    n_keep: int
    hood_size: int
    wanted: int
    largest_miss: int
    n_empty: int
    tolerance: float

    @property
    def gap(self) -> float:
        """Cost above its bound, as a share of the cost."""
        return (self.cost - self.bound) / self.cost if self.cost > 0 else 0.0

    @property
    def proven(self) -> bool:
        """Whether the selection is optimal within the tolerance."""
        return self.gap <= self.tolerance


def solve_tiles(
    program: LocalDensity,
    points: Points,
    mask: Mask,
    multipliers: Vector,
    *,
    n_tiles: int,
    tolerance: float,
    time_limit: float,
    progress: Progress | None = None,
) -> tuple[Mask, LocalCertificate]:
    """Improve a selection tile by tile, and certify it.

    Parameters
    ----------
    program : LocalDensity
    points : ndarray, shape (n, 3)
        The cloud, for the tiles.
    mask : ndarray of bool, shape (n,)
        A selection of ``n_keep`` points.
    multipliers : ndarray, shape (n,)
        Those of the bound.
    n_tiles : int
        Tiles to solve, at most.
    tolerance : float
        Gap that counts as optimal; a selection that is there is not worked on.
    time_limit : float
        Seconds per tile; at the limit the best selection so far is kept.
    progress : callable, optional
        Called with (tiles solved, tiles to solve).

    Returns
    -------
    mask : ndarray of bool, shape (n,)
    certificate : LocalCertificate

    Raises
    ------
    InputError
        A setting is not a number of the right size.
    SolverError
        HiGHS ended without a selection.
    """
    n_tiles, tolerance = check_integer("n_tiles", n_tiles, 0), check_number("gap", tolerance, 0.0)
    time_limit, mask = check_number("time_limit", time_limit, 0.0), mask.copy()
    tiles = np.array_split(Neighbors(points).order.astype(np.intp), -(-len(points) // _TILE))
    bound, proof = program.bound(multipliers), "relaxation"
    if mask.all():
        bound, proof = program.cost(mask), "counting"
    elif len(tiles) == 1:
        bound, proof = max((bound, proof), (_solve_tile(program, mask, tiles[0], time_limit), "solver"))
    elif program.cost(mask) - bound > tolerance * program.cost(mask):
        gaps = program.gaps(mask, multipliers)
        worst = np.argsort([-gaps[tile].sum() for tile in tiles], kind="stable")[:n_tiles]
        for done, tile in enumerate(worst, 1):
            _solve_tile(program, mask, np.sort(tiles[tile]), time_limit)
            if progress:
                progress(done, len(worst))
    return mask, _certify(program, mask, bound, proof, tolerance)


def build_program(program: LocalDensity, tile: Indices, mask: Mask) -> tuple[cp.Problem, list[cp.Variable]]:
    """The program of a tile, its other points as they are; the variables are x, y and e.

    Parameters
    ----------
    program : LocalDensity
    tile : ndarray of int, shape (t,)
        Points to choose among.
    mask : ndarray of bool, shape (n,)
        A selection; as many of the tile's points will be kept as it keeps.
    """
    import cvxpy as cp

    reach, outside = _reach(program, tile, mask)
    x = cp.Variable(len(tile), boolean=True)  # eq. 26
    y, e = cp.Variable(len(outside), nonneg=True), cp.Variable(len(outside), nonneg=True)
    missing = program.wanted - outside  # what the paper's eqs. 20 and 23 make the term of x_{nc+1}
    constraints: list[Any] = [
        cp.sum(x) == int(mask[tile].sum()),  # eq. 22
        reach @ x - missing <= y,  # eq. 24
        missing - reach @ x <= y,  # eq. 25
        y <= 1 + e,
    ]
    lost = program.features[tile] @ (1 - x)
    cost = lost + program.price * cp.sum(y) + program.hole_price * cp.sum(e)
    return cp.Problem(cp.Minimize(cost), constraints), [x, y, e]


def _solve_tile(program: LocalDensity, mask: Mask, tile: Indices, time_limit: float) -> float:
    """Replace the tile's part of a selection by a better one; return HiGHS's bound on the tile's cost."""
    reach, outside = _reach(program, tile, mask)
    problem, variables = build_program(program, tile, mask)
    misses = np.abs(outside + reach @ mask[tile].astype(float) - program.wanted)
    canonical = Canonical(problem)
    outcome = canonical.solve_from(
        np.concatenate([canonical.columns(v) for v in variables]),
        np.concatenate([mask[tile].astype(float), misses, np.maximum(misses - 1, 0.0)]),
        objective_target=-np.inf,
        time_limit=time_limit,
        gap=_FINE,
    )
    n_kept = int(mask[tile].sum())
    found = np.zeros(len(tile), dtype=bool)
    found[np.argsort(-outcome.values[: len(tile)], kind="stable")[:n_kept]] = True

    def cost(chosen: Mask) -> float:
        penalties = program.penalties(outside + reach @ chosen.astype(float))
        return float(program.features[tile] @ ~chosen + penalties.sum())

    mask[tile] = min(mask[tile], found, key=cost)
    # cvxpy's matrix form leaves out the objective's constant, the sum of the features
    return outcome.bound + float(program.features[tile].sum())


def _reach(program: LocalDensity, tile: Indices, mask: Mask) -> tuple[csr_array, Vector]:
    """Of every neighborhood with a point in the tile: its members there, and how many it keeps outside."""
    members = program.members[:, tile]
    hoods = np.flatnonzero(np.diff(members.indptr))
    reach = members[hoods]
    kept = program.members[hoods] @ mask.astype(float)
    return reach, kept - reach @ mask[tile].astype(float)


def _certify(
    program: LocalDensity, mask: Mask, bound: float, proof: str, tolerance: float
) -> LocalCertificate:
    kept, cost = program.members @ mask.astype(float), program.cost(mask)
    n, size = program.hoods.shape
    return LocalCertificate(
        cost,
        min(bound, cost),
        proof,
        n,
        program.n_keep,
        size,
        program.wanted,
        int(np.abs(kept - program.wanted).max()),
        int(np.count_nonzero(kept == 0)),
        tolerance,
    )
