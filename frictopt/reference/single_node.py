"""The contact of one node: the smallest system in which slip changes the normal force."""

from ..errors import ModelError
from ._checks import number
from .uncoupled import uncoupled_limit

__all__ = ["single_node_limit"]


def single_node_limit(A: float, B: float, q0: float, p0: float, q1: float, p1: float, f: float) -> float:
    """Shakedown limit of one node, `lambda_1 = lambda_2`.

    With slip v the reactions at the corners `s = -1, +1` are `q = q0 + lam s q1 + A v` and `p = p0 + lam s p1 + B v`. Two bounds on v, one
    from each sense of slip, close on each other as the load grows and meet at::

        lambda = f (A p0 - B q0) / max(|A q1 - f^2 B p1|, f |A p1 - B q1|)

    The first entry of the maximum rules for `|q1| > f |p1|`: above the limit the node slips to and fro. Otherwise the second does: one corner
    unloads the node until it lifts off.

    Parameters
    ----------
    A, B
        Tangential force and normal force per slip (v along +x), force per depth and length, `A > 0`.
    q0, p0
        Bonded reactions of the mean load, tangential (along +x) and normal (compression positive), force per depth.
    q1, p1
        Bonded reactions of the corner `s = +1` at load factor one, force per depth.
    f
        Coefficient of friction, dimensionless, `0 < f < A / |B|`: from `A / |B|` on the node wedges and the bounds no longer meet.

    Returns
    -------
    float
        Dimensionless; inf if the load does not touch the node, nan if no slip is safe even without the cyclic load.

    Raises
    ------
    ModelError
        A value that is not real and finite, stiffness or friction not positive, friction at or above the critical one.

    References
    ----------
    A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic contact problems with Coulomb friction, International Journal of
    Solids and Structures 44, 8355-8365: the conditions; the expression is where the two bounds meet.
    """
    A, B = number("A", A, above=0.0), number("B", B)
    q0, p0, q1, p1 = (number(name, value) for name, value in zip(("q0", "p0", "q1", "p1"), (q0, p0, q1, p1), strict=True))
    f = number("f", f, above=0.0)
    if f * abs(B) >= A:
        raise ModelError(f"f: {f:g} is not below the critical friction A/|B| = {A / abs(B):g}; give less friction or weaker coupling")
    return uncoupled_limit(q0, p0, q1, p1, f, d=B / A)
