"""Stage 3: the boolean programme of one cluster, eqs. 14-26 of Leal et al. (2017), and its certificate.

The costs are divided by their mean, so objective, bound and residual are in units of the cluster's mean cost.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from threading import Event

import cvxpy as cp
import numpy as np

from lpcompare.errors import SolverError
from lpcompare.lp.highs import solve_from
from lpcompare.lp.start import exchange, starting_mask
from lpcompare.types import Mask, Vector

TOLERANCE = 1e-6
"""A selection within this share of the cluster's density of a proven bound counts as optimal."""

_LIMITS = {
    "HIGHS": lambda seconds, gap: {"time_limit": seconds, "mip_rel_gap": gap},
    "SCIPY": lambda seconds, gap: {"scipy_options": {"time_limit": seconds, "mip_rel_gap": gap}},
    "SCIP": lambda seconds, gap: {"scip_params": {"limits/time": seconds, "limits/gap": gap}},
    "CBC": lambda seconds, gap: {"maximumSeconds": seconds, "allowablePercentageGap": 100 * gap},
    "GLPK_MI": lambda seconds, gap: {"tm_lim": int(1000 * seconds)},
    "GUROBI": lambda seconds, gap: {"TimeLimit": seconds, "MIPGap": gap},
}


@dataclass(frozen=True)
class Certificate:
    """What is proven about one cluster's selection.

    Attributes
    ----------
    status : str
        "optimal" (within the tolerance), "time limit", "interrupted" or "inaccurate".
    proof : str
        Where the bound comes from: "zero" (an absolute value is never negative), "sorting" (the k nearest or
        farthest points have the extreme mean cost), "solver", or "counting" (nothing was to be chosen).
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


def select(
    costs: Vector,
    n_keep: int,
    *,
    density: float,
    k: float,
    rng: np.random.Generator,
    solver: str = "highs",
    time_limit: float = 10.0,
    gap: float = 0.0,
    cancelled: Event | None = None,
) -> tuple[Mask, Certificate]:
    """Choose ``n_keep`` points with |k D_cr - D_c| as small as possible (eqs. 14-26).

    Parameters
    ----------
    costs : ndarray, shape (nc,)
        C_i of eq. 13, normalised to mean one.
    n_keep : int
        nr of eq. 22, from 0 to nc.
    density : float
        D_c of eq. 12, in the same unit.
    k : float
        Proportionality constant of eq. 14.
    rng : numpy.random.Generator
        Draws the starting solution.
    solver : str
        "highs" starts HiGHS from a solution, "highs-cold" leaves it to cvxpy, and any mixed-integer solver
        that cvxpy has can be named.
    time_limit : float
        Seconds.
    gap : float
        Relative gap that the solver may leave.
    cancelled : threading.Event, optional
        Ends the search soon after it is set.

    Returns
    -------
    mask : ndarray of bool, shape (nc,)
    certificate : Certificate

    Raises
    ------
    SolverError
        The solver ended without a selection of the right size.
    """
    if n_keep in (0, len(costs)):
        mask = np.full(len(costs), n_keep > 0)
        return mask, _certify(costs, mask, density, k, "optimal")
    if solver == "highs":
        return _select_from_start(costs, n_keep, density, k, rng, time_limit, gap, cancelled)
    return _select_cold(costs, n_keep, density, k, solver, time_limit, gap)


def build_programme(costs: Vector, n_keep: int, density: float, k: float) -> cp.Problem:
    """Eqs. 21-26: the boolean programme of one cluster.

    Its variables are ``x``, of length nc + 1, and ``y``; the other arguments are those of `select`.
    """
    n_points = len(costs)
    x = cp.Variable(n_points + 1, boolean=True, name="x")  # eq. 26
    y = cp.Variable(name="y", nonneg=True)  # eq. 19
    row = np.append(k * costs / n_keep, -density)  # eq. 20
    return cp.Problem(
        cp.Minimize(y),  # eq. 21
        [
            cp.sum(x[:n_points]) == n_keep,  # eq. 22
            x[n_points] == 1,  # eq. 23
            row @ x <= y,  # eq. 24
            -row @ x <= y,  # eq. 25
        ],
    )


def _select_from_start(
    costs: Vector,
    n_keep: int,
    density: float,
    k: float,
    rng: np.random.Generator,
    time_limit: float,
    gap: float,
    cancelled: Event | None,
) -> tuple[Mask, Certificate]:
    start = starting_mask(costs, n_keep, density / k, rng)
    first = _certify(costs, start, density, k, "optimal")
    problem = build_programme(costs, n_keep, density, k)
    x, y = (next(v for v in problem.variables() if v.name() == name) for name in "xy")
    outcome = solve_from(
        problem,
        {x: np.append(start, True).astype(float), y: np.array(first.objective)},
        objective_target=first.bound + TOLERANCE * density,
        time_limit=time_limit,
        gap=gap,
        cancelled=cancelled,
    )
    mask = exchange(costs, _rounded(x, n_keep), density / k)
    best = min((start, mask), key=lambda m: _objective(costs, m, density, k))
    return best, _certify(costs, best, density, k, outcome.status, outcome.bound)


def _select_cold(
    costs: Vector, n_keep: int, density: float, k: float, solver: str, time_limit: float, gap: float
) -> tuple[Mask, Certificate]:
    name = cp.HIGHS if solver == "highs-cold" else solver.upper()
    problem = build_programme(costs, n_keep, density, k)
    x = next(v for v in problem.variables() if v.name() == "x")
    limits = _LIMITS.get(name, lambda seconds, gap: {})(time_limit, gap)
    try:
        with warnings.catch_warnings():
            # cvxpy warns of a limit or an inaccurate solution; the certificate says both
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=name, **limits)
    except cp.SolverError as error:
        raise SolverError(f"Solver {solver!r} failed on a cluster of {len(costs)} points: {error}") from error
    if x.value is None:
        raise SolverError(
            f"Solver {solver!r} ended with {problem.status!r} and no selection; raise time_limit."
        )
    status = {"optimal": "optimal", "user_limit": "time limit"}.get(problem.status, "inaccurate")
    mask = _rounded(x, n_keep)
    bound = _objective(costs, mask, density, k) if status == "optimal" else 0.0
    return mask, _certify(costs, mask, density, k, status, bound)


def _rounded(x: cp.Variable, n_keep: int) -> Mask:
    """The solver's x as a choice of exactly ``n_keep`` points: solvers return 0 and 1 only nearly."""
    values = np.asarray(x.value)[:-1]
    mask = np.zeros(len(values), dtype=bool)
    mask[np.argsort(-values, kind="stable")[:n_keep]] = True
    return mask


def _objective(costs: Vector, mask: Mask, density: float, k: float) -> float:
    """Z of eq. 14."""
    return abs(k * float(costs[mask].mean()) - density) if mask.any() else density


def _certify(
    costs: Vector, mask: Mask, density: float, k: float, status: str, solver_bound: float = 0.0
) -> Certificate:
    """Recompute Z in float64 and name the bound that proves most."""
    objective, n_keep = _objective(costs, mask, density, k), int(mask.sum())
    bounds = {"zero": 0.0, "sorting": _sorting_bound(costs, n_keep, density, k), "solver": solver_bound}
    if n_keep in (0, len(costs)):
        bounds = {"counting": objective}
    proof = max(bounds, key=lambda name: min(bounds[name], objective) - (1e-12 if name == "solver" else 0.0))
    bound = min(bounds[proof], objective)
    if objective - bound <= TOLERANCE * density:
        status = "optimal"
    reduced = float(costs[mask].mean()) if n_keep else 0.0
    return Certificate(status, proof, objective, bound, density, reduced, len(costs), n_keep)


def _sorting_bound(costs: Vector, n_keep: int, density: float, k: float) -> float:
    """Z of the extreme choices: no mean of ``n_keep`` costs lies outside theirs."""
    ordered = np.sort(costs)
    if not n_keep > 0:
        return 0.0
    lowest, highest = float(ordered[:n_keep].mean()), float(ordered[-n_keep:].mean())
    return max(k * lowest - density, density - k * highest, 0.0)
