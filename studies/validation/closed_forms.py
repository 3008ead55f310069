"""Closed forms of contacts with one node, of sliders, and of contacts whose nodes do not interact.

The load of each contact swings between two corners. The bonded reactions are `r0 + lam * s * r1`
with `s = -1, +1`. Their tangential parts are `q0, q1` along +x, and their normal parts `p0, p1`,
positive in compression. The limits follow from equal bounds of the slip. On the contacts that shake
down from every start, see A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic
contact problems with Coulomb friction, International Journal of Solids and Structures 44,
8355-8365.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from frictopt.base import ROUNDING, Array


def uncoupled_limit(
    q0: ArrayLike, p0: ArrayLike, q1: ArrayLike, p1: ArrayLike, f: ArrayLike, *, d: ArrayLike = 0.0
) -> float:
    """Limit lambda_1 = lambda_2 of an uncoupled or proportionally coupled contact.

    Uncoupled means `B = 0`; proportionally coupled means `B = D A` with `D = diag(d)`. With `B = D
    A` slip enters the law of node i only through its own `t_i = (A v)_i`, as `q += t` and `p += d
    t`. If A is positive definite, `A v = t` has a solution for every `t`. So each node acts like a
    single node of stiffness 1 and coupling `d`, and the weakest node governs::

        lambda = min over nodes of  f (p0 - d q0) / max(|q1 - f^2 d p1|, f |p1 - d q1|)

    For `d = 0` this is `f p0 / max(|q1|, f |p1|)`, for all A and q0. The second entry of the
    maximum governs if the node lifts off instead of slipping. In full contact `lambda_1 =
    lambda_2`. A node slips forward only if `t_i` is at its lower bound, and backward only if `t_i`
    is at its upper bound; safe slips lie between the bounds. So slip never increases the distance
    from a safe slip in the norm of A.

    Parameters
    ----------
    q0, p0, q1, p1
        Bonded reactions of the mean load and of the corner `s = +1` at load factor one, tangential
        (along +x) and normal (compression positive), (N,) or one number, force per depth.
    f, d
        Coefficient of friction, positive, and diagonal of D, (N,) or one number, dimensionless, `f
        |d| < 1`.

    Returns
    -------
    float
        Dimensionless; inf if the cyclic load does not load the nodes, nan if no slip is safe even
        without the cyclic load.
    """
    q0, p0, q1, p1, f, d = np.broadcast_arrays(q0, p0, q1, p1, f, d)
    strength = f * (p0 - d * q0)
    # A strength of zero may be off by the rounding of terms that cancel.
    terms = f * (np.abs(p0) + np.abs(d * q0))
    if (strength < -ROUNDING * terms).any():
        return float("nan")
    load = np.maximum(np.abs(q1 - f**2 * d * p1), f * np.abs(p1 - d * q1))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = np.maximum(strength, 0.0) / load
    return float(np.nanmin(ratio, initial=np.inf))


def single_node_limit(
    A: float, B: float, q0: float, p0: float, q1: float, p1: float, f: float
) -> float:
    """Shakedown limit of one node, `lambda_1 = lambda_2`.

    With slip v the reactions at the corners `s = -1, +1` are `q = q0 + lam s q1 + A v` and `p = p0
    + lam s p1 + B v`. Each sense of slip gives a bound on v. The two bounds approach each other as
    the load grows, and meet at::

        lambda = f (A p0 - B q0) / max(|A q1 - f^2 B p1|, f |A p1 - B q1|)

    The first entry of the maximum governs for `|q1| > f |p1|`: above the limit the node slips to
    and fro. Otherwise the second entry governs: one corner unloads the node until it lifts off.

    Parameters
    ----------
    A, B
        Tangential force and normal force per slip (v along +x), force per depth and length, `A >
        0`.
    q0, p0, q1, p1
        Bonded reactions as in `uncoupled_limit`, force per depth.
    f
        Coefficient of friction, dimensionless, `0 < f < A / |B|`: at `A / |B|` and above, the node
        wedges and the bounds do not meet.

    Returns
    -------
    float
        Dimensionless; inf if the cyclic load does not load the node, nan if no slip is safe even
        without the cyclic load.
    """
    return uncoupled_limit(q0, p0, q1, p1, f, d=B / A)


def single_node_dissipation(
    A: float, B: float, q0: float, p0: float, q1: float, p1: float, f: float, load_factor: float
) -> float:
    """Work of friction in one cycle of the steady state of one node, the same from every start.

    Up to the limit of `single_node_limit` it is zero. Above it the node slips forward until one
    corner, where it stops at `v_I` with `q = -f p`, and backward until the other corner, where it
    stops at `v_II` with `q = f p`. With `D = A p0 - B q0`, `e = A p1 - B q1` and `t` the sign of
    q1, the travel and the pressures at the two ends are::

        v_I - v_II = 2 (lam |A q1 - f^2 B p1| - f D) / (A^2 - f^2 B^2)
        p_I = (D - lam t e) / (A + f B)        p_II = (D + lam t e) / (A - f B)

    While the node slips, its pressure is linear in v. So the work of each of the two slips is `f
    (v_I - v_II)` times the pressure half-way, and the two works add up to::

        W = f (v_I - v_II) q1 (p_I / (q1 - f p1) + p_II / (q1 + f p1))

    Without coupling and cyclic pressure, `B = p1 = 0`, this is `4 f p0 (lam |q1| - f p0) / A`. In a
    larger uncoupled contact, a node whose neighbours stick dissipates the same work, if A is its
    diagonal entry of the stiffness.

    Parameters
    ----------
    A, B, q0, p0, q1, p1, f
        See `single_node_limit`.
    load_factor
        Factor `lam` of the cyclic load, dimensionless, at least 0 and at most `D / |e|`. Above this
        value the node lifts off at one of the corners. If `|q1| <= f |p1|`, this value is the limit
        itself: such a node never dissipates in full contact.

    Returns
    -------
    float
        Work per cycle, force per depth times length, at least 0; nan if the node lifts off.
    """
    lam = load_factor
    D = A * p0 - B * q0
    e = A * p1 - B * q1
    terms = A * abs(p0) + abs(B * q0)
    travel = 2 * (lam * abs(A * q1 - f**2 * B * p1) - f * D) / (A**2 - (f * B) ** 2)
    if lam * abs(e) - D > ROUNDING * (terms + lam * (abs(A * p1) + abs(B * q1))):
        return float("nan")
    if abs(q1) <= f * abs(p1) or travel <= 0:
        return 0.0
    swing = lam * e if q1 > 0 else -lam * e
    p_I = (D - swing) / (A + f * B)
    p_II = (D + swing) / (A - f * B)
    return f * travel * q1 * (p_I / (q1 - f * p1) + p_II / (q1 + f * p1))


def smallest_circle(points: ArrayLike) -> tuple[Array, float]:
    """Centre and radius of the smallest circle around points (K, 2) of the plane, K > 0.

    The circle passes through two or three of the points. All pairs and triples are tried, so the
    number of points should be small. Points, centre and radius have the same unit.

    Returns
    -------
    tuple of Array and float
        The centre (2,), and the radius.
    """
    array = np.asarray(points, dtype=float)
    middle = array.mean(axis=0)
    size = float(np.abs(array - middle).max())
    if size == 0:
        return array[0], 0.0
    scaled = (array - middle) / size
    enclosing = []
    for centre, radius in _circles(scaled):
        distance = np.hypot(*(scaled - centre).T)
        if distance.max() <= radius + ROUNDING:
            enclosing.append((centre, radius))
    centre, radius = min(enclosing, key=lambda circle: circle[1])
    return middle + size * centre, size * radius


def _circles(points: Array) -> Iterator[tuple[Array, float]]:
    """Centre and radius of the circles through two opposite points, and through three points."""
    for a, b in combinations(points, 2):
        yield (a + b) / 2, float(np.hypot(*(a - b)) / 2)
    for a, b, c in combinations(points, 3):
        matrix = 2 * np.array([b - a, c - a])
        on_a_line = abs(np.linalg.det(matrix)) <= ROUNDING
        if not on_a_line:
            centre = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
            yield centre, float(np.hypot(*(a - centre)))


def smallest_circle_limit(p0: ArrayLike, q1: ArrayLike, f: ArrayLike) -> float:
    """Limit lambda_2 of an uncoupled contact in space (B = 0).

    The cyclic loads change only the shear forces. A residual slip adds the same vector to the shear
    forces of a node at all corners. If A is positive definite, this vector is arbitrary. The node
    is safe if its corners lie within a circle of radius `f p0`, so the weakest node governs::

        lambda = min over nodes of  f p0 / (radius of the smallest circle around the corners' q1)

    Parameters
    ----------
    p0, q1
        Normal forces of the mean load, compression positive, (N,) or one number; (K, N, 2) shear
        forces of the corners at load factor one; force.
    f
        Coefficient of friction, (N,) or one number, positive.

    Returns
    -------
    float
        Dimensionless; inf if the load does not shear the nodes, nan if a node is in tension under
        the mean load.
    """
    shear = np.asarray(q1, dtype=float)
    nodes = shear.shape[1]
    p0, f = np.broadcast_to(p0, nodes), np.broadcast_to(f, nodes)
    if p0.min() < 0:
        return float("nan")
    radii = np.array([smallest_circle(shear[:, node])[1] for node in range(nodes)])
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(radii > 0, f * p0 / radii, np.inf).min())


def masing_dissipation(k: ArrayLike, bound: ArrayLike, X: float) -> float:
    """Work of friction in one cycle of sliders in parallel.

    Their common base moves between `-X` and `+X`. A spring connects each slider to the base. A
    slider sticks until the force of its spring reaches the friction bound, and then slips for the
    rest of the way. It slips to and fro over `2 (X - bound / k)`. As a contact system: `A =
    diag(k)`, `B = 0`, constant pressures `p0 = bound / f`, and `q1 = -k X` as the bonded reaction
    at the corner where the base is at `+X`.

    Parameters
    ----------
    k
        Spring stiffness, (N,), force per depth and length, positive.
    bound
        Friction bound `f p` of each slider, (N,) or one number, force per depth, not negative.
    X
        Amplitude of the base, length, not negative.

    Returns
    -------
    float
        Work per cycle, `sum 4 bound max(0, X - bound / k)`, force per depth times length.

    References
    ----------
    G. Masing (1926), Eigenspannungen und Verfestigung beim Messing, Proceedings of the 2nd
    International Congress of Applied Mechanics, Zürich. W. D. Iwan (1966), A distributed-element
    model for hysteresis and its steady-state dynamic response, Journal of Applied Mechanics 33,
    893-900.
    """
    k, bound = np.asarray(k, dtype=float), np.asarray(bound, dtype=float)
    return float(np.sum(4 * bound * np.maximum(0.0, X - bound / k)))
