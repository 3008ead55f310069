"""Wear of a contact in many load cycles, computed in jumps of cycles between steady states."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from ..base import (
    Array,
    Bar,
    PerNode,
    Plotted,
    Recorded,
    SolveRecord,
    finite_number,
    frozen,
    progress_bar,
    warns_of_odd_values,
)
from ..base.checks import per_node
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_round,
    checked_width,
    friction_coefficients,
    joined,
    parted,
)
from ..contact.diagnosis import in_contact
from ..errors import ModelError, NoContinuation, SolverError
from ..transients import SteadyState, steady_state
from ..transients.march import path_of
from ..transients.steady import settled_from

# The course of wear: the contact as it is worn so far, and its next jump of load cycles.

# Numbers of the jumps.

# A contact is worn in if its work of friction per cycle falls to this share of its largest.
WORN_IN = 1e-3
# With this parameter of the Rosenbrock method, fast changes decay without oscillation.
_GAMMA = 1 - 1 / np.sqrt(2)
# Rates that remain after this number of cycles count as constant. The unit is the number of cycles
# in which the stiffest node loses its pressure.
_FAR = 1e6
# Largest and smallest growth of the length of a jump. Of the growth that the error estimate allows,
# only the share `_SAFETY` is used.
_LARGEST_GROWTH = 4.0
_SMALLEST_GROWTH = 0.2
_SAFETY = 0.9
# Largest number of attempts at a jump; each is shorter than the one before.
_ATTEMPTS = 20


class Course:
    """A contact while it wears, between two jumps of many load cycles.

    Attributes
    ----------
    per_work, tolerance
        (N,) depth per work of friction, and tolerance of a jump.
    settle
        Function that follows a worn contact from a state to its steady state.
    steady, began
        The steady state, and the state from which it was followed.
    cycles, length
        Number of load cycles so far, and number of load cycles of the next jump.
    rows, started
        Rows of the history, for the unworn contact and after each jump; and the time of the start.
    """

    def __init__(
        self,
        per_work: Array,
        tolerance: float,
        settle: Callable[[ContactSystem, ContactState | None], SteadyState],
        steady: SteadyState,
        began: ContactState | None,
    ) -> None:
        self.per_work = per_work
        self.tolerance = tolerance
        self.settle = settle
        self.steady = steady
        self.began = began
        self.cycles = 0.0
        self.rows = list[dict[str, Any]]()
        self.started = perf_counter()
        self._unworn_gap = steady.system.gap
        self._add_row()
        fastest = float(self.damping.diagonal().max())
        self.length = float(np.sqrt(tolerance)) / fastest if fastest > 0 else np.inf

    def _add_row(self) -> None:
        """Add the row of the contact as it is worn now."""
        steady, system, state = self.steady, self.steady.system, self.steady.state
        assert system.width is not None
        u = joined(state.slip, state.gap - system.gap)
        p = state.bonded_p + (system.S @ u)[-system.nodes :]
        depth = system.gap - self._unworn_gap
        sticks = ~(steady.slipping | steady.open)
        self.rows.append(
            {
                "cycles": self.cycles,
                "work": steady.dissipation,
                "largest_depth": float(depth.max()),
                "volume": float(depth @ system.width),
                "slipping": int(steady.slipping.sum()),
                "stick_width": float(system.width[sticks].sum()),
                "outcome": steady.outcome.name,
                "depth": depth,
                "pressure": np.where(state.gap > 0, 0.0, p) / system.width,
                "residual": steady.residual,
            }
        )

    def rate(self, steady: SteadyState) -> Array:
        """(N,) depth per cycle."""
        return self.per_work * steady.dissipation_per_node

    @property
    def damping(self) -> Array:
        """(N, N) decrease of the rate with the depths, because depths reduce the pressure."""
        steady = self.steady
        per_pressure = self.per_work * steady.friction * steady.sliding_distance
        return per_pressure[:, None] * steady.system.C

    def after(self, depth: Array) -> tuple[SteadyState, ContactState]:
        """The steady state after a further depth has been worn off, and the state it starts from.

        The transient starts from the current state, which stays in equilibrium: the bonded
        reactions grow by the forces that the depth carried.
        """
        state = self.steady.state
        worn = self.steady.system.with_gap(self.steady.system.gap + depth)
        q, p = parted(worn.pressing_shut(depth), worn.tangents + 1)
        began = replace(state, bonded_q=state.bonded_q + q, bonded_p=state.bonded_p + p)
        return self.settle(worn, began), began

    def jump(self, most_cycles: float) -> None:
        """Make the next jump, as long as the tolerance allows, up to `most_cycles` in all.

        The jump is a step of a linearly implicit Rosenbrock method of second order. The first stage
        of this step is a step of first order, which estimates the error.
        """
        rate, damping = self.rate(self.steady), self.damping
        for _ in range(_ATTEMPTS):
            cycles = min(self.cycles + self.length, most_cycles)
            length = cycles - self.cycles
            implicit = np.eye(len(rate)) + _GAMMA * length * damping
            first = np.maximum(np.linalg.solve(implicit, rate), 0.0)
            middle, _began = self.after(length * first)
            second = np.linalg.solve(implicit, self.rate(middle) - 2 * first)
            depth = np.maximum(length * (1.5 * first + 0.5 * second), 0.0)

            difference = float(np.abs(depth - length * first).max())
            largest_depth = float((self.rows[-1]["depth"] + depth).max())
            error = difference / (self.tolerance * largest_depth)
            self.length = length * _growth(error)
            if error <= 1:
                self.steady, self.began = self.after(depth)
                self.cycles = cycles
                self._add_row()
                return
        raise SolverError(
            f"wear: after {self.cycles:.6g} cycles a jump of {length:.1e} is too long for the "
            f"tolerance {self.tolerance:g}; allow more"
        )

    def end(self, most_cycles: float) -> str:
        """Why the history ends here, in words; "" if it goes on."""
        work = self.steady.dissipation
        largest = max(row["work"] for row in self.rows)
        rate = self.rate(self.steady)
        if work == 0 and largest == 0:
            return "the contact does not slip, and does not wear"
        if work == 0:
            return "worn in: the contact no longer slips"
        if not rate.any():
            return "no node that slips has a coefficient of wear above 0"
        if self.cycles >= most_cycles:
            return f"{most_cycles:.6g} cycles are over"
        if np.isfinite(most_cycles):
            return ""
        if work <= WORN_IN * largest:
            return f"worn in: the work of friction per cycle is {work / largest:.1e} of its largest"
        if self._never_changes(rate):
            return (
                "the contact continues to wear at constant rates, which do not change any "
                "pressure; give `cycles`"
            )
        return ""

    def _never_changes(self, rate: Array) -> bool:
        """Whether the rates (N,) stay the same after wear has relieved all pressure that it can."""
        damping = self.damping
        cycles = _FAR / (np.abs(damping).max() or 1.0)
        late = np.linalg.solve(np.eye(len(rate)) + cycles * damping, rate)
        return bool(np.abs(late - rate).max() <= self.tolerance * rate.max())


def _growth(error: float) -> float:
    """Length of the next jump or attempt, divided by the length of a jump with this error."""
    if error == 0:
        return _LARGEST_GROWTH
    growth = _SAFETY / np.sqrt(error)
    return float(np.clip(growth, _SMALLEST_GROWTH, _LARGEST_GROWTH))


ONE_FRICTION = (
    "wear needs true sliding distances, so give the system that it was made of, with the same "
    "friction along both tangents"
)
"""The remedy of an error about orthotropic friction."""


class Worn(Recorded, Plotted):
    """Base of results that have a worn contact in a steady state."""

    steady: SteadyState

    @property
    def system(self) -> ContactSystem:
        """The worn contact."""
        return self.steady.system

    @property
    def state(self) -> ContactState:
        """The state at the last corner of the steady cycle, where another transient may start."""
        return self.steady.state


@dataclass(frozen=True, eq=False, repr=False)
class WearHistory(Worn):
    """A contact while it wears: its steady states before the first jump and after each one.

    Theory, eq. (29).

    Attributes
    ----------
    steady
        The last steady state. Its `system` is the worn contact, which all other functions accept.
        In space, if an error ended the history, its `step_error` is inf.
    depth, pressure
        (J + 1, N) depth worn off at each node since the beginning, both bodies together, length;
        and pressure (normal force divided by width) at the last corner of the steady cycle.
    reason, record
        The reason for the end of the history, in words, and the record of the solution; `residual`
        is the largest residual of all steady states.

    Examples
    --------
    >>> import frictopt as fo
    >>> cylinder = {"nodes": 32, "half_length": 1.0, "E_star": 1e5, "R": 100.0}  # N and mm
    >>> arrays = fo.reference.half_plane_contact(**cylinder)
    >>> system = fo.ContactSystem.from_blocks(**arrays, width=[2 / 32] * 32)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> history = fo.joints.wear(
    ...     system, cycle, 0.5, load_factor=100.0, coefficient=1e-8, cycles=1e5
    ... )
    >>> history.reason, f"{history.volume:.2e}"
    ('100000 cycles are over', '3.14e-05')
    >>> history.to_frame()[["slipping", "stick_width", "outcome"]].tail(1)
        slipping  stick_width      outcome
    10         8          1.0  CYCLIC_SLIP
    """

    steady: SteadyState
    depth: Array
    pressure: Array
    reason: str
    record: SolveRecord
    _table: pd.DataFrame

    @property
    def cycles(self) -> Array:
        """(J + 1,) number of load cycles so far: 0 before the first jump, then after each jump.

        Jumps do not end at whole cycles.
        """
        return frozen(self._table["cycles"])

    @property
    def volume(self) -> float:
        """Volume worn off at the end of the history (per depth in the plane)."""
        return float(self._table["volume"].iloc[-1])

    @property
    def worn_in(self) -> bool:
        """Whether slip has stopped, or its work per cycle is a thousandth of the largest."""
        work = self._table["work"]
        return bool(work.iloc[-1] <= WORN_IN * work.max())

    def to_frame(self) -> pd.DataFrame:
        """A row for the unworn contact, and a row after each jump.

        Columns: cycles; work, of friction per cycle; largest_depth and volume worn off so far;
        slipping, number of nodes that slip; stick_width, length (area in space) of the nodes that
        neither slip nor open; outcome, the name of an `Outcome`.
        """
        return self._table.copy()

    def _answer(self) -> Mapping[str, object]:
        last = self._table.iloc[-1]
        return {
            "jumps": len(self._table) - 1,
            "cycles": float(last["cycles"]),
            "work_per_cycle": float(last["work"]),
            "largest_depth": float(last["largest_depth"]),
            "volume": float(last["volume"]),
            "reason": self.reason,
        }


@warns_of_odd_values
def wear(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    coefficient: PerNode,
    cycles: float | None = None,
    initial_state: ContactState | None = None,
    tolerance: float = 0.01,
    steps: int | None = None,
    progress: bool = True,
) -> WearHistory:
    """Follow a contact while it wears, in jumps of many load cycles between steady states.

    In each steady cycle node i loses the depth `coefficient / width_i` times the integral of `p_i
    |dv_i|` (Archard). This integral is the node's work of friction divided by its coefficient of
    friction. A surface that shears at its strength also wears in proportion to this work. Depths
    are added to the gap. The bodies remain elastic and their stiffness does not change, so depths
    must be small relative to the contact. A jump is a step of a linearly implicit Rosenbrock method
    of second order. It is implicit because wear lowers the pressure, which slows down the wear
    within the jump. The length of a jump follows from an estimate of its error. After each jump the
    transient continues from the last state, with the worn depth added to the gap, to the next
    steady state. This state has to pass the usual checks. Theory, eq. (29).

    Without `cycles` the history ends when the contact is worn in: when it no longer slips, or its
    work of friction per cycle is a thousandth of the largest. The history also ends once wear no
    longer changes any pressure: from then on wear goes on at constant rates.

    Parameters
    ----------
    system, cycle, friction
        The contact, which needs its `width`; its load cycle; and its coefficient of friction, one
        or one per node.
    load_factor
        Load factor, >= 0.
    coefficient
        Archard's coefficient of wear of both bodies together, volume per normal force and sliding
        distance, >= 0; one value, or one per node. With N and mm, 1e-8 means 1e-8 mm^3/(N mm). The
        value depends on the units, see the tutorial. If you know the wear volume per work of
        friction instead, multiply it by the coefficient of friction.
    cycles
        Number of load cycles, >= 1; None: until the contact is worn in.
    initial_state
        Initial state; None: no slip. To continue an earlier history, give its `state` and its
        `system`.
    tolerance
        Largest estimated error of the depth that a jump adds, relative to the largest depth at its
        end. The estimate uses a method of first order. The tolerance does not bound the error of
        the whole history, to which all jumps contribute. The error of most histories is below the
        tolerance; some have an error several times larger. To check, repeat the history with a
        quarter of the tolerance.
    steps, progress
        Number of increments from corner to corner, see `steady_state`, and whether to show the
        progress after two seconds.

    Returns
    -------
    WearHistory
        Depth, pressure and work after each jump.

    Raises
    ------
    ModelError
        Bad input, a contact without width, or a node with a coefficient of wear and without
        friction, whose wear does not follow from its work.
    NoContinuation, SolverError
        A worn contact has no steady state, or its steady state does not pass the checks. If wear
        has begun, the attribute `history` of the error, or of a KeyboardInterrupt (Ctrl-C), holds
        the history so far.

    Notes
    -----
    Jumps: Verwer, Spee, Blom & Hundsdorfer 1999, SIAM J. Sci. Comput. 20, 1456-1480. Wear: Archard
    1953, J. Appl. Phys. 24, 981-988; by energy: Fouvry, Kapsa & Vincent 1996, Wear 200, 186-205.

    Examples
    --------
    >>> import frictopt as fo
    >>> cylinder = {"nodes": 32, "half_length": 1.0, "E_star": 1e5, "R": 100.0}  # N and mm
    >>> arrays = fo.reference.half_plane_contact(**cylinder)
    >>> system = fo.ContactSystem.from_blocks(**arrays, width=[2 / 32] * 32)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> history = fo.joints.wear(system, cycle, friction=0.5, load_factor=100.0, coefficient=1e-8)
    >>> f"{history.cycles[-1]:.1e} cycles, {1e3 * history.depth[-1].max():.2f} micrometres"
    '2.2e+06 cycles, 0.61 micrometres'
    >>> history.worn_in
    True
    """
    checked_round(system, ONE_FRICTION)
    per_work = _depth_per_work(system, friction, coefficient)
    most_cycles = np.inf if cycles is None else finite_number("cycles", cycles, least=1.0)
    tolerance = finite_number("tolerance", tolerance, above=0.0)

    def settle(worn: ContactSystem, state: ContactState | None) -> SteadyState:
        path = path_of(worn, cycle, friction, load_factor, None, state, steps=steps).start()
        return settled_from(path, np.inf)  # the error is not known yet

    errors = (KeyboardInterrupt, NoContinuation, SolverError)
    with progress_bar(progress, "wear", "jump", on=errors) as bar:
        course = Course(per_work, tolerance, settle, settle(system, initial_state), initial_state)
        _keep(bar, course)
        reason = course.end(most_cycles)
        while not reason:
            course.jump(most_cycles)
            _keep(bar, course)
            bar.update()
            reason = course.end(most_cycles)
        if course.steady.steps:
            # The error of the increments needs two more transients, so it is computed only for the
            # last state.
            course.steady = steady_state(
                course.steady.system,
                cycle,
                friction,
                load_factor,
                initial_state=course.began,
                steps=steps,
            )
        return _history(course, reason)


def _keep(bar: Bar, course: Course) -> None:
    """Keep the history so far.

    An interrupt or an error that ends the history becomes its reason.
    """

    def history() -> WearHistory:
        error = sys.exception()
        return _history(course, f"{type(error).__name__}: {error}")

    note = "cycles are in the attribute `history`; to continue, pass its `system` and `state`"
    depth = course.rows[-1]["largest_depth"]
    best = f"{course.cycles:.4g} cycles, {depth:.3g} deep so far"
    bar.keep("history", history, f"{course.cycles:.6g} {note}", best)


def _history(course: Course, reason: str) -> WearHistory:
    """The history so far."""
    table = pd.DataFrame(course.rows)
    depth = np.array(table.pop("depth").to_list())
    pressure = np.array(table.pop("pressure").to_list())
    residual = float(table.pop("residual").max())
    seconds = perf_counter() - course.started
    record = SolveRecord(course.steady.record.solver, (), residual, (), seconds)
    return WearHistory(course.steady, frozen(depth), frozen(pressure), reason, record, table)


def _depth_per_work(system: ContactSystem, friction: PerNode, coefficient: PerNode) -> Array:
    """(N,) depth per work of friction."""
    f = friction_coefficients(friction, system)
    remedy = "give a coefficient of wear >= 0, volume per normal force and sliding distance"
    k = per_node("coefficient", coefficient, system, remedy)
    width = checked_width(system, "without it, depths do not follow from worn volumes")
    without_friction = (f == 0) & (k > 0)
    if without_friction.any():
        node = int(without_friction.argmax())
        raise ModelError(
            f"friction: 0 at node {node}{in_contact(system, node)}, and wear follows from the work "
            "of friction; give friction above 0, or a coefficient of 0 there"
        )
    return np.divide(k, f * width, out=np.zeros(system.nodes), where=k > 0)
