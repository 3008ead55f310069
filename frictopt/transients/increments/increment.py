"""A friction increment: the problem as posed, in dimensionless units, and the result that every way to solve it returns."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import ClassVar

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from ...base import RESIDUAL, Array, SolveRecord, components, finite_array, frame
from ...contact import (
    ContactSystem,
    checked_system,
    contact_law,
    friction_coefficients,
    joined,
    off_law,
    parted,
)
from ...contact.given_parts import checked_pair
from ...errors import SolverError
from ...solve.problem import Explained
from ..statics import check_sliding, rigid_motions
from ..transient import HOLD, OPEN
from .newton import Law, State, newton

# a mean normal force below this share of the largest reaction is no scale: the error of an answer
# is as large
_NO_FORCE = RESIDUAL


@dataclass(frozen=True, eq=False, repr=False)
class Increment(Explained):
    """The state after one increment of load, judged by the referee.

    Attributes
    ----------
    slip
        Slip v, (N,) along +x in the plane, (N, 2) along the tangents in space, length. Nodes that
        stick keep their slip bit for bit.
    gap
        (N,) total gap w (initial gap included), length, >= 0.
    q, p
        Shear forces, in the shape of `slip`, and (N,) normal forces, compression positive: force
        per depth in the plane, force in space.
    status
        (N,) 0 sticks, 2 is open; slips: +1 along +x and -1 against it in the plane, 1 in space.
    steps
        Steps of Newton's method; of a program with frozen friction bound, how often it was solved.
    record
        How it was found. Its `residual` is the referee's, with the slip before the increment as the
        previous one. At most 1e-9.
    problem
        The cvxpy problem, in the units of the contact, in which the answer stands; None for
        Newton's method. A later solve by the same object overwrites its values.

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
    problem: cp.Problem | None = field(repr=False)
    _title: str = field(repr=False)

    def to_frame(self) -> pd.DataFrame:
        """A row for each node: node, slip, gap, q, p and status; in space slip1, slip2, q1 and q2."""
        columns = {
            **components("slip", self.slip),
            "gap": self.gap,
            **components("q", self.q),
            "p": self.p,
            "status": self.status,
        }
        return frame({"node": range(len(self.gap)), **columns})

    def _answer(self) -> Mapping[str, object]:
        counts = {
            name: int((np.abs(self.status) == value).sum())
            for name, value in (("slipping", 1), ("open", OPEN))
        }
        return {
            "nodes": len(self.gap),
            **counts,
            "residual": self.residual,
            "solver": self.record.solver,
        }

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return self._title, None, None, ""


def force_scale(bonded: Array, reactions: Array) -> float:
    """The mean of normal bonded reactions (N,), or where there are next to none, of the reactions (M,) without motion."""
    force = float(np.abs(bonded).sum()) / len(bonded)
    return (
        force
        if force > _NO_FORCE * np.abs(reactions).max()
        else float(np.abs(reactions).mean()) or 1.0
    )


def sizes_of(S: Array, own: Array) -> Array:
    """(t + 1, N) stiffness of each node against itself, for its tangents the largest in any direction, at least that `own` of each direction."""
    (axes, n), each = own.shape, np.arange(own.shape[1])
    blocks = S.reshape(axes, n, axes, n)[:-1, each, :-1, each]
    return np.vstack(
        [
            np.tile(
                np.maximum(np.linalg.eigvalsh(blocks)[:, -1], own[:-1].max(axis=0)), (axes - 1, 1)
            ),
            own[-1],
        ]
    )


class Posed:
    """An increment in units of the mean normal force and of the slip that this force makes; ModelError for arrays that do not fit.

    The unknowns are `u = [dv, w]`, slip since `slip` and total gap; the reactions `[q, p] = trial +
    S u`.
    """

    def __init__(
        self, owner: FrictionIncrement, slip: ArrayLike, bonded: Sequence[ArrayLike]
    ) -> None:
        system, self._started = owner.system, perf_counter()
        self.owner, self.slip = owner, finite_array("slip", slip, system.slip_shape)
        self.bonded = checked_pair("bonded", bonded, system.nodes, system.tangents)
        moved = joined(self.slip, -system.gap)
        self.reactions = joined(*self.bonded) + (system.S @ moved if moved.any() else 0.0)
        self.force = force_scale(self.bonded[1], self.reactions)
        self.length = self.force / system.stiffness_scale
        self.trial = self.reactions / self.force
        self.law = owner.law.per_force(self.force)

    def result(self, state: State, how: SolveRecord, residual: float | None = None) -> Increment:
        """The state in the caller's units, and how it was found, with what the referee says of it unless that is known."""
        owner, system = self.owner, self.owner.system
        (dv, w), (q, p) = (
            parted(state.u, system.tangents + 1),
            parted(self.force * state.r, system.tangents + 1),
        )
        slip, gap = (
            np.where(dv != 0, self.slip + self.length * dv, self.slip),
            self.length * np.maximum(w, 0.0),
        )
        if residual is None:
            u, before = joined(slip, gap - system.gap), joined(self.slip, gap)
            errors = off_law(
                system,
                owner.friction,
                joined(*self.bonded),
                u,
                self.force * state.r,
                self.force,
                before,
            )
            residual = float(np.nan_to_num(errors, nan=np.inf, posinf=np.inf).max())
        record = replace(how, residual=residual, seconds=perf_counter() - self._started)
        return Increment(slip, gap, q, p, state.status, state.steps, record, None, owner._title)

    def claim(self, u: Array, steps: int = 0) -> Increment:
        """What motions u say, dimensionless, after so many steps of Newton's method at most."""
        return self.result(newton(self.law, self.trial, u, steps), SolveRecord("NEWTON"))


class FrictionIncrement(ABC):
    """A friction increment after another of the same contact.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    """

    _title: ClassVar[str] = "friction increment"

    def __init__(self, system: ContactSystem, friction: ArrayLike) -> None:
        self.system, self.friction = (
            checked_system(system),
            friction_coefficients(friction, system.nodes),
        )
        self.own = (system.own_stiffness / system.stiffness_scale).reshape(-1, system.nodes)
        """(t + 1, N) dimensionless stiffness of each direction of each node."""
        S = system.S / system.stiffness_scale
        bound = contact_law(system, self.friction)
        augmentation = np.tile(self.own.max(axis=0), (len(self.own), 1))
        self.law = Law(S, bound.slopes, bound.constants, augmentation)
        """The dimensionless law, with one c and d for all directions of a node; its constants are in the unit of the caller."""
        self.sizes = sizes_of(S, self.own)

    def solve(self, slip: ArrayLike, bonded: Sequence[ArrayLike]) -> Increment:
        """A state to which a slip can move under a load.

        Parameters
        ----------
        slip
            Slip before the increment, (N,) in the plane, (N, 2) in space, length.
        bonded
            `(q^w, p^w)`, bonded reactions of the load after it, in the shape of `slip` and (N,):
            force per depth in the plane, force in space.

        Raises
        ------
        ModelError
            Arrays that do not fit.
        NoContinuation
            The load is beyond friction.
        SolverError
            No answer that passes the referee. That is no proof that no state obeys the law.
        """
        posed = Posed(self, slip, bonded)
        try:
            return self._solved(posed)
        except SolverError:
            check_sliding(self.system, self.friction, {"the load": joined(*posed.bonded)})
            raise

    @property
    def _remedy(self) -> str:
        """Why there may be no state, and what to change."""
        if rigid_motions(self.system.S, self.system.own_stiffness).size:
            return f"the body may slide or open as a whole, or friction is above the critical value there: {HOLD}"
        return "try smaller load steps, or less friction (above the critical friction there may be no state, or several)"

    def along(
        self, u: Array, loads: Sequence[Array]
    ) -> Iterator[tuple[Array, Array, NDArray[np.int8]]]:
        """`u = [v, w - g0]` and reactions (M,), and status, after each of several loads (M,) in turn, from `u` on; errors are those of `solve`."""
        axes = self.system.tangents + 1
        for load in loads:
            new = self.solve(parted(u, axes)[0], parted(load, axes))
            u = joined(new.slip, new.gap - self.system.gap)
            yield u, joined(new.q, new.p), new.status

    @abstractmethod
    def _solved(self, posed: Posed) -> Increment: ...
