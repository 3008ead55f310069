import numpy as np
import pytest

import frictopt as fo
from helpers.liars import is_excess, lying, misread, sloppy, unpolished
from helpers.systems import (
    at_corners,
    explained,
    linprog_limit,
    random_system,
    stress_of,
    unit_nodes,
)


def test_refinement_restores_an_answer_that_a_solver_leaves_inaccurate(
    punch, paper_cycle, monkeypatch
):
    lying(monkeypatch, sloppy(1e-5))
    limit = fo.shakedown_limit(punch(40), paper_cycle, 0.7)
    assert [attempt.outcome for attempt in limit.record.attempts] == ["optimal", "refined"]
    assert limit.record.attempts[0].residual > 1e-7 and limit.residual < 1e-10


@pytest.mark.parametrize("simplify", [True, False])
@pytest.mark.parametrize("corners", [3, 24])
def test_corners_that_rule_no_node_are_counted_and_change_nothing(punch, corners, simplify):
    """The corners are on an ellipse, and one is within it. A plain program with the rows of all
    corners gives the same limit."""
    angles = np.r_[2 * np.pi * np.arange(corners) / corners, 0.3]
    sizes = np.r_[np.ones(corners), 0.4]
    loads = [
        {"sigma": size * float(np.cos(a)), "Q": 0.3 * size * float(np.sin(a))}
        for a, size in zip(angles, sizes, strict=True)
    ]
    cycle = fo.LoadCycle({"P": 1.0}, loads)
    limit = fo.shakedown_limit(punch(16), cycle, 0.7, simplify=simplify)
    assert limit.load_factor == pytest.approx(linprog_limit(punch(16), cycle, 0.7)[1], rel=1e-7)
    stuck = [row for row in limit.problem.constraints if str(row.label).startswith("stuck")]
    assert len(stuck) == corners + (not simplify) and {row.size for row in stuck} == {17}
    assert (
        f"corners: 1 of {corners + 1} are within the hull of the others" in limit.record.left_out
    ) == simplify
    q, p = at_corners(punch(16), cycle, limit.load_factor, limit.slip)
    assert (0.7 * p - np.abs(q)).min() == pytest.approx(0.0, abs=1e-9)


def test_friction_changed_by_hand_to_zero_leaves_no_tension():
    """The cyclic load lifts node 0, p = 1 - lam, and shears node 1. Without friction at node 0 the
    limit is min(1, 10 f)."""
    loads = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.0, 0.1], [1.0, 0.0])}
    two = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    problem = fo.shakedown_limit(two, cycle, 0.5, open_nodes=[False, False]).problem
    for friction, right in (([0.0, 0.5], 1.0), ([0.0, 0.02], 0.2), ([1e-9, 0.5], 1.0)):
        problem.param_dict["f"].value = np.array(friction)
        assert problem.solve(solver="HIGHS") == pytest.approx(right, rel=1e-6)


def test_many_corners_take_memory_for_their_loads_alone():
    """There are three nodes and 20,000 corners. Rows of all of them would be a program of 120,000
    rows."""
    rng = np.random.default_rng(0)
    contact = random_system(rng, 3, loads=("mean", "a", "b"))
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(20_000, 2))]
    )
    limit = fo.shakedown_limit(contact, cycle, 0.4)
    assert sum(str(row.label).startswith("stuck") for row in limit.problem.constraints) < 100
    q, p = at_corners(contact, cycle, limit.load_factor, limit.slip)
    assert (0.4 * p - np.abs(q)).min() == pytest.approx(0.0, abs=1e-9)


def test_the_mechanism_is_a_proof(punch, paper_cycle):
    """The slips in the table of the mechanism prove the limit.

    Their shares add up to one, they do no work on any residual slip, and they bound the load from
    above.
    """
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
    lying(monkeypatch, lambda _, name, x, y: "stopped" if name == "HIGHS" else None)
    limit = fo.shakedown_limit(punch(12), paper_cycle, 0.7)
    assert limit.record.solver == "CLARABEL"
    assert [a.outcome for a in limit.record.attempts] == ["stopped", "optimal"]
    with pytest.raises(
        fo.SolverError, match=r"no answer within the tolerance 1e-09 \(HIGHS: stopped"
    ):
        fo.shakedown_limit(punch(12), paper_cycle, 0.7, solver="HIGHS")


def test_a_wrong_answer_is_not_believed(punch, paper_cycle, monkeypatch):
    lying(monkeypatch, lambda _, name, x, y: ((1 + 1e-7) * x, y) if name == "HIGHS" else None)
    with monkeypatch.context() as patch:
        unpolished(patch)
        limit = fo.shakedown_limit(punch(12), paper_cycle, 0.7)
    assert limit.record.solver == "CLARABEL" and limit.record.attempts[0].residual > 1e-8


@pytest.mark.parametrize("wrong", ["load_factor", "slip", "proof"])
def test_an_answer_that_is_wrong_in_one_respect_is_not_believed(
    wrong, punch, paper_cycle, monkeypatch
):
    """An answer with one wrong quantity is refused, whatever the program and its polish return.

    The stiffness judges the slip, and the multipliers judge the limit.
    """
    load_factors = []

    def lie(program, x, y):
        load_factors.append(x[0])
        if wrong == "load_factor":
            x[0] *= 1 + 1e-6
        elif wrong == "slip":
            x[1:] *= 1 + 1e-6
        else:
            y[::2] *= 1 + 1e-6

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.shakedown_limit(punch(16), paper_cycle, 0.7)
    assert load_factors


def test_a_false_claim_of_no_optimum_is_not_believed(punch, paper_cycle, monkeypatch):
    lying(monkeypatch, lambda program, *_: None if is_excess(program) else "infeasible")
    with pytest.raises(fo.SolverError, match="HIGHS: infeasible, residual inf; CLARABEL"):
        fo.shakedown_limit(punch(16), paper_cycle, 0.7)


def test_a_sweep_has_the_limit_of_each_friction(punch, paper_cycle):
    model = fo.ShakedownModel(punch(16), paper_cycle)
    table = model.sweep([0.3, 0.7, np.full(17, 0.7)])
    assert (
        table.load_factor[1]
        == table.load_factor[2]
        == fo.shakedown_limit(punch(16), paper_cycle, 0.7).load_factor
    )
    assert {model.load_factor, model.slip} < {*model.solve(0.3).problem.variables()}
    assert list(table.columns) == [
        "friction",
        "load_factor",
        "least",
        "bound",
        "residual",
        "friction_rate",
        "node",
        "direction",
        "solver",
    ]
