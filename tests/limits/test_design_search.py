"""The search of the best design compared with narrower searches.

A best design is no worse than no design, nor than a design within narrower bounds, and its
multipliers belong to it.
"""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, random_system

A = np.array([[2.0, -0.5, 0.0], [-0.5, 2.0, -0.5], [0.0, -0.5, 2.0]])
B = 0.2 * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def pulled_open(seed):
    """A contact of three nodes, of which the mean load pulls the middle node open."""
    rng = np.random.default_rng(seed)
    p = np.array([1.0, -0.3, 1.0]) * rng.uniform(0.5, 1.5, 3)
    loads = {
        "mean": (np.zeros(3), p),
        "cyclic": (rng.uniform(0.2, 0.6, 3), rng.uniform(-0.2, 0.2, 3)),
    }
    return fo.ContactSystem.from_blocks(A, B, A, [0.0, 1.0, 2.0], loads)


def with_a_bolt(seed, nodes):
    """A random contact whose mean load pulls one node open, and a friction."""
    rng = np.random.default_rng([72, seed])
    assert int(rng.integers(2, 5)) == nodes
    system = random_system(rng, nodes)
    q, p = (np.array(part) for part in system.bonded["mean"])
    p[rng.integers(nodes)] *= -0.5
    bolt = rng.normal(size=nodes) * 0.2, rng.uniform(0, 0.5, size=nodes)
    return system.with_bonded({"mean": (q, p), "bolt": bolt}), float(rng.uniform(0.3, 0.8))


@pytest.mark.parametrize("seed", few([4, 6, 7], 1))
def test_the_search_begins_without_a_design_too(seed):
    """The search also begins with the nodes that are open without a design.

    With all nodes closed there is a worse design. The best design never gets worse with a larger
    bound of the preload, and the contact with the design built in has its load factor.
    """
    system = pulled_open(seed)
    model = fo.DesignModel(system, CYCLE, preloads=["cyclic"])
    least = fo.shakedown_limit(system, CYCLE, 0.5).load_factor
    for most in (0.01, 1.0, 100.0):
        design = model.solve(0.5, [cp.abs(model.preload) <= most])
        assert design.load_factor >= least * (1 - 1e-6)
        least = design.load_factor
        built = fo.shakedown_limit(
            system,
            fo.LoadCycle({"mean": 1.0, "cyclic": design.preload["cyclic"]}, CYCLE.corners),
            0.5,
        )
        assert built.load_factor >= least * (1 - 1e-6)


def test_a_design_that_would_open_other_nodes_counts_with_its_own_limit():
    """The load factor of a design is the limit of the contact that is built.

    `shakedown_limit` of this contact agrees, from the mean load of the design on. If none of the
    larger designs counts, `reason` says so, and `bound` is their bound.
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
    assert ("the search stops before them" in wide.reason) == (
        wide.bound > wide.load_factor * (1 + 1e-6)
    )
    assert built(wide.preload["cyclic"]) == pytest.approx(wide.load_factor, rel=1e-6)


def test_without_a_bound_there_is_a_design_where_a_bounded_one_is():
    """A design without bounds exists wherever a bounded one exists.

    The expected value is the limit of the contact with the design built in, at the load factor that
    the constraint prescribes.
    """
    loads = {"mean": ([0, 0, 0], [1, -0.3, 1]), "cyclic": ([0.5, 0.2, 0.5], [0.1, 0, 0])}
    system = fo.ContactSystem.from_blocks(A, B, A, [0.0, 1.0, 2.0], loads)
    prescribed = 0.5 * fo.shakedown_limit(system, CYCLE, 0.6, slip_bound=10.0).load_factor
    model = fo.DesignModel(system, CYCLE, preloads=["cyclic"], slip_bound=10.0)
    found = []
    for most in (20.0, 50.0, 1e4):
        design = model.solve(
            0.6,
            [model.load_factor == prescribed, cp.abs(model.preload) <= most],
            objective=model.preload[0],
        )
        found.append(design.preload["cyclic"])
    assert found == sorted(found)
    built = fo.shakedown_limit(
        system,
        fo.LoadCycle({"mean": 1.0, "cyclic": found[-1]}, CYCLE.corners),
        0.6,
        slip_bound=10.0,
    )
    assert built.load_factor == pytest.approx(prescribed, rel=1e-6)


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
