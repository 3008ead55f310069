"""A friction increment by convex programs with a frozen friction bound, and the programs to read.

Solvers get the program in units of the mean normal force and of the slip that this force makes.
Newton's method makes their solution exact. Then the answer is put into the program in the units of
the contact. The programs themselves stand at the end of this file: `frozen_bound`, `exact` for
`by_booleans.py`, and `complementarity`, which no method here solves.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution
from numpy.typing import ArrayLike, NDArray

from ...base import RESIDUAL, Array, Attempt, PerNode, warns_of_odd_values
from ...contact import ContactSystem, checked_law, checked_plane, joined, most_shear, parted
from ...contact.diagnosis import in_contact
from ...errors import SolverError
from ...solve.by_cvxpy import solve
from ...solve.problem import Problem, printed_as
from ...solve.solvers import QP, SOCP
from .increment import FrictionIncrement, Increment, Posed


@dataclass(frozen=True)
class ProgramSettings:
    """Numbers of an increment by programs."""

    # Largest number of programs with frozen bound for one increment.
    most_sweeps: int = 100
    # Change of the frozen bound, over the mean normal force, below which more sweeps by the solvers
    # of quadratic programs and of cone programs find nothing new.
    settled_qp: float = 1e6 * RESIDUAL
    settled_socp: float = 1e4 * RESIDUAL
    # Newton steps that make the solution of a program exact. They may correct the status of nodes
    # that a solver left wrong.
    corrections: int = 4


SETTINGS = ProgramSettings()

Statuses: TypeAlias = NDArray[np.int8]

_NO_STATE = (
    "friction increment: no state is found with the friction bound frozen at {bound:.3g} "
    "mean normal forces in sum (if slip raises the pressure enough, another increment may find "
    "the state); {remedy}"
)
_NOT_CONVERGED = (
    "friction increment: did not converge in {sweeps} sweeps with frozen bound; the bound still "
    "changes by {change:.1e} of the mean normal force, most at node {node}, and the residual is "
    "{residual:.1e}; {remedy}, or another increment"
)


class ByProgram(FrictionIncrement):
    """An increment by a program, compiled once."""

    @abstractmethod
    def _listing(self, system: ContactSystem) -> cp.Problem:
        """The program of a contact, in its units."""

    @cached_property
    def problem(self) -> cp.Problem:
        """The program, in the units of the contact."""
        return self._listing(self.system)

    @cached_property
    def _scaled(self) -> cp.Problem:
        """The program that solvers get, of the dimensionless contact."""
        system = self.system
        no_load = {"none": np.zeros(len(self.law.S))}
        dimensionless = ContactSystem(
            self.law.S, system.points, no_load, frames=system.frames, contact=system.contact
        )
        return self._listing(dimensionless)

    @abstractmethod
    def _motions(self) -> Array:
        """(M,) slip steps and gaps in the program that was solved, dimensionless."""

    def _found(self, posed: Posed, kind: str, **parameters: Array) -> Increment:
        """Solve the program by the first solver of a kind that answers, then by Newton's method.

        The caller must check the residual of the result.
        """
        _set_parameters(self._scaled, trial=posed.trial, **parameters)
        attempts = solve(self._scaled, lambda: posed.claim(self._motions()).residual, kind)
        found = posed.claim(self._motions(), SETTINGS.corrections)
        if found.steps:
            attempts += (Attempt("NEWTON", f"{found.steps} steps", found.residual),)
        record = replace(found.record, solver=attempts[-1].solver, attempts=attempts)
        return replace(found, record=record)

    @abstractmethod
    def _answer(self, posed: Posed, found: Increment, guess: Statuses) -> Increment:
        """The increment with the program in the units of the contact, in which the answer stands.

        `guess` are the statuses that a program with booleans expects.
        """


def put_into(
    problem: cp.Problem, found: Increment, variables: Mapping[str, Array], **parameters: Array
) -> Increment:
    """An increment with a problem, in whose variables and parameters its state stands.

    In a convex program the pressures are the multipliers of its gaps.
    """
    _set_parameters(problem, **parameters)
    values = {problem.var_dict[name].id: value for name, value in variables.items()}
    multipliers = {}
    if problem.is_dcp() and not problem.is_mixed_integer():
        multipliers = {problem.constraints[0].id: found.p}
    problem.unpack(Solution(cp.OPTIMAL, None, values, multipliers, {}))
    return replace(found, problem=problem)


def _set_parameters(problem: cp.Problem, **parameters: Array) -> None:
    for name, value in parameters.items():
        problem.param_dict[name].value = value


@warns_of_odd_values
class FrozenBoundIncrement(ByProgram):
    """A friction increment by convex programs with frozen friction bound, compiled once.

    Each sweep solves the program, in the plane by OSQP to three digits. A few steps of Newton's
    method, with the bound free, make the state exact. If the state passes the check of the contact
    law, it is the result. Otherwise the bound is set to `f p` and the program is solved again. When
    sweeps by OSQP change nothing more, Clarabel solves the program to all digits. With strong
    friction and coupling this need not converge. The `problem` of a result has the bound `f p` of
    the answer, which solves it.

    It takes no user constraints: they would act as forces outside the contact law. Theory, eq.
    (11).

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     [[2.0]], [[0.5]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.FrozenBoundIncrement(system, friction=0.5).solve([0.0], load).slip.round(
    ...     6
    ... ).tolist()
    [-0.285714]
    """

    _title = "friction increment, frozen bound"

    def _listing(self, system: ContactSystem) -> cp.Problem:
        return frozen_bound(system)

    def _solved(self, posed: Posed) -> Increment:
        law = posed.law
        n = len(self.friction)
        kind = QP if self.system.tangents == 1 else SOCP
        attempts = list[Attempt]()
        bound = law.bound(posed.trial[-n:])
        for sweep in range(1, SETTINGS.most_sweeps + 1):
            try:
                found = self._found(posed, kind, bound=bound)
            except SolverError as error:
                text = _NO_STATE.format(bound=bound.sum(), remedy=self._remedy)
                raise SolverError(text) from error
            attempts += found.record.attempts
            if found.residual <= RESIDUAL:
                record = replace(found.record, attempts=tuple(attempts))
                return self._answer(posed, replace(found, steps=sweep, record=record), found.status)
            step = law.bound((posed.trial + law.S @ self._motions())[-n:]) - bound
            change = np.abs(step)
            if kind == SOCP and change.max() <= SETTINGS.settled_socp:
                break
            if kind == QP and change.max() <= SETTINGS.settled_qp:
                kind = SOCP
            bound = bound + step
        raise SolverError(
            _NOT_CONVERGED.format(
                sweeps=sweep,
                change=change.max(),
                node=f"{change.argmax()}{in_contact(self.system, change.argmax())}",
                residual=found.residual,
                remedy=self._remedy,
            )
        )

    def _answer(self, posed: Posed, found: Increment, guess: Statuses) -> Increment:
        u = joined(found.slip - posed.slip, found.gap)
        bound = most_shear(self.system, self.friction, found.p.clip(0.0))
        return put_into(self.problem, found, {"u": u}, trial=posed.reactions, bound=bound)

    def _motions(self) -> Array:
        u = self._scaled.var_dict["u"].value
        n = len(self.friction)
        # A solver may leave gaps a little below zero.
        motions: Array = np.concatenate([u[:-n], np.maximum(u[-n:], 0.0)])
        return motions


class ComplementarityProblem(NamedTuple):
    """The complementarity problem of one increment, in the units of the contact.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,).
    problem
        The quadratic program, with z as its variable and c as its parameter.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    >>> fo.increments.complementarity_problem(
    ...     rod, 0.5, [0.0, 0.0], rod.reaction({"pressure": 1.0})
    ... ).matrix.shape
    (6, 6)
    """

    matrix: Array
    constant: Array
    problem: cp.Problem


@warns_of_odd_values
def complementarity_problem(
    system: ContactSystem, friction: PerNode, slip: ArrayLike, bonded: Sequence[ArrayLike]
) -> ComplementarityProblem:
    """Build the complementarity problem of one increment (Klarbring & Bjorkman 1988).

    With the slip step split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z +
    c) = 0` for `z = [s+, s-, w]`. So z satisfies the law if the quadratic program `min z' (M z +
    c), z >= 0, M z + c >= 0` has the value 0 at z. With friction the program is not convex, and a
    local minimum need not be a state of the contact, so cvxpy refuses to solve it. Theory, eq.
    (12).

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

    Returns
    -------
    ComplementarityProblem
        The quadratic program, with the matrix and the constant of the problem.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     [[2.0]], [[0.5]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.complementarity_problem(system, 0.5, [0.0], load).problem.is_dcp()
    False
    """
    checked_law(
        checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"),
        "the complementarity problem",
    )
    owner = FrozenBoundIncrement(system, friction)
    f = owner.friction
    trial = Posed(owner, slip, bonded).reactions
    q, p = parted(trial, 2)
    problem = complementarity(system, f)
    c = problem.param_dict["c"]
    c.value = np.concatenate([f * p + q, f * p - q, p])
    M = next(constant.value for constant in problem.constants() if constant.name() == "M")
    return ComplementarityProblem(M, c.value, problem)


def frozen_bound(system: ContactSystem) -> cp.Problem:
    """The increment with a given friction bound g at each node, in the plane and in space.

    Its optimality conditions are the contact law with g, the `bound`, in place of f p; the
    multipliers of no_overlap are the pressures. Klarbring, Mikelic & Shillor 1988.
    """
    n = system.nodes
    u = cp.Variable(len(system.S), name="u")
    trial = cp.Parameter(len(system.S), name="trial")
    bound = cp.Parameter(n, nonneg=True, name="bound")
    S = cp.Constant(system.S, name="S")

    slip_step = u[:-n]
    gap = u[-n:]
    if system.tangents == 1:
        length = cp.abs(slip_step)
    else:
        steps = cp.reshape(slip_step, (n, 2), order="F")
        length = printed_as(cp.norm(steps, axis=1), f"norm({slip_step})")
    energy = printed_as(cp.quad_form(u, cp.psd_wrap(S)), "u @ S @ u") / 2 + trial @ u
    return Problem(cp.Minimize(energy + bound @ length), [(gap >= 0).set_label("no_overlap")])


def exact(system: ContactSystem, friction: Array) -> cp.Problem:
    """The contact law itself, in the plane, with booleans for the status of each node.

    A node slips along +x (`forward`) or against it (`backward`), is open (`opened`), or sticks.
    The parameters `most_motion` and `most_force` are the largest slip step or gap, and the largest
    pressure, of the states considered. `most_slack`, 2 f most_force, is the largest distance of a
    shear force from its bound. The objective counts booleans: `unexpected` is -1 for a boolean that
    is expected to be 1, else 1.
    """
    n = system.nodes
    slip_step = cp.Variable(n, name="slip_step")
    gap = cp.Variable(n, name="gap")
    q = cp.Variable(n, name="q")
    p = cp.Variable(n, name="p")
    forward = cp.Variable(n, boolean=True, name="forward")
    backward = cp.Variable(n, boolean=True, name="backward")
    opened = cp.Variable(n, boolean=True, name="opened")
    trial = cp.Parameter(2 * n, name="trial")
    unexpected = cp.Parameter((3, n), name="unexpected")
    most_motion = cp.Parameter(n, nonneg=True, name="most_motion")
    most_force = cp.Parameter(n, nonneg=True, name="most_force")
    most_slack = cp.Parameter(n, nonneg=True, name="most_slack")
    A = cp.Constant(system.A, name="A")
    B = cp.Constant(system.B, name="B")
    C = cp.Constant(system.C, name="C")
    f = cp.Constant(friction, name="f")

    bound = cp.multiply(f, p)
    rows = {
        "shear": q == trial[:n] + A @ slip_step + B.T @ gap,
        "pressure": p == trial[n:] + B @ slip_step + C @ gap,
        "one_status": forward + backward + opened <= 1,
        "slips_forward": slip_step <= cp.multiply(most_motion, forward + opened),
        "slips_backward": -slip_step <= cp.multiply(most_motion, backward + opened),
        "no_overlap": gap >= 0,
        "opens": gap <= cp.multiply(most_motion, opened),
        "no_tension": p >= 0,
        "no_force_across_a_gap": p + cp.multiply(most_force, opened) <= most_force,
        "friction_bound": cp.abs(q) <= bound,
        "on_forward_bound": bound + q + cp.multiply(most_slack, forward) <= most_slack,
        "on_backward_bound": bound - q + cp.multiply(most_slack, backward) <= most_slack,
    }
    count = unexpected[0] @ forward + unexpected[1] @ backward + unexpected[2] @ opened
    return Problem(cp.Minimize(count), [row.set_label(name) for name, row in rows.items()])


def complementarity(system: ContactSystem, friction: Array) -> cp.Problem:
    """The quadratic program of the complementarity problem, in the plane.

    It is `min z' (M z + c), z >= 0, M z + c >= 0`. z are the slip steps along +x, those against it,
    and the gaps. `M z + c` are f p + q, f p - q and p.
    """
    n = system.nodes
    A, B, C = system.A, system.B, system.C
    f = friction[:, None]
    rows = [[A + f * B, -(A + f * B), B.T + f * C], [f * B - A, A - f * B, f * C - B.T], [B, -B, C]]
    M = cp.Constant(np.block(rows), name="M")
    z = cp.Variable(3 * n, name="z")
    c = cp.Parameter(3 * n, name="c")
    signs = [(z >= 0).set_label("motions"), (M @ z + c >= 0).set_label("slacks")]
    return Problem(cp.Minimize(z @ (M @ z + c)), signs)
