"""Products of a half-space: the fields of point forces, and limits by the matrix they make."""

import numpy as np
import pytest

import frictopt as fo
from studies.half_space import CYCLE, HalfSpace, punch_on_half_space

ALL = slice(0, 3)


def test_far_from_a_cell_its_force_is_a_point_force():
    """Boussinesq and Cerruti, Johnson 1985, (3.19) and (3.75), at the modulus 1."""
    cells, nu = 16, 0.2
    surface = HalfSpace(cells, 1.0, nu, float)
    shear_modulus = 1 / (2 * (1 + nu))
    x, y = np.meshgrid(np.arange(16.0), np.arange(16.0), indexing="ij")
    far = np.hypot(x, y) > 6
    x, y = x[far], y[far]
    r = np.hypot(x, y)
    beside_x, beside_y = (1 - 2 * nu) * x / r**2 / 2, (1 - 2 * nu) * y / r**2 / 2
    fields = (
        [(1 - nu) / r + nu * x**2 / r**3, nu * x * y / r**3, -beside_x],
        [nu * x * y / r**3, (1 - nu) / r + nu * y**2 / r**3, -beside_y],
        [beside_x, beside_y, (1 - nu) / r],
    )
    for axis, field in enumerate(fields):
        force = np.zeros((3, cells, cells))
        force[axis, 0, 0] = 1.0
        moved = surface.motions(force, ALL, ALL).reshape(3, cells, cells)[:, far]
        exact = np.array(field) / (2 * np.pi * shear_modulus)
        assert np.abs(moved - exact).max() < 0.01 * np.abs(exact).max()


def test_the_limit_is_that_of_the_dense_matrix():
    contact = punch_on_half_space(6)
    surface = HalfSpace(6, 1 / 6, 0.3, float)
    compliance = np.array([surface.motions(unit, ALL, ALL) for unit in np.eye(108)])
    S = np.linalg.inv((compliance + compliance.T) / 2)
    dense = fo.ContactSystem((S + S.T) / 2, contact.points, contact.bonded)
    exact = fo.shakedown_limit(dense, CYCLE, 0.5, open_nodes=np.zeros(36, dtype=bool)).load_factor
    limit = fo.shakedown_limit(contact, CYCLE, 0.5, gap=0.01)
    assert limit.load_factor <= exact <= limit.bound <= limit.load_factor / 0.99
    assert dense.bonded["approach"][1].sum() == pytest.approx(contact.bonded["approach"][1].sum())
