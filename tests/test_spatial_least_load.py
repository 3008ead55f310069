"""The least safe load factor in three dimensions, of contacts whose mean load alone is not safe."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from studies.validation.fuzz.embedded import embedded
from test_least_load import pressing_cycle

UP, DOWN = {"P": [0, 0, 1], "N": [0, 0, 1], "X": [1, 0, 0], "Y": [0, 1, 0]}, {"P": -1.0}
THREE = [(0.3, 0.0), (-0.1, 0.2), (-0.1, -0.2)]


def node_and_cycle():
    """A node that the mean load pulls; three corners press it and shear it in three directions."""
    return fo.ContactSystem(np.eye(3), [[0, 0, 0]], UP), fo.LoadCycle(DOWN, [{"N": 1.0, "X": x, "Y": y} for x, y in THREE])


def test_one_node_by_the_smallest_circle_around_its_corners():
    """Slip moves the centre of the shears, so that the node sticks if their smallest circle, of radius r, fits: r lam <= f (lam - 1)."""
    node, cycle = node_and_cycle()
    centre = (0.3**2 - 0.1**2 - 0.2**2) / (2 * (0.3 + 0.1))  # on the axis, as far from (0.3, 0) as from (-0.1, 0.2)
    radius = 0.3 - centre
    assert np.hypot(-0.1 - centre, 0.2) == pytest.approx(radius)
    limit = fo.shakedown_limit(node, cycle, 0.5)
    assert limit.kind is fo.LimitKind.UNBOUNDED and limit.least == pytest.approx(0.5 / (0.5 - radius), rel=1e-9) and limit.residual <= 1e-9
    assert (
        f"every load factor from {limit.least:.6g} on has a safe residual slip" in limit.reason
        and f"none is safe below {limit.least:.6g}" in limit.reason
    )
    for share, exists in ((0.999, False), (1.001, True)):
        assert fo.safe_slip(node, cycle, 0.5, share * limit.least).exists == exists
    below, within = (fo.steady_state(node, cycle, 0.5, share * limit.least).outcome for share in (0.95, 1.05))
    assert below is not fo.Outcome.SHAKEDOWN and within is fo.Outcome.SHAKEDOWN


@settings(max_examples=12)
@given(seed=st.integers(0, 10**6), nodes=st.integers(1, 4), corners=st.integers(1, 3), f=st.just(0.0) | st.floats(0.05, 1.2))
def test_the_interval_is_that_of_the_plane(seed, nodes, corners, f):
    rng = np.random.default_rng(seed)
    flat, cycle = pressing_cycle(rng, nodes, corners)
    solid, _ = embedded(flat, rng)
    plane, limit = fo.shakedown_limit(flat, cycle, f), fo.shakedown_limit(solid, cycle, f)
    assert limit.kind is plane.kind and limit.residual <= 1e-9
    assert limit.load_factor == pytest.approx(plane.load_factor, rel=1e-7, abs=1e-8, nan_ok=True)
    assert limit.least == pytest.approx(plane.least, rel=1e-7, abs=1e-8, nan_ok=True)
