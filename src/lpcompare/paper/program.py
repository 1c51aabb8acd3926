"""Stage 3: the boolean program of every cluster, eqs. 14-26 of Leal et al. (2017), solved and certified.

The costs are divided by their mean, so objective, bound and residual are in units of the cluster's mean cost.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from threading import Event
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from lpcompare.errors import SolverError
from lpcompare.paper.certificate import TOLERANCE, Certificate, DensityGoal, certify
from lpcompare.paper.enumeration import nearest_sum
from lpcompare.paper.highs import Canonical
from lpcompare.paper.start import exchange, rearrange, starting_mask
from lpcompare.threads import Progress, map_in_threads
from lpcompare.types import Indices, Mask, Vector

if TYPE_CHECKING:
    import cvxpy as cp

_TURNS = 12
_TOGETHER = 64
"""Clusters in one problem: cvxpy numbers the places of the matrix, rows times columns."""

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


@dataclass(frozen=True, eq=False)
class Program:
    """What the boolean program of one cluster is made from.

    Attributes
    ----------
    costs : ndarray, shape (nc,)
        C_i of eq. 13, normalised to mean one.
    n_keep : int
        nr of eq. 22, from 0 to nc.
    goal : DensityGoal
        D_c of eq. 12 and k of eq. 14.
    """

    costs: Vector
    n_keep: int
    goal: DensityGoal

    @property
    def trivial(self) -> bool:
        """Whether there is nothing to choose."""
        return self.n_keep in (0, len(self.costs))

    def within_reach(self) -> Program:
        """The program with a density that a solver can hold."""
        return replace(self, goal=self.goal.within_reach(self.costs))


def select(
    programs: Sequence[Program],
    generators: Sequence[np.random.Generator],
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    cancelled: Event | None = None,
) -> list[tuple[Mask, Certificate]]:
    """Choose the points of every cluster with |k D_cr - D_c| as small as possible (eqs. 14-26).

    Parameters
    ----------
    programs : sequence of Program
    generators : sequence of numpy.random.Generator
        One per program; it draws the starting solution.
    settings : SolverSettings, optional
    progress : callable, optional
        Called with (programs solved, programs).
    cancelled : threading.Event, optional
        Ends the search soon after it is set.

    Returns
    -------
    list of (ndarray of bool, shape (nc,), Certificate)
        One per program.

    Raises
    ------
    SolverError
        The solver ended without a selection.
    """
    settings, cancelled = settings or SolverSettings(), cancelled or Event()
    if settings.solver == "highs":
        return _select_from_starts(programs, generators, settings, progress, cancelled)
    with warnings.catch_warnings():
        # cvxpy warns of a limit or an inaccurate solution; the certificate says both
        warnings.simplefilter("ignore", UserWarning)
        return map_in_threads(lambda p: _select_cold(p, settings), programs, progress, cancelled)


def build_program(programs: Sequence[Program]) -> tuple[cp.Problem, cp.Variable, cp.Variable]:
    """Eqs. 21-26 for clusters that share no point, as one problem: the sum of theirs.

    Returns
    -------
    problem : cvxpy.Problem
    x : cvxpy.Variable, shape (n + K,)
        The points of all K clusters, then x_{nc+1} of each.
    y : cvxpy.Variable, shape (K,)
    """
    import cvxpy as cp  # two seconds; most clusters are certified without a solver

    sizes = np.array([len(p.costs) for p in programs])
    n_clusters, n_points = len(sizes), int(sizes.sum())
    owners = np.append(np.repeat(np.arange(n_clusters), sizes), np.arange(n_clusters))
    place = owners, np.arange(n_points + n_clusters)
    x = cp.Variable(n_points + n_clusters, boolean=True)  # eq. 26
    y = cp.Variable(n_clusters, nonneg=True)  # eq. 19
    member = np.append(np.ones(n_points), np.zeros(n_clusters))
    row = np.concatenate(  # eq. 20
        [p.goal.k * p.costs / p.n_keep for p in programs] + [[-p.goal.density] for p in programs]
    )
    rows = csr_array((row, place))
    constraints: list[Any] = [
        csr_array((member, place)) @ x == np.array([p.n_keep for p in programs]),  # eq. 22
        x[n_points:] == 1,  # eq. 23
        rows @ x <= y,  # eq. 24
        -rows @ x <= y,  # eq. 25
    ]
    return cp.Problem(cp.Minimize(cp.sum(y)), constraints), x, y  # eq. 21


def _select_from_starts(
    programs: Sequence[Program],
    generators: Sequence[np.random.Generator],
    settings: SolverSettings,
    progress: Progress | None,
    cancelled: Event,
) -> list[tuple[Mask, Certificate]]:
    """Give HiGHS a starting solution of every cluster where no bound proves it optimal already."""
    starts = map_in_threads(
        lambda item: _start(*item), zip(programs, generators, strict=True), None, cancelled
    )
    pairs = list(zip(programs, starts, strict=True))
    blocks = _blocks([p.within_reach() for p, (_, certificate) in pairs if not certificate.proven])

    def solve(item: tuple[Program, tuple[Mask, Certificate], _Block | None]) -> tuple[Mask, Certificate]:
        program, start, block = item
        return start if block is None else _improve(program, start, block, settings, cancelled)

    items = [(p, start, None if start[1].proven else next(blocks)) for p, start in pairs]
    return map_in_threads(solve, items, progress, cancelled)


def _start(program: Program, rng: np.random.Generator) -> tuple[Mask, Certificate]:
    """A selection to start from; it is final where there is nothing to choose."""
    costs, n_keep, goal = program.costs, program.n_keep, program.goal
    if program.trivial:
        return _all_or_none(program)
    return _certified_start(starting_mask(costs, n_keep, goal.wanted, rng), costs, goal)


def _all_or_none(program: Program) -> tuple[Mask, Certificate]:
    mask = np.full(len(program.costs), program.n_keep > 0)
    return mask, certify(program.costs, mask, program.goal)


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


@dataclass(frozen=True, eq=False)
class _Block:
    """One cluster's part of a joint problem: the columns of its points, of its x_{nc+1} and of its y."""

    problem: Canonical
    columns: Indices


def _blocks(programs: Sequence[Program]) -> Iterator[_Block]:
    """Write the programs as few problems, and find each one's part again."""
    for first in range(0, len(programs), _TOGETHER):
        together = programs[first : first + _TOGETHER]
        problem, x, y = build_program(together)
        canonical = Canonical(problem)
        ends = np.cumsum([len(p.costs) for p in together])
        of_points, of_ones = np.split(canonical.columns(x), ends[-1:])
        parts = zip(np.split(of_points, ends[:-1]), of_ones, canonical.columns(y), strict=True)
        yield from (_Block(canonical, np.append(rows, [one, of_y])) for rows, one, of_y in parts)


def _improve(
    program: Program,
    start: tuple[Mask, Certificate],
    block: _Block,
    settings: SolverSettings,
    cancelled: Event,
) -> tuple[Mask, Certificate]:
    """Give HiGHS the starting solution; what it returns is improved by exchanges and certified."""
    costs, n_keep, goal = program.costs, program.n_keep, program.goal
    mask, first = start
    reach = program.within_reach().goal
    objective = reach.objective(costs[mask])
    outcome = block.problem.solve_from(
        block.columns,
        np.append(mask, [1.0, objective]),
        objective_target=first.bound + TOLERANCE * reach.density,
        time_limit=settings.time_limit,
        gap=settings.gap,
        cancelled=cancelled,
    )
    found = exchange(costs, _rounded(outcome.values[:-2], n_keep), goal.wanted)
    best = min((mask, found), key=lambda chosen: goal.objective(costs[chosen]))
    return best, certify(costs, best, goal, outcome.status, {"solver": outcome.bound})


def _select_cold(program: Program, settings: SolverSettings) -> tuple[Mask, Certificate]:
    """Leave the program to cvxpy and the solver."""
    import cvxpy as cp

    costs, n_keep, goal = program.costs, program.n_keep, program.goal
    if program.trivial:
        return _all_or_none(program)
    name = cp.HIGHS if settings.solver == "highs-cold" else settings.solver
    limits: dict[str, Any] = _LIMITS[name](settings) if name in _LIMITS else {}
    problem, x, _ = build_program([program.within_reach()])
    try:
        problem.solve(solver=name, **limits)
    except cp.SolverError as error:
        raise _no_selection(name, n_keep, len(costs)) from error
    if x.value is None:
        raise _no_selection(name, n_keep, len(costs))
    status = {"optimal": "optimal", "user_limit": "time limit"}.get(str(problem.status), "inaccurate")
    mask = _rounded(np.asarray(x.value)[:-1], n_keep)
    # a solver that was not told the gap has one of its own: its word proves nothing
    known = status == "optimal" and name in _LIMITS
    bounds = {"solver": (1.0 - settings.gap) * goal.objective(costs[mask])} if known else None
    return mask, certify(costs, mask, goal, status, bounds)


def _no_selection(name: str, n_keep: int, n_points: int) -> SolverError:
    return SolverError(
        f"Solver {name} found no selection of {n_keep} of {n_points} points; raise time_limit "
        "or try solver='highs'."
    )


def _rounded(values: Vector, n_keep: int) -> Mask:
    """The solver's x as a choice of exactly ``n_keep`` points: solvers return 0 and 1 only nearly."""
    mask = np.zeros(len(values), dtype=bool)
    mask[np.argsort(-values, kind="stable")[:n_keep]] = True
    return mask
