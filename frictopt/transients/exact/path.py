"""The exact path of one transient, from corner to corner of the load cycle."""

import numpy as np

from ...base import RESIDUAL, Array, Booleans
from ...contact import LoadCycle, checked_plane, checked_uncapped, off_law
from ...contact.diagnosis import in_contact
from ...contact.history import turning_points
from ...errors import NoContinuation
from ..begin import Cycle, Transient
from .kernel import (
    DONE,
    OPEN,
    STALLED,
    UNSETTLED,
    compiled,
    follow,
    new_active_set,
    new_state,
    set_statuses,
)

_RESTART = (
    RESIDUAL / 10
)  # residual of a state that a path may restart from: the cycle from there adds its own
_ROWS = 256  # events that the record holds before they are moved to the history


def turning_corners(cycle: LoadCycle, load_factor: float = 1.0) -> list[int]:
    """Numbers of the corners at which the load changes its direction, the first and the last one in any case, see `turning_points`.

    The load factor counts only where a part of the cycle is fixed.
    """
    corners = cycle.corners if cycle.fixed is None else cycle.at(load_factor)
    cases = sorted({case for corner in corners for case in corner})
    return turning_points(
        np.array([[corner.get(case, 0.0) for case in cases] for corner in corners])
    )


class ExactPath(Transient):
    """The transient of one contact in the plane, see `Transient` for what it asks for: exactly, from event to event.

    On each straight segment of the load slip, gap and reactions are piecewise linear. There is no
    time step, and the only error is rounding.

    Attributes
    ----------
    state
        The present state, see `State` in `kernel.py`.
    history
        Of a path that is `recorded`: arrays of times (T,), `u` and `r` (T, 2N), statuses and work
        (T, N) side by side, after each event and at each corner. The time counts the corners
        visited.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> from frictopt.transients.exact import ExactPath
    >>> path = ExactPath(rod, cycle, friction=0.5, load_factor=1.0).start()
    >>> work = path.cycle_on(1).work
    >>> path.visited, round(float(path.state.u[0]), 6)  # slip of the first node at the second corner
    (2, -0.5)
    """

    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        checked_uncapped(
            checked_plane(self.system, "follow it by march or steady_state, in increments"),
            "the exact path",
        )
        compiled()
        nodes, self._S, self.unit = self.nodes, self.system.S, np.tile(self.scales.length, 2)
        self.turns = turning_corners(self.cycle, self.load_factor)
        self.history: list[Array] = []
        self._active, self._proof, self._record = (
            new_active_set(nodes),
            new_active_set(nodes),
            np.zeros((0, 1 + 6 * nodes)),
        )
        self.state = new_state(u, r, np.array(self.system.gap))
        self.state.status[opened] = OPEN

    def cycle_on(self, count: int) -> Cycle:
        """Follow so many load cycles, from each corner at which the load turns to the next."""
        state = self.state
        state.work[:] = state.supplied[:] = state.slid[:] = (
            0.0  # else a small work is lost to rounding next to that of a far start
        )
        state.trace[1] = 0
        before, stress, stops = state.u.copy(), state.r - self.bonded, []
        for number in self.turns * count:
            self.follow_to(*self.legs[number])
            stops.append((self.bonded, state.u.copy(), state.r.copy(), float(state.work.sum())))
        bonded, u, r = (
            np.array(values) for values in zip(*(stop[:3] for stop in stops), strict=True)
        )
        works = np.diff(
            [0.0, *(stop[3] for stop in stops[len(self.turns) - 1 :: len(self.turns)])]
        ).tolist()
        work, begin, end = state.work.copy(), before / self.unit, u[-1] / self.unit
        stress = (stress + r[-1] - bonded[-1]) / 2
        lost = abs(float(state.supplied[0] - work.sum() - stress @ (u[-1] - before)))
        scale = max(
            self.largest * self.length,
            float(work.sum()),
            float(np.abs(stress) @ np.abs(before)),
            np.finfo(float).tiny,
        )
        slid, change, lost = (
            state.slid.copy(),
            float(np.abs(end - begin).max()),
            max(lost, -float(work.min())) / scale,
        )
        return Cycle(
            begin, end, change, work, slid, works, int(state.trace[1]), bonded, u, r, lost=lost
        )

    def at(self, place: Array) -> "ExactPath | None":
        """A copy at the same load with another slip and gap, (2N,), in slip scales; None if that state violates the contact law."""
        n, copy, u = self.nodes, self.recorded(0), place * self.unit
        opened = self.state.status == OPEN
        u[n:][~opened] = -self.state.gap[~opened]
        bare = np.flatnonzero(np.r_[opened, opened])
        u[bare] -= np.linalg.lstsq(self._S[np.ix_(bare, bare)], (self.bonded + self._S @ u)[bare])[
            0
        ]  # rounding, of a far place many times
        r = self.bonded + self._S @ u
        r[bare] = 0.0
        copy.state = copy.state._replace(u=u, r=r)
        return (
            copy
            if off_law(self.system, self.friction, self.bonded, u, r, self.force).max() <= _RESTART
            else None
        )

    def recorded(self, rows: int = _ROWS) -> "ExactPath":
        """A copy at the same load and state that keeps the states at all events from here on, so many at a time; 0: none."""
        n, copy = self.nodes, object.__new__(ExactPath)
        copy.__dict__.update(
            self.__dict__,
            history=[],
            _record=np.zeros((rows, 1 + 6 * n)),
            _active=new_active_set(n),
        )
        copy.state = type(self.state)(*(values.copy() for values in self.state))
        return copy

    def follow_to(self, bonded: Array, where: str) -> None:
        """Follow the path in a straight line to other bonded reactions (2N,); NoContinuation if at some load no rates, or several, obey the law."""
        code, time, begins = UNSETTLED, 0.0, True
        seen: set[tuple[float, bytes]] = set()  # times and statuses of the rate problems
        while code != DONE:
            own = self.state, self._active, self._proof
            code, time = follow(
                self._S,
                self.friction,
                self.bonded,
                bonded,
                *own,
                self.scales.mean,
                time,
                begins,
                self._record,
            )
            if code == STALLED:
                raise NoContinuation(
                    f"{where}: at {time:.9g} of it the statuses change without end; loads or gaps may differ too much in size"
                )
            begins = False
            if len(self._record):
                self.history.append(self._record[: self.state.trace[3]].copy())
                self.history[-1][:, 0] += self.visited
                self.state.trace[3] = 0
            if code == UNSETTLED:
                place = time, self.state.status.tobytes()
                self._solve_rate_problem(bonded - self.bonded, time, where, again=place in seen)
                seen.add(place)
        state = self.state
        self.bonded = bonded
        self.visited += 1
        self.events, self.unproven = int(state.trace[0]), int(state.trace[2])
        if len(self._record):
            self.history.append(
                np.concatenate([[self.visited], state.u, state.r, state.status, state.work])[None]
            )

    def states(self) -> list[Array]:
        """Times (T,), `u` and `r` (T, 2N), statuses and work (T, N) of the history."""
        time, *states = np.split(
            np.concatenate(self.history), [1, *(1 + self.nodes * np.array([2, 4, 5]))], axis=1
        )
        return [time[:, 0], *states]

    def _solve_rate_problem(self, load_rate: Array, time: float, where: str, again: bool) -> None:
        """Set the statuses to the solution of the rate problem; if the path comes to it `again` at the same time, its rates lead nowhere."""
        from .rate import (
            Solutions,
            find_rates,
            rate_problem,
        )  # here, for few paths have such an event

        problem = rate_problem(self._S, self.friction, load_rate, self.state, self.scales.mean)
        solutions = (
            Solutions([], False) if problem.floating else find_rates(problem, self.state.status)
        )
        numbers, free = sorted(set(problem.node.tolist())), "the contact slides or opens freely"
        nodes = (
            f"nodes {numbers}{in_contact(self.system, numbers)}"
            if numbers
            else "open and frictionless nodes"
        )
        if problem.floating:
            why = free
        elif again:
            why = f"the statuses of {nodes} change without end"
        elif not solutions.found:
            proof = (
                "no rates obey the law"
                if solutions.complete
                else "no rates that obey the law were found"
            )
            why = f"{proof}; {nodes} are at their bounds and would jump"
        elif len(solutions.found) > 1:
            both = " or ".join(
                str([int(status[node]) for node in numbers]) for status, _ in solutions.found
            )
            why = f"two sets of rates obey the law: {nodes} may take the statuses {both}"
        elif not set_statuses(
            self._S, self.friction, self.state, self._active, solutions.found[0][0]
        ):
            why = f"{free}, its rates are not unique"
        else:
            self.state.trace[2] += not solutions.complete
            return
        hint = "often friction is above the critical value there (a node wedges itself where f exceeds A/|B|): lower it"
        if free in why:
            hint = self.free_body(self.state.r)
        elif problem.sliding:
            hint = f"the body may slide or open as a whole ({self.free_body(self.state.r)}), or friction is above the critical value there"
        raise NoContinuation(f"{where}: at {time:.9g} of it {why}; {hint}")
