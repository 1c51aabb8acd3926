"""What is proven about a selection: eq. 14 recomputed in float64, and a bound that no selection can beat."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from lpcompare.types import Mask, Vector

TOLERANCE = 1e-6
"""A selection within this share of the cluster's density of a proven bound counts as optimal."""


@dataclass(frozen=True)
class DensityGoal:
    """What eq. 14 asks of a cluster: k D_cr near D_c.

    Attributes
    ----------
    density : float
        D_c of eq. 12.
    k : float
        Proportionality constant of eq. 14.
    """

    density: float
    k: float = 1.0

    @property
    def wanted(self) -> float:
        """The reduced density at which eq. 14 is zero."""
        return self.density / self.k

    def objective(self, costs: Vector) -> float:
        """Z of eq. 14 for the costs of the chosen points, shape (nr,)."""
        return abs(self.k * _mean(costs) - self.density)

    def within_reach(self, costs: Vector) -> DensityGoal:
        """The goal with its density cut to twice what the dearest of the costs gives.

        Beyond that, every density asks for the dearest points; a solver cannot hold a very large one.
        """
        return replace(self, density=min(self.density, 2 * self.k * float(costs.max())))


@dataclass(frozen=True)
class Certificate:
    """What is proven about one cluster's selection.

    Attributes
    ----------
    status : str
        "optimal" (proven within the tolerance), or how the solver ended: "gap" (content with the gap that it
        was allowed), "time limit", "interrupted" or "inaccurate".
    proof : str
        Where the bound comes from: "zero" (an absolute value is never negative), "sorting" (no mean of nr
        costs lies outside those of the nearest and the farthest points), "counting" (every sum of nr costs
        was listed, or there was nothing to choose), or "solver" (the solver's own bound).
    objective : float
        Z of eq. 14, recomputed in float64 from the selection.
    bound : float
        No selection of this size has a smaller Z.
    density, reduced_density : float
        D_c of eq. 12 and D_cr of eq. 15.
    n_candidates, n_keep : int
        Points to choose from (nc) and points chosen (nr).
    """

    status: str
    proof: str
    objective: float
    bound: float
    density: float
    reduced_density: float
    n_candidates: int
    n_keep: int

    @property
    def residual(self) -> float:
        """Z as a share of the cluster's density."""
        return self.objective / self.density if self.density else 0.0

    @property
    def gap(self) -> float:
        """Z above its bound, as a share of the cluster's density."""
        return (self.objective - self.bound) / self.density if self.density else 0.0

    @property
    def proven(self) -> bool:
        """Whether the selection is optimal within the tolerance."""
        return self.gap <= TOLERANCE

    def in_units(self, mean_cost: float) -> Certificate:
        """The same certificate with costs and densities multiplied by ``mean_cost``."""
        fields = ("objective", "bound", "density", "reduced_density")
        return replace(self, **{name: getattr(self, name) * mean_cost for name in fields})


def certify(
    costs: Vector,
    mask: Mask,
    goal: DensityGoal,
    status: str = "optimal",
    bounds: Mapping[str, float] | None = None,
) -> Certificate:
    """Recompute Z and name the first bound that proves it, or else the highest.

    Parameters
    ----------
    costs : ndarray, shape (nc,)
    mask : ndarray of bool, shape (nc,)
        The selection.
    goal : DensityGoal
    status : str
        How the solver says it ended; "optimal" stands only where a bound within the tolerance proves it.
    bounds : mapping of str to float, optional
        Further lower bounds on Z, by the name of their proof.

    Returns
    -------
    Certificate
    """
    n_keep = int(mask.sum())
    objective = goal.objective(costs[mask])
    known = {"zero": 0.0, "sorting": _sorting_bound(costs, n_keep, goal), **(bounds or {})}
    if n_keep in (0, len(costs)):
        known = {"counting": objective}
    enough = [name for name, bound in known.items() if objective - bound <= TOLERANCE * goal.density]
    proof = enough[0] if enough else max(known, key=lambda name: known[name])
    unproven = "gap" if status == "optimal" else status
    return Certificate(
        "optimal" if enough else unproven,
        proof,
        objective,
        min(known[proof], objective),
        goal.density,
        _mean(costs[mask]),
        len(costs),
        n_keep,
    )


def _sorting_bound(costs: Vector, n_keep: int, goal: DensityGoal) -> float:
    """Z of the extreme choices: no mean of ``n_keep`` costs lies outside theirs."""
    ordered = np.sort(costs)
    lowest, highest = _mean(ordered[:n_keep]), _mean(ordered[len(ordered) - n_keep :])
    return max(goal.k * lowest - goal.density, goal.density - goal.k * highest, 0.0)


def _mean(costs: Vector) -> float:
    return float(costs.mean()) if len(costs) else 0.0
