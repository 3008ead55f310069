"""Required friction of one node in space, by hand."""

import numpy as np
import pytest

import frictopt as fo


def test_a_node_in_space_needs_the_radius_of_the_smallest_circle_around_its_shears():
    """The required friction is the radius of the circle around the shears, over the pressure.

    Three shears of size 1 are 120 degrees apart, and slip takes the mean shear away. A pressure of
    2 gives f = 1 / 2; at half the load f is a quarter.
    """
    node = fo.ContactSystem(
        np.eye(3), [[0, 0, 0]], {"P": [0, 0, 2], "X": [1, 0, 0], "Y": [0, 1, 0]}
    )
    angles = 2 * np.pi * np.arange(3) / 3
    cycle = fo.LoadCycle(
        {"P": 1.0, "X": 0.7}, [{"X": float(np.cos(a)), "Y": float(np.sin(a))} for a in angles]
    )
    for load_factor, expected in ((1.0, 0.5), (0.5, 0.25)):
        required = fo.required_friction(node, cycle, load_factor)
        assert required.required == pytest.approx(expected, rel=1e-5)
        assert required.bound < required.required
        q, p = required.reactions
        assert (np.hypot(q[..., 0], q[..., 1]) <= required.required * p * (1 + 1e-9)).all()
    assert required.slip.shape == (1, 2)
    assert {"slip1", "slip2"} <= set(required.to_frame()) & set(required.mechanism)


def test_no_friction_is_enough_in_space_for_a_node_that_the_load_opens():
    """With a bound on the slip the nodes have to stay as they are."""
    pulled = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "N": [0, 0, -1]})
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0}, {"N": -1.0}])
    answer = fo.required_friction(pulled, cycle, 2.0, slip_bound=1.0)
    assert answer.required == np.inf and "open one of these nodes (at (0, 0, 0))" in answer.reason
    assert answer.mechanism[["node", "corner", "slip1", "slip2"]].to_numpy().tolist() == [
        [0, 0, 0, 0]
    ]
