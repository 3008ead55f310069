"""The guaranteed limit and its solvers: whose answer counts, what is believed, and what a result carries."""

import gc
import weakref

import highspy
import numpy as np
import pytest

import frictopt as fo
from frictopt.solve import LP_SOLVERS
from frictopt.solve import solvers as policy
from systems import explained


@pytest.mark.parametrize("solver", LP_SOLVERS)
@pytest.mark.parametrize("ask", [fo.shakedown_limit, fo.guaranteed_limit])
def test_each_solver_alone_is_named(punch, paper_cycle, ask, solver):
    limit = ask(punch(16), paper_cycle, 0.5, solver=solver)
    assert limit.record.solver == solver and {attempt.solver for attempt in limit.record.attempts} == {solver}
    assert limit.load_factor == pytest.approx(ask(punch(16), paper_cycle, 0.5).load_factor, rel=1e-8)


def test_a_wrong_answer_is_refined_and_a_false_denial_not_believed(punch, paper_cycle, monkeypatch):
    run, right = policy._run, fo.guaranteed_limit(punch(16), paper_cycle, 0.5)

    def sloppy(problem, name):
        outcome = run(problem, name)
        rng = np.random.default_rng(0)
        for variable in problem.variables():
            variable.save_value(variable.value + 1e-6 * rng.normal(size=variable.shape))
        return outcome

    monkeypatch.setattr(policy, "_run", sloppy)
    limit = fo.guaranteed_limit(punch(16), paper_cycle, 0.5)
    assert limit.record.attempts[-1].outcome == "refined on the vertex" and limit.load_factor == pytest.approx(right.load_factor, rel=1e-8)

    def denies(problem, name):
        outcome = run(problem, name)
        return "infeasible" if "node_rows" in problem.param_dict and "excess" not in problem.var_dict else outcome

    monkeypatch.setattr(policy, "_run", denies)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.guaranteed_limit(punch(16), paper_cycle, 0.5)


def test_the_problem_is_named_dpp_and_compiled_once(punch, paper_cycle):
    model = fo.GuaranteedModel(punch(16), paper_cycle, slip_bound=10.0)
    first, second = model.solve(0.3), model.solve(0.5)
    assert first.problem is second.problem and first.problem.is_dpp()
    labels = ["load_factor_not_negative", "forward_slip_bound", "backward_slip_bound", "no_forward_slip", "no_backward_slip", "critical"]
    assert [constraint.label for constraint in first.problem.constraints] == labels
    text = explained(second)
    assert "critical" in text and "2 of 2 rows bind" in text and f"{second.load_factor:.12g}" in text


def test_no_solver_outlives_its_answer(punch, paper_cycle, monkeypatch):
    """A solver holds copies of its program, which for a thousand nodes take more than the program."""
    alive, made = weakref.WeakSet(), []

    class Watched(highspy.Highs):
        def __init__(self):
            super().__init__()
            alive.add(self)
            made.append(None)

    monkeypatch.setattr(highspy, "Highs", Watched)
    limit = fo.guaranteed_limit(punch(16), paper_cycle, 0.5)
    gc.collect()
    assert made and limit.problem is not None and not len(alive)
