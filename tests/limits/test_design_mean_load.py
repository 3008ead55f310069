"""Designs that are safe under the mean load, too: by hand, and against a plain program."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.designs import largest_load_factor
from helpers.systems import random_system, unit_nodes

FRICTION = 0.5


def lever():
    """Two uncoupled nodes that a preload b presses in opposite senses.

    The preload presses node 0 with 1 + b and node 1 with 1 - b; the load a shears node 0 and
    presses node 1.
    """
    loads = {
        "mean": ([0.0, 0.0], [1.0, 1.0]),
        "b": ([0.0, 0.0], [1.0, -1.0]),
        "a": ([1.0, 0.0], [0.0, 1.0]),
        "-a": ([-1.0, 0.0], [0.0, 1.0]),
    }
    return unit_nodes(loads), fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"-a": 1.0}])


def test_a_design_that_no_constraint_admits_under_the_mean_load_has_a_least_load_factor():
    """With b >= 2 node 1 needs the load factor b - 1."""
    model = fo.DesignModel(*lever(), preloads=["b"])
    single = model.solve(FRICTION, [model.preload >= 2.0, model.preload <= 2.9])
    assert single.load_factor == pytest.approx(1.95)
    assert single.least == pytest.approx(1.9)
    assert "with all nodes closed no slip is safe below 1.9" in single.reason
    with pytest.raises(fo.ModelError, match="it grows without bound with the design"):
        model.solve(FRICTION, [model.preload >= 2.0])  # node 1 is open

    some = model.solve(FRICTION, [model.preload == 2.0])
    assert (some.least, some.load_factor) == pytest.approx((1.0, 1.5))
    built = fo.shakedown_limit(some.system, some.cycle, FRICTION, open_nodes=[False, False])
    assert (built.least, built.load_factor) == pytest.approx((1.0, 1.5))


def test_the_fixed_part_of_a_cycle_belongs_to_its_mean_load():
    """The fixed part of a cycle counts at load factor 0, too.

    At corner 1 the fixed part adds 0.5 to b, so that node 1 is pressed at load factor 0 only up to
    b = 0.5. Both corners together shear node 0 by 2, and it carries f (1 + b) + f (1.5 + b).
    """
    system, _ = lever()
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"-a": 1.0}], fixed=[{}, {"b": 0.5}])
    model = fo.DesignModel(system, cycle, preloads=["b"])
    design = model.solve(FRICTION, [model.preload >= 0.0, model.preload <= 1.0])
    assert design.preload["b"] == pytest.approx(0.5)
    assert design.load_factor == pytest.approx(0.875)
    assert design.least == 0.0


def test_a_design_is_safe_under_the_mean_load_of_all_scenarios():
    """The scenario has half of the preload. Node 1 needs b <= 1 in the first scenario, and node 0
    carries f (1 + b / 2) in the other."""
    system, cycle = lever()
    scenarios = [(cycle, FRICTION, {"b": 0.5})]
    model = fo.DesignModel(system, cycle, preloads=["b"], scenarios=scenarios)
    design = model.solve(FRICTION, [model.preload >= 0.0, model.preload <= 1.5])
    assert design.preload["b"] == pytest.approx(1.0)
    assert design.load_factor == pytest.approx(0.75)
    assert design.least == 0.0
    assert len(design.slips) == len(design.scenarios) == len(design.opens) == 2


def test_with_an_objective_the_design_is_safe_under_the_mean_load_too():
    model = fo.DesignModel(*lever(), preloads=["b"])
    rows = [model.load_factor >= 0.25, model.preload <= 1.2]
    dearest = model.solve(FRICTION, rows, objective=model.preload[0])
    assert dearest.preload["b"] == pytest.approx(1.0)
    assert dearest.least == 0.0


def pressed_by_cyclic_loads(rng, nodes):
    """A random contact whose cyclic loads a and b press all nodes; c is a preload."""
    contact = random_system(rng, nodes, ("mean", *"abc"))
    loads = dict(contact.bonded)
    for name in "ab":
        loads[name] = loads[name][0], rng.uniform(0.5, 1.0, nodes)
    return fo.ContactSystem.from_blocks(contact.A, contact.B, contact.C, contact.x, loads)


def test_random_designs_are_safe_under_the_mean_load_if_any_is():
    smaller = 0
    for seed in few(range(30)):
        rng = np.random.default_rng(seed)
        nodes = int(rng.integers(2, 5))
        contact = pressed_by_cyclic_loads(rng, nodes)
        cycle = fo.LoadCycle({"mean": 0.3}, [{"a": 1.0}, {"a": 0.5, "b": 1.0}, {"b": 1.0}])
        friction = rng.uniform(0.3, 0.9)
        anywhere, everywhere = (
            largest_load_factor(
                contact,
                [(cycle, friction, {})],
                ["c"],
                lambda b, g: [cp.abs(b) <= 1.0, g == 0],
                at_mean_load=at_mean_load,
            )
            for at_mean_load in (False, True)
        )
        model = fo.DesignModel(contact, cycle, preloads=["c"])
        try:
            design = model.solve(friction, [cp.abs(model.preload) <= 1.0])
        except fo.ModelError:
            assert not np.isfinite(anywhere)
            continue
        if any(opened.any() for opened in design.opens):
            continue
        expected = anywhere if np.isnan(everywhere) else everywhere
        assert design.load_factor == pytest.approx(expected, rel=1e-7, abs=1e-7)
        assert (design.least == 0.0) == (not np.isnan(everywhere))
        smaller += everywhere < anywhere * (1 - 1e-6)
    assert smaller >= few(30) // 10
