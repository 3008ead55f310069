"""The exact path of one transient, from corner to corner of the load cycle."""

from time import perf_counter
from typing import Any

import numpy as np

from ...contact import ContactState, ContactSystem, LoadCycle, friction_coefficients, referee
from ...contact.checks import Array, finite_array, finite_number, flag
from ...contact.cycle import checked_cycle
from ...contact.diagnosis import mean_load_diagnosis, pressing
from ...contact.state import checked_state
from ...contact.system import checked_plane
from ...contact.tolerances import NO_DRIVE, RESTART
from ...errors import ModelError, NoContinuation
from .begin import standing
from .kernel import (
    DONE,
    FULL,
    NOT_UNIQUE,
    OPEN,
    STALLED,
    UNSETTLED,
    begin_segment,
    compiled,
    follow,
    new_active_set,
    new_proof,
    new_record,
    new_state,
    refresh,
    set_statuses,
)
from .rate import find_rates, rate_problem
from .scales import scales

__all__ = ["ExactPath"]

_FAR = 1e18  # largest initial stress over the loads: with more, rounding hides the events (1e30 gave wrong results)
_FAR_START = 1e3  # initial stress over the loads, above which an error names it as the cause of a large residual
_ROWS = 256  # events that the record holds before they are moved to the history


class ExactPath:
    """The transient of one contact under one load cycle, from an initial slip or from an earlier state.

    The load path is a chain of straight segments. On each of them slip, gap and reactions are piecewise linear, so the path is followed from event to
    event. There is no time step, and the only error is rounding. The first segment starts at an artificial load that carries the initial slip with
    q = 0 and, at every node, p equal to the mean of |p^w| under the mean load. It ends at the mean load. Then the path visits the corners in their
    order, again and again. From an earlier state, whose nodes may be open, it goes straight on to the corner that comes next.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor of the cycle, >= 0.
    initial_slip
        (N,) slip left from assembly, length; None for none.
    initial_state
        An earlier state, instead of a slip.
    keep
        Whether to keep the states at all events.

    Attributes
    ----------
    state
        The present state, see `State` in `kernel.py`.
    visited
        Number of corners visited so far; -1 until the path reaches the mean load. An earlier state has visited those before its next corner.
    history
        With `keep`: list of tuples of times (T,), `u` and `r` (T, 2N), statuses and work (T, N), after each event and at each corner. The time
        counts the corners visited.
    started
        When it was made, for the record.
    fallbacks
        Number of events at which the iteration on the signs of the rates did not converge.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> from frictopt.transients.exact import ExactPath
    >>> path = ExactPath(rod, cycle, friction=0.5, load_factor=1.0)
    >>> path.start()
    >>> path.run_cycle()
    >>> path.visited, round(float(path.state.u[0]), 6)  # slip of the first node at the second corner
    (2, -0.5)
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: Any,
        load_factor: float,
        initial_slip: Any = None,
        *,
        initial_state: ContactState | None = None,
        keep: bool = False,
    ) -> None:
        self.started = perf_counter()
        nodes = checked_plane(system).nodes
        self.cycle = checked_cycle(cycle)
        slip = np.zeros(nodes) if initial_slip is None else finite_array("initial_slip", initial_slip, (nodes,))
        self.load_factor = finite_number("load_factor", load_factor, least=0.0)
        self.system = system
        self.friction = np.array(friction_coefficients(friction, nodes))
        self.mean = np.concatenate(system.reaction(cycle.mean))
        self._cyclic = [np.concatenate(pair) for pair in zip(*cycle.corner_reactions(system), strict=True)]
        self.corners = self.corners_at(self.load_factor)
        self.force = float(np.abs(self.mean[nodes:]).mean() or max(np.abs(corner).max() for corner in self.corners) or 1.0)
        self._S = np.ascontiguousarray(system.S)
        self.scales = scales(self._S, self.mean, self.corners)
        compiled()
        self.fallbacks, self.visited = 0, -1
        self.history: list[tuple[Array, ...]] = []
        self._active, self._proof = new_active_set(nodes), new_proof(nodes)
        if initial_state is None:
            self._start_name, self._start_stress = "initial_slip", self.check_near("initial_slip", self._S[:, :nodes] @ slip)
            artificial = np.concatenate([np.zeros(nodes), np.full(nodes, self.force)])
            self.state = new_state(np.concatenate([slip, -system.gap]), artificial, np.array(system.gap))
            self.bonded = self.state.r - self._S @ self.state.u
        else:
            if initial_slip is not None:
                raise ModelError("initial_slip, initial_state: both are given; a state has its own slip, give one of the two")
            self._stand_at(checked_state("initial_state", initial_state, nodes, len(self.corners)))
        self._record = new_record(_ROWS if flag("keep", keep) else 0, nodes)

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return self.system.nodes

    def corners_at(self, load_factor: float) -> list[Array]:
        """Bonded reactions (2N,) at the corners of the cycle under a load factor."""
        return [self.mean + load_factor * corner for corner in self._cyclic]

    def check_near(self, name: str, stress: Any) -> float:
        """Check that reactions (2N,) are not so large that their rounding hides the loads; return their ratio to the loads.

        Raises
        ------
        ModelError
            They are larger than 1e18 times the largest load.
        """
        loads = max(self.force, *(float(np.abs(corner).max()) for corner in self.corners))
        most = float(np.abs(stress).max())
        if most > _FAR * loads:
            raise ModelError(
                f"{name}: it stresses the contact {most / loads:.1e} times as much as the loads, so rounding would hide them; "
                f"give one of at most {_FAR:g} times, or check the units"
            )
        return most / loads

    def _stand_at(self, begin: ContactState) -> None:
        self.bonded, self.visited = np.concatenate([begin.bonded_q, begin.bonded_p]), begin.next_corner
        stress = self._S @ np.concatenate([begin.slip, begin.gap - self.system.gap])
        self._start_name, self._start_stress = "initial_state", self.check_near("initial_state", np.r_[stress, self.bonded])
        largest = max(self.force, *(float(np.abs(load).max()) for load in (*self.corners, self.bonded)))
        self.state = standing(self.system, self.friction, begin, largest)

    @property
    def far_start(self) -> bool:
        """Whether the start stresses the contact so much more than the loads do that its rounding may hide them."""
        return self._start_stress > _FAR_START

    @property
    def cause_of_rounding(self) -> str:
        """The cause of large rounding errors, as a sentence."""
        if self.far_start:
            name, stress = self._start_name, self._start_stress
            return f"{name}: it stresses the contact {stress:.1e} times as much as the loads, so rounding hides them; give less"
        return "stiffnesses or loads differ too much in size"

    @property
    def _free_body(self) -> str:
        """The forces of the present state, or the diagnosis of the mean load on the way to it, and the remedy for a free body, as a sentence."""
        q, p = np.split(self.state.r, 2)
        forces = pressing(self.system, self.friction, q, p, self.force)
        mean = f"{mean_load_diagnosis(self.system, self.cycle, self.friction)}; " if self.visited < 0 else ""
        return f"there {forces}; {mean}hold the body by supports, or load it less"

    @property
    def unproven(self) -> int:
        """Number of events whose rates are not proven to be the only ones."""
        return int(self.state.trace[2])

    def start(self) -> None:
        """Follow the path from the artificial load to the mean load; from an earlier state to the end of its cycle."""
        if self.visited < 0:
            self.follow_to(self.mean, "the segment from the initial slip to the mean load")
        elif self.visited > 0:
            self.run_cycle(self.visited)

    def run_cycle(self, first: int = 0) -> None:
        """Follow the path once through all corners of the cycle, or through those from the `first` on."""
        for number, corner in enumerate(self.corners[first:], first):
            self.follow_to(corner, f"the segment to corner {number}")

    def stress(self, u: Array) -> Array:
        """(2N,) reactions `S u` that slip and gap `u = [v, w - g0]` add to the bonded ones."""
        return np.asarray(self._S @ u)

    def restarted_at(self, u: Array) -> "ExactPath | None":
        """A copy at the same load with another slip and gap, (2N,); None if that state violates the contact law."""
        n, copy = self.nodes, object.__new__(ExactPath)
        copy.__dict__.update(self.__dict__, history=[], _record=new_record(0, n))
        r = self.bonded + self.stress(u)
        opened = self.state.status == OPEN
        r[np.r_[opened, opened]] = 0.0
        copy.state = type(self.state)(*(values.copy() for values in self.state))._replace(u=u.copy(), r=r)
        copy.state.u[n:][~opened] = -self.state.gap[~opened]
        copy._active = new_active_set(n)
        verdict = referee(
            self.system,
            (self.bonded[:n], self.bonded[n:]),
            self.friction,
            v=u[:n],
            w=copy.state.u[n:] + self.state.gap,
            q=r[:n],
            p=r[n:],
            force_scale=self.force,
        )
        return copy if verdict.residual <= RESTART else None

    def recorded(self) -> "ExactPath":
        """A copy at the same load and state that keeps the states at all events from here on."""
        n, copy = self.nodes, object.__new__(ExactPath)
        copy.__dict__.update(self.__dict__, history=[], _record=new_record(_ROWS, n), _active=new_active_set(n))
        copy.state = type(self.state)(*(values.copy() for values in self.state))
        return copy

    def follow_to(self, bonded: Array, where: str) -> None:
        """Follow the path in a straight line to other bonded reactions (2N,).

        Raises
        ------
        NoContinuation
            At some load of the segment no rates obey the contact law, or more than one set of rates does.
        """
        load_rate = bonded - self.bonded
        settled = not np.any(np.abs(load_rate) > NO_DRIVE * np.tile(self.scales.mean, 2))
        begin_segment(self._S, self.friction, self.state, self._active, self._proof)
        code, time = UNSETTLED, 0.0
        while code != DONE:
            own = self.state, self._active, self._proof
            code, time = follow(self._S, self.friction, self.bonded, load_rate, *own, self.scales.mean, time, settled, self._record)
            if code == STALLED:
                raise NoContinuation(f"{where}: at {time:.9g} of it the statuses change without end; loads or gaps may differ too much in size")
            settled = True
            if code == FULL:
                self._move_record()
            elif code != DONE:
                self._solve_rate_problem(load_rate, code == NOT_UNIQUE, time, where)
        refresh(self._S, self.friction, bonded, self.state, self._active)
        self._move_record()
        self.bonded = bonded
        self.visited += 1
        if len(self._record.time):
            state = self.state
            self.history.append((np.array([float(self.visited)]), *(values[None].copy() for values in (state.u, state.r, state.status, state.work))))

    def _move_record(self) -> None:
        """Move the recorded states to the history."""
        record = self._record
        used = int(record.used[0])
        if used:
            self.history.append((self.visited + record.time[:used], *(values[:used].copy() for values in record[1:5])))
            record.used[0] = 0

    def _solve_rate_problem(self, load_rate: Array, not_unique: bool, time: float, where: str) -> None:
        """Set the statuses to the solution of the rate problem."""
        problem = rate_problem(self._S, self.friction, load_rate, self.state, self.scales.mean)
        if problem.floating:
            raise NoContinuation(f"{where}: at {time:.9g} of it the contact slides or opens freely; {self._free_body}")
        solutions = find_rates(problem, self.state.status)
        nodes = sorted(set(problem.node.tolist()))
        here = f"{where}: at {time:.9g} of it"
        hint = "often friction is above the critical value there (a node wedges itself where f exceeds A/|B|): lower it"
        if problem.sliding:
            hint = f"the body may slide or open as a whole ({self._free_body}), or friction is above the critical value there"
        if not solutions.found:
            proof = "no rates obey the law" if solutions.complete else "no rates that obey the law were found"
            raise NoContinuation(f"{here} {proof}; nodes {nodes} are at their bounds and would jump; {hint}")
        if len(solutions.found) > 1:
            both = " or ".join(str([int(status[node]) for node in nodes]) for status, _ in solutions.found)
            raise NoContinuation(f"{here} two sets of rates obey the law: nodes {nodes} may take the statuses {both}; {hint}")
        if not set_statuses(self._S, self.friction, self.state, self._active, solutions.found[0][0]):
            raise NoContinuation(f"{here} the contact slides or opens freely, its rates are not unique; {self._free_body}")
        self.fallbacks += not not_unique
        self.state.trace[2] += not solutions.complete
