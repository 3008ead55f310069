"""The contact of one node: the smallest system in which slip changes the normal force."""

from ..contact.checks import finite_number
from ..contact.tolerances import ROUNDING
from ..errors import ModelError
from .uncoupled import uncoupled_limit


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

    Examples
    --------
    >>> from frictopt.reference import single_node_limit
    >>> single_node_limit(A=1.0, B=0.0, q0=0.0, p0=1.0, q1=1.0, p1=0.0, f=0.5)
    0.5
    """
    A, B, q0, p0, q1, p1, f = _checked(A, B, q0, p0, q1, p1, f)
    return uncoupled_limit(q0, p0, q1, p1, f, d=B / A)


def single_node_dissipation(A: float, B: float, q0: float, p0: float, q1: float, p1: float, f: float, load_factor: float) -> float:
    """Work of friction in one cycle of the steady state of one node, the same from every start.

    Up to the limit of `single_node_limit` it is zero. Above it the node slips forward up to the corner that pulls it forward, where it rests at
    `v_I` on `q = -f p`, and backward up to the other one, where it rests at `v_II` on `q = f p`. With `D = A p0 - B q0`, `e = A p1 - B q1`
    and `t` the sign of q1, the travel and the pressures at the two ends are::

        v_I - v_II = 2 (lam |A q1 - f^2 B p1| - f D) / (A^2 - f^2 B^2)
        p_I = (D - lam t e) / (A + f B)        p_II = (D + lam t e) / (A - f B)

    While the node slips its pressure is linear in v, so that the work of a passage is `f (v_I - v_II)` times the pressure half-way, and the two
    passages add up to::

        W = f (v_I - v_II) q1 (p_I / (q1 - f p1) + p_II / (q1 + f p1))

    Without coupling and cyclic pressure, `B = p1 = 0`, this is `4 f p0 (lam |q1| - f p0) / A`. In a larger uncoupled contact a node whose
    neighbours stick dissipates as much, with its own diagonal entry of the stiffness for A.

    Parameters
    ----------
    A, B
        Tangential force and normal force per slip (v along +x), force per depth and length, `A > 0`.
    q0, p0
        Bonded reactions of the mean load, tangential (along +x) and normal (compression positive), force per depth.
    q1, p1
        Bonded reactions of the corner `s = +1` at load factor one, force per depth.
    f
        Coefficient of friction, dimensionless, `0 < f < A / |B|`.
    load_factor
        Factor `lam` of the cyclic load, dimensionless, at least 0 and at most `D / |e|`, from where on the node lifts off at one of the corners.
        For `|q1| <= f |p1|` that is the limit itself: such a node never dissipates in full contact.

    Returns
    -------
    float
        Work per cycle, force per depth times length, at least 0.

    Raises
    ------
    ModelError
        A value that is not real and finite, stiffness or friction not positive, friction at or above the critical one, a negative load factor, a
        node that the mean load or the load factor lifts off.

    References
    ----------
    A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic contact problems with Coulomb friction, International Journal of
    Solids and Structures 44, 8355-8365: the two bounds; the work follows from them by the integration above.

    Examples
    --------
    >>> from frictopt.reference import single_node_dissipation
    >>> single_node_dissipation(A=1.0, B=0.0, q0=0.0, p0=1.0, q1=1.0, p1=0.0, f=0.5, load_factor=1.0)  # 4 f p0 (1 - f p0)
    1.0
    """
    A, B, q0, p0, q1, p1, f = _checked(A, B, q0, p0, q1, p1, f)
    lam = finite_number("load_factor", load_factor, least=0.0)
    D, e = A * p0 - B * q0, A * p1 - B * q1
    terms = A * abs(p0) + abs(B * q0)
    if D < -ROUNDING * terms:
        raise ModelError(f"p0: {p0:g}; the mean load lifts the node off, give more pressure")
    travel = 2 * (lam * abs(A * q1 - f**2 * B * p1) - f * D) / (A**2 - (f * B) ** 2)
    if lam * abs(e) - D > ROUNDING * (terms + lam * (abs(A * p1) + abs(B * q1))):
        raise ModelError(f"load_factor: {lam:g}; the node lifts off at one corner, give at most {max(D, 0.0) / abs(e):g}")
    if abs(q1) <= f * abs(p1) or travel <= 0:
        return 0.0
    swing = lam * e if q1 > 0 else -lam * e
    ends = (D - swing) / (A + f * B), (D + swing) / (A - f * B)
    return f * travel * q1 * (ends[0] / (q1 - f * p1) + ends[1] / (q1 + f * p1))


def _checked(A: float, B: float, q0: float, p0: float, q1: float, p1: float, f: float) -> tuple[float, ...]:
    A, B = finite_number("A", A, above=0.0), finite_number("B", B)
    q0, p0, q1, p1 = (finite_number(name, value) for name, value in zip(("q0", "p0", "q1", "p1"), (q0, p0, q1, p1), strict=True))
    f = finite_number("f", f, above=0.0)
    if f * abs(B) >= A:
        raise ModelError(f"f: {f:g} is not below the critical friction A/|B| = {A / abs(B):g}; give less friction or weaker coupling")
    return A, B, q0, p0, q1, p1, f
