"""What increments in space leave in the work of friction, and what the result tells of it: against many more increments, extrapolated."""

from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from cases import few
from spatial import cycle, random_contact, single

LAP = Path(__file__).parents[1] / "docs" / "tutorial" / "lap.msh"
HARD = [1, 11, 14, 16, 23, 29, 31, 35, 36, 38]  # slow decay, nodes that slip in the first cycles alone, errors that cancel, slip close to a corner


def problem(seed):
    rng = np.random.default_rng(seed)
    contact, friction, loads = random_contact(rng, int(rng.integers(1, 6))), float(rng.choice([0.2, 0.35, 0.5])), cycle(int(rng.integers(2, 4)))
    ratio = float(rng.choice([1.05, 1.15, 1.3, 1.6, 2.0]))
    return contact, loads, friction, ratio * fo.shakedown_limit(contact, loads, friction).load_factor


def told_over_true(asked, numbers, many):
    """Told over true errors with some numbers of increments, inf where none is true or known; the true work extrapolates `many` and twice as many."""
    fine = fo.steady_state(*asked, steps=many, progress=False)
    finest = fo.steady_state(*asked, steps=2 * many, initial_state=fine.state, progress=False)
    work = 2 * finest.dissipation - fine.dissipation
    states = [fo.steady_state(*asked, steps=steps, progress=False) for steps in numbers]
    true = np.array([abs(work - state.dissipation) for state in states])
    told = np.array([state.step_error * state.dissipation if np.isfinite(state.step_error) else np.inf for state in states])
    return np.where(true > 1e-9 * work, told / np.maximum(true, 1e-9 * work), np.inf)


@pytest.mark.parametrize("seed", few(HARD))
def test_the_error_told_is_not_below_the_true_one(seed):
    assert min(told_over_true(problem(seed), [1, 2, 4], 32)) >= 1


@pytest.mark.slow
def test_the_errors_told_of_random_contacts_are_two_to_three_times_the_true_ones():
    ratios = np.array([told_over_true(problem(seed), [1, 2, 4], 32) for seed in range(few(10, 5))])
    assert ratios.min() >= 1 and (np.median(ratios, axis=0) <= 3).all()


@pytest.mark.slow
def test_the_error_told_of_the_bolted_lap_joint_is_not_below_the_true_one():
    steel, plates = fo.Material(E=210e3, nu=0.3), ("upper", "lower")
    bodies = fo.split_bodies(fo.read_mesh(LAP), dict.fromkeys([*plates, "bolt"], steel))
    pairs = {"lap": plates, "head": ("bolt", "upper"), "nut": ("bolt", "lower")}
    model = fo.ContactModel(
        bodies,
        contacts=[fo.Contact(one, two, two, one, name=name) for name, (one, two) in pairs.items()],
        supports=[fo.Support("lower", "left")],
        loads={
            "preload": [fo.BoltPreload("bolt", "section", 20e3)],
            "pull": [fo.Traction("upper", "right", x=5.0)],
            "side": [fo.Traction("upper", "right", y=0.5)],
        },
    )
    loads = fo.LoadCycle({"preload": 1.0}, [{"pull": 1.0, "side": 1.0}, {"pull": -1.0, "side": -1.0}])
    assert min(told_over_true((model.condense(), loads, 0.3, 1.0), [2, 4], 16)) >= 1


def test_a_contact_at_rest_has_no_error():
    loads = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    for steps in (1, 2, 20):
        assert fo.steady_state(single(), loads, 0.5, 0.3, steps=steps).step_error == 0
