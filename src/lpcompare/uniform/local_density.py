"""The program of `lp_graph`: the paper's, with a density of its own for every neighborhood.

Leal, Leal and Sanchez-Torres (2017) keep the density of a whole cluster (eqs. 14-26), which leaves open where
in it the points lie. Here every point i has a neighborhood N_i, itself and its nearest others, K = c n / n_r
of them, and each should keep c. Points that differ from their neighbors' mean (f_i, the high-pass energy of a
graph) are worth keeping::

    minimize    sum_i f_i (1 - x_i) + p sum_i y_i + q sum_i e_i
    subject to  sum_i x_i = n_r                      eq. 22
                |sum_{j in N_i} x_j - c| <= y_i      eqs. 24, 25 for each neighborhood
                y_i <= 1 + e_i                       a neighborhood without a point costs more
                x_i in {0, 1}, y_i, e_i >= 0         eq. 26

It is the boolean form of the quadratic program of Qi, Hu and Guo (2019), whose first term becomes linear
because x^2 = x, with absolute values in place of squares.

The bound is that of the Lagrangian in which z_i = sum_{j in N_i} x_j is relaxed with a multiplier u_i. For any
|u_i| <= p + q ::

    sum_i f_i - sum_i (c u_i + max(|u_i| - p, 0)) + the n_r least of (sum_{i: j in N_i} u_i - f_j) over j

is no larger than the cost of any selection. The multipliers come from the primal-dual method of Chambolle and
Pock (2011) on the linear relaxation. It needs sparse products only, so that one bound holds for the whole
cloud and not for parts of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lpcompare.checks import check_integer, check_number
from lpcompare.geometry.graphs import high_pass_energy, nearest_others
from lpcompare.geometry.shares import nearest_shares
from lpcompare.types import Mask, Points, Vector

_STEPS = 400
_LOOK_EVERY = 25
_CLOSE = 2e-4
"""Relative gap of the linear relaxation at which its search ends."""
_PRIMAL_STEP = 3.0


@dataclass(frozen=True, eq=False)
class LocalDensity:
    """The numbers of the program.

    Attributes
    ----------
    features : ndarray, shape (n,)
        f_i, not negative.
    hoods : ndarray of int, shape (n, K)
        The points of each N_i, the point itself first.
    n_keep : int
        n_r of eq. 22, from 1 to n.
    wanted : int
        c, the points that each neighborhood should keep.
    price, hole_price : float
        p and q: the price of each point that a neighborhood has too many or too few, and what each such point
        after the first costs beside it.
    """

    features: Vector
    hoods: NDArray[np.intp]
    n_keep: int
    wanted: int
    price: float
    hole_price: float

    @classmethod
    def over(
        cls, points: Points, n_keep: int, *, n_neighbors: int, wanted: int, price: float, hole_price: float
    ) -> LocalDensity:
        """The program of a cloud.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
        n_keep : int
            From 1 to n.
        n_neighbors : int
            Nearest others that define a point's feature.
        wanted, price, hole_price
            As the attributes.

        Raises
        ------
        InputError
            A setting is not a number of the right size.
        """
        n_neighbors, wanted = check_integer("n_neighbors", n_neighbors, 1), check_integer("wanted", wanted, 1)
        price, hole_price = check_number("price", price, 0.0), check_number("hole_price", hole_price, 0.0)
        n = len(points)
        size = max(wanted, round(wanted * n / n_keep))
        _, others = nearest_others(points, size - 1)
        hoods = np.column_stack([np.arange(n), others])
        energy = high_pass_energy(points, n_neighbors)
        return cls(energy, hoods, n_keep, min(wanted, n_keep), price, hole_price)

    @cached_property
    def members(self) -> csr_array:
        """One where point j is in N_i, shape (n, n)."""
        n, size = self.hoods.shape
        return csr_array((np.ones(n * size), self.hoods.ravel(), np.arange(n + 1) * size), shape=(n, n))

    @cached_property
    def owners(self) -> csr_array:
        """The transpose of `members`."""
        return self.members.T.tocsr()

    def penalties(self, kept: Vector) -> Vector:
        """P y + q e of neighborhoods that keep some numbers of points."""
        misses = np.abs(kept - self.wanted)
        return self.price * misses + self.hole_price * np.maximum(misses - 1, 0.0)

    def cost(self, x: Vector | Mask) -> float:
        """The objective of a selection, or of shares, shape (n,)."""
        x = np.asarray(x, dtype=float)
        return float(self.features @ (1 - x) + self.penalties(self.members @ x).sum())

    def bound(self, multipliers: Vector) -> float:
        """What no selection can cost less than, for multipliers of at most p + q, shape (n,)."""
        reduced = self.owners @ multipliers - self.features
        least = np.partition(reduced, self.n_keep - 1)[: self.n_keep].sum()
        saved = self.wanted * multipliers + np.maximum(np.abs(multipliers) - self.price, 0.0)
        return float(self.features.sum() - saved.sum() + least)

    def gaps(self, x: Mask, multipliers: Vector) -> Vector:
        """What each point and its neighborhood add to cost minus bound, shape (n,), not negative."""
        reduced = self.owners @ multipliers - self.features
        threshold = np.partition(reduced, self.n_keep - 1)[self.n_keep - 1]
        misses = self.members @ x.astype(float) - self.wanted
        slack = np.maximum(np.abs(multipliers) - self.price, 0.0) - multipliers * misses
        chosen = np.where(x, reduced - threshold, 0.0) + np.maximum(threshold - reduced, 0.0)
        return self.penalties(misses + self.wanted) + slack + chosen


def relax(program: LocalDensity) -> tuple[Vector, Vector]:
    """Solve the linear relaxation nearly.

    Parameters
    ----------
    program : LocalDensity

    Returns
    -------
    shares : ndarray, shape (n,)
        x_i from 0 to 1.
    multipliers : ndarray, shape (n,)
        Those of the best `LocalDensity.bound` that was met.
    """
    members, owners, n = program.members, program.owners, len(program.features)
    # the norm of the matrix is at most the root of the largest row sum times the largest column sum
    norm = np.sqrt(program.hoods.shape[1] * members.sum(axis=0).max())
    primal_step, dual_step = _PRIMAL_STEP / norm, 1 / (_PRIMAL_STEP * norm)
    shares, multipliers = np.full(n, program.n_keep / n), np.zeros(n)
    best, best_bound = multipliers, program.bound(multipliers)
    for step in range(1, _STEPS + 1):
        slope = owners @ multipliers - program.features
        before, shares = shares, nearest_shares(shares - primal_step * slope, program.n_keep)
        ahead = members @ (2 * shares - before) - program.wanted
        multipliers = _shrunk(program, multipliers + dual_step * ahead, dual_step)
        if step % _LOOK_EVERY == 0:
            bound = program.bound(multipliers)
            if bound > best_bound:
                best, best_bound = multipliers, bound
            if program.cost(shares) - best_bound <= _CLOSE * abs(best_bound):
                break
    return shares, best


def _shrunk(program: LocalDensity, values: Vector, step: float) -> Vector:
    """The proximal map of step * max(|u| - p, 0) on |u| <= p + q."""
    sizes = np.abs(values)
    shrunk = np.maximum(np.minimum(sizes, program.price), sizes - step)
    return np.sign(values) * np.minimum(shrunk, program.price + program.hole_price)
