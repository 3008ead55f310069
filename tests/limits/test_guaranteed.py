"""The guaranteed limit and its witness against independent methods.

The methods are closed forms, linear programs over raw slips, and changes of the scene that leave
the limit unchanged or scale it.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.guaranteed import check, least_by_node, random_cycle
from helpers.liars import is_excess, lying, sloppy
from helpers.systems import (
    CYCLE,
    FIRST_PAIR,
    ONE_NODE,
    SECOND_PAIR,
    THREE,
    linprog_limit,
    random_system,
    system,
)

FIRST, SECOND = (FIRST_PAIR, 0.6, 0.391864153760), (SECOND_PAIR, 0.4, 0.532623169108)


@pytest.mark.parametrize("simplify", [True, False])
@pytest.mark.parametrize(
    ("data", "friction", "lower", "upper"),
    [
        (ONE_NODE, 0.4, 0.393145161290, 0.393145161290),
        ((1.0, 0.0, 0.0, 1.0, 1.0, 0.0), 0.5, 0.5, 0.5),
        (*FIRST, 0.726057393108),
        (*SECOND, 0.953695570335),
        (THREE, 0.4, 0.8, 0.8),
    ],
)
def test_published_instances(data, friction, lower, upper, simplify):
    contact = system(*data)
    limit, shakedown = (
        ask(contact, CYCLE, friction, simplify=simplify)
        for ask in (fo.guaranteed_limit, fo.shakedown_limit)
    )
    assert (limit.load_factor, shakedown.load_factor) == pytest.approx(
        (lower, upper), rel=1e-9, abs=1e-12
    )
    check(limit)
    if not contact.B.any():
        assert limit.proven and "uncoupled" in limit.reason and limit.record.solver == "HIGHS"


@settings(max_examples=few(12))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(2, 6),
    corners=st.integers(2, 5),
    f=st.floats(0.05, 1.5),
    most=st.sampled_from([None, 0.5, 3.0]),
)
def test_any_cycle_against_linear_programs_of_all_corners(seed, nodes, corners, f, most):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes, loads=("mean", "a", "b"))
    cycle = random_cycle(rng, corners)
    friction = f * rng.uniform(0.5, 1.5, nodes)
    status, shakedown = linprog_limit(contact, cycle, friction, most)
    if status == 2:
        limit = fo.guaranteed_limit(contact, cycle, friction, slip_bound=most)
        assert np.isnan(limit.load_factor)
        assert not limit.proven
        assert np.isnan(limit.reactions).all()
        assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
        return
    least = least_by_node(contact, cycle, friction, most)
    for simplify in (True, False):
        limit = fo.guaranteed_limit(contact, cycle, friction, slip_bound=most, simplify=simplify)
        assert limit.load_factor == pytest.approx(
            min(shakedown if status == 0 else np.inf, least.min()), rel=1e-8, abs=1e-9
        )
        if np.isfinite(limit.load_factor):
            check(limit)
            assert most is None or np.abs(limit.slip).max() <= most
        solved = limit.to_frame()[limit.to_frame().how == "solved"]
        assert solved.load_factor.to_numpy() == pytest.approx(
            least[solved.node], rel=1e-7, abs=1e-8
        )
        assert np.isinf(
            least[limit.to_frame().node[limit.to_frame().how == "never critical"]]
        ).all()
        out = limit.to_frame()[limit.to_frame().how == "left out by its bound"]
        assert (out.load_factor <= least[out.node] * (1 + 1e-8)).all()
    assert set(limit.to_frame().how) <= {"solved", "never critical", "one corner alone governs"}


@pytest.mark.parametrize("solver", ["HIGHS", "CLARABEL", "HIGHS_IPM"])
@pytest.mark.parametrize("ask", [fo.shakedown_limit, fo.guaranteed_limit])
def test_each_solver_alone_is_named(punch, paper_cycle, ask, solver):
    limit = ask(punch(12), paper_cycle, 0.5, solver=solver)
    assert limit.record.solver == solver
    assert {attempt.solver for attempt in limit.record.attempts} == {solver}
    assert limit.load_factor == pytest.approx(
        ask(punch(12), paper_cycle, 0.5).load_factor, rel=1e-8
    )


def test_a_wrong_answer_is_refined_and_a_false_denial_not_believed(punch, paper_cycle, monkeypatch):
    right = fo.guaranteed_limit(punch(16), paper_cycle, 0.5)
    lying(monkeypatch, sloppy(1e-6))
    limit = fo.guaranteed_limit(punch(16), paper_cycle, 0.5)
    assert limit.record.attempts[-1].outcome == "refined"
    assert limit.load_factor == pytest.approx(right.load_factor, rel=1e-8)
    # Only programs of single nodes have equations.
    lying(
        monkeypatch,
        lambda program, *_: "infeasible" if program.zero and not is_excess(program) else None,
    )
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.guaranteed_limit(punch(16), paper_cycle, 0.5)
