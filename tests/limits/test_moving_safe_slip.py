"""Safe slips and required friction of uncoupled contacts whose areas open and close.

They are compared with closed forms and transients.
"""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import unit_nodes
from studies.validation.moving_areas import Case, contact, ends
from studies.validation.moving_events import FRICTION, IN_PHASE, ROLLS, cylinder, out_of_phase
from studies.validation.rest_intervals import contact as scaled_contact

F = FRICTION


def test_a_rolling_cylinder_has_a_safe_slip_up_to_its_limit():
    system = cylinder(20, 1.8)
    limit = fo.shakedown_limit(system, ROLLS, F)
    below = fo.safe_slip(system, ROLLS, F, 0.99 * limit.load_factor)
    above = fo.safe_slip(system, ROLLS, F, 1.01 * limit.load_factor)
    assert below.exists and below.margin == pytest.approx(below.bound, abs=1e-9)
    assert len(below.events) and "nodes that open and close" in below.reason
    assert not above.exists and above.margin < 0 and len(above.certificate)
    assert "no state of rest exists at this load factor" in above.reason
    steady = fo.steady_state(
        system, ROLLS, F, below.load_factor, initial_state=below.state, progress=False
    )
    assert steady.outcome is fo.Outcome.SHAKEDOWN


def test_the_required_friction_of_static_shear_and_of_loads_in_phase():
    """The limit of both is proportional to friction."""
    for half_length, cycle in ((1.8, ROLLS), (1.6, IN_PHASE)):
        system = cylinder(16, half_length)
        limit = fo.shakedown_limit(system, cycle, F).load_factor
        required = fo.required_friction(system, cycle, 0.6 * limit)
        assert required.required == pytest.approx(0.6 * F, rel=1e-6)
        assert required.bound == pytest.approx(0.6 * F, rel=1e-6)
        assert "for all openings and closings" in required.reason and len(required.mechanism)


def test_with_a_phase_no_friction_is_enough():
    system = cylinder(16, 1.6)
    required = fo.required_friction(system, out_of_phase(45.0), 0.05)
    assert required.required == np.inf
    assert "closes and opens under different shear loads" in required.reason
    assert not fo.safe_slip(system, out_of_phase(45.0), 50.0, 0.05).exists
    assert fo.safe_slip(system, out_of_phase(45.0), F, 0.0).exists


def test_one_node_with_scaled_normal_loads_by_hand():
    """It rests up to 1 / 2.2, and from 1 on, where it is open while its shear turns."""
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    loads = [(0.0, 0.0), (-1.0, 0.0), (-2.0, 0.1), (-2.0, -0.1), (-1.0, 0.0)]
    cycle = fo.LoadCycle({"P": 1.0}, [{"P": p, "Q": q} for p, q in loads])
    rests = [fo.safe_slip(node, cycle, 0.5, lam).exists for lam in (0.45, 0.46, 0.9, 1.01, 3.0)]
    assert rests == [True, False, False, True, True]
    # At 0.4 it is closed, and needs 0.04 of 0.2.
    assert fo.required_friction(node, cycle, 0.4).required == pytest.approx(0.2, rel=1e-5)


@pytest.mark.parametrize("friction_in_the_air", [0.5, 0.1, 1e-3])
def test_the_margin_is_the_reserve_over_the_mean_bound_of_the_whole_contact(friction_in_the_air):
    """By hand: only node 0 needs a reserve, and keeps 1 - 0.9. Node 1 opens and closes without
    shear. Node 2 never closes, so that its friction counts only in the mean bound."""
    one = np.eye(3)
    f = np.array([0.5, 0.5, friction_in_the_air])
    p = np.array([2.0, 1.0, -1.0])
    loads = {"mean": (0 * p, p), "P": (0 * p, [0.0, 2.0, 0.0]), "Q": ([1.0, 0.0, 0.0], 0 * p)}
    system = fo.ContactSystem.from_blocks(one, 0 * one, one, [0.0, 1.0, 2.0], loads)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"P": 1.0, "Q": 0.9}, {"P": -1.0, "Q": -0.9}])
    safe = fo.safe_slip(system, cycle, f, 1.0)
    assert len(safe.events) == 2
    assert safe.margin == pytest.approx(0.1 / np.mean(f * p), rel=1e-9)
    assert safe.bound == pytest.approx(safe.margin, abs=1e-9)


def test_no_friction_is_needed_where_pressed_nodes_carry_no_shear():
    """By hand: one node opens in each cycle, under no shear, under static shear that a slip takes
    off, and under shear that comes and goes while the node is open. With hardly any friction every
    start comes to rest."""
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    lifts = [{"P": -2.0}, {"P": 2.0}]
    turns = [(0.0, 0.0), (-1.0, 0.0), (-2.0, 0.1), (-2.0, -0.1), (-1.0, 0.0)]
    cycles = (
        fo.LoadCycle({"P": 1.0}, lifts),
        fo.LoadCycle({"P": 1.0, "Q": 0.3}, lifts),
        fo.LoadCycle({"P": 1.0}, [{"P": 3 * p, "Q": 3 * q} for p, q in turns]),
    )
    for cycle, slip in zip(cycles, (0.0, -0.3, 0.0), strict=True):
        required = fo.required_friction(node, cycle, 1.0)
        assert required.required == 0.0 and np.isnan(required.bound)
        assert required.slip == pytest.approx([slip], abs=1e-12)
        assert fo.safe_slip(node, cycle, 0.0, 1.0).exists
        case = Case(node, cycle, np.array([1e-3]), "by hand")
        assert set(ends(case.arguments, 1.0, 4)) == {"SHAKEDOWN"}
    # At 0.3 times its load the last one opens and closes under different shear.
    slips = fo.safe_slip(node, cycles[-1], 0.0, 0.3)
    assert not slips.exists and "for all openings" not in slips.reason
    assert fo.required_friction(node, cycles[-1], 0.3).required == np.inf


@pytest.mark.parametrize("seed", few(range(9500, 9512)))
def test_where_a_slip_is_safe_every_start_comes_to_rest_and_nowhere_else(seed):
    case = (contact if seed % 2 else scaled_contact)(seed)
    for load_factor in (0.2, 0.7, 1.5):
        safe = fo.safe_slip(case.system, case.cycle, case.friction, load_factor)
        if abs(safe.margin) < 0.01:
            continue
        found = ends(case.arguments, load_factor, 3, seed)
        assert (set(found) == {"SHAKEDOWN"}) == safe.exists, (load_factor, safe.margin, found)


def test_fixed_parts_may_differ_while_normal_loads_are_scaled():
    case = scaled_contact(9520)
    corners = list(case.cycle.corners)
    fixed = [*corners[1:], corners[0]]
    fixed = [{name: 0.2 * value for name, value in part.items()} for part in fixed]
    mixed = fo.LoadCycle(case.cycle.mean, corners, fixed)
    for load_factor in (0.1, 0.5, 1.5):
        safe = fo.safe_slip(case.system, mixed, case.friction, load_factor)
        found = ends(replace(case, cycle=mixed).arguments, load_factor, 3)
        assert (set(found) == {"SHAKEDOWN"}) == safe.exists, (load_factor, safe.margin, found)


def test_a_file_keeps_the_safe_slip(tmp_path):
    system = cylinder(16, 1.8)
    safe = fo.safe_slip(system, ROLLS, F, 0.1)
    safe.save(tmp_path / "safe.npz")
    again = fo.results.load(tmp_path / "safe.npz")
    assert again.reason == safe.reason and again.events.equals(safe.events)
