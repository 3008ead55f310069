"""Designs under which nodes stay open.

They are compared with a plain program for every set of open nodes, with the limit of the contact
into which the design is built, and with no design or narrower bounds.
"""

from itertools import product

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.designs import CYCLE as TURNS
from helpers.designs import largest_load_factor, pulled
from helpers.systems import CYCLE, random_system, unit_nodes
from studies.validation.blocks import block
from studies.validation.fuzz.cases import random_case
from studies.validation.fuzz.space import _SpatialSubject

MOST, DEPTH = 0.6, 0.1
# The mean load pulls node 0 open, and a bolt presses it and the others.
BOLTED = unit_nodes(
    {
        "P": ([0.0] * 3, [-1.0, 1.0, 1.0]),
        "bolt": ([0.0] * 3, [0.5, 0.2, 0.2]),
        "N": ([0.0] * 3, [0.5, 0.0, 0.0]),
        "Q": ([1.0] * 3, [0.0] * 3),
    }
)


@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
def test_the_best_design_of_random_contacts_is_that_of_its_open_nodes(tangents):
    """It is the best of all sets of open nodes, and `shakedown_limit` of the built contact agrees."""
    rel, found = 1e-7 if tangents == 1 else 1e-5, 0
    for seed in few(range(12)):
        contact, friction = pulled(seed, tangents)
        every = {
            opened: largest_load_factor(
                contact,
                [(TURNS, friction, {})],
                ["c"],
                lambda b, g: [cp.abs(b) <= MOST, cp.abs(g) <= DEPTH],
                opened=np.array(opened),
            )
            for opened in product([False, True], repeat=contact.nodes)
            if not all(opened)
        }
        model = fo.DesignModel(contact, TURNS, preloads=["c"], profile=True)
        most = max(np.nan_to_num([*every.values()], nan=-1.0))
        within = [cp.abs(model.preload) <= MOST, cp.abs(model.profile) <= DEPTH]
        if most < 0:
            with pytest.raises(fo.ModelError, match="no design is safe"):
                model.solve(friction, within)
            continue
        try:
            design = model.solve(friction, within)
        except fo.ModelError as error:  # it did not find the open nodes with which one is safe
            assert np.isnan(every[(False,) * contact.nodes])
            assert "with all nodes closed" in str(error)
            continue
        (opened,) = design.opens
        assert design.load_factor == pytest.approx(every[tuple(opened)], rel=rel, abs=rel)
        assert design.residual <= 1e-9
        assert design.load_factor == pytest.approx(most, rel=rel, abs=rel)
        assert fo.shakedown_limit(
            design.system, design.cycle, friction
        ).load_factor == pytest.approx(design.load_factor, rel=1e-7, abs=1e-7)
        q, p = design.reactions
        assert (np.linalg.norm(q.reshape(*p.shape, -1), axis=-1) - friction * p).max() <= 1e-8
        assert np.abs(p[:, opened]).max(initial=0.0) <= 1e-12
        assert "and none with other nodes open" in design.reason
        assert (opened == design.open).all()
        found += opened.any()
    assert found >= few(12) // 6


@pytest.mark.parametrize("seed", [560, 5486, *few(range(60), 2)])
def test_a_contact_with_the_best_of_all_designs_has_no_higher_limit(seed):
    case = random_case(seed, nodes=2 + seed % 2)
    (q, p), length = case.system.reaction(case.cycle.mean), 1 / case.system.stiffness_scale
    length *= np.abs([*np.ravel(q), *p]).max()
    model = fo.DesignModel(case.system, case.cycle, preloads=["b"], profile=True)
    within = [cp.abs(model.preload) <= 0.3, cp.abs(model.profile) <= 0.3 * length]
    try:
        design = model.solve(case.friction, within)
        built = fo.shakedown_limit(design.system, design.cycle, case.friction)
    except fo.FrictoptError:  # for example, the design grows without end with some nodes open
        return
    opens_and_closes = "with any nodes open" not in built.covers
    if "none with other nodes open" in design.reason and not (built.least or opens_and_closes):
        assert built.load_factor <= design.load_factor * (1 + 1e-6) + 1e-9


def test_a_bolt_that_is_too_weak_to_close_a_node_leaves_it_open():
    """A bolt that cannot close a node leaves it open, and no constraint of the user is blamed.

    The mean load pulls node 0 open by 1, of which the bolt takes a half; the other two nodes carry
    f (1 + 0.2 b).
    """
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    model = fo.DesignModel(BOLTED, cycle, preloads=["bolt"])
    design = model.solve(0.5, [model.preload >= 0, model.preload <= 1.0, model.load_factor >= 0.5])
    assert design.load_factor == pytest.approx(0.6) and design.open.tolist() == [True, False, False]
    assert design.slips[0][0] == pytest.approx(0.0)
    assert model.q[0].value[0] == model.p[0].value[0] == 0.0
    assert design.reason.startswith(
        "with 1 of 3 nodes open: no design within the constraints is better"
    )


def test_the_gap_that_a_bolt_leaves_to_an_open_node_bounds_the_design():
    """By hand: node 0 is open by 1 - b / 2 - L / 2 at the first corner, and the other nodes carry
    (1 + b / 5) / 2, which is largest at b = 15 / 11."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0, "N": 1.0}, {"Q": -1.0}])
    model = fo.DesignModel(BOLTED, cycle, preloads=["bolt"])
    design = model.solve(0.5, [model.preload >= 0, model.preload <= 1.5])
    assert design.open.tolist() == [True, False, False]
    assert (design.load_factor, design.preload["bolt"]) == (
        pytest.approx(7 / 11, rel=1e-9),
        pytest.approx(15 / 11, rel=1e-9),
    )


def test_scenarios_have_open_nodes_of_their_own():
    """In the second scenario half of the bolt acts, which leaves node 0 open. The other two nodes
    carry 0.5 (1 + 0.5 b) in it, and 0.5 (1 + b) in the first scenario."""
    none = np.zeros(3)
    loads = {
        "P": (none, [-1.0, 1.0, 1.0]),
        "bolt": (none, [2.0, 1.0, 1.0]),
        "Q": ([0.1, 1.0, 1.0], none),
    }
    contact = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    model = fo.DesignModel(
        contact, cycle, preloads=["bolt"], scenarios=[(cycle, 0.5, {"bolt": 0.5})]
    )
    design = model.solve(0.5, [model.preload >= 0.0, model.preload <= 0.8])
    assert design.load_factor == pytest.approx(0.7)
    assert [opened.tolist() for opened in design.opens] == [[False] * 3, [True, False, False]]


def test_a_design_under_a_static_load_grows_without_end():
    """With nodes 1 and 3 open every load factor has a state of rest, without a design."""
    system, cycle, friction = _SpatialSubject(725550944).args
    limit = fo.shakedown_limit(system, cycle, friction)
    assert limit.load_factor == np.inf and limit.open.nonzero()[0].tolist() == [1, 3]
    steady = fo.steady_state(system, cycle, friction, 5.0)
    assert steady.outcome is fo.Outcome.SHAKEDOWN
    model = fo.DesignModel(system, cycle, preloads=["b"], profile=True)
    within = [cp.abs(model.preload) <= 0.11, cp.abs(model.profile) <= 357.0]
    with pytest.raises(fo.ModelError, match="grows without bound"):
        model.solve(friction, within)


@pytest.mark.parametrize("seed", [290, *few(range(40), 2)])
def test_a_relaxed_constraint_never_lowers_a_design(seed):
    """Bolts of a block on a rigid base may be tightened more and more in total."""
    rng = np.random.default_rng([seed, 55])
    contact, cycle, friction = block(seed, nodes=int(rng.integers(3, 6)))
    loads = {name: np.concatenate(pair) for name, pair in contact.bonded.items()}
    bolts = [f"bolt {number}" for number in range(int(rng.integers(1, 4)))]
    for bolt in bolts:
        loads[bolt] = np.zeros(2 * contact.nodes)
        loads[bolt][contact.nodes + rng.integers(contact.nodes)] = rng.uniform(0.3, 1.0)
    system = fo.ContactSystem(contact.S, contact.points, loads, gap=contact.gap)
    model = fo.DesignModel(system, cycle, preloads=bolts)
    before = 0.0
    for most in (0.5, 0.75, 1.5, 3.0):
        rows = [model.preload >= 0, model.preload <= 2, cp.sum(model.preload) <= most]
        try:
            design = model.solve(friction, rows)
        except fo.ModelError as error:
            if "grows" not in str(error):
                continue  # no design is safe
            before = np.inf
            continue
        assert design.load_factor >= before * (1 - 1e-6)
        before = design.load_factor
        built = fo.shakedown_limit(design.system, design.cycle, friction)
        assert built.load_factor == pytest.approx(before, rel=1e-6)


def test_a_design_of_a_large_contact_is_no_worse_than_the_strongest_bolt():
    """Not all sets of open nodes are compared there: the search begins at those under this bolt."""
    for seed in few((0, 1, 4, 5, 6, 8, 9, 10)):
        rng = np.random.default_rng(seed)
        contact = random_system(rng, 16, loads=("mean", "cyclic", "bolt"), coupling=0.8)
        contact = contact.with_gap(rng.uniform(0, 4.0, 16) * (rng.random(16) < 0.4))
        corners = [{"cyclic": 1.0}, {"cyclic": -1.0}]
        model = fo.DesignModel(contact, fo.LoadCycle({}, corners), preloads=["bolt"])
        design = model.solve(0.7, [model.preload <= 2.0])
        tightened = fo.LoadCycle({"bolt": 2.0}, corners)
        limit = fo.shakedown_limit(contact, tightened, 0.7)
        assert design.load_factor > limit.load_factor * (1 - 1e-9) > 0


def with_a_bolt(seed, nodes):
    """A random contact whose mean load pulls one node open, and a friction."""
    rng = np.random.default_rng([72, seed])
    assert int(rng.integers(2, 5)) == nodes
    system = random_system(rng, nodes)
    q, p = (np.array(part) for part in system.bonded["mean"])
    p[rng.integers(nodes)] *= -0.5
    bolt = rng.normal(size=nodes) * 0.2, rng.uniform(0, 0.5, size=nodes)
    return system.with_bonded({"mean": (q, p), "bolt": bolt}), float(rng.uniform(0.3, 0.8))


def test_the_search_begins_without_a_design_too():
    """A node that a bolt can close is better left open, because the bolt unloads the other nodes.

    By hand: the mean load pulls node 0 by 1 and presses 19 nodes by 1, which carry the shear force
    `load factor`. The bolt presses node 0 by .5 and pulls the others by .02. With all nodes closed
    it needs the preload 2, and they carry .5 * .96; without a preload node 0 is open, and they
    carry .5. A search that begins with the nodes that are open under the largest preload is not
    told of that. There are too many nodes to compare all sets.
    """
    none, others = np.zeros(20), np.r_[0.0, np.ones(19)]
    loads = {
        "P": (none, np.r_[-1.0, np.ones(19)]),
        "bolt": (none, np.r_[0.5, np.full(19, -0.02)]),
        "Q": (others, none),
    }
    contact = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    model = fo.DesignModel(contact, cycle, preloads=["bolt"])
    design = model.solve(0.5, [model.preload >= 0, model.preload <= 10.0])
    assert design.load_factor == pytest.approx(0.5)
    assert design.open.tolist() == [True, *[False] * 19]


def test_a_design_that_would_open_other_nodes_counts_with_its_own_limit():
    """The load factor of a design is the limit of the contact that is built.

    `shakedown_limit` of this contact agrees, from the mean load of the design on.
    """
    system, friction = with_a_bolt(10008, 3)
    model = fo.DesignModel(system, CYCLE, preloads=["cyclic"])
    narrow = model.solve(friction, [cp.abs(model.preload) <= 1.0])
    wide = model.solve(friction, [cp.abs(model.preload) <= 100.0])

    def built(preload):
        return fo.shakedown_limit(
            system, fo.LoadCycle({"mean": 1.0, "cyclic": preload}, CYCLE.corners), friction
        ).load_factor

    assert wide.load_factor > 2 * narrow.load_factor
    assert built(wide.preload["cyclic"]) == pytest.approx(wide.load_factor, rel=1e-6)


def test_the_multiplier_of_an_own_row_is_its_price():
    """The multiplier of a row of the user is its price, by finite differences.

    The search presses once as much as it may, after the best design.
    """
    loads = {
        "P": ([0.8], [1.9]),
        "one": ([0.0], [0.5]),
        "two": ([-0.1], [0.5]),
        "a": ([0.6], [0.0]),
        "b": ([0.7], [-0.9]),
    }
    node = fo.ContactSystem.from_blocks([[1.0]], [[0.6]], [[1.0]], [0.0], loads)
    model = fo.DesignModel(
        node, fo.LoadCycle({"P": 1.0}, [{"a": 1.0}, {"b": 1.0}]), preloads=["one", "two"]
    )
    budget = cp.Parameter(value=1.0)
    row = cp.sum(model.preload) <= budget
    design = model.solve(0.8, [row, model.preload >= 0])
    dual, preload = float(row.dual_value), model.preload.value
    budget.value += 1e-5
    rate = (model.solve(0.8, [row, model.preload >= 0]).load_factor - design.load_factor) / 1e-5
    assert dual == pytest.approx(rate, rel=1e-3)
    assert float(design.prices["constraints[0]"]) == pytest.approx(dual, rel=1e-9)
    assert preload == pytest.approx(design.preload.to_numpy(), abs=1e-12)
