"""Limits between two proven numbers: exact limits lie between them, and both are proven by hand."""

import warnings

import numpy as np
import pytest

import frictopt as fo
from helpers import spatial
from helpers.cases import few
from helpers.refused import refused
from helpers.separation import pulled_system
from helpers.systems import (
    CYCLE,
    NODE,
    at_corners,
    explained,
    fixed_contact,
    lifts,
    linprog_limit,
    random_system,
    stress_of,
    system,
    uncoupled,
    unit_nodes,
)

THREE = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"a": -0.5, "b": 0.3}])
GAP = 0.01


def plane(seed):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, int(rng.integers(2, 12)), loads=("mean", "a", "b"))
    return contact, THREE, rng.uniform(0.1, 1.5, contact.nodes)


def within(contact, cycle, friction, **options):
    """The limit within a gap, which is not wider than asked."""
    limit = fo.shakedown_limit(contact, cycle, friction, gap=GAP, **options)
    assert limit.kind is fo.LimitKind.FINITE and limit.residual <= 1e-9
    assert limit.gap == pytest.approx(1 - limit.load_factor / limit.bound) and limit.gap <= GAP
    return limit


def encloses(limit, exact):
    return limit.load_factor <= exact * (1 + 1e-8) and limit.bound >= exact * (1 - 1e-8)


@pytest.mark.parametrize("seed", range(few(12, least=6)))
def test_both_numbers_are_proven_by_hand_in_the_plane(seed):
    contact, cycle, f = plane(seed)
    limit = within(contact, cycle, f, open_nodes=np.zeros(contact.nodes, dtype=bool))
    assert encloses(limit, linprog_limit(contact, cycle, f)[1])
    q, p = at_corners(contact, cycle, limit.load_factor, limit.slip)
    assert (np.abs(q) - f * p).max() < 1e-9
    # The mechanism: no residual slip resists it, and the loads do more work than friction above it.
    table = limit.mechanism
    assert np.abs(stress_of(contact, table, f)).max() < 1e-7 * np.abs(contact.A).max()
    (q0, p0), (q1, p1) = contact.reaction({"mean": 1.0}), cycle.corner_reactions(contact)
    slips, lift = table.direction * table.share, lifts(table, f) * table.share
    resists = (slips * q0[table.node] + lift * p0[table.node]).sum()
    at = table.corner, table.node
    assert resists / -(slips * q1[at] + lift * p1[at]).sum() == pytest.approx(limit.bound, rel=1e-6)


@pytest.mark.parametrize("seed", range(few(12, least=6)))
def test_the_exact_limit_in_space_lies_between_both_numbers(seed):
    rng = np.random.default_rng(seed)
    contact = spatial.random_contact(rng, int(rng.integers(2, 10)))
    if seed % 3 == 1:
        contact = contact.with_orthotropic_friction(0.6)
    closed = np.zeros(contact.nodes, dtype=bool)
    f = rng.uniform(0.1, 1.0, contact.nodes)
    exact = fo.shakedown_limit(contact, spatial.cycle(), f, open_nodes=closed)
    assert encloses(within(contact, spatial.cycle(), f, open_nodes=closed), exact.load_factor)


@pytest.mark.parametrize("tangents", [1, 2])
def test_each_node_of_an_uncoupled_contact_has_a_limit_of_its_own(tangents):
    contact, p = uncoupled(np.random.default_rng(tangents), 6, tangents)
    q1 = np.reshape(contact.reaction({"cyclic": 1.0})[0], (6, tangents))
    by_hand = (0.4 * p / np.linalg.norm(q1, axis=1)).min()
    limit = within(contact, CYCLE, 0.4)
    assert encloses(limit, by_hand) and limit.bound_for_all == limit.bound


def in_plane_with_gap():
    contact, cycle, f = plane(3)
    rng = np.random.default_rng(3)
    return contact.with_gap(0.2 * rng.random(contact.nodes)), cycle, f


def with_strength(contact, cycle, f):
    width = np.ones(contact.nodes)
    strong = fo.ContactSystem(contact.S, contact.points, contact.bonded, width=width)
    return strong.with_shear_strength(0.3), cycle, f


def in_space(seed):
    contact = spatial.random_contact(np.random.default_rng(seed), 6)
    return contact, spatial.cycle(), 0.6


@pytest.mark.parametrize(
    ("contact", "cycle", "friction"),
    [
        in_plane_with_gap(),
        with_strength(*plane(4)),
        with_strength(*in_space(4)),
        fixed_contact(5),
        fixed_contact(8),
    ],
    ids=["gap", "strength", "strength in space", "fixed parts", "more fixed parts"],
)
def test_gaps_strengths_and_fixed_parts_count(contact, cycle, friction):
    closed = np.zeros(contact.nodes, dtype=bool)
    exact = fo.shakedown_limit(contact, cycle, friction, open_nodes=closed).load_factor
    limit = within(contact, cycle, friction, open_nodes=closed)
    assert exact > 0 and encloses(limit, exact)


@pytest.mark.parametrize("seed", range(few(8)))
def test_nodes_that_the_mean_load_opens_stay_open(seed):
    rng = np.random.default_rng(seed)
    contact = pulled_system(rng, 8)
    path = fo.march(contact, CYCLE, 0.5, load_factor=0.0, cycles=1)
    limit = fo.shakedown_limit(contact, CYCLE, 0.5, gap=GAP)
    assert np.array_equal(limit.open, path.gap[0] > 0)
    exact = fo.shakedown_limit(contact, CYCLE, 0.5, open_nodes=limit.open)
    if exact.load_factor > 0:
        assert encloses(limit, exact.load_factor) and limit.gap <= GAP
        assert "open" in limit.covers


def test_the_first_safe_slip_need_not_be_that_without_friction():
    # Without friction the shear of the mean load opens the second node; friction carries it.
    contact = system(
        [[1.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [3.0, 0.0]], (0.3, 0.0), (1.0, 0.5), 0.4, 0.1
    )
    closed = [False, False]
    exact = linprog_limit(contact, CYCLE, 0.6)[1]
    limit = within(contact, CYCLE, 0.6, open_nodes=closed)
    assert exact > 0 and encloses(limit, exact)


def test_a_limit_within_a_gap_has_its_proofs_and_no_rates(tmp_path):
    contact, cycle, f = plane(1)
    limit = within(contact, cycle, f)
    assert limit.reason.startswith("the limit is between") and "closed" in limit.reason
    assert limit.least == 0 and limit.least_slip(1.1 * limit.bound).bound > 0
    limit.save(tmp_path / "limit.npz")
    again = fo.results.load(tmp_path / "limit.npz")
    assert (again.load_factor, again.bound, again.gap) == (
        limit.load_factor,
        limit.bound,
        limit.gap,
    )
    assert "problem     none" in explained(limit)
    for name in ("problem", "multipliers", "load_rates", "friction_rate", "interference_rate"):
        with pytest.raises(fo.ModelError, match=name):
            getattr(limit, name)


def test_without_a_limit_the_exact_program_proves_it():
    pressed = fo.LoadCycle({"P": 1.0}, [{"N": 1.0}, {"N": 2.0, "Q": 0.1}])
    limit = fo.shakedown_limit(NODE, pressed, 0.5, gap=GAP)
    assert limit.kind is fo.LimitKind.UNBOUNDED and limit.least == 0
    pulled = fo.LoadCycle({"P": -1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    limit = fo.shakedown_limit(NODE, pulled, 0.5, gap=GAP, open_nodes=[False])
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    # Load factors below -1 would be safe, but they are not negative.
    lifted = fo.LoadCycle({"P": -1.0}, [{"N": -1.0}, {"N": -1.0, "Q": 0.1}])
    limit = fo.shakedown_limit(NODE, lifted, 0.5, gap=GAP, open_nodes=[False])
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    sheared = fo.LoadCycle({"P": 1.0}, [{"P": -1.0}, {"P": 1.0}])
    assert fo.shakedown_limit(NODE, sheared, 0.5, gap=GAP).bound == pytest.approx(1.0, rel=GAP)


def test_a_limit_of_zero_is_within_a_share_of_the_unit():
    contact = system([[1.0]], [[0.0]], 0.0, 0.0, 1.0, 0.0)
    limit = fo.shakedown_limit(contact, CYCLE, 0.5, gap=GAP, open_nodes=[False])
    assert limit.load_factor == 0 and limit.bound <= 1e-4 and limit.gap <= GAP


def test_a_gap_below_single_precision_is_not_reached_and_says_so():
    contact, cycle, f = plane(2)
    with pytest.warns(fo.ModelWarning, match="wider gap than 1e-11"):
        limit = fo.shakedown_limit(contact, cycle, f, gap=1e-11)
    assert limit.gap > 1e-11 and "3000 steps; stopped" in limit.reason
    assert encloses(limit, linprog_limit(contact, cycle, f)[1])


@refused(
    ({"events": True}, "events.*gap=None"),
    ({"slip_bound": 1.0}, "slip_bound.*gap=None"),
    ({"programs": 3}, "programs.*gap=None"),
    ({"solver": "HIGHS"}, "solver.*gap=None"),
    ({"gap": 0.0}, "gap: 0.0; it must be"),
    ({"gap": 1}, "gap: 1.*below 1"),
    ({"friction": [0.5, 0.0]}, "friction: node 1 has none.*gap=None"),
    ({"open_nodes": [True, True]}, "open_nodes: the closed nodes are too few"),
)
def test_parts_that_it_does_not_know(options):
    contact = system(np.eye(2), 0.1 * np.eye(2), 0.0, 1.0, 1.0, 0.0)
    fo.shakedown_limit(contact, CYCLE, **{"friction": 0.5, "gap": GAP} | options)


@refused((None, "loads alone open and close nodes.*open_nodes"))
def test_moving_areas_are_not_known(nothing):
    loads = {"mean": ([0, 0], [1, 0.2]), "a": ([1, 0.5], [0, 0]), "b": ([0, 0], [0, -1])}
    contact = unit_nodes(loads)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"a": -1.0}], [{"b": 0.0}, {"b": 1.0}])
    fo.shakedown_limit(contact, cycle, 0.5, gap=GAP)


@refused((None, "slide that nothing resists opens"))
def test_slides_that_open_nodes_are_not_known(nothing):
    # Two bodies that slide along the contact together with the gap of the last node.
    free = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.5])
    rng = np.random.default_rng(0)
    root = rng.normal(size=(6, 6))
    root -= np.outer(root @ free, free) / (free @ free)
    loads = {"mean": np.r_[0, 0, 0, 1.0, 1.0, 0.0], "cyclic": np.r_[0.1, 0, -0.1, 0, 0, 0]}
    points = np.column_stack([np.arange(3.0), np.zeros(3)])
    contact = fo.ContactSystem(root.T @ root, points, loads)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fo.ModelWarning)
        fo.shakedown_limit(contact, CYCLE, 0.5, gap=GAP, open_nodes=[False, False, True])


def test_an_open_node_that_touches_limits_the_load_together_with_friction():
    """The exact limit is 810 / 1111: slip of the closed node lifts the open one until it slides.

    The mechanism is that of the exact limit.
    """
    A = np.array([[4.0, -1.0], [-1.0, 4.0]])
    B = np.array([[0.0, 0.8], [-0.8, 0.0]])
    loads = {"P": ([0.0, 0.0], [1.0, -1.0]), "N": ([0.1, 0.0], [0.0, 1.5])}
    contact = fo.ContactSystem.from_blocks(A, B, A, [0.0, 1.0], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0}, {"N": -1.0}])
    close = fo.shakedown_limit(contact, cycle, 0.5, open_nodes=[False, True], gap=0.01)
    assert close.load_factor <= 810 / 1111 <= close.bound <= close.load_factor / 0.99
    exact = fo.shakedown_limit(contact, cycle, 0.5, open_nodes=[False, True])
    first = close.mechanism.head(2)
    assert first.drop(columns="share").equals(exact.mechanism.drop(columns="share"))
    assert first["share"].to_numpy() == pytest.approx(exact.mechanism["share"], abs=0.02)
