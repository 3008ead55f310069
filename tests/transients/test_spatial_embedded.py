"""Plane contacts embedded in space have the answers of the plane.

Some nodes have no friction or no pressure.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.spatial import random_contact
from helpers.systems import all_closed
from studies.validation.fuzz.embedded import embedded

OPPOSED = [{"a": 1.0}, {"a": -1.0}]


@pytest.mark.parametrize("seed", [0, 3519, 17821, 21577])
def test_several_slides_that_nothing_resists_leave_the_limit_of_the_plane(seed):
    """The body slides along the plane, and nodes move freely across it. In all cases but the first
    LAPACK does not find these slides alone."""
    A = [[2.0, -1.0, -1.0], [-1.0, 2.0, -1.0], [-1.0, -1.0, 2.0]]
    bonded = {"P": (np.zeros(3), np.ones(3)), "Q": ([1.0, 0.5, -1.5], np.zeros(3))}
    flat = fo.ContactSystem.from_blocks(A, np.zeros((3, 3)), np.eye(3), range(3), bonded)
    solid, _ = embedded(flat, np.random.default_rng(seed))
    loads = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    assert fo.shakedown_limit(solid, loads, 0.5).load_factor == pytest.approx(0.5 / 1.5, rel=1e-9)


@pytest.mark.parametrize(
    ("friction", "pressure", "corners", "why"),
    [
        (
            [0.0, 0.5],
            [1.0, 1.0],
            [{"X": 1.0}, {"X": -0.3}],
            "node 0 has no friction, and the cyclic load shears it",
        ),
        (
            0.5,
            [1.0, 0.0],
            [{"X": 1.0}, {"X": -0.3}],
            "node 1 carries no pressure under the mean load, and the cyclic load shears it",
        ),
        (
            0.5,
            [1.0, 0.0],
            [{"Z": 1.0}, {}],
            "node 1 carries no pressure under the mean load, and the cyclic load lifts it",
        ),
    ],
)
def test_a_node_that_alone_keeps_the_limit_at_zero_is_named(friction, pressure, corners, why):
    bonded = {
        "P": np.r_[0.1, -0.2, 0.0, 0.1, pressure],
        "X": [1.0, 1.0, 0.5, 0.2, 0, 0],
        "Z": [0, 0, 0, 0, 0.1, -0.2],
    }
    S = np.kron(np.eye(3), [[2.0, -1.0], [-1.0, 2.0]])
    question = (
        fo.ContactSystem(S, [[0, 0, 0], [1, 0, 0]], bonded),
        fo.LoadCycle({"P": 1.0}, corners),
    )
    limit = all_closed(*question, friction)  # all nodes closed
    assert (limit.load_factor, limit.kind) == (0.0, fo.LimitKind.FINITE)
    advice = "; a state of rest with nodes that open and close may exist: pass events=True"
    assert limit.reason.endswith(why if "no friction" in why else why + advice)
    assert limit.bound == pytest.approx(0.0, abs=1e-12)
    assert set(limit.mechanism["node"]) == {int(why[5])}


def test_a_smooth_node_in_a_contact_that_nothing_makes_safe_leaves_no_limit():
    bonded = {"P": [0, 0, 0, 0, -1, -1], "X": [1, 1, 0, 0, 0, 0]}
    pulled = fo.ContactSystem(
        np.kron(np.eye(3), [[2.0, -1.0], [-1.0, 2.0]]), [[0, 0, 0], [1, 0, 0]], bonded
    )
    limit = fo.shakedown_limit(
        pulled, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), [0.0, 0.5]
    )
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    assert np.isnan(limit.load_factor)
    assert "pulls the bodies apart" in limit.reason


def test_the_slip_at_a_limit_stays_within_every_circle_to_rounding():
    """The residual of a solver is taken off the load factor."""
    loads = fo.LoadCycle({"mean": 1.0}, OPPOSED)
    for seed in range(20):
        contact = random_contact(np.random.default_rng(seed), 6)
        q, p = fo.shakedown_limit(contact, loads, 0.5).reactions
        assert not (np.linalg.norm(q, axis=-1) - 0.5 * p).max() > 1e-11
