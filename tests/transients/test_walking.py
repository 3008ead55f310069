"""Smooth contacts that walk: closed forms and transients.

The tests cover static shear while the contacts roll to and fro, loads in phase, and limits that
depend on the mesh.
"""

import numpy as np
import pytest

import frictopt as fo

F = 0.5
P = np.pi / 4  # the half-width of the contact is 1


def cylinder(cells, half_length=1.6):
    """A cylinder of radius 1 on a half-plane of modulus 1.

    The load case "roll" moves its lowest point by a unit length.
    """
    contact = fo.ContactSystem.from_blocks(
        **fo.reference.half_plane_contact(cells, half_length, 1.0, R=1.0)
    )
    return contact.with_bonded({"roll": (np.zeros(cells), contact.C @ contact.x)})


def pressures(contact, ends):
    """(2, N) pressures at both ends of the way that a contact rolls."""
    shear = next(name for name, (q, p) in contact.bonded.items() if q.any() and not p.any())
    cycles = [fo.LoadCycle(loads, [{shear: 0.0}]) for loads in ends]
    return np.array(
        [fo.march(contact, cycle, F, 1.0, cycles=0, progress=False).p[-1] for cycle in cycles]
    )


def pressed(contact, ends, shear, S):
    """A contact without gaps that has these pressures, and a static shear force that grows."""
    none = np.zeros(contact.slip_shape)
    held = fo.ContactSystem(
        S, contact.points, {"left": (none, ends[0]), "right": (none, ends[1]), "T": shear}
    )
    return held, fo.LoadCycle(
        {"left": 0.5, "right": 0.5},
        [{"T": 1.0}] * 2,
        [{"left": 0.5, "right": -0.5}, {"left": -0.5, "right": 0.5}],
    )


@pytest.mark.parametrize("way", [0.1, 0.2, 0.5])
def test_a_cylinder_that_rolls_walks_above_the_least_pressures_of_its_way(way):
    """T_max / (f P) is the share of the pressure that stays. Nodes at the edges open and close, and
    the transient of the true contact agrees."""
    contact = cylinder(20)
    closed = 1 - 2 / np.pi * (way * np.sqrt(1 - way**2) + np.arcsin(way))
    ends = pressures(contact, [{"P": P, "roll": -way}, {"P": P, "roll": way}])
    limit = fo.shakedown_limit(*pressed(contact, ends, contact.bonded["Q"], contact.S), F)
    assert (
        limit.load_factor
        == pytest.approx(F * ends.min(axis=0).sum(), rel=1e-8)
        == pytest.approx(F * P * closed, rel=2e-3)
    )
    guaranteed = fo.guaranteed_limit(*pressed(contact, ends, contact.bonded["Q"], contact.S), F)
    assert guaranteed.proven and guaranteed.load_factor == limit.load_factor
    rolling = fo.LoadCycle({"P": P}, [{"Q": 1.0}] * 2, [{"roll": -way}, {"roll": way}])
    below, above = (
        fo.steady_state(contact, rolling, F, share * limit.load_factor) for share in (0.98, 1.02)
    )
    assert below.outcome is fo.Outcome.SHAKEDOWN
    assert above.outcome is fo.Outcome.RATCHETING
    assert above.open.any()


@pytest.mark.parametrize(("P1", "Q1"), [(0.05, 0.1), (0.3, 0.3)])
def test_a_contact_whose_pressure_and_shear_come_in_phase_rests_up_to_friction_times_their_ratio(
    P1, Q1
):
    """Full stick if and only if Q1 <= f P1: the edges open and close, and roll on without slip."""
    contact, limit = cylinder(20), F * P1 / Q1
    cycle = fo.LoadCycle({"P": P}, [{"Q": -Q1 * P}, {"Q": Q1 * P}], [{"P": -P1 * P}, {"P": P1 * P}])
    below, above = (fo.steady_state(contact, cycle, F, share * limit) for share in (0.98, 1.02))
    assert below.outcome is fo.Outcome.SHAKEDOWN and above.outcome is fo.Outcome.CYCLIC_SLIP
    exact = fo.shakedown_limit(contact, cycle, F)
    assert exact.load_factor == pytest.approx(limit, rel=1e-9)
    assert "nodes 3" in exact.reason and "uncoupled" in exact.reason
    found = fo.limit_after_protocol(exact, start=np.zeros(20), up_to=2 * limit)
    assert (
        0.9 * limit
        <= found.load_factor
        <= limit * (1 + 1e-9)
        <= found.upper * (1 + 1e-9)
        < 1.1 * limit
    )


def test_the_limit_of_a_cylinder_under_constant_pressure_falls_with_the_mesh_to_zero():
    """Shear is the shear of a flat punch and grows at the edge, where pressure falls: lam = f p / q
    is 2 f P / Q (1 - x^2), on cells a share of it."""
    limits, shares = [], []
    for half in (8, 16, 32):
        # The edge of the contact, at 1, is a quarter of a cell outside of its last cell.
        size = 1 / (half + 0.25)
        contact = fo.ContactSystem.from_blocks(
            **fo.reference.half_plane_contact(2 * half + 8, (half + 4) * size, 1.0, R=1.0)
        )
        limit = fo.shakedown_limit(contact, fo.LoadCycle({"P": P}, [{"Q": -P}, {"Q": P}]), F)
        node = limit.mechanism["node"].iloc[0]
        assert int((~limit.open).sum()) == 2 * half and limit.open[[node - 1, node + 1]].sum() == 1
        assert (
            f"node {node} governs, next to open nodes, where pressure falls to zero: the limit depends on the mesh"
            in limit.reason
        )
        assert (
            "depends on the mesh" in fo.guaranteed_limit(contact, limit._question.cycle, F).reason
        )
        shares.append(limit.load_factor / (2 * F * (1 - contact.x[node] ** 2)))
        limits.append(limit.load_factor / size)
    assert np.ptp(limits) < 0.05 * limits[-1]  # of first order in the size of the cells
    assert np.ptp(shares) < 0.01 and 0.5 < shares[-1] < 1


def test_an_edge_beside_open_nodes_has_a_limit_of_its_own():
    """A flat punch is beside a gap that stays open, and its pressure is highest at its edges."""
    flat = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(24, 1.5, 1.0))
    punch = flat.with_gap(np.where(np.abs(flat.x) < 1, 0.0, 9.0))
    limit = fo.shakedown_limit(punch, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), F)
    assert limit.load_factor == pytest.approx(F, rel=1e-9)
    assert int(limit.open.sum()) == 8
    assert "mesh" not in limit.reason
