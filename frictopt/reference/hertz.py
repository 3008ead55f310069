"""A cylinder or a sphere that is pressed on a flat body and sheared to and fro.

These are the contacts of Hertz, Cattaneo, Mindlin and Deresiewicz.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array, finite_array, finite_number
from ..errors import ModelError


class _Round:
    """Base of round bodies, with fields that are positive numbers, or Poisson's ratio."""

    P: float
    f: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name == "nu":
                checked = finite_number(name, value, above=-1.0, most=0.5)
            else:
                checked = finite_number(name, value, above=0.0)
            object.__setattr__(self, name, checked)

    def _share(self, name: str, Q: float) -> float:
        """Size of a shear force divided by its bound, below 1."""
        share = abs(finite_number(name, Q)) / (self.f * self.P)
        if share >= 1:
            raise ModelError(
                f"{name}: {Q:g}; the body slides, "
                f"give a shear force below f P = {self.f * self.P:g}"
            )
        return share


def _work(a: float, x: float) -> float:
    """The series `x^3 / 6 (1 + a x / 2 + ...)` of a work of friction, where x is Q / (f P).

    The closed form of this series loses digits if x is small.
    """
    # Imported here, because other closed forms need numpy alone.
    from scipy.special import hyp2f1

    return x**3 / 6 * float(hyp2f1(a, 2, 4, x))


@dataclass(frozen=True)
class LineContact(_Round):
    """Cylinder on a half-plane, sheared under a constant normal force.

    The shear force starts from zero. Materials are similar: shear does not change the pressure (`B
    = 0`), as for two equal materials. Methods take a shear force Q: the resultant, along +x, of the
    tractions q of the half-plane on the cylinder. Q must be less than `f P` in size, because the
    cylinder slides at `f P`.

    Parameters
    ----------
    P
        Normal force, compression positive, force per depth, positive.
    R
        Radius of the cylinder (of two cylinders: `1 / R = 1 / R1 + 1 / R2`), length, positive and
        large compared with the contact.
    E_star, f
        Contact modulus, `1 / E* = (1 - nu1^2) / E1 + (1 - nu2^2) / E2`, stress, positive;
        coefficient of friction, dimensionless, positive.

    References
    ----------
    C. Cattaneo (1938), Sul contatto di due corpi elastici: distribuzione locale degli sforzi,
    Rendiconti dell'Accademia Nazionale dei Lincei 27. R. D. Mindlin (1949), Compliance of elastic
    bodies in contact, Journal of Applied Mechanics 16, 259-268. Mindlin and Deresiewicz (1953), see
    `SphereContact`: cycles and their work. K. L. Johnson (1985), Contact Mechanics, Cambridge
    University Press: the cylinder. M. Ciavarella (1998), The generalized Cattaneo partial slip
    plane contact problem, International Journal of Solids and Structures 35, 2349-2362; Popov
    (2014), see `SphereContact`: worn contacts.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> from frictopt.reference import LineContact
    >>> contact = LineContact(P=1.0, R=10.0, E_star=100.0, f=0.5)
    >>> round(contact.half_width, 4), round(contact.stick_half_width(0.25), 4)
    (0.3568, 0.2523)
    >>> f"{contact.dissipation(0.25):.4e}"
    '9.0484e-05'
    """

    P: float
    R: float
    E_star: float
    f: float

    @property
    def half_width(self) -> float:
        """Half-width `a = sqrt(4 P R / (pi E_star))` of the contact, length."""
        return sqrt(4 * self.P * self.R / (pi * self.E_star))

    @property
    def peak_pressure(self) -> float:
        """Pressure `2 P / (pi a)` in the middle, stress."""
        return 2 * self.P / (pi * self.half_width)

    def stick_half_width(self, Q: float) -> float:
        """Half-width `c = a sqrt(1 - |Q| / (f P))` of the part that has not slipped, length.

        In a cycle, pass half the change since the last reversal as Q.
        """
        return self.half_width * sqrt(1 - self._share("Q", Q))

    def pressure(self, x: ArrayLike) -> Array:
        """Pressure, stress, at distance x (any shape) from the middle; zero beyond the contact."""
        return self.peak_pressure * _ellipse(finite_array("x", x), self.half_width)

    def shear(self, x: ArrayLike, Q: float) -> Array:
        """Shear traction q, stress, at x (length, any shape) when the shear force first reaches Q.

        It is f p, minus f times the pressure in a contact of half-width c.
        """
        a = self.half_width
        c = self.stick_half_width(Q)
        x = finite_array("x", x)
        peak = float(np.sign(Q)) * self.f * self.peak_pressure
        return peak * (_ellipse(x, a) - c / a * _ellipse(x, c))

    def dissipation(self, Q0: float) -> float:
        """Work of friction in one cycle of the shear force between `-Q0` and `Q0`.

        The work, in force per depth times length, is the integral of friction times slip over both
        slipping edges. With `z = |Q0| / (f P)`::

            W = 4 f^2 P^2 / (pi E_star) (z - z^2 / 2 + (1 - z) log(1 - z))
        """
        unit = 4 * (self.f * self.P) ** 2 / (pi * self.E_star)
        return unit * _work(1.0, self._share("Q0", Q0))

    def worn_depth(self, x: ArrayLike, Q0: float) -> Array:
        """Depth worn off in the end, length, at x (length, any shape).

        Shear between `-Q0` and `Q0` wears the cylinder. The stick zone does not wear, and in the
        end it carries the whole force. With `c = a sqrt(1 - |Q0| / (f P))` (Ciavarella 1998, Popov
        2014)::

            h = (a^2 arccosh(|x| / c) - |x| sqrt(x^2 - c^2)) / (2 R)     where that is positive
        """
        a = self.half_width
        c = self.stick_half_width(Q0)
        outside = np.maximum(np.abs(finite_array("x", x)), c)
        height = a**2 * np.arccosh(outside / c) - outside * np.sqrt(outside**2 - c**2)
        depth: Array = np.maximum(height, 0.0) / (2 * self.R)
        return depth


@dataclass(frozen=True)
class SphereContact(_Round):
    """Sphere on a half-space of the same material, sheared under a constant normal force.

    The shear force starts from zero. Poisson's ratio causes slip across the direction of the force.
    As in the sources, this slip is neglected; the solution is exact for `nu = 0`.

    Parameters
    ----------
    P, R, f
        Normal force, radius of the sphere, length, and coefficient of friction, positive.
    E, nu
        Young's modulus of both bodies, force per area, positive, and Poisson's ratio, above -1 and
        at most 0.5.

    References
    ----------
    R. D. Mindlin and H. Deresiewicz (1953), Elastic spheres in contact under varying oblique
    forces, Journal of Applied Mechanics 20, 327-344. K. L. Johnson (1985), Contact Mechanics,
    Cambridge University Press, sections 4.2 and 7.4. V. L. Popov (2014), Analytic solution for the
    limiting shape of profiles due to fretting wear, Scientific Reports 4, 3749: the worn sphere.

    Raises
    ------
    ModelError
        A value is out of its range.

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

    @property
    def half_width(self) -> float:
        """Radius a of the contact, length: `a^3 = 3 P R / (4 E*)`, `E* = E / (2 (1 - nu^2))`."""
        return float((1.5 * self.P * self.R * (1 - self.nu**2) / self.E) ** (1 / 3))

    def dissipation(self, Q: float) -> float:
        """Work of friction per cycle of the shear force between -Q and Q, force times length.

        With `x = Q / (f P)` and the shear modulus G of both bodies::

            W = 9 f^2 P^2 / (10 a) * 2 (2 - nu) / G * {1 - (1 - x)^(5/3) - (5 x / 6) [1 + (1 -
            x)^(2/3)]}

        Q is the amplitude of the shear force. It must be below f P, because the sphere slides at f
        P.
        """
        shear_modulus = self.E / (2 * (1 + self.nu))
        unit = 2 * (2 - self.nu) / shear_modulus * (self.f * self.P) ** 2 / self.half_width
        return 0.9 * unit * 5 / 27 * _work(4 / 3, self._share("Q", Q))


def _ellipse(x: Array, half_width: float) -> Array:
    return np.sqrt(np.maximum(0.0, 1 - (x / half_width) ** 2))
