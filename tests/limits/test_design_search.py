"""The search of the best design compared with narrower searches.

A best design is no worse than no design, nor than a design within narrower bounds, and its
multipliers belong to it.
"""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.systems import CYCLE, random_system


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
    contact = fo.ContactSystem.from_blocks(
        np.eye(20), np.zeros((20, 20)), np.eye(20), np.arange(20.0), loads
    )
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
