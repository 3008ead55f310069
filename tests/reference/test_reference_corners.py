"""Corner modes against finite differences of their Airy function and against complex potentials,
which share no formula with them."""

from functools import partial

import numpy as np
import pytest

import frictopt as fo

HALF_ANGLE, INTERFACE = 3 * np.pi / 4, np.pi / 4
MODES = pytest.mark.parametrize(
    "mode", fo.reference.bonded_corner(), ids=("symmetric", "antisymmetric")
)


def potentials(exponent, theta, kolosov=1.8):
    """Columns: (s_tt, s_rt, u_r, u_t) at r = 1 of Kolosov-Muskhelishvili potentials `a z^l`, `b
    z^l` for a = 1, i and b = 1, i; 2 mu = 1."""
    z = np.exp(1j * theta)
    columns = []
    for a, b in [(1, 0), (1j, 0), (0, 1), (0, 1j)]:
        first, first_d, first_dd = (
            a * c * z ** (exponent - k)
            for k, c in enumerate((1, exponent, exponent * (exponent - 1)))
        )
        second, second_d = b * z**exponent, b * exponent * z ** (exponent - 1)
        traction = first_d + np.conj(first_d) + z**2 * (np.conj(z) * first_dd + second_d)
        displacement = (kolosov * first - z * np.conj(first_d) - np.conj(second)) / z
        columns.append([traction.real, traction.imag, displacement.real, displacement.imag])
    return np.array(columns).T


def least_singular_value(matrix):
    """Least singular value after scaling rows and columns, so that it is small only where the
    determinant vanishes."""
    matrix = matrix / np.linalg.norm(matrix, axis=1)[:, None]
    return np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0), compute_uv=False)[-1]


def sliding_matrix(exponent, ratio, kolosov=1.8):
    """Eight conditions of punch (quarter-plane above) and block (half-plane below), interface theta
    = 0, `s_rt = ratio * s_tt`."""
    interface, punch, block = (
        potentials(exponent, theta, kolosov) for theta in (0, np.pi / 2, -np.pi)
    )
    none = np.zeros((2, 4))
    free = np.vstack([np.hstack([punch[:2], none]), np.hstack([none, block[:2]])])
    continuous = np.hstack([interface[[0, 1, 3]], -interface[[0, 1, 3]]])
    friction = np.hstack([interface[1] - ratio * interface[0], np.zeros(4)])
    return np.vstack([free, continuous, friction])


def cartesian(function, x, y):
    return function(np.hypot(x, y), np.arctan2(y, x))


def airy(mode, r, theta):
    """The Airy function `r^(l+1) F(theta)`, whose second derivative along r is the hoop stress."""
    return mode.stress(r, theta)[1] * r**2 / (mode.exponent * (mode.exponent + 1))


@MODES
def test_bonded_stresses_are_derivatives_of_the_airy_function(mode):
    h = 1e-3
    for x, y in [(1.0, 0.3), (-0.4, 0.9), (0.2, -1.1)]:
        phi = {
            (i, j): cartesian(partial(airy, mode), x + i * h, y + j * h)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        }
        s_yy = (phi[1, 0] - 2 * phi[0, 0] + phi[-1, 0]) / h**2
        s_xx = (phi[0, 1] - 2 * phi[0, 0] + phi[0, -1]) / h**2
        s_xy = -(phi[1, 1] - phi[1, -1] - phi[-1, 1] + phi[-1, -1]) / (4 * h**2)
        theta = np.arctan2(y, x)
        turn = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
        polar = turn @ np.array([[s_xx, s_xy], [s_xy, s_yy]]) @ turn.T
        assert cartesian(mode.stress, x, y) == pytest.approx(
            (polar[0, 0], polar[1, 1], polar[0, 1]), abs=1e-5
        )


@MODES
def test_bonded_faces_are_free_and_the_mode_is_not_zero(mode):
    for side in (1, -1):
        _, s_tt, s_rt = mode.stress([0.1, 1.0, 7.0], side * HALF_ANGLE)
        assert np.abs([s_tt, s_rt]).max() < 1e-12
        slope = (
            airy(mode, 1.0, side * HALF_ANGLE + 1e-5) - airy(mode, 1.0, side * HALF_ANGLE - 1e-5)
        ) / 2e-5
        assert abs(slope) < 1e-9
    assert abs(mode.stress(1.0, INTERFACE)[1]) > 0.1


@pytest.mark.parametrize("f", [0, 0.2, 0.7, 1.9])
def test_sliding_exponent_is_the_leading_root_of_the_eight_conditions(f):
    exponent = fo.reference.sliding_corner_exponent(f)
    for kolosov in (1.0, 1.8, 3.0):  # Poisson's ratio of one half, 0.3 in plane strain, zero
        assert least_singular_value(sliding_matrix(exponent, f, kolosov)) < 1e-12
    smaller = np.linspace(0.01, exponent - 0.005, 300)
    assert min(least_singular_value(sliding_matrix(trial, f)) for trial in smaller) > 1e-5


def test_friction_beyond_which_no_mode_is_singular():
    assert 0 < fo.reference.sliding_corner_exponent(3 * np.pi / 4 - 1 / np.pi - 1e-6) < 1e-5
