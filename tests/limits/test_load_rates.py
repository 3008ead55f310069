"""Rates of the shakedown limit with loads, interferences and friction.

The rates come from multipliers alone and are compared with differences of limits that are computed
again.
"""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import ALL_CASES, few
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import random_contact
from helpers.systems import CYCLE, random_system

STEP = 1e-6


def agrees(rate, limit, limit_after, slack=1e-4):
    """The rate is between the slopes on both sides.

    At a kink any value between the slopes is a rate. `limit_after(step)` is the limit after a step.
    """
    sides = []
    for step in (-STEP, STEP):
        moved = limit_after(step)
        assume(moved.open.tolist() == limit.open.tolist())
        sides.append((moved.load_factor - limit.load_factor) * np.sign(step))
    room = slack * STEP * (1 + limit.load_factor + abs(rate)) + 1e-10 * limit.load_factor
    assert min(sides) - room <= STEP * rate <= max(sides) + room


def rates_agree(contact, cycle, f, most=None, slack=1e-4):
    """Compare rates with every amplitude of the loads, with interferences, and with friction.

    Returns the limit.
    """
    n, f = contact.nodes, np.broadcast_to(f, contact.nodes)

    def limit_of(system, mean, fixed, corners, friction=f, **options):
        return fo.shakedown_limit(
            system, fo.LoadCycle(mean, corners, fixed or None), friction, slip_bound=most, **options
        )

    parts = (
        [dict(cycle.mean)],
        [dict(part) for part in cycle.fixed or ()],
        [dict(corner) for corner in cycle.corners],
    )
    limit = limit_of(contact, *parts[0], *parts[1:])
    # The rates are those of the limit with these open nodes.
    same = {"open_nodes": limit.open}
    assume(1e-2 < limit.load_factor < np.inf and limit.least == 0)
    entries = [(0, 0, case) for case in dict.fromkeys([*cycle.mean, *contact.bonded])]
    entries += [
        (kind, k, case) for kind in (1, 2) for k, loads in enumerate(parts[kind]) for case in loads
    ]
    assert len(limit.load_rates) == len(entries)
    rows = list(zip(limit.load_rates.itertuples(), entries, strict=True))
    for row, (kind, k, case) in rows[:: 1 if ALL_CASES else 2]:

        def moved(by, kind=kind, k=k, case=case):
            other = [[dict(loads) for loads in part] for part in parts]
            other[kind][k][case] = other[kind][k].get(case, 0.0) + by
            return limit_of(contact, *other[0], *other[1:], **same)

        assert row.amplitude == parts[kind][k].get(case, 0.0)
        agrees(row.rate, limit, moved, slack)
    for node in few(range(n)):
        here = np.eye(n)[node]
        fitted = contact.with_interference({"fit": here})
        agrees(
            limit.interference_rate[node],
            limit,
            lambda by, fitted=fitted: limit_of(
                fitted, {**cycle.mean, "fit": by}, *parts[1:], **same
            ),
            slack,
        )
        agrees(
            limit.friction_rate[node],
            limit,
            lambda by, here=here: limit_of(contact, *parts[0], *parts[1:], f + by * here, **same),
            slack,
        )
    return limit


@settings(max_examples=few(5))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 4),
    f=st.floats(0.1, 1.0),
    most=st.sampled_from([None, 0.05]),
    fixed=st.booleans(),
    coupling=st.sampled_from([0.0, 0.5]),
)
def test_in_the_plane(seed, nodes, f, most, fixed, coupling):
    contact = random_system(
        np.random.default_rng(seed), nodes, loads=("mean", "cyclic", "bolt"), coupling=coupling
    )
    cycle = fo.LoadCycle(
        CYCLE.mean, CYCLE.corners, fixed=[{"mean": 0.2, "bolt": 0.1}, {}] if fixed else None
    )
    limit = rates_agree(contact, cycle, f, most)
    taken = contact.with_gap(STEP * np.arange(nodes))
    lost = fo.shakedown_limit(taken, cycle, f, slip_bound=most).load_factor - limit.load_factor
    # The limit is concave in the gaps.
    assert lost <= -STEP * limit.interference_rate @ np.arange(nodes) + 1e-4 * STEP * nodes**2


@settings(max_examples=2)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 3),
    f=st.floats(0.2, 1.0),
    most=st.sampled_from([None, 0.1]),
)
def test_in_space(seed, nodes, f, most):
    contact = random_contact(np.random.default_rng(seed), nodes)
    rates_agree(contact, spatial_cycle(), f, most, slack=1e-3)


@settings(max_examples=1)
@given(seed=st.integers(0, 10**6))
def test_with_open_nodes(seed):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, 4).with_gap([0.0, 0.0, 3.0, 0.0])
    assume(fo.shakedown_limit(contact, CYCLE, 0.5).open.any())
    rates_agree(contact, CYCLE, 0.5)


def test_the_bolt_with_the_largest_rate_presses_the_node_that_limits():
    """The nodes are uncoupled. The limit is f p / |q| of the weakest node: a force on its bolt
    raises the limit by f / |q| per unit, and a force on the other bolt does not change it."""
    bonded = {
        "P": ([0.0, 0.0], [1.0, 1.0]),
        "one": ([0.0, 0.0], [1.0, 0.0]),
        "two": ([0.0, 0.0], [0.0, 1.0]),
        "Q": ([1.0, 0.4], [0.0, 0.0]),
    }
    contact = fo.ContactSystem.from_blocks(
        np.eye(2), np.zeros((2, 2)), 3 * np.eye(2), [0, 1], bonded
    )
    limit = fo.shakedown_limit(contact, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), 0.3)
    rates = limit.load_rates.set_index(["part", "load"])["rate"]
    assert rates["mean"].to_dict() == pytest.approx({"P": 0.3, "one": 0.3, "two": 0.0, "Q": 0.0})
    assert limit.interference_rate == pytest.approx([0.9, 0.0])


def test_there_are_none_without_a_finite_limit():
    contact = random_system(np.random.default_rng(0), 2)
    pressing = fo.shakedown_limit(contact, fo.LoadCycle({"mean": 1.0}, [{"mean": 1.0}]), 0.5)
    pulled = fo.shakedown_limit(contact, fo.LoadCycle({"mean": -1.0}, [{"cyclic": 1.0}]), 0.5)
    for limit in (pressing, pulled):
        assert not np.isfinite(limit.load_factor)
        assert np.isnan(limit.interference_rate).all()
        assert limit.load_rates["rate"].isna().all()
