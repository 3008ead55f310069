"""The steady state of a transient in three dimensions, by cycles with extrapolation."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from ..contact import LoadCycle
from ..contact.answers import Outcome
from ..contact.checks import Array, finite_number, frozen, whole_number
from ..contact.extrapolation import SLOW, drift_text, fixed_point
from ..contact.record import Recorded, SolveRecord
from ..contact.show import Plotted, frame
from ..contact.tolerances import LEVEL, NO_SLIP, PERIODIC, RESIDUAL, ROUNDING
from ..errors import NoContinuation, SolverError
from .coulomb import referee
from .newton import OPEN
from .system import ContactSystem3D, parted
from .transient import Point3D, Transient3D, checked_steps

__all__ = ["SteadyState3D", "steady_state"]

_LEAST, _WINDOW = 4, 12  # cycles before the first extrapolation, and cycles that one looks back on
_ROUNDS = 6  # extrapolations in a row, each from the cycles that follow the one before


@dataclass(frozen=True, eq=False, repr=False)
class SteadyState3D(Recorded, Plotted):
    """The steady state that a transient reaches in increments, confirmed by a cycle that starts from it and comes back.

    Attributes
    ----------
    outcome
        The long-run behaviour.
    dissipation
        Work of friction per cycle in the steady state, >= 0, force times length; exactly 0 after shakedown.
    dissipation_per_node
        (N,) work of friction per cycle at each node.
    slip
        (N, 2) slip at the last corner of the cycle, length (for ratcheting: after the last cycle that was followed).
    open
        (N,) whether the node is open at some increment of the steady cycle.
    slipping
        (N,) whether the node slides against friction in the steady cycle, by more than 1e-9 slip scales of the mean pressure.
    first_cycle
        Work of friction in the first cycle (of the load cycle itself, not of an overload).
    cycles
        Number of cycles followed.
    record
        How it was found. Its `residual` is the larger of the violation of the contact law in the confirming cycle and the change of slip over it;
        forces are in units of the largest nodal force of the load cycle, slips in units of that force over the stiffness scale. At most 1e-9.
    step_error
        Difference of the dissipation from what half as many increments give, over the larger of the two: an estimate of the error in
        time, no bound.
    extrapolated
        True if the state is an extrapolated limit of the cycles, False if the transient reached it cycle by cycle.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem3D(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> steady = fo.steady_state(node, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), friction=0.5, load_factor=1.0)
    >>> steady.outcome.name, round(steady.dissipation, 9)
    ('CYCLIC_SLIP', 1.0)
    """

    engine: ClassVar[str] = "newton"

    outcome: Outcome
    dissipation: float
    dissipation_per_node: Array
    slip: Array
    open: np.ndarray[Any, np.dtype[np.bool_]]
    slipping: np.ndarray[Any, np.dtype[np.bool_]]
    first_cycle: float
    cycles: int
    record: SolveRecord
    step_error: float
    extrapolated: bool
    _system: ContactSystem3D = field(repr=False)

    def to_frame(self) -> Any:
        """The DataFrame of the nodes: columns node, x, y, z, slip1, slip2, open, dissipation (work of friction per cycle)."""
        columns = dict(zip("xyz", self._system.points.T, strict=True)) | {"slip1": self.slip[:, 0], "slip2": self.slip[:, 1], "open": self.open}
        return frame({"node": range(len(self.slip)), **columns, "dissipation": self.dissipation_per_node})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("outcome", "dissipation", "cycles", "residual", "step_error")}


def steady_state(
    system: ContactSystem3D,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    overload: float | None = None,
    most_cycles: int = 500,
    steps: int = 20,
) -> SteadyState3D:
    """Follow a transient in increments until a cycle comes back to where it began.

    The limit of the cycles is extrapolated from the last ones (reduced-rank extrapolation, Sidi 2017), and accepted only where a cycle from it comes
    back to it; otherwise the transient goes on. The increments are those of `march`; half as many tell `step_error`.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        (N, 2) residual slip from assembly, length; None: no slip.
    overload
        Load factor of one extra cycle before all others, >= 0; None: no such cycle.
    most_cycles
        Number of cycles after which to give up.
    steps
        Number of increments from corner to corner, even.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        No cycle comes back within `most_cycles`.
    SolverError
        An increment has no valid answer, or the states violate the contact law by more than the tolerance.
    """
    start = perf_counter()
    whole_number("most_cycles", most_cycles, least=1)
    extra = None if overload is None else finite_number("overload", overload, least=0.0)
    fine, coarse = (
        _Run(Transient3D(system, cycle, friction, load_factor, initial_slip, "newton", number), extra, most_cycles)
        for number in (checked_steps(steps), steps // 2)
    )
    found = fine.steady()
    outcome, last, extrapolated = found
    work, other = float(last.work.sum()), coarse.steady()
    half = 0.0 if other[0] is Outcome.SHAKEDOWN else float(other[1].work.sum())
    none = outcome is Outcome.SHAKEDOWN
    work = 0.0 if none else work
    residual = max(fine.violation(last), 0.0 if outcome is Outcome.RATCHETING else last.change)
    if not residual <= RESIDUAL:
        raise SolverError(
            f"steady state: the states violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g}); bring the loads of the cycle, or the "
            "initial slip and the loads, closer together in size"
        )
    opened, path = last.open.copy(), fine._transient
    opened.flags.writeable = False
    return SteadyState3D(
        outcome=outcome,
        dissipation=work,
        dissipation_per_node=frozen(np.zeros(system.nodes) if none else last.work),
        slip=frozen(last.after),
        open=opened,
        slipping=(path.friction > 0) & (last.way > max(NO_SLIP * path.pressure / path.force, ROUNDING) * path.length) & (not none),
        first_cycle=fine.first,
        cycles=fine.cycles,
        record=SolveRecord("NEWTON", (), residual, (), perf_counter() - start),
        step_error=abs(work - half) / max(work, half) if max(work, half) > 0 else 0.0,
        extrapolated=extrapolated,
        _system=system,
    )


@dataclass(frozen=True, eq=False)
class _Cycle:
    """One cycle: work of friction and way slid per node, slip before and after and its change in slip scales, what opens, last reactions, states."""

    work: Array
    way: Array
    before: Array
    after: Array
    change: float
    open: np.ndarray
    end: Array
    states: tuple[Array, ...]


class _Run:
    """The cycles of one transient."""

    def __init__(self, transient: Transient3D, overload: float | None, most: int) -> None:
        self._transient, self._overload, self._most = transient, overload, most
        self.cycles, self.first = 0, np.nan

    def steady(self) -> tuple[Outcome, _Cycle, bool]:
        """The outcome, a cycle of the steady state, and whether it is extrapolated."""
        path = self._transient
        for load in [path.mean, *(path.corners_at(self._overload) if self._overload is not None else ())]:
            for _ in path.follow_to(load):
                pass
        last = self._cycle()  # it starts at the mean load and not at the last corner, and says nothing of those to come
        self.first, iterates = float(last.work.sum()), [last.after.ravel()]
        before, pause = last, _LEAST
        while self.cycles < self._most:
            before, last = last, self._cycle()
            iterates = [*iterates[-_WINDOW:], last.after.ravel()]
            outcome = self._outcome(before, last)
            if outcome is not None:
                return outcome, last, False
            pause -= 1
            if pause <= 0 and (found := self._extrapolated(iterates)):
                return *found, True
            pause = pause if pause > 0 else len(iterates)
        text = f"the slip still changes by {last.change:.1e} slip scales a cycle; give more cycles"
        if len(iterates) > _LEAST:  # an extrapolation failed
            decay = float(np.abs((last.after - last.before) - (before.after - before.before)).max()) / path.length / last.change
            text = drift_text(last.change, decay) if decay < SLOW else text
        raise NoContinuation(f"steady state: no cycle comes back within most_cycles = {self._most}; {text}")

    def _cycle(self) -> _Cycle:
        path, before = self._transient, self._transient.state.slip
        previous, points = before, list[Point3D]()
        for corner in path.corners:
            points += path.follow_to(corner)
        self.cycles += 1
        states = tuple(np.array([getattr(point, name) for point in points]) for name in ("bonded", "slip", "gap", "q", "p"))
        work, way = (np.sum([getattr(point, name) for point in points], axis=0) for name in ("work", "way"))
        after = points[-1].slip
        opened = np.any([point.status == OPEN for point in points], axis=0)
        change = float(np.abs(after - before).max()) / path.length
        return _Cycle(work, way, previous, after, change, opened, np.r_[points[-1].q.ravel(), points[-1].p], states)

    def _outcome(self, before: _Cycle, last: _Cycle) -> Outcome | None:
        """What a cycle shows; None if it does not come back."""
        path = self._transient
        if last.change <= PERIODIC:
            slid = float(last.way.max()) / path.length
            if slid <= max(NO_SLIP * path.pressure / path.force, ROUNDING):
                return Outcome.SHAKEDOWN
            if last.change <= LEVEL * slid:  # so that the work is right to this share, however small the slips are beside the largest force
                return Outcome.CYCLIC_SLIP
        drift = np.abs((last.after - last.before) - (before.after - before.before)).max() / path.length
        if max(drift, float(np.abs(last.end - before.end).max()) / path.force) <= PERIODIC:
            return Outcome.RATCHETING
        return None

    def _extrapolated(self, iterates: list[Array]) -> tuple[Outcome, _Cycle] | None:
        """A cycle from an extrapolated limit that comes back; else None, and the transient is where it was."""
        path, kept = self._transient, self._transient.state
        for _ in range(_ROUNDS):
            try:
                path.moved_to(fixed_point(np.array(iterates)).reshape(path.state.slip.shape))
                before = self._cycle()
                outcome = self._outcome(before, before) if before.change <= PERIODIC else None
                if outcome is not None:
                    return outcome, before
                iterates = [before.before.ravel(), before.after.ravel(), *(self._cycle().after.ravel() for _ in range(_LEAST))]
            except SolverError:
                break
        path.state = kept
        return None

    def violation(self, cycle: _Cycle) -> float:
        """Violation of the contact law by the states of a cycle."""
        path, (bonded, v, w, q, p) = self._transient, cycle.states
        previous = np.concatenate([cycle.before[None], v[:-1]])
        loads = parted(bonded)
        return referee(path.system, loads, path.friction, v=v, w=w, q=q, p=p, previous_slip=previous, force_scale=path.force).residual
