"""One model under several load cycles: its limits are those of models of these load cycles."""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.separation import lifted_system
from helpers.spatial import CORNERS, random_contact
from helpers.systems import CYCLE, NODE, random_system

SPACE = fo.LoadCycle({"mean": 1.0}, CORNERS)
TO_AND_FRO = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])


def changed(cycle, rng, fixed=False):
    """Another mean load and other amplitudes, of which the first corner may be within the hull."""
    corners = [
        {name: float(rng.uniform(0.3, 2.0)) * value for name, value in corner.items()}
        for corner in cycle.corners
    ]
    mean = {name: float(rng.uniform(0.7, 2.0)) * value for name, value in cycle.mean.items()}
    parts = [{name: 0.1 * k for name in mean} for k in range(len(corners))]
    return fo.LoadCycle(mean, corners, fixed=parts if fixed else None)


def agree(found, other):
    assert found.load_factor == pytest.approx(other.load_factor, rel=1e-7, nan_ok=True)
    assert found.least == pytest.approx(other.least, rel=1e-7, abs=1e-9, nan_ok=True)
    assert not found.residual > 1e-9
    assert (found.open == other.open).all()


@pytest.mark.parametrize("seed", few(range(9)))
def test_limits_are_those_of_models_of_the_load_cycles(seed):
    rng = np.random.default_rng([seed, 78])
    questions = [
        (random_system(rng, 5), CYCLE),
        (lifted_system(rng, 4), CYCLE),
        (random_contact(rng, 3), SPACE),
    ]
    system, cycle = questions[seed % 3]
    model = fo.ShakedownModel(system, cycle)
    first = model.solve(0.5)
    for fixed in (False, True, False):
        other = changed(cycle, rng, fixed)
        friction = float(rng.uniform(0.3, 0.8))
        agree(model.solve(friction, cycle=other), fo.shakedown_limit(system, other, friction))
    agree(model.solve(0.5), first)


def test_a_limit_by_hand():
    """A node is pressed by P and sheared by Q to and fro: the limit is f P / Q."""
    model = fo.ShakedownModel(NODE, TO_AND_FRO)
    for P, Q, friction in [(1.0, 1.0, 0.5), (3.0, 0.5, 0.4), (0.2, 2.0, 0.9)]:
        cycle = fo.LoadCycle({"P": P}, [{"Q": -Q}, {"Q": Q}])
        limit = model.solve(friction, cycle=cycle)
        assert limit.load_factor == pytest.approx(friction * P / Q, rel=1e-9)
        assert limit.problem.value == pytest.approx(limit.load_factor, rel=1e-9)


def test_corners_within_the_hull_of_one_load_cycle_are_vertices_of_another():
    """Of three corners on a line the middle one is left out, until it is an end."""
    middle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 0.5}, {"Q": 1.0}])
    end = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 4.0}, {"Q": 1.0}])
    model = fo.ShakedownModel(NODE, middle)
    assert model.solve(0.5).load_factor == pytest.approx(0.5)
    # The slip moves the mean of the shear forces to zero: their range is 5 Q.
    assert model.solve(0.5, cycle=end).load_factor == pytest.approx(2 * 0.5 / 5)


def test_another_number_of_corners_is_refused():
    model = fo.ShakedownModel(NODE, TO_AND_FRO)
    with pytest.raises(fo.ModelError, match=r"cycle: 1 corner, the model has 2; give as many"):
        model.solve(0.5, cycle=fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]))
