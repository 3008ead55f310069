"""Safe slips and required friction of nodes that open and close in each cycle.

They are compared with limits, plain programs and transients.
"""

from functools import cache

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.liars import misread
from helpers.orders import largest_round_a_cycle, there_and_back
from helpers.separation import pulled_system, rests, with_events
from helpers.systems import CYCLE, random_system

PIN = fo.LoadCycle({"fit": 1.0}, [{"Fx": -1.0}, {"Fx": 1.0}])


@pytest.fixture(scope="module")
def pin():
    return fo.scenes.PinInPlate(elements=8).condense()


def margin_in_order(safe, start, events):
    """By a plain program, in the units of a safe slip."""
    question = safe._question
    return largest_round_a_cycle(
        safe.system,
        safe.cycle,
        safe.friction,
        start,
        there_and_back(events),
        at=safe.load_factor,
        margin=(question.mean_bound, question.clearance),
    )


def drawn(seed):
    """A random contact with nodes that the loads lift off, and a friction."""
    rng = np.random.default_rng([41, seed])
    return pulled_system(rng, 3), float(rng.uniform(0.2, 0.8))


@cache
def opening(count):
    """Limits of random contacts whose nodes open and close in each cycle."""
    asked = (drawn(seed) for seed in range(60 + 20 * count))
    return with_events(
        (fo.shakedown_limit(contact, CYCLE, friction, events=True) for contact, friction in asked),
        count,
    )


@pytest.mark.parametrize("share", few([0.5, 0.9, 0.7, 0.999]))
def test_a_pin_has_the_safe_slip_of_a_plain_program_and_rests_with_it(share, pin):
    load_factor = share * fo.shakedown_limit(pin, PIN, 0.8, events=True).load_factor
    safe = fo.safe_slip(pin, PIN, 0.8, load_factor, events=True)
    assert safe.exists and safe.margin == pytest.approx(safe.bound, abs=1e-9)
    if share > 0.5:  # there all nodes stay closed
        assert not fo.safe_slip(pin, PIN, 0.8, load_factor).exists
        assert safe.margin == pytest.approx(
            margin_in_order(safe, *safe._question.order[:2]), abs=1e-7
        )
        assert (
            f"open and close in each cycle: {safe.events['node'].nunique()} (events)" in safe.reason
        )
        assert not safe.events.empty
    assert fo.steady_state(pin, PIN, 0.8, load_factor, initial_state=safe.state).dissipation < 1e-9
    assert rests(pin, PIN, 0.8, load_factor, initial_slip=safe.slip)


def test_a_small_load_factor_may_need_another_order_than_the_limit():
    """With the order of the limit no slip is safe there. A plain program and a transient agree."""
    contact, friction = drawn(17)
    static, moving = (
        fo.shakedown_limit(contact, CYCLE, friction, events=events).load_factor
        for events in (False, True)
    )
    load_factor = static + 0.05 * (moving - static)
    safe = fo.safe_slip(contact, CYCLE, friction, load_factor, events=True)
    assert safe.exists
    order = safe._question.order[:2]
    assert safe.margin == pytest.approx(margin_in_order(safe, *order), abs=1e-7)
    assert rests(contact, CYCLE, friction, load_factor, initial_slip=safe.slip)


def test_the_margin_falls_by_the_rate_of_friction(pin):
    load_factor, step = 3.6, 1e-5
    low, at, high = (
        fo.safe_slip(pin, PIN, 0.8 + by, load_factor, events=True) for by in (-step, 0.0, step)
    )
    assert at._question.events and low._question.order == at._question.order == high._question.order
    force = at._question.mean_bound  # the unit follows friction
    slope = (high.margin * high._question.mean_bound - low.margin * low._question.mean_bound) / (
        2 * step
    )
    assert at.friction_rate * force == pytest.approx(slope, rel=1e-3)


def test_required_friction_agrees_with_the_limit_from_both_sides():
    for limit in opening(few(2, 1)):
        required = fo.required_friction(limit.system, CYCLE, limit.load_factor, events=True)
        assert required.required <= limit.friction[0] * (1 + 1e-5)
        enough, less = (
            fo.shakedown_limit(limit.system, CYCLE, f, events=True).load_factor
            for f in (required.required, required.bound)
        )
        assert enough >= limit.load_factor * (1 - 1e-9) > less * (1 - 1e-9)


def test_an_uncoupled_contact_that_lifts_off_rests_from_every_start_or_from_none():
    """By the theorem for uncoupled contacts, all starts come to rest wherever a state with events
    is safe with a margin."""

    def drawn(seed):
        rng = np.random.default_rng([53, seed])
        uncoupled = random_system(rng, 3, coupling=0.0)
        shear = uncoupled.bonded["cyclic"][0]
        contact = uncoupled.with_bonded({"cyclic": (shear, rng.normal(size=3))})
        return fo.shakedown_limit(contact, CYCLE, 0.5, events=True)

    rng = np.random.default_rng(53)
    for limit in with_events(map(drawn, range(60)), few(3)):
        contact = limit.system
        safe = fo.safe_slip(contact, CYCLE, 0.5, 0.95 * limit.load_factor, events=True)
        starts = 2 * rng.normal(size=(3, 3))
        assert safe.margin > 0
        assert all(
            rests(contact, CYCLE, 0.5, safe.load_factor, initial_slip=start) for start in starts
        )
        assert not any(
            rests(contact, CYCLE, 0.5, 1.02 * limit.load_factor, initial_slip=start)
            for start in starts
        )


@pytest.mark.parametrize("wrong", [0, 1], ids=["margin", "place of an event"])
def test_the_referee_sees_events_elsewhere_and_a_margin_above_the_reserve(wrong, pin, monkeypatch):
    """The last program of a safe slip with events has its margin first, and then the places."""
    told = []
    misread(monkeypatch, lambda program, x, y: told.append(len(x)))
    honest = fo.safe_slip(pin, PIN, 0.8, 3.6, events=True)
    assert honest.residual < 1e-9 and len(honest.events)
    last = len(told)

    def lie(program, x, y):
        told.append(len(x))
        if len(told) >= 2 * last:
            x[wrong] += 1e-3

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.safe_slip(pin, PIN, 0.8, 3.6, events=True)
