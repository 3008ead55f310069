"""Uncoupled contacts whose normal loads are scaled, too: the load factors of rest.

They are compared with closed forms, plain programs, other searches, and transients from several
starts.
"""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import frictopt as fo
from frictopt.limits import (
    NoPath,
    limit_of_any_set,
    normal_path,
    piece_at,
    pieces,
    pose,
    rest_intervals,
)
from frictopt.limits.moving import normal_path as paths
from frictopt.limits.search.order_search import best_with_events
from frictopt.limits.shakedown import LIMITS
from helpers.cases import few
from helpers.systems import unit_nodes
from studies.validation.fuzz.embedded import embedded
from studies.validation.moving_areas import Case, ends
from studies.validation.rest_intervals import compared, contact

P = np.pi / 4  # half-width 1 of the cylinder with R = E_star = 1
F = 0.4


def node(A=1.0, C=1.0):
    return fo.ContactSystem.from_blocks(
        [[A]], [[0.0]], [[C]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    )


def path(*loads):
    return fo.LoadCycle({"P": 1.0}, [{"P": p, "Q": q} for p, q in loads])


LOOP = path((0.0, 0.0), (-1.0, 0.0), (-2.0, 0.1), (-2.0, -0.1), (-1.0, 0.0))


def cylinder(cells):
    return fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(cells, 1.6, 1.0, R=1.0))


def harmonic(phase, shear=0.1, corners=8):
    """Normal load of P +- P / 2 that leads the shear by a phase in degrees; both are scaled."""
    angles = 2 * np.pi * np.arange(corners) / corners
    pressed = 0.5 * np.cos(angles + np.deg2rad(phase))
    return fo.LoadCycle(
        {"P": P},
        [
            {"P": P * float(p), "Q": shear * P * float(q)}
            for p, q in zip(pressed, np.cos(angles), strict=True)
        ],
    )


def test_one_node_rests_on_two_intervals():
    """Its friction ends the first interval; from 1 on the node is open where its shear turns."""
    limit = fo.shakedown_limit(node(), LOOP, 0.5)
    assert limit.load_factor == pytest.approx(1 / 2.2) and not limit.proven
    assert_allclose(limit.intervals, [[0, 1 / 2.2], [1, np.inf]], rtol=1e-9)
    assert fo.guaranteed_limit(node(), LOOP, 0.5).load_factor == limit.load_factor


def test_one_node_slips_from_the_load_on_at_which_it_opens():
    """It opens at 1, and from there on it opens and closes under different shears."""
    cycle = path((-1.0, 0.01), (0.0, 0.0), (-1.0, -0.01), (0.0, 0.0))
    limit = fo.shakedown_limit(node(), cycle, 0.5)
    assert limit.load_factor == pytest.approx(1 / 1.02)
    loop = path((0.0, 0.0), (-1.0, 0.01), (-1.0, -0.01))
    early = fo.shakedown_limit(node(), loop, 100.0)
    assert early.load_factor == pytest.approx(1 / 1.0001)
    assert_allclose(early.intervals, [[0, early.load_factor]])


def test_a_node_that_opens_on_a_line_rests_at_every_load():
    """To and fro it opens and closes at one load; the size of its slip while it is open does not
    matter."""
    limit = fo.shakedown_limit(node(A=3.0), path((2.0, 0.5), (-2.0, -0.5)), 0.9)
    assert limit.load_factor == np.inf and "every load factor" in limit.reason
    assert limit.intervals.tolist() == [[0.0, np.inf]]
    # Below 1 / 2 it stays closed: |lam + x| <= f (1 + 2 lam) and |x - lam| <= f (1 - 2 lam). From
    # 1 / 2 on it carries lam + 1 / 2 at the first corner.
    weak = fo.shakedown_limit(node(A=3.0), path((2.0, 1.0), (-2.0, -1.0)), 0.45)
    assert_allclose(weak.intervals, [[0, 0.45]], rtol=1e-9)
    again = fo.shakedown_limit(node(A=3.0), path((2.0, 1.0), (-2.0, -1.0)), 0.49)
    assert again.load_factor == pytest.approx(0.49)


@pytest.mark.parametrize("cells", few([20, 40], least=1))
def test_in_phase_a_cylinder_rests_up_to_gross_slip(cells):
    system = cylinder(cells)
    known = F / (F * 0.5 + 0.1)
    for cycle in (harmonic(0.0), harmonic(0.0, corners=2)):
        limit = fo.shakedown_limit(system, cycle, F)
        assert limit.load_factor == pytest.approx(known, rel=1e-9) and limit.least == 0
        assert limit.proven and limit.bound_for_all == pytest.approx(known)
        assert limit.covers.startswith("states of rest just above it, for all openings")
        assert set(limit.events["event"]) == {"opens", "closes"}
        assert_allclose(limit.intervals, [[0, known]], rtol=1e-9)
    guaranteed = fo.guaranteed_limit(system, harmonic(0.0), F)
    assert guaranteed.load_factor == pytest.approx(known) and not guaranteed.proven


def open_nodes(C, reactions):
    """The open nodes of a line contact: opening one only takes pressure off the others."""
    opened = reactions < 0
    while True:
        gap = np.zeros(len(C))
        gap[opened] = np.linalg.solve(C[np.ix_(opened, opened)], -reactions[opened])
        pulled = (reactions + C @ gap < -1e-12) & ~opened
        if not pulled.any():
            return opened
        opened |= pulled


@pytest.mark.parametrize("phase", few([10, 45, 90], least=1))
def test_with_a_phase_a_cylinder_slips_from_the_load_on_at_which_its_first_node_opens(phase):
    system = cylinder(20)
    cycle = harmonic(phase)
    question = pose(system, cycle, F)
    low, high = 0.0, 1.0
    always = open_nodes(system.C, question.r0[0, -1])
    while high - low > 1e-9:
        middle = (low + high) / 2
        corners = (question.r0 + middle * question.r1)[:, -1]
        same = all((open_nodes(system.C, corner) == always).all() for corner in corners)
        low, high = (middle, high) if same else (low, middle)
    limit = fo.shakedown_limit(system, cycle, F)
    assert limit.load_factor == pytest.approx(low, rel=1e-6)
    assert "closes and opens under different shear loads" in limit.reason
    assert_allclose(limit.intervals, [[0, limit.load_factor]])
    steady = fo.steady_state(system, cycle, F, 1.05 * limit.load_factor)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP


@pytest.mark.parametrize("seed", few([*range(9000, 9012), *range(9100, 9140)]))
def test_random_contacts_rest_inside_of_their_intervals_and_slip_outside(seed):
    *_, wrong = compared(seed)
    assert not wrong


def two_nodes(pressures, P, Q):
    """Two nodes that do not know of each other, with mean pressures, and cyclic loads of node 1."""
    loads = {"mean": (np.zeros(2), pressures), "P": ([0, 0], [0, P]), "Q": ([0, Q], [0, 0])}
    return unit_nodes(loads)


TO_AND_FRO = fo.LoadCycle({"mean": 1.0}, [{"P": 1.0, "Q": 1.0}, {"P": -1.0, "Q": -1.0}])


def test_a_limit_that_is_nearly_zero_has_its_interval():
    """Node 1 has hardly any pressure, and its shear grows faster than its friction bound. By hand,
    0.5 lam + x <= f (p + 0.1 lam) and 0.5 lam - x <= f (p - 0.1 lam), so that lam = 2 f p."""
    system = two_nodes([1.0, 1e-13], 0.1, 0.5)
    limit = fo.shakedown_limit(system, TO_AND_FRO, 0.5)
    assert 0 <= limit.load_factor < 1e-11
    assert limit.intervals.tolist() == [[0.0, limit.load_factor]]
    assert fo.steady_state(system, TO_AND_FRO, 0.5, 0.01).outcome is fo.Outcome.CYCLIC_SLIP


def test_a_limit_with_a_node_that_never_touches_covers_all_openings():
    """The mean load pulls node 0 open. By hand, node 1 has 0.5 lam + x <= 0.5 (1 + 0.2 lam) and 0.5
    lam - x <= 0.5 (1 - 0.2 lam), so that its limit is 1. Above it every start slips."""
    system = two_nodes([-1.0, 1.0], 0.2, 0.5)
    for events in (False, True):
        limit = fo.shakedown_limit(system, TO_AND_FRO, 0.5, events=events)
        assert limit.load_factor == pytest.approx(1.0) and limit.open.tolist() == [True, False]
        assert limit.covers.startswith("states of rest just above it, for all openings")
    case = Case(system, TO_AND_FRO, np.full(2, 0.5), "by hand")
    assert set(ends(case.arguments, 1.01, 4)) == {"CYCLIC_SLIP"}
    assert set(ends(case.arguments, 0.99, 4)) == {"SHAKEDOWN"}
    limit_of_set = fo.shakedown_limit(system, TO_AND_FRO, 0.5, open_nodes=limit.open)
    assert "the contact may shake down above it" in limit_of_set.covers


def test_a_pressure_that_keeps_its_value_bounds_no_load_factor():
    """In the last piece the node that stays closed has one pressure at an event of the other node,
    and the rate of this pressure is rounding. Transients from several starts rest far above the
    last event."""
    case = contact(9248)
    limit = fo.shakedown_limit(*case.arguments)
    assert limit.load_factor == np.inf and limit.intervals.tolist() == [[0.0, np.inf]]
    assert set(ends(case.arguments, 40.0, 4)) == {"SHAKEDOWN"}


@pytest.mark.parametrize("seed", few(range(9200, 9218, 3)))
def test_to_and_fro_the_search_of_events_has_the_same_limit(seed):
    case = contact(seed)
    assert case.kind == "to and fro"
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction)
    settled = limit_of_any_set(pose(case.system, case.cycle, case.friction))
    searched = best_with_events(LIMITS, settled)
    assert searched.load_factor == pytest.approx(limit.load_factor, rel=1e-7)


@pytest.mark.parametrize("seed", few(range(9300, 9312)))
def test_a_contact_in_the_plane_has_its_intervals_in_space(seed):
    case = contact(seed)
    plane = fo.shakedown_limit(case.system, case.cycle, case.friction)
    # Across the plane something holds the open nodes, too.
    turned, _ = embedded(case.system, np.random.default_rng([7509, seed]), across=case.system.A)
    space = fo.shakedown_limit(turned, case.cycle, case.friction)
    assert space.load_factor == pytest.approx(plane.load_factor, rel=1e-7)
    assert_allclose(space.intervals, plane.intervals, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("seed", few([15, *range(15), 16, 17]))  # 15 has a piece from 342 on
def test_pressures_and_gaps_of_a_piece_are_those_of_each_load_factor(seed):
    case = contact(9400 + seed)
    question = pose(case.system, case.cycle, case.friction)
    at_zero, scaled = question.r0[0, -1], question.r1[:, -1]
    rng = np.random.default_rng(seed)
    before = 0.0
    for areas in pieces(question):
        piece = areas.path
        # Pieces follow each other without a hole.
        assert piece.low == pytest.approx(before, abs=1e-6)
        before = piece.high
        end = min(piece.high, 2 * piece.low + 1)
        load_factor = piece.low + rng.uniform(0.05, 0.95) * (end - piece.low)
        if end - piece.low < 1e-4:
            continue
        path = normal_path(case.system.C, at_zero + load_factor * scaled)
        events = (path.part == 0) | (np.roll(path.presses, 1, axis=0) ^ path.presses).any(axis=1)
        assert_allclose(piece.part(load_factor), path.part[events], atol=1e-7)
        values = ((piece.pressure, path.pressure), (piece.gap, path.gap))
        for affine, known in values:
            assert_allclose(affine[0] + load_factor * affine[1], known[events], atol=1e-8)
    assert before == np.inf


def test_a_body_that_lifts_off_ends_the_load_factors():
    system = cylinder(8)
    question = pose(system, harmonic(0.0, shear=0.0), F)
    assert max(areas.path.high for areas in pieces(question)) == pytest.approx(2.0)
    with pytest.raises(NoPath):
        piece_at(system.C, question.r0[0, -1], question.r1[:, -1], 2.1)
    limit = fo.shakedown_limit(system, harmonic(0.0, shear=0.0), F)
    assert limit.load_factor == pytest.approx(2.0) and "lift a body off" in limit.reason


def moving_case():
    """A contact with nodes that come and go at its limit."""
    system, cycle = cylinder(12), harmonic(0.0, corners=2)
    return system, cycle, fo.shakedown_limit(system, cycle, F)


def test_the_state_of_the_limit_rests_and_files_keep_it(tmp_path):
    system, cycle, limit = moving_case()
    below = 0.999 * limit.load_factor
    steady = fo.steady_state(system, cycle, F, below, initial_slip=limit.slip)
    assert steady.outcome is fo.Outcome.SHAKEDOWN
    gaps = steady.states().gap
    partly = (gaps.min(axis=0) <= 1e-9) & (gaps.max(axis=0) > 1e-9)
    assert partly.any() and set(np.flatnonzero(partly)) == set(limit.events["node"])
    limit.save(tmp_path / "limit.npz")
    for again in (fo.results.load(tmp_path / "limit.npz"), pickle.loads(pickle.dumps(limit))):
        assert again.reason == limit.reason and again.covers == limit.covers
        assert again.events.equals(limit.events)


def test_the_rate_with_friction_is_that_of_differences():
    system, cycle, limit = moving_case()
    step = 1e-6
    slope = (fo.shakedown_limit(system, cycle, F + step).load_factor - limit.load_factor) / step
    assert limit.friction_rate.sum() == pytest.approx(slope, rel=1e-4)


def test_closed_contacts_keep_their_limit():
    flat = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(8, 1.0, 1.0))
    cycle = fo.LoadCycle({"P": P}, [{"Q": -0.3, "P": 0.1}, {"Q": 0.3, "P": -0.2}])
    limit = fo.shakedown_limit(flat, cycle, F)
    closed = fo.shakedown_limit(flat, cycle, F, open_nodes=np.zeros(8, dtype=bool))
    assert limit.load_factor == closed.load_factor and limit.reason.startswith(closed.reason)
    assert_allclose(limit.intervals[0], [0, limit.load_factor])


def test_intervals_of_shear_alone_of_static_loads_and_of_coupled_contacts():
    shear = fo.LoadCycle({"P": P}, [{"Q": -0.3}, {"Q": 0.3}])
    limit = fo.shakedown_limit(cylinder(8), shear, F)
    assert limit.intervals.tolist() == [[limit.least, limit.load_factor]]
    static = fo.shakedown_limit(node(), path((-2.0, 0.3)), F)
    assert static.load_factor == np.inf and static.intervals.tolist() == [[0.0, np.inf]]
    coupled = fo.ContactSystem.from_blocks(
        [[2.0]], [[0.5]], [[2.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    )
    with pytest.raises(fo.ModelError, match="intervals: nodes may open and close"):
        _ = fo.shakedown_limit(coupled, LOOP, 0.5).intervals


def test_held_loads_that_begin_too_large_are_safe_later():
    """A free body slides under its mean shear until the cyclic load presses it."""
    system = cylinder(8)
    cycle = fo.LoadCycle({"P": P, "Q": 0.5 * P}, [{"P": 2 * P}, {"P": 4 * P}])
    limit = fo.shakedown_limit(system, cycle, F)
    # 0.5 = f (1 + 2 lam) at the corner with less pressure.
    assert limit.intervals[0, 0] == pytest.approx((0.5 / F - 1) / 2)
    assert limit.least == pytest.approx(limit.intervals[0, 0]) and limit.load_factor == np.inf


def test_a_piece_ends_where_two_nodes_open_at_the_same_place_of_the_segment():
    """By hand: node 0 opens at 1 / (2 lambda), node 1 at 3 / (8 lambda) + 1 / 8; equal at 1."""
    C = np.eye(2)
    at_zero = np.array([1.0, 1.5])
    scaled = np.array([[0.0, 0.5], [-2.0, -3.5]])
    below = piece_at(C, at_zero, scaled, 0.9)
    above = piece_at(C, at_zero, scaled, 1.1)
    assert below.high == pytest.approx(1.0, rel=1e-12)
    assert above.low == pytest.approx(1.0, rel=1e-12)


def test_a_node_that_opens_and_closes_under_shears_that_never_agree_slips_from_there_on():
    """By hand: it opens under a shear of 0.05 and closes under 0.1 + 0.2 lambda.

    The two are equal only at a load factor below 0, where the node stays closed.
    """
    cycle = path((0.0, 0.0), (-2.0, 0.1), (-2.0, 0.4), (0.0, 0.2))
    ((least, largest),) = fo.shakedown_limit(node(), cycle, 0.5).intervals
    assert least == 0.0
    assert largest < 0.5


@pytest.mark.parametrize(("least", "joins"), [(0.5, True), (0.5 + 1e-7, True), (0.7, False)])
def test_rests_join_only_without_a_hole_between_them(least, joins):
    current = SimpleNamespace(largest=0.5, areas=SimpleNamespace(load_unit=1.0))
    assert rest_intervals._joins(current, SimpleNamespace(least=least)) is joins


@pytest.mark.parametrize(("low", "high", "may"), [(0.5, 2.0, True), (1.5, 2.0, False)])
def test_a_rim_that_can_rest_at_one_load_factor_rests_only_in_its_piece(low, high, may):
    """The forces that the equations leave vanish at the load factor 1."""
    unsolved = np.array([[-1.0, -2.0], [1.0, 2.0]])
    areas = SimpleNamespace(unsolved=unsolved, path=SimpleNamespace(low=low, high=high))
    assert rest_intervals._rim_may_rest(areas) is may


def test_a_piece_ends_where_two_instants_meet():
    """Their places times the load factor are 1/10 + lambda / 5 and 1/2 + lambda / 10.

    They meet at 4. The second one is at the end of the segment at 5/9.
    """
    part = np.array([0.0, 0.3, 0.6])
    place = np.array([[0.0, 0.1, 0.5], [0.0, 0.2, 0.1]])
    nothing = np.zeros((2, 3, 1))
    assert paths._ends(part, place, nothing, nothing, 1.0) == pytest.approx((5 / 9, 4.0))
