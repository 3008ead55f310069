"""Wedging: friction so large that a node can stay locked by its own slip, without any load."""

from math import cos, pi, sin

from ..contact.checks import finite_number
from ..errors import ModelError


def critical_friction(A: float, B: float) -> float:
    """Critical coefficient of friction `A / |B|` of one node.

    With slip v and no load the reactions are `q = A v` and `p = B v`. From `f = A / |B|` on, slip towards the side of `B v > 0` builds up enough
    pressure to hold itself: the node stays wedged. Beyond it, the stiffness `A - f |B|` against slip along the bound that presses the node
    is negative. On that bound (`q = f p` for `B > 0`) a load rate with `f dp^w - dq^w > 0` may be followed by stick or by slip, and one
    with `f dp^w - dq^w < 0` by neither: the node jumps.

    Parameters
    ----------
    A, B
        Tangential force and normal force per slip (v along +x), force per depth and length, `A > 0`.

    Returns
    -------
    float
        Dimensionless; inf without coupling.

    Raises
    ------
    ModelError
        A value that is not real and finite, tangential stiffness not positive.

    References
    ----------
    A. Klarbring (1990), Examples of non-uniqueness and non-existence of solutions to quasistatic contact problems with friction,
    Ingenieur-Archiv 60, 529-541.

    Examples
    --------
    >>> from frictopt.reference import critical_friction
    >>> critical_friction(A=1.0, B=-0.5)
    2.0
    """
    A, B = finite_number("A", A, above=0.0), abs(finite_number("B", B))
    return A / B if B else float("inf")


def tilted_bar(k: float, angle: float) -> tuple[float, float, float]:
    """Stiffness `(A, B, C)` of a node that one straight bar supports: the simplest node that wedges, at `f = |cot(angle)|`.

    The bar rises from the node, which is body 1, into body 1's support. The motion `(v, w)` of the node shortens the bar by
    `v cos(angle) + w sin(angle)`, and the force of the foundation on the node is k times that, along the bar::

        A = k cos^2(angle)      B = k sin(angle) cos(angle)      C = k sin^2(angle)

    Parameters
    ----------
    k
        Axial stiffness of the bar, force per depth and length, positive.
    angle
        Angle from +x to the bar, radian, between 0 and pi; a bar that leans towards +x, `angle < pi/2`, is pressed by slip along +x.

    Returns
    -------
    tuple[float, float, float]
        Stiffnesses of a single node, force per depth and length; `A C = B^2`, because motion across the bar meets no force.

    Raises
    ------
    ModelError
        A value that is not real and finite, stiffness not positive, an angle out of range.

    References
    ----------
    A. Klarbring (1990), Examples of non-uniqueness and non-existence of solutions to quasistatic contact problems with friction,
    Ingenieur-Archiv 60, 529-541: a node on inclined springs.

    Examples
    --------
    >>> from math import pi
    >>> from frictopt.reference import tilted_bar
    >>> [round(value, 12) for value in tilted_bar(k=2.0, angle=pi / 4)]
    [1.0, 1.0, 1.0]
    """
    k, angle = finite_number("k", k, above=0.0), finite_number("angle", angle, above=0.0)
    if angle >= pi:
        raise ModelError(f"angle: {angle:g}; give an angle in radian below pi")
    along, across = cos(angle), sin(angle)
    return k * along**2, k * across * along, k * across**2
