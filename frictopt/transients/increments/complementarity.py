"""One friction increment as a complementarity problem, and the quadratic program that it is equivalent to.

With the slip increment split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z + c) = 0` for `z = [s+, s-, w]`::

        [   A + f B    -(A + f B)    B' + f C ]            [ f p + q ]
    M = [ -(A - f B)     A - f B    -B' + f C ]        c = [ f p - q ]  of the trial reactions
        [      B            -B           C    ]            [    p    ]

(Klarbring & Bjorkman 1988). A z obeys it exactly where the quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` has the minimum 0. That program
is convex only where the symmetric part of M has no negative eigenvalue: without friction. It is here to be looked at: cvxpy refuses to solve it
elsewhere, where a local minimum need not be a state of the contact.
"""

from collections.abc import Sequence
from typing import NamedTuple

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, ContactSystem, checked_plane
from .by_newton import NewtonIncrement
from .increment import Posed


class ComplementarityProblem(NamedTuple):
    """The complementarity problem of one increment, dimensionless.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,).
    problem
        The quadratic program, with variables forward_slip, backward_slip and gap.
    length
        Unit of its slips and gaps.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    >>> load = rod.reaction({"pressure": 1.0, "force": 1.0})
    >>> problem = fo.increments.complementarity_problem(rod, 0.5, [0.0, 0.0], load)
    >>> problem.matrix.shape, problem.problem.is_dcp()
    ((6, 6), False)
    """

    matrix: Array
    constant: Array
    problem: cp.Problem
    length: float


def complementarity_problem(system: ContactSystem, friction: ArrayLike, slip: ArrayLike, bonded: Sequence[ArrayLike]) -> ComplementarityProblem:
    """Build the complementarity problem of one increment.

    Theory, eq. (12).

    Parameters
    ----------
    system
        The contact, in the plane.
    friction
        Coefficient of friction, one or one per node.
    slip
        (N,) slip before the increment, length.
    bonded
        `(q^w, p^w)`, (N,) bonded reactions of the load after it, force per depth.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.complementarity_problem(system, 0.5, [0.0, 0.0], load).problem.is_dcp()
    False
    """
    owner = NewtonIncrement(checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"), friction)
    posed, n = Posed(owner, slip, bonded), system.nodes
    f, one, none = np.diag(owner.friction), np.eye(n), np.zeros((n, n))
    motion = np.block([[one, -one, none], [none, none, one]])  # u = motion z
    force = np.block([[one, f], [-one, f], [none, one]])  # [f p + q, f p - q, p] = force r
    M, c = force @ owner.law.S @ motion, force @ posed.trial
    split = {name: cp.Variable(n, name=name) for name in ("forward_slip", "backward_slip", "gap")}
    z = cp.hstack(list(split.values()))
    slack = dict(zip(("forward_bound", "backward_bound", "no_tension"), (M @ z + c).reshape((3, n), order="C"), strict=True))
    rows = [(part >= 0).set_label(name) for name, part in {**split, **slack}.items()]
    return ComplementarityProblem(M, c, cp.Problem(cp.Minimize(cp.quad_form(z, (M + M.T) / 2) + c @ z), rows), posed.length)
