"""Limits of contacts whose nodes open and close in each cycle.

They are compared with plain programs for every order of events, closed forms, transients, and plane
contacts turned into space.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import Question
from helpers.cases import few
from helpers.interrupts import interrupted
from helpers.orders import every_order, largest_round_a_cycle, there_and_back
from helpers.separation import pulled_system, rests, with_events
from helpers.systems import CYCLE, all_closed, random_system, system
from studies.validation.fuzz.embedded import embedded

PIN = fo.LoadCycle({"fit": 1.0}, [{"Fx": -1.0}, {"Fx": 1.0}])
MOST = 30.0


@pytest.fixture(scope="module")
def pin():
    return cache(lambda elements: fo.scenes.PinInPlate(elements=elements).condense())


def best_of_all_orders(contact, friction):
    found = [
        largest_round_a_cycle(contact, CYCLE, friction, start, there_and_back(events))
        for start, events in every_order(contact.nodes)
    ]
    return max((factor for factor in found if factor is not None), default=np.nan)


@pytest.mark.parametrize(
    ("elements", "friction", "all_closed", "expected_limit", "opening"),
    few([(8, 0.8, 2.683, 4.041, 6), (16, 0.5, 2.437, 2.968, 6), (16, 1.0, 2.587, 4.730, 10)]),
)
def test_a_pin_rests_though_its_sides_lift_off_in_each_cycle(
    elements, friction, all_closed, expected_limit, opening, pin
):
    """The numbers are the table of the theory page. A plain program of the same order of events and
    transients agree."""
    contact = pin(elements)
    limit = fo.shakedown_limit(contact, PIN, friction, events=True)
    closed = fo.shakedown_limit(contact, PIN, friction)
    assert (closed.load_factor, limit.load_factor) == pytest.approx(
        (all_closed, expected_limit), abs=5e-4
    )
    assert limit.load_factor > 1.2 * closed.load_factor
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-9)
    assert len(limit.events) == opening
    assert limit.events["way"].is_monotonic_increasing
    assert not limit.open.any()
    start, events, _ = limit._question.order
    largest = largest_round_a_cycle(contact, PIN, friction, start, there_and_back(events))
    assert largest == pytest.approx(limit.load_factor, rel=1e-7)
    assert rests(contact, PIN, friction, 0.9999 * limit.load_factor, initial_slip=limit.slip)
    assert not rests(contact, PIN, friction, 1.001 * limit.load_factor, initial_slip=limit.slip)
    assert f"{opening} nodes that open and close in this order" in limit.reason
    assert "another order" in limit.covers
    assert (
        fo.steady_state(
            contact, PIN, friction, limit.load_factor * (1 - 1e-6), initial_state=limit.state
        ).dissipation
        < 1e-9
    )


def test_forces_at_the_last_corner_are_those_of_the_stiffness(pin):
    """The forces at the last corner are `r + S (slip, gap)`.

    The open nodes at the last corner are others than at the first corner.
    """
    contact = pin(16)
    limit = fo.shakedown_limit(contact, PIN, 0.5, events=True)
    bonded = contact.reaction(PIN.at(limit.load_factor)[-1])
    q, p = np.split(
        np.concatenate(bonded) + contact.S @ np.concatenate([limit.state.slip, limit.state.gap]), 2
    )
    for found, right in zip(limit.reactions, (q, p), strict=True):
        assert found[-1] == pytest.approx(right, abs=1e-9 * np.abs(p).max())
    assert (np.abs(p) > 1e-6).any() and (limit.state.gap > 0).any()


def test_the_cycle_that_is_followed_opens_the_nodes_where_the_limit_says(pin):
    contact = pin(16)
    limit = fo.shakedown_limit(contact, PIN, 0.5, events=True)
    steady = fo.steady_state(
        contact, PIN, 0.5, limit.load_factor * (1 - 1e-9), initial_state=limit.state
    )
    gaps = steady.states().gap
    first, second = gaps.min(axis=0) > -1e-9, gaps.max(axis=0) > 1e-9
    assert first.all() and set(np.flatnonzero(second)) == set(limit.events["node"])


@pytest.mark.parametrize(
    ("draw", "nodes", "seeds"),
    [
        (random_system, 2, [9, 18, *range(9), *range(10, 18), 19]),
        (pulled_system, 2, [1, 0, *range(2, 8)]),
        (pulled_system, 3, range(6)),
    ],
)
def test_small_contacts_against_every_order(draw, nodes, seeds):
    opening = 0
    # In the first one nodes open and close.
    for seed in [seeds[0], *few(seeds[1:], 3)]:
        rng = np.random.default_rng(seed)
        contact, friction = draw(rng, nodes), float(rng.uniform(0.1, 1.0))
        limit = fo.shakedown_limit(contact, CYCLE, friction, events=True)
        assert min(limit.load_factor, MOST) == pytest.approx(
            best_of_all_orders(contact, friction), rel=1e-6, nan_ok=True
        )
        opening += not limit.events.empty
        if limit.kind is fo.LimitKind.FINITE and not limit.events.empty:
            assert rests(
                contact, CYCLE, friction, 0.999 * limit.load_factor, initial_slip=limit.slip
            )
    assert opening > 0


def test_one_node_on_a_vertical_spring_opens_and_never_slips():
    contact = system(1.0, 0.0, 0.0, 2.0, 0.0, 1.0, C=[[3.0]])
    limit = fo.shakedown_limit(contact, CYCLE, 0.5, events=True)
    assert limit.kind is fo.LimitKind.UNBOUNDED
    assert all_closed(contact, CYCLE, 0.5).load_factor == pytest.approx(2.0)
    assert limit.events[["node", "event"]].values.tolist() == [[0, "closes"]]
    assert "every load factor" in limit.reason
    assert fo.limit_after_protocol(limit, start=np.zeros(1), up_to=100.0).upper == np.inf


def test_rates_of_a_load_at_each_corner_count_the_events_between():
    """The shear and the pressure of the load are two load cases: at an event their rates balance."""
    rng = np.random.default_rng([41, 17])
    drawn, friction = pulled_system(rng, 3), float(rng.uniform(0.2, 0.8))
    q, p = drawn.bonded["cyclic"]
    contact = drawn.with_bonded({"shear": (q, 0 * p), "press": (0 * q, p)})
    corners = [{"shear": sign, "press": sign} for sign in (-1.0, 1.0)]

    def limit_of(corners):
        cycle = fo.LoadCycle({"mean": 1.0}, corners)
        return fo.shakedown_limit(contact, cycle, friction, events=True)

    limit, step = limit_of(corners), 1e-5
    assert not limit.events.empty
    table = limit.load_rates.set_index(["load", "part"])["rate"]
    for k, name in enumerate(limit.cycle.corner_names):
        for case in ("shear", "press"):
            lower, upper = (
                limit_of(
                    [
                        {**loads, case: loads[case] + by * (k == j)}
                        for j, loads in enumerate(corners)
                    ]
                ).load_factor
                for by in (-step, step)
            )
            slope = (upper - lower) / (2 * step)
            assert table[case, name] == pytest.approx(slope, rel=1e-3, abs=1e-5)


@pytest.mark.parametrize("seed", few([6, 2], 1))
def test_a_plane_contact_has_the_same_limit_in_space(seed):

    def drawn(number):
        rng = np.random.default_rng([seed, number])
        contact, friction = pulled_system(rng, 3), float(rng.uniform(0.2, 0.8))
        return fo.shakedown_limit(contact, CYCLE, friction, events=True)

    for limit in with_events(map(drawn, range(40)), few(3, 1)):
        turned, _ = embedded(limit.system, np.random.default_rng(seed))
        solid = fo.shakedown_limit(turned, CYCLE, limit.friction, events=True)
        assert solid.load_factor == pytest.approx(limit.load_factor, rel=1e-6)
        assert solid.events["node"].tolist() == limit.events["node"].tolist()


def test_questions_without_events_are_refused(pin):
    contact, model = pin(8), fo.ShakedownModel(pin(8), PIN)
    for question, why in (
        (
            lambda: fo.shakedown_limit(contact, PIN, 0.8, slip_bound=1.0, events=True),
            "slip is bounded",
        ),
        (
            lambda: fo.required_friction(contact, PIN, 1.0, slip_bound=1.0, events=True),
            "slip is bounded",
        ),
        (lambda: model.solve(0.8, [model.load_factor <= 1], events=True), "cannot be combined"),
        (
            lambda: model.solve(0.8, open_nodes=np.zeros(8, dtype=bool), events=True),
            "cannot be combined",
        ),
        (lambda: model.solve(0.8, events="yes"), "True or False"),
        (lambda: fo.shakedown_limit(contact, PIN, 0.8, open_nodes=np.zeros(8)), "each of 8 nodes"),
        (
            lambda: fo.shakedown_limit(contact, PIN, 0.8, open_nodes=np.ones(8, dtype=bool)),
            "leave more nodes closed",
        ),
    ):
        with pytest.raises(fo.ModelError, match=why):
            question()


def test_least_slip_refuses_nodes_that_open_and_close(pin):
    with pytest.raises(fo.ModelError, match="use shakedown_limit without events"):
        fo.shakedown_limit(pin(8), PIN, 0.8, events=True).least_slip(5.0)


def test_the_referee_sees_nodes_that_carry_where_they_open_and_events_in_no_order(pin, monkeypatch):
    limit = fo.shakedown_limit(pin(8), PIN, 0.8, events=True)
    question, way, state = limit._question, limit._question.way, (limit.load_factor, limit.slip)
    later, back = way.copy(), way.copy()
    later[2] += 0.05
    back[-1] = way[-2] - 10.0
    assert question.violation(*state) < 1e-9
    touching = sorted(question.order.events[1])
    carried = (
        np.abs(replace(question, way=later).instants(*state)[1][2][:, touching]).max()
        / question.force
    )
    assert carried > 1e-3 and replace(question, way=later).violation(*state) >= carried
    assert replace(question, way=back).violation(*state) >= 10.0
    # The law alone sees most events in no order.
    monkeypatch.setattr(Question, "violation", lambda *_: 0.0)
    assert question.violation(*state) < 1e-9
    assert replace(question, way=back).violation(*state) == pytest.approx(10.0)


@pytest.mark.parametrize("programs", [2, 3])
def test_an_interrupted_search_keeps_the_best_limit_by_then(programs, pin):
    """Each order of events is better than the order it came from. The returned limit is judged as
    every limit is, and the progress bar counts programs."""
    with interrupted("events", programs) as caught:
        fo.shakedown_limit(pin(16), PIN, 1.0, events=True)
    limit = caught.value.limit
    assert "attribute `limit`" in caught.value.__notes__[0]
    assert 2.5871 < limit.load_factor < 4.7303
    assert rests(pin(16), PIN, 1.0, 0.999 * limit.load_factor, initial_slip=limit.slip)
