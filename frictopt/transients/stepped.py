"""A transient from increment to increment."""

from copy import copy
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ..base import Array, Booleans, whole_number
from ..errors import ModelError, NoContinuation, SolverError
from .statics import Statics, check_sliding, motions_of_bodies
from .transient import OPEN, STICK, FollowedCycle, Transient

# Numbers of increments.

# Default number of increments from corner to corner.
_STEPS = 20
# Least number of parts into which the error estimate divides each increment.
_PARTS = 4
# Least number of increments from corner to corner in the error estimate.
_FINEST = 32

# The finer increments also end at these distances before a corner, in lengths of an increment. Just
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

    A segment goes from corner to corner. `steps` is 20 if it is None. The other parameters are
    those of `Transient`.

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
        smaller_counts = {max(1, self.steps // 2), max(1, self.steps // 4)} - {self.steps}
        self.coarser = sorted(smaller_counts, reverse=True)
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
        because increments that friction cannot hold end it anyway.
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
        """The next state, with the work of friction from the mean of the two friction bounds."""
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
        is_supported = not motions_of_bodies(system).size
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
        points = self.follow(self.legs * count)
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
