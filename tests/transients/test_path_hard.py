"""Starts, loads and contacts that are difficult for the search of a steady state.

Each of them once gave a wrong answer.
"""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.paths import followed
from helpers.systems import CYCLE, random_system, unit_nodes


@settings(max_examples=few(60))
# Slip dies out by a factor of 12 a cycle, next to a node without friction.
@example(seed=858, nodes=4, corners=2, size=0.5)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 5),
    corners=st.integers(1, 4),
    size=st.sampled_from([0.5, 2.0, 20.0]),
)
def test_steady_states_are_where_a_hundred_cycles_go(seed, nodes, corners, size):
    """Work, slip and outcome agree with brute force, with frictionless nodes, gaps, separation, and
    integer loads that meet bounds exactly."""
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes, loads=("mean", "a", "b")).with_gap(
        0.3 * rng.random(nodes) * (rng.random(nodes) < 0.3)
    )
    friction = rng.uniform(0.1, 0.5, nodes) * (rng.random(nodes) < 0.7)
    cycle = fo.LoadCycle(
        {"mean": 1.0},
        [{"a": float(a), "b": float(b)} for a, b in rng.integers(-2, 3, size=(corners, 2)) / 2],
    )
    start = rng.normal(size=nodes)
    steady = fo.steady_state(contact, cycle, friction, size, initial_slip=start)
    path = followed(contact, cycle, friction, size, start, cycles=100)
    path.state.work[:] = 0.0
    path.follow(path.segments)
    scale = path.force**2 / contact.stiffness_scale * max(1.0, size) ** 2
    assert path.state.work.sum() == pytest.approx(steady.dissipation, rel=1e-8, abs=1e-9 * scale)
    assert steady.residual < 1e-9
    assert (steady.outcome is fo.Outcome.SHAKEDOWN) == (steady.dissipation == 0.0)
    assert np.allclose(
        path.state.u[:nodes], steady.slip, atol=1e-7 * max(1.0, np.abs(steady.slip).max())
    )


NODE = unit_nodes({"N": ([0.0], [1.0]), "T": ([1.0], [0.0])})


def test_a_first_cycle_without_work_is_no_shakedown():
    """A node lifts off, moves freely and lands elsewhere: it dissipates from the second cycle on."""
    cycle = fo.LoadCycle({"N": 1.0}, [{"N": -2.0}, {"N": -2.0, "T": 0.3}, {"T": 0.3}, {}])
    steady = fo.steady_state(NODE, cycle, 0.5, 1.0)
    work = fo.march(NODE, cycle, 0.5, 1.0, cycles=6).cycle_work.sum(axis=1)
    assert work[0] == 0.0 and work[-1] == pytest.approx(0.045)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP and steady.dissipation == pytest.approx(0.045)


def test_a_first_cycle_that_comes_back_without_work_is_no_shakedown():
    """From the mean load a node lifts off at once. From the last corner, where it is sheared, it
    slips first: `q = 0.6 (1 - t)` meets `f p = 1 - 1.25 t`."""
    steady = fo.steady_state(
        NODE, fo.LoadCycle({"N": 1.0}, [{"N": -1.5}, {"N": 1.0}, {"N": 1.0, "T": 0.6}]), 0.5, 1.0
    )
    begin, end = 0.4 / 0.65, 0.8  # of slip: at the bound, and without pressure
    work = 0.65 * ((end - 0.625 * end**2) - (begin - 0.625 * begin**2))
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert steady.first_cycle == 0
    assert steady.dissipation == pytest.approx(work)


def test_dissipation_does_not_drown_in_that_of_a_far_start():
    loads = {"P": ([0, 0], [1, 1]), "L": ([1, 0.2], [0.1, 0])}
    contact = fo.ContactSystem.from_blocks(
        [[2, -1], [-1, 2]], [[0.1, 0.3], [-0.3, 0.1]], 2 * np.eye(2), [0, 1], loads
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"L": 1.0}, {"L": -1.0}])
    near, far = (
        fo.steady_state(contact, cycle, 0.4, 1.0, initial_slip=[v, -v / 3]).dissipation
        for v in (1e3, 1e7)
    )
    assert near == pytest.approx(0.64067927, rel=1e-7) and far == pytest.approx(near, rel=1e-8)


@pytest.mark.parametrize("friction", [0.0, 0.3, 0.5])
def test_bodies_that_nothing_holds_slide_away(friction):
    for A in ([[0.0]], [[1.0, -1.0], [-1.0, 1.0]]):
        n = len(A)
        loads = {"P": (np.zeros(n), np.ones(n)), "L": (np.full(n, 0.5), np.zeros(n))}
        contact = fo.ContactSystem.from_blocks(A, np.zeros((n, n)), np.eye(n), np.arange(n), loads)
        cycle = fo.LoadCycle({"P": 1.0}, [{"L": 1.2}, {"L": -1.2}])
        with pytest.raises(fo.NoContinuation, match=r"as a whole|slides or opens freely"):
            fo.steady_state(contact, cycle, friction, 1.0)


@pytest.mark.parametrize("seed", few(range(4)))
def test_a_start_too_far_for_the_loads_to_be_seen_is_refused_and_one_that_is_not_ends_as_any_far_start(
    seed,
):
    """From far away the way to the mean load is a ray, from which all starts on it end alike."""
    rng = np.random.default_rng(seed)
    contact, direction = random_system(rng, 4), rng.normal(size=4)
    near, far = (
        fo.steady_state(contact, CYCLE, 0.3, 0.5, initial_slip=size * direction)
        for size in (1e7, 1e15)
    )
    assert far.outcome is near.outcome
    assert far.slip == pytest.approx(near.slip, abs=1e-5 * np.abs(near.slip).max())
    for size in (1e30, 1e40, 1e140):
        with pytest.raises(
            fo.ModelError,
            match=r"initial_slip: it stresses the contact .* times as much as the loads",
        ):
            fo.steady_state(contact, CYCLE, 0.3, 0.5, initial_slip=size * direction)
        with pytest.raises(fo.ModelError, match="initial_slip: it stresses the contact"):
            fo.march(contact, CYCLE, 0.3, 0.5, initial_slip=size * direction, steps=1)
        with pytest.raises(fo.ModelError, match="overload: it stresses the contact"):
            fo.steady_state(contact, CYCLE, 0.3, 0.5, overload=size)


def test_loads_and_slips_that_are_large_together_are_not_far():
    contact = random_system(np.random.default_rng(0), 3)
    one = fo.steady_state(contact, CYCLE, 0.3, 0.5, initial_slip=[1.0, 2.0, -1.0])
    scaled = fo.LoadCycle(
        {"mean": 1e40},
        [{name: 1e40 * value for name, value in corner.items()} for corner in CYCLE.corners],
    )
    other = fo.steady_state(contact, scaled, 0.3, 0.5, initial_slip=[1e40, 2e40, -1e40])
    assert other.slip == pytest.approx(1e40 * one.slip, rel=1e-9) and other.outcome is one.outcome
