"""Kinds of limits and their reasons, in repr and `explain()`, in the plane and in space."""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, all_closed, explained, random_system, system, unit_nodes
from studies.validation.fuzz.embedded import embedded

ASK = (fo.shakedown_limit, fo.guaranteed_limit)


def in_plane(contact):
    return contact


def in_space(contact):
    # A contact that is soft across is refused or not by rounding where the limit is 0.
    return embedded(contact, np.random.default_rng(0), across=contact.A)[0]


SPACES = pytest.mark.parametrize("place", [in_plane, in_space])


def plain(n, *loads, B=0.0):
    """Nodes of unit stiffness."""
    return system(np.eye(n), np.broadcast_to(B, (n, n)), *loads)


COUPLED = random_system(np.random.default_rng(0), 2)
SHEARED = plain(1, 3.0, 1.0, 1.0, 0.0)
HELD = plain(2, 0.0, 1.0, 0.4, 1.0, B=[[0.0, 0.1], [-0.1, 0.0]])
ALONE = plain(1, 0.0, 1.0, 1.0, 0.0)
PRESSING = fo.LoadCycle({"mean": 1.0}, [{"mean": 1.0}, {"mean": 2.0}])
ONE_WAY = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}])
UNLOADED, PRESSED = fo.LoadCycle({}, CYCLE.corners), fo.LoadCycle({}, [{"mean": 1.0}])
WITHIN = {"slip_bound": 0.1}
ENDLESS = "every load factor has a safe residual slip; "
NO_GROWTH = "at no node does the cyclic shear exceed f p"
STAYS = NO_GROWTH + ", so the residual slip stays bounded"
FOLLOWS = [
    "a slip that grows with the load keeps every node within its friction bound; ",
    "pass slip_bound",
]
FINITE, UNBOUNDED, NONE = fo.LimitKind.FINITE, fo.LimitKind.UNBOUNDED, fo.LimitKind.NO_SAFE_SLIP
CASES = {  # contact, cycle, options, kind
    "finite": (COUPLED, CYCLE, {}, FINITE),
    "pressing": (COUPLED, PRESSING, {}, UNBOUNDED),
    "pressed as much as sheared": (HELD, ONE_WAY, {}, UNBOUNDED),
    "pressed within a slip bound": (HELD, ONE_WAY, WITHIN, UNBOUNDED),
    "following": (ALONE, ONE_WAY, {}, UNBOUNDED),
    "still": (COUPLED, fo.LoadCycle({"mean": 1.0}, [{}]), {}, UNBOUNDED),
    "still at the contact": (plain(2, 0.0, 1.0, 0.0, 0.0), CYCLE, {}, UNBOUNDED),
    "pulled": (plain(2, 0.0, -1.0, 1.0, 0.0, B=0.1), CYCLE, {}, NONE),
    "pulled alone": (plain(1, 0.0, -1.0, 1.0, 0.0), CYCLE, {}, NONE),
    "half open": (plain(2, 0.0, [1.0, -0.5], 1.0, 0.0), CYCLE, {}, FINITE),
    "unloaded": (COUPLED, UNLOADED, {}, FINITE),
    "unloaded within a slip bound": (COUPLED, UNLOADED, WITHIN, FINITE),
    "pressed by the corner alone": (COUPLED, PRESSED, {}, UNBOUNDED),
    "bounded": (SHEARED, CYCLE, WITHIN, NONE),
}
TEXTS = {
    "finite": ["is safe above it"],
    "pressing": ["the shakedown limit is infinite: " + ENDLESS + NO_GROWTH],
    "pressed as much as sheared": [STAYS],
    "pressed within a slip bound": ["within the slip bound; ", STAYS],
    "following": FOLLOWS,
    "still": ["the corners carry no load"],
    "still at the contact": ["the corners carry no load"],
    "pulled": ["compression must be positive", "sum to -2"],
    "pulled alone": ["compression must be positive", "sum to -1"],
    "half open": ["with 1 of 2 nodes open: "],
    "unloaded": ["any load factor above 0", "the mean load is zero"],
    "unloaded within a slip bound": ["the mean load is zero"],
    "pressed by the corner alone": ["every load factor"],
    "bounded": ["within the slip bound", "larger slip_bound", "exceed"],
}


@SPACES
@pytest.mark.parametrize("simplify", few([True, False], 1))
@pytest.mark.parametrize("ask", ASK)
@pytest.mark.parametrize("name", CASES)
def test_every_limit_says_its_kind_and_why(ask, name, simplify, place):
    contact, cycle, options, kind = CASES[name]
    limit = ask(place(contact), cycle, 0.5, simplify=simplify, **options)
    number = limit.load_factor
    assert limit.kind is kind
    assert {
        fo.LimitKind.FINITE: np.isfinite,
        fo.LimitKind.UNBOUNDED: np.isposinf,
        fo.LimitKind.NO_SAFE_SLIP: np.isnan,
    }[kind](number)
    assert (number == 0) == name.startswith("unloaded") and limit.residual <= 1e-9
    if kind is not fo.LimitKind.FINITE:
        rates = (limit if ask is fo.shakedown_limit else limit.shakedown).friction_rate
        assert all(np.isnan(values).all() for values in (limit.slip, *limit.reactions, rates))
        assert (
            kind is fo.LimitKind.UNBOUNDED
            or ask is fo.guaranteed_limit
            or set(limit.mechanism.node) == set(range(contact.nodes))
        )
    printed = explained(limit)
    if ask is fo.shakedown_limit or limit.node is None:
        for text in TEXTS[name]:
            assert text in limit.reason and text in printed
    assert limit.reason in repr(limit) and f"kind={kind.name}" in repr(limit)


@SPACES
def test_a_contact_that_locks_itself_says_so(place):
    """A slip presses the node 2.5 times as much as it shears it. With f = 0.5 the slip may follow
    any load; with f = 0.3 it helps up to a limit."""
    wedge = place(system(np.eye(1), [[2.5]], 0.0, 1.0, 1.0, 0.0))
    locked = fo.shakedown_limit(wedge, CYCLE, 0.5)
    assert locked.kind is fo.LimitKind.UNBOUNDED
    assert "wedges the contact tighter (self-locking with f = 0.5)" in locked.reason
    assert "pass slip_bound" in locked.reason
    assert fo.shakedown_limit(wedge, CYCLE, 0.3).kind is fo.LimitKind.FINITE
    bounded = fo.shakedown_limit(wedge, CYCLE, 0.5, slip_bound=0.4)
    assert bounded.load_factor == pytest.approx(0.5 * (1 + 2.5 * 0.4) - 0.4)
    assert bounded.largest_slip == pytest.approx(0.4)


def test_the_reason_of_a_witness_names_node_and_corners():
    contact = random_system(np.random.default_rng(3), 3)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.4)
    assert limit.node is not None
    forward, backward = (CYCLE.corner_names[corner] for corner in limit.corners)
    assert limit.reason.startswith(
        f"node {limit.node} is on its bound of forward slip at the corner ({forward}) and of backward slip at ({backward})"
    )


@pytest.mark.parametrize("ask", ASK)
@pytest.mark.parametrize(
    "scene",
    [fo.scenes.PunchOnHalfPlane(elements=8), fo.scenes.RoundedPunch()],
    ids=["square", "rounded"],
)
@pytest.mark.parametrize("stress", [1.0, -1.0], ids=["tension", "compression"])
def test_a_static_bulk_stress_of_any_size_has_a_safe_slip(ask, scene, stress):
    """A uniform stress stretches the flat surface, and a slip that follows it leaves the punch free
    of force. The stiffness has the rounding of a condensation, and the reactions are zero only up
    to it."""
    contact = scene.condense()
    q, p = contact.reaction({"sigma": stress})
    stretch = np.linalg.lstsq(np.vstack([contact.A, contact.B]), -np.r_[q, p], rcond=None)[0]
    left = np.abs(np.r_[q + contact.A @ stretch, p + contact.B @ stretch]).max()
    assert left <= 1e-12 * np.abs(np.r_[q, p]).max()

    limit = ask(contact, fo.LoadCycle({"P": 1.0}, [{"sigma": stress}]), 0.3)
    assert limit.kind is fo.LimitKind.UNBOUNDED
    assert limit.load_factor == np.inf


@pytest.mark.parametrize("coupling", [1e-3, 1e-5, 1e-7, 1e-9])
def test_a_weak_coupling_is_no_infinite_limit(coupling):
    """One node has q = load factor + v and p = 1 + coupling * v. A slip v = -load factor keeps it
    pressed up to 1 / coupling, for each friction. If rounding hides this limit, the answer is an
    error."""
    loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    node = fo.ContactSystem.from_blocks([[1.0]], [[coupling]], [[1.0]], [0.0], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}])
    try:
        limit = fo.shakedown_limit(node, cycle, 0.3)
    except fo.SolverError as error:
        assert coupling < 1e-6
        assert "coupling so weak" in str(error)
    else:
        assert limit.load_factor == pytest.approx(1 / coupling, rel=1e-9)


def test_a_problem_without_a_safe_slip_has_the_multipliers_that_prove_it():
    """The loads of two corners ask for shear forces that differ by 2, friction allows 1.

    The first solver says so, and the multipliers stand in the problem: times the rows they give a
    negative bound, while no slip changes their sum.
    """
    loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    node = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}], fixed=[{"Q": 1.0}, {"Q": -1.0}])
    limit = fo.shakedown_limit(node, cycle, 0.5, open_nodes=[False])
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    (attempt,) = limit.record.attempts
    assert attempt.outcome == "infeasible"
    multipliers = {row.label: row.dual_value for row in limit.problem.constraints}
    ends = np.concatenate([multipliers["q[0]"], multipliers["q[1]"]])
    bounds = np.concatenate([multipliers["stuck[0]"], multipliers["stuck[1]"]])
    assert ends.sum() == pytest.approx(0.0, abs=1e-9) and (bounds > 0).all()
    assert 0.5 * bounds.sum() + ends @ [1.0, -1.0] < -1e-3


@pytest.mark.parametrize("pulled", [True, False])
def test_a_node_that_only_slip_presses_is_named(pulled):
    """Slip of node 0, at most f, presses node 1 by half of the slip: |0.1 lam| <= f (f / 2 + p)."""
    p, f = -0.05 if pulled else 0.05, 0.5
    pair = system(np.eye(2), [[0.0, 0.0], [-0.5, 0.0]], [0.0, 0.0], [1.0, p], [0.0, 0.1], 0.0)
    limit = all_closed(pair, CYCLE, f)
    assert limit.load_factor == pytest.approx(f * (f / 2 + p) / 0.1)
    sentence = "only residual slip presses node 1, which governs the limit"
    assert (sentence in limit.reason) == pulled


def test_a_node_that_slip_unloads_is_named():
    contact = random_system(np.random.default_rng(9), 3, coupling=1.0)
    limit = fo.guaranteed_limit(contact, CYCLE, 1.0)
    largest = np.abs(limit.slip).max()
    assert f"up to {largest:.3g} can unload it completely under the mean load" in limit.reason
    q, p = limit.reactions
    assert limit.load_factor == 0 and np.abs([q[:, limit.node], p[:, limit.node]]).max() < 1e-9


@pytest.mark.parametrize(("friction", "wedges"), [(1.9, False), (2.1, True)])
def test_a_node_that_may_wedge_itself_is_named(friction, wedges):
    """With A = 1 and B = 1/2 its critical friction is A / |B| = 2 (Klarbring 1990)."""
    node = system(np.eye(1), [[0.5]], 0.0, 1.0, 1.0, 0.0)
    limit = fo.guaranteed_limit(node, CYCLE, friction)
    assert limit.node == 0 and ("may wedge itself" in limit.reason) == wedges
