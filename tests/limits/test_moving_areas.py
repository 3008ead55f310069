"""Uncoupled contacts whose normal loads open and close nodes.

The limits are compared with closed forms, plain programs, and transients from several starts.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

import frictopt as fo
from frictopt.limits import NoPath, moving_areas, normal_path, pose
from helpers.cases import few
from helpers.systems import unit_nodes
from studies.validation.fuzz.embedded import embedded
from studies.validation.moving_areas import compared, contact

F = 0.35
P = np.pi / 4  # half-width 1 of the cylinder with R = E_star = 1


def cylinder(cells, half_length):
    """A cylinder on a half-plane, with a load case that rolls it by its amplitude."""
    system = fo.ContactSystem.from_blocks(
        **fo.reference.half_plane_contact(cells, half_length, 1.0, R=1.0)
    )
    return system.with_bonded({**system.bonded, "roll": (0 * system.x, system.C @ system.x)})


def harmonic(phase, corners=8):
    """Shear of 0.4 P, and normal load of 0.2 P that leads by a phase in degrees."""
    angles = 2 * np.pi * np.arange(corners) / corners
    pressed = np.cos(angles + np.deg2rad(phase))
    return fo.LoadCycle(
        {"P": P},
        [{"Q": 0.4 * P * np.cos(angle)} for angle in angles],
        fixed=[{"P": 0.2 * P * part} for part in pressed],
    )


def of_all_states(limit):
    assert limit.covers == "all states of rest, for all openings and closings"
    assert limit.bound_for_all == pytest.approx(limit.load_factor, rel=1e-9, abs=1e-12)
    return limit.proven


@pytest.mark.parametrize("cells", few([20, 160]))
def test_a_cylinder_in_phase_sticks_up_to_friction_times_the_ratio_of_the_amplitudes(cells):
    """Q1 = 0.4 P is twice P1 = 0.2 P."""
    two = fo.LoadCycle(
        {"P": P}, [{"Q": -0.4 * P}, {"Q": 0.4 * P}], fixed=[{"P": -0.2 * P}, {"P": 0.2 * P}]
    )
    for cycle in (two, harmonic(0.0)):
        limit = fo.shakedown_limit(cylinder(cells, 1.6), cycle, F)
        assert limit.load_factor == pytest.approx(F * 0.2 / 0.4, abs=1e-10)
        assert of_all_states(limit) and limit.least == 0
        assert len(limit.events) and set(limit.events["event"]) == {"opens", "closes"}


def test_a_rolling_cylinder_has_its_limit_on_160_cells():
    roll = 0.35
    cycle = fo.LoadCycle({"P": P}, [{"Q": P}] * 2, fixed=[{"roll": -roll}, {"roll": roll}])
    limit = fo.shakedown_limit(cylinder(160, 1.8), cycle, F)
    known = F * (1 - 2 / np.pi * (roll * np.sqrt(1 - roll**2) + np.arcsin(roll)))
    assert limit.load_factor == pytest.approx(known, rel=5e-5)
    assert of_all_states(limit)


@pytest.mark.parametrize("seed", few(range(6)))
def test_rolling_and_pressing_at_random_leaves_the_least_pressure_of_each_node(seed):
    rng = np.random.default_rng([7501, seed])
    system = cylinder(24, 1.9)
    corners = int(rng.integers(2, 7))
    fixed = [
        {"roll": rng.uniform(-0.4, 0.4), "P": rng.uniform(-0.3, 0.3) * P} for _ in range(corners)
    ]
    cycle = fo.LoadCycle({"P": P}, [{"Q": P}] * corners, fixed=fixed)
    limit = fo.shakedown_limit(system, cycle, F)
    q, p = np.array(limit._instants[1]), np.array(limit._instants[2])
    assert limit.load_factor == pytest.approx(F * p.min(axis=0).sum() / P, rel=1e-12)
    assert_allclose(q.sum(axis=1), limit.load_factor * P, rtol=1e-11)


@pytest.mark.parametrize("phase", [10, 45, 90])
def test_a_phase_leaves_no_limit_and_its_transients_slip(phase):
    system = cylinder(20, 1.6)
    limit = fo.shakedown_limit(system, harmonic(phase), F)
    assert limit.load_factor == 0 and limit.kind is fo.LimitKind.FINITE and of_all_states(limit)
    comes_and_goes = limit.events["node"].unique()
    assert limit.mechanism["node"].iloc[0] in comes_and_goes
    assert "steady_state" in limit.reason
    assert any(
        f"node {node} closes and opens under different shear loads" in limit.reason
        for node in comes_and_goes
    )
    steady = fo.steady_state(system, harmonic(phase), F, 0.001)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP and steady.dissipation > 0


def test_the_guaranteed_limit_is_the_same_number_and_proven_if_bodies_are_held():
    for system, cycle, held in (
        (cylinder(20, 1.6), harmonic(0.0), False),
        (contact(2).system, contact(2).cycle, True),
    ):
        guaranteed = fo.guaranteed_limit(system, cycle, F)
        limit = fo.shakedown_limit(system, cycle, F)
        assert guaranteed.load_factor == limit.load_factor
        assert guaranteed.proven is held and guaranteed.node is None
        assert ("observed in transients, not proven" in guaranteed.reason) is not held
        assert set(guaranteed.to_frame()["how"]) <= {
            "not needed",
            "one corner alone governs",
            "open",
        }


# A node of 9101 opens twice in each cycle, and presses at its beginning.
@pytest.mark.parametrize("seed", few([9101, *range(9000, 9012), 9100, *range(9102, 9140)]))
def test_random_contacts_rest_just_below_and_slip_just_above_from_every_start(seed):
    *_, wrong = compared(seed)
    assert not wrong


@pytest.mark.parametrize("seed", few(range(9200, 9212)))
def test_a_contact_in_the_plane_has_its_limit_in_space(seed):
    case = contact(seed)
    plane = fo.shakedown_limit(case.system, case.cycle, case.friction)
    # Across the plane something holds the open nodes, too.
    turned, _ = embedded(case.system, np.random.default_rng([7503, seed]), across=case.system.A)
    space = fo.shakedown_limit(turned, case.cycle, case.friction)
    assert space.load_factor == pytest.approx(plane.load_factor, rel=1e-7, abs=1e-9, nan_ok=True)
    assert len(space.events) == len(plane.events) and space.kind is plane.kind


def test_held_shear_that_differs_leaves_all_load_factors_or_one_or_none():
    """One node that lifts off: q0 and q1 at opening and closing decide, by hand."""
    node = fo.ContactSystem.from_blocks(
        [[2.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    )

    def limit_of(held, scaled):
        """Corners: pressed, touching, open, touching; then pressed again."""
        cycle = fo.LoadCycle(
            {"P": 0.0},
            [{"Q": q} for q in scaled],
            fixed=[{"P": p, "Q": q} for p, q in zip((2.0, 0.0, -1.0, 0.0), held, strict=True)],
        )
        return fo.shakedown_limit(node, cycle, 0.5)

    # The node opens under held[1] + lam scaled[1] and closes under held[3] + lam scaled[3].
    every = limit_of((0.0, 0.1, 0.0, 0.1), (1.0, 0.0, 0.7, 0.0))
    assert every.load_factor == pytest.approx(0.5 * 2.0 + 0.1) and every.least == 0
    one = limit_of((0.0, 0.1, 0.0, 0.0), (1.0, 0.0, 0.0, 0.2))
    assert one.load_factor == pytest.approx(0.5) and one.least == pytest.approx(0.5)
    assert "at any other load factor" in one.reason and of_all_states(one)
    zero = limit_of((0.0, 0.1, 0.0, 0.1), (1.0, 0.0, 0.0, 0.2))
    assert zero.load_factor == 0
    assert "node 0 closes and opens under different shear loads" in zero.reason
    none = limit_of((0.0, 0.1, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    assert np.isnan(none.load_factor) and none.bound_for_all == 0.0
    assert "at any load factor, for all openings and closings: node 0 closes" in none.reason


def test_the_rate_with_friction_is_that_of_differences():
    case = contact(9001)
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction)
    step = 1e-6
    for node in range(case.system.nodes):
        more = case.friction + step * (np.arange(case.system.nodes) == node)
        slope = (
            fo.shakedown_limit(case.system, case.cycle, more).load_factor - limit.load_factor
        ) / step
        assert limit.friction_rate[node] == pytest.approx(slope, abs=1e-4)


@pytest.mark.parametrize(
    "load_factor, rests", [(0.45, 1), (0.46, 0), (0.99, 0), (1.01, 1), (3.0, 1)]
)
def test_with_a_scaled_normal_load_the_states_of_rest_need_not_be_an_interval(load_factor, rests):
    """One node is at rest on [0, 1 / 2.2] and from 1 on."""
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    loads = [(0.0, 0.0), (-1.0, 0.0), (-2.0, 0.1), (-2.0, -0.1), (-1.0, 0.0)]
    cycle = fo.LoadCycle({"P": 1.0}, [{"P": p, "Q": q} for p, q in loads])
    for slip in (-0.5, 0.0, 0.5):
        steady = fo.steady_state(node, cycle, 0.5, load_factor, initial_slip=[slip])
        assert (steady.outcome is fo.Outcome.SHAKEDOWN) is bool(rests)
    limit = fo.shakedown_limit(node, cycle, 0.5)
    assert limit.load_factor == pytest.approx(1 / 2.2) and not limit.proven


def test_options_that_restrict_the_slip_ask_the_ordinary_question():
    system, cycle = cylinder(20, 1.6), harmonic(0.0)
    assert fo.shakedown_limit(system, cycle, F, events=True).load_factor == pytest.approx(F / 2)
    for options in ({"slip_bound": 1.0}, {"open_nodes": np.zeros(20, dtype=bool)}):
        assert np.isnan(fo.shakedown_limit(system, cycle, F, **options).load_factor)
    with pytest.raises(fo.ModelError, match="events: 'yes'"):
        fo.shakedown_limit(system, cycle, F, events="yes")
    with pytest.raises(fo.ModelError, match="least_slip: nodes open and close"):
        fo.shakedown_limit(system, cycle, F).least_slip(1.0)


def test_the_referee_of_all_instants_refuses_a_rim_that_moves_otherwise():
    case = contact(9001)
    areas = moving_areas(pose(case.system, case.cycle, case.friction))
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction)
    load_factor, slip = limit.load_factor, limit.slip
    assert areas.violation(load_factor, slip) < 1e-12
    rng = np.random.default_rng(0)
    moved = areas.rim.motion + 1e-3 * rng.normal(size=areas.rim.motion.shape)
    path = areas.path
    lifted = path.gap + 1e-3 * (path.pressure > 0)
    for wrong in (
        replace(areas, rim=replace(areas.rim, motion=moved)),
        replace(areas, path=replace(path, gap=lifted)),
        replace(areas, friction=0.9 * areas.friction),
    ):
        assert wrong.violation(load_factor, slip) > 1e-6


def test_closed_and_constantly_open_areas_keep_the_ordinary_limit_and_cover_all_states():
    flat = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(8, 1.0, 1.0))
    static = fo.LoadCycle({"P": P}, [{"Q": -1.0}, {"Q": 1.0}])
    for system in (flat, cylinder(20, 1.6)):
        limit = fo.shakedown_limit(system, static, F)
        assert moving_areas(pose(system, static, F)) is None
        assert of_all_states(limit) and limit.events.empty
    normal = fo.LoadCycle({"P": P}, [{"Q": -1.0, "P": 0.1}, {"Q": 1.0}])
    assert "at higher load factors" in fo.shakedown_limit(flat, normal, F).covers


def enumerated(C, reactions):
    """Pressures and gaps by all sets of open nodes."""
    count = len(reactions)
    for bits in range(2**count):
        opened = np.array([bits >> i & 1 for i in range(count)], dtype=bool)
        gap = np.zeros(count)
        if opened.any():
            gap[opened] = np.linalg.solve(C[np.ix_(opened, opened)], -reactions[opened])
        pressure = reactions + C @ gap
        if gap.min() >= -1e-9 and pressure.min() >= -1e-9:
            return pressure, gap
    raise AssertionError("no solution")


@pytest.mark.parametrize("seed", few(range(30)))
def test_the_normal_path_is_that_of_all_sets_tried_at_each_place(seed):
    rng = np.random.default_rng([7502, seed])
    count, corners = int(rng.integers(1, 6)), int(rng.integers(1, 6))
    factor = rng.normal(size=(count, count))
    C = factor @ factor.T / count + 0.1 * np.eye(count)
    loads = rng.normal(size=(corners, count)) + 0.3
    if seed % 3 == 0:  # integers make ties
        C = np.eye(count) * 2.0
        loads = rng.integers(-1, 3, (corners, count)).astype(float)
    path = normal_path(C, loads)
    places = path.segment + path.part
    assert (np.diff(places) > 0).all() and set(range(corners)) <= set(places.tolist())
    for place in rng.uniform(0, corners, 20):
        k, part = int(place), place % 1
        pressure, gap = enumerated(C, (1 - part) * loads[k] + part * loads[(k + 1) % corners])
        ends = np.append(places, corners)
        for values, known in ((path.pressure, pressure), (path.gap, gap)):
            around = np.vstack([values, values[:1]])
            found = [np.interp(place, ends, column) for column in around.T]
            assert_allclose(found, known, atol=1e-8)


def test_twins_open_in_one_event():
    C = np.array([[2.0, 0.5, 0.5], [0.5, 2.0, 0.1], [0.5, 0.1, 2.0]])
    path = normal_path(C, np.array([[1.0, 1.0, 1.0], [3.0, -1.0, -1.0]]))
    assert len(path.segment) == 4
    opens = path.presses[0] & ~path.presses[1]
    assert opens.tolist() == [False, True, True]
    for first, last in pairwise(path.part[path.segment == 0]):
        assert last > first


def test_of_two_nodes_that_lose_their_pressure_at_once_one_opens():
    """By hand: half way both pressures are zero. The gap of node 0, w = 2 s - 1, presses node 1 by
    0.9 w, which is more than the 0.5 w that the load takes."""
    path = normal_path(np.array([[1.0, 0.9], [0.9, 1.0]]), np.array([[1.0, 0.5], [-1.0, -0.5]]))
    assert_allclose(path.segment + path.part, [0, 0.5, 1, 1.5])
    assert_allclose(path.gap, [[0, 0], [0, 0], [1, 0], [0, 0]], atol=1e-12)
    assert_allclose(path.pressure, [[1, 0.5], [0, 0], [0, 0.4], [0, 0]], atol=1e-12)


def test_a_free_body_that_lifts_off_has_no_path():
    with pytest.raises(NoPath):
        normal_path(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, 1.0], [-2.0, -1.0]]))
    system = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(6, 1.0, 1.0))
    lifted = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}] * 2, fixed=[{"P": -3.0}, {"P": 1.0}])
    assert np.isnan(fo.shakedown_limit(system, lifted, F).load_factor)
