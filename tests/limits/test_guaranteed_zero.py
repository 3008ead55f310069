"""Guaranteed limits of contacts with a node that carries nothing under the mean load.

At load factor 0 such a node is on both its bounds, because the bounds coincide.
"""

import numpy as np
import pytest

import frictopt as fo
from studies.validation import oracles
from studies.validation.verify import verify

PRESSED = fo.LoadCycle({"mean": 1.0}, [{"press": 1.0, "shear": 1.0}, {"press": 1.0, "shear": -1.0}])


def about_its_middle(cycle, load_factor):
    """The loads of a cycle at a load factor as a cycle with the load factor 1.

    The middle of its corners is its mean load.
    """
    corners = cycle.at(load_factor)
    cases = {case for corner in corners for case in corner}
    middle = {
        case: sum(corner.get(case, 0.0) for corner in corners) / len(corners) for case in cases
    }
    return fo.LoadCycle(
        middle,
        [{case: corner.get(case, 0.0) - middle[case] for case in cases} for corner in corners],
    )


def two_nodes(self_coupling, cross_coupling):
    """Two nodes, of which node 0 carries nothing under the mean load.

    The cycle shears node 0 and presses it more. The pressure of node 0 follows its own slip and the
    slip of node 1.
    """
    loads = {"mean": ([0, 0], [0, 1.0]), "press": ([0, 0], [1.0, 0]), "shear": ([0.5, 0.3], [0, 0])}
    return fo.ContactSystem.from_blocks(
        np.eye(2),
        [[self_coupling, cross_coupling], [0, self_coupling]],
        np.eye(2),
        [0.0, 1.0],
        loads,
    )


def follow(contact, cycle, friction, load_factor, slip):
    """From the mean of the corners, so that no start is carried off before the first corner."""
    return fo.steady_state(
        contact, about_its_middle(cycle, load_factor), friction, 1.0, initial_slip=slip
    )


@pytest.mark.parametrize("simplify", [True, False])
@pytest.mark.parametrize("self_coupling", [0.0, 0.01])
def test_where_loads_press_the_node_more_than_they_shear_it_is_no_witness(self_coupling, simplify):
    """Node 0 rests at every load factor: the larger the load, the more slips are there in which it
    can rest."""
    contact, rng = two_nodes(self_coupling, 0.0), np.random.default_rng(0)
    limit = fo.guaranteed_limit(contact, PRESSED, 1.0, simplify=simplify)
    assert limit.load_factor == pytest.approx(1 / 0.3, rel=1e-9) and limit.node != 0
    if self_coupling:
        assert limit.to_frame().how[0] == "only at the least safe load factor"
        assert not limit.proven
        assert "; 1 node is critical only at the least safe load factor 0" in limit.reason
    for load_factor in (1e-3, 0.1, 1.0, 3.0):
        for size in (1e-6, 1e-3, 0.1, 1.0):
            slip = size * load_factor * rng.normal(size=2)
            assert follow(contact, PRESSED, 1.0, load_factor, slip).outcome is fo.Outcome.SHAKEDOWN
    assert verify(limit, starts=20, moved=0).dies_out


@pytest.mark.parametrize("simplify", [True, False])
@pytest.mark.parametrize("other", [0.3, -0.3, 0.01])
def test_where_slip_of_another_node_takes_that_pressure_off_it_is_one(other, simplify):
    """At every load factor lam a slip of node 1 leaves node 0 a pressure of lam / 4 against a shear
    of +- lam / 2, so that it slips to and fro by lam / 2."""
    contact = two_nodes(0.0, other)
    limit = fo.guaranteed_limit(contact, PRESSED, 1.0, simplify=simplify)
    assert limit.load_factor == 0
    assert limit.node == 0
    assert limit.shakedown.load_factor > 1
    assert not limit.proven
    for load_factor in (1e-3, 1e-2):
        steady = follow(contact, PRESSED, 1.0, load_factor, [0.0, -0.75 * load_factor / other])
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP
        assert steady.dissipation == pytest.approx(load_factor**2 / 4, rel=1e-6)
    at, witness = limit.witness_above_least(1e-2)
    assert 0 < at <= 1e-2
    assert oracles.off_bounds(contact, PRESSED, np.ones(2), at, witness, 0, limit.corners) < 1e-12
    assert oracles.excess(contact, PRESSED, np.ones(2), at, witness) < 1e-12
    outcomes = [follow(contact, PRESSED, 1.0, share * at, witness).outcome for share in (0.9, 1.1)]
    # A smaller load is worse if the load presses.
    assert outcomes == [fo.Outcome.CYCLIC_SLIP, fo.Outcome.SHAKEDOWN]
    assert verify(limit, starts=0, moved=0).persists


@pytest.mark.parametrize("coupling", [1e-5, 1e-6])
def test_a_limit_that_is_tiny_beside_the_loads_is_not_taken_for_the_coincidence_at_zero(coupling):
    """A tiny limit is distinguished from the coincidence of the bounds at load factor 0.

    Only slip presses node 1, by a weak coupling. Node 1 slips for ever at any load factor from a
    slip that holds it on both bounds.
    """
    bonded = {"P": ([0.0, 0.0], [1.0, 0.0]), "Q": ([0.0, 1.0], [0.0, 0.0])}
    pair = fo.ContactSystem.from_blocks(
        [[1.0, 0.3], [0.3, 1.0]], [[0.0, 0.0], [coupling, coupling]], np.eye(2), [0.0, 1.0], bonded
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    limit = fo.guaranteed_limit(pair, cycle, 0.5)
    assert limit.load_factor == 0.0 and limit.shakedown.load_factor > 0.1 * coupling
    at = 0.6 * limit.shakedown.load_factor
    # leaves node 1 no shear under the mean load, and is on both bounds at a sixth less load
    first = at / 1.2 / (0.5 * coupling * 0.7)
    assert (
        fo.steady_state(pair, cycle, 0.5, at, initial_slip=[first, -0.3 * first]).outcome
        is fo.Outcome.CYCLIC_SLIP
    )
