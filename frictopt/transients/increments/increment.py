"""A friction increment: the problem in dimensionless units, and its result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base import RESIDUAL, Array, SolveRecord, Table, components, finite_array, frame, worst
from ...contact import joined, off_law, parted
from ...contact.given_parts import checked_pair
from ...solve.explained import Explained
from ..transient import OPEN
from .newton import State

# A mean normal force below this share of the largest reaction is no scale of forces, because the
# errors of the reactions may be as large.
_NO_FORCE = RESIDUAL


@dataclass(frozen=True, eq=False, repr=False)
class Increment(Explained):
    """State after one increment of load, checked against the contact law.

    Attributes
    ----------
    slip
        Slip v, (N,) along +x in the plane, (N, 2) along the tangents in space, length. The slip of
        a node that sticks stays the same bit for bit.
    gap
        (N,) total gap w (initial gap included), length, >= 0.
    q, p
        Shear forces, in the shape of `slip`, and (N,) normal forces, compression positive: force
        per depth in the plane, force in space.
    status
        (N,) 0: stick; 2: open; 1: slip, in the plane along +x; -1 (only in the plane): slip against
        +x.
    steps
        Number of Newton steps.
    record
        How the state was found. Its `residual`, at most 1e-9, is the largest violation of the
        contact law by the forces and by the slip since the previous state.
    problem
        The cvxpy problem of the `form` of the call, in the units of the contact, with the answer as
        its values; None without a form.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     [[2.0]], [[0.5]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> state = fo.increments.NewtonIncrement(system, friction=0.5).solve([0.0], load)
    >>> state.to_frame()[["node", "slip", "q", "p", "status"]].round(6)
       node      slip         q         p  status
    0     0 -0.285714  0.428571  0.857143      -1
    """

    slip: Array
    gap: Array
    q: Array
    p: Array
    status: NDArray[np.int8]
    steps: int
    record: SolveRecord
    problem: Any = field(default=None, repr=False)
    _title: str = field(default="friction increment", repr=False)

    def to_frame(self) -> Table:
        """A row for each node: node, slip, gap, q, p, status; in space slip1, slip2, q1, q2."""
        columns = {
            **components("slip", self.slip),
            "gap": self.gap,
            **components("q", self.q),
            "p": self.p,
            "status": self.status,
        }
        return frame({"node": range(len(self.gap)), **columns})

    def _answer(self) -> Mapping[str, object]:
        return {
            "nodes": len(self.gap),
            "slipping": int((np.abs(self.status) == 1).sum()),
            "open": int((self.status == OPEN).sum()),
            "residual": self.residual,
            "solver": self.record.solver,
        }

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        return self._title, None, None, ""


def force_scale(bonded: Array, reactions: Array) -> float:
    """The unit of force of an increment: the mean normal bonded reaction.

    If next to no normal forces act, the unit is the mean size of all reactions. `bonded` (N,) are
    the normal bonded reactions, and `reactions` (M,) all reactions without further motion.
    """
    force = float(np.abs(bonded).sum()) / len(bonded)
    if force > _NO_FORCE * np.abs(reactions).max():
        return force
    return float(np.abs(reactions).mean()) or 1.0


def sizes_of(S: Array, own_stiffness: Array) -> Array:
    """(t + 1, N) stiffness of each node against itself.

    For the tangents of a node it is the largest stiffness in any tangential direction, and at least
    the stiffness of each direction in `own_stiffness` (t + 1, N).
    """
    axes, n = own_stiffness.shape
    nodes = np.arange(n)
    # (N, t, t) tangential stiffness of each node.
    blocks = S.reshape(axes, n, axes, n)[:-1, nodes, :-1, nodes]
    largest = np.linalg.eigvalsh(blocks)[:, -1]
    tangential = np.maximum(largest, own_stiffness[:-1].max(axis=0))
    return np.vstack([np.tile(tangential, (axes - 1, 1)), own_stiffness[-1]])


class Posed:
    """An increment in units of the mean normal force and of the slip that this force makes.

    The unknowns are `u = [dv, w]`: the change of slip from `slip`, and the total gap. The reactions
    are `[q, p] = trial + S u`. The `owner` is a `NewtonIncrement`, with the contact, its friction
    and its law. ModelError for arrays that do not fit.
    """

    def __init__(self, owner: Any, slip: ArrayLike, bonded: Sequence[ArrayLike]) -> None:
        self._started = perf_counter()
        system = owner.system
        self.owner = owner
        self.slip = finite_array("slip", slip, system.slip_shape)
        self.bonded = checked_pair("bonded", bonded, system.nodes, system.tangents)
        moved = joined(self.slip, -system.gap)
        self.reactions = joined(*self.bonded) + system.S @ moved
        self.force = force_scale(self.bonded[1], self.reactions)
        self.length = self.force / system.stiffness_scale
        self.trial = self.reactions / self.force
        self.law = owner.law.per_force(self.force)

    def result(self, state: State, solver: str, residual: float | None = None) -> Increment:
        """The state in the units of the caller, with its record.

        If `residual` is None, the check of the contact law computes it.
        """
        owner = self.owner
        system = owner.system
        axes = system.tangents + 1
        dv, w = parted(state.u, axes)
        q, p = parted(self.force * state.r, axes)
        slip = np.where(dv != 0, self.slip + self.length * dv, self.slip)
        gap = self.length * np.maximum(w, 0.0)
        if residual is None:
            u, before = joined(slip, gap - system.gap), joined(self.slip, gap)
            errors = off_law(
                system,
                owner.contact_law,
                joined(*self.bonded),
                u,
                self.force * state.r,
                self.force,
                before,
            )
            residual = worst(errors)
        seconds = perf_counter() - self._started
        record = SolveRecord(solver, residual=residual, seconds=seconds)
        return Increment(slip, gap, q, p, state.status, state.steps, record)
