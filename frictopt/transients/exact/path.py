"""The exact path of one transient, from corner to corner of the load cycle."""

from copy import copy, deepcopy
from typing import Any

import numpy as np

from ...base import RESIDUAL, Array, Booleans
from ...contact import LoadCycle, amplitudes_of, checked_law, off_law
from ...contact.diagnosis import in_contact
from ...contact.history import turning_points
from ...errors import ModelError, NoContinuation
from ..transient import FollowedCycle, Transient
from .kernel import (
    BEGIN,
    DONE,
    EVENT,
    EVENTS,
    OPEN,
    SIGNATURE,
    STALLED,
    UNPROVEN,
    UNSETTLED,
    compiled,
    follow,
    new_active_set,
    new_state,
    set_statuses,
)
from .rate import RateProblem, Solutions, find_rates, rate_problem

_FREE = "the contact slides or opens freely"


def turning_corners(cycle: LoadCycle, load_factor: float = 1.0) -> list[int]:
    """Numbers of the corners at which the load changes its direction, see `turning_points`.

    The first and the last corner are always among them. The load factor matters only if the cycle
    has fixed parts.
    """
    corners = cycle.corners if cycle.fixed is None else cycle.at(load_factor)
    return turning_points(amplitudes_of(corners))


class ExactPath(Transient):
    """The transient of one contact in the plane, followed exactly from event to event.

    On each straight segment of the load slip, gap and reactions are piecewise linear. There is no
    time step, and the only error is rounding. The parameters are those of `Transient`.

    Attributes
    ----------
    state
        The present state, see `State` in `kernel.py`.
    history
        Of a path that is `recorded`: time, `u` and `r` (2N,), statuses and work (N,) after each
        event and at each corner. The time counts the corners visited.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> from frictopt.transients.exact import ExactPath
    >>> path = ExactPath(rod, cycle, friction=0.5, load_factor=1.0).start()
    >>> work = path.cycle_on(1).work
    >>> path.visited, round(float(path.state.u[0]), 6)  # slip of node 0 at the second corner
    (2, -0.5)
    """

    def _begin(self, u: Array, r: Array, opened: Booleans) -> None:
        if self.system.tangents != 1:
            raise ModelError(
                "system: a contact in space; this is answered for contacts in the plane; follow it "
                "by march or steady_state, in increments"
            )
        checked_law(self.system, "the exact path")
        compiled()
        self._S = self.system.S
        self._active = new_active_set(self.nodes)
        self._proof = new_active_set(self.nodes)
        self.unit = np.tile(self.scales.length, 2)
        self.turns = turning_corners(self.cycle, self.load_factor)
        self.history: list[tuple[Any, ...]] = []
        self._records = False
        self.state = new_state(u, r, np.array(self.system.gap))
        self.state.status[opened] = OPEN

    def cycle_on(self, count: int) -> FollowedCycle:
        """Follow `count` load cycles, from each corner at which the load turns to the next."""
        state = self.state
        # Sums begin at zero, or a small work would be lost to rounding after a far start.
        state.work[:] = 0.0
        state.supplied[:] = 0.0
        state.slid[:] = 0.0
        state.trace[SIGNATURE] = 0
        u_before = state.u.copy()
        stress_before = state.r - self.bonded

        loads, motions, forces = [], [], []
        work_so_far = [0.0]
        for _ in range(count):
            for number in self.turns:
                self.follow_to(*self.segments[number])
                loads.append(self.bonded)
                motions.append(state.u.copy())
                forces.append(state.r.copy())
            work_so_far.append(float(state.work.sum()))

        before = u_before / self.unit
        after = state.u / self.unit
        return FollowedCycle(
            before=before,
            after=after,
            change=float(np.abs(after - before).max()),
            work=state.work.copy(),
            slid=state.slid.copy(),
            works=np.diff(work_so_far).tolist(),
            events=int(state.trace[SIGNATURE]),
            bonded=np.array(loads),
            u=np.array(motions),
            r=np.array(forces),
            lost=self._lost_energy(u_before, stress_before),
        )

    def _lost_energy(self, u_before: Array, stress_before: Array) -> float:
        """The error of the energy balance in a cycle, or negative work of friction if it is larger.

        See `FollowedCycle.lost`. `stress_before` (2N,) is `S u` at the beginning: the elastic
        energy gained is the mean stress times the change of u.
        """
        state, work = self.state, self.state.work
        mean_stress = (stress_before + state.r - self.bonded) / 2
        gained = mean_stress @ (state.u - u_before)
        error = abs(float(state.supplied[0] - work.sum() - gained))
        largest_energy = max(
            self.largest * self.length,
            float(work.sum()),
            float(np.abs(mean_stress) @ np.abs(u_before)),
            np.finfo(float).tiny,
        )
        return max(error, -float(work.min())) / largest_energy

    def at(self, place: Array) -> "ExactPath | None":
        """A copy at the same load with another slip and gap (2N,), in slip scales.

        None if that state violates the contact law.
        """
        n, S = self.nodes, self._S
        opened = self.state.status == OPEN
        u = place * self.unit
        u[n:][~opened] = -self.state.gap[~opened]
        # Open nodes move until no force acts on them: at a far place rounding leaves a force.
        motions = np.flatnonzero(np.r_[opened, opened])
        carried = (self.bonded + S @ u)[motions]
        u[motions] -= np.linalg.lstsq(S[np.ix_(motions, motions)], carried)[0]
        r = self.bonded + S @ u
        r[motions] = 0.0
        residual = off_law(self.system, self.law, self.bonded, u, r, self.force).max()
        # Largest residual of a state from which a path may restart. This residual is less than the
        # tolerance, because the cycle from such a state adds errors of its own.
        restart = RESIDUAL / 10
        if not residual <= restart:
            return None
        there = self.recorded(records=False)
        there.state = there.state._replace(u=u, r=r)
        return there

    def recorded(self, records: bool = True) -> "ExactPath":
        """A copy at the same load and state that records the states at all events from here on.

        If `records` is False, it records none.
        """
        path = copy(self)
        path.history = []
        path.state = deepcopy(self.state)
        path._records = records
        path._active = new_active_set(self.nodes)
        return path

    def follow_to(self, bonded: Array, where: str) -> None:
        """Follow the path in a straight line to other bonded reactions (2N,).

        NoContinuation if at some load no rates obey the law, or several do.
        """
        code, time = BEGIN, 0.0
        # Number of the event after which the statuses seem to change without end.
        most = self.events + 1000 + 200 * self.nodes
        # Times and statuses of the rate problems on this segment.
        seen: set[tuple[float, bytes]] = set()
        while code != DONE:
            code, time = follow(
                self._S,
                self.friction,
                self.bonded,
                bonded,
                self.state,
                self._active,
                self._proof,
                self.scales.mean,
                self.system.stiffness_scale,
                time,
                code,
                self._records,
                most - self.state.trace[EVENTS],
            )
            if code == STALLED:
                raise NoContinuation(
                    f"{where}: at {time:.9g} of it the statuses change without end; loads or gaps "
                    "may differ too much in size"
                )
            if code == EVENT:
                self._record(time)
            if code == UNSETTLED:
                problem = time, self.state.status.tobytes()
                place = f"{where}: at {time:.9g} of it"
                self._solve_rate_problem(bonded - self.bonded, place, again=problem in seen)
                seen.add(problem)
        self.bonded = bonded
        self.visited += 1
        self.events = int(self.state.trace[EVENTS])
        self.unproven = int(self.state.trace[UNPROVEN])
        if self._records:
            self._record(0.0)

    def _record(self, time: float) -> None:
        """Add the state at a time of the present segment to the history."""
        state = self.state
        parts = state.u, state.r, state.status, state.work
        self.history.append((self.visited + time, *(part.copy() for part in parts)))

    def states(self) -> list[Any]:
        """Times (T,), `u` and `r` (T, 2N), statuses and work (T, N) of the history."""
        return [np.array(parts) for parts in zip(*self.history, strict=True)]

    def _solve_rate_problem(self, load_rate: Array, place: str, again: bool) -> None:
        """Set the statuses to the only solution of the rate problem; NoContinuation without one.

        `again`: the path has come back to this problem at the same time: its rates lead nowhere.
        """
        state = self.state
        problem = rate_problem(self._S, self.friction, load_rate, state, self.scales.mean)
        if problem.floating:
            raise NoContinuation(f"{place} {_FREE}; {self.free_body(state.r)}")
        nodes = self._nodes_of(problem)
        if again:
            raise NoContinuation(
                f"{place} the statuses of {nodes} change without end; {self._remedy(problem)}"
            )
        solutions = find_rates(problem, state.status)
        if len(solutions.found) != 1:
            reason = _not_unique(problem, solutions, nodes)
            raise NoContinuation(f"{place} {reason}; {self._remedy(problem)}")
        status, _ = solutions.found[0]
        if not set_statuses(self._S, self.friction, state, self._active, status):
            raise NoContinuation(
                f"{place} {_FREE}, its rates are not unique; {self.free_body(state.r)}"
            )
        if not solutions.complete:
            state.trace[UNPROVEN] += 1

    def _nodes_of(self, problem: RateProblem) -> str:
        """Name the nodes of a rate problem."""
        numbers = problem.numbers
        if not numbers:
            return "open and frictionless nodes"
        return f"nodes {numbers}{in_contact(self.system, numbers)}"

    def _remedy(self, problem: RateProblem) -> str:
        if problem.sliding:
            return (
                f"the body may slide or open as a whole ({self.free_body(self.state.r)}), or "
                "friction is above the critical value there"
            )
        return (
            "often friction is above the critical value A/|B| there, so that a node wedges "
            "itself: lower the friction"
        )


def _not_unique(problem: RateProblem, solutions: Solutions, nodes: str) -> str:
    """Why a rate problem ends the path: it has no solution, or two."""
    if not solutions.found:
        proof = "no rates that obey the law were found"
        if solutions.complete:
            proof = "no rates obey the law"
        return f"{proof}; {nodes} are at their bounds and would jump"
    statuses = [
        str([int(status[node]) for node in problem.numbers]) for status, _ in solutions.found
    ]
    return f"two sets of rates obey the law: {nodes} may take the statuses {' or '.join(statuses)}"
