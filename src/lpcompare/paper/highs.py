"""HiGHS given a starting solution: for a cvxpy problem, and for a program given as a matrix.

cvxpy's own warm start only reuses its previous solve, so the problem's data go to highspy directly.
"""

from __future__ import annotations

from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING, Any

import highspy
import numpy as np
from scipy.sparse import csc_array

from lpcompare.errors import SolverError
from lpcompare.types import Indices, Mask, Vector

if TYPE_CHECKING:
    import cvxpy as cp

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


@dataclass(frozen=True, eq=False)
class Outcome:
    """How HiGHS ended.

    Attributes
    ----------
    status : str
        "optimal", "time limit" or "interrupted".
    bound : float
        Lower bound on the objective that HiGHS proved.
    values : ndarray, shape (c,)
        The solution, in the order of the columns that were asked for.
    prices : ndarray, shape (r,)
        What the objective would change by if the limits of a row were one more; without integers only.
    """

    status: str
    bound: float
    values: Vector
    prices: Vector


@dataclass(frozen=True, eq=False)
class Program:
    """A mixed-integer linear program: minimise ``costs @ x`` between limits of the rows and of the columns.

    Attributes
    ----------
    costs : ndarray, shape (c,)
    matrix : scipy.sparse.csc_array, shape (r, c)
    rows : tuple of ndarray, shape (r,)
        Least and largest value of each row of ``matrix @ x``.
    columns : tuple of ndarray, shape (c,)
        Least and largest value of each column.
    boolean : ndarray of bool, shape (c,)
        Columns that are whole numbers.
    """

    costs: Vector
    matrix: csc_array
    rows: tuple[Vector, Vector]
    columns: tuple[Vector, Vector]
    boolean: Mask

    def part(self, free: Mask, values: Vector) -> Program:
        """The program of the columns ``free`` where the others are fixed at their ``values``, shape (c,)."""
        fixed = self.matrix[:, ~free] @ values[~free]
        return Program(
            self.costs[free],
            self.matrix[:, free],
            (self.rows[0] - fixed, self.rows[1] - fixed),
            (self.columns[0][free], self.columns[1][free]),
            self.boolean[free],
        )

    def reduced(self, prices: Vector) -> Vector:
        """What the objective would change by if a column were one more, at prices (r,) of the rows, shape (c,)."""
        return self.costs - prices @ self.matrix

    def solve(
        self, options: dict[str, Any], *, start: Vector | None = None, cancelled: Event | None = None
    ) -> Outcome:
        """Solve by HiGHS on one thread, from a starting solution if there is one.

        Raises
        ------
        SolverError
            HiGHS ended without a solution.
        """
        solver = _QuietHighs()
        for name, value in (_OPTIONS | options).items():
            solver.setOptionValue(name, value)
        self._pass_to(solver)
        if start is not None:
            solution = highspy.HighsSolution()
            solution.col_value = start.tolist()
            solution.value_valid = True
            solver.setSolution(solution)
        if cancelled is not None:
            _watch(solver, cancelled)
        # an earlier solve with another number of threads leaves this thread a scheduler that refuses ours
        highspy.Highs.resetGlobalScheduler(True)
        solver.run()
        return _outcome(solver)

    def _pass_to(self, solver: highspy.Highs) -> None:
        integer, continuous = highspy.HighsVarType.kInteger, highspy.HighsVarType.kContinuous
        # the arrays as such: an attribute of a HighsLp is copied number by number
        solver.passModel(
            len(self.costs),
            len(self.rows[0]),
            self.matrix.nnz,
            int(highspy.MatrixFormat.kColwise),
            int(highspy.ObjSense.kMinimize),
            0.0,
            self.costs,
            self.columns[0],
            self.columns[1],
            self.rows[0],
            self.rows[1],
            self.matrix.indptr.astype(np.int32),
            self.matrix.indices.astype(np.int32),
            np.asarray(self.matrix.data, dtype=np.float64),
            np.where(self.boolean, int(integer), int(continuous)).astype(np.int32),
        )


class Canonical:
    """A mixed-integer linear problem of cvxpy in its matrix form, which may be solved block by block.

    cvxpy takes as long for one small problem as for many at once. Problems that share no variable are
    therefore written as one, brought into matrix form together, and solved each on its own columns.

    Parameters
    ----------
    problem : cvxpy.Problem
        A linear objective and linear constraints over boolean and continuous variables.
    """

    def __init__(self, problem: cp.Problem) -> None:
        data = problem.get_problem_data("HIGHS")[0]
        self._matrix = data["A"].tocsc()
        self._costs, self._right, self._n_equalities = data["c"], data["b"], data["dims"].zero
        self._boolean = np.isin(np.arange(len(self._costs)), data["bool_vars_idx"])
        self._lower, self._upper = _bounds(data, self._boolean)
        self._first = data["param_prob"].var_id_to_col

    def columns(self, variable: cp.Variable) -> Indices:
        """The matrix columns of a variable of the problem, shape (size,)."""
        first = self._first[variable.id]
        return np.arange(first, first + variable.size)

    def solve_from(
        self,
        columns: Indices,
        start: Vector,
        *,
        objective_target: float,
        time_limit: float,
        gap: float,
        cancelled: Event | None = None,
    ) -> Outcome:
        """Solve the block of some columns from a starting solution.

        Parameters
        ----------
        columns : ndarray of int, shape (c,)
            Columns that share no row with any other.
        start : ndarray, shape (c,)
            A feasible value of each.
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
        options = {"objective_target": objective_target, "time_limit": time_limit, "mip_rel_gap": gap}
        return self._block(columns).solve(options, start=start, cancelled=cancelled)

    def _block(self, columns: Indices) -> Program:
        """The rows that touch the columns, equalities first, then rows at most b."""
        matrix = self._matrix[:, columns]
        touched = np.bincount(matrix.indices, minlength=len(self._right)) > 0
        rows, right = np.flatnonzero(touched), self._right[touched]
        left = np.where(rows < self._n_equalities, right, -highspy.kHighsInf)
        places = (np.cumsum(touched) - 1)[matrix.indices]
        return Program(
            self._costs[columns],
            csc_array((matrix.data, places, matrix.indptr), shape=(len(rows), len(columns))),
            (left, right),
            (self._lower[columns], self._upper[columns]),
            self._boolean[columns],
        )


def _outcome(solver: highspy.Highs) -> Outcome:
    status, solution = solver.getModelStatus().name, solver.getSolution()
    if status not in _HAS_SOLUTION or not solution.value_valid:
        raise SolverError(
            f"HiGHS ended with {status} and no solution; raise time_limit or try another solver."
        )
    named = {"kTimeLimit": "time limit", "kSolutionLimit": "time limit", "kInterrupt": "interrupted"}
    bound = float(solver.getInfo().mip_dual_bound)
    prices = np.array(solution.row_dual)
    return Outcome(named.get(status, "optimal"), bound, np.array(solution.col_value), prices)


def _bounds(data: dict[str, Any], boolean: Mask) -> tuple[Vector, Vector]:
    lower, upper = data["lower_bounds"], data["upper_bounds"]
    lower = np.full(len(boolean), -highspy.kHighsInf) if lower is None else np.array(lower, dtype=float)
    upper = np.full(len(boolean), highspy.kHighsInf) if upper is None else np.array(upper, dtype=float)
    lower[boolean] = np.maximum(lower[boolean], 0.0)
    upper[boolean] = np.minimum(upper[boolean], 1.0)
    return lower, upper


def _watch(solver: highspy.Highs, cancelled: Event) -> None:
    """Let HiGHS stop at its next check once ``cancelled`` is set."""

    def stop(event: Any) -> None:
        if cancelled.is_set():
            event.data_in.user_interrupt = True

    solver.cbMipInterrupt += stop
    solver.cbSimplexInterrupt += stop
