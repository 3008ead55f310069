"""The proof that no other open nodes among given ones are better, against every set of them."""

from functools import cache
from itertools import product

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import loose_nodes, pose, with_open
from helpers.cases import ALL_CASES, few
from helpers.separation import lifted_system, open_in_space, pulled_system
from helpers.systems import CYCLE, FIRST_PAIR, system
from validation.fuzz.cases import random_case

CONTACT = system(*FIRST_PAIR)


@cache
def pulled(seed):
    """A random contact with gaps and pulled nodes, its cycle and friction."""
    rng = np.random.default_rng([seed, 31])
    return pulled_system(rng, int(rng.integers(2, 6))), CYCLE, float(rng.uniform(0.1, 1.0))


@cache
def lifted(seed):
    """A random contact that is closed under its mean load, and that the cyclic load lifts."""
    rng = np.random.default_rng([seed, 32])
    contact = lifted_system(rng, int(rng.integers(2, 6)))
    return contact, CYCLE, float(rng.uniform(0.2, 1.5))


@cache
def spatial(seed):
    """A random contact in space with nodes that the mean load leaves open."""
    contact, cycle, _ = open_in_space(seed, nodes=4)
    return contact, cycle, 0.6


@cache
def limit_of_set(case, seed, opened):
    """The limit with a set of open nodes by its own program; None if it has none."""
    contact, cycle, friction = case(seed)
    try:
        limit = fo.shakedown_limit(contact, cycle, friction, open=np.array(opened))
    except fo.FrictoptError:
        return None
    return None if np.isnan(limit.load_factor) else limit


def limits_of_sets(case, seed, nodes, opened):
    """The limits of all sets that differ from `opened` in some nodes, each by its own program."""
    limits = []
    for states in product([False, True], repeat=len(nodes)):
        chosen = opened.copy()
        chosen[nodes] = states
        limits.append(limit_of_set(case, seed, tuple(chosen.tolist())))
    return [limit for limit in limits if limit is not None]


def reach(limit, limits):
    """How far load factors without holes reach up from a limit."""
    end = limit.load_factor
    while True:
        counts = [other.load_factor for other in limits if not other.least > end * (1 + 1e-7)]
        if max(counts, default=0.0) <= end * (1 + 1e-7):
            return end
        end = max(counts)


def poor_limit(contact, cycle, friction):
    """A limit of the set that is not the best, and finite; None if there is none."""
    for opened in (np.zeros(contact.nodes, dtype=bool), np.arange(contact.nodes) == 0):
        try:
            limit = fo.shakedown_limit(contact, cycle, friction, open=opened)
        except fo.FrictoptError:
            continue
        if 1e-3 < limit.load_factor < 100.0:
            return limit
    return None


@pytest.mark.parametrize("case", [pulled, lifted, spatial])
@pytest.mark.parametrize("seed", few([9, 6, 0, 1, 2, 3, 4, 5, 7, 8, 10, 11], 2, 6))
def test_the_best_set_of_all_or_of_some_nodes_is_found_and_proven(case, seed):
    contact, cycle, friction = case(seed)
    limit = poor_limit(contact, cycle, friction)
    if limit is None:
        assert seed not in (6, 9)  # the cases that every run tries have such a limit
        return
    for nodes in (np.arange(contact.nodes), np.arange(contact.nodes)[::2]):
        best = fo.best_open_nodes(limit, nodes)
        limits = limits_of_sets(case, seed, nodes, limit.open)
        assert best.limit.load_factor == pytest.approx(reach(limit, limits), rel=1e-6)
        assert best.proven and best.bound >= best.load_factor * (1 - 1e-8)
        assert best.improved == (best.load_factor > limit.load_factor * (1 + 1e-6))
        assert np.array_equal(np.delete(best.limit.open, nodes), np.delete(limit.open, nodes))
        higher = [other for other in limits if other.load_factor > best.load_factor * (1 + 1e-6)]
        assert bool(best.separate) == bool(higher)


@pytest.mark.parametrize("case", [pulled, lifted, spatial])
@pytest.mark.parametrize("seed", few(range(6)))
def test_a_branch_of_one_set_has_the_limit_of_that_set(case, seed):
    """A branch of a single set has the limit of this set.

    Otherwise branches are divided down to single sets, and the answer only takes longer.
    """
    contact, cycle, friction = case(seed)
    nodes = np.arange(contact.nodes)
    closed = pose(contact, cycle, friction)
    program = loose_nodes.LooseNodes(closed, nodes, 1.0, None)
    for states in product([False, True], repeat=contact.nodes):
        opened = np.array(states)
        question = with_open(closed, opened)
        if opened.all() or question is None:
            continue
        limit = limit_of_set(case, seed, states)
        if limit is not None and 1e-3 < limit.load_factor < 20.0:
            relaxed = program.solve(loose_nodes.Branch(opened, ~opened), -np.inf)
            assert relaxed.bound == pytest.approx(limit.load_factor, rel=1e-5)


def test_a_load_factor_without_end_has_no_bound():
    """There is no bound if every load factor is safe, as with one open node here."""
    nodes = int(np.random.default_rng([16, 75]).integers(2, 7))
    case = random_case(9_000_016, nodes=nodes)
    closed = np.zeros(nodes, dtype=bool)
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction, open=closed)
    assert limit.load_factor < 1.0
    assert fo.best_open_nodes(limit, range(nodes), programs=1).bound == np.inf
    best = fo.best_open_nodes(limit, range(nodes))
    assert best.load_factor == np.inf and best.proven


def test_two_pressed_nodes_that_have_to_open_together_are_found():
    """Two pressed nodes that have to open together are found.

    The other search flips nodes one by one, or flips all nodes that govern.
    """
    nodes = int(np.random.default_rng([5, 75]).integers(2, 7))
    case = random_case(9_000_005, nodes=nodes)
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction)
    best = fo.best_open_nodes(limit, range(nodes) if ALL_CASES else [1, 2])
    assert best.proven and best.improved
    assert best.reason.startswith("with nodes 1, 2 open the limit is 0.433106, not 0.381729; no")
    again = fo.best_open_nodes(best.limit, [1, 2])
    assert again.proven and not again.improved and again.limit is best.limit
    table = best.to_frame()
    assert table.node[table.open & ~table.was_open].tolist() == [1, 2]


def test_limits_above_load_factors_that_are_not_safe_are_separate():
    """With nodes 0 and 1 open the limit is 1. With node 0 open it is 5/3, but from 1.25 on."""
    loads = {
        "P": ([0, 0, 0], [-5.0, -1.0, 1.0]),
        "N": ([0, 0, 0], [0, 1.0, 0]),
        "Q": ([0, 0.1, 0.3], [0, 0, 0]),
    }
    contact = fo.ContactSystem.from_blocks(np.eye(3), np.zeros((3, 3)), np.eye(3), [0, 1, 2], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0, "Q": 1.0}, {"N": 1.0, "Q": -1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.5)
    best = fo.best_open_nodes(limit, range(3))
    assert best.limit is limit and best.proven
    (separate,) = best.separate
    assert (separate.least, separate.load_factor) == pytest.approx((1.25, 5 / 3))
    assert best.reason.endswith("except with safe load factors that begin at 1.25 or above")


def test_with_too_few_programs_the_bound_is_what_is_proven_by_then():
    limit = fo.shakedown_limit(*lifted(3), open=np.zeros(lifted(3)[0].nodes, dtype=bool))
    assert 1e-3 < limit.load_factor < 100.0
    best = fo.best_open_nodes(limit, range(limit.system.nodes), programs=1)
    whole = fo.best_open_nodes(limit, range(limit.system.nodes))
    assert best.programs == 1 < whole.programs
    assert not best.proven and best.bound > whole.load_factor
    assert "give more programs" in best.reason


def test_the_answer_does_not_depend_on_units():
    contact, cycle, friction = pulled(4)
    limit = fo.shakedown_limit(contact, cycle, friction)
    best = fo.best_open_nodes(limit, range(contact.nodes))
    loads = {name: 1e6 * np.r_[r].ravel() for name, r in contact.bonded.items()}
    other = fo.ContactSystem(contact.S * 1e9, contact.points * 1e-3, loads, gap=contact.gap * 1e-3)
    again = fo.best_open_nodes(fo.shakedown_limit(other, cycle, friction), range(contact.nodes))
    assert again.load_factor == pytest.approx(best.load_factor, rel=1e-7)
    assert again.proven and best.proven


@pytest.mark.parametrize(
    ("nodes", "text"),
    [
        ([2], "integers from 0 to 1"),
        ([-1], "integers from 0 to 1"),
        ([0.5], "integers from 0 to 1"),
        ([], "nodes: none"),
        ([[0]], "shape"),
    ],
)
def test_bad_nodes_are_refused(nodes, text):
    limit = fo.shakedown_limit(CONTACT, CYCLE, 0.6)
    with pytest.raises(fo.ModelError, match=text):
        fo.best_open_nodes(limit, nodes)


def test_limits_that_cannot_be_compared_are_refused():
    infinite = system(1.0, 0.0, 0.0, 1.0, 0.0, 1.0, C=[[1.0]])
    pressed = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}])
    model = fo.ShakedownModel(CONTACT, CYCLE)
    loads = {"P": ([0, 0], [1.0, 0.3]), "up": ([0, 0], [0, -1.0]), "Q": ([1.0, 0], [0, 0])}
    alone = fo.ContactSystem.from_blocks(
        2 * np.eye(2), np.zeros((2, 2)), 2 * np.eye(2), [0, 1], loads
    )
    lifting = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}], fixed=[{"up": 1.0}, {"up": -1.0}])
    limits = {
        "limit: 1.0; give the answer": 1.0,
        "finite limit": fo.shakedown_limit(infinite, pressed, 0.5),
        "constraints or an objective": model.solve(0.6, [model.slip >= -1.0]),
        "loads alone open and close": fo.shakedown_limit(alone, lifting, 0.5),
        "without slip_bound": fo.shakedown_limit(CONTACT, CYCLE, 0.6, slip_bound=1.0),
    }
    for text, limit in limits.items():
        with pytest.raises(fo.ModelError, match=text):
            fo.best_open_nodes(limit, [0])
    with pytest.raises(fo.ModelError, match="solver"):
        fo.best_open_nodes(fo.shakedown_limit(CONTACT, CYCLE, 0.6), [0], solver="none")
