from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.paths import followed
from helpers.systems import CYCLE, FIRST_PAIR, PULL, system

NODE = {"A": 2.0, "B": 0.5, "q0": 0.1, "p0": 1.0, "q1": 1.0, "p1": 0.2}


def corners(contact, cycle, friction, load_factor, start, cycles):
    """(K, N) slips and gaps at the corners of the last of some cycles."""
    path = followed(contact, cycle, friction, load_factor, start, cycles=cycles - 1)
    states = []
    for number, corner in enumerate(path.corners):
        path.follow_to(corner, f"to corner {number}")
        states.append(path.state.u.copy())
    return np.split(np.array(states) + np.r_[np.zeros(contact.nodes), contact.gap], 2, axis=1)


def test_one_node_slips_as_much_as_the_closed_form_says():
    f, one = 0.4, system(**NODE)
    limit = fo.shakedown_limit(one, CYCLE, f)
    for ratio in (1.1, 1.5):
        lam = ratio * limit.load_factor
        (A, B, q0, p0, q1, p1) = NODE.values()
        forward = (-(q0 + f * p0) + lam * abs(q1 + f * p1)) / (A + f * B)
        backward = (f * p0 - q0 - lam * abs(q1 - f * p1)) / (A - f * B)
        least = limit.least_slip(lam)
        table = least.to_frame()
        assert table["alone"].item() == pytest.approx(forward - backward, rel=1e-9)
        assert [table[f"g at {name}"].item() for name in CYCLE.corner_names] == least.g[
            :, 0
        ].tolist()
        assert least.total == pytest.approx(forward - backward, rel=1e-9)
        assert least.of([[forward], [backward]]) == pytest.approx(least.bound, rel=1e-9)


def test_it_is_sharp_on_the_punch_and_names_its_edges():
    scene = fo.scenes.PunchOnHalfPlane(elements=16).condense()
    limit = fo.shakedown_limit(scene, PULL, 0.7)
    least = limit.least_slip(1.5 * limit.load_factor)
    slip, gap = corners(scene, PULL, 0.7, least.load_factor, limit.slip, 40)
    assert not gap.any() and least.of(slip) == pytest.approx(least.bound, rel=1e-9)
    assert least.to_frame()["node"][0] in (0, 16)  # of mirror images the mechanism may be one
    assert np.ptp(slip, axis=0).sum() >= least.total > 0


def test_a_contact_that_only_lifts_off_has_no_closed_cycle_above_its_limit():
    # One corner governs both bounds.
    limit = fo.shakedown_limit(system(2.0, 0.5, 0.1, 1.0, 0.1, 1.0), CYCLE, 0.4)
    least = limit.least_slip(1.2 * limit.load_factor)
    assert least.total == np.inf
    assert not least.weight.any()
    assert not len(least.to_frame())
    assert least.residual <= 1e-9
    slip, gap = corners(
        system(2.0, 0.5, 0.1, 1.0, 0.1, 1.0), CYCLE, 0.4, least.load_factor, None, 5
    )
    assert gap.any() and least.of(slip, gap) >= least.bound * (1 - 1e-9)


def test_below_the_limit_it_says_nothing_and_keeps_its_sign():
    limit = fo.shakedown_limit(system(*FIRST_PAIR), CYCLE, 0.6)
    least = limit.least_slip(0.5 * limit.load_factor)
    assert least.bound == pytest.approx(-0.5 * limit.load_factor)
    assert least.total == 0.0
    assert not least.to_frame()["alone"].any()


def test_limits_that_prove_nothing_are_refused():
    contact = system(*FIRST_PAIR)
    model = fo.ShakedownModel(contact, CYCLE)
    for limit in (
        fo.shakedown_limit(contact, CYCLE, 0.6, slip_bound=0.5),
        fo.shakedown_limit(contact, fo.LoadCycle({"mean": 1.0}, [{}]), 0.6),
        model.solve(0.6, [model.slip[0] == 0]),
    ):
        with pytest.raises(fo.ModelError, match="least_slip"):
            limit.least_slip(1.0)
    with pytest.raises(fo.ModelError, match="shape"):
        model.solve(0.6).least_slip(1.0).of([0.1, 0.2])


def test_multipliers_that_do_not_balance_prove_nothing():
    """Multipliers that do not balance leave no lower bound of the slip.

    Either their net slip stresses the contact by a millionth, or the limit is not proven to the
    tolerance.
    """
    contact = system(*FIRST_PAIR)
    limit = fo.shakedown_limit(contact, CYCLE, 0.6)
    moves = limit._motion.moves.copy()
    moves[np.unravel_index(np.abs(moves[:, :1]).argmax(), moves[:, :1].shape)] *= 1 + 1e-6
    with pytest.raises(
        fo.SolverError, match=r"least slip: the multipliers of the limit are off by .*e-0[67]"
    ):
        replace(limit, _motion=replace(limit._motion, moves=moves)).least_slip(1.0)
    with pytest.raises(fo.SolverError, match=r"off by 2\.0e-09"):
        replace(limit, record=replace(limit.record, residual=2e-9)).least_slip(1.0)
