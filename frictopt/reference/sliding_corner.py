"""The corner of a square punch that slides on a half-plane of the same material."""

from math import pi, sin, tan
from typing import Literal

from ..contact.checks import choice, finite_number
from ..errors import ModelError
from ._numerics import bisection


def sliding_corner_exponent(f: float, *, slip: Literal["outward", "inward"] = "outward") -> float:
    """Exponent l of the leading mode at a sliding corner: displacement of order `r^l`, pressure and friction of order `r^(l-1)`.

    Punch (quarter-plane) and block (half-plane) stay in contact, `q = kappa p` on the interface. q is the force of the block on the punch,
    positive into the contact, p the pressure; `kappa = +f` for outward slip of the punch (past the corner), `-f` for inward slip.

    Parameters
    ----------
    f
        Coefficient of friction, dimensionless, not negative; below `3 pi/4 - 1/pi` (outward), below `1/pi` (inward).
    slip
        Sense of slip of the punch relative to the block: "outward", away from the contact, or "inward".

    Returns
    -------
    float
        The only root in (0, 1), dimensionless, independent of the elastic constants; it falls with f for outward slip and rises for inward slip.

    Raises
    ------
    ModelError
        f not real and finite, negative, or so large that no mode lies in (0, 1); unknown sense of slip.

    Notes
    -----
    A wedge between the interface `theta = 0` and a free face `theta = omega` has an Airy function `r^(l+1) F(theta)`, with
    `F = a cos(l+1)theta + b cos(l-1)theta + c sin(l+1)theta + e sin(l-1)theta`. Stresses are `s_tt = l (l+1) r^(l-1) F`,
    `s_rt = -l r^(l-1) F'`, and the normal displacement of the interface is `2 mu u_t = r^l (-F' - 4 (1-nu) e)`. Tractions and material are
    common to both wedges, so continuity of `u_t` asks for the same `e` in both. `F = F' = 0` on the free face and `s_rt = kappa s_tt` on the
    interface give, per unit of `-(l+1) F(0) / 4`::

        e(omega) = (sin 2 l omega + l sin 2 omega - 2 kappa (sin^2 l omega + l sin^2 omega)) / (sin^2 l omega - l^2 sin^2 omega)

    and `e(pi/2) = e(-pi)`, the characteristic determinant, reduces to::

        sin(pi l) + 2 cot(pi l) (sin^2(pi l / 2) - l^2) = 2 kappa l (1 + l)

    Solved for kappa it falls steadily from `3 pi/4 - 1/pi` at l = 0 to `-1/pi` at l = 1.

    References
    ----------
    J. Dundurs and M. S. Lee (1972), Stress concentration at a sharp edge in contact problems, Journal of Elasticity 2, 109-112, for f = 0.
    M. Comninou (1976), Stress singularity at a sharp edge in contact problems with friction, Zeitschrift für angewandte Mathematik und Physik 27,
    493-499. C. M. Churchman and D. A. Hills (2006), General results for complete contacts subject to oscillatory shear, Journal of the Mechanics and
    Physics of Solids 54, 1186-1205.

    Examples
    --------
    >>> from frictopt.reference import sliding_corner_exponent
    >>> [round(sliding_corner_exponent(f), 4) for f in (0.0, 0.5, 1.0)]
    [0.774, 0.5604, 0.3854]
    """
    kappa = finite_number("f", f, least=0.0) * (1 if choice("slip", slip, ("outward", "inward")) == "outward" else -1)
    strongest, weakest = 3 * pi / 4 - 1 / pi, -1 / pi
    if not weakest < kappa < strongest:
        largest = strongest if slip == "outward" else -weakest
        raise ModelError(f"f: {f:g} leaves no singular mode for {slip} slip; give friction below {largest:.6g}")
    return bisection(lambda exponent: _traction_ratio(exponent) - kappa, 0.0, 1.0)


def _traction_ratio(exponent: float) -> float:
    """Ratio `q / p` that has the given leading exponent."""
    angle = pi * exponent
    return (sin(angle) + 2 / tan(angle) * (sin(angle / 2) ** 2 - exponent**2)) / (2 * exponent * (1 + exponent))
