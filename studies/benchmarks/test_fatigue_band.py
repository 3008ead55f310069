"""Stress maps and fatigue bands of 25 points against recoveries of single fields.

A recovery gives the stresses of one state. Half of the bands here are proven by a program for each
point (Crossland), the others search planes (Smith, Watson and Topper).
"""

import numpy as np
import pytest

import frictopt as fo


@pytest.fixture(scope="module")
def model():
    return fo.scenes.PunchOnHalfPlane(elements=24).model()


@pytest.fixture(scope="module")
def stresses(model):
    return model.stress_map(depth=0.0, side=2)


def recoveries(model, count):
    """Recover `count` fields, one after the other; the model already has its factorisation."""
    glued = np.zeros(model.condense().nodes)
    for _ in range(count):
        model.recover({"P": 1.0}, glued)


def test_a_stress_map_against_recoveries_one_by_one(compare, model):
    count = 3 + 2 * model.condense().nodes
    assert (
        compare(
            lambda: model.stress_map(depth=0.0, side=2), lambda: recoveries(model, count), rounds=3
        )
        < 0.5
    )


@pytest.mark.parametrize(("parameter", "most"), [("Crossland", 0.3), ("SWT", 5.0)])
def test_a_band_with_both_ends_against_thirty_recoveries(
    compare, model, stresses, cycle, parameter, most
):
    band = fo.fatigue_band(stresses, cycle, 0.7, 1.19, parameter)
    assert band.least < band.most
    assert (
        compare(
            lambda: fo.fatigue_band(stresses, cycle, 0.7, 1.19, parameter),
            lambda: recoveries(model, 30),
            rounds=3,
        )
        < most
    )
