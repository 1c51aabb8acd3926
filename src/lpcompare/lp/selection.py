"""Stage 3: the boolean programme of one cluster, eqs. 14-26 of Leal et al. (2017), solved and certified.

The costs are divided by their mean, so objective, bound and residual are in units of the cluster's mean cost.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from threading import Event
from typing import Any

import cvxpy as cp
import numpy as np

from lpcompare.errors import SolverError
from lpcompare.lp.certificate import TOLERANCE, Certificate, DensityGoal, certify
from lpcompare.lp.enumeration import nearest_sum
from lpcompare.lp.highs import solve_from
from lpcompare.lp.start import exchange, rearrange, starting_mask
from lpcompare.types import Mask, Vector

_TURNS = 12
_LIMITS = {
    "HIGHS": lambda s: {"time_limit": s.time_limit, "mip_rel_gap": s.gap},
    "SCIPY": lambda s: {"scipy_options": {"time_limit": s.time_limit, "mip_rel_gap": s.gap}},
    "SCIP": lambda s: {"scip_params": {"limits/time": s.time_limit, "limits/gap": s.gap}},
    "CBC": lambda s: {"maximumSeconds": s.time_limit, "allowablePercentageGap": 100 * s.gap},
    "GLPK_MI": lambda s: {"tm_lim": int(1000 * s.time_limit)},
    "GUROBI": lambda s: {"TimeLimit": s.time_limit, "MIPGap": s.gap},
}


@dataclass(frozen=True)
class SolverSettings:
    """Which solver, and when it may stop.

    Attributes
    ----------
    solver : str
        "highs" starts HiGHS from a solution, "highs-cold" leaves it to cvxpy, and any mixed-integer solver
        that cvxpy has can be named.
    time_limit : float
        Seconds per cluster.
    gap : float
        Relative gap that the solver may leave.
    """

    solver: str = "highs"
    time_limit: float = 10.0
    gap: float = 0.0


def select(
    costs: Vector,
    n_keep: int,
    goal: DensityGoal,
    *,
    rng: np.random.Generator,
    settings: SolverSettings | None = None,
    cancelled: Event | None = None,
) -> tuple[Mask, Certificate]:
    """Choose ``n_keep`` points with |k D_cr - D_c| as small as possible (eqs. 14-26).

    Parameters
    ----------
    costs : ndarray, shape (nc,)
        C_i of eq. 13, normalised to mean one.
    n_keep : int
        nr of eq. 22, from 0 to nc.
    goal : DensityGoal
        D_c of eq. 12 and k of eq. 14.
    rng : numpy.random.Generator
        Draws the starting solution.
    settings : SolverSettings, optional
    cancelled : threading.Event, optional
        Ends the search soon after it is set.

    Returns
    -------
    mask : ndarray of bool, shape (nc,)
    certificate : Certificate

    Raises
    ------
    SolverError
        The solver ended without a selection.
    """
    settings = settings or SolverSettings()
    if n_keep in (0, len(costs)):
        mask = np.full(len(costs), n_keep > 0)
        return mask, certify(costs, mask, goal)
    if settings.solver == "highs":
        start = starting_mask(costs, n_keep, goal.wanted, rng)
        return _select_from(start, costs, goal, settings, cancelled)
    return _select_cold(costs, n_keep, goal, settings)


def build_programme(costs: Vector, n_keep: int, goal: DensityGoal) -> tuple[cp.Problem, cp.Variable]:
    """Eqs. 21-26: the boolean programme of one cluster, and its x of length nc + 1."""
    n_points = len(costs)
    x = cp.Variable(n_points + 1, boolean=True)  # eq. 26
    y = cp.Variable(nonneg=True)  # eq. 19
    row = np.append(goal.k * costs / n_keep, -goal.density)  # eq. 20
    constraints: list[Any] = [
        cp.sum(x[:n_points]) == n_keep,  # eq. 22
        x[n_points] == 1,  # eq. 23
        row @ x <= y,  # eq. 24
        -row @ x <= y,  # eq. 25
    ]
    return cp.Problem(cp.Minimize(y), constraints), x  # eq. 21


def _select_from(
    start: Mask, costs: Vector, goal: DensityGoal, settings: SolverSettings, cancelled: Event | None
) -> tuple[Mask, Certificate]:
    """Give HiGHS the starting solution; what it returns is improved by exchanges and certified."""
    start, first = _certified_start(start, costs, goal)
    reach = goal.within_reach(costs)
    objective = reach.objective(costs[start])
    problem, x = build_programme(costs, first.n_keep, reach)
    (y,) = (v for v in problem.variables() if v is not x)
    outcome = solve_from(
        problem,
        {x: np.append(start, True), y: np.array(objective)},
        objective_target=(objective if first.proven else first.bound) + TOLERANCE * reach.density,
        time_limit=settings.time_limit,
        gap=settings.gap,
        cancelled=cancelled,
    )
    found = exchange(costs, _rounded(x, first.n_keep), goal.wanted)
    best = min((start, found), key=lambda mask: goal.objective(costs[mask]))
    bounds = {first.proof: first.bound} if first.proven else {"solver": outcome.bound}
    return best, certify(costs, best, goal, outcome.status, bounds)


def _certified_start(start: Mask, costs: Vector, goal: DensityGoal) -> tuple[Mask, Certificate]:
    """The start, improved where no bound proves it: a few points anew, then all if affordable."""
    first = certify(costs, start, goal, "open")
    for turn in range(_TURNS):
        if first.proven:
            return start, first
        start = min(
            (start, rearrange(costs, start, goal.wanted, turn)), key=lambda m: goal.objective(costs[m])
        )
        first = certify(costs, start, goal, "open")
    counted = nearest_sum(costs, first.n_keep, goal.wanted)
    if counted is None:
        return start, first
    return counted, certify(costs, counted, goal, bounds={"counting": goal.objective(costs[counted])})


def _select_cold(
    costs: Vector, n_keep: int, goal: DensityGoal, settings: SolverSettings
) -> tuple[Mask, Certificate]:
    """Leave the programme to cvxpy and the solver."""
    name = cp.HIGHS if settings.solver == "highs-cold" else settings.solver
    limits: dict[str, Any] = _LIMITS[name](settings) if name in _LIMITS else {}
    problem, x = build_programme(costs, n_keep, goal.within_reach(costs))
    try:
        with warnings.catch_warnings():
            # cvxpy warns of a limit or an inaccurate solution; the certificate says both
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=name, **limits)
    except cp.SolverError as error:
        raise _no_selection(name, n_keep, len(costs)) from error
    if x.value is None:
        raise _no_selection(name, n_keep, len(costs))
    status = {"optimal": "optimal", "user_limit": "time limit"}.get(str(problem.status), "inaccurate")
    mask = _rounded(x, n_keep)
    # a solver that was not told the gap has one of its own: its word proves nothing
    known = status == "optimal" and name in _LIMITS
    bounds = {"solver": (1.0 - settings.gap) * goal.objective(costs[mask])} if known else None
    return mask, certify(costs, mask, goal, status, bounds)


def _no_selection(name: str, n_keep: int, n_points: int) -> SolverError:
    return SolverError(
        f"Solver {name} found no selection of {n_keep} of {n_points} points; raise time_limit "
        "or try solver='highs'."
    )


def _rounded(x: cp.Variable, n_keep: int) -> Mask:
    """The solver's x as a choice of exactly ``n_keep`` points: solvers return 0 and 1 only nearly."""
    values = np.asarray(x.value)[:-1]
    mask = np.zeros(len(values), dtype=bool)
    mask[np.argsort(-values, kind="stable")[:n_keep]] = True
    return mask
