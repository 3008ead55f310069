"""The contact of two nodes: the smallest system whose fate depends on where it starts."""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array
from ..contact.tolerances import CONDENSATION, ROUNDING
from ..errors import ModelError
from ._shared import least_ratio, per_node


@dataclass(frozen=True)
class TwoNodeLimits:
    """Load factors that bound the dependence on the start, dimensionless, `lambda_1 <= lambda_2`.

    Attributes
    ----------
    lambda_1
        Guaranteed limit: below it the contact shakes down from every start.
    lambda_2
        Shakedown limit: above it the contact shakes down from no start.

    Examples
    --------
    >>> from frictopt.reference import TwoNodeLimits
    >>> TwoNodeLimits(lambda_1=0.5, lambda_2=0.75)
    TwoNodeLimits(lambda_1=0.5, lambda_2=0.75)
    """

    lambda_1: float
    lambda_2: float


class _Meeting(NamedTuple):
    """Apex of one node against a line of the other: the apex is on the safe side of the line iff `lam * demand <= strength`."""

    strength: float
    demand: float
    terms: float  # size of the terms that cancel in `strength`


def two_node_limits(A: ArrayLike, B: ArrayLike, q0: ArrayLike, p0: ArrayLike, q1: ArrayLike, p1: ArrayLike, f: ArrayLike) -> TwoNodeLimits:
    """Limits lambda_1 and lambda_2 of two coupled nodes in full contact.

    In the plane of the slips `v = (v_1, v_2)` each node has two lines, `-(A + f B)_i v = (q0 + f p0)_i - lam |q1 + f p1|_i` (forward slip) and
    `(A - f B)_i v = (f p0 - q0)_i - lam |q1 - f p1|_i` (backward slip). The safe slips lie between the two lines of both nodes. As the load grows the
    lines close in, and three of the four meet in a point where a 3 x 3 determinant linear in `lam` vanishes. The two lines of a node cross in
    its apex; below the critical friction one line of the other node faces the apex and the other one lies behind it:

    * the apex of a node reaches the line facing it: no slip is safe any more, and lambda_2 is the first such load factor;
    * the apex of a node that slips both ways, `|q1| > f |p1|`, lies between the lines of the other node: it is a corner of the safe
      region, starts near it keep slipping to and fro, and lambda_1 is the first load factor at which this is so. It is 0 if the apex is a corner from
      the outset, that is, if slip of one node can unload the other.

    Both hold for full contact (no gap opens). lambda_2 also covers a node that lifts off rather than slips, because its pressure would have to
    be negative; lambda_1 leaves such a node out, which dissipates nothing, and is never above lambda_2.

    Parameters
    ----------
    A
        Tangential forces per slip (v along +x), (2, 2), symmetric positive definite, force per depth and length.
    B
        Normal forces per slip, (2, 2), not symmetric in general, force per depth and length.
    q0, p0
        Bonded reactions of the mean load, tangential (along +x) and normal (compression positive), (2,) or one number, force per depth.
    q1, p1
        Bonded reactions of the corner `s = +1` at load factor one, (2,) or one number, force per depth.
    f
        Coefficient of friction, (2,) or one number, dimensionless, positive and below the critical one: all `A_ii +- f_i B_ii` and all
        determinants of `A + diag(+-f_1, +-f_2) B` positive.

    Returns
    -------
    TwoNodeLimits
        Both inf if no load factor is too large, both nan if no slip is safe even without the cyclic load.

    Raises
    ------
    ModelError
        Values that are not real and finite, shapes that do not match, A not symmetric positive definite, friction not positive or too large.

    References
    ----------
    Y. J. Ahn, E. Bertocchi and J. R. Barber (2008), Shakedown of coupled two-dimensional discrete frictional systems, Journal of the Mechanics
    and Physics of Solids 56, 3433-3440: three of the four lines meet. G. Björkman and A. Klarbring (1987), shakedown and residual stresses in
    frictional systems: lambda_2 as a linear program, of which this is the solution by hand.

    Examples
    --------
    >>> from frictopt.reference import two_node_limits
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> limits = two_node_limits(A, B, q0=0.0, p0=1.0, q1=0.8, p1=[0.4, 0.1], f=0.6)
    >>> round(limits.lambda_1, 4), round(limits.lambda_2, 4)
    (0.3919, 0.7261)
    """
    A, B = _stiffness(A), finite_array("B", B, (2, 2))
    q0, p0, q1, p1, f = per_node(2, q0=q0, p0=p0, q1=q1, p1=p1, f=f)
    # Line 0 bounds forward slip, line 1 backward slip; safe is `normal . v <= strength - lam * demand`. Axes: line, node (, component of v).
    normal = np.stack([-A - f[:, None] * B, A - f[:, None] * B])
    _require_below_critical_friction(normal, f)
    strength = np.stack([q0 + f * p0, f * p0 - q0])
    demand = np.stack([np.abs(q1 + f * p1), np.abs(q1 - f * p1)])

    meetings = [_facing_and_behind(normal, strength, demand, node) for node in (0, 1)]
    lambda_2 = least_ratio(*np.array([facing for facing, _ in meetings]).T)
    slips_both_ways = np.abs(q1) > f * np.abs(p1)
    corners = [_first_corner(behind) for (_, behind), both_ways in zip(meetings, slips_both_ways, strict=True) if both_ways]
    return TwoNodeLimits(lambda_2 if np.isnan(lambda_2) else min([lambda_2, *corners]), lambda_2)


def _facing_and_behind(normal: Array, strength: Array, demand: Array, node: int) -> tuple[_Meeting, _Meeting]:
    """Meetings of the apex of `node` with the line of the other node that faces it and with the one that lies behind it."""
    other = 1 - node
    forward_normal, backward_normal = normal[:, node]
    meetings = []
    for line in (0, 1):
        third = normal[line, other]
        # Weights with which the three normals add up to zero: the minors of the determinant. Those of the apex's own lines are made
        # positive; all three then have one sign, and no slip is safe behind the meeting, iff the third line faces the apex.
        weights = np.array([_det(backward_normal, third), _det(third, forward_normal), _det(forward_normal, backward_normal)])
        weights *= np.sign(weights[0])
        resisting = weights * [*strength[:, node], strength[line, other]]
        closing = float(weights @ [*demand[:, node], demand[line, other]])
        meetings.append((weights[2], _Meeting(float(resisting.sum()), closing, float(np.abs(resisting).sum()))))
    (_, behind), (_, facing) = sorted(meetings, key=lambda weighted: weighted[0])
    return facing, _Meeting(-behind.strength, -behind.demand, behind.terms)


def _first_corner(behind: _Meeting) -> float:
    """Least load factor at which the apex lies before the line behind it, inf if there is none; up to lambda_2 it lies before the facing one."""
    if behind.demand < 0:
        return max(0.0, behind.strength / behind.demand)
    return 0.0 if behind.strength > ROUNDING * behind.terms else float("inf")


def _stiffness(A: ArrayLike) -> Array:
    matrix = finite_array("A", A, (2, 2))
    if abs(matrix[0, 1] - matrix[1, 0]) > 10 * CONDENSATION * np.abs(matrix).max():
        raise ModelError(f"A: {matrix.tolist()} is not symmetric; give the condensed stiffness of the relative tangential motion")
    if matrix[0, 0] <= 0 or _det(*matrix) <= 0:
        raise ModelError(f"A: {matrix.tolist()} is not positive definite; hold both bodies against rigid motion")
    return matrix


def _require_below_critical_friction(normal: Array, f: Array) -> None:
    signs = np.array([-1.0, 1.0])
    diagonal = signs[:, None] * normal[:, [0, 1], [0, 1]]
    mixed = [signs[i] * signs[j] * _det(normal[i, 0], normal[j, 1]) for i, j in product((0, 1), repeat=2)]
    if diagonal.min() <= 0 or min(mixed) <= 0:
        raise ModelError(f"f: {f.tolist()} is not below the critical friction of A and B; give less friction or weaker coupling")


def _det(first: Array, second: Array) -> float:
    return float(first[0] * second[1] - first[1] * second[0])
