"""The cvxpy problems of increments.

The tests cover names, printing, the complementarity form, and wedging of one node.
"""

import inspect
import re
import textwrap
from pathlib import Path

import cvxpy as cp
import numpy as np
import osqp
import pytest
import scipy.sparse as sp

import frictopt as fo
from frictopt.base import SolveRecord
from frictopt.solve import by_cvxpy
from frictopt.solve import solvers as policy
from frictopt.solve.problem import Problem, printed_as
from frictopt.transients.increments import (
    programs as listings,
)
from frictopt.transients.increments.increment import Posed
from frictopt.transients.increments.newton import State, newton
from helpers.enumeration import admissible_states, random_increment
from helpers.spatial import random_contact
from helpers.systems import explained, random_system

CONTACT, FRICTION, SLIP, LOAD = random_increment(np.random.default_rng(3), 3, 0.6)


def solved(contact, friction, slip, load, form=None):
    return fo.increments.NewtonIncrement(contact, friction).solve(slip, load, form)


def names(problem):
    return {variable.name() for variable in problem.variables()}, {
        parameter.name() for parameter in problem.parameters()
    }


def test_problems_are_dpp_and_named():
    contact = random_system(np.random.default_rng(0), 3)
    load = np.zeros(3), np.ones(3)
    frozen, exact, pairs = (
        solved(contact, 0.5, np.zeros(3), load, form).problem
        for form in ("qp", "milp", "complementarity")
    )
    space = random_contact(np.random.default_rng(0), 3)
    in_space = solved(space, 0.5, np.zeros((3, 2)), (np.zeros((3, 2)), np.ones(3)), "qp").problem
    assert frozen.is_dpp() and exact.is_dpp()
    for problem in (frozen, exact, pairs, in_space):
        assert all(constraint.label for constraint in problem.constraints)
        # It prints names, and not the atoms of cvxpy.
        printed = str(problem)
        assert printed.count("\n") < 14 and "[[" not in printed
        assert not re.search("QuadForm|psd_wrap|Sum|[HV]stack|reshape|Pnorm", printed), printed
    assert names(pairs) == ({"z"}, {"c"})
    assert names(frozen) == ({"u"}, {"trial", "bound"})
    assert names(exact)[0] == {"slip_step", "gap", "q", "p", "forward", "backward", "opened"}
    assert names(exact)[1] == {"trial", "unexpected", "most_motion", "most_force", "most_slack"}
    assert not frozen.is_mixed_integer() and exact.is_mixed_integer()


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


@pytest.mark.parametrize("sigma", [2.2, 4.0])
def test_osqp_alone_finds_the_state(punch, sigma):
    """OSQP finds the state without Newton's method.

    Sweeps of quadratic programs, whose matrices are written down here, give the state to ten
    digits.
    """
    contact, f, n = punch(24), 0.7, 25
    q, p = contact.reaction({"P": 1.0, "sigma": sigma})
    none, one = sp.csc_matrix((n, n)), sp.eye_array(n)
    P = sp.triu(sp.block_diag([contact.S, none]), format="csc")
    # W >= 0, |dv| <= t.
    rows = sp.block_array([[none, one, none], [one, none, -one], [-one, none, -one]], format="csc")
    low = np.r_[np.zeros(n), np.full(2 * n, -np.inf)]
    high = np.r_[np.full(n, np.inf), np.zeros(2 * n)]
    bound, solver = f * np.maximum(p, 0.0), osqp.OSQP()
    options = {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 100_000, "verbose": False}
    solver.setup(sp.csc_matrix(P), np.zeros(3 * n), sp.csc_matrix(rows), low, high, **options)
    for _ in range(30):
        solver.update(q=np.concatenate([q, p, bound]))
        u = solver.solve(raise_error=True).x[: 2 * n]
        bound = f * np.maximum(p + contact.S[n:] @ u, 0.0)
    found = solved(contact, f, np.zeros(n), (q, p))
    assert u == pytest.approx(np.r_[found.slip, found.gap], abs=1e-7 * np.abs(u).max())
    assert 0 < np.count_nonzero(found.status) < n


def bare(listing):
    """The body of a listing, as it is pasted into a script."""
    lines = inspect.getsource(listing).split('"""')[-1]
    return textwrap.dedent(lines).replace("return Problem", "problem = Problem")


def test_listings_run_in_a_bare_script(punch):
    system, friction = punch(8), np.full(9, 0.5)
    load = system.reaction({"P": 1.0, "sigma": 3.0})
    page = (Path(__file__).parents[2] / "docs/api/increments.md").read_text(encoding="utf-8")
    assert all(
        f"```text\n{listed}\n```" in page
        for listed in (
            listings.frozen_bound(system),
            listings.exact(system, friction),
            listings.complementarity(system, friction),
        )
    )
    state = fo.increments.NewtonIncrement(system, friction).solve(np.zeros(9), load)
    script = {
        "cp": cp,
        "np": np,
        "Problem": Problem,
        "printed_as": printed_as,
        "system": system,
        "friction": friction,
    }
    assert state.status.any() and not state.status.all()
    trial = np.concatenate(load)
    step = pytest.approx(state.slip, abs=1e-5 * np.abs(state.slip).max())

    exec(bare(listings.frozen_bound), script)
    problem = script["problem"]
    problem.param_dict["trial"].value, problem.param_dict["bound"].value = trial, friction * state.p
    problem.solve(solver="CLARABEL")
    assert problem.var_dict["u"].value[:9] == step

    exec(bare(listings.exact), script)
    problem = script["problem"]
    for name, value in {
        "trial": trial,
        "unexpected": np.ones((3, 9)),
        "most_motion": np.full(9, 10.0),
        "most_force": np.full(9, 10.0),
    }.items():
        problem.param_dict[name].value = value
    problem.param_dict["most_slack"].value = 20 * friction
    problem.solve(solver="HIGHS")
    assert problem.var_dict["slip_step"].value == step

    exec(bare(listings.complementarity), script)
    problem = script["problem"]
    q, p = load
    problem.param_dict["c"].value = np.r_[friction * p + q, friction * p - q, p]
    motions = np.maximum(state.slip, 0), np.maximum(-state.slip, 0), state.gap
    problem.var_dict["z"].value = np.concatenate(motions)
    assert problem.objective.value == pytest.approx(0.0, abs=1e-12)
    assert all(row.violation().max() < 1e-12 for row in problem.constraints)


def test_the_complementarity_problem_is_solved_with_a_boolean_for_each_pair():
    """The boolean decides whether a motion or its slack vanishes. The value of the quadratic
    program at the solution is 0, and the solution is the enumerated state."""
    for seed in range(8):
        contact, friction, slip, load = random_increment(np.random.default_rng(seed), 3, 0.6)
        posed = solved(contact, friction, slip, load, "complementarity").problem
        motions, slacks = (row.args[1] for row in posed.constraints)
        moves = cp.Variable(9, boolean=True)
        cp.Problem(
            cp.Minimize(0),
            [*posed.constraints, motions <= 100 * moves, slacks <= 100 * (1 - moves)],
        ).solve(solver="HIGHS")
        assert posed.objective.value == pytest.approx(0.0, abs=1e-6)
        (v, w, _, _) = admissible_states(contact, friction, slip, load)[0]
        z = motions.value
        assert slip + z[:3] - z[3:6] == pytest.approx(v, abs=1e-5)
        assert z[6:] == pytest.approx(w, abs=1e-5)


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


def test_explain():
    printed = explained(solved(CONTACT, FRICTION, SLIP, LOAD, "qp"))
    assert all(
        part in printed
        for part in (
            "frozen bound",
            "optimal",
            "    bound",
            "no_overlap",
            "(DPP) yes",
            "trial",
            "3 of 3 rows bind",
        )
    )
    printed = explained(solved(CONTACT, FRICTION, SLIP, LOAD, "milp"))
    assert all(
        part in printed
        for part in (
            "mixed-integer",
            "optimal",
            "boolean",
            "most_motion",
            "no_force_across_a_gap",
            "one_status",
            "rows bind",
        )
    )
    posed = solved(CONTACT, FRICTION, SLIP, LOAD, "complementarity").problem
    assert all(part in str(posed) for part in ("motions", "slacks"))
    assert solved(CONTACT, FRICTION, SLIP, LOAD).problem is None


def test_cvxpy_is_asked_with_every_option_accepted():
    """A misspelt option would be an error of the solver, and a silent fall-back."""
    x = cp.Variable(2, name="x")
    smooth = cp.Problem(cp.Minimize(cp.sum_squares(x - 1)), [x >= 0])
    for name in policy.OPTIONS:
        assert by_cvxpy._run(smooth, name) == "optimal"


def states_of(A, B, C, friction, q, p, slip):
    """Slips, gaps and forces of all states of one node, (number of states, 4)."""
    contact = fo.ContactSystem.from_blocks([[A]], [[B]], [[C]], [0.0], {"load": ([q], [p])})
    return admissible_states(contact, friction, np.array([slip]), ([q], [p]))[:, :, 0]


def test_without_load_a_node_stays_where_it_slipped_from_the_critical_friction_on():
    for angle, v in [(np.pi / 3, 0.4), (2.0, -0.4)]:
        # A bar of unit stiffness.
        A = np.cos(angle) ** 2
        B = np.sin(angle) * np.cos(angle)
        C = np.sin(angle) ** 2
        wedged, *others = (
            states_of(A, B, C, f * A / abs(B), 0.0, 0.0, v)[:, 0] for f in (1.001, 0.999, 0.3)
        )
        assert v in wedged and not any(v in slips for slips in others)
    assert 1.0 in states_of(1.0, 0.5, 1.0, 3.0, 0.0, 0.0, 1.0)[:, 0]


@pytest.mark.parametrize(("f", "towards", "away"), [(1.9, 1, 1), (2.1, 0, 2), (3.0, 0, 2)])
def test_on_the_bound_that_presses_a_node_beyond_critical_friction_has_no_or_two_continuations(
    f, towards, away
):
    v, p, step = 1.0, 2.0, 1e-4
    at_bound = f * p  # q = f p, about to slip backward
    for sign, expected in [(-1, towards), (1, away)]:
        q_bonded, p_bonded = at_bound - 1.0 * v, p - 0.5 * v
        # f dp^w - dq^w = sign * step.
        after = states_of(1.0, 0.5, 1.0, f, q_bonded - sign * step, p_bonded, v)
        assert (np.abs(after[:, :2] - [v, 0.0]).max(axis=1) < 100 * step).sum() == expected
