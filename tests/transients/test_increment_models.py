"""The cvxpy problems of increments.

The tests cover their values and the complementarity form.
"""

from pathlib import Path

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.base import SolveRecord
from frictopt.solve import by_cvxpy
from frictopt.solve import solvers as policy
from frictopt.transients.increments import programs as listings
from frictopt.transients.increments.increment import Posed
from frictopt.transients.increments.newton import State, newton
from helpers.enumeration import admissible_states, random_increment
from helpers.systems import explained, random_system

CONTACT, FRICTION, SLIP, LOAD = random_increment(np.random.default_rng(3), 3, 0.6)


def solved(contact, friction, slip, load, form=None):
    return fo.increments.NewtonIncrement(contact, friction).solve(slip, load, form)


@pytest.mark.parametrize("unit", [1.0, 1e6])
def test_the_answer_stands_in_the_problem_and_is_its_optimum(unit):
    """It is in the units of the contact. A plain solve by cvxpy gives it again, and its multipliers
    are the pressures."""
    contact = fo.ContactSystem(
        unit * CONTACT.S, CONTACT.points, {"none": np.zeros(6)}, gap=CONTACT.gap
    )
    load = (unit * LOAD[0], unit * LOAD[1])
    found, frozen = (solved(contact, FRICTION, SLIP, load, form) for form in ("milp", "qp"))
    motions = np.concatenate([frozen.slip - SLIP, frozen.gap])
    for problem, state in ((found.problem, found), (frozen.problem, frozen)):
        assert problem.value == problem.objective.value and problem.status == "optimal"
        assert all(row.violation().max() < 1e-9 * unit for row in problem.constraints)
        assert np.abs(state.slip - SLIP - motions[:3]).max() < 1e-9
        assert explained(state).count("none here") == 0
    assert (found.problem.var_dict["opened"].value == 1).tolist() == (found.status == 2).tolist()
    assert found.problem.var_dict["p"].value == pytest.approx(found.p)
    assert found.problem.var_dict["slip_step"].value == pytest.approx(motions[:3])
    value, problem = frozen.problem.value, frozen.problem
    assert np.array_equal(problem.var_dict["u"].value, motions)
    assert problem.constraints[0].dual_value == pytest.approx(frozen.p)
    assert problem.param_dict["bound"].value == pytest.approx(FRICTION * frozen.p)
    assert problem.solve(solver="CLARABEL") == pytest.approx(value, rel=1e-6)
    assert problem.var_dict["u"].value == pytest.approx(motions, abs=1e-5)
    assert problem.constraints[0].dual_value == pytest.approx(frozen.p, abs=1e-5 * unit)


def test_the_page_of_increments_has_their_problems_as_they_are_printed(punch):
    system, friction = punch(8), np.full(9, 0.5)
    page = (Path(__file__).parents[2] / "docs/api/increments.md").read_text(encoding="utf-8")
    for listed in (
        listings.frozen_bound(system),
        listings.exact(system, friction),
        listings.complementarity(system, friction),
    ):
        assert f"```text\n{listed}\n```" in page


def test_slip_along_its_friction_is_no_state():
    """Backward slip at q = -f p breaks only the line of the law that needs the slip before."""
    contact = fo.ContactSystem.from_blocks(
        [[2.0]], [[0.0]], [[1.0]], [0.0], {"load": ([1.0], [1.0])}
    )
    posed = Posed(fo.increments.NewtonIncrement(contact, 0.4), [5.0], ([1.0 - 10.0], [1.0]))
    right = newton(posed.owner.law, posed.trial, np.zeros(2))
    q = -right.r[0]
    dv = (q - posed.trial[0]) / posed.owner.law.S[0, 0]
    wrong = State(np.array([dv, 0.0]), np.array([q, right.r[1]]), np.ones(1, dtype=np.int8), 0, 0.0)
    assert right.u[0] < 0 and posed.result(right, SolveRecord()).residual < 1e-12
    assert wrong.u[0] < 0 and posed.result(wrong, SolveRecord()).residual > 0.3


@pytest.mark.parametrize("coupling", [0.0, 0.4])
def test_complementarity_is_refused_where_it_is_not_convex(coupling):
    contact = random_system(np.random.default_rng(0), 3, coupling=coupling)
    load = [1.0, 0.0, -1.0], [1.0, 1.0, 1.0]
    posed = solved(contact, 0.5, np.zeros(3), load, "complementarity").problem
    matrix = matrix_of(posed)
    assert np.linalg.eigvalsh(matrix + matrix.T)[0] < -1e-3
    assert not posed.is_dcp()
    with pytest.raises(cp.DCPError):
        posed.solve()


def matrix_of(problem):
    return next(constant.value for constant in problem.constants() if constant.name() == "M")


def test_complementarity_matrix_is_the_law():
    """At the enumerated state z >= 0, M z + c >= 0 and z' (M z + c) = 0."""
    for seed in range(20):
        contact, friction, slip, load = random_increment(np.random.default_rng(seed), 3, 0.6)
        posed = solved(contact, friction, slip, load, "complementarity").problem
        v, w, _, _ = admissible_states(contact, friction, slip, load)[0]
        dv = v - slip
        z = np.r_[np.maximum(dv, 0), np.maximum(-dv, 0), w]
        slack = matrix_of(posed) @ z + posed.param_dict["c"].value
        assert slack.min() > -1e-9 and np.abs(z * slack).max() < 1e-9
        A, B, C = contact.A, contact.B, contact.C
        f = friction[:, None]
        rows = [
            [A + f * B, -(A + f * B), B.T + f * C],
            [-(A - f * B), A - f * B, -B.T + f * C],
            [B, -B, C],
        ]
        assert matrix_of(posed) == pytest.approx(np.block(rows))
        assert posed.objective.value == pytest.approx(0.0, abs=1e-9)
        assert posed.var_dict["z"].value == pytest.approx(z, abs=1e-9)
        assert all(constraint.value(1e-9) for constraint in posed.constraints)


def test_cvxpy_is_asked_with_every_option_accepted():
    """A misspelt option would be an error of the solver, and a silent fall-back."""
    x = cp.Variable(2, name="x")
    smooth = cp.Problem(cp.Minimize(cp.sum_squares(x - 1)), [x >= 0])
    for name in policy.OPTIONS:
        assert by_cvxpy._run(smooth, name) == "optimal"
