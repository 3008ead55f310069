"""Contacts in which one node does not feel another: limits of uncoupled and proportionally coupled systems."""

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError
from ._checks import per_node
from ._numerics import least_ratio


def uncoupled_limit(q0: ArrayLike, p0: ArrayLike, q1: ArrayLike, p1: ArrayLike, f: ArrayLike, *, d: ArrayLike = 0.0) -> float:
    """Limit lambda_1 = lambda_2 of an uncoupled contact, `B = 0`, or of a proportionally coupled one, `B = D A` with `D = diag(d)`.

    With `B = D A` slip enters the law of node i only through its own `t_i = (A v)_i`, as `q += t` and `p += d t`, and `A v = t` has a solution
    for every `t` when A is positive definite. The nodes are then as many single nodes of stiffness 1 and coupling `d`, and the weakest rules::

        lambda = min over nodes of  f (p0 - d q0) / max(|q1 - f^2 d p1|, f |p1 - d q1|)

    which for `d = 0` is `f p0 / max(|q1|, f |p1|)`, whatever A and q0. The second entry of the maximum rules where the node lifts off rather
    than slips. In full contact `lambda_1 = lambda_2`: a node slips forward only with `t_i` at its lower bound and backward only at its upper one,
    safe slips lie between the two, so slip never increases the distance from a safe slip in the norm of A.

    Parameters
    ----------
    q0, p0
        Bonded reactions of the mean load, tangential (along +x) and normal (compression positive), (N,) or one number, force per depth.
    q1, p1
        Bonded reactions of the corner `s = +1` at load factor one, (N,) or one number, force per depth.
    f
        Coefficient of friction, (N,) or one number, dimensionless, positive.
    d
        Diagonal of D, (N,) or one number, dimensionless, `f |d| < 1`.

    Returns
    -------
    float
        Dimensionless; inf if the load does not touch the nodes, nan if no slip is safe even without the cyclic load.

    Raises
    ------
    ModelError
        Values that are not real and finite, lengths that do not match, friction not positive, or friction of `1 / |d|` or more.

    References
    ----------
    A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic contact problems with Coulomb friction, International Journal of
    Solids and Structures 44, 8355-8365: which contacts shake down from every start.

    Examples
    --------
    >>> from frictopt.reference import uncoupled_limit
    >>> uncoupled_limit(q0=0.3, p0=[1.0, 2.0], q1=[1.0, 1.0], p1=0.0, f=0.5)
    0.5
    """
    q0, p0, q1, p1, f, d = per_node(q0=q0, p0=p0, q1=q1, p1=p1, f=f, d=d)
    if (f * np.abs(d) >= 1).any():
        node = int(np.argmax(f * np.abs(d)))
        raise ModelError(f"f: {f[node]:g} at node {node} is not below the critical friction 1/|d| = {1 / abs(d[node]):g}; give less of either")
    return least_ratio(
        strength=f * (p0 - d * q0),
        demand=np.maximum(np.abs(q1 - f**2 * d * p1), f * np.abs(p1 - d * q1)),
        terms=f * (np.abs(p0) + np.abs(d * q0)),
    )
