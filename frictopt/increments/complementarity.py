"""One friction increment as a complementarity problem, and the quadratic program that it is equivalent to.

With the slip increment split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z + c) = 0` for `z = [s+, s-, w]`::

        [   A + f B    -(A + f B)    B' + f C ]            [ f p + q ]
    M = [ -(A - f B)     A - f B    -B' + f C ]        c = [ f p - q ]  of the trial reactions
        [      B            -B           C    ]            [    p    ]

(Klarbring & Bjorkman 1988). A z obeys it exactly where the quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` has the minimum 0. That program
is convex only where the symmetric part of M has no negative eigenvalue: without friction, or for an uncoupled contact whose gaps are no unknowns. It
is here to be looked at, and to be solved in those cases; a local minimum of a program that is not convex need not be a state of the contact.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem
from ..contact.checks import Array, flag
from ..errors import NoContinuation, SolverError
from ..solve.explain import explain
from ..solve.solvers import Kind, NoOptimum, solve
from .increment import Increment, Law, PosedIncrement
from .newton import Status, guessed
from .status_search import StatusSearch

__all__ = ["ComplementarityProblem", "complementarity_problem"]

_TITLE = "friction increment, complementarity"
_ROUNDING = 1e-12  # negative eigenvalues up to this share of the largest entry of M are rounding


@dataclass(frozen=True, eq=False)
class ComplementarityProblem:
    """The complementarity problem of one increment, dimensionless.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,), or (2N, 2N) and (2N,) where gaps are no unknowns.
    problem
        Its quadratic program, with variables forward_slip, backward_slip and gap.
    separation
        Whether gaps are unknowns.
    """

    matrix: Array
    constant: Array
    problem: cp.Problem = field(repr=False)
    separation: bool
    _posed: PosedIncrement = field(repr=False)

    @cached_property
    def least_eigenvalue(self) -> float:
        """Smallest eigenvalue of the symmetric part of M, in units of the stiffness scale; negative: the quadratic program is not convex."""
        return float(np.linalg.eigvalsh((self.matrix + self.matrix.T) / 2)[0])

    @property
    def convex(self) -> bool:
        """Whether the quadratic program is convex, up to rounding."""
        return _is_convex(self.matrix, self.least_eigenvalue)

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the quadratic program by its names."""
        units = dict.fromkeys(("forward_slip", "backward_slip", "gap"), self._posed.length)
        explain(_TITLE, self.problem, None, units, self._left_out, pd.DataFrame(), file)

    def solve(self, solver: str | None = None) -> Increment:
        """The state after the increment, where the program is convex.

        Parameters
        ----------
        solver
            One of "CLARABEL", "HIGHS_QP"; by default each in this order until an answer passes.

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
        model = StatusSearch(self.problem, self._posed, self._read_status, self.separation)
        try:
            answer = solve(model, model.claim, solver, kind=Kind.QP)
        except NoOptimum as error:
            closed = "" if self.separation else " with every gap closed"
            raise NoContinuation(f"complementarity program: no state obeys the law under this load{closed} ({error})") from error
        return self._posed.result(_TITLE, answer.claim.state, 0, answer.solver, answer.attempts, self._left_out, self.problem)

    def _read_status(self) -> Status:
        law, none = self._posed.law, np.zeros(self._posed.law.nodes)
        value = {name: np.asarray(variable.value) for name, variable in self.problem.var_dict.items()}
        u = np.r_[value["forward_slip"] - value["backward_slip"], value.get("gap", none)]
        return guessed(law.friction, none, u, self._posed.trial + law.S @ u, self.separation)

    @property
    def _left_out(self) -> tuple[str, ...]:
        return () if self.separation else ("gaps: no unknowns of the program, by request",)


def complementarity_problem(system: ContactSystem, friction: Any, slip: Any, bonded: Any, *, separation: bool = True) -> ComplementarityProblem:
    """Build the complementarity problem of one increment.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    slip
        (N,) slip before the increment, length.
    bonded
        `(q^w, p^w)`, (N,) bonded reactions of the load after it, force per depth.
    separation
        Whether gaps are unknowns; False keeps every node closed (the referee then says whether it is).

    Raises
    ------
    ModelError
        Bad input.
    """
    law = Law(system, friction)
    posed = law.pose(slip, bonded)
    n, f = law.nodes, np.diag(law.friction)
    one, none = np.eye(n), np.zeros((n, n))
    motion = np.block([[one, -one, none], [none, none, one]])  # u = motion z
    force = np.block([[one, f], [-one, f], [none, one]])  # [f p + q, f p - q, p] = force r
    kept = (3 if flag("separation", separation) else 2) * n
    matrix, constant = (force @ law.S @ motion)[:kept, :kept], (force @ posed.trial)[:kept]
    return ComplementarityProblem(matrix, constant, _program(matrix, constant, n), separation, posed)


def _program(matrix: Array, constant: Array, nodes: int) -> cp.Problem:
    names = ("forward_slip", "backward_slip", "gap")[: len(matrix) // nodes]
    labels = ("forward_bound", "backward_bound", "no_tension")
    parts = [cp.Variable(nodes, name=name) for name in names]
    z = cp.hstack(parts)
    symmetric = (matrix + matrix.T) / 2
    if _is_convex(matrix, float(np.linalg.eigvalsh(symmetric)[0])):
        symmetric = cp.psd_wrap(symmetric)
    rows = [(part >= 0).set_label(f"{name}_grows") for part, name in zip(parts, names, strict=True)]
    for k, label in enumerate(labels[: len(parts)]):
        own = slice(k * nodes, (k + 1) * nodes)
        rows.append((matrix[own] @ z + constant[own] >= 0).set_label(label))
    return cp.Problem(cp.Minimize(cp.quad_form(z, symmetric) + constant @ z), rows)


def _is_convex(matrix: Array, least_eigenvalue: float) -> bool:
    return least_eigenvalue >= -_ROUNDING * float(np.abs(matrix).max())
