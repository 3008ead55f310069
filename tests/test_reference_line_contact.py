"""The closed forms of Hertz, Cattaneo and Mindlin against their own integrals; `test_path_line_contact` has them against a discrete contact."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from frictopt.reference import LineContact, contact_modulus

CONTACT = LineContact(P=1.3, R=8.0, E_star=2.6 * 4 / np.pi, f=0.3)  # half-width 2
SHARES = (0.4375, 0.75, 0.9375)  # of gross sliding


def test_contact_modulus():
    assert contact_modulus(2.0, 0.3, 2.0, 0.3) == pytest.approx(1 / 0.91, rel=1e-12)
    assert contact_modulus(2.0, 0.5, 1e12, 0.0) == pytest.approx(2 / 0.75, rel=1e-9)
    assert contact_modulus(1.0, 0.1, 3.0, 0.4) == contact_modulus(3.0, 0.4, 1.0, 0.1)


def integral(function, *kinks):
    pieces = sorted({-CONTACT.half_width, *kinks, *(-kink for kink in kinks), CONTACT.half_width})
    return sum(quad(function, left, right, epsabs=1e-11, epsrel=1e-11)[0] for left, right in pairwise(pieces))


def test_tractions_carry_the_load_and_respect_friction():
    gross, x = CONTACT.f * CONTACT.P, np.linspace(-2.4, 2.4, 999)
    assert integral(CONTACT.pressure) == pytest.approx(CONTACT.P, rel=1e-8)
    for share in SHARES:
        Q0 = share * gross
        assert integral(lambda s, Q0=Q0: CONTACT.shear(s, -Q0), CONTACT.stick_half_width(Q0)) == pytest.approx(-Q0, rel=1e-8)
        q, bound = CONTACT.shear(x, Q0), CONTACT.f * CONTACT.pressure(x)
        assert (np.abs(q) <= bound * (1 + 1e-12)).all() and np.array_equal(np.isclose(q, bound), np.abs(x) >= CONTACT.stick_half_width(Q0))


def test_dissipation_is_friction_times_slip_integrated():
    for share in (1e-3, 0.0999, 0.1001, 0.5, 0.99):
        Q0 = share * CONTACT.f * CONTACT.P
        c = CONTACT.stick_half_width(Q0)
        density = integral(lambda s, Q0=Q0: CONTACT.f * CONTACT.pressure(s) * abs(CONTACT.slip(s, Q0)) / CONTACT.dissipation(Q0), c)
        assert 4 * density == pytest.approx(1, rel=1e-6)  # there and back, over twice the slip of the first loading
    assert CONTACT.dissipation(0) == 0
    small = 1e-6  # where the terms of the closed form cancel to the first ones of its series
    series = 4 * (CONTACT.f * CONTACT.P) ** 2 / (np.pi * CONTACT.E_star) * (small**3 / 6 + small**4 / 12)
    assert CONTACT.dissipation(small * CONTACT.f * CONTACT.P) / series == pytest.approx(1, rel=1e-10)


def test_tractions_are_zero_and_slip_is_unknown_outside_the_contact():
    outside = [-2.01, 3.0]
    assert (CONTACT.pressure(outside) == 0).all() and (CONTACT.shear(outside, 0.1) == 0).all()
    assert np.isnan(CONTACT.slip(outside, 0.1)).all()
