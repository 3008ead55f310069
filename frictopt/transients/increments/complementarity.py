"""One friction increment as a complementarity problem, and the quadratic program that it is equivalent to.

With the slip increment split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z + c) = 0` for `z = [s+, s-, w]`::

        [   A + f B    -(A + f B)    B' + f C ]            [ f p + q ]
    M = [ -(A - f B)     A - f B    -B' + f C ]        c = [ f p - q ]  of the trial reactions
        [      B            -B           C    ]            [    p    ]

(Klarbring & Bjorkman 1988). A z obeys it exactly where the quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` has the minimum 0. That program
is convex only where the symmetric part of M has no negative eigenvalue: without friction. It is here to be looked at, and to be solved in that case;
a local minimum of a program that is not convex need not be a state of the contact.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import IO

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ...contact import ContactSystem
from ...contact.checks import Array
from ...contact.system import checked_plane
from ...contact.tolerances import ROUNDING
from ...errors import NoContinuation, SolverError
from ...solve.explain import explain
from ...solve.solvers import NoOptimum, solve
from .by_newton import NewtonIncrement
from .increment import Increment, Posed

_NOT_CONVEX = ROUNDING  # negative eigenvalues up to this share of the largest entry are rounding
_TITLE = "friction increment, complementarity"


@dataclass(frozen=True, eq=False)
class ComplementarityProblem:
    """The complementarity problem of one increment, dimensionless.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,).

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
    >>> problem = fo.increments.complementarity_problem(system, 0.0, [0.0, 0.0], load)
    >>> problem.convex, problem.solve().slip.round(6).tolist()
    (True, [-0.833333, -0.666667])
    """

    matrix: Array
    constant: Array
    _posed: Posed = field(repr=False)

    @cached_property
    def least_eigenvalue(self) -> float:
        """Smallest eigenvalue of the symmetric part of M, in units of the stiffness scale; negative: the quadratic program is not convex."""
        return float(np.linalg.eigvalsh((self.matrix + self.matrix.T) / 2)[0])

    @property
    def convex(self) -> bool:
        """Whether the quadratic program is convex, up to rounding."""
        return self.least_eigenvalue >= -_NOT_CONVEX * float(np.abs(self.matrix).max())

    @cached_property
    def problem(self) -> cp.Problem:
        """The quadratic program, with variables forward_slip, backward_slip and gap."""
        M, c, n = self.matrix, self.constant, len(self.constant) // 3
        forward_slip, backward_slip, gap = (cp.Variable(n, name=name) for name in ("forward_slip", "backward_slip", "gap"))
        z = cp.hstack([forward_slip, backward_slip, gap])
        forward_slack, backward_slack, p = M[:n] @ z + c[:n], M[n : 2 * n] @ z + c[n : 2 * n], M[2 * n :] @ z + c[2 * n :]
        rows = {
            "forward_slip_grows": forward_slip >= 0,
            "backward_slip_grows": backward_slip >= 0,
            "no_overlap": gap >= 0,
            "forward_bound": forward_slack >= 0,
            "backward_bound": backward_slack >= 0,
            "no_tension": p >= 0,
        }
        symmetric = (M + M.T) / 2
        work = cp.quad_form(z, cp.psd_wrap(symmetric) if self.convex else symmetric) + c @ z
        return cp.Problem(cp.Minimize(work), [row.set_label(name) for name, row in rows.items()])

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the quadratic program by its names."""
        units = dict.fromkeys(("forward_slip", "backward_slip", "gap"), self._posed.length)
        explain(_TITLE, self.problem, None, units, (), None, file)

    def solve(self) -> Increment:
        """The state after the increment, where the program is convex.

        Raises
        ------
        NoContinuation
            No state obeys the law.
        SolverError
            The program is not convex, or no solver gave an answer that the referee accepts.
        """
        if not self.convex:
            raise SolverError(
                f"complementarity program: not convex, the symmetric part of M has the eigenvalue {self.least_eigenvalue:.3g} (in units of the "
                "stiffness scale), so that a solver's minimum need not be a state of the contact; solve an ExactIncrement or a FrozenBoundIncrement"
            )
        values = self.problem.var_dict
        try:
            found, record = solve(
                self.problem,
                lambda: self._posed.claim(np.r_[values["forward_slip"].value - values["backward_slip"].value, values["gap"].value], self.problem),
            )
        except NoOptimum as error:
            raise NoContinuation(f"complementarity program: no state obeys the law under this load ({error})") from error
        return replace(found, _title=_TITLE, record=replace(found.record, solver=record.solver, attempts=record.attempts))


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
    >>> fo.increments.complementarity_problem(system, 0.5, [0.0, 0.0], load).convex
    False
    """
    owner = NewtonIncrement(checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"), friction)
    posed, n = Posed(owner, slip, bonded), system.nodes
    f, one, none = np.diag(owner.friction), np.eye(n), np.zeros((n, n))
    motion = np.block([[one, -one, none], [none, none, one]])  # u = motion z
    force = np.block([[one, f], [-one, f], [none, one]])  # [f p + q, f p - q, p] = force r
    return ComplementarityProblem(force @ owner.law.S @ motion, force @ posed.trial, posed)
