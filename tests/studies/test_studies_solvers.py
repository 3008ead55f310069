"""The study of solvers on the printed problems."""

import cvxpy as cp
import numpy as np
import pytest

from studies.validation import solvers
from studies.validation.solvers import QUICK, PrintedProblem, outcome


def _problem(optimum):
    return PrintedProblem(cp.Problem(cp.Minimize(0)), optimum)


@pytest.mark.parametrize(
    ("optimum", "status", "error", "expected"),
    [
        (2.0, cp.OPTIMAL, 1e-7, "right"),
        (2.0, cp.OPTIMAL, 1e-4, "rough"),
        (2.0, cp.OPTIMAL, 1e-2, "wrong"),
        (2.0, cp.OPTIMAL, np.nan, "wrong"),
        (2.0, cp.INFEASIBLE, np.nan, "wrong"),
        (2.0, cp.OPTIMAL_INACCURATE, 1e-9, "inaccurate"),
        (2.0, cp.USER_LIMIT, np.nan, "refused"),
        (cp.UNBOUNDED, cp.UNBOUNDED, np.nan, "right"),
        (cp.UNBOUNDED, cp.OPTIMAL, np.nan, "wrong"),
        (cp.UNBOUNDED, cp.INFEASIBLE, np.nan, "wrong"),
        (cp.INFEASIBLE, cp.settings.INFEASIBLE_OR_UNBOUNDED, np.nan, "right"),
        (cp.INFEASIBLE, "timed out", np.nan, "timed out"),
    ],
)
def test_an_outcome_needs_the_right_value_with_the_right_status(optimum, status, error, expected):
    row = {"status": status, "error": error}
    assert outcome(_problem(optimum), row, QUICK) == expected


def test_a_solver_that_does_not_end_is_stopped_and_the_next_problem_is_solved():
    x = cp.Variable(name="x")
    printed = PrintedProblem(cp.Problem(cp.Minimize(x), [x >= 2]), 2.0)
    packed = solvers.pickle.dumps(printed)
    process = solvers.SolverProcess()
    stopped = process.solve(packed, "HIGHS", {}, seconds=1e-3)
    row = process.solve(packed, "HIGHS", {}, seconds=120.0)
    process.end()
    assert stopped["status"] == "timed out"
    assert outcome(printed, row, QUICK) == "right"


def test_installed_solvers_are_right_on_the_printed_problems(quick):
    (table,) = quick((solvers.SOLVERS,)).values()
    assert set(table["outcome"]) <= {"right", "rough", "not taken"}
    of_limits = table[table["problem"].str.startswith("limit")]
    assert set(of_limits["outcome"]) <= {"right", "not taken"}
