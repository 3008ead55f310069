"""Answers of programs as arrays: which solution is accepted, and what proves that there is none."""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.solve import answer, solvers
from helpers.arrays_of import arrays_of
from helpers.liars import lying, unpolished


@dataclass
class Claimed:
    """A claim with its residual."""

    residual: float


def tiny(kind, cone):
    """A program of a kind over x and its size t."""
    x, t = cp.Variable(2), cp.Variable()
    ball = cp.SOC(t, x) if cone else cp.abs(x) <= t
    rows = [ball, x[0] >= 2, x[1] <= 7]
    rows += {"infeasible": [t <= 1], "unbounded": [], "feasible": [t <= 3]}[kind]
    return arrays_of(cp.Problem(cp.Maximize(x[1 if kind == "infeasible" else 0]), rows))


def nothing_to_judge(x, y):
    pytest.fail("nothing to judge")


@pytest.mark.parametrize("cone", [False, True])
@pytest.mark.parametrize("kind", ["infeasible", "unbounded", "feasible"])
def test_that_there_is_no_optimum_is_proven(kind, cone):
    program = tiny(kind, cone)
    none, more = answer.infeasible(program), answer.unbounded(program)
    assert (none is not None, more is not None) == (kind == "infeasible", kind == "unbounded")
    if none:
        y, error = none
        assert np.abs(program.columns(y)).sum() < 1e-9 * -(program.right @ y) and error <= 1e-9
        assert np.array_equal(program.admissible(y), y)
    for outcome in (solvers.INFEASIBLE, solvers.UNBOUNDED):
        assert str(answer.without_optimum(program, outcome)) == str(none or more)


@pytest.mark.parametrize("kind", ["infeasible", "unbounded"])
def test_solvers_that_agree_on_no_optimum_are_not_believed_without_a_proof(kind):
    program = tiny(kind, False)
    for claim in (None, Claimed(1e-8)):
        with pytest.raises(solvers.NoOptimum):
            answer.answer(program, nothing_to_judge, no_optimum=lambda outcome, claim=claim: claim)
    claim, record = answer.answer(
        program, nothing_to_judge, no_optimum=lambda outcome: Claimed(1e-10)
    )
    assert claim.residual == record.residual == 1e-10


@pytest.mark.parametrize("failing", [None, 0, 1, 2])
def test_that_there_is_no_optimum_is_for_all_solvers_to_say(monkeypatch, failing):
    outcomes = iter(["stopped" if k == failing else "infeasible" for k in range(3)])
    lying(monkeypatch, lambda *_: next(outcomes))
    with pytest.raises(fo.SolverError) as end:
        answer.answer(tiny("feasible", False), nothing_to_judge)
    assert isinstance(end.value, solvers.NoOptimum) == (failing is None)


@pytest.mark.parametrize("over", [0.0, 1e-12])
def test_rows_that_rounding_parts_contradict_nothing(over):
    t = cp.Variable()
    assert answer.infeasible(arrays_of(cp.Problem(cp.Maximize(t), [t >= 1 + over, t <= 1]))) is None


@pytest.mark.parametrize("damage", ["unbalanced", "the wrong way", "none"])
@pytest.mark.parametrize("kind", ["infeasible", "feasible"])
def test_damaged_multipliers_contradict_nothing(kind, damage, monkeypatch):
    def damaged(program, name, x, y):
        changed = {"unbalanced": y + 1e-3 * np.arange(1, len(y) + 1), "the wrong way": -y}
        return np.ones(len(x)), changed.get(damage, 0 * y)

    lying(monkeypatch, damaged)
    unpolished(monkeypatch)
    assert answer.infeasible(tiny(kind, True)) is None


@pytest.mark.parametrize("value", [0.0, 5.0])
def test_a_contradiction_that_one_solver_gets_wrong_is_asked_of_the_next(value, monkeypatch):
    """The first solver returns zeros, or multipliers that do not balance but prove some excess."""
    names = set()

    def wrong(program, name, x, y):
        names.add(name)
        if len(names) > 1:
            return None
        x, y = 0 * x, 0 * y
        x[program.cost.astype(bool)] = value
        y[np.argmin(program.right)] = value / max(1.0, -program.right.min())
        return x, y

    lying(monkeypatch, wrong)
    unpolished(monkeypatch)
    assert answer.infeasible(tiny("infeasible", True)) is not None and len(names) > 1


@pytest.mark.parametrize("ray", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
def test_a_way_that_leaves_the_rows_or_leads_nowhere_is_no_growth(ray, monkeypatch):
    monkeypatch.setattr(answer, "growths", lambda program: [np.array(ray)])
    assert answer.unbounded(tiny("unbounded", True)) is None


@pytest.mark.parametrize("cone", [False, True])
def test_growth_needs_pressure_that_grows_and_values_to_begin_with(cone):
    q, p = cp.Variable(2), cp.Variable()
    rows = [cp.SOC(p, q) if cone else cp.max(cp.abs(q)) <= p, q[1] == 0]
    endless = cp.Maximize(q[0])
    for more, grows in (([], True), ([p <= 1], False), ([q[0] <= -1], False), ([q[1] >= 1], False)):
        program = arrays_of(cp.Problem(endless, [*rows, *more]))
        assert (answer.unbounded(program) is not None) == grows
    pulled = arrays_of(cp.Problem(cp.Maximize(p), [*rows, q[0] <= -1, q[0] >= 1]))
    assert answer.unbounded(pulled) is None and answer.infeasible(pulled) is not None


@pytest.mark.parametrize("cone", [False, True])
def test_multipliers_outside_their_cones_prove_no_bound(cone, monkeypatch):
    """All solvers return the least value as the largest one, with a multiplier of the wrong sign.

    These multipliers balance, and their bound is that value.
    """
    x = cp.Variable(2)
    row = cp.SOC(cp.Constant(1.0), x) if cone else cp.abs(x) <= 1.0
    program = arrays_of(cp.Problem(cp.Maximize(x[0]), [row]))

    def claimed(x, y):
        least, error = program.lower_bound(x, y)
        return Claimed(abs(program.cost @ x - least) + error)

    def wrong(program, name, x, y):
        y = np.zeros(len(program.right))
        against = np.argmax(program.matrix @ program.cost)
        y[[0, against] if cone else against] = -1.0
        least = np.zeros(len(program.cost))
        least[program.cost.astype(bool)] = -1.0
        return least, y

    with monkeypatch.context() as patch:
        unpolished(patch)
        lying(patch, wrong)
        with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
            answer.answer(program, claimed)
    assert answer.answer(program, claimed)[0].residual <= 1e-9
