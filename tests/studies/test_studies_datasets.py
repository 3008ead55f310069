"""The study of data sets of others: its formulas, its numbers, and its quick table."""

from math import pi

import numpy as np
import pytest

from studies.datasets.study import DATASETS, dundurs, numbers, pressed_cylinder, total_of_half


def test_the_integral_of_half_a_roof_is_that_of_the_whole_roof():
    at = np.array([0.0, 0.5, 1.0])
    assert total_of_half(at, np.array([4.0, 2.0, 0.0])) == pytest.approx(4.0)


def test_the_constant_of_dundurs():
    """Plane strain; on rigid ground (1 - 2 nu) / (2 (1 - nu)), and the other sign if exchanged."""
    assert dundurs((1.0, np.inf), 0.3) == pytest.approx(2 / 7)
    assert dundurs((np.inf, 1.0), 0.3) == pytest.approx(-2 / 7)
    assert dundurs((5.0, 5.0), 0.3) == 0.0
    assert dundurs((1.0, 3.0), 0.5) == 0.0
    # With moduli 1 and 3 the compliances differ by half their sum.
    assert dundurs((1.0, 3.0), 0.3) == pytest.approx(1 / 7)


def test_a_cylinder_of_one_material_has_the_pressure_of_hertz():
    force, radius, modulus = 2.0, 7.0, 30.0
    x, p, q = pressed_cylinder(force, radius, modulus, 0.0, 0.4, 61, 3)
    a = np.sqrt(4 * force * radius / (pi * modulus))
    exact = 2 * force / (pi * a) * np.sqrt(np.maximum(1 - (x / a) ** 2, 0))
    assert np.abs(p - exact).max() < 0.06 * exact.max() and np.abs(q).max() < 1e-9
    assert p.max() == pytest.approx(exact.max(), rel=2e-3)
    assert p.sum() * (x[1] - x[0]) == pytest.approx(force)


def test_the_sign_of_the_mismatch_changes_only_the_sign_of_the_shear():
    _, p, q = pressed_cylinder(1.0, 3.0, 1.0, 0.25, 0.4, 31, 4)
    _, other_p, other_q = pressed_cylinder(1.0, 3.0, 1.0, -0.25, 0.4, 31, 4)
    assert np.allclose(p, other_p) and np.allclose(q, -other_q) and np.abs(q).max() > 0


def test_the_numbers_of_others_obey_their_friction():
    at, pressure = numbers("moose augmented", "pressure")
    same, shear = numbers("moose augmented", "shear")
    assert np.array_equal(at, same) and np.all(shear <= 0.4 * pressure * (1 + 1e-6))
    assert len(numbers("beam", "force")[0]) == len(numbers("beam", "frequency")[0]) == 8


def test_pressures_agree_and_differ_from_those_without_friction(quick):
    table = quick((DATASETS,))[DATASETS.name]
    middle = table[table["quantity"] == "pressure in the middle"]
    assert len(middle) == 2 and middle["difference"].abs().max() < 0.02
    at, theirs = numbers("moose augmented", "pressure")
    hertz = np.sqrt(total_of_half(at, theirs) * 1e6 / 0.91 / (pi * 3.0))
    assert middle["ours"].iloc[1] > 1.06 * hertz
    damping = table[table["quantity"].str.startswith("exponent")].iloc[0]
    assert damping["ours"] == pytest.approx(1.0, abs=0.1)
