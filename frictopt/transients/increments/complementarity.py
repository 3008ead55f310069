"""One friction increment as a complementarity problem, and the quadratic program that it is equivalent to.

With the slip step split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z + c) = 0` for `z = [s+, s-, w]`, where `M z + c` are
f p + q, f p - q and p (Klarbring & Bjorkman 1988). A z obeys it exactly where the quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` has the
minimum 0. That program is convex only where the symmetric part of M has no negative eigenvalue: without friction. It is here to be looked at: cvxpy
refuses to solve it elsewhere, where a local minimum need not be a state of the contact.
"""

from collections.abc import Sequence
from typing import NamedTuple

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, ContactSystem, checked_plane, parted
from ...solve.problem import Problem
from .by_newton import NewtonIncrement
from .increment import Posed
from .listings import complementarity


class ComplementarityProblem(NamedTuple):
    """The complementarity problem of one increment, in the units of the contact.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,).
    problem
        The quadratic program, with variables forward_slip, backward_slip and gap, and the reactions without these as parameters.

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
    >>> system = fo.ContactSystem.from_blocks([[2.0]], [[0.5]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.complementarity_problem(system, 0.5, [0.0], load).problem.is_dcp()
    False
    """
    owner = NewtonIncrement(checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"), friction)
    trial, f = Posed(owner, slip, bonded).reactions, owner.friction
    listed, (q, p) = complementarity(system, f), parted(trial, 2)
    problem = Problem(listed.objective, listed.constraints)
    problem.param_dict["trial"].value = trial
    M = next(constant.value for constant in problem.constants() if constant.name() == "M")
    return ComplementarityProblem(M, np.concatenate([f * p + q, f * p - q, p]), problem)
