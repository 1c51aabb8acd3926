"""HiGHS given a starting solution, for a cvxpy problem.

cvxpy's own warm start only reuses its previous solve, so the problem's data go to highspy directly and the
solution comes back through cvxpy.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from threading import Event
from typing import Any

import cvxpy as cp
import highspy
import numpy as np
from numpy.typing import NDArray

from lpcompare.errors import SolverError

_OPTIONS = {
    "threads": 1,
    "presolve": "off",
    "mip_abs_gap": 1e-10,
    "mip_feasibility_tolerance": 1e-9,
    "primal_feasibility_tolerance": 1e-9,
    "small_matrix_value": 1e-12,
}
_HAS_SOLUTION = {"kOptimal", "kObjectiveTarget", "kTimeLimit", "kSolutionLimit", "kInterrupt"}


class _QuietHighs(highspy.Highs):
    """HiGHS that is told to be silent before its constructor prints a banner."""

    def enableCallbacks(self) -> None:  # noqa: N802 - highspy's name
        self.setOptionValue("output_flag", False)
        super().enableCallbacks()


@dataclass(frozen=True)
class Outcome:
    """How HiGHS ended.

    Attributes
    ----------
    status : str
        "optimal", "time limit" or "interrupted".
    bound : float
        Lower bound on the objective that HiGHS proved.
    """

    status: str
    bound: float


def solve_from(
    problem: cp.Problem,
    start: Mapping[cp.Variable, NDArray[Any]],
    *,
    objective_target: float,
    time_limit: float,
    gap: float,
    cancelled: Event | None = None,
) -> Outcome:
    """Solve a mixed-integer linear problem from a starting solution; the variables of ``problem`` get values.

    Parameters
    ----------
    problem : cvxpy.Problem
        A linear objective and linear constraints over boolean and continuous variables.
    start : mapping of cvxpy.Variable to ndarray
        A feasible value of every variable.
    objective_target : float
        A solution at least this good ends the search; it counts as optimal.
    time_limit : float
        Seconds; at the limit the best solution so far is kept.
    gap : float
        Relative gap between solution and bound that counts as optimal.
    cancelled : threading.Event, optional
        HiGHS gives up soon after it is set.

    Returns
    -------
    Outcome

    Raises
    ------
    SolverError
        HiGHS ended without a solution.
    """
    data, chain, inverse = problem.get_problem_data(cp.HIGHS)
    solver = _QuietHighs()
    options = _OPTIONS | {"objective_target": objective_target, "time_limit": time_limit, "mip_rel_gap": gap}
    for name, value in options.items():
        solver.setOptionValue(name, value)
    solver.passModel(_model(data))
    solver.setSolution(_start_solution(data, start))
    if cancelled is not None:
        _watch(solver, cancelled)
    solver.run()
    results = {
        "solution": solver.getSolution(),
        "info": solver.getInfo(),
        "model_status": solver.getModelStatus().name,
        "run_time": solver.getRunTime(),
    }
    return _unpack(problem, results, chain, inverse)


def _unpack(problem: cp.Problem, results: dict[str, Any], chain: Any, inverse: Any) -> Outcome:
    status = results["model_status"]
    if status not in _HAS_SOLUTION or not results["solution"].value_valid:
        raise SolverError(
            f"HiGHS ended with {status} and no solution; raise time_limit or try another solver."
        )
    with warnings.catch_warnings():
        # cvxpy warns of a limit; here the target is one, and the caller recomputes the objective itself
        warnings.simplefilter("ignore", UserWarning)
        problem.unpack_results(results | {"model_status": "kOptimal"}, chain, inverse)
    named = {"kTimeLimit": "time limit", "kSolutionLimit": "time limit", "kInterrupt": "interrupted"}
    return Outcome(named.get(status, "optimal"), float(results["info"].mip_dual_bound))


def _model(data: dict[str, Any]) -> highspy.HighsModel:
    """The problem data of cvxpy as a HiGHS model: equalities first, then rows at most b."""
    matrix = data["A"].tocsc()
    n_rows, n_columns = matrix.shape
    boolean = np.asarray(data["bool_vars_idx"], dtype=int)
    model = highspy.HighsModel()
    lp = model.lp_
    lp.num_col_, lp.num_row_ = n_columns, n_rows
    lp.col_cost_ = data["c"]
    lp.row_upper_ = data["b"]
    lp.row_lower_ = np.where(np.arange(n_rows) < data["dims"].zero, data["b"], -highspy.kHighsInf)
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_ = matrix.indptr
    lp.a_matrix_.index_ = matrix.indices
    lp.a_matrix_.value_ = matrix.data
    lp.col_lower_, lp.col_upper_ = _bounds(data, n_columns, boolean)
    kinds = np.full(n_columns, highspy.HighsVarType.kContinuous, dtype=object)
    kinds[boolean] = highspy.HighsVarType.kInteger
    lp.integrality_ = kinds.tolist()
    return model


def _bounds(
    data: dict[str, Any], n_columns: int, boolean: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    lower, upper = data["lower_bounds"], data["upper_bounds"]
    lower = np.full(n_columns, -highspy.kHighsInf) if lower is None else np.array(lower, dtype=float)
    upper = np.full(n_columns, highspy.kHighsInf) if upper is None else np.array(upper, dtype=float)
    lower[boolean] = np.maximum(lower[boolean], 0.0)
    upper[boolean] = np.minimum(upper[boolean], 1.0)
    return lower, upper


def _start_solution(data: dict[str, Any], start: Mapping[cp.Variable, NDArray[Any]]) -> highspy.HighsSolution:
    columns = data["param_prob"].var_id_to_col
    values = np.zeros(data["A"].shape[1])
    for variable, value in start.items():
        first = columns[variable.id]
        values[first : first + variable.size] = np.ravel(value, order="F")
    solution = highspy.HighsSolution()
    solution.col_value = values.tolist()
    solution.value_valid = True
    return solution


def _watch(solver: highspy.Highs, cancelled: Event) -> None:
    """Let HiGHS stop at its next check once ``cancelled`` is set."""

    def stop(event: Any) -> None:
        if cancelled.is_set():
            event.data_in.user_interrupt = True

    solver.cbMipInterrupt += stop
    solver.cbSimplexInterrupt += stop
