"""The half-plane's influence matrix and the contact of Hertz: each against the other, by plain active sets.

Closed forms know no matrix, the matrix knows no closed form. Meshes are refined with the edges of the contact on edges of cells, so that errors fall
at a clean rate.
"""

import numpy as np
import pytest
from scipy.integrate import quad

from frictopt.reference import LineContact, half_plane_contact, half_plane_influence

CONTACT = LineContact(P=1.3, R=2.0, E_star=2.6 * 4 / np.pi, f=0.3)  # half-width 1
HALF_LENGTH = 1.25
MESHES = (40, 80, 160, 320)


def orders(errors):
    """Observed order of convergence from each mesh to the next, which has twice the cells."""
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


def pressed(nodes):
    """Middles of the cells, cell width, influence matrix and forces p of the cylinder under P, from `G p + gap + c >= 0`, zero in contact."""
    h = 2 * HALF_LENGTH / nodes
    x = -HALF_LENGTH + h * (np.arange(nodes) + 0.5)
    G, gap = half_plane_influence(nodes, CONTACT.E_star), x**2 / (2 * CONTACT.R)
    closed = np.ones(nodes, dtype=bool)
    for _ in range(50):
        active = np.flatnonzero(closed)
        border = np.ones((len(active), 1))
        bordered = np.block([[G[np.ix_(active, active)], border], [border.T, np.zeros((1, 1))]])
        solution = np.linalg.solve(bordered, np.r_[-gap[active], CONTACT.P])
        p = np.zeros(nodes)
        p[active] = solution[:-1]
        touching = np.where(closed, p > 0, G @ p + gap + solution[-1] < 0)
        if (touching == closed).all():
            return x, h, G, p
        closed = touching
    raise AssertionError("the contact did not settle")


def test_influence_is_the_mean_of_the_logarithm_over_both_cells():
    nodes, E_star = 7, 1.7
    G = half_plane_influence(nodes, E_star)
    for i, j in [(0, 0), (1, 2), (0, 2), (0, 6)]:
        offset = abs(i - j)
        points = [point for point in (-offset, 0) if abs(point) < 1]

        def integrand(t, offset=offset):  # t: difference of the places in the two cells, in cells
            return (1 - abs(t)) * np.log(abs(offset + t) / nodes) if offset + t else 0.0

        mean, _ = quad(integrand, -1, 1, points=points, epsabs=1e-10, limit=200)
        assert G[i, j] == pytest.approx(-2 / (np.pi * E_star) * mean, rel=1e-8)


def test_influence_of_distant_cells_has_no_cancellation():
    G = half_plane_influence(4000, np.pi)
    d = np.array([500.0, 3999.0])
    series = np.log(d / 4000) - 1 / (12 * d**2) - 1 / (60 * d**4)  # the mean of the logarithm, expanded about the distance of the middles
    assert G[0, d.astype(int)] == pytest.approx(-2 / np.pi * series / np.pi, abs=1e-13)


@pytest.mark.parametrize("nodes", [2, 3, 50])
def test_stiffness_inverts_the_influence_up_to_translation(nodes):
    arrays, G = half_plane_contact(nodes, 1.0, 2.0), half_plane_influence(nodes, 2.0)
    A, share = arrays["A"], arrays["bonded"]["P"][1]
    assert np.linalg.eigvalsh(G)[0] > 0
    assert np.abs(A.sum(axis=1)).max() < 1e-13 * np.abs(A).max()
    assert np.linalg.eigvalsh(A)[1] > 1e-3
    r = np.random.default_rng(1).normal(size=nodes)
    for translation in (0.0, 3.7):
        assert A @ (G @ r + translation) + r.sum() * share == pytest.approx(r, abs=1e-12)
    assert np.ptp(G @ share) < 1e-13
    assert share.sum() == pytest.approx(1, rel=1e-12)
    shifted = G + 5.0  # another zero of the displacement
    inverse = np.linalg.inv(shifted)
    assert inverse.sum(axis=1) / inverse.sum() == pytest.approx(share, rel=1e-9)
    assert inverse - np.outer(inverse.sum(axis=1), inverse.sum(axis=0)) / inverse.sum() == pytest.approx(A, abs=1e-10)


def test_flat_punch_pressure():
    inner, whole = [], []
    for nodes in MESHES:
        arrays = half_plane_contact(nodes, 2.0, 1.5)
        x, share, edges = arrays["x"], arrays["bonded"]["P"][1], np.linspace(-1, 1, nodes + 1)
        assert (arrays["gap"] == 0).all()
        exact = np.diff(np.arcsin(edges)) / np.pi  # P / (pi sqrt(a^2 - x^2)), over each cell
        inner.append(share[np.abs(x) < 1.0].sum() - 2 / np.pi * np.arcsin(0.5))
        whole.append(np.abs(share - exact).sum())
    assert orders(np.array(inner)) == pytest.approx(1, abs=0.1)
    assert abs(inner[-1]) < 3e-4
    assert orders(np.array(whole)) == pytest.approx(0.5, abs=0.1) and whole[-1] < 1e-2  # the edge cells, in which the pressure is singular


def test_hertz_pressure_and_width():
    errors = []
    for nodes in MESHES:
        x, h, _, p = pressed(nodes)
        assert (p > 0).sum() * h / 2 == pytest.approx(CONTACT.half_width, rel=1e-12)  # exact, as it ends at the edge of a cell
        errors.append(np.abs(p / h - CONTACT.pressure(x)).sum() * h / CONTACT.P)
    assert orders(np.array(errors)) == pytest.approx(1.5, abs=0.1)
    assert errors[-1] < 2e-4
