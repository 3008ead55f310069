"""The guaranteed limit against exact transients.

Just above the limit slip from the witness never stops; just below it slip from no start continues.
"""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, FIRST_PAIR, random_system, system
from studies.validation.verify import verify


@pytest.mark.parametrize(("nodes", "seed"), [(2, 0), (3, 1), (4, 2)])
def test_random_systems(nodes, seed):
    rng, starts = np.random.default_rng(seed), few(500)
    contact = random_system(rng, nodes, loads=("mean", "a", "b"))
    cycle = fo.LoadCycle(
        {"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(nodes, 2))]
    )
    check = verify(fo.guaranteed_limit(contact, cycle, 0.4), starts=starts)
    assert check.dies_out
    assert check.persists
    assert check.undecided == 0
    assert len(check.counterexamples) == 0
    assert "wedge" not in check.limit.reason
    runs = check.runs
    assert len(runs) == len(check.starts) == starts + 6 and (runs.share < 1).sum() == starts
    assert set(runs.start) == {"witness", "moved witness", "vertex", "beyond vertex", "random"}
    assert runs.dissipation[runs.share < 1].eq(0).all()
    assert runs.dissipation[0] > 0
    assert runs.moved[0] == 0
    assert runs.moved[runs.start == "moved witness"].between(0, 1e-3, inclusive="right").all()


@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_the_papers_scene(punch, paper_cycle, friction):
    check = verify(fo.guaranteed_limit(punch(16), paper_cycle, friction), starts=40, moved=2)
    assert check.dies_out and check.persists and check.undecided == 0


def test_a_limit_that_is_too_high_is_found_out():
    """Between lambda_1 and lambda_2 the start decides. With lambda_2 in the place of lambda_1, some
    starts keep slipping below it."""
    contact = system(*FIRST_PAIR)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.6)
    fake = replace(limit, load_factor=limit.shakedown.load_factor, slip=limit.shakedown.slip)
    check = verify(fake, starts=100)
    assert not check.dies_out and 0 < len(check.counterexamples) < 100
    again = fo.steady_state(
        contact, CYCLE, 0.6, check.runs.load_factor.iloc[-1], initial_slip=check.counterexamples[0]
    )
    assert again.outcome is fo.Outcome.CYCLIC_SLIP


def test_a_witness_that_is_none_does_not_persist():
    contact = system(*FIRST_PAIR)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.6)
    fake = replace(
        limit, slip=fo.safe_slip(contact, CYCLE, 0.6, limit.shakedown.load_factor * 0.9).slip
    )
    check = verify(fake, starts=0)
    assert not check.persists and check.dies_out and len(check.runs) == 6


@pytest.mark.parametrize("tangents", [1, 2])
def test_a_node_above_its_critical_friction_may_wedge_itself(tangents):
    """The shear +- lam is held by f (1 + B v). At lam = f both bounds are met without slip; above
    it slips v >= (lam - f) / (f B - 1) relieve both bounds."""
    S, still = np.eye(tangents + 1), [0.0] * (tangents - 1)
    S[0, -1] = S[-1, 0] = 0.8
    node = fo.ContactSystem(
        S, [[0.0] * (tangents + 1)], {"P": [0.0, *still, 1.0], "Q": [1.0, *still, 0.0]}
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    limit = fo.guaranteed_limit(node, cycle, friction=2.0)
    assert limit.load_factor == pytest.approx(2.0, rel=1e-9)
    assert limit.shakedown.load_factor == np.inf
    assert "wedge itself" in limit.reason
    # Increments in space may jump to another state that obeys the law.
    assert tangents == 2 or not verify(limit, starts=0).persists
    assert fo.safe_slip(node, cycle, 2.0, 2.2).slip.ravel()[0] >= 0.2 / 0.6 - 1e-9


def test_rounding_of_a_rigid_slide_is_no_stiffness(punch, paper_cycle):
    """In matrices that another code condensed, rounding may resist the free sliding of the punch."""
    exact, rng = punch(16), np.random.default_rng(0)
    noise = 1e-13 * np.abs(exact.A).max() * rng.normal(size=exact.A.shape)
    rounded = fo.ContactSystem.from_blocks(
        exact.A + noise + noise.T, exact.B, exact.C, exact.x, exact.bonded
    )
    check = verify(fo.guaranteed_limit(rounded, paper_cycle, 0.5), starts=10, moved=1)
    assert check.dies_out and check.persists and {"vertex", "random"} < set(check.runs.start)


def test_without_guarantee_only_the_side_above_is_tested(punch, paper_cycle):
    contact = punch(32)
    limit = fo.guaranteed_limit(contact, paper_cycle, 0.8)
    assert limit.load_factor == 0 < limit.shakedown.load_factor
    check = verify(limit, starts=50, moved=1)
    assert len(check.runs) == 4 and check.persists and np.isinf(check.runs.share).all()


@pytest.mark.parametrize(
    ("mean", "corners", "shown"),
    [({"P": 1.0}, [{"P": 0.5}], "inf"), ({"P": -1.0}, [{"Q": 1.0}, {"Q": -1.0}], "nan")],
)
def test_without_a_finite_shakedown_limit_the_overload_needs_a_load_factor(mean, corners, shown):
    node = fo.ContactSystem.from_blocks(
        [[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    )
    limit = fo.guaranteed_limit(node, fo.LoadCycle(mean, corners), 0.5)
    with pytest.raises(fo.ModelError, match=rf"^limit: its shakedown limit is {shown}.*`load_fac"):
        fo.after_overload(limit)
