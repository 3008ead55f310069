"""A friction increment by the cvxpy programs of `listings`: with the friction bound frozen in turn, and one to be looked at.

Solvers get the program of the contact in units of the mean normal force and of the slip that this
force makes. Newton's method makes what they find exact, and the answer is put into the program in
the units of the contact.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import cvxpy as cp
import numpy as np
from cvxpy.reductions.solution import Solution
from numpy.typing import ArrayLike

from ...base import RESIDUAL, Array, Attempt, warns_of_odd_values
from ...contact import ContactSystem, checked_law, checked_plane, joined, most_shear, parted
from ...errors import SolverError
from ...solve.problem import Problem
from ...solve.solvers import QP, SOCP, solve
from .increment import FrictionIncrement, Increment, Posed

_SETTLED = {
    QP: 1e6 * RESIDUAL,
    SOCP: 1e4 * RESIDUAL,
}  # change of the frozen bound up to which more sweeps by these solvers find nothing else
_SWEEPS = 100  # programs for one increment at most
# Newton steps that make the solution of a program exact, and may correct the status of nodes where
# a solver left it wrong
_CORRECTIONS = 4


class ByProgram(FrictionIncrement):
    """An increment by a program, compiled once."""

    @abstractmethod
    def _listing(self, system: ContactSystem) -> cp.Problem: ...

    @cached_property
    def problem(self) -> cp.Problem:
        """The program, in the units of the contact."""
        listed = self._listing(self.system)
        return Problem(listed.objective, listed.constraints)

    @cached_property
    def _scaled(self) -> cp.Problem:
        """The program that solvers get, of the dimensionless contact."""
        system, none = self.system, {"none": np.zeros(len(self.law.S))}
        return self._listing(
            ContactSystem(
                self.law.S, system.points, none, frames=system.frames, contact=system.contact
            )
        )

    @abstractmethod
    def _motions(self) -> Array:
        """The motions that stand in the program that was solved, dimensionless."""

    def _found(self, posed: Posed, kind: str, **parameters: Array) -> Increment:
        """What the first solver of this kind that answers, and Newton's method after it, find."""
        _put(self._scaled, trial=posed.trial, **parameters)
        attempts = solve(self._scaled, lambda: posed.claim(self._motions()).residual, kind)
        found = posed.claim(self._motions(), _CORRECTIONS)
        if found.steps:
            attempts += (Attempt("NEWTON", f"{found.steps} steps", found.residual),)
        return replace(
            found, record=replace(found.record, solver=attempts[-1].solver, attempts=attempts)
        )

    def _answer(
        self, posed: Posed, found: Increment, variables: Mapping[str, Array], **parameters: Array
    ) -> Increment:
        """The increment, put into the program; pressures are multipliers of its gaps where these have some."""
        problem = self.problem
        _put(problem, trial=posed.reactions, **parameters)
        pressures = {} if problem.is_mixed_integer() else {problem.constraints[0].id: found.p}
        values = {problem.var_dict[name].id: value for name, value in variables.items()}
        problem.unpack(Solution(cp.OPTIMAL, None, values, pressures, {}))
        return replace(found, problem=problem)


def _put(problem: cp.Problem, **parameters: Array) -> None:
    for name, value in parameters.items():
        problem.param_dict[name].value = value


@warns_of_odd_values
class FrozenBoundIncrement(ByProgram):
    """A friction increment by convex programs with frozen friction bound, compiled once.

    Each sweep solves the program, in the plane by OSQP to three digits. A few steps of Newton's
    method make the state that it ends with exact, with the bound free; if the referee accepts it,
    it is the answer. Otherwise the bound moves to `f p` and the program is solved again, by
    Clarabel to all digits once sweeps by OSQP change nothing. This need not converge where friction
    and coupling are strong. The `problem` of a result has the bound `f p` of the answer, which
    solves it.

    It takes no constraints of your own: they would act as forces that the contact law does not
    have. Theory, eq. (11).

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
        law, n, attempts, kind = (
            posed.law,
            len(self.friction),
            list[Attempt](),
            QP if self.system.tangents == 1 else SOCP,
        )
        bound = law.bound(posed.trial[-n:])
        for sweep in range(1, _SWEEPS + 1):
            try:
                found = self._found(posed, kind, bound=bound)
            except SolverError as error:
                raise SolverError(
                    f"friction increment: no state of rest is found with the friction bound frozen at {bound.sum():.3g} mean normal forces in sum "
                    f"(where slip would raise the pressure enough to hold it, another increment may find the state); {self._remedy}"
                ) from error
            attempts += found.record.attempts
            if found.residual <= RESIDUAL:
                found = replace(
                    found, steps=sweep, record=replace(found.record, attempts=tuple(attempts))
                )
                u = joined(found.slip - posed.slip, found.gap)
                return self._answer(
                    posed,
                    found,
                    {"u": u},
                    bound=most_shear(self.system, self.friction, found.p.clip(0.0)),
                )
            step = law.bound((posed.trial + law.S @ self._motions())[-n:]) - bound
            if np.abs(step).max() <= _SETTLED[kind]:
                if kind == SOCP:
                    break
                kind = SOCP
            bound = bound + step
        raise SolverError(
            f"friction increment: did not converge in {sweep} sweeps with frozen bound; the bound still changes by {np.abs(step).max():.1e} of the "
            f"mean normal force, most at node {int(np.abs(step).argmax())}, and the residual is {found.residual:.1e}; {self._remedy}, or another "
            "increment"
        )

    def _motions(self) -> Array:
        u, n = self._scaled.var_dict["u"].value, len(self.friction)
        motions: Array = np.concatenate([u[:-n], np.maximum(u[-n:], 0.0)])
        return motions


class ComplementarityProblem(NamedTuple):
    """The complementarity problem of one increment, in the units of the contact.

    Attributes
    ----------
    matrix, constant
        `M` (3N, 3N) and `c` (3N,).
    problem
        The quadratic program, with variables forward_slip, backward_slip and gap, and the reactions
        without these as parameters.

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
    system: ContactSystem, friction: ArrayLike, slip: ArrayLike, bonded: Sequence[ArrayLike]
) -> ComplementarityProblem:
    """Build the complementarity problem of one increment (Klarbring & Bjorkman 1988).

    With the slip step split, `dv = s+ - s-`, the contact law reads `z >= 0, M z + c >= 0, z' (M z +
    c) = 0` for `z = [s+, s-, w]`. A z obeys it where the quadratic program `min z' (M z + c), z >=
    0, M z + c >= 0` has the minimum 0. That is convex only without friction: elsewhere cvxpy
    refuses to solve it, for a local minimum need not be a state of the contact. Theory, eq. (12).

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
    trial, f = Posed(owner, slip, bonded).reactions, owner.friction
    listed, (q, p) = complementarity(system, f), parted(trial, 2)
    problem = Problem(listed.objective, listed.constraints)
    problem.param_dict["trial"].value = trial
    M = next(constant.value for constant in problem.constants() if constant.name() == "M")
    return ComplementarityProblem(M, np.concatenate([f * p + q, f * p - q, p]), problem)


def frozen_bound(system: ContactSystem) -> cp.Problem:
    """The increment with a given friction bound g at each node (Klarbring, Mikelic & Shillor 1988), in the plane and in space.

    Its optimality conditions are the contact law with g, the `bound`, in place of f p; the
    multipliers of no_overlap are the pressures.
    """
    n = system.nodes
    u, trial = cp.Variable(len(system.S), name="u"), cp.Parameter(len(system.S), name="trial")
    bound = cp.Parameter(n, nonneg=True, name="bound")
    S = cp.Constant(system.S, name="S")

    slip_step, gap = u[:-n], u[-n:]
    length = (
        cp.abs(slip_step)
        if system.tangents == 1
        else cp.norm(cp.reshape(slip_step, (n, 2), order="F"), axis=1)
    )
    energy = cp.quad_form(u, cp.psd_wrap(S)) / 2 + trial @ u
    return cp.Problem(cp.Minimize(energy + bound @ length), [(gap >= 0).set_label("no_overlap")])


def exact(system: ContactSystem, friction: Array) -> cp.Problem:
    """The contact law itself, in the plane: each node sticks, slips along or against +x, or is open, with a boolean for each but sticking.

    `most_motion` and `most_force` are the largest slip step or gap, and pressure, that are looked
    for; `most_slack`, 2 f most_force, is the largest distance of a shear force from its bound. The
    objective counts booleans: `unexpected` is -1 for those that are expected to be 1, else 1.
    """
    n = system.nodes
    slip_step, gap, q, p = (cp.Variable(n, name=name) for name in ("slip_step", "gap", "q", "p"))
    forward, backward, opened = (
        cp.Variable(n, boolean=True, name=name) for name in ("forward", "backward", "opened")
    )
    trial, unexpected = cp.Parameter(2 * n, name="trial"), cp.Parameter((3, n), name="unexpected")
    most_motion, most_force, most_slack = (
        cp.Parameter(n, nonneg=True, name=name)
        for name in ("most_motion", "most_force", "most_slack")
    )
    A, B, C, f = (
        cp.Constant(value, name=name)
        for name, value in (("A", system.A), ("B", system.B), ("C", system.C), ("f", friction))
    )

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
        "friction_bound": cp.abs(q) <= cp.multiply(f, p),
        "on_forward_bound": cp.multiply(f, p) + q + cp.multiply(most_slack, forward) <= most_slack,
        "on_backward_bound": cp.multiply(f, p) - q + cp.multiply(most_slack, backward)
        <= most_slack,
    }
    count = cp.sum(cp.multiply(unexpected, cp.vstack([forward, backward, opened])))
    return cp.Problem(cp.Minimize(count), [row.set_label(name) for name, row in rows.items()])


def complementarity(system: ContactSystem, friction: Array) -> cp.Problem:
    """The quadratic program `min z' (M z + c), z >= 0, M z + c >= 0` of the complementarity problem, in the plane.

    The slip step is `forward_slip - backward_slip`, and `M z + c` are f p + q, f p - q and p.
    """
    A, B, C, f = system.A, system.B, system.C, friction[:, None]
    rows = [[A + f * B, -(A + f * B), B.T + f * C], [f * B - A, A - f * B, f * C - B.T], [B, -B, C]]
    matrix, n = np.block(rows), system.nodes
    M, symmetric = (
        cp.Constant(matrix, name="M"),
        cp.Constant((matrix + matrix.T) / 2, name="(M + M.T) / 2"),
    )
    trial = cp.Parameter(2 * n, name="trial")

    q, p, coefficient = trial[:n], trial[n:], cp.Constant(friction, name="f")
    c = cp.hstack([cp.multiply(coefficient, p) + q, cp.multiply(coefficient, p) - q, p])
    z = cp.hstack([cp.Variable(n, name=name) for name in ("forward_slip", "backward_slip", "gap")])
    signs = [(z >= 0).set_label("motions"), (M @ z + c >= 0).set_label("slacks")]
    return cp.Problem(cp.Minimize(cp.quad_form(z, symmetric) + c @ z), signs)
