"""The best design in space: against cone programs over raw unknowns, the plane, a closed form, and the limit of the design built in."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.parts import joined
from spatial import cycle, random_contact


def best(contact, scenarios, preloads, profile, own):
    """Status and largest load factor of a plain program: a circle for each node at each corner of each scenario. `own(b, g)` gives constraints."""
    n, lam = contact.nodes, cp.Variable()
    b, g = cp.Variable(max(len(preloads), 1)), cp.Variable(n)
    rows = [lam >= 0, *own(b, g)] + ([] if profile else [g == 0]) + ([] if preloads else [b == 0])
    R = np.array([joined(*contact.bonded[name]) for name in preloads]).reshape(len(preloads), 3 * n)
    for loads, friction in scenarios:
        v = cp.Variable(2 * n)
        added = contact.S @ cp.hstack([v, -g]) + (R.T @ b if preloads else 0.0)
        mean, corners = joined(*loads.mean_reaction(contact)), [joined(*pair) for pair in zip(*loads.corner_reactions(contact), strict=True)]
        for corner in corners:
            r = mean + lam * corner + added
            rows += [cp.norm(cp.reshape(r[: 2 * n], (n, 2), order="F"), 2, axis=1) <= cp.multiply(friction, r[2 * n :])]
    problem = cp.Problem(cp.Maximize(lam), rows)
    problem.solve(solver="CLARABEL")
    return problem.status, problem.value


@pytest.mark.parametrize("part", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_random_contacts_have_the_design_of_a_plain_cone_program_and_it_holds(part):
    found = 0
    for seed in range(10, 40) if part else range(10):
        rng = np.random.default_rng(seed)
        contact, bolts, profile = random_contact(rng, int(rng.integers(1, 5))), ["a", "b"][: seed % 3], bool(seed % 3 == 0 or seed % 2)
        loads = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0, "c": 0.2}, {"a": -1.0}, {"b": 0.7}])
        scenarios = [(loads, rng.uniform(0.2, 0.9))] + [(cycle(), rng.uniform(0.2, 0.9, contact.nodes))] * (seed % 4 == 1)
        depth, budget = rng.uniform(0.01, 0.3), rng.uniform(0.05, 0.5)

        def own(b, g, bolts=bolts, profile=profile, depth=depth, budget=budget):
            return ([cp.norm(b) <= budget] if bolts else []) + ([cp.abs(g) <= depth] if profile else [])

        status, value = best(contact, scenarios, bolts, profile, own)
        model = fo.DesignModel(contact, loads, preloads=bolts, profile=profile, scenarios=scenarios[1:])
        if status != "optimal":
            with pytest.raises(fo.ModelError):
                model.solve(scenarios[0][1], own(model.preload, model.profile))
            continue
        design, found = model.solve(scenarios[0][1], own(model.preload, model.profile)), found + 1
        assert design.load_factor == pytest.approx(value, rel=1e-6, abs=1e-7) and design.bound == pytest.approx(
            design.load_factor, rel=1e-8, abs=1e-8
        )
        anew = [fo.shakedown_limit(design.system, one, friction).load_factor for one, friction in design.scenarios]
        assert min(anew) == pytest.approx(design.load_factor, rel=1e-8, abs=1e-8) and design.residual <= 1e-9
    assert found >= 5


def test_two_bolts_that_nothing_else_helps_even_out_the_loads_of_the_nodes():
    """No mean load presses: the bolts alone do, within a budget b. Sheared along X, then Y, by s: each needs |s| / (sqrt 2 f) of it."""
    shears, f, budget = np.array([1.0, 0.4]), 0.3, 5.0
    none = np.zeros(2)
    loads = {"one": [0, 0, 0, 0, 1, 0], "two": [0, 0, 0, 0, 0, 1], "X": np.r_[shears, none, none], "Y": np.r_[none, shears, none]}
    contact = fo.ContactSystem(np.eye(6), [[0, 0, 0], [1, 0, 0]], loads)
    model = fo.DesignModel(contact, fo.LoadCycle({}, [{"X": 1.0}, {"Y": 1.0}]), preloads=["one", "two"])
    design = model.solve(f, [cp.sum(model.preload) <= budget, model.preload >= 0])
    assert design.load_factor == pytest.approx(f * budget * np.sqrt(2) / 1.4, rel=1e-8)  # the circle through both points has half their distance
    assert design.preload.to_numpy() == pytest.approx(budget * shears / 1.4, rel=1e-6)
    assert float(design.prices["constraints[0]"]) == pytest.approx(f * np.sqrt(2) / 1.4, rel=1e-6)
    assert design.slip == pytest.approx(-design.load_factor / 2 * np.column_stack([shears, shears]), abs=1e-6)
    least = model.solve(f, [model.load_factor == 1.0, model.preload >= 0], objective=-cp.sum(model.preload))
    assert least.preload.sum() == pytest.approx(1.4 / f / np.sqrt(2), rel=1e-7) and least.bound == pytest.approx(least.objective, rel=1e-8)


def test_what_contradicts_and_what_grows_is_named():
    contact = random_contact(np.random.default_rng(0), 2)
    model = fo.DesignModel(contact, cycle(), preloads=["mean"])
    with pytest.raises(fo.ModelError, match=r"preload\['mean'\] has no upper bound"):
        model.solve(0.5)
    with pytest.raises(fo.ModelError, match=r"^low, high: they contradict each other"):
        model.solve(0.5, [(cp.norm(model.preload) <= 1.0).set_label("low"), (model.preload[0] >= 2.0).set_label("high")])
    shaped = fo.DesignModel(contact, cycle(), profile=True)
    with pytest.raises(fo.ModelError, match="friction: node 1 has no friction, and the cyclic load shears it: no design is safe"):
        shaped.solve([0.5, 0.0], [cp.abs(shaped.profile) <= 0.1])
