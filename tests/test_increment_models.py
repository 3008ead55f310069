"""The increments' cvxpy problems: names, DPP, fall-back, convergence, printing; the complementarity form; wedging at one node."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from enumeration import admissible_states, distance, random_increment
from frictopt.contact import SolveRecord
from frictopt.solve import solvers as policy
from frictopt.transients.increments import ExactIncrement, FrozenBoundIncrement, NewtonIncrement, complementarity_problem, increment, programs
from frictopt.transients.increments.increment import Posed
from frictopt.transients.increments.newton import State, newton
from liars import lying
from systems import explained, random_system, system

CONTACT, FRICTION, SLIP, LOAD = random_increment(np.random.default_rng(3), 3, 0.6)


def names(problem):
    return {variable.name() for variable in problem.variables()}, {parameter.name() for parameter in problem.parameters()}


def test_problems_are_dpp_and_named():
    contact = random_system(np.random.default_rng(0), 3)
    frozen, exact = FrozenBoundIncrement(contact, 0.5).problem, ExactIncrement(contact, 0.5).problem
    for problem in (frozen, exact):
        assert problem.is_dpp()
        assert all(constraint.label for constraint in problem.constraints)
        assert problem.param_dict["trial_reaction"].shape == (6,)
    assert names(frozen) == ({"slip_increment", "gap"}, {"trial_reaction", "friction_bound"})
    assert names(exact) == ({"slip_increment", "gap", "forward", "backward", "opened"}, {"trial_reaction", "expected_status", "largest"})
    assert not frozen.is_mixed_integer() and exact.is_mixed_integer()


def test_the_solution_stands_in_the_problem():
    length = np.abs(LOAD[1]).mean() / CONTACT.stiffness_scale
    found = ExactIncrement(CONTACT, FRICTION).solve(SLIP, LOAD)
    assert SLIP + length * found.problem.var_dict["slip_increment"].value == pytest.approx(found.slip, abs=1e-5)
    assert (found.problem.var_dict["opened"].value > 0.5).tolist() == (found.status == 2).tolist()
    sweep = FrozenBoundIncrement(CONTACT, FRICTION).solve(SLIP, LOAD).problem
    trial, S = sweep.param_dict["trial_reaction"].value, CONTACT.S / CONTACT.stiffness_scale
    q, p = np.split(trial + S @ np.r_[sweep.var_dict["slip_increment"].value, sweep.var_dict["gap"].value], 2)
    assert (np.abs(q) <= sweep.param_dict["friction_bound"].value + 1e-6).all() and p.min() > -1e-6


def test_the_next_solver_answers_where_one_fails(monkeypatch):
    lying(monkeypatch, lambda _, name: "stopped" if name == "CLARABEL_DIRECT" else None)
    found = FrozenBoundIncrement(CONTACT, FRICTION).solve(SLIP, LOAD)
    assert found.record.solver == "CLARABEL" and [attempt.solver for attempt in found.record.attempts[:2]] == ["CLARABEL_DIRECT", "CLARABEL"]
    assert distance(admissible_states(CONTACT, FRICTION, SLIP, LOAD), found) < 1e-9


def test_sweeps_converge_to_the_state_and_too_few_say_so(monkeypatch):
    contact, friction, slip, load = random_increment(np.random.default_rng(245), 3, 0.8)  # the first of these that needs more than two
    found = FrozenBoundIncrement(contact, friction).solve(slip, load)
    assert found.steps > 1 and found.residual < 1e-9 and distance(admissible_states(contact, friction, slip, load), found) < 1e-9
    monkeypatch.setattr(programs, "_SWEEPS", 1)
    with pytest.raises(fo.SolverError, match=r"did not converge in 1 sweeps.*bound still changes by .*most at node \d.*try"):
        FrozenBoundIncrement(contact, friction).solve(slip, load)


def test_slip_along_its_friction_is_no_state():
    """q = -f p with backward slip breaks only the line of the law that needs the slip before."""
    contact = fo.ContactSystem.from_blocks([[2.0]], [[0.0]], [[1.0]], [0.0], {"load": ([1.0], [1.0])})
    posed = Posed(NewtonIncrement(contact, 0.4), [5.0], ([1.0 - 10.0], [1.0]))
    right = newton(posed.owner.law, posed.trial, np.zeros(2))
    q = -right.r[0]
    dv = (q - posed.trial[0]) / posed.owner.law.S[0, 0]
    wrong = State(np.array([dv, 0.0]), np.array([q, right.r[1]]), np.ones(1, dtype=np.int8), 0, 0.0)
    assert right.u[0] < 0 and posed.result(right, SolveRecord()).residual < 1e-12
    assert wrong.u[0] < 0 and posed.result(wrong, SolveRecord()).residual > 0.3


def test_booleans_are_not_believed_before_the_referee(monkeypatch):
    def wrong(problem, name):
        if "opened" in problem.var_dict:
            for boolean in ("forward", "backward", "opened"):
                problem.var_dict[boolean].save_value(np.full(3, float(boolean == "opened")))
            problem.var_dict["gap"].save_value(np.full(3, 1e3))

    lying(monkeypatch, wrong)
    monkeypatch.setattr(increment, "_CORRECTIONS", 0)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        ExactIncrement(CONTACT, FRICTION).solve(SLIP, LOAD)


def test_a_claim_that_there_is_no_state_is_checked(monkeypatch):
    asked = []
    lying(monkeypatch, lambda _, name: asked.append(name) or ("infeasible" if name.startswith("HIGHS") else None))
    with pytest.raises(fo.SolverError, match="but Newton's method does"):
        ExactIncrement(CONTACT, FRICTION).solve(SLIP, LOAD)
    assert [name for name in asked if name.startswith("HIGHS")] == list(policy.MILP_SOLVERS)


def test_a_solver_that_stops_is_no_proof(monkeypatch):
    monkeypatch.setattr(policy, "_run", lambda *_: "stopped")
    with pytest.raises(fo.SolverError, match=r"mixed-integer program: no answer.*stopped"):
        ExactIncrement(CONTACT, FRICTION).solve(SLIP, LOAD)


@pytest.mark.parametrize("push", [1.5, 15.0])
def test_states_beyond_the_reach_are_not_ruled_out(push, monkeypatch):
    """A = 0.01, B = 0: friction 1 holds 1 of the load, so that the node slips by 100 (load - 1), in units of p / C."""
    contact = system(0.01, 0.0, 0, 1, 0, 0, C=1.0)
    monkeypatch.setattr(programs, "newton", lambda law, trial, u: State(u, trial, np.zeros(1, dtype=np.int8), 0, 0.0))
    load = ([push], [1.0])
    found = ExactIncrement(contact, 1.0).solve([0.0], load)
    assert found.slip == pytest.approx([-100 * (push - 1)])
    with pytest.raises(fo.NoContinuation, match=r"no state obeys the law under this load with slip increments and gaps up to .*larger reach"):
        ExactIncrement(contact, 1.0, reach=10.0).solve([0.0], load)
    needed = 100 * (push - 1) * contact.stiffness_scale / push
    with pytest.raises(fo.SolverError, match="give a larger reach than"):
        ExactIncrement(contact, 1.0, reach=needed * (1 + 1e-6)).solve([0.0], load)
    assert ExactIncrement(contact, 1.0, reach=1.01 * needed).solve([0.0], load).slip == pytest.approx(found.slip)


@pytest.mark.parametrize("coupling", [0.0, 0.4])
def test_complementarity_is_refused_where_it_is_not_convex(coupling):
    contact = random_system(np.random.default_rng(0), 3, coupling=coupling)
    posed = complementarity_problem(contact, 0.5, np.zeros(3), ([1.0, 0.0, -1.0], [1.0, 1.0, 1.0]))
    assert np.linalg.eigvalsh(posed.matrix + posed.matrix.T)[0] < -1e-3 and not posed.problem.is_dcp()
    with pytest.raises(cp.DCPError):
        posed.problem.solve()


def test_complementarity_matrix_is_the_law():
    """At the enumerated state z >= 0, M z + c >= 0 and z' (M z + c) = 0."""
    for seed in range(20):
        contact, friction, slip, load = random_increment(np.random.default_rng(seed), 3, 0.6)
        posed = complementarity_problem(contact, friction, slip, load)
        v, w, _, _ = admissible_states(contact, friction, slip, load)[0]
        dv = (v - slip) / posed.length
        z = np.r_[np.maximum(dv, 0), np.maximum(-dv, 0), w / posed.length]
        slack = posed.matrix @ z + posed.constant
        assert slack.min() > -1e-9 and np.abs(z * slack).max() < 1e-9
        A, B, C = (matrix / contact.stiffness_scale for matrix in (contact.A, contact.B, contact.C))
        f = friction[:, None]
        rows = [[A + f * B, -(A + f * B), B.T + f * C], [-(A - f * B), A - f * B, -B.T + f * C], [B, -B, C]]
        assert posed.matrix == pytest.approx(np.block(rows))
        for variable, part in zip(("forward_slip", "backward_slip", "gap"), np.split(z, 3), strict=True):
            posed.problem.var_dict[variable].save_value(part)
        assert posed.problem.objective.value == pytest.approx(0.0, abs=1e-9)
        assert all(constraint.value(1e-9) for constraint in posed.problem.constraints)


def test_explain():
    frozen, exact = FrozenBoundIncrement(CONTACT, FRICTION), ExactIncrement(CONTACT, FRICTION)
    said = explained(frozen.solve(SLIP, LOAD))
    assert all(
        part in said for part in ("frozen bound", "optimal", "friction_bound", "no_overlap", "(DPP) yes", "slip_increment", ", unit ", "rows bind")
    )
    said = explained(exact.solve(SLIP, LOAD))
    assert all(part in said for part in ("mixed-integer", "optimal", "boolean", "largest", "no_force_across_a_gap", "one_status", "rows bind"))
    posed = complementarity_problem(CONTACT, FRICTION, SLIP, LOAD)
    assert all(part in str(posed.problem) for part in ("forward_bound", "no_tension"))
    assert NewtonIncrement(CONTACT, FRICTION).solve(SLIP, LOAD).problem is None


def test_cvxpy_is_asked_with_every_option_accepted():
    """A misspelt option would be an error of the solver, and a silent fall-back."""
    x = cp.Variable(2, name="x")
    smooth = cp.Problem(cp.Minimize(cp.sum_squares(x - 1)), [x >= 0])
    for name in policy.SOCP_SOLVERS:
        assert policy._run(smooth, name) == "optimal"
    whole = cp.Variable(2, boolean=True)
    for name in policy.MILP_SOLVERS:
        assert policy._run(cp.Problem(cp.Maximize(cp.sum(whole)), [cp.sum(whole) <= 1.5]), name) == "optimal"


def states_of(A, B, C, friction, q, p, slip):
    """Of one node: (number of states, 4) slips, gaps and forces."""
    contact = fo.ContactSystem.from_blocks([[A]], [[B]], [[C]], [0.0], {"load": ([q], [p])})
    return admissible_states(contact, friction, np.array([slip]), ([q], [p]))[:, :, 0]


def test_without_load_a_node_stays_where_it_slipped_from_the_critical_friction_on():
    for angle, v in [(np.pi / 3, 0.4), (2.0, -0.4)]:
        A, B, C = np.cos(angle) ** 2, np.sin(angle) * np.cos(angle), np.sin(angle) ** 2  # a bar of unit stiffness
        wedged, *others = (states_of(A, B, C, f * A / abs(B), 0.0, 0.0, v)[:, 0] for f in (1.001, 0.999, 0.3))
        assert v in wedged and not any(v in slips for slips in others)
    assert 1.0 in states_of(1.0, 0.5, 1.0, 3.0, 0.0, 0.0, 1.0)[:, 0]


@pytest.mark.parametrize(("f", "towards", "away"), [(1.9, 1, 1), (2.1, 0, 2), (3.0, 0, 2)])
def test_on_the_bound_that_presses_a_node_beyond_critical_friction_has_no_or_two_continuations(f, towards, away):
    v, p, step = 1.0, 2.0, 1e-4
    at_bound = f * p  # q = f p, about to slip backward
    for sign, expected in [(-1, towards), (1, away)]:
        q_bonded, p_bonded = at_bound - 1.0 * v, p - 0.5 * v
        after = states_of(1.0, 0.5, 1.0, f, q_bonded - sign * step, p_bonded, v)  # f dp^w - dq^w = sign * step
        assert (np.abs(after[:, :2] - [v, 0.0]).max(axis=1) < 100 * step).sum() == expected
