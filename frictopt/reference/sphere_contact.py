"""A sphere pressed on a half-space and sheared to and fro: the contact of Hertz, Mindlin and Deresiewicz."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array, finite_number
from ..errors import ModelError
from ._shared import poisson_ratio

_SMALL, _TERMS = 0.1, 20  # shear over the bound below which the closed form loses digits, and so many terms of its series do not


@dataclass(frozen=True)
class SphereContact:
    """Sphere on a half-space of the same material, under a constant normal force and a shear force that starts from zero.

    Slip across the direction of the force, which Poisson's ratio causes, is neglected as it is in the sources; the solution is exact for `nu = 0`.

    Parameters
    ----------
    P
        Normal force, positive.
    R
        Radius of the sphere, length, positive.
    E
        Young's modulus of both bodies, force per area, positive.
    nu
        Poisson's ratio of both bodies, above -1 and at most 0.5.
    f
        Coefficient of friction, positive.

    Raises
    ------
    ModelError
        Values that are not real and finite, or out of range.

    References
    ----------
    R. D. Mindlin and H. Deresiewicz (1953), Elastic spheres in contact under varying oblique forces, Journal of Applied Mechanics 20, 327-344.
    K. L. Johnson (1985), Contact Mechanics, Cambridge University Press, sections 4.2 and 7.4. V. L. Popov (2014), Analytic solution for the limiting
    shape of profiles due to fretting wear, Scientific Reports 4, 3749: the worn sphere.

    Examples
    --------
    >>> from frictopt.reference import SphereContact
    >>> ball = SphereContact(P=1.0, R=1.0, E=1.0, nu=0.0, f=0.5)
    >>> round(ball.half_width, 9), round(ball.dissipation(0.25), 9)
    (1.144714243, 0.009229495)
    """

    P: float
    R: float
    E: float
    nu: float
    f: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            object.__setattr__(self, name, poisson_ratio(name, value) if name == "nu" else finite_number(name, value, above=0.0))

    @property
    def half_width(self) -> float:
        """Radius a of the contact, length: `a^3 = 3 P R / (4 E*)` with `E* = E / (2 (1 - nu^2))`."""
        return float((1.5 * self.P * self.R * (1 - self.nu**2) / self.E) ** (1 / 3))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure, `3 P / (2 pi a^2)`."""
        return float(1.5 * self.P / (pi * self.half_width**2))

    def dissipation(self, Q: float) -> float:
        """Work of friction per cycle of the shear force between -Q and Q, force times length.

        With `x = Q / (f P)` and the shear modulus G of both bodies::

            W = 9 f^2 P^2 / (10 a) * 2 (2 - nu) / G * {1 - (1 - x)^(5/3) - (5 x / 6) [1 + (1 - x)^(2/3)]}

        Parameters
        ----------
        Q
            Amplitude of the shear force, from 0 to f P.

        Raises
        ------
        ModelError
            Q out of range: beyond f P the sphere slides.
        """
        x = finite_number("Q", Q, least=0.0) / (self.f * self.P)
        if x > 1:
            raise ModelError(f"Q: {Q:g}; give at most f P = {self.f * self.P:g}, beyond which the sphere slides")
        shear_modulus = self.E / (2 * (1 + self.nu))
        unit = 2 * (2 - self.nu) / shear_modulus * (self.f * self.P) ** 2 / self.half_width
        if x < _SMALL:
            return 0.9 * unit * _series(x)
        return float(0.9 * unit * (1 - (1 - x) ** (5 / 3) - 5 * x / 6 * (1 + (1 - x) ** (2 / 3))))

    def worn_depth(self, r: ArrayLike, Q: float) -> Array:
        """Depth worn off at distance r from the middle, length, any shape, once shear between -Q and Q has worn the sphere in.

        The stick zone stays, and in the end it carries the whole force: the sphere indents by d more, as a flat punch of radius c does. With
        `c = a (1 - Q / (f P))^(1/3)` and `d = 2 (a^3 - c^3) / (3 R c)` (Popov 2014), outside of c and where it is positive::

            h = c^2/R + d - r^2/(2R) - ((2 c^2 - r^2) arcsin(c/r) + r c sqrt(1 - c^2/r^2)) / (pi R) - (2 d / pi) arcsin(c/r)

        Raises
        ------
        ModelError
            Q not below f P, or negative, or r that is not real and finite.
        """
        x = finite_number("Q", Q, least=0.0, below=self.f * self.P) / (self.f * self.P)
        a, R, place = self.half_width, self.R, np.abs(finite_array("r", r))
        c = a * (1 - x) ** (1 / 3)
        d, far = 2 * (a**3 - c**3) / (3 * R * c), np.maximum(place, c)
        angle = np.arcsin(c / far)
        lifted = ((2 * c**2 - far**2) * angle + c * np.sqrt(far**2 - c**2)) / (pi * R)
        return np.where(place > c, np.maximum(c**2 / R + d - far**2 / (2 * R) - lifted - 2 * d / pi * angle, 0.0), 0.0)


def _series(x: float) -> float:
    """The braces of the dissipation by powers of x, the first of which is x^3: the binomial series of both roots."""
    k = np.arange(1, _TERMS)
    root = np.cumprod((k - 1 - 5 / 3) / k)  # (-1)^k binomial(5/3, k)
    other = np.cumprod(np.r_[1.0, (k - 1 - 2 / 3) / k])[:-1]  # (-1)^(k-1) binomial(2/3, k-1)
    return float(((-root - 5 / 6 * other) * x**k)[2:].sum())
