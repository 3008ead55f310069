"""The corner of a square punch on a half-plane of the same material, bonded and sliding.

The bonded corner has Williams' eigenfunctions of a three-quarter plane. Polar coordinates have
their origin at the left corner of the contact; `theta` is anticlockwise from the bisector of the
material. The free face of the block is `theta = -3 pi/4`, the interface `theta = pi/4` (running
along +x into the contact), the free side of the punch `theta = 3 pi/4`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin, tan

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array, check_entries, finite_array, finite_number
from ..errors import ModelError

# theta of the free side of the punch, and of the interface
_HALF_ANGLE = 3 * pi / 4
_INTERFACE = pi / 4


@dataclass(frozen=True)
class CornerMode:
    """A singular mode, of arbitrary amplitude.

    Stress is proportional to `r ** (exponent - 1)` and displacement to `r ** exponent`. Use only
    the modes that `bonded_corner` returns: with any other exponent the faces are not free. `stress`
    raises `ModelError` for distances that are not positive.

    Attributes
    ----------
    exponent
        The exponent l of the displacement, dimensionless, in (0, 1).
    symmetric
        Whether the Airy function is even about the bisector (mode I) or odd (mode II).

    Examples
    --------
    >>> from frictopt.reference import bonded_corner
    >>> round(bonded_corner()[0].traction_ratio, 4)  # the corner sticks with friction above it
    0.5431
    """

    exponent: float
    symmetric: bool

    def stress(self, r: ArrayLike, theta: ArrayLike) -> tuple[Array, Array, Array]:
        """Polar stresses `(s_rr, s_tt, s_rt)`, tension positive, at distance r and angle theta.

        theta is in radians; r and theta are arrays that broadcast.
        """
        distance = finite_array("r", r)
        check_entries(
            "r",
            distance,
            distance > 0,
            "give distances above 0, because the stress is infinite at the corner",
            "index",
        )
        scale = distance ** (self.exponent - 1)
        F, dF, ddF = (self._angular(theta, order) for order in (0, 1, 2))
        s_rr = scale * ((self.exponent + 1) * F + ddF)
        s_tt = scale * (self.exponent + 1) * self.exponent * F
        s_rt = -scale * self.exponent * dF
        return s_rr, s_tt, s_rt

    @property
    def traction_ratio(self) -> float:
        """Signed `q / p` on the interface at the left corner; at the right corner its sign changes.

        `q` is the force of the block on the punch along +x, `p` the pressure. The ratio is the same
        at every distance. If only the symmetric mode is present (bodies pressed together), the
        corner sticks if the coefficient of friction exceeds this ratio; otherwise the punch slips
        outward.
        """
        _, s_tt, s_rt = self.stress(1.0, _INTERFACE)
        return float(s_rt / s_tt)

    def _angular(self, theta: ArrayLike, order: int) -> Array:
        """Derivative of F of the given order.

        F is the sum of two harmonics, weighted such that it vanishes on both faces; F' vanishes
        there only at an eigenvalue.
        """
        plus = self.exponent + 1
        minus = self.exponent - 1
        wave = cos if self.symmetric else sin
        # A sine is a cosine a quarter turn late; each derivative advances a cosine by a quarter.
        phase = order * pi / 2
        if not self.symmetric:
            phase -= pi / 2
        angle = finite_array("theta", theta)
        slow = minus**order * np.cos(minus * angle + phase)
        fast = plus**order * np.cos(plus * angle + phase)
        return np.asarray(wave(plus * _HALF_ANGLE) * slow - wave(minus * _HALF_ANGLE) * fast)


def bonded_corner() -> tuple[CornerMode, CornerMode]:
    """The two singular modes of the bonded corner of a square punch.

    The symmetric mode comes first, and is the stronger one. Punch (quarter-plane) and block
    (half-plane) are of the same material, so the bonded pair is one wedge of angle `2 alpha = 3 pi
    / 2` with free faces, `F = F' = 0` at `theta = +-alpha`. For the symmetric and the antisymmetric
    function this condition is `sin(2 alpha l) +- l sin(2 alpha) = 0`, here `sin(3 pi l / 2) = +-l`.
    Each equation has one root in (0, 1), near 0.544 and 0.909, independent of the elastic
    constants.

    Returns
    -------
    tuple of CornerMode
        The symmetric and the antisymmetric mode.

    References
    ----------
    M. L. Williams (1952), Stress singularities resulting from various boundary conditions in
    angular corners of plates in extension, Journal of Applied Mechanics 19, 526-528. C. M.
    Churchman and D. A. Hills (2006), General results for complete contacts subject to oscillatory
    shear, Journal of the Mechanics and Physics of Solids 54, 1186-1205: its use for complete
    contacts.

    Examples
    --------
    >>> from frictopt.reference import bonded_corner
    >>> [round(mode.exponent, 4) for mode in bonded_corner()]
    [0.5445, 0.9085]
    """
    even = _bisection(lambda exponent: sin(2 * _HALF_ANGLE * exponent) - exponent, 1 / 3, 2 / 3)
    # The bounds exclude the root 1, which is a rigid rotation.
    odd = _bisection(lambda exponent: sin(2 * _HALF_ANGLE * exponent) + exponent, 2 / 3, 0.95)
    return CornerMode(even, symmetric=True), CornerMode(odd, symmetric=False)


def sliding_corner_exponent(f: float) -> float:
    """Exponent l of the leading mode at a sliding corner.

    Displacement is of order `r^l`, pressure and friction are of order `r^(l-1)`. Punch
    (quarter-plane) and block (half-plane) stay in contact, and the punch slips outward, past the
    corner: `q = f p` on the interface. q is the force of the block on the punch, positive into the
    contact, p the pressure. l is the only root in (0, 1), dimensionless, independent of the elastic
    constants; it falls with f.

    Parameters
    ----------
    f
        Coefficient of friction, dimensionless, not negative, below `3 pi/4 - 1/pi`.

    Returns
    -------
    float
        The exponent l.

    Raises
    ------
    ModelError
        f not real and finite, negative, or so large that no exponent l lies in (0, 1).

    Notes
    -----
    A wedge between the interface `theta = 0` and a free face `theta = omega` has an Airy function
    `r^(l+1) F(theta)`, with `F = a cos(l+1)theta + b cos(l-1)theta + c sin(l+1)theta + e
    sin(l-1)theta`. Stresses are `s_tt = l (l+1) r^(l-1) F`, `s_rt = -l r^(l-1) F'`, and the normal
    displacement of the interface is `2 mu u_t = r^l (-F' - 4 (1-nu) e)`. Tractions and material are
    common to both wedges, so continuity of `u_t` requires the same `e` in both. `F = F' = 0` on the
    free face and `s_rt = f s_tt` on the interface give, per unit of `-(l+1) F(0) / 4`::

        e(omega) = (sin 2 l omega + l sin 2 omega - 2 f (sin^2 l omega + l sin^2 omega)) /
        (sin^2 l omega - l^2 sin^2 omega)

    and `e(pi/2) = e(-pi)`, the characteristic determinant, reduces to::

        sin(pi l) + 2 cot(pi l) (sin^2(pi l / 2) - l^2) = 2 f l (1 + l)

    The f that solves this equation falls steadily from `3 pi/4 - 1/pi` at l = 0 to `-1/pi` at l =
    1.

    References
    ----------
    J. Dundurs and M. S. Lee (1972), Stress concentration at a sharp edge in contact problems,
    Journal of Elasticity 2, 109-112, for f = 0. M. Comninou (1976), Stress singularity at a sharp
    edge in contact problems with friction, Zeitschrift für angewandte Mathematik und Physik 27,
    493-499. Churchman and Hills (2006), see `bonded_corner`.

    Examples
    --------
    >>> from frictopt.reference import sliding_corner_exponent
    >>> [round(sliding_corner_exponent(f), 4) for f in (0.0, 0.5, 1.0)]
    [0.774, 0.5604, 0.3854]
    """
    friction = finite_number("f", f, least=0.0)
    largest = 3 * pi / 4 - 1 / pi
    if not friction < largest:
        raise ModelError(f"f: {f:g} leaves no singular mode; give friction below {largest:.6g}")
    return _bisection(lambda exponent: _traction_ratio(exponent) - friction, 0.0, 1.0)


def _traction_ratio(exponent: float) -> float:
    """Ratio `q / p` that has the given leading exponent."""
    angle = pi * exponent
    return (sin(angle) + 2 / tan(angle) * (sin(angle / 2) ** 2 - exponent**2)) / (
        2 * exponent * (1 + exponent)
    )


def _bisection(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that is positive at `low` and negative at `high`, to the last digit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
