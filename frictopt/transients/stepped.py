"""A transient from increment to increment."""

from copy import copy
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ..base import Array, Booleans, whole_number
from ..contact import ContactSystem, most_shear
from ..errors import ModelError, NoContinuation, SolverError
from .statics import Statics, check_sliding
from .transient import OPEN, STICK, FollowedCycle, Transient

# Numbers of increments.

# Default number of increments from corner to corner.
_STEPS = 20
# Least number of parts into which the error estimate divides each increment.
_PARTS = 4
# Least number of increments from corner to corner in the error estimate.
_FINEST = 32

# In the error estimate, increments also end at these distances before a corner. The unit is the
# length of an increment before it is divided. Just
# above a limit, nodes slip only shortly before a corner. The closer the load factor is to the
# limit, the smaller is this part of the segment.
_TAIL = np.concatenate([0.5 ** (np.arange(1, 13) / 2), 0.5 ** np.arange(7, 21)])


class SteppedState(NamedTuple):
    """A state: load, `u = [v, w - g0]` and reactions (M,), and status (N,).

    `work` and `way` (N,) are the work of friction, and the path of slip while closed, since the
    previous state.
    """

    bonded: Array
    u: Array
    r: Array
    status: NDArray[np.int8]
    work: Array
    way: Array


class SteppedPath(Transient):
    """States of a transient in `steps` increments per segment.

    A segment goes from corner to corner. If `steps` is None, it has 20 increments. The other
    parameters are those of `Transient`.

    Attributes
    ----------
    shares
        Ends of the increments, as shares of the segment.
    state
        The present state.
    events
        Number of changes of status so far.
    """

    engine = "newton"

    def __init__(self, steps: int | None, *parameters: Any, retries: bool = True) -> None:
        self._retries = retries
        self.steps = whole_number("steps", _STEPS if steps is None else steps, least=1)
        self.shares = np.arange(1, self.steps + 1) / self.steps
        super().__init__(*parameters)

    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        # Imported here, because the exact path does not need it.
        from .increments import NewtonIncrement

        self._increment = NewtonIncrement(self.system, self.friction)
        self._increment.retries = self._retries
        self.unit = np.tile(self.scales.length, self.system.tangents)
        status = np.where(opened, OPEN, STICK).astype(np.int8)
        zeros = np.zeros(self.nodes)
        self.state = SteppedState(self.bonded, u, r, status, zeros, zeros)

    def checked(self) -> Self:
        """Return the transient itself if its mean load presses and friction can hold all loads.

        Otherwise raise ModelError or NoContinuation. Without retries friction is not checked,
        because an increment that friction cannot hold ends the transient anyway.
        """
        loads = {"the mean load": self.mean}
        for name, corner in zip(self.cycle.corner_names, self.corners, strict=True):
            loads[f"the load at the corner ({name})"] = corner
        if self._retries:
            check_sliding(self.system, self.friction, loads)
        if not np.abs(self.mean[-self.nodes :]).max() > 0:
            raise ModelError(
                "mean: the mean load has no normal reactions, and a transient starts from it; give "
                "`cycle.mean` a load that presses"
            )
        return self

    def follow_to(self, bonded: Array, where: str) -> list[SteppedState]:
        """The states on the straight segment to other bonded reactions.

        The last one becomes the present state. Errors of increments name the segment by `where`.
        """
        points = []
        change = bonded - self.state.bonded
        loads = [*(self.state.bonded + self.shares[:-1, None] * change), bonded]
        states = self._increment.along(self.state.u, loads)
        for step, load in enumerate(loads, 1):
            try:
                u, r, status = next(states)
            except (NoContinuation, SolverError) as error:
                place = f"{where}, increment {step} of {len(loads)}"
                raise self._end(error, load, place) from error
            self.events += int((status != self.state.status).sum())
            self.state = self._next_state(load, u, r, status)
            points.append(self.state)
        self.bonded = bonded
        self.visited += 1
        # In increments no event is proven to be unique.
        self.unproven = self.events
        return points

    def _next_state(
        self, load: Array, u: Array, r: Array, status: NDArray[np.int8]
    ) -> SteppedState:
        """The next state, with the work of friction by the mean of the bounds before and after."""
        n, before = self.nodes, self.state
        slip_step = (u - before.u)[:-n].reshape(-1, n)
        path = np.sqrt((slip_step**2).sum(axis=0)) * (status != OPEN)
        pressures = np.array([before.r, r])[:, -n:]
        bound = self.law.bound(pressures).mean(axis=0)
        return SteppedState(load, u, r, status, bound * path, path)

    def _end(
        self, error: NoContinuation | SolverError, load: Array, where: str
    ) -> NoContinuation | SolverError:
        """The error of an increment that has no state, with the place of the increment.

        If a body slides off under the load, the message names this as the cause.
        """
        system = self.system
        is_supported = not system.rigid_motions.size
        if isinstance(error, NoContinuation) or is_supported or not self._retries:
            return type(error)(f"{where}: {error}")
        statics = Statics(system, self.friction)
        slides = statics.slides_off("the load there", load + system.S @ self.state.u)
        if slides:
            return NoContinuation(f"{where}: {slides}; no state was found")
        return SolverError(f"{where}: {error} ({self.forces_there(self.state.r)})")

    def finer(self) -> tuple[Self, int]:
        """A copy with finer increments, and the number of parts of each increment."""
        parts = max(_PARTS, -(-_FINEST // self.steps))
        count = parts * self.steps
        equal_ends = np.arange(1, count + 1) / count
        last_ends = 1 - _TAIL / self.steps
        copied = copy(self)
        copied.shares = np.unique(np.r_[equal_ends, last_ends].round(12))
        return copied, parts

    def cycle_on(self, count: int) -> FollowedCycle:
        """Follow `count` load cycles, from increment to increment."""
        begin = self.state
        points = self.follow(self.segments * count)
        bonded, u, r, status, work, path = (
            np.array(values) for values in zip(*points, strict=True)
        )
        before = begin.u[: -self.nodes] / self.unit
        after = u[-1, : -self.nodes] / self.unit
        return FollowedCycle(
            before=before,
            after=after,
            change=float(np.abs(after - before).max()),
            work=work.sum(axis=0),
            slid=path.sum(axis=0),
            works=work.reshape(count, -1).sum(axis=1).tolist(),
            events=status.tobytes(),
            bonded=bonded,
            u=u,
            r=r,
            previous=np.concatenate([begin.u[None], u[:-1]]),
        )

    def at(self, place: Array) -> Self | None:
        """A copy at the same load, in the state that an increment reaches from another slip.

        `place` is the other slip, in slip scales. None if there is no such state.
        """
        copied = copy(self)
        u = np.r_[place * self.unit, self.state.u[-self.nodes :]]
        copied.state = self.state._replace(u=u)
        copied.shares = np.ones(1)
        try:
            copied.follow_to(self.bonded, "the load at hand")
        except (NoContinuation, SolverError):
            return None
        copied.shares = self.shares
        return copied


# Work and slip of events within increments, which the states at their ends do not show.
#
# An increment has only the states at its two ends. Between them the load on each node is assumed to
# change linearly. The increment is exact if the node keeps sliding, or if its friction bound stays
# constant. These functions estimate the missed work and slip if the node sticks for a part of the
# increment, slips to and fro, opens or lands. So they detect events that are so close to a corner
# that no number of increments separates them from it.


class Doubts(NamedTuple):
    """Possible errors of work and slip, see `doubts`, and the mean bound; (T - 1, N) each."""

    lacking: Array
    change: Array
    missed: Array
    late: Array
    bound: Array


def doubts(system: ContactSystem, friction: Array, u: Array, r: Array) -> Doubts:
    """Possible errors of work and slip within the increments between T states (T, M).

    `lacking` is the work of friction, the mean bound times the path of slip, minus the work that
    the reactions do against the slip. `lacking` is positive if a node is below its bound for a part
    of the increment. `change` is the change of the bound times the path of slip.

    `missed` is the work of friction of a node before it opens within an increment. `late` is the
    distance between the point where a node lands and the point where the increment makes it stick.
    The states contain neither. `missed` and `late` are computed for each node by itself, under a
    load that changes linearly from the closed end to the open end. In the plane this is exact for a
    node that is not coupled to other nodes.
    """
    n = len(friction)
    gap = u[:, -n:] + system.gap
    slip_step = np.diff(u[:, :-n], axis=0).reshape(len(u) - 1, -1, n)
    forces = r.reshape(len(r), -1, n)
    closed = (forces != 0).any(axis=1)
    shear = forces[:, :-1]
    bound = most_shear(system, friction, forces[:, -1])

    path = np.linalg.norm(slip_step * closed[1:, None], axis=1)
    mean_bound = (bound[1:] + bound[:-1]) / 2
    mean_shear = (shear[1:] + shear[:-1]) / 2
    lacking = mean_bound * path + (mean_shear * slip_step * closed[1:, None]).sum(axis=1)
    change = np.abs(np.diff(bound, axis=0)) * path

    opens = closed[:-1] & ~closed[1:]
    lands = ~closed[:-1] & closed[1:] & (path == 0)
    row, node = np.nonzero(opens | lands)
    # If a node lands, its increment has the closed end at the last state, not at the first.
    crossing = _Crossing(
        stiffness=system.S.reshape(-1, n, len(system.S) // n, n)[:, node, :, node],
        forces=forces[row + lands[row, node], :, node],
        slip_step=slip_step[row, :, node],
        gap=gap[row + opens[row, node], node],
    )
    slip = _slip_in_contact(crossing)
    distance = np.linalg.norm(slip, axis=1)
    pressure = _pressure_at_first_slip(crossing, friction[node], slip)
    missed = np.zeros_like(path)
    missed[row, node] = friction[node] * pressure / 2 * distance * opens[row, node]
    late = np.zeros_like(path)
    late[row, node] = distance * lands[row, node]
    return Doubts(np.maximum(lacking, 0.0), change, missed, late, mean_bound)


class _Crossing(NamedTuple):
    """E nodes that open or land within an increment, each by itself.

    `stiffness` (E, t + 1, t + 1) has the diagonal blocks of the nodes in the stiffness matrix.
    `forces` (E, t + 1) are their reactions `[q, p]` at the closed end, `slip_step` (E, t) their
    slips in the increment, and `gap` (E,) their gaps at the open end.
    """

    stiffness: Array
    forces: Array
    slip_step: Array
    gap: Array


def _slip_in_contact(crossing: _Crossing) -> Array:
    """(E, t) slip between the closed end and the point where the pressure vanishes.

    This slip lies between two slips without shear force: the first releases the shear at the closed
    end, the second is the whole slip minus the part due to the gap. The pressure decreases linearly
    from the first slip to the second.
    """
    q, p = crossing.forces[:, :-1], crossing.forces[:, -1]
    coupling = crossing.stiffness[:, :-1, -1]
    shear_flexibility = np.linalg.pinv(crossing.stiffness[:, :-1, :-1], hermitian=True)
    slips = shear_flexibility @ np.stack([q, coupling], axis=2)
    # Slip that releases the shear, with opposite sign, and slip due to a unit closure of the gap.
    freed, per_gap = np.moveaxis(slips, 2, 0)

    pressure_left = np.maximum(p - (coupling * freed).sum(axis=1), 0.0)
    normal_stiffness = crossing.stiffness[:, -1, -1] - (coupling * per_gap).sum(axis=1)
    pull_of_gap = np.maximum(normal_stiffness, 0.0) * crossing.gap
    whole = np.where(pressure_left > 0, pressure_left + pull_of_gap, 1.0)
    share = (pressure_left / whole)[:, None]
    slip_without_gap = crossing.slip_step + per_gap * crossing.gap[:, None]
    slip: Array = share * slip_without_gap - (1 - share) * freed
    return slip


def _pressure_at_first_slip(crossing: _Crossing, friction: Array, slip: Array) -> Array:
    """(E,) pressure at which a slip (E, t) reaches its friction bound and begins."""
    size = np.linalg.norm(slip, axis=1)
    direction = slip / np.where(size > 0, size, 1.0)[:, None]
    motion = np.column_stack([crossing.slip_step, crossing.gap])
    # Change of the load from the closed end to the open end, where the node has no reactions.
    load_change = -crossing.forces - (crossing.stiffness @ motion[..., None])[..., 0]

    def slack(forces: Array) -> Array:
        value: Array = friction * forces[:, -1] + (forces[:, :-1] * direction).sum(axis=1)
        return value

    p = crossing.forces[:, -1]
    fall = slack(-load_change)
    share = slack(crossing.forces) / np.where(fall > 0, fall, 1.0)
    begins_at = np.where(fall > 0, p + load_change[:, -1] * share, p)
    return begins_at.clip(0.0, p)
