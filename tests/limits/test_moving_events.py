"""Limits with nodes that open and close on any segment of a cycle.

The limits are compared with closed forms, plain linear programs of the same order of events, and
transients.
"""

from functools import cache

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.orders import largest_round_a_cycle, there_and_back
from helpers.screens import seen
from helpers.separation import pulled_system, rests, with_events
from studies.validation.fuzz.embedded import embedded
from studies.validation.moving_events import FRICTION as F
from studies.validation.moving_events import (
    IN_PHASE,
    ROLLS,
    contact,
    cylinder,
    limits_of_two_materials,
)
from studies.validation.moving_events import PRESS as P


def test_an_order_that_only_a_start_away_from_the_limit_shows_is_found():
    """From the state of the limit and from no slip, transients just above the limit slip for ever.

    From a slip beside it they come to rest, with a node that opens and closes.
    """
    case = contact(9001, "there and back")
    without_events = fo.shakedown_limit(*case.arguments)
    above = 1.01 * without_events.load_factor
    slip = without_events.slip - 0.2 * np.eye(case.system.nodes)[0]
    assert rests(*case.arguments, above, initial_slip=slip)
    assert not rests(*case.arguments, above, initial_slip=without_events.slip)
    limit = fo.shakedown_limit(*case.arguments, events=True)
    assert limit.load_factor > above and set(limit.events["node"]) == {1}
    assert rests(*case.arguments, 0.999 * limit.load_factor, initial_state=limit.state)


def definite(rng, size):
    """A random stiffness."""
    factor = rng.normal(size=(size, size))
    return factor @ factor.T / size + 0.4 * np.eye(size)


@cache
def coupled(seed, kind):
    return contact(seed, kind).arguments


@cache
def limit_of(seed, kind):
    return fo.shakedown_limit(*coupled(seed, kind), events=True)


def opening(kind, count):
    """Random contacts whose limit has nodes that open and close, with these limits."""
    limits = with_events((limit_of(seed, kind) for seed in range(60 + 20 * count)), count)
    return [(limit.system, limit.cycle, limit.friction, limit) for limit in limits]


def by_plain_program(limit):
    order = limit._question.order
    segments = order.segments or (0,) * len(order.events)
    return largest_round_a_cycle(
        limit.system,
        limit.cycle,
        limit.friction,
        order.start,
        list(zip(segments, order.events, strict=True)),
    )


@pytest.mark.parametrize(
    ("cells", "half_length", "shear", "press"), [(20, 1.62, 0.2, 0.4), (26, 1.5, 0.3, 0.45)]
)
def test_a_cylinder_sticks_up_to_gross_slip_in_phase(cells, half_length, shear, press):
    """Shear grows less than friction times pressure: nothing slips until all nodes slip."""
    cycle = fo.LoadCycle.harmonic({"Q": shear * F * P, "P": press * P}, mean={"P": P})
    limit = fo.shakedown_limit(cylinder(cells, half_length), cycle, F, events=True)
    assert limit.load_factor == pytest.approx(1 / (shear + press), rel=1e-9)
    assert limit.least == 0 and len(limit.events) > 4


def test_twins_have_the_limit_of_one_of_them():
    """Nothing couples the two contacts, and the multipliers belong to one of them."""
    gains = 0
    for seed in few(range(24)):
        rng = np.random.default_rng([75, 1, seed])
        nodes = int(rng.integers(2, 4))
        S = definite(rng, 2 * nodes)
        none = np.zeros(nodes)
        loads = {"P": (none, rng.uniform(0.3, 1.5, nodes))}
        loads["Q"] = 0.5 * rng.normal(size=nodes), rng.normal(size=nodes)
        cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
        limits = []
        for copies in (1, 2):
            blocks = [
                np.kron(np.eye(copies), block)
                for block in (S[:nodes, :nodes], S[nodes:, :nodes], S[nodes:, nodes:])
            ]
            bonded = {
                name: (np.tile(q, copies), np.tile(p, copies)) for name, (q, p) in loads.items()
            }
            x = np.arange(float(copies * nodes))
            system = fo.ContactSystem.from_blocks(*blocks, x, bonded)
            limits.append(fo.shakedown_limit(system, cycle, 0.4, events=True))
        one, twins = limits
        assert twins.load_factor == pytest.approx(one.load_factor, rel=1e-7, nan_ok=True)
        gains += not one.events.empty
    assert gains > 0


def test_a_node_that_opens_twice_has_two_slips():
    """Node 0 opens, then node 1 opens and its gap presses node 0 shut again, under another shear
    load. Both rest at any load factor, so that node 2 gives the limit 2 f p / q."""
    C = np.array([[1.0, 0.85, 0.0], [0.85, 1.0, 0.0], [0.0, 0.0, 1.0]])
    loads = {"P": ([0, 0, 0], [0.25, 1.1, 1.0]), "D": ([0.12, 0.0, 0.2], [-1.0, -2.8, 0.0])}
    system = fo.ContactSystem.from_blocks(np.eye(3), np.zeros((3, 3)), C, [0.0, 1.0, 2.0], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{}, {"D": 1.0}])
    limit = fo.shakedown_limit(system, cycle, 0.4, events=True)
    assert limit.load_factor == pytest.approx(4.0, rel=1e-9)
    assert limit.events[["node", "event"]].values.tolist() == [
        [0, "opens"],
        [1, "opens"],
        [0, "closes"],
    ]
    # By hand: node 0 opens where its pressure is zero, node 1 with the gap of node 0.
    places = limit.events["way"].to_numpy() * limit.load_factor
    assert places == pytest.approx([0.25, 0.8875 / 1.95, 0.685 / 1.38], rel=1e-9)
    rng = np.random.default_rng(5)
    for start in [None, *0.3 * rng.normal(size=(2, 3))]:
        assert rests(system, cycle, 0.4, 3.98, initial_slip=start)
        assert not rests(system, cycle, 0.4, 4.02, initial_slip=start)
    rests_above = fo.steady_state(
        system, cycle, 0.4, (1 - 1e-9) * limit.load_factor, initial_state=limit.state
    )
    assert rests_above.dissipation < 1e-9


def test_turning_points_on_a_line_change_nothing():
    """The ends of the line stand for any history of one load."""
    found = 0
    for seed in [10, 11, 14, 15, *few(range(60))]:
        rng = np.random.default_rng([75, 2, seed])
        system = pulled_system(rng, int(rng.integers(2, 4)))
        between = rng.uniform(-0.9, 0.7, size=4)
        turning = [{"cyclic": float(part)} for part in (*between[:2], 0.8, -1.0, *between[2:])]
        many = fo.LoadCycle({"mean": 1.0}, turning)
        two = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 0.8}, {"cyclic": -1.0}])
        limit = fo.shakedown_limit(system, many, 0.5, events=True)
        known = fo.shakedown_limit(system, two, 0.5, events=True)
        assert limit.load_factor == pytest.approx(known.load_factor, rel=1e-9, nan_ok=True)
        assert limit.events["way"].to_numpy() == pytest.approx(known.events["way"].to_numpy())
        if limit.kind is fo.LimitKind.FINITE and not limit.events.empty:
            assert limit.least == 0 and limit.cycle == many
            steady = fo.steady_state(
                system, many, 0.5, (1 - 1e-9) * limit.load_factor, initial_state=limit.state
            )
            assert steady.dissipation < 1e-9
            # The last turning point is somewhere on the line. Its forces are those of its load.
            bonded = np.concatenate(system.reaction(many.at(limit.load_factor)[-1]))
            moved = np.concatenate([limit.state.slip, limit.state.gap - system.gap])
            forces = np.concatenate([part[-1] for part in limit.reactions])
            assert forces == pytest.approx(bonded + system.S @ moved, abs=1e-7)
            found += 1
    assert found > 3


def test_a_measured_history_of_one_load_may_have_events():
    system = pulled_system(np.random.default_rng([75, 2, 3]), 2)
    history = pd.DataFrame({"mean": 1.0, "cyclic": [0.0, 0.7, 0.1, 0.8, -1.0, 0.3]})
    cycle = fo.LoadCycle.from_history(history, mean={"mean": 1.0})
    two = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 0.8}, {"cyclic": -1.0}])
    limit = fo.shakedown_limit(system, cycle, 0.5, events=True)
    assert len(cycle.corners) > 2
    assert limit.load_factor == pytest.approx(
        fo.shakedown_limit(system, two, 0.5, events=True).load_factor, rel=1e-9
    )


@pytest.mark.parametrize("kind", ["there and back", "static shear"])
def test_orders_round_a_cycle_against_a_plain_program_and_transients(kind):
    slips = 0
    for system, cycle, friction, limit in opening(kind, few(12)):
        assert limit.load_factor == pytest.approx(by_plain_program(limit), rel=1e-6)
        assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
        below = (1 - 1e-6) * limit.load_factor
        steady = fo.steady_state(system, cycle, friction, below, initial_state=limit.state)
        assert steady.outcome is fo.Outcome.SHAKEDOWN and steady.dissipation < 1e-8
        above = 1.02 * limit.load_factor
        slips += not rests(system, cycle, friction, above, initial_state=limit.state)
        sets = fo.shakedown_limit(system, cycle, friction)
        assert not sets.load_factor > limit.load_factor * (1 + 1e-9)
    # Above a limit other states of rest may exist; most starts do not find them.
    assert slips > 0.7 * few(12)


def test_required_friction_round_a_cycle():
    """The required friction of a cycle with events is enough, and its lower bound is not.

    Transients and safe slips agree. The search is local: more friction than needed may hide the
    order of events that rests with less.
    """
    reached = 0
    contacts = opening("there and back", few(6, 3))[::-1]  # the search in the third is short
    for system, cycle, friction, _ in contacts[: few(6, 1, 6)]:
        mean = float(friction.mean())
        known = fo.shakedown_limit(system, cycle, mean, events=True).load_factor
        required = fo.required_friction(system, cycle, known, events=True)
        reached += required.required == pytest.approx(mean, rel=1e-5)
        enough = fo.safe_slip(system, cycle, required.required, known, events=True)
        assert enough.exists
        assert rests(system, cycle, required.required, known, initial_state=enough.state)
        assert not fo.safe_slip(system, cycle, required.bound, known, events=True).exists
    assert reached > 0


def asked_with_events(*case):
    return fo.shakedown_limit(*case, events=True).load_factor


def test_where_the_load_encloses_an_area_no_events_are_searched():
    """Events need a load for which a node closes at the bonded reactions at which it opens (lemma)."""
    for seed in few(range(6)):
        case = coupled(seed, "around an area")
        assert "events: " not in seen(lambda case=case: asked_with_events(*case))
        assert asked_with_events(*case) == pytest.approx(
            fo.shakedown_limit(*case).load_factor, rel=1e-12, nan_ok=True
        )
    assert "events: " in seen(lambda: asked_with_events(*coupled(0, "there and back")))


@pytest.mark.parametrize(
    ("beta", "in_phase", "rolling"),
    few([(0.05, 0.13030, 0.19692), (0.2, 0.00317, 0.18594), (0.1, 0.08730, 0.19401)]),
)
def test_a_cylinder_of_two_materials(beta, in_phase, rolling):
    """Fixed and scaled loads both vary in phase, so that the program has products, and proves no
    bound."""
    two_bodies = cylinder(20, 1.6, beta)
    limit = fo.shakedown_limit(two_bodies, IN_PHASE, F, events=True)
    assert limit.load_factor == pytest.approx(in_phase, abs=5e-6)
    assert limit.bound == np.inf and np.isnan(limit.least)
    assert "no bound is proven" in limit.reason and "infinite" in limit.covers
    # The printed product is linear about the answer, where nothing is gained.
    assert limit.problem.solve(solver="HIGHS") == pytest.approx(limit.load_factor, rel=1e-6)
    order = limit._question.order
    for share, exists in ((0.999, True), (1.001, False)):
        rest = largest_round_a_cycle(
            two_bodies,
            IN_PHASE,
            limit.friction,
            order.start,
            there_and_back(order.events),
            at=share * limit.load_factor,
        )
        assert (rest is not None) == exists
        assert rests(two_bodies, IN_PHASE, F, share * limit.load_factor) == exists

    two_bodies = cylinder(20, 1.8, beta)
    limit = fo.shakedown_limit(two_bodies, ROLLS, F, events=True)
    assert limit.load_factor == pytest.approx(rolling, abs=5e-6)
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-9) and limit.least == 0
    for share, exists in ((0.99, True), (1.01, False)):
        assert rests(two_bodies, ROLLS, F, share * limit.load_factor) == exists


def test_a_small_limit_is_found():
    """The transient under the fixed loads opens twin nodes at once, and shows no order of events."""
    two_bodies = cylinder(20, 1.6, 0.18)
    limit = fo.shakedown_limit(two_bodies, IN_PHASE, F, events=True)
    assert limit.load_factor == pytest.approx(0.02001, abs=5e-6)
    for share, exists in ((0.999, True), (1.001, False)):
        assert rests(two_bodies, IN_PHASE, F, share * limit.load_factor) == exists


def test_the_table_of_two_materials():
    table = limits_of_two_materials([0.0, 0.25])
    assert table["in_phase"].to_numpy() == pytest.approx([F / 2, np.nan], rel=1e-9, nan_ok=True)
    assert table["rolls"].to_numpy() == pytest.approx([0.19699, 0.17956], abs=5e-6)


def test_a_cylinder_of_two_very_different_materials_slips_under_its_pressure_alone():
    limit = fo.shakedown_limit(cylinder(20, 1.6, 0.3), IN_PHASE, F, events=True)
    assert np.isnan(limit.load_factor) and "no transient at a small load factor" in limit.reason
    assert not rests(cylinder(20, 1.6, 0.3), IN_PHASE, F, 0.0)


def test_a_reason_says_where_to_ask_for_events():
    two_bodies = cylinder(20, 1.6, 0.1)
    for cycle, advised in ((IN_PHASE, True), (ROLLS, True)):
        limit = fo.shakedown_limit(two_bodies, cycle, F)
        assert np.isnan(limit.load_factor)
        assert ("pass events=True" in limit.reason) == advised
    angles = np.deg2rad([0, 90, 180, 270])
    around = fo.LoadCycle(
        {"P": P},
        [{"Q": 0.4 * P * np.cos(a)} for a in angles],
        fixed=[{"P": 0.2 * P * np.sin(a)} for a in angles],
    )
    assert "events=True" not in fo.shakedown_limit(two_bodies, around, F).reason
    bounded = fo.shakedown_limit(two_bodies, IN_PHASE, F, slip_bound=1.0)
    assert "events=True" not in bounded.reason


def test_a_plane_contact_has_the_same_limit_round_a_cycle_in_space():
    system, cycle, friction, limit = opening("there and back", 1)[0]
    rng = np.random.default_rng(1)
    solid = embedded(system, rng)[0]
    space = fo.shakedown_limit(solid, cycle, friction, events=True)
    assert space.load_factor == pytest.approx(limit.load_factor, rel=1e-5)
