"""Limits in three dimensions.

They are compared with closed forms, the plane, invariances, extremes, and certificates from both
sides.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.separation import rests
from helpers.spatial import cycle, random_contact, single, vectors
from helpers.systems import CYCLE, at_corners
from studies.lift_off import flange
from studies.validation.closed_forms import smallest_circle_limit
from studies.validation.polygons import polygon_limit


def uncoupled(rng, nodes, corners):
    """A contact with B = 0 and K corners that shear it, and their shears."""
    contact = random_contact(rng, nodes, coupling=0.0)
    p0, q1 = rng.uniform(0.5, 1.5, nodes), rng.normal(size=(corners, nodes, 2))
    cases = {f"{k}": np.r_[q[:, 0], q[:, 1], np.zeros(nodes)] for k, q in enumerate(q1)}
    system = fo.ContactSystem(
        contact.S, contact.points, {"mean": np.r_[rng.normal(size=2 * nodes), p0], **cases}
    )
    return system, fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in cases]), p0, q1


@settings(max_examples=few(20))
@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(1, 6))
def test_uncoupled_nodes_are_limited_by_the_smallest_circle_around_their_shears(
    seed, corners, nodes
):
    rng = np.random.default_rng(seed)
    system, loads, p0, q1 = uncoupled(rng, nodes, corners)
    f = rng.uniform(0.1, 2.0, nodes)
    limit = fo.shakedown_limit(system, loads, f)
    assert limit.load_factor == pytest.approx(smallest_circle_limit(p0, q1, f), rel=1e-9)
    assert abs(limit.bound / limit.load_factor - 1) <= 1e-9


def test_corners_within_the_hull_of_others_are_left_out_and_change_nothing():
    contact = random_contact(np.random.default_rng(3), 5)
    loads = cycle()
    inner = fo.LoadCycle(
        loads.mean, [*loads.corners, {"a": 0.3}, {"a": 0.0, "b": 0.35, "c": 0.1}, {"a": 1.0}]
    )
    one, other = fo.shakedown_limit(contact, loads, 0.5), fo.shakedown_limit(contact, inner, 0.5)
    assert other.load_factor == pytest.approx(one.load_factor, rel=1e-9)
    assert one.record.left_out == ()
    assert other.record.left_out == ("corners: 3 of 6 are within the hull of the others",)


@pytest.mark.parametrize("idle", [[0], [0, 1, 2]])
def test_a_load_that_presses_some_nodes_and_leaves_others_alone_has_no_limit(idle):
    contact = random_contact(np.random.default_rng(4), 3)
    share = ~np.isin(np.arange(3), idle)
    # No slip keeps a node without cyclic load at rest, and any slip shears it.
    pressed = np.r_[0.1 * share, 0.2 * share, share]
    contact = contact.with_bonded({"press": pressed})
    limit = fo.shakedown_limit(
        contact, fo.LoadCycle({"mean": 1.0}, [{"press": 1.0}, {"press": 0.5}]), 0.5
    )
    assert limit.kind is fo.LimitKind.UNBOUNDED and limit.residual <= 1e-9 and limit.mechanism.empty


def unlike(seed):
    """A random contact whose limit depends on small multipliers, and its load cycle.

    The contact is weakly coupled, or its nodes have stiffnesses over eight decades.
    """
    rng = np.random.default_rng(seed)
    nodes, corners = int(rng.integers(4, 41)), int(rng.integers(2, 9))
    contact = random_contact(rng, nodes, coupling=10.0 ** rng.uniform(-6, 0))
    size = np.tile(10.0 ** rng.uniform(-2, 2, nodes), 3) if seed % 2 else np.ones(3 * nodes)
    cases = {
        f"{k}": np.r_[rng.normal(size=2 * nodes), 0.3 * rng.normal(size=nodes)]
        for k in range(corners)
    }
    unlike = fo.ContactSystem(
        contact.S * np.outer(size, size), contact.points, {"mean": contact.bonded["mean"], **cases}
    )
    return (
        unlike,
        fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in cases]),
        float(rng.choice([0.1, 0.3, 0.5, 1.0, 2.0])),
    )


@pytest.mark.parametrize("seed", few(range(4)))
def test_safe_slips_end_at_the_limit_and_its_slip_carries_no_more(seed):
    contact = random_contact(np.random.default_rng(seed), 6)
    limit = fo.shakedown_limit(contact, cycle(), 0.5)
    below, above = (
        fo.safe_slip(contact, cycle(), 0.5, limit.load_factor * factor)
        for factor in (1 - 1e-6, 1 + 1e-6)
    )
    assert below.exists and not above.exists and below.margin > 0 > above.margin
    assert fo.safe_slip(contact, cycle(), 0.5, limit.load_factor).exists
    q, p = at_corners(contact, cycle(), limit.load_factor, limit.slip)
    # Within all circles but for rounding, where solvers leave 1e-12 and more.
    assert (np.linalg.norm(q, axis=2) - 0.5 * p).max() < 1e-14
    march = fo.march(
        contact, cycle(), 0.5, limit.load_factor, cycles=2, initial_slip=limit.slip, steps=2
    )
    assert march.cycle_work.sum() < 1e-14


@pytest.mark.parametrize("seed", [7, 14])  # of others the oracle has no answer on some processors
def test_nodes_that_hardly_feel_the_load_do_not_move_the_limit_by_the_rounding_of_soft_slips(seed):
    """Little but its spring resists a slide of the whole body; half of the nodes stick whatever the
    load."""
    contact = random_contact(np.random.default_rng(seed), 12)
    slides = np.kron(np.eye(3, 2), np.ones((12, 1))) / np.sqrt(12)
    held = np.eye(36) - slides @ slides.T
    loaded = np.tile(np.where(np.arange(12) < 6, 1e-4, 1.0), 3)
    S = held @ contact.S @ held + 1e-6 * slides @ slides.T
    cases = {name: r if name == "mean" else r * loaded for name, r in vectors(contact).items()}
    soft = fo.ContactSystem((S + S.T) / 2, contact.points, cases)
    assert fo.shakedown_limit(soft, cycle(), 0.5).load_factor == pytest.approx(
        polygon_limit(soft, cycle(), 0.5), rel=1e-7
    )


def wedged(seed):
    """A contact of unlike nodes, its load cycle and friction.

    Slips can press the nodes thousands of times harder than the mean load.
    """
    rng = np.random.default_rng(seed)
    nodes, corners = int(rng.integers(2, 7)), int(rng.integers(2, 5))
    contact = random_contact(rng, nodes, coupling=1.0)
    size = np.tile(10.0 ** rng.uniform(-3, 3, nodes), 3)
    cases = {f"{k}": rng.normal(size=3 * nodes) for k in range(corners)}
    pressure = rng.uniform(0.5, 1.5, nodes) * np.r_[1e-3, np.ones(nodes - 1)]
    system = fo.ContactSystem(
        contact.S * np.outer(size, size),
        contact.points,
        {"mean": np.r_[np.zeros(2 * nodes), pressure], **cases},
    )
    return (
        system,
        fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in cases]),
        10.0 ** rng.uniform(-3, 1, nodes),
    )


def test_no_limit_is_below_a_load_factor_that_polygons_find_safe():
    """A mechanism that stresses the contact a little gives no bound where slips can be large."""
    compared = 0
    for seed in [6, 52, 91, 234, 319, 340, *few(range(12))]:
        system, loads, f = wedged(seed)
        limit = fo.shakedown_limit(system, loads, f)
        safe = polygon_limit(system, loads, f)
        if limit.kind.name == "FINITE" and safe is not None and np.isfinite(safe):
            assert limit.load_factor >= safe * (1 - 1e-6)
            q, p = limit.reactions
            assert (np.linalg.norm(q, axis=-1) - f * p).max() <= 1e-9
            compared += 1
    assert compared >= 3


def test_a_corner_a_little_outside_of_the_others_counts():
    """It is further out by 5e-8. That is within the tolerance of the linear program that finds it,
    and above the tolerance of the answer."""
    node, off = single(), 5e-8
    limit = fo.shakedown_limit(
        node, fo.LoadCycle({"P": 1.0}, [{"X": 1.0 + off}, {"X": -1.0}, {"X": 1.0}]), 0.5
    )
    assert limit.load_factor == pytest.approx(0.5 / (1 + off / 2), rel=2e-9)


@pytest.mark.parametrize("friction", [0.6, 1.5])
def test_a_limit_at_a_corner_of_many_cones_is_answered(friction):
    """A flange of 78 nodes, most of which are at their friction bound in the safe slip.

    A transient stays at rest just below the limit. Plain cvxpy, which knows the largest load factor
    of these badly scaled rows to a hundredth, finds no larger one.
    """
    joint = flange(12)
    limit = fo.shakedown_limit(joint, CYCLE, friction)
    below = 0.99 * limit.load_factor
    assert limit.residual <= 1e-9
    assert rests(joint, CYCLE, friction, below, initial_state=limit.state, steps=4)
    assert limit.problem.solve(solver="CLARABEL") <= 1.02 * limit.load_factor
