from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

import frictopt as fo
from helpers.components import joined
from helpers.paths import ROCKING, WALKING
from helpers.refused import refused
from helpers.spatial import thick
from helpers.systems import CYCLE, FIRST_PAIR, PULL, mirrored, system


def by_trajectory(contact, cycle, friction, factor, cycles):
    """The last cycle of a long transient from event to event, and its work of friction.

    The work is the integral of -q dv by the trapezoidal rule.
    """
    path = fo.march(contact, cycle, friction, factor, cycles=cycles)
    last = path.time >= path.time[-1] - len(path.cycle.corners)
    q, v = path.q[last], path.slip[last]
    return path, last, -((q[1:] + q[:-1]) / 2 * np.diff(v, axis=0)).sum(axis=0)


@pytest.mark.parametrize("opening", [False, True])
def test_the_table_against_a_long_transient_by_quadrature(punch, opening):
    if opening:  # nodes lift off at one corner and land at the other
        contact = mirrored(np.random.default_rng(3), 6)
        cycle = fo.LoadCycle({"mean": 1.0}, [{"one": -1.0}, {"one": 1.0}])
        friction = 0.4
        factor = 9.0
    else:
        contact, cycle, friction = punch(16), PULL, 0.7
        factor = 1.3 * fo.shakedown_limit(contact, cycle, friction).load_factor
    contact = replace(contact, width=np.linspace(0.1, 0.3, contact.nodes))
    steady = fo.steady_state(contact, cycle, friction, factor)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP and bool(steady.open.any()) is opening
    table = steady.fretting_table()
    path, last, work = by_trajectory(contact, cycle, friction, factor, steady.cycles + 60)
    q, p, width = path.q[last], path.p[last], contact.width
    closed = np.where(path.gap[last] <= 0, path.slip[last], np.nan)
    slips = np.nan_to_num(np.nanmax(closed, axis=0) - np.nanmin(closed, axis=0))
    scale = steady.dissipation
    assert np.allclose(table.work, work, atol=1e-7 * scale)
    assert table.share.sum() == pytest.approx(1.0)
    assert np.allclose(table.work_density, work / width, atol=1e-6 * scale)
    assert np.allclose(table.slip_range, slips, atol=1e-7 * slips.max())
    assert np.allclose(
        table.F1, np.abs(q).max(axis=0) / width * slips, rtol=1e-6, atol=1e-7 * table.F1.max()
    )
    for name, part in (("tau", q / width), ("pressure", p / width)):
        assert np.allclose(
            table[f"{name}_amplitude"],
            (part.max(axis=0) - part.min(axis=0)) / 2,
            atol=1e-6 * np.abs(part).max(),
        )
        assert np.allclose(
            table[f"{name}_mean"],
            (part.max(axis=0) + part.min(axis=0)) / 2,
            atol=1e-6 * np.abs(part).max(),
        )
    assert "property of the mesh" in table.attrs["note"]


def test_the_slip_range_of_a_state_of_rest_is_zero_and_no_rounding(punch):
    contact = punch(16)
    limit = fo.shakedown_limit(contact, PULL, 0.7).load_factor
    for share in (0.6, 0.7, 0.8):
        rest = fo.steady_state(contact, PULL, 0.7, share * limit)
        assert rest.outcome is fo.Outcome.SHAKEDOWN and rest.slip.any()
        assert not rest.fretting_table()["slip_range"].any()
        assert not rest.by_contact()["slip_range"].any()


def test_a_contact_that_creeps_has_its_drift_in_the_slip_range():
    steady, path = fo.steady_state(*WALKING), fo.march(*WALKING, cycles=9)
    assert steady.outcome is fo.Outcome.RATCHETING
    drift = path.slip[path.time == 18.0][0] - path.slip[path.time == 16.0][0]
    assert np.allclose(steady.fretting_table().slip_range, np.abs(drift))
    assert np.abs(drift).min() > 0.01


def test_bulk_stress_gives_f2_and_swt():
    contact = system(*FIRST_PAIR)
    steady = fo.steady_state(contact, CYCLE, 0.6, 2.0)
    stress, strain = np.array([[3.0, -2.0], [1.0, -1.0]]), np.array([[0.3, -0.2], [0.1, 0.4]])
    table = steady.fretting_table(stress=stress, strain=strain)
    assert np.allclose(table.F2_force, table.F1_force * [3.0, 0.0])
    assert np.allclose(table.SWT, [3.0 * 0.1, 0.0])
    assert list(table.columns[:3]) == ["node", "x", "slip_range"]
    assert "nodal forces" in table.attrs["note"]


@refused(
    ({"stress": np.ones((1, 2))}, "only one is given"),
    ({"stress": np.ones((1, 2)), "strain": np.ones((2, 2))}, "1 and 2 states"),
)
def test_stress_and_strain_that_do_not_fit_are_refused(change):
    fo.steady_state(system(*FIRST_PAIR), CYCLE, 0.6, 2.0).fretting_table(**change)


def test_a_steady_state_with_another_work_or_one_that_does_not_come_back_is_refused():
    steady = fo.steady_state(*WALKING)
    for change in (
        {"dissipation_per_node": 1.001 * steady.dissipation_per_node},
        {"outcome": fo.Outcome.CYCLIC_SLIP},
    ):
        with pytest.raises(fo.SolverError, match="a cycle from this state does not return to it"):
            replace(steady, **change).states()


def test_a_steady_state_outside_its_bounds_is_refused():
    """The cycle has one corner, at which nothing moves any more. The contact was computed with the
    friction that holds it."""
    steady = fo.steady_state(ROCKING, fo.LoadCycle({"P": 1.0}, [{"Q": 0.5}]), 0.9, 1.0)
    assert steady.outcome is fo.Outcome.SHAKEDOWN and steady.states().work.max() == 0
    with pytest.raises(fo.ModelError, match="initial_state: it violates the contact law"):
        replace(steady, friction=np.full(2, 0.5)).states()


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0])
def test_in_space_the_plane_of_swt_is_across_the_largest_slip(angle):
    """Of two nodes without coupling one slips: to and fro along one direction, and on a closed
    curve, where each two states are compared."""
    direction = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-np.sin(angle), np.cos(angle)])
    q = np.array([[2.0], [0.1]])
    loads = {
        "P": np.r_[np.zeros(4), 1.0, 1.0],
        "a": joined(q * direction, np.zeros(2)),
        "b": joined(0.5 * q * across, np.zeros(2)),
    }
    contact = fo.ContactSystem(np.eye(6), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], loads)
    stress = np.array(
        [
            [3.0 * np.outer(direction, direction) - 7.0 * np.outer(across, across)] * 2,
            [np.outer(across, across) - np.outer(direction, direction)] * 2,
        ]
    )
    strain = np.array(
        [
            [0.2 * np.outer(direction, direction)] * 2,
            [9.0 * np.outer(across, across) - 0.1 * np.outer(direction, direction)] * 2,
        ]
    )
    for corners in ([{"a": 1.0}, {"a": -1.0}], [{"a": 1.0}, {"b": 1.0}, {"a": -1.0}, {"b": -1.0}]):
        steady = fo.steady_state(contact, fo.LoadCycle({"P": 1.0}, corners), 0.5, 1.0, steps=4)
        table = steady.fretting_table(stress=stress, strain=strain)
        slip = steady.states().slip[:, 0]
        one, other = max(combinations(slip, 2), key=lambda pair: np.linalg.norm(pair[0] - pair[1]))
        size = np.linalg.norm(one - other)
        along = direction if len(corners) == 2 else (one - other) / size
        tension, extent = ((part[:, 0] @ along) @ along for part in (stress, strain))
        assert size > 1.5 and table["slip_range"].to_numpy() == pytest.approx([size, 0.0], rel=1e-9)
        assert table["SWT"][0] == pytest.approx(max(tension) * np.ptp(extent) / 2, rel=1e-6)
        assert np.isnan(table["SWT"][1])
        assert table["F2_force"].to_numpy() == pytest.approx(
            [max(tension) * table["F1_force"][0], 0.0], rel=1e-6
        )


def test_in_space_stress_along_one_tangent_is_not_enough():
    contact = thick(0.7)[1]
    steady = fo.steady_state(
        contact, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.4, 1e-3, steps=1
    )
    with pytest.raises(fo.ModelError, match="stress: shape"):
        steady.fretting_table(
            stress=np.ones((2, contact.nodes)), strain=np.ones((2, contact.nodes))
        )
