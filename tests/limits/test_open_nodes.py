"""Contacts that lift off somewhere under the mean load.

They are compared with programs whose unknowns are all slips and gaps, with transients, and with the
same question in other forms.
"""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from frictopt.limits import limit_of_set
from helpers.cases import few
from helpers.guaranteed import check as of_witness
from helpers.interrupts import interrupted
from helpers.oracle import Oracle
from helpers.separation import THREE, open_contact, open_in_space, pulled_system
from helpers.systems import CYCLE, all_closed, system, unit_nodes
from studies.validation.open_sets import largest_with_open
from studies.validation.verify import verify


@settings(max_examples=few(6))
@given(st.integers(0, 10**6), st.sampled_from([CYCLE, THREE]))
def test_the_limit_is_that_of_a_program_in_all_slips_and_gaps(seed, cycle):
    contact, friction, limit = open_contact(seed, cycle=cycle)
    full = largest_with_open(
        contact,
        cycle,
        friction,
        np.tile(limit.open, (len(cycle.corners), 1)),
        3 * limit.load_factor,
    )
    assert full is not None and limit.load_factor == pytest.approx(full[0], rel=1e-6)
    closed = largest_with_open(
        contact,
        cycle,
        friction,
        np.zeros((len(cycle.corners), contact.nodes), dtype=bool),
        3 * limit.load_factor,
    )
    assert closed is None or closed[0] <= limit.load_factor * (1 + 1e-6)
    assert limit.residual <= 1e-9 and limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
    assert limit.reason.startswith(f"with {int(limit.open.sum())} of {contact.nodes} nodes open: ")


@settings(max_examples=few(5))
@given(st.integers(0, 10**6))
def test_the_limit_in_space_is_that_of_cones_in_all_slips_and_gaps(seed):
    contact, cycle, limit = open_in_space(seed)
    assume(limit.open.any() and 1e-3 < limit.load_factor < np.inf)
    assert limit.load_factor == pytest.approx(
        Oracle(contact, cycle, 0.6, limit.open).largest(), rel=1e-6
    )
    assert limit.residual <= 1e-9 and limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
    q, p = limit.reactions
    assert not q[:, limit.open].any() and not p[:, limit.open].any()


@settings(max_examples=few(5))
@given(st.integers(0, 10**6))
def test_the_state_of_a_safe_slip_rests_and_no_slip_is_safe_beyond_the_limit(seed):
    contact, friction, limit = open_contact(seed, most_nodes=4)
    for share in (0.5, 0.999):
        safe = fo.safe_slip(contact, CYCLE, friction, share * limit.load_factor)
        # At less load, other nodes may be open.
        assert safe.exists
        assert ("and the others open" in safe.reason) == safe.open.any()
        rests = fo.steady_state(
            contact, CYCLE, friction, share * limit.load_factor, initial_state=safe.state
        )
        assert rests.outcome is fo.Outcome.SHAKEDOWN
    beyond = fo.safe_slip(contact, CYCLE, friction, 1.001 * limit.load_factor)
    assert not beyond.exists
    assert beyond.certificate is not None
    assert (
        f"open nodes that the search finds ({limit.open.sum()}); with other nodes open a slip may be safe"
        in beyond.reason
    )


def test_amplitudes_of_two_loads_with_a_node_that_stays_open():
    """Amplitudes of two loads agree with a region by hand.

    Node 0 sticks while |Q| <= 0.5 (2 - R). Node 1 is pulled open by 1 and touches where R presses
    it by 2 R = 1, before Q slips node 0.
    """
    loads = {
        "P": ([0.0, 0.0], [2.0, -1.0]),
        "Q": ([1.0, 0.0], [0.0, 0.0]),
        "R": ([0.0, 0.0], [-1.0, 2.0]),
    }
    pair = unit_nodes(loads)
    region = fo.safe_region(pair, {"P": 1.0}, ["Q", "R"], friction=0.5)
    assert region.vertices == pytest.approx(
        np.array([[1.0, 0.0], [0.75, 0.5], [0.0, 0.5]]), abs=1e-8
    )
    ruling = [side.iloc[0][["node", "direction"]].tolist() for side in region.mechanisms]
    assert [node for node, _ in ruling] == [0, 1]


@settings(max_examples=few(5))
@given(st.integers(0, 10**6))
def test_every_cycle_above_the_limit_slips_as_much_as_is_proven_while_the_open_nodes_carry_nothing(
    seed,
):
    contact, friction, limit = open_contact(seed)
    above = 1.2 * limit.load_factor
    least = limit.least_slip(above)
    try:
        path = fo.march(contact, CYCLE, friction, above, cycles=3)
    except fo.FrictoptError:
        assume(False)
    ends = np.searchsorted(path.time, np.arange(1, 7) + 1e-9) - 1
    assume(path.p[ends[-2:]][:, limit.open].max() == 0.0)
    slip, gap = path.slip[ends[-2:]], path.gap[ends[-2:]]
    assert least.of(slip, gap) >= least.bound - 1e-8 * (1 + np.abs(slip).max())


def test_closed_nodes_without_mean_load_rest_until_a_gap_closes():
    """Two nodes in space do not feel each other. The mean load opens the first node by 0.1; the
    second node, whose shear is 0.1 times its pressure, rests under any cyclic load. From 0.1 on the
    first node closes, without shear."""
    still, shear = np.zeros((2, 2)), np.array([[0.0, 0.0], [0.1, 0.0]])
    bonded = {
        "mean": (still, np.array([-0.1, 0.0])),
        "press": (shear, np.ones(2)),
        "lift": (-shear, np.array([-1.0, 1.0])),
    }
    contact = fo.ContactSystem(np.eye(6), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], bonded)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"press": 1.0}, {"lift": 1.0}])
    best = fo.shakedown_limit(contact, cycle, 0.5, open_nodes=[True, False])
    assert best.load_factor == pytest.approx(0.1)
    assert fo.shakedown_limit(contact, cycle, 0.5).load_factor == np.inf
    assert fo.shakedown_limit(contact, cycle, 0.09).load_factor == 0


def test_an_open_node_may_slip_farther_than_the_largest_slip():
    contact = system(np.eye(2), np.zeros((2, 2)), [0.4, 3.0], [1.0, -0.5], [1.0, 0.0], 0.0)
    safe = fo.safe_slip(contact, CYCLE, 0.5, 0.3)
    assert safe.open.tolist() == [False, True] and safe.slip[1] == pytest.approx(-3.0)
    assert 0.2 <= safe.largest_slip == abs(safe.slip[0]) < 1.0


@pytest.mark.parametrize("seed", [3, 8, 12, 19])
def test_transients_verify_a_guaranteed_limit_with_open_nodes(seed):
    """Slip goes on from the witness just above it, and dies out from random slips just below."""
    rng = np.random.default_rng(seed)
    contact = pulled_system(rng, int(rng.integers(2, 7)))
    friction = rng.uniform(0.1, 1.0, contact.nodes)
    limit = fo.guaranteed_limit(contact, CYCLE, friction)
    of_witness(limit)
    check = verify(limit, starts=10, moved=1)
    above = check.runs[check.runs["start"] == "witness"]
    assert limit.open.any()
    assert limit.node is not None
    assert check.persists
    assert above["outcome"].tolist() == ["CYCLIC_SLIP"]
    assert check.dies_out
    assert not check.undecided
    assert check.residual <= 1e-9
    assert set(check.runs["start"]) == {"witness", "moved witness", "random"}


@pytest.mark.parametrize("seed", [14, 15])
def test_starts_from_which_nodes_open_and_close_slip_for_ever_below_a_guaranteed_limit(seed):
    rng = np.random.default_rng(seed)
    contact = pulled_system(rng, int(rng.integers(2, 7)))
    friction = float(rng.uniform(0.1, 1.0))
    limit = fo.guaranteed_limit(contact, CYCLE, friction)
    assert not verify(limit, starts=60, moved=1).dies_out
    assert limit.reason.endswith(
        "starts with nodes that open and close in every cycle may slip for ever below it"
    )


@pytest.mark.parametrize("solver", ["CLARABEL", "INTERIOR_POINT"])
@pytest.mark.parametrize("seed", [1, 5, 17])
def test_that_nothing_is_safe_with_all_nodes_closed_is_proven_by_multipliers(seed, solver):
    """Multipliers prove that no load factor is safe with all nodes closed.

    The multipliers are slips and openings that stress nothing. The mean load does work on them, and
    the cyclic load does none.
    """
    contact, cycle, limit = open_in_space(seed)
    claim = all_closed(contact, cycle, 0.6, solver=solver)
    motion = claim._motion
    (q0, p0) = contact.closed_reaction(cycle.mean)
    (q1, p1) = cycle.corner_reactions(contact)
    assert limit.open.any()
    assert claim.kind is fo.LimitKind.NO_SAFE_SLIP
    assert claim.residual <= 1e-9
    assert not claim.open.any()
    work = [
        float((motion.moves[:, :-1].swapaxes(1, 2) * q).sum() + (motion.moves[:, -1] * p).sum())
        for q, p in ((q0, p0), (q1, p1))
    ]
    assert work[0] < -1e-3 * motion.size.sum() and work[1] <= 1e-7 * motion.size.sum()
    assert (
        np.abs(contact.S[: -contact.nodes] @ motion.moves.sum(axis=0).ravel()).max()
        <= 1e-7 * motion.size.sum()
    )
    assert motion.opening.min() >= 0


def test_nodes_that_open_beyond_a_jump_are_left_out():
    """Friction exceeds its critical value at the first node. The exact path under the mean load
    ends at a jump, beyond which this node is open."""
    A = [[1.351, 2.040], [2.040, 7.362]]
    B = [[-2.027, -3.535], [0.386, 0.939]]
    C = [[7.626, -2.224], [-2.224, 1.063]]
    bonded = {"mean": ([-0.201, 0.0592], [0.0, 1.568]), "cyclic": ([1.0, 0.5], [0.5, 0.1])}
    contact = fo.ContactSystem.from_blocks(A, B, C, [0.0, 1.0], bonded)
    friction = np.array([0.727, 0.558])
    with pytest.raises(fo.NoContinuation, match="would jump"):
        fo.steady_state(contact, CYCLE, friction, 0.0)
    limit = fo.shakedown_limit(contact, CYCLE, friction)
    assert limit.open.tolist() == [True, False]
    full = largest_with_open(
        contact, CYCLE, friction, np.tile(limit.open, (2, 1)), 3 * limit.load_factor
    )
    assert full is not None and limit.load_factor == pytest.approx(full[0], rel=1e-7)


def test_a_closed_node_without_friction_is_named_where_others_are_open():
    """Node 0 is pulled open, node 1 pressed, and node 2 pressed without friction."""
    loads = {"P": [0, 0, 0, 0, 0, 0, -1, 1, 1], "X": [0, 1, 1, 0, 0, 0, 0, 0, 0]}
    three = fo.ContactSystem(np.eye(9), [[0, 0, 0], [1, 0, 0], [2, 0, 0]], loads)
    limit = fo.shakedown_limit(
        three, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), [0.5, 0.5, 0.0]
    )
    assert limit.open.tolist() == [True, False, False] and limit.load_factor == 0.0
    assert "node 2 has no friction" in limit.reason and set(limit.mechanism["node"]) == {2}


def test_no_limit_is_called_none_if_the_answer_of_the_settled_nodes_failed(monkeypatch):
    """A node is pulled open, so that no slip is safe with all nodes closed."""
    contact = pulled_system(np.random.default_rng(6), 4)
    assert fo.shakedown_limit(contact, CYCLE, 0.5).open.any()

    def failing(question, *rest, **options):
        if question.open_nodes.any():
            raise fo.SolverError("rounding")
        return limit_of_set(question, *rest, **options)

    monkeypatch.setattr("frictopt.limits.shakedown.limit_of_set", failing)
    with pytest.raises(fo.SolverError, match="rounding"):
        fo.shakedown_limit(contact, CYCLE, 0.5)


@pytest.mark.parametrize(
    ("shear", "stiff", "held"), [(0.0, 1.0, True), (0.5, 1.0, False), (0.0, 0.0, False)]
)
def test_open_nodes_may_be_free_aside_where_no_load_takes_them_and_nowhere_else(shear, stiff, held):
    """Open nodes may be free to move only in directions in which no load acts.

    Nothing resists the slip of node 1. While it is open, nothing carries its shear, or, without
    stiffness, its lift. The other node carries f p.
    """
    bonded = {"P": ([0.0, 0.0], [1.0, -1.0]), "Q": ([1.0, shear], [0.0, 0.0])}
    contact = fo.ContactSystem.from_blocks(
        np.diag([1.0, 0.0]), np.zeros((2, 2)), np.diag([1.0, stiff]), [0.0, 1.0], bonded
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    if held:
        assert fo.shakedown_limit(
            contact, cycle, 0.5, open_nodes=[False, True]
        ).load_factor == pytest.approx(0.5, rel=1e-9)
    else:
        with pytest.raises(fo.ModelError, match="the closed nodes are too few"):
            fo.shakedown_limit(contact, cycle, 0.5, open_nodes=[False, True])


def test_an_interrupted_search_keeps_a_proven_limit():
    flat = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    rounded = flat.with_gap(2.0 * flat.x**4)
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    with interrupted("open nodes", 3) as stopped:
        fo.shakedown_limit(rounded, cycle, 0.6)
    limit = stopped.value.limit
    assert limit.load_factor > 0 and limit.residual < 1e-9
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
