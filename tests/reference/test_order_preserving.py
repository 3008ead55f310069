import numpy as np
import pytest

import frictopt as fo
from frictopt.transients.exact import ExactPath
from helpers.systems import CYCLE, system


def ordered_system(rng, nodes):
    """A contact in which each node pulls the others along, and the friction up to which it keeps
    the order."""
    A = -rng.uniform(0.05, 1.0, (nodes, nodes))
    A = (A + A.T) / 2
    np.fill_diagonal(A, 0.0)
    A += np.diag(0.3 - A.sum(axis=1))
    coupling = rng.normal(size=(nodes, nodes)) * rng.uniform(0.2, 1.0)
    off = ~np.eye(nodes, dtype=bool)
    np.fill_diagonal(coupling, 0.1)
    friction = float((-A[off] / np.abs(coupling[off])).min())
    return system(
        A,
        coupling,
        0.1 * rng.normal(size=nodes),
        rng.uniform(0.5, 1.5, nodes),
        rng.normal(size=nodes),
        0.1 * rng.normal(size=nodes),
    ), friction


def violation(contact, friction, load_factor, low, high):
    """Largest excess of the slips from the lower start over those from the upper one, at the
    corners; None where a node opens."""
    paths = [
        ExactPath(contact, CYCLE, friction, load_factor, start).start() for start in (low, high)
    ]
    most = -np.inf
    for _ in range(4):
        for number in range(2):
            for path in paths:
                path.follow_to(path.corners[number], "")
                if (path.state.status == 2).any():
                    return None
            most = max(most, float((paths[0].state.u - paths[1].state.u)[: contact.nodes].max()))
    return most


def test_it_holds_up_to_the_friction_that_it_names():
    contact, friction = ordered_system(np.random.default_rng(0), 4)
    assert fo.reference.order_preserving(contact).min() == pytest.approx(friction, rel=1e-12)


def test_ordered_starts_stay_ordered():
    checked = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        nodes = int(rng.integers(2, 6))
        contact, most = ordered_system(rng, nodes)
        friction = min(0.95 * most, 0.6)
        assert (fo.reference.order_preserving(contact) >= friction).all()
        low = 0.5 * rng.normal(size=nodes)
        found = violation(
            contact, friction, rng.uniform(0.1, 0.6), low, low + rng.uniform(0.0, 0.3, nodes)
        )
        if found is not None:
            assert found <= 1e-12
            checked += 1
    assert checked > 20


def test_without_the_condition_the_order_may_be_lost():
    pushing = system([[1.0, 0.6], [0.6, 1.0]], np.zeros((2, 2)), 0.0, 1.0, (0.0, 1.0), 0.0)
    assert fo.reference.order_preserving(pushing).max() < 0.4
    assert violation(pushing, 0.4, 1.0, np.array([0.0, 0.0]), np.array([0.3, 0.0])) > 0.01


def test_an_uncoupled_contact_keeps_the_order_at_any_friction_or_at_none():
    assert (
        fo.reference.order_preserving(
            system([[1.0, -0.2], [-0.2, 1.0]], np.zeros((2, 2)), 0.0, 1.0, 1.0, 0.0)
        ).min()
        == np.inf
    )
    assert (
        fo.reference.order_preserving(
            system([[1.0, 0.2], [0.2, 1.0]], np.zeros((2, 2)), 0.0, 1.0, 1.0, 0.0)
        ).min()
        == -np.inf
    )


def test_the_friction_of_a_node_counts_with_what_slips_do_to_its_own_pressure():
    """Slip of node 1 changes the pressure of node 0, not the other way round: node 0 needs -A_01 >=
    f_0 |B_01|, and node 1 nothing."""
    contact = system([[1.0, -0.4], [-0.4, 1.0]], [[0.0, 0.5], [0.0, 0.0]], 0.0, 1.0, 1.0, 0.0)
    assert fo.reference.order_preserving(contact).tolist() == [0.8, np.inf]
