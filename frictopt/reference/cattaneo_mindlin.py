"""A cylinder pressed on a half-plane and under alternating shear: the contact of Hertz, Cattaneo and Mindlin."""

from dataclasses import dataclass, fields
from math import log1p, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array, finite_number
from ..errors import ModelError
from ._shared import poisson_ratio


def contact_modulus(E1: float, nu1: float, E2: float, nu2: float) -> float:
    """Contact modulus of two bodies in plane strain, `1 / E_star = (1 - nu1^2) / E1 + (1 - nu2^2) / E2`.

    Parameters
    ----------
    E1, E2
        Young's moduli, stress, positive.
    nu1, nu2
        Poisson's ratios, dimensionless, above -1 and at most 0.5.

    Returns
    -------
    float
        Stress.

    Raises
    ------
    ModelError
        Values that are not real and finite, or out of range.

    References
    ----------
    K. L. Johnson (1985), Contact Mechanics, Cambridge University Press.

    Examples
    --------
    >>> from frictopt.reference import contact_modulus
    >>> round(contact_modulus(E1=210e9, nu1=0.3, E2=210e9, nu2=0.3) / 1e9, 2)
    115.38
    """
    E1, E2 = finite_number("E1", E1, above=0.0), finite_number("E2", E2, above=0.0)
    return 1 / ((1 - poisson_ratio("nu1", nu1) ** 2) / E1 + (1 - poisson_ratio("nu2", nu2) ** 2) / E2)


@dataclass(frozen=True)
class LineContact:
    """Cylinder on a half-plane of similar material, under a constant normal force and a shear force that starts from zero.

    Similar are materials whose shear does not change the pressure (`B = 0`), two equal ones above all. Methods take a shear force Q, the
    resultant of the tractions q of the half-plane on the cylinder along +x, of magnitude below `f P`: beyond that the cylinder slides.

    Parameters
    ----------
    P
        Normal force, compression positive, force per depth, positive.
    R
        Radius of the cylinder (of two cylinders: `1 / R = 1 / R1 + 1 / R2`), length, positive and large against the contact.
    E_star
        Contact modulus, see `contact_modulus`, stress, positive.
    f
        Coefficient of friction, dimensionless, positive.

    Raises
    ------
    ModelError
        Values that are not real and finite or not positive; by the methods, a shear force out of range or a point that is not real and finite.

    References
    ----------
    C. Cattaneo (1938), Sul contatto di due corpi elastici: distribuzione locale degli sforzi, Rendiconti dell'Accademia Nazionale dei Lincei 27.
    R. D. Mindlin (1949), Compliance of elastic bodies in contact, Journal of Applied Mechanics 16, 259-268. R. D. Mindlin and H. Deresiewicz
    (1953), Elastic spheres in contact under varying oblique forces, Journal of Applied Mechanics 20, 327-344: cycles and their work, for
    spheres. K. L. Johnson (1985), Contact Mechanics, Cambridge University Press: the cylinder. M. Ciavarella (1998), The generalized Cattaneo partial
    slip plane contact problem, International Journal of Solids and Structures 35, 2349-2362; V. L. Popov (2014), Analytic solution for the limiting
    shape of profiles due to fretting wear, Scientific Reports 4, 3749: worn contacts.

    Examples
    --------
    >>> from frictopt.reference import LineContact
    >>> contact = LineContact(P=1.0, R=10.0, E_star=100.0, f=0.5)
    >>> round(contact.half_width, 4), round(contact.stick_half_width(0.25), 4), f"{contact.dissipation(0.25):.4e}"
    (0.3568, 0.2523, '9.0484e-05')
    """

    P: float
    R: float
    E_star: float
    f: float

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, finite_number(field.name, getattr(self, field.name), above=0.0))

    @property
    def half_width(self) -> float:
        """Half-width `a = sqrt(4 P R / (pi E_star))` of the contact, length."""
        return sqrt(4 * self.P * self.R / (pi * self.E_star))

    @property
    def peak_pressure(self) -> float:
        """Pressure `2 P / (pi a)` in the middle, stress."""
        return 2 * self.P / (pi * self.half_width)

    def stick_half_width(self, Q: float) -> float:
        """Half-width `c = a sqrt(1 - |Q| / (f P))` of the part that has not slipped when the shear force first reaches Q, length.

        In a cycle, put half the change of shear force since the last reversal for Q.
        """
        return self.half_width * sqrt(1 - self._share("Q", Q))

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure at distance x from the middle, length, any shape; zero outside the contact, stress."""
        return self.peak_pressure * _ellipse(finite_array("x", x), self.half_width)

    def shear(self, x: ArrayLike, Q: float) -> Array:
        """Shear traction q at x, length, any shape, when the shear force first reaches Q, stress.

        It is f times the pressure, less the traction of a smaller contact of half-width c that keeps the middle from slipping.
        """
        a, c, x = self.half_width, self.stick_half_width(Q), finite_array("x", x)
        peak = float(np.sign(Q)) * self.f * self.peak_pressure
        return peak * (_ellipse(x, a) - c / a * _ellipse(x, c))

    def slip(self, x: ArrayLike, Q: float) -> Array:
        """Slip v at x, length, any shape, when the shear force first reaches Q: against Q, zero for `|x| <= c`, nan outside the contact, length.

        It grows from the edge of the stick region with the slope `2 f p_0 sqrt(x^2 - c^2) / (E_star a)`, where p_0 is the peak pressure.
        """
        a, c = self.half_width, self.stick_half_width(Q)
        distance = np.abs(finite_array("x", x))
        beyond = np.maximum(distance, c)
        grown = 0.5 * (beyond * np.sqrt(beyond**2 - c**2) - c**2 * np.arccosh(beyond / c))
        slip = -np.sign(Q) * 2 * self.f * self.peak_pressure / (self.E_star * a) * grown
        return np.where(distance <= a, slip, np.nan)

    def dissipation(self, Q0: float) -> float:
        """Work of friction in one cycle of the shear force between `-Q0` and `Q0`, force per depth times length.

        Pressure times slip, integrated over both slipping edges; with `z = |Q0| / (f P)`::

            W = 4 f^2 P^2 / (pi E_star) (z - z^2 / 2 + (1 - z) log(1 - z))
        """
        z = self._share("Q0", Q0)
        # For a small share the three terms cancel to z^3 / 6: add up what is left of them.
        bracket = z - z**2 / 2 + (1 - z) * log1p(-z) if z > 0.1 else sum(z**k / (k * (k - 1)) for k in range(3, 25))
        return 4 * (self.f * self.P) ** 2 / (pi * self.E_star) * bracket

    def worn_depth(self, x: ArrayLike, Q0: float) -> Array:
        """Depth worn off at x, length, any shape, once shear between `-Q0` and `Q0` has worn the cylinder in.

        The stick zone stays, and in the end it carries the whole force. With `c = a sqrt(1 - |Q0| / (f P))` (Ciavarella 1998, Popov 2014)::

            h = (a^2 arccosh(|x| / c) - |x| sqrt(x^2 - c^2)) / (2 R)     where that is positive
        """
        a, c, x = self.half_width, self.stick_half_width(Q0), np.abs(finite_array("x", x))
        far = np.maximum(x, c)
        depth: Array = np.maximum(a**2 * np.arccosh(far / c) - far * np.sqrt(far**2 - c**2), 0.0) / (2 * self.R)
        return depth

    def _share(self, name: str, Q: float) -> float:
        share = abs(finite_number(name, Q)) / (self.f * self.P)
        if share >= 1:
            raise ModelError(f"{name}: {Q:g}; the cylinder slides, give a shear force below f P = {self.f * self.P:g}")
        return share


def _ellipse(x: Array, half_width: float) -> Array:
    return np.sqrt(np.maximum(0.0, 1 - (x / half_width) ** 2))
