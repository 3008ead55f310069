"""A transient followed exactly, corner by corner."""

from typing import Any

import numpy as np

from ..contact import ContactSystem, LoadCycle, friction_coefficients, referee
from ..contact.checks import Array, finite_array, finite_number, flag
from ..contact.cycle import checked_cycle
from ..contact.mirror import MirrorHalf, mirror_half
from ..contact.system import checked_system
from ..errors import ModelError, NoContinuation
from .active import OPEN, new_active_set
from .halved import Halved
from .proof import clear_proof, new_proof
from .rate import find_rates, rate_problem
from .segment import DONE, FULL, STALLED, Record, follow, new_record
from .settle import TWOFOLD, UNSETTLED, State, impose, refresh, turn

__all__ = ["ExactPath"]

_LAWFUL = 1e-10  # residual of a state from which a path may be taken up
_NO_DRIVE = 1e-15  # change of the bonded reactions, over the force scale, that moves nothing
_WORTH = 60  # nodes from which on half of them saves more time than the change to and fro takes
_NOTHING = np.zeros((0, 0))  # the motions of the whole contact that leave a symmetry which is not asked for
_FAR = 1e18  # times the loads, from where the last events before them are still told apart; paths from 1e30 times as far went wrong unnoticed
_ROWS = 256  # events that the record holds before they are moved to the history


class ExactPath:
    """The transient of one contact under one load cycle, from an initial slip on.

    Between two load corners the loads are linear, so slip, gap and reactions are piecewise linear in them: the path is followed from event to
    event, with no time step and no error but rounding. It starts at the artificial load that carries the initial slip with q = 0 and, at every node,
    p equal to the mean of |p^w| under the mean load, goes in a straight line to the mean load, and then visits the corners again and again.

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
    keep
        Whether to keep the states at all events.
    simplify
        Whether to follow only half of a contact that is mirror-symmetric with its loads and its initial slip, wherever the path is proven to keep the
        symmetry. Two events that the symmetry makes simultaneous are then one. States are those of the whole contact in any case.

    Attributes
    ----------
    state
        Where the path is, see `State`.
    visited
        Number of corners visited, -1 before the mean load is reached.
    history
        With `keep`: pieces of times (T,), `u`, `r` (T, 2N), statuses and work (T, N) after each event and at each corner; the time counts the
        corners visited.
    fallbacks
        Number of events at which the iteration on the signs did not find the rates.
    ways, half_ways
        Number of straight ways followed, and of those on which half of the contact was enough.

    Raises
    ------
    ModelError
        Bad input.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: Any,
        load_factor: float,
        initial_slip: Any = None,
        *,
        keep: bool = False,
        simplify: bool = True,
    ) -> None:
        nodes = checked_system(system).nodes
        checked_cycle(cycle)
        slip = np.zeros(nodes) if initial_slip is None else finite_array("initial_slip", initial_slip, (nodes,))
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        self.system = system
        self.friction = np.array(friction_coefficients(friction, nodes))
        self.mean = np.concatenate(system.reaction(cycle.mean))
        self._cyclic = [np.concatenate(pair) for pair in zip(*cycle.corner_reactions(system), strict=True)]
        self.corners = self.corners_at(load_factor)
        self.force = float(np.abs(self.mean[nodes:]).mean() or max(np.abs(corner).max() for corner in self.corners) or 1.0)
        self.state = State(
            u=np.concatenate([slip, -system.gap]),
            r=np.concatenate([np.zeros(nodes), np.full(nodes, self.force)]),
            gap=np.array(system.gap),
            status=np.zeros(nodes, dtype=np.int8),
            work=np.zeros(nodes),
            trace=np.zeros(3, dtype=np.int64),
        )
        self.fallbacks = self.ways = self.half_ways = 0
        self.visited = -1
        self.history: list[tuple[Array, ...]] = []
        self._S = np.ascontiguousarray(system.S)
        self._active, self._proof = new_active_set(nodes), new_proof(nodes, 1)
        self.check_near("initial_slip", self._S[:, :nodes] @ slip)
        self.bonded: Array = self.state.r - self._S @ self.state.u
        rows = _ROWS if keep else 0
        self._record = new_record(rows, nodes)
        worth = flag("simplify", simplify) and nodes >= _WORTH
        half = mirror_half(system, self.friction) if worth else None
        self._half = None if half is None else Halved(half, self.friction, self.force, rows)

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return self.system.nodes

    def corners_at(self, load_factor: float) -> list[Array]:
        """Bonded reactions (2N,) at the corners of the cycle under a load factor."""
        return [self.mean + load_factor * corner for corner in self._cyclic]

    def check_near(self, name: str, stress: Array) -> None:
        """Check that reactions (2N,) at which the path starts or turns leave something of the loads in the rounding on the way back.

        Raises
        ------
        ModelError
            They are larger than 1e18 times the largest load.
        """
        loads = max(self.force, *(float(np.abs(corner).max()) for corner in self.corners))
        most = float(np.abs(stress).max())
        if most > _FAR * loads:
            raise ModelError(
                f"{name}: it stresses the contact {most / loads:.1e} times as much as the loads, which rounding hides then; "
                f"give one of at most {_FAR:g} times, or check the units"
            )

    @property
    def unproven(self) -> int:
        """Number of events whose rates are not proven to be the only ones."""
        return int(self.state.trace[2])

    @property
    def left_out(self) -> tuple[str, ...]:
        """What the scene did not need, in words."""
        if not self.half_ways:
            return ()
        nodes = f"{(self.nodes + 1) // 2} of {self.nodes} nodes were followed"
        return (f"mirror symmetry: v is odd, {nodes}" + (f" on {self.half_ways} of {self.ways} ways" if self.half_ways < self.ways else ""),)

    def start(self) -> None:
        """Follow the path from the artificial load to the mean load."""
        self.go(self.mean, "the way from the initial slip to the mean load")

    def run_cycle(self) -> None:
        """Follow the path once through all corners of the cycle."""
        for number, corner in enumerate(self.corners):
            self.go(corner, f"the way to corner {number}")

    def stress(self, u: Array) -> Array:
        """(2N,) reactions `S u` that slip and gap `u = [v, w - g0]` add to the bonded ones."""
        return np.asarray(self._S @ u)

    def moved(self, u: Array) -> "ExactPath | None":
        """A copy that stands at the same load with another slip and gap, (2N,); None if the law does not allow it there."""
        n, copy = self.nodes, object.__new__(ExactPath)
        copy.__dict__.update(self.__dict__, history=[], _record=new_record(0, n))
        r = self.bonded + self.stress(u)
        opened = self.state.status == OPEN
        r[np.r_[opened, opened]] = 0.0
        copy.state = self.state._replace(u=u.copy(), r=r, status=self.state.status.copy(), work=self.state.work.copy(), trace=self.state.trace.copy())
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
        return copy if verdict.residual <= _LAWFUL else None

    def go(self, bonded: Array, where: str) -> None:
        """Follow the path in a straight line to other bonded reactions (2N,).

        Raises
        ------
        NoContinuation
            No rates obey the law at some load on the way, or more than one set of rates does.
        """
        drive = bonded - self.bonded
        settled = not np.abs(drive).max() > _NO_DRIVE * self.force
        done, time = False, 0.0
        if self._half is not None and self._half.fits(self.state, drive, bonded):
            done, time = self._half.go(self.state, drive, bonded, settled, self._keep)
        if not done:
            self._go_whole(drive, bonded, time, settled and time == 0, where)
        self.ways, self.half_ways = self.ways + 1, self.half_ways + done
        self.bonded = bonded
        self.visited += 1
        if len(self._record.time):
            state = self.state
            self.history.append((np.array([float(self.visited)]), *(values[None].copy() for values in (state.u, state.r, state.status, state.work))))

    def _go_whole(self, drive: Array, bonded: Array, time: float, settled: bool, where: str) -> None:
        """Follow the whole contact from the share `time` of the way on."""
        turn(self._S, self.friction, self.state, self._active)
        clear_proof(self._proof)
        code = UNSETTLED
        while code != DONE:
            own = self.state, self._active, self._proof
            code, time = follow(self._S, _NOTHING, self.friction, drive, *own, self.force, time, settled, self._record)
            if code == STALLED:
                raise NoContinuation(
                    f"{where}: at {time:.9g} of it the path changes its status without end; loads or gaps may differ too much in size"
                )
            settled = True
            if code == FULL:
                self._keep(self._record)
            elif code != DONE:
                self._decide(drive, code == TWOFOLD, time, where)
        refresh(self._S, self.friction, bonded, self.state, self._active)
        self._keep(self._record)

    def _keep(self, record: Record, half: MirrorHalf | None = None) -> None:
        """Move what a record holds to the history."""
        used = int(record.used[0])
        if used:
            u, r, status, work = (values[:used].copy() for values in record[1:5])
            if half is not None:
                u, r, status, work = half.whole_motion(u), half.whole_forces(r), half.whole_status(status), half.whole_even(work)
            self.history.append((self.visited + record.time[:used], u, r, status, work))
            record.used[0] = 0

    def _decide(self, drive: Array, twofold: bool, time: float, where: str) -> None:
        """Settle the statuses by the rate problem."""
        problem = rate_problem(self._S, self.friction, drive, self.state, self.force)
        if problem.floating:
            raise NoContinuation(f"{where}: at {time:.9g} of it the contact slides or opens freely; hold the punch, or load it less")
        solutions = find_rates(problem, self.state.status)
        nodes = sorted(set(problem.node.tolist()))
        here = f"{where}: at {time:.9g} of it"
        hint = "often friction is above the critical value there (a node wedges itself where f exceeds A/|B|): lower it"
        if problem.sliding:
            hint = "the body may slide or open as a whole (hold it, or load it less), or friction is above the critical value there"
        if not solutions.found:
            proof = "no rates obey the law" if solutions.complete else "no rates that obey the law were found"
            raise NoContinuation(f"{here} {proof}; nodes {nodes} are at their bounds and would jump; {hint}")
        if len(solutions.found) > 1:
            both = " or ".join(str([int(status[node]) for node in nodes]) for status, _ in solutions.found)
            raise NoContinuation(f"{here} two sets of rates obey the law: nodes {nodes} may take the statuses {both}; {hint}")
        if not impose(self._S, self.friction, self.state, self._active, solutions.found[0][0]):
            raise NoContinuation(f"{here} the contact slides or opens freely, its rates are not unique; hold the punch, or load it less")
        self.fallbacks += not twofold
        self.state.trace[2] += not solutions.complete
