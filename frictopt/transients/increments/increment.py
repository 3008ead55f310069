"""One friction increment: the problem as posed, in dimensionless units, and the result that every engine returns."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ...contact import ContactSystem, friction_coefficients, referee
from ...contact.checks import Array, finite_array, frozen
from ...contact.record import Attempt, Recorded, SolveRecord
from ...contact.show import frame
from ...contact.system import checked_plane
from ...contact.tolerances import NO_FORCE, STUCK
from ...errors import ModelError
from ...solve.explain import explain
from .newton import State, classified, sticking

__all__ = ["Increment", "Law", "PosedIncrement"]


@dataclass(frozen=True, eq=False, repr=False)
class Increment(Recorded):
    """The state after one increment of load, judged by the referee.

    Attributes
    ----------
    slip
        (N,) slip v along +x, length. Nodes that stick keep their slip bit for bit.
    gap
        (N,) total gap w (initial gap included), length, >= 0.
    q, p
        (N,) reactions, tangential (along +x) and normal (compression positive), force per depth.
    status
        (N,) status by the reactions, within 1e-9 of the mean normal force: 2 open (no pressure), +1 and -1 on the friction bound that opposes slip
        along +x (q = -f p) and along -x (q = +f p), 0 inside both bounds.
    sweeps
        Number of convex programs with frozen friction bound that were solved.
    record
        How it was found. Its `residual` is the referee's, with the slip before the increment as the previous one. At most 1e-9.
    problem
        The solved cvxpy problem; None for a closed form. A later solve by the same engine overwrites its values.

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
    >>> state = fo.ExactIncrement(system, friction=0.5).solve([0.0, 0.0], load)
    >>> state.to_frame()[["node", "slip", "q", "p", "status"]].round(6)
       node      slip         q         p  status
    0     0 -0.326531  0.469388  0.938776      -1
    1     1 -0.122449  0.581633  1.163265      -1
    """

    slip: Array
    gap: Array
    q: Array
    p: Array
    status: np.ndarray[Any, np.dtype[np.int8]]
    sweeps: int
    record: SolveRecord
    problem: cp.Problem | None = field(repr=False)
    _title: str = field(repr=False)
    _units: dict[str, float] = field(repr=False)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, slip, gap, q, p and status."""
        return frame({"node": range(len(self.slip)), **{name: getattr(self, name) for name in ("slip", "gap", "q", "p", "status")}})

    def _answer(self) -> Mapping[str, Any]:
        counts = {name: int((np.abs(self.status) == value).sum()) for name, value in (("at_bound", 1), ("open", 2))}
        return {"nodes": len(self.slip), **counts, "residual": self.residual, "solver": self.record.solver}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain(self._title, self.problem, None, self._units, self.record.left_out, None, file)


class Law:
    """Stiffness and friction of a contact, the stiffness in units of its scale.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Not a ContactSystem, or bad friction.
    """

    def __init__(self, system: ContactSystem, friction: Any) -> None:
        self.system = checked_plane(system)
        self.friction = friction_coefficients(friction, system.nodes)
        self.S = frozen(system.S / system.stiffness_scale)

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return self.system.nodes

    @property
    def no_bound(self) -> Array:
        """(N,) friction bound besides f p: none."""
        return np.zeros(self.nodes)

    def pose(self, slip: Any, bonded: Any) -> "PosedIncrement":
        """The increment from a slip to a load, given by its bonded reactions.

        Raises
        ------
        ModelError
            Arrays that are not finite, not real or not of length N.
        """
        try:
            q, p = bonded
        except (TypeError, ValueError) as error:
            raise ModelError(f"bonded: not a pair; give (q, p), two arrays of length {self.nodes}") from error
        slip = finite_array("slip", slip, (self.nodes,))
        return PosedIncrement(self, slip, finite_array("bonded q", q, (self.nodes,)), finite_array("bonded p", p, (self.nodes,)))


@dataclass(frozen=True, eq=False)
class PosedIncrement:
    """One increment in units of the mean normal force and of the slip that this force makes.

    The unknowns are `u = [dv, w]`, slip since `slip` and total gap; the reactions `[q, p] = trial + S u`.

    Attributes
    ----------
    law
        Stiffness and friction.
    slip
        (N,) slip before the increment, length.
    bonded_q, bonded_p
        (N,) bonded reactions of the load after it, force per depth.
    started
        When it was posed, for the record.
    """

    law: Law
    slip: Array
    bonded_q: Array
    bonded_p: Array
    started: float = field(default_factory=perf_counter)

    @cached_property
    def reactions(self) -> Array:
        """(2N,) reactions with no further slip and all gaps pressed shut, force per depth."""
        system = self.law.system
        return np.asarray(np.r_[self.bonded_q, self.bonded_p] + system.S @ np.r_[self.slip, -system.gap])

    @cached_property
    def force(self) -> float:
        """Unit of force per depth: mean of |p^w|, as the referee's, or of the trial reactions where that is nothing."""
        force = float(np.abs(self.bonded_p).mean())
        return force if force > NO_FORCE * np.abs(self.reactions).max() else float(np.abs(self.reactions).mean()) or 1.0

    @property
    def length(self) -> float:
        """Unit of slip."""
        return self.force / self.law.system.stiffness_scale

    @cached_property
    def trial(self) -> Array:
        """(2N,) dimensionless trial reactions."""
        return frozen(self.reactions / self.force)

    @property
    def stuck(self) -> bool:
        """Whether the trial state obeys the law: nothing slips, nothing opens."""
        q, p = np.split(self.trial, 2)
        return bool(p.min() >= -STUCK and (np.abs(q) <= self.law.friction * p + STUCK).all())

    @property
    def worst_node(self) -> int:
        """Node at which the trial state violates the law most."""
        q, p = np.split(self.trial, 2)
        return int(np.argmax(np.maximum(np.abs(q) - self.law.friction * p, -p)))

    def residual(self, state: State) -> float:
        """Residual of a state, by the referee."""
        return self._judged(*self._dimensional(state))

    def result(
        self, title: str, state: State, sweeps: int, solver: str, attempts: tuple[Attempt, ...], left_out: tuple[str, ...], problem: cp.Problem | None
    ) -> Increment:
        """The state in the caller's units, with its residual."""
        values = self._dimensional(state)
        slip, gap, q, p = (frozen(value) for value in values)
        status = classified(self.law.friction, state)
        status.flags.writeable = False
        units = dict.fromkeys(("slip_increment", "gap", "forward_slip", "backward_slip"), self.length)
        record = SolveRecord(solver, attempts, self._judged(*values), left_out, perf_counter() - self.started)
        return Increment(slip, gap, q, p, status, sweeps, record, problem, title, units)

    def _dimensional(self, state: State) -> tuple[Array, Array, Array, Array]:
        dv, w = np.split(state.u, 2)
        q, p = np.split(self.force * state.r, 2)
        return np.where(dv != 0, self.slip + self.length * dv, self.slip), self.length * np.maximum(w, 0.0), q, p

    def _judged(self, slip: Array, gap: Array, q: Array, p: Array) -> float:
        system, bonded = self.law.system, (self.bonded_q, self.bonded_p)
        verdict = referee(system, bonded, self.law.friction, v=slip, w=gap, q=q, p=p, previous_slip=self.slip, force_scale=self.force)
        return verdict.residual

    def closed_form(self, title: str) -> Increment:
        """The increment in which nothing moves."""
        why = "optimisation problem: the trial state obeys the law, nothing slips and nothing opens"
        still = State(sticking(self.law.nodes), np.zeros(2 * self.law.nodes), self.trial)
        return self.result(title, still, 0, "closed form", (), (why,), None)
