"""The best design against independent numbers and closed forms.

It is also compared with plain programs over raw unknowns, and with the limit of the contact into
which the design is built.
"""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.components import joined
from helpers.designs import largest_load_factor
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import random_contact
from helpers.springs import punch
from helpers.systems import CYCLE, PULL, at_corners, explained, random_system


@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
@pytest.mark.parametrize("part", few([0, 1], 1))
def test_random_contacts_have_the_design_of_a_plain_program_and_it_holds(part, tangents):
    """The contact with the design built in has the same limit, and no scenario has a smaller one."""
    found, rel = 0, 1e-7 if tangents == 1 else 1e-6
    for seed in range(12, 60) if part else few(range(12), 4):
        rng = np.random.default_rng(seed)
        nodes = int(rng.integers(1, 5))
        bolts = ["a", "b"][: seed % 3]
        profile = bool(seed % 3 == 0 or seed % 2)
        contact = (
            random_contact(rng, nodes)
            if tangents == 2
            else random_system(rng, nodes, ("mean", *"abc"))
        )
        scenarios = [
            (
                fo.LoadCycle(
                    {"mean": 1.0, "a": 0.1}, [{"a": 1.0, "c": 0.2}, {"a": -1.0}, {"b": 0.7}]
                ),
                rng.uniform(0.2, 0.9),
                {},
            )
        ]
        if seed % 4 == 1:
            scenarios.append(
                (
                    spatial_cycle(),
                    rng.uniform(0.2, 0.9, nodes),
                    {name: rng.uniform(0.7, 1.2) for name in bolts},
                )
            )
        depth = rng.uniform(0.01, 0.3)
        budget = rng.uniform(0.05, 0.5)
        weights = rng.uniform(0.5, 1.5, len(bolts))

        def user_rows(
            b, g, bolts=bolts, profile=profile, depth=depth, budget=budget, weights=weights
        ):
            rows = []
            if bolts and tangents == 2:
                rows += [cp.norm(b) <= budget]
            elif bolts:
                rows += [b >= 0, weights @ b <= budget]
            if profile:
                rows += [cp.abs(g) <= depth]
            return rows

        def fixed(b, g, bolts=bolts, profile=profile):
            """What there is not in this design."""
            return ([] if bolts else [b == 0]) + ([] if profile else [g == 0])

        value = largest_load_factor(
            contact, scenarios, bolts, lambda b, g: user_rows(b, g) + fixed(b, g)
        )
        friction = scenarios[0][1]
        model = fo.DesignModel(
            contact, scenarios[0][0], preloads=bolts, profile=profile, scenarios=scenarios[1:]
        )
        if not np.isfinite(value):
            with pytest.raises(
                fo.ModelError, match=r"constraints|load_factor: it grows|no design is safe"
            ):
                model.solve(friction, user_rows(model.preload, model.profile))
            continue
        design = model.solve(friction, user_rows(model.preload, model.profile))
        found += 1
        # The plain program leaves all nodes closed.
        if np.any(design.opens):
            assert design.load_factor > value
        else:
            assert design.load_factor == pytest.approx(value, rel=rel, abs=rel / 10)
        assert design.residual <= 1e-9
        assert design.bound == pytest.approx(design.load_factor, rel=1e-8, abs=1e-8)
        anew = [
            fo.shakedown_limit(design.system, cycle, f).load_factor for cycle, f in design.scenarios
        ]
        assert min(anew) == pytest.approx(design.load_factor, rel=1e-8, abs=1e-8)
        for (cycle, f), slip in zip(design.scenarios, design.slips, strict=True):
            q, p = at_corners(design.system, cycle, design.load_factor, slip)
            off = np.linalg.norm(q.reshape(*p.shape, -1), axis=-1) - f * p
            assert np.where(np.any(design.opens), 0.0, off).max() <= 1e-8
    assert found >= few(12, 4) // 2


@pytest.mark.parametrize(
    ("cells", "limits"),
    few(
        [
            (40, (0.20096, 0.24004, 0.28016, 0.29539, 0.29539)),
            (80, (0.20060, 0.23973, 0.27990, 0.29518, 0.29518)),
        ],
        1,
    ),
)
def test_a_hollow_face_of_a_rigid_punch_on_a_rough_half_plane(cells, limits):
    system = punch(cells, 0.02)
    model = fo.DesignModel(system, PULL, profile=True)
    deepest = cp.Parameter(nonneg=True)
    for depth, limit in zip((0.0, 0.1, 0.3, 1.0, 3.0), limits, strict=True):
        deepest.value = depth
        found = model.solve(0.3, [model.profile >= 0, model.profile <= deepest])
        assert found.load_factor == pytest.approx(limit, abs=4e-4)
    assert (
        found.profile[np.abs(system.x) < 0.5].mean() > found.profile[np.abs(system.x) > 0.8].mean()
    )


@pytest.mark.parametrize("tangents", [1, 2])
def test_a_preload_that_does_nothing_obeys_its_bounds_and_one_of_rounding_is_refused(tangents):
    """Condensation leaves such rounding for an interference that a free body gives way to. No
    amplitude of this preload could be distinguished from zero."""
    rng = np.random.default_rng(5)
    contact = random_contact(rng, 3) if tangents == 2 else random_system(rng, 3, ("mean", *"abc"))
    large = contact.with_bonded(
        {name: 1e6 * joined(*pair) for name, pair in contact.bonded.items()}
        | {"idle": np.zeros(3 * tangents + 3)}
    )
    model = fo.DesignModel(large, spatial_cycle(), preloads=["a", "idle"])
    bounds = [
        model.preload >= -0.2,
        model.preload <= 1.0,
        model.load_factor >= 0.9 * fo.shakedown_limit(large, spatial_cycle(), 0.6).load_factor,
    ]
    design = model.solve(0.6, bounds, objective=-cp.sum(model.preload))
    assert design.preload["idle"] == pytest.approx(-0.2, abs=1e-7)
    assert design.bound == pytest.approx(-design.preload.sum(), abs=1e-7)
    for left in (1e-20, 1e-11):
        with pytest.raises(
            fo.ModelError,
            match=r"preloads: 'idle' has reactions of .* only rounding relative to the reactions",
        ):
            fo.DesignModel(
                contact.with_bonded({"idle": left * np.ones(3 * tangents + 3)}),
                spatial_cycle(),
                preloads=["a", "idle"],
            )


@pytest.mark.parametrize("mean", [1.0, 1e-12])
@pytest.mark.filterwarnings("ignore:friction")
def test_a_bolt_on_a_joint_that_hardly_carries(mean):
    """A joint has the limit `f (mean + bolt) / shear`.

    Nearly all friction comes from the bolt, and residual slip takes the shear of the bolt off the
    node.
    """
    loads = {"P": ([0.0], [mean]), "bolt": ([-0.52999694], [0.1801059]), "Q": ([0.22466545], [0.0])}
    node = fo.ContactSystem.from_blocks(
        [[0.916534225]], [[-1.11894197e-07]], [[1.85041491]], [0.0], loads
    )
    model = fo.DesignModel(
        node, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["bolt"], profile=True
    )
    design = model.solve(
        10.0,
        [
            cp.abs(model.preload) <= 0.2651997875936538,
            cp.abs(model.profile) <= 1.9171108287401726e-13,
        ],
    )
    assert design.load_factor == pytest.approx(
        10.0 * (mean + 0.1801059 * 0.2651997875936538) / 0.22466545, rel=1e-6
    )


def moved(model, constraints, values):
    for parameter, value in values.items():
        parameter.value = value
    return model.solve(0.5, constraints)


def test_prices_are_slopes_in_the_units_of_the_user():
    contact = random_system(np.random.default_rng(1), 4, loads=("mean", "cyclic", "one", "two"))
    for stiff, force in few([(1e9, 1e4), (1.0, 1.0)], 1):
        loads = {name: (force * q, force * p) for name, (q, p) in contact.bonded.items()}
        system = fo.ContactSystem.from_blocks(
            stiff * contact.A, stiff * contact.B, stiff * contact.C, contact.x, loads
        )
        model = fo.DesignModel(system, CYCLE, preloads=["one", "two"], profile=True)
        depth, budget, tilt = cp.Parameter(nonneg=True), cp.Parameter(), cp.Parameter()
        constraints = [
            cp.abs(model.profile) <= depth,
            (cp.norm1(model.preload) <= budget).set_label("budget"),
            system.x @ model.profile == tilt,
            cp.NonNeg(0.1 * depth - model.profile[1]),
        ]
        start = {depth: 0.2 * force / stiff, budget: 0.5, tilt: 0.05 * force / stiff}

        design = moved(model, constraints, start)
        rates = {"budget": design.prices["budget"], "tilt": design.prices["constraints[2]"]}
        rates["depth"] = (
            design.prices["constraints[0]"].sum() + 0.1 * design.prices["constraints[3]"]
        )
        for name, parameter in (("depth", depth), ("budget", budget), ("tilt", tilt)):
            up, down = (
                moved(model, constraints, {**start, parameter: (1 + step) * start[parameter]})
                for step in (1e-5, -1e-5)
            )
            slope = (up.load_factor - down.load_factor) / (2e-5 * start[parameter])
            assert rates[name] == pytest.approx(slope, rel=1e-4, abs=1e-6 * abs(slope)), name
        assert rates["budget"] > 0 and rates["depth"] > 0 and abs(rates["tilt"]) > 0


def test_a_profile_is_in_the_gap_and_what_it_adds_is_an_overlap():
    contact = random_system(np.random.default_rng(6), 3)
    model = fo.DesignModel(contact.with_gap([0.0, 0.02, 0.0]), CYCLE, profile=True)
    design = model.solve(0.4, [model.profile == np.array([0.05, -0.01, -0.03])])
    assert design.system.gap.tolist() == pytest.approx([0.05, 0.01, 0.0])
    assert design.cycle.mean["profile"] == 1.0
    q, p = contact.reaction({"mean": 1.0})
    total = np.array([0.05, 0.01, -0.03])
    assert design.system.closed_reaction(design.cycle.mean)[0] == pytest.approx(
        q - contact.B.T @ total
    )
    assert design.system.closed_reaction(design.cycle.mean)[1] == pytest.approx(
        p - contact.C @ total
    )
    table = design.to_frame()
    assert table["profile"].tolist() == pytest.approx([0.05, -0.01, -0.03]) and "slip" in table
    printed = explained(design)
    assert "best design" in printed and "profile == [ 0.05 -0.01 -0.03]" in printed
