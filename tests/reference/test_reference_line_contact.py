"""The closed forms of Hertz, Cattaneo and Mindlin against their own integrals, and the half-plane's
influence matrix against its own.

`test_path_line_contact` has each against the other: closed forms know no matrix, the matrix knows
no closed form.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import frictopt as fo

CONTACT = fo.reference.LineContact(P=1.3, R=8.0, E_star=2.6 * 4 / np.pi, f=0.3)  # half-width 2
SHARES = (0.4375, 0.75, 0.9375)  # of gross sliding


def integral(function, *kinks):
    pieces = sorted({-CONTACT.half_width, *kinks, *(-kink for kink in kinks), CONTACT.half_width})
    return sum(
        quad(function, left, right, epsabs=1e-11, epsrel=1e-11)[0]
        for left, right in pairwise(pieces)
    )


def test_tractions_carry_the_load_and_respect_friction():
    gross, x = CONTACT.f * CONTACT.P, np.linspace(-2.4, 2.4, 999)
    assert integral(CONTACT.pressure) == pytest.approx(CONTACT.P, rel=1e-8)
    for share in SHARES:
        Q0 = share * gross
        assert integral(
            lambda s, Q0=Q0: CONTACT.shear(s, -Q0), CONTACT.stick_half_width(Q0)
        ) == pytest.approx(-Q0, rel=1e-8)
        q, bound = CONTACT.shear(x, Q0), CONTACT.f * CONTACT.pressure(x)
        assert (np.abs(q) <= bound * (1 + 1e-12)).all() and np.array_equal(
            np.isclose(q, bound), np.abs(x) >= CONTACT.stick_half_width(Q0)
        )


def test_dissipation_begins_with_the_cube_of_the_shear():
    assert CONTACT.dissipation(0) == 0
    small = 1e-6  # where the terms of the closed form cancel to the first ones of its series
    series = (
        4 * (CONTACT.f * CONTACT.P) ** 2 / (np.pi * CONTACT.E_star) * (small**3 / 6 + small**4 / 12)
    )
    assert CONTACT.dissipation(small * CONTACT.f * CONTACT.P) / series == pytest.approx(
        1, rel=1e-10
    )


def test_tractions_are_zero_outside_the_contact():
    outside = [-2.01, 3.0]
    assert (CONTACT.pressure(outside) == 0).all() and (CONTACT.shear(outside, 0.1) == 0).all()


def test_influence_is_the_mean_of_the_logarithm_over_both_cells():
    nodes, E_star = 7, 1.7
    G = fo.reference.half_plane_influence(nodes, E_star)
    for i, j in [(0, 0), (1, 2), (0, 2), (0, 6)]:
        offset = abs(i - j)
        points = [point for point in (-offset, 0) if abs(point) < 1]

        def integrand(t, offset=offset):  # t: difference of the places in the two cells, in cells
            return (1 - abs(t)) * np.log(abs(offset + t) / nodes) if offset + t else 0.0

        mean, _ = quad(integrand, -1, 1, points=points, epsabs=1e-10, limit=200)
        assert G[i, j] == pytest.approx(-2 / (np.pi * E_star) * mean, rel=1e-8)


def test_influence_of_distant_cells_has_no_cancellation():
    G = fo.reference.half_plane_influence(4000, np.pi)
    d = np.array([500.0, 3999.0])
    # the mean of the logarithm, expanded about the distance of the middles
    series = np.log(d / 4000) - 1 / (12 * d**2) - 1 / (60 * d**4)
    assert G[0, d.astype(int)] == pytest.approx(-2 / np.pi * series / np.pi, abs=1e-13)


@pytest.mark.parametrize("nodes", [2, 3, 50])
def test_stiffness_inverts_the_influence_up_to_translation(nodes):
    arrays, G = (
        fo.reference.half_plane_contact(nodes, 1.0, 2.0),
        fo.reference.half_plane_influence(nodes, 2.0),
    )
    A, share = arrays["A"], arrays["bonded"]["P"][1]
    assert np.linalg.eigvalsh(G)[0] > 0
    assert (
        arrays["x"] == pytest.approx((2 * np.arange(nodes) + 1) / nodes - 1)
        and not arrays["gap"].any()
    )  # middles of the cells
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
    assert inverse - np.outer(
        inverse.sum(axis=1), inverse.sum(axis=0)
    ) / inverse.sum() == pytest.approx(A, abs=1e-10)


def test_influence_in_space_is_far_away_that_of_point_forces():
    """Cerruti: of two bodies, `(1 + nu) 2 / (pi E r)` along the force and in its direction, `1 -
    nu` times as much beside it."""
    E, nu, cells = 2.0, 0.4, 21
    system = fo.ContactSystem(
        **fo.reference.half_space_contact(cells, half_length=0.5 * cells, R=1e3, E=E, nu=nu)
    )
    n, at = (
        system.nodes,
        {tuple(place): node for node, place in enumerate(system.points[:, :2].round(9).tolist())},
    )
    moved, middle = np.linalg.inv(system.S[: 2 * n, : 2 * n]), at[0.0, 0.0]
    unit = 2 * (1 + nu) / (np.pi * E)
    for (x, y), force, share in (
        ((9, 0), (1, 0), 1.0),
        ((0, 9), (1, 0), 1 - nu),
        ((7, 7), (1, 1), 1.0),
        ((7, 7), (1, -1), 1 - nu),
    ):
        node, way = at[float(x), float(y)], np.array(force) / np.hypot(*force)
        found = way @ moved[np.ix_([node, n + node], [middle, n + middle])] @ way
        assert found == pytest.approx(share * unit / np.hypot(x, y), rel=5e-3)


@pytest.mark.parametrize("beta", [0.3, -0.15])
def test_a_bonded_punch_of_two_materials_has_the_oscillating_pressure(beta):
    """Johnson (1985), section 2.8: pressure and shear turn by eta along the punch."""
    arrays = fo.reference.half_plane_contact(400, 1.0, 1.0, beta=beta)
    x, (q, p) = arrays["x"], arrays["bonded"]["P"]
    inner = np.abs(x) < 0.9
    eta = np.log((1 + beta) / (1 - beta)) / (2 * np.pi) * np.log((1 + x) / (1 - x))
    size = 2 / 400 / (np.pi * np.sqrt(1 - beta**2) * np.sqrt(1 - x**2))
    assert p[inner] == pytest.approx((size * np.cos(eta))[inner], rel=5e-3)
    sign = np.sign(q[300] * np.sin(eta[300]))
    assert sign * q[inner] == pytest.approx((size * np.sin(eta))[inner], abs=5e-3 * size.min())
    assert p.sum() == pytest.approx(1.0) and q.sum() == pytest.approx(0.0, abs=1e-9)
    S = np.block([[arrays["A"], arrays["B"].T], [arrays["B"], arrays["C"]]])
    assert np.linalg.eigvalsh(S).min() > -1e-9


def test_one_material_is_the_limit_of_two():
    one, two = (
        fo.reference.half_plane_contact(30, 1.0, 2.0),
        fo.reference.half_plane_contact(30, 1.0, 2.0, beta=1e-12),
    )
    for name in "ABC":
        assert two[name] == pytest.approx(one[name], abs=1e-9)
    with pytest.raises(fo.ModelError, match="beta"):
        fo.reference.half_plane_contact(30, 1.0, 2.0, beta=0.5)
