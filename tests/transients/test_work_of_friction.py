"""The work of friction is a physical quantity.

It does not depend on the side from which a contact is seen, on units, or on the way it was
computed.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.systems import unit_nodes

BEGINS_SYMMETRIC = [{"sigma": -1.0}, {"sigma": 1.0}]


def cycle_with_shear(Q):
    """Bulk stress to and fro, then a shear that the contact's mirror image sees as -Q."""
    return fo.LoadCycle({"P": 1.0}, [*BEGINS_SYMMETRIC, {"sigma": 1.0, "Q": Q}])


def work_from_states(path):
    """Work of friction (cycles, N) from reactions and slips.

    Both are linear from state to state; the work is the integral of -q dv.
    """
    spent = -(path.q[1:] + path.q[:-1]) / 2 * np.diff(path.slip, axis=0)
    so_far = np.vstack([0 * spent[:1], np.cumsum(spent, axis=0)])
    ends = (
        np.searchsorted(
            path.time, np.arange(0, path.time[-1] + 0.5, len(path.cycle.corners)) + 1e-9
        )
        - 1
    )
    return np.diff(so_far[ends], axis=0)


@pytest.mark.parametrize("Q", [0.1, -0.1])
def test_work_is_that_of_the_reactions_on_the_slips(punch, Q):
    contact = punch(64)
    path = fo.march(contact, cycle_with_shear(Q), 0.5, 0.69, cycles=6)
    expected = work_from_states(path)
    assert expected[-1].sum() > 1e-5
    assert np.allclose(path.cycle_work, expected, rtol=0, atol=1e-10 * expected.sum())
    assert (np.diff(path.work, axis=0) >= -1e-15).all()
    assert np.abs(path.energy_error).max() < 1e-10 * expected.sum()
    steady = fo.steady_state(contact, cycle_with_shear(Q), 0.5, 0.69)
    assert steady.dissipation_per_node == pytest.approx(
        expected[-1], rel=1e-6, abs=1e-9 * steady.dissipation
    )


@pytest.mark.parametrize("node", [0, 30, 59])
def test_one_node_that_rubs_beside_others_that_came_to_rest(node):
    """60 nodes do not feel each other, A = 1, f p = 1/2. One of them has q^w = 3/4 s: it slips by
    1/2 each way, W = 1/2, wherever it is. Its counterpart on the other side keeps a slip of -1/4,
    the mirror image of its own slip in the last two segments, which other loads leave alone."""
    n = 60
    identity, none, shape = np.eye(n), np.zeros(n), np.linspace(-0.1, 0.1, n)
    loads = {"P": (none, np.ones(n)), "R": (identity[node], none), "s": (shape, none)}
    contact = fo.ContactSystem.from_blocks(identity, 0 * identity, identity, np.arange(60.0), loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"R": 0.75}, {"R": -0.75}, {}, {"s": 1.0}])
    steady = fo.steady_state(contact, cycle, 0.5, 1.0, initial_slip=-0.25 * identity[n - 1 - node])
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert steady.dissipation_per_node == pytest.approx(0.5 * identity[node], abs=1e-12)


def test_a_steady_state_is_the_one_that_the_cycles_come_to():
    """Other states next to it are steady as well: a state that comes back to itself need not be the
    state of this start. After 20 cycles this transient has settled."""
    A = 2.2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    B = 0.4 * (np.eye(3, k=1) - np.eye(3, k=-1))
    loads = {
        "mean": ([-0.0776, 0.0, 0.0776], [1.2917, 0.7968, 1.2917]),
        "a": ([-0.4529, 0.0, 0.4529], [-0.0272, -0.1348, -0.0272]),
        "b": ([1.9426, -0.4638, 1.2569], [-0.8819, 0.0319, 0.4238]),
    }
    contact = fo.ContactSystem.from_blocks(A, B, A + 0.5 * np.eye(3), np.arange(3.0), loads)
    cycle = fo.LoadCycle(
        {"mean": 1.0},
        [{"a": 0.93, "b": -1.3972}, {"a": -0.2141, "b": -2.1851}, {"a": -0.22, "b": 0.2561}],
    )
    start = np.array([-5.4455, 2.4687, -5.4534])
    steady = fo.steady_state(contact, cycle, 0.5354, 0.3966, initial_slip=start)
    path = fo.march(contact, cycle, 0.5354, 0.3966, initial_slip=start, cycles=60)
    assert path.cycle_work[-1] == pytest.approx(path.cycle_work[-20], rel=1e-9)
    assert steady.dissipation_per_node == pytest.approx(path.cycle_work[-1], rel=1e-8, abs=1e-12)
    assert steady.slip == pytest.approx(path.slip[-1], abs=1e-8)


@pytest.mark.parametrize("steps", [None, 1, 3])
def test_work_under_a_pressure_that_grows_while_the_node_slips(steps):
    """A = 1 and f = 1/2. On the second segment q^w grows from 1 to 3 and p from 1 to 2.

    The bound grows from 1/2 to 1, so that the node slips by 2 - 1/2 under a mean bound of 3/4.
    """
    loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    contact = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": 3.0, "P": 1.0}])
    path = fo.march(contact, cycle, 0.5, 1.0, cycles=1, steps=steps)
    first, second = (np.flatnonzero(path.time == corner)[-1] for corner in (1, 2))
    assert path.work[second, 0] - path.work[first, 0] == pytest.approx(0.75 * 1.5, rel=1e-12)
