"""Contacts whose mean load alone is not safe, while the corners press the nodes.

The safe load factors form an interval that does not begin at 0.
"""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.liars import misread
from helpers.systems import CYCLE, NODE, SEEDS, excess, linprog_limit, random_system, unit_nodes
from studies.validation.verify import verify

Z = [0.0, 0.0]
PRESSING = fo.LoadCycle({"P": 1.0}, [{"N": 1.0, "Q": 1.0}, {"N": 1.0, "Q": -1.0}])
PULLED = {"P": (Z, [-1.0, 1.0]), "N": (Z, [1.0, 0.0]), "Q": ([0.1, 0.3], Z)}
GAPED = {**PULLED, "P": (Z, [0.2, 1.0])}
# Node 0 sticks if 0.1 lam <= 0.5 (lam - 1), node 1 if 0.3 lam <= 0.5; the second contact is the
# same by a gap that the mean load does not close.
TWO = unit_nodes(PULLED)
GAP = TWO.with_bonded(GAPED).with_gap([1.2, 0.0])
PULL = fo.LoadCycle({"P": -1.0}, [{"N": 1.0, "Q": 0.1}, {"N": 1.0, "Q": -0.1}])


def oracle(contact, cycle, friction, most=None, upper=()):
    """The least and the largest load factor of all rows of all corners over raw slips."""
    return tuple(
        linprog_limit(contact, cycle, friction, most, upper, least=least)[1]
        for least in (True, False)
    )


def pressing_cycle(rng, nodes, corners=3):
    """A random contact whose mean load pulls some nodes or leaves them open.

    The corners press all nodes, some more and some less.
    """
    contact = random_system(
        rng, nodes, loads=("mean", *"abc"[:corners]), coupling=rng.choice([0.0, 0.3, 1.0])
    )
    press = rng.uniform(0.0, 1.5, nodes)
    loads = {
        name: (0.3 * rng.normal(size=nodes), press + 0.2 * rng.normal(size=nodes))
        for name in "abc"[:corners]
    }
    contact = contact.with_bonded(
        {"mean": (0.1 * rng.normal(size=nodes), rng.uniform(-1.0, 1.0, nodes)), **loads}
    )
    contact = contact.with_gap(0.3 * rng.random(nodes) * (rng.random(nodes) < 0.3))
    return contact, fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in "abc"[:corners]])


@pytest.mark.parametrize("simplify", [True, False])
@pytest.mark.parametrize("contact", [TWO, GAP], ids=["pulled", "gap"])
def test_two_uncoupled_nodes_by_hand(contact, simplify):
    """Below 1 node 0 is open, and node 1 sticks: the interval of this set comes first."""
    first = fo.shakedown_limit(contact, PRESSING, 0.5, simplify=simplify)
    assert (first.least, first.load_factor) == (0.0, pytest.approx(1.0))
    assert first.intervals == pytest.approx(np.array([[0.0, 1.0], [1.25, 5 / 3]]))
    closed = np.zeros(2, dtype=bool)
    limit = fo.shakedown_limit(contact, PRESSING, 0.5, simplify=simplify, open_nodes=closed)
    assert (limit.least, limit.load_factor) == pytest.approx((1.25, 5 / 3), rel=1e-12)
    assert limit.record.solver == "HIGHS"
    assert "no slip is safe below 1.25: " in limit.reason
    assert "no residual slip is safe above it" in limit.reason
    assert "least=1.25" in repr(limit)
    for load_factor, safe in ((1.2, False), (1.3, True), (1.6, True), (1.7, False)):
        assert fo.steady_state(contact, PRESSING, 0.5, load_factor).outcome.name == (
            "SHAKEDOWN" if safe else "CYCLIC_SLIP"
        )
        assert fo.safe_slip(contact, PRESSING, 0.5, load_factor).exists == safe


@pytest.mark.parametrize("solver", [None, "HIGHS", "CLARABEL", "HIGHS_IPM"])
def test_one_node_without_a_largest_load_factor(solver):
    limit = fo.shakedown_limit(NODE, PULL, 0.5, solver=solver)  # 0.1 lam <= 0.5 (lam - 1)
    assert limit.kind is fo.LimitKind.UNBOUNDED
    assert limit.least == pytest.approx(1.25, rel=1e-9)
    assert limit.residual <= 1e-9
    assert limit.reason.startswith(
        "the shakedown limit is infinite: every load factor from 1.25 on has a safe residual slip; at no node does the cyclic"
    )
    assert "no slip is safe below 1.25: the mean load pulls the bodies apart" in limit.reason


@settings(max_examples=few(12))
@given(
    seed=SEEDS,
    nodes=st.integers(1, 5),
    corners=st.integers(1, 3),
    f=st.just(0.0) | st.floats(0.01, 1.5),
    most=st.none() | st.floats(0.05, 1.0),
)
@example(seed=160, nodes=2, corners=1, f=1.0, most=None)  # nodes open and close in the cycle
@example(seed=34, nodes=2, corners=2, f=1.0, most=None)  # and it rests again at larger loads
def test_the_interval_by_linear_programs_over_raw_slips(seed, nodes, corners, f, most):
    contact, cycle = pressing_cycle(np.random.default_rng(seed), nodes, corners)
    least, largest = oracle(contact, cycle, f, most)
    limits = [
        fo.shakedown_limit(contact, cycle, f, slip_bound=most, simplify=simplify)
        for simplify in (True, False)
    ]
    for limit in limits:
        if "for all openings and closings" in limit.covers and not np.isnan(largest):
            # Nodes may open and close: all that is safe with closed nodes is safe, and more may be.
            assert any(
                low <= least * (1 + 1e-7) + 1e-8 and largest * (1 - 1e-7) - 1e-8 <= high
                for low, high in limit.intervals
            )
            continue
        if limit.open.any():  # the oracle keeps all nodes closed
            assert np.isnan(largest)
            continue
        assert limit.least == pytest.approx(least, rel=1e-7, abs=1e-8, nan_ok=True)
        assert limit.residual <= 1e-9
        assert limit.load_factor == pytest.approx(largest, rel=1e-7, abs=1e-8, nan_ok=True)


def test_constraints_may_leave_no_small_load_factor():
    model = fo.ShakedownModel(random_system(np.random.default_rng(1), 3), CYCLE)
    whole = model.solve(0.4)
    assert whole.least == 0
    limit = model.solve(0.4, [(model.load_factor >= 0.25 * whole.load_factor).set_label("more")])
    assert limit.least == pytest.approx(0.25 * whole.load_factor)
    assert limit.reason.endswith(f"no slip is safe below {limit.least:.6g}")
    chosen = model.solve(
        0.4, [model.load_factor == 0.5 * whole.load_factor], objective=-cp.norm1(model.slip)
    )
    assert np.isnan(chosen.least)  # the load factor that an objective chooses is no limit


SOLID = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "N": [0, 0, 1], "X": [1, 0, 0]})
TO_AND_FRO = fo.LoadCycle({"P": -1.0}, [{"N": 1.0, "X": 0.2}, {"N": 1.0, "X": -0.2}])


@pytest.mark.parametrize(
    ("contact", "cycle", "least"),
    [(TWO, PRESSING, 1.25), (SOLID, TO_AND_FRO, 1 / (1 - 0.2 / 0.5))],
    ids=["plane", "space"],
)
@pytest.mark.parametrize(
    ("share", "proof", "right"),
    [(1, 1, True), (1 + 1e-8, 1, False), (1 - 1e-8, 1, False), (1.2, 1, False), (1.2, 1.2, False)],
)
def test_a_least_load_factor_that_is_not_the_least_is_not_accepted(
    share, proof, right, contact, cycle, least, monkeypatch
):
    """A value above the least is refused because its multipliers do not prove it, or because
    multipliers of more work balance nothing. A value below the least has no safe slip."""

    def lie(program, x, y):
        if program.cost[0] > 0:  # the load factor, which comes first, is minimised
            x[0] *= share
            y *= proof

    misread(monkeypatch, lie)
    closed = np.zeros(contact.nodes, dtype=bool)
    assert fo.shakedown_limit(contact, cycle, 0.5, open_nodes=closed).least == (
        pytest.approx(least, rel=1e-9) if right else pytest.approx(np.nan, nan_ok=True)
    )


@pytest.mark.parametrize("contact", [TWO, GAP], ids=["pulled", "gap"])
def test_shakedown_of_an_uncoupled_contact_is_a_theorem_within_the_interval(contact):
    """Of the two intervals with a state of rest the first one counts."""
    limit = fo.guaranteed_limit(contact, PRESSING, 0.5)
    assert limit.proven and (limit.least, limit.load_factor) == pytest.approx((0.0, 1.0))
    check = verify(limit, starts=20, moved=0)
    runs = check.runs
    assert check.dies_out
    assert check.persists
    assert set(runs.loc[runs["share"] < 1, "load_factor"].round(6)) == {0.98}
    endless = fo.guaranteed_limit(NODE, PULL, 0.5)
    assert endless.proven
    assert endless.least == pytest.approx(1.25)
    assert endless.load_factor == np.inf
    assert "from 1.25 on" in endless.reason


def test_where_rounding_hides_the_least_load_factor_the_limit_stands_and_says_so():
    """The contact is pulled on faces that only just lock themselves. Whether its mean load alone is
    safe depends on the last digits."""
    blade = fo.fem.Material(E=10.0, nu=0.3)
    contact = fo.scenes.Dovetail(
        angle=60, elements=40, grading=100, growth=1.8, blade_material=blade
    ).condense()
    cycle = fo.LoadCycle({"pull": 1.0}, [{"pull": -0.3, "sway": -0.3}] * 2)
    f = 0.6994592257251427 * (1 + 2e-6)
    limit = fo.shakedown_limit(contact, cycle, f)
    assert limit.load_factor == np.inf
    assert limit.least == 0 or (
        np.isnan(limit.least) and "rounding hides the load factor" in limit.reason
    )
    if np.isnan(limit.least):
        with pytest.raises(fo.SolverError, match="rounding hides"):
            fo.guaranteed_limit(contact, cycle, f)


@pytest.mark.parametrize(("most", "least"), [(None, 0.0), (0.05, 0.86875), (0.0, 1.25)])
@pytest.mark.parametrize("simplify", [True, False])
def test_the_least_load_of_a_mirror_symmetric_pair_that_the_mean_load_alone_shears_too_much(
    most, least, simplify
):
    """A bound on slip gives a mirror-symmetric pair a least load in closed form.

    Opposed slips of -a take 3 a off the shear 1 + 0.1 lam and add 0.1 a to the pressure 1 + lam.
    The pair rests from the load factor on at which a equals its bound `most`.
    """
    loads = {"P": (np.zeros(2), np.ones(2)), "Q": ([1.0, -1.0], np.zeros(2))}
    pair = fo.ContactSystem.from_blocks(
        [[2.0, -1.0], [-1.0, 2.0]], [[0.1, 0.2], [-0.2, -0.1]], 2 * np.eye(2), [0.0, 1.0], loads
    )
    cycle = fo.LoadCycle({"P": 1.0, "Q": 1.0}, [{"P": 1.0, "Q": 0.1}, {"P": 1.0, "Q": -0.1}])
    limit = fo.shakedown_limit(pair, cycle, 0.5, slip_bound=most, simplify=simplify)
    assert limit.load_factor == np.inf and limit.least == pytest.approx(least, abs=1e-9)


UP, DOWN = {"P": [0, 0, 1], "N": [0, 0, 1], "X": [1, 0, 0], "Y": [0, 1, 0]}, {"P": -1.0}
THREE = [(0.3, 0.0), (-0.1, 0.2), (-0.1, -0.2)]


def node_and_cycle():
    """A node that the mean load pulls; three corners press it and shear it in three directions."""
    return fo.ContactSystem(np.eye(3), [[0, 0, 0]], UP), fo.LoadCycle(
        DOWN, [{"N": 1.0, "X": x, "Y": y} for x, y in THREE]
    )


def test_one_node_by_the_smallest_circle_around_its_corners():
    """The smallest circle around the shears of one node gives its interval of safe load factors.

    Slip moves the centre of the shears. The node sticks if the smallest circle, of radius r, fits
    into the friction circle: r lam <= f (lam - 1).
    """
    node, cycle = node_and_cycle()
    # On the axis, as far from (0.3, 0) as from (-0.1, 0.2).
    centre = (0.3**2 - 0.1**2 - 0.2**2) / (2 * (0.3 + 0.1))
    radius = 0.3 - centre
    assert np.hypot(-0.1 - centre, 0.2) == pytest.approx(radius)
    limit = fo.shakedown_limit(node, cycle, 0.5)
    assert limit.kind is fo.LimitKind.UNBOUNDED
    assert limit.least == pytest.approx(0.5 / (0.5 - radius), rel=1e-9)
    assert limit.residual <= 1e-9
    for sentence in (
        "every load factor from {} on has a safe residual slip",
        "no slip is safe below {}",
    ):
        assert sentence.format(f"{limit.least:.6g}") in limit.reason
    for share, exists in ((0.999, False), (1.001, True)):
        assert fo.safe_slip(node, cycle, 0.5, share * limit.least).exists == exists
    below, within = (
        fo.steady_state(node, cycle, 0.5, share * limit.least).outcome for share in (0.95, 1.05)
    )
    assert below is not fo.Outcome.SHAKEDOWN and within is fo.Outcome.SHAKEDOWN


def test_a_mean_load_that_settles_is_safe(punch):
    """The slip that the mean load leaves is safe; zero slip and that of the limit are not."""
    contact = punch(8)
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": 0.5}])
    limit = fo.shakedown_limit(contact, cycle, 0.1)
    assert limit.least == 0 and limit.load_factor > 0
    for slip in (0 * limit.slip, limit.slip):
        assert excess(contact, cycle, 0.1, 0.0, slip) > 1e-3
