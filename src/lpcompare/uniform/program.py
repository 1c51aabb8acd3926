"""Stage 3 of `lp_uniform`: one point per cell, the cluster's density kept, the surface represented best.

To the boolean program of Leal et al. (2017), eqs. 14-26, come a second objective and one row per cell, as
the paper's future work asks ("multiple objectives to avoid hole generation", "uniformly distributed")::

    minimise    sum_i c_i x_i + W e
    subject to  sum_i x_i = n_r                      eq. 22
                x_{nc+1} = 1                         eq. 23
                |sum_i C_i x_i / n_r - D_c| <= y     eqs. 24, 25 with k = 1
                y <= tolerance D_c + e               the density is kept, or missed by as little as can be
                sum_{i in cell s} x_i = 1            for every cell s: no holes, no clumps
                x_i in {0, 1}, y, e >= 0             eq. 26

The rows of the cells and the density row make it nearly totally unimodular: relaxing the density row alone
leaves a choice per cell that sorting solves, and the best multiplier of that row gives at once a starting
solution and a lower bound that leaves a gap of one cell in n_r. HiGHS closes it or proves it small enough.

Compared, on fandisk at 70 % and 90 % (eq. 27, k = 8, over that of Poisson disk sampling at equal counts):

- coverage rows, a kept point within a curvature-dependent radius of every original, in place of the cells:
  .64 at 90 %, 124 s, 8 of 20 clusters at their time limit of 10 s (cells and this program: .57 in .2 s);
- cells alone, the cheapest candidate of each, no density row: .51 and .57; with this program .51 and .57:
  the tilted cells have paid for the density already;
- cells made again with weights multiplied by the root of the error mass of the current selection, which lets
  the error decide how many points a region gets: .47 and .51 once, .48 and .47 three times, but Hausdorff
  then 2.9 and 1.9 times Poisson disk's and the surface lost at 70 % (1.29);
- cells, guarded exchange, then this program: .46 and .53 with Hausdorff below 1.5 and surface .57 and .58:
  the default. Without the density rows .43 and .47: that is what it costs to keep the density;
- the candidate nearest to the centre of its cell, in place of the least quadric, over five models: .77
  against .71 before the exchange.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from threading import Event
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from lpcompare.paper.highs import Canonical
from lpcompare.types import Indices, Mask, Vector
from lpcompare.uniform.quadrics import cheapest_of_each

if TYPE_CHECKING:
    import cvxpy as cp

_EXCESS_PRICE = 100.0
_MULTIPLIER_STEPS = 60
_CHANGES = 100


@dataclass(frozen=True)
class Stop:
    """When HiGHS may stop.

    Attributes
    ----------
    gap : float
        Relative gap between solution and bound that counts as optimal.
    time_limit : float
        Seconds per cluster; at the limit the best solution so far is kept.
    """

    gap: float = 5e-3
    time_limit: float = 10.0


@dataclass(frozen=True)
class SpreadCertificate:
    """What is proven about one cluster's selection.

    Attributes
    ----------
    status : str
        "optimal" (within the gap), "time limit" or "interrupted".
    objective : float
        Z of eq. 14, recomputed in float64 from the selection.
    density, reduced_density : float
        D_c of eq. 12 and D_cr of eq. 15.
    cost, bound : float
        The program's objective, in units of the cheapest choice without the density row, and a proven
        lower bound on it.
    n_candidates, n_keep : int
        Points to choose from (nc) and points chosen (nr).
    tolerance : float
        Gap that counts as optimal, relative to ``cost``.
    """

    status: str
    objective: float
    density: float
    reduced_density: float
    cost: float
    bound: float
    n_candidates: int
    n_keep: int
    tolerance: float

    @property
    def residual(self) -> float:
        """Z as a share of the cluster's density."""
        return self.objective / self.density if self.density else 0.0

    @property
    def gap(self) -> float:
        """Cost above its bound, as a share of the cost."""
        return (self.cost - self.bound) / self.cost if self.cost > 0 else 0.0

    @property
    def proven(self) -> bool:
        """Whether the selection is optimal within the tolerance."""
        return self.gap <= self.tolerance

    def in_units(self, mean_cost: float) -> SpreadCertificate:
        """Densities and Z multiplied by the mean cost that had been divided out."""
        return replace(
            self,
            objective=self.objective * mean_cost,
            density=self.density * mean_cost,
            reduced_density=self.reduced_density * mean_cost,
        )


def select_one_per_cell(
    costs: Vector,
    cells: Indices,
    inverse_distances: Vector,
    *,
    tolerance: float,
    stop: Stop,
    cancelled: Event | None = None,
) -> tuple[Mask, SpreadCertificate]:
    """Choose one candidate of every cell of one cluster.

    Parameters
    ----------
    costs : ndarray, shape (nc,)
        How badly each candidate represents its cell, not negative.
    cells : ndarray of int, shape (nc,)
        Cell of each candidate, from 0 to nr - 1, each with a candidate.
    inverse_distances : ndarray, shape (nc,)
        C_i of eq. 13 divided by D_c.
    tolerance : float
        Largest Z of eq. 14 that costs nothing, as a share of D_c.
    stop : Stop
    cancelled : threading.Event, optional
        Ends the search soon after it is set.

    Returns
    -------
    mask : ndarray of bool, shape (nc,)
        One candidate of every cell.
    certificate : SpreadCertificate

    Raises
    ------
    SolverError
        The solver ended without a selection.
    """
    n_keep = int(cells.max()) + 1
    cheapest = float(costs[cheapest_of_each(costs, cells, n_keep)].sum())
    model = _Model(costs / (cheapest or 1.0), cells, n_keep, inverse_distances / n_keep, tolerance)
    chosen, bound = _relaxed_choice(model)
    status = "optimal"
    if model.objective(chosen) > bound * (1 + stop.gap):
        chosen, status, solver_bound = _solve(model, chosen, bound, stop, cancelled)
        bound = max(bound, solver_bound)
    mask = np.zeros(len(costs), dtype=bool)
    mask[chosen] = True
    reduced, cost = float(model.rows[chosen].sum()), model.objective(chosen)
    return mask, SpreadCertificate(
        status, abs(reduced - 1.0), 1.0, reduced, cost, min(bound, cost), len(costs), n_keep, stop.gap
    )


@dataclass(frozen=True, eq=False)
class _Model:
    """The numbers of one cluster's program, with D_c = 1: costs c_i, rows C_i / n_r."""

    costs: Vector
    cells: Indices
    n_keep: int
    rows: Vector
    tolerance: float

    def cheapest(self, costs: Vector) -> Indices:
        """The candidate of least cost in each cell."""
        return cheapest_of_each(costs, self.cells, self.n_keep)

    def deviation(self, chosen: Indices) -> float:
        """D_cr - D_c: Z of eq. 14 with its sign."""
        return float(self.rows[chosen].sum()) - 1.0

    def excess(self, chosen: Indices) -> float:
        """What Z of eq. 14 exceeds the tolerance by."""
        return max(abs(self.deviation(chosen)) - self.tolerance, 0.0)

    def objective(self, chosen: Indices) -> float:
        return float(self.costs[chosen].sum()) + _EXCESS_PRICE * self.excess(chosen)


def build_program(model: _Model) -> cp.Problem:
    """The boolean program of one cluster; its variables are ``x`` (nc + 1), ``y`` and ``e``."""
    import cvxpy as cp

    n_points, n_keep = len(model.costs), model.n_keep
    x = cp.Variable(n_points + 1, boolean=True, name="x")  # eq. 26
    y, e = cp.Variable(name="y", nonneg=True), cp.Variable(name="e", nonneg=True)
    row = np.append(model.rows, -1.0)  # eq. 20, divided by D_c
    membership = csr_array(
        (np.ones(n_points), (model.cells, np.arange(n_points))), shape=(n_keep, n_points + 1)
    )
    constraints: list[Any] = [
        cp.sum(x[:n_points]) == n_keep,  # eq. 22
        x[n_points] == 1,  # eq. 23
        row @ x <= y,  # eq. 24
        -row @ x <= y,  # eq. 25
        y <= model.tolerance + e,
        membership @ x == 1,
    ]
    return cp.Problem(cp.Minimize(np.append(model.costs, 0.0) @ x + _EXCESS_PRICE * e), constraints)


def _solve(
    model: _Model, start: Indices, bound: float, stop: Stop, cancelled: Event | None
) -> tuple[Indices, str, float]:
    problem = build_program(model)
    canonical = Canonical(problem)
    by_name = {v.name(): canonical.columns(v) for v in problem.variables()}
    values = np.zeros(len(model.costs) + 3)
    values[start] = 1.0
    values[-3:] = 1.0, abs(model.deviation(start)), model.excess(start)
    outcome = canonical.solve_from(
        np.concatenate([by_name[name] for name in "xye"]),
        values,
        objective_target=bound * (1 + stop.gap),
        time_limit=stop.time_limit,
        gap=stop.gap,
        cancelled=cancelled,
    )
    found = model.cheapest(-outcome.values[:-3])
    return min(start, found, key=model.objective), outcome.status, outcome.bound


def _relaxed_choice(model: _Model) -> tuple[Indices, float]:
    """A choice from the Lagrangian of the density row, and the best bound that its multipliers give."""
    chosen = model.cheapest(model.costs)
    bound = float(model.costs[chosen].sum())
    side = np.sign(model.deviation(chosen))
    if model.excess(chosen) == 0:
        return chosen, bound
    outside = inside = chosen
    low, high = 0.0, _EXCESS_PRICE
    for _ in range(_MULTIPLIER_STEPS):
        multiplier = (low + high) / 2
        priced = model.costs + multiplier * side * model.rows
        chosen = model.cheapest(priced)
        bound = max(bound, float(priced[chosen].sum()) - multiplier * (side + model.tolerance))
        if side * model.deviation(chosen) > model.tolerance:
            low, outside = multiplier, chosen
        else:
            high, inside = multiplier, chosen
        if high - low <= 1e-9 * high:
            break
    return min(_improved(model, outside), _improved(model, inside), key=model.objective), bound


def _improved(model: _Model, chosen: Indices) -> Indices:
    """Change the choice in one cell, the best change each time, while the objective falls."""
    chosen = chosen.copy()
    for _ in range(_CHANGES):
        present = chosen[model.cells]
        costs = model.costs - model.costs[present]
        deviations = model.deviation(chosen) + model.rows - model.rows[present]
        excess = np.maximum(np.abs(deviations) - model.tolerance, 0.0)
        change = costs + _EXCESS_PRICE * (excess - model.excess(chosen))
        best = int(np.argmin(change))
        if change[best] >= -1e-12:
            break
        chosen[model.cells[best]] = best
    return chosen
