"""The half-plane's influence matrix and the contact of Hertz: each against the other, by plain active sets.

Closed forms know no matrix, the matrix knows no closed form. Meshes are refined with the edges of the contact on edges of cells, so that errors fall
at a clean rate.
"""

import numpy as np
import pytest
from scipy.integrate import quad

from frictopt.reference import half_plane_contact, half_plane_influence


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
    assert arrays["x"] == pytest.approx((2 * np.arange(nodes) + 1) / nodes - 1) and not arrays["gap"].any()  # middles of the cells
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
