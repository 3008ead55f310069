"""A transient from increment to increment."""

from copy import copy
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ..base import Array, Booleans, whole_number
from ..contact import ContactSystem, most_shear
from ..errors import ModelError, NoContinuation, SolverError
from .begin import OPEN, STICK, Cycle, Transient
from .statics import Statics, check_sliding, rigid_motions

ENGINES = MappingProxyType(
    {"newton": "NewtonIncrement", "qp": "FrozenBoundIncrement", "milp": "ExactIncrement"}
)
"""Ways to solve an increment, and the names of their classes."""

_STEPS = 20  # increments from corner to corner, unless another number is given
_PARTS, _LEAST = (
    4,
    32,
)  # finer increments that tell an error: of each one, and from corner to corner, at least
# Shares of the last of the finer increments that are left at more of them. Just above a limit nodes
# slip shortly before a corner alone, in a part of
# the way that is as small as the load factor is close to the limit.
_TAIL = np.concatenate([0.5 ** (np.arange(1, 13) / 2), 0.5 ** np.arange(7, 21)])


class Point(NamedTuple):
    """One state: load, `u = [v, w - g0]`, reactions (M,); status; and since the state before the work of friction and the way slid while closed."""

    bonded: Array
    u: Array
    r: Array
    status: NDArray[np.int8]
    work: Array
    way: Array


class SteppedPath(Transient):
    """States of a transient by an engine of `ENGINES`, a number of increments from corner to corner (None: 20); `asked` as in `Transient`.

    Attributes
    ----------
    shares
        Ends of the increments, as shares of the way from corner to corner.
    state
        The present state.
    events
        Number of changes of status so far.
    """

    def __init__(self, engine: str, steps: int | None, *asked: Any) -> None:
        self.engine, self.steps = (
            engine,
            whole_number("steps", _STEPS if steps is None else steps, least=1),
        )
        self.coarser = sorted(
            {max(1, self.steps // 2), max(1, self.steps // 4)} - {self.steps}, reverse=True
        )
        self.shares = np.arange(1, self.steps + 1) / self.steps
        super().__init__(*asked)

    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        from . import increments  # here, because the exact path does not need cvxpy

        none = np.zeros(self.nodes)
        self._increment = getattr(increments, ENGINES[self.engine])(self.system, self.friction)
        self.unit = np.tile(self.scales.length, self.system.tangents)
        self.state = Point(
            self.bonded, u, r, np.where(opened, OPEN, STICK).astype(np.int8), none, none
        )

    def checked(self) -> Self:
        """The transient itself, if its mean load presses and friction can hold all loads; else ModelError, NoContinuation."""
        loads = {
            f"the load at the corner ({name})": r
            for name, r in zip(self.cycle.corner_names, self.corners, strict=True)
        }
        check_sliding(self.system, self.friction, {"the mean load": self.mean} | loads)
        if not np.abs(self.mean[-self.nodes :]).max() > 0:
            raise ModelError(
                "mean: the mean load has no normal reactions, and a transient starts from it; give `cycle.mean` a load that presses"
            )
        return self

    def follow_to(self, bonded: Array, where: str) -> list[Point]:
        """The states on the straight way to other bonded reactions; the last one stays. Errors of increments say where."""
        n, points = self.nodes, list[Point]()
        loads = [
            *(self.state.bonded + self.shares[:-1, None] * (bonded - self.state.bonded)),
            bonded,
        ]
        states = self._increment.along(self.state.u, loads)
        for step, load in enumerate(loads, 1):
            try:
                u, r, status = next(states)
            except (NoContinuation, SolverError) as error:
                raise self._end(
                    error, load, f"{where}, increment {step} of {len(loads)}"
                ) from error
            before = self.state
            moved = np.sqrt(((u - before.u)[:-n].reshape(-1, n) ** 2).sum(axis=0)) * (
                status != OPEN
            )
            bound = most_shear(self.system, self.friction, np.array([before.r, r])[:, -n:]).mean(
                axis=0
            )
            self.events += int((status != before.status).sum())
            self.state = Point(load, u, r, status, bound * moved, moved)
            points.append(self.state)
        self.bonded, self.visited, self.unproven = (
            bonded,
            self.visited + 1,
            self.events,
        )  # nothing is proven of any event
        return points

    def _end(
        self, error: NoContinuation | SolverError, load: Array, where: str
    ) -> NoContinuation | SolverError:
        """The error of an increment that finds no state under a load, which says where, and that the body slides off where it does."""
        system = self.system
        if (
            isinstance(error, NoContinuation)
            or not rigid_motions(system.S, system.own_stiffness).size
        ):
            return type(error)(f"{where}: {error}")
        slides = Statics(system, self.friction).slides_off(
            "the load there", load + system.S @ self.state.u
        )
        if slides:
            return NoContinuation(f"{where}: {slides}; no state was found")
        return SolverError(f"{where}: {error} ({self.forces_there(self.state.r)})")

    def finer(self) -> tuple[Self, int]:
        """A copy that goes on in finer increments, and into how many it parts each one."""
        copied, parts = copy(self), max(_PARTS, -(-_LEAST // self.steps))
        copied.shares = np.unique(
            np.r_[
                np.arange(1, parts * self.steps + 1) / (parts * self.steps), 1 - _TAIL / self.steps
            ].round(12)
        )
        return copied, parts

    def cycle_on(self, count: int) -> Cycle:
        """Follow so many load cycles, from increment to increment."""
        begin = self.state
        points = [point for leg in self.legs * count for point in self.follow_to(*leg)]
        bonded, u, r, status, work, way = (np.array(values) for values in zip(*points, strict=True))
        before, after = begin.u[: -self.nodes] / self.unit, u[-1, : -self.nodes] / self.unit
        previous, change = (
            np.concatenate([begin.u[None], u[:-1]]),
            float(np.abs(after - before).max()),
        )
        works = work.reshape(count, -1).sum(axis=1).tolist()
        return Cycle(
            before,
            after,
            change,
            work.sum(axis=0),
            way.sum(axis=0),
            works,
            status.tobytes(),
            bonded,
            u,
            r,
            previous,
        )

    def at(self, place: Array) -> Self | None:
        """A copy at the same load with another slip, in slip scales, and where an increment takes it from there; None if there is no state."""
        elsewhere, n = copy(self), self.nodes
        elsewhere.state = self.state._replace(u=np.r_[place * self.unit, self.state.u[-n:]])
        elsewhere.shares = np.ones(1)
        try:
            elsewhere.follow_to(self.bonded, "the load at hand")
        except (NoContinuation, SolverError):
            return None
        elsewhere.shares = self.shares
        return elsewhere


class Doubts(NamedTuple):
    """What the ends of increments leave in doubt, (T - 1, N) each: works and slips, see `doubts`; and the mean friction bound."""

    lacking: Array
    change: Array
    missed: Array
    late: Array
    bound: Array


def doubts(system: ContactSystem, friction: Array, u: Array, r: Array) -> Doubts:
    """What the ends of increments leave in doubt, from T states and their reactions, (T, M).

    `lacking` is what the loads lack for the work of friction: a node that sticks in a part of an
    increment, or slips to and fro, is below its bound there. `change` is the change of the bound
    along the way. Both are zero where a node slides all the time, or its bound stays: there the
    increment is exact. `missed` is the work of a node before it opens, and `late` the slip between
    where a node sticks that was open, and where it came down: increments count neither. They all
    see events that lie so close to a corner that no number of increments parts them.

    All else is taken to drive a node evenly from where it is closed to where it is open, which is
    exact in the plane for a node that no other one moves.
    """
    n, gap = len(friction), u[:, -len(friction) :] + system.gap
    dv, r = np.diff(u[:, :-n], axis=0).reshape(len(u) - 1, -1, n), r.reshape(len(r), -1, n)
    closed, q, bound = (
        (r != 0).any(axis=1),
        r[:, :-1],
        most_shear(system, friction, r[:, -1]),
    )  # an open node has no reactions
    way, mean = np.linalg.norm(dv * closed[1:, None], axis=1), (bound[1:] + bound[:-1]) / 2
    lacking = mean * way + ((q[1:] + q[:-1]) / 2 * dv * closed[1:, None]).sum(axis=1)

    opens, lands = closed[:-1] & ~closed[1:], ~closed[:-1] & closed[1:] & (way == 0)
    row, node = np.nonzero(opens | lands)
    own, f = (
        system.S.reshape(-1, n, len(system.S) // n, n)[:, node, :, node],
        friction[node],
    )  # stiffness of a node against itself
    begun, dv, w = (
        r[row + lands[row, node], :, node],
        dv[row, :, node],
        gap[row + opens[row, node], node],
    )  # reactions while closed, gap while open
    b, p = own[:, :-1, -1], begun[:, -1]
    freed, pushed = np.moveaxis(
        np.linalg.pinv(own[:, :-1, :-1], hermitian=True) @ np.stack([begun[:, :-1], b], axis=2),
        2,
        0,
    )
    left, opened = (
        np.maximum(p - (b * freed).sum(axis=1), 0.0),
        np.maximum(own[:, -1, -1] - (b * pushed).sum(axis=1), 0.0) * w,
    )
    share = (left / np.where(left > 0, left + opened, 1.0))[:, None]
    slip = share * (dv + pushed * w[:, None]) - (1 - share) * freed  # up to where the node opens
    size = np.linalg.norm(slip, axis=1)
    drive, along = (
        -begun - (own @ np.column_stack([dv, w])[..., None])[..., 0],
        slip / np.where(size > 0, size, 1.0)[:, None],
    )
    slack, falls = (
        f * part[:, -1] + (part[:, :-1] * along).sum(axis=1) for part in (begun, -drive)
    )
    pressure = np.where(
        falls > 0, p + drive[:, -1] * slack / np.where(falls > 0, falls, 1.0), p
    ).clip(0.0, p)  # at which this slip begins
    missed, late = np.zeros_like(way), np.zeros_like(way)
    missed[row, node], late[row, node] = (
        f * pressure / 2 * size * opens[row, node],
        size * lands[row, node],
    )
    return Doubts(
        np.maximum(lacking, 0.0), np.abs(np.diff(bound, axis=0)) * way, missed, late, mean
    )
