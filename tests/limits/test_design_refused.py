"""Designs that cannot exist are refused.

They have no bounds, contradictory constraints, or no model that they could belong to.
"""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import Question
from helpers.liars import misread
from helpers.refused import refused
from helpers.systems import CYCLE, random_system

SHEAR = fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}])
CONTACT = random_system(np.random.default_rng(0), 2)


def uncoupled(shares, shears, names=("one", "two")):
    n = len(shears)
    bonded = {name: (np.zeros(n), share) for name, share in zip(names, shares, strict=True)}
    return fo.ContactSystem.from_blocks(
        np.eye(n), np.zeros((n, n)), np.eye(n), np.arange(n), {**bonded, "Q": (shears, np.zeros(n))}
    )


def test_designs_without_bounds_are_named_with_the_direction_in_which_they_grow():
    model = fo.DesignModel(uncoupled(np.eye(2), [1.0, 0.5]), SHEAR, preloads=["one", "two"])
    with pytest.raises(
        fo.ModelError,
        match=r"load_factor: it grows without bound with the design: .*preload\['two'\] has no upper bound",
    ):
        model.solve(0.5)
    with pytest.raises(fo.ModelError, match=r"preload\['one'\] has no upper bound"):
        model.solve(0.5, [model.preload[1] == 3.0], objective=model.preload[0])
    pulling = fo.DesignModel(uncoupled(-np.eye(2), [1.0, 0.5]), SHEAR, preloads=["one", "two"])
    with pytest.raises(
        fo.ModelError,
        match=r"preload\['one'\] has no lower bound, preload\['two'\] has no lower bound",
    ):
        pulling.solve(0.5)
    shaped = fo.DesignModel(CONTACT, CYCLE, preloads=["mean"], profile=True)
    with pytest.raises(fo.ModelError, match=r"design: (profile\[\d\] has no lower bound(, )?)+;"):
        shaped.solve(0.5, [cp.abs(shaped.preload) <= 0.1])
    pressing = fo.DesignModel(
        CONTACT, fo.LoadCycle({"mean": 1.0}, [{"mean": 1.0}]), preloads=["cyclic"]
    )
    with pytest.raises(fo.ModelError, match="load_factor: it grows without bound for any design"):
        pressing.solve(0.5, [cp.abs(pressing.preload) <= 0.1])


def test_designs_that_cannot_be_name_the_constraints_that_contradict():
    model = fo.DesignModel(uncoupled(np.eye(2), [1.0, 0.5]), SHEAR, preloads=["one", "two"])
    low = (model.preload[0] <= 1.0).set_label("strength")
    high = (model.preload[0] >= 2.0).set_label("seal")
    with pytest.raises(fo.ModelError, match=r"^strength, seal: they contradict each other"):
        model.solve(0.5, [low, model.preload[1] <= 5.0, high])
    with pytest.raises(
        fo.ModelError,
        match=r"^strength, constraints\[1\]: no design is safe at any load factor with all nodes closed under these",
    ):
        model.solve(0.5, [low, model.load_factor >= 0.6, model.preload >= 0.1])
    pulled = fo.DesignModel(
        uncoupled([[0.0, 0.0], [-1.0, -1.0]], [1.0, 0.5]),
        fo.LoadCycle({"two": 1.0}, SHEAR.corners),
        preloads=["one"],
    )
    with pytest.raises(
        fo.ModelError,
        match=r"^preloads: no design is safe at any load factor with all nodes closed; .*shakedown_limit",
    ):
        pulled.solve(0.5)
    with pytest.raises(fo.ModelError, match="another model"):
        model.solve(
            0.5,
            [
                fo.DesignModel(uncoupled(np.eye(2), [1.0, 0.5]), SHEAR, preloads=["one"]).preload
                <= 1.0
            ],
        )
    with pytest.raises(fo.ModelError, match=r"constraints\[0\]: not convex"):
        model.solve(0.5, [cp.norm(model.preload) >= 1.0])


@refused(
    ({}, "preloads, profile: none"),
    ({"preloads": ["bolt"]}, "preloads: 'bolt' is no load case"),
    ({"preloads": ["mean", "mean"]}, "name each load case once"),
    ({"profile": 1}, "profile: "),
    ({"profile": True, "scenarios": [CYCLE]}, r"scenarios\[0\]: "),
    ({"profile": True, "scenarios": [(CYCLE, -1.0)]}, "friction"),
    (
        {"profile": True, "scenarios": [(CYCLE, 0.5, {"bolt": 0.9})]},
        r"scenarios\[0\]: shares of \['bolt'\]",
    ),
)
def test_bad_models_are_refused(options):
    fo.DesignModel(CONTACT, CYCLE, **options)


def test_a_load_case_of_the_name_of_an_overlap_is_refused():
    contact = random_system(np.random.default_rng(0), 2, loads=("mean", "cyclic", "profile"))
    with pytest.raises(fo.ModelError, match="profile: the system has a load case 'profile'"):
        fo.DesignModel(contact, CYCLE, profile=True)


def test_a_design_that_breaks_the_law_in_one_scenario_is_no_answer(monkeypatch):
    violation = Question.violation
    monkeypatch.setattr(
        Question,
        "violation",
        lambda question, *at: 1e-6 if question.friction[0] == 0.6 else violation(question, *at),
    )
    model = fo.DesignModel(CONTACT, CYCLE, preloads=["mean"], scenarios=[(CYCLE, 0.6)])
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        model.solve(0.5, [cp.abs(model.preload) <= 0.1])


@pytest.mark.parametrize(
    "which", ["more preload than its own row admits", "multipliers of another bound"]
)
def test_a_design_beyond_its_rows_or_without_its_bound_is_no_answer(which, monkeypatch):
    """It is safe at the right load factor all the same."""
    model = fo.DesignModel(uncoupled(np.eye(2), [1.0, 0.5]), SHEAR, preloads=["one", "two"])
    lies = []
    rows = [model.preload >= 0.5, cp.sum(model.preload) <= 3.0]
    assert model.solve(0.5, rows).load_factor == pytest.approx(1.0)

    def lie(program, x, y):
        lies.append(which)
        if which.startswith("more"):
            x[1:3] += 1e-3
        else:
            y[::2] *= 1 + 1e-6

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        model.solve(0.5, rows)
    assert lies
