"""The corner of a square punch bonded to a half-plane of the same material: Williams' eigenfunctions of a three-quarter plane.

Polar coordinates sit at the left corner of the contact, `theta` anticlockwise from the bisector of the material. The free face of the block is
`theta = -3 pi/4`, the interface `theta = pi/4` (running along +x into the contact), the free side of the punch `theta = 3 pi/4`.
"""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array
from ..errors import ModelError
from ._numerics import bisection

_HALF_ANGLE = 3 * pi / 4
_INTERFACE = pi / 4


@dataclass(frozen=True)
class CornerMode:
    """One singular mode, stress proportional to `r ** (exponent - 1)` and displacement to `r ** exponent`, of arbitrary amplitude.

    Made by `bonded_corner`: with any other exponent the faces are not free. `airy` and `stress` raise `ModelError` for distances that are not
    positive and values that are not real and finite.

    Attributes
    ----------
    exponent
        The exponent l of the displacement, dimensionless, in (0, 1).
    symmetric
        Whether the Airy function is even about the bisector (mode I) or odd (mode II).

    Examples
    --------
    >>> from frictopt.reference import bonded_corner
    >>> symmetric, _ = bonded_corner()
    >>> round(symmetric.traction_ratio, 4)  # the corner sticks if the coefficient of friction is above
    0.5431
    """

    exponent: float
    symmetric: bool

    def airy(self, r: ArrayLike, theta: ArrayLike) -> Array:
        """Airy stress function `r^(l+1) F(theta)` at distance r (any length unit) and angle theta (radian), arrays that broadcast."""
        return _distance(r) ** (self.exponent + 1) * self._angular(theta, 0)

    def stress(self, r: ArrayLike, theta: ArrayLike) -> tuple[Array, Array, Array]:
        """Polar stresses `(s_rr, s_tt, s_rt)`, tension positive, at distance r and angle theta (radian), arrays that broadcast."""
        l1 = self.exponent + 1
        scale = _distance(r) ** (self.exponent - 1)
        F, dF, ddF = (self._angular(theta, order) for order in (0, 1, 2))
        return scale * (l1 * F + ddF), scale * l1 * self.exponent * F, -scale * self.exponent * dF

    @property
    def traction_ratio(self) -> float:
        """Signed `q / p` on the interface at the left corner; it has the other sign at the right corner.

        `q` is the force of the block on the punch along +x, `p` the pressure. The ratio is the same at every distance. Under the symmetric
        mode alone (pressed together) the corner sticks iff the coefficient of friction exceeds it, and else the punch slips outward.
        """
        _, s_tt, s_rt = self.stress(1.0, _INTERFACE)
        return float(s_rt / s_tt)

    def _angular(self, theta: ArrayLike, order: int) -> Array:
        """Derivative of F of the given order: two harmonics, weighted such that F vanishes on both faces; F' does so only at an eigenvalue."""
        plus, minus = self.exponent + 1, self.exponent - 1
        wave = cos if self.symmetric else sin
        phase = order * pi / 2 - (0.0 if self.symmetric else pi / 2)  # each derivative of a cosine advances it by a quarter turn
        angle = finite_array("theta", theta)
        harmonics = [k**order * np.cos(k * angle + phase) for k in (minus, plus)]
        return np.asarray(wave(plus * _HALF_ANGLE) * harmonics[0] - wave(minus * _HALF_ANGLE) * harmonics[1])


def _distance(r: ArrayLike) -> Array:
    distance = finite_array("r", r)
    if (distance <= 0).any():
        raise ModelError(f"r: {distance.min():g}; give distances above 0, the stress has no value at the corner itself")
    return distance


def bonded_corner() -> tuple[CornerMode, CornerMode]:
    """The two singular modes of the bonded corner of a square punch, symmetric (stronger) and antisymmetric.

    Punch (quarter-plane) and block (half-plane) are of the same material, so the bonded pair is one wedge of angle `2 alpha = 3 pi / 2` with free
    faces. Those are free where `F = F' = 0` at `theta = +-alpha`, which for the symmetric and antisymmetric functions is
    `sin(2 alpha l) +- l sin(2 alpha) = 0`, here `sin(3 pi l / 2) = +-l`; each has one root in (0, 1).

    Returns
    -------
    tuple[CornerMode, CornerMode]
        Modes with exponents near 0.544 and 0.909, dimensionless, independent of the elastic constants.

    References
    ----------
    M. L. Williams (1952), Stress singularities resulting from various boundary conditions in angular corners of plates in extension, Journal
    of Applied Mechanics 19, 526-528. C. M. Churchman and D. A. Hills (2006), General results for complete contacts subject to oscillatory shear,
    Journal of the Mechanics and Physics of Solids 54, 1186-1205: its use for complete contacts.

    Examples
    --------
    >>> from frictopt.reference import bonded_corner
    >>> [round(mode.exponent, 4) for mode in bonded_corner()]
    [0.5445, 0.9085]
    """
    even = bisection(lambda exponent: sin(2 * _HALF_ANGLE * exponent) - exponent, 1 / 3, 2 / 3)
    odd = bisection(lambda exponent: sin(2 * _HALF_ANGLE * exponent) + exponent, 2 / 3, 0.95)  # 1, a rigid rotation, is a root as well
    return CornerMode(even, symmetric=True), CornerMode(odd, symmetric=False)
