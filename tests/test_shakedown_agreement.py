import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.solve import solvers as policy
from liars import lying, sloppy
from spatial import cycle as space_cycle
from spatial import random_contact
from systems import CYCLE, at_corners, explained, linprog_limit, random_system, stress_of


def test_refinement_restores_an_answer_that_a_solver_leaves_inaccurate(punch, paper_cycle, monkeypatch):
    lying(monkeypatch, sloppy(1e-5))
    limit = fo.shakedown_limit(punch(40), paper_cycle, 0.7)
    assert [attempt.outcome for attempt in limit.record.attempts] == ["optimal", "refined on the vertex"]
    assert limit.record.attempts[0].residual > 1e-7 and limit.residual < 1e-10


@pytest.mark.parametrize("corners", [3, 64])
def test_corners_that_rule_no_node_are_counted_and_change_nothing(punch, corners):
    """Against a plain program with the rows of all corners."""
    angles = 2 * np.pi * np.arange(corners) / corners
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": float(np.cos(a)), "Q": 0.3 * float(np.sin(a))} for a in angles])
    limit = fo.shakedown_limit(punch(16), cycle, 0.7, simplify=False)
    assert limit.load_factor == pytest.approx(linprog_limit(punch(16), cycle, 0.7)[1], rel=1e-7)
    assert limit.problem.constraints[0].size == 17
    (q1, p1), f = cycle.corner_reactions(punch(16)), 0.7
    idle = corners - len(set(np.r_[(-q1 - f * p1).argmax(axis=0), (q1 - f * p1).argmax(axis=0)]))
    assert limit.record.left_out == ((f"corners: {idle} of {corners} rule no node",) if idle else ())


@pytest.mark.slow
def test_many_corners_take_memory_for_their_loads_alone():
    """Three nodes and 100,000 corners: rows of all of them would be a program of 600,000."""
    rng = np.random.default_rng(0)
    contact = random_system(rng, 3, loads=("mean", "a", "b"))
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(100_000, 2))])
    limit = fo.shakedown_limit(contact, cycle, 0.4, simplify=False)
    assert sum(constraint.size for constraint in limit.problem.constraints) == 7
    q, p = at_corners(contact, cycle, limit.load_factor, limit.slip)
    assert (0.4 * p - np.abs(q)).min() == pytest.approx(0.0, abs=1e-9)


def test_the_mechanism_is_a_proof(punch, paper_cycle):
    """Slips of the table: shares add up to one, do no work on any residual slip, and bound the load from above."""
    contact = punch(16)
    limit = fo.shakedown_limit(contact, paper_cycle, 0.7)
    table = limit.mechanism
    assert list(table.columns) == ["node", "x", "corner", "loads", "direction", "share"]
    assert table.share.sum() == pytest.approx(1.0, abs=1e-6) and (np.diff(table.share) <= 0).all()
    assert np.array_equal(table.x, contact.x[table.node])
    assert np.abs(stress_of(contact, table, 0.7)).max() < 1e-8 * np.abs(contact.A).max()
    (q0, p0), (q1, p1) = contact.bonded["P"], contact.bonded["sigma"]
    sign = np.array([-1.0, 1.0])[table.corner]
    resistance = (table.share * (table.direction * q0[table.node] + 0.7 * p0[table.node])).sum()
    drive = -(table.share * sign * (table.direction * q1[table.node] + 0.7 * p1[table.node])).sum()
    assert resistance / drive == pytest.approx(limit.load_factor, rel=1e-7)


def test_explain_does_not_mix_two_solves(punch, paper_cycle):
    model = fo.ShakedownModel(punch(16), paper_cycle)
    first = model.solve(0.3)
    text = explained(first)
    assert "rows bind" in text and f"{first.load_factor:.12g}" in text
    model.solve(0.7)
    text = explained(first)
    assert "rows bind" not in text and "solved for something else since" in text


def test_a_failing_solver_is_recorded_and_the_next_one_answers(punch, paper_cycle, monkeypatch):
    lying(monkeypatch, lambda _, name: "stopped" if name == "HIGHS" else None)
    limit = fo.shakedown_limit(punch(16), paper_cycle, 0.7)
    assert limit.record.solver == "CLARABEL" and [a.outcome for a in limit.record.attempts] == ["stopped", "optimal"]
    with pytest.raises(fo.SolverError, match=r"no answer within the tolerance 1e-09 \(HIGHS: stopped"):
        fo.shakedown_limit(punch(16), paper_cycle, 0.7, solver="HIGHS")


def test_a_wrong_answer_is_not_believed(punch, paper_cycle, monkeypatch):
    def slightly_wrong(problem, name):
        if name == "HIGHS":
            problem.var_dict["load_factor"].value = problem.var_dict["load_factor"].value * (1 + 1e-7)

    lying(monkeypatch, slightly_wrong)
    monkeypatch.setattr(policy, "polish", lambda problem: None)
    limit = fo.shakedown_limit(punch(16), paper_cycle, 0.7)
    assert limit.record.solver == "CLARABEL" and limit.record.attempts[0].residual > 1e-8


def test_a_false_claim_of_no_optimum_is_not_believed(punch, paper_cycle, monkeypatch):
    lying(monkeypatch, lambda problem, _: "infeasible" if "margin" not in problem.var_dict else None)
    with pytest.raises(fo.SolverError, match="HIGHS: infeasible, residual inf; CLARABEL"):
        fo.shakedown_limit(punch(16), paper_cycle, 0.7)


def test_the_problem_is_named_dpp_and_solved(punch, paper_cycle):
    problem = fo.shakedown_limit(punch(16), paper_cycle, 0.7).problem
    assert problem.status == cp.OPTIMAL and problem.is_dpp()
    assert set(problem.var_dict) == {"load_factor", "traction"}
    assert set(problem.param_dict) == {"friction", "forward_mean", "backward_mean", "forward", "backward"}
    assert [constraint.label for constraint in problem.constraints] == ["no_forward_slip", "no_backward_slip", "load_factor_not_negative"]


def test_explain_prints_names_sizes_units_and_binding_rows(punch, paper_cycle):
    printed = explained(fo.shakedown_limit(punch(16), paper_cycle, 0.7))
    said = ("load_factor", "traction", "no_backward_slip", "(DPP) yes", "unit", "rows bind", "mirror symmetry", "friction", "mechanism")
    assert all(part in printed for part in (*said, "\nparameters\n"))
    assert "closed form" in explained(fo.shakedown_limit(random_system(np.random.default_rng(0), 3, coupling=0.0), CYCLE, 0.4))
    of_one_solve = fo.shakedown_limit(random_contact(np.random.default_rng(0), 3), space_cycle(), 0.4)
    assert "\nparameters\n" not in explained(of_one_solve)


def test_a_sweep_is_one_compiled_problem(punch, paper_cycle):
    model = fo.ShakedownModel(punch(16), paper_cycle)
    table = model.sweep([0.3, 0.7, np.full(17, 0.7)])
    assert table.load_factor[1] == table.load_factor[2] == fo.shakedown_limit(punch(16), paper_cycle, 0.7).load_factor
    assert model.solve(0.3).problem is model.solve(0.5).problem
    assert list(table.columns) == ["friction", "load_factor", "least", "bound", "residual", "friction_rate", "node", "direction", "solver"]
