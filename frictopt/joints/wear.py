"""Wear: how a contact changes over many load cycles, in jumps of cycles between steady states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Plotted,
    Recorded,
    SolveRecord,
    bar_of,
    finite_number,
    frozen,
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
from ..transients.cycles import Run
from ..transients.march import path_of
from ..transients.steady import MOST_CYCLES, reported

_WORN_IN = (
    1e-3  # work of friction per cycle, over its largest, from which on a contact counts as worn in
)
_GAMMA = 1 - 1 / np.sqrt(2)  # the jumps then damp without oscillation what changes fast
# cycles, in units of the time in which the stiffest node wears its pressure off, after which a rate
# that is left never changes
_FAR = 1e6
_MOST, _LEAST, _SAFE = (
    4.0,
    0.2,
    0.9,
)  # growth of the jumps: at most, at least, and the share of what the error allows
_FAILURES = 20  # jumps in a row that are too long, after which there is none


class Worn(Recorded, Plotted):
    """Base of results that have a worn contact in a steady state."""

    steady: SteadyState

    @property
    def system(self) -> ContactSystem:
        """The contact as it is worn in the end."""
        return self.steady.system

    @property
    def state(self) -> ContactState:
        """Its state at the last corner of the steady cycle, from which wear or another transient may go on."""
        return self.steady.state


@dataclass(frozen=True, eq=False, repr=False)
class WearHistory(Worn):
    """A contact while it wears: its steady states before the first jump of cycles and after each one.

    Theory, eq. (29).

    Attributes
    ----------
    steady
        The last steady state. Its contact is worn, and takes every other question. Its `step_error`
        is inf in space where an error ended the history.
    depth, pressure
        (J + 1, N) depth worn off at each node since the beginning, of both bodies together, length,
        and normal force over width at the last corner of the steady cycle.
    reason, record
        Why the history ends, in words, and how it was found; `residual` is the largest of all
        steady states.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=32, half_length=1.0, E_star=1e5, R=100.0)  # a cylinder; N and mm
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays, width=[2 / 32] * 32)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> history = fo.wear(cylinder, cycle, friction=0.5, load_factor=100.0, coefficient=1e-8, cycles=1e5)
    >>> history.reason, f"{history.volume:.2e}"
    ('100000 cycles are over', '3.14e-05')
    >>> history.to_frame()[["slipping", "stick_width", "outcome"]].tail(1)
        slipping  stick_width      outcome
    10         8          1.0  CYCLIC_SLIP
    """

    steady: SteadyState = field(repr=False)
    depth: Array
    pressure: Array
    reason: str
    record: SolveRecord
    _table: pd.DataFrame

    @property
    def cycles(self) -> Array:
        """(J + 1,) number of load cycles before the first jump, 0, and after each one; jumps do not end at whole cycles."""
        return frozen(self._table["cycles"])

    @property
    def volume(self) -> float:
        """Volume worn off in the end (per depth in the plane)."""
        return float(self._table["volume"].iloc[-1])

    @property
    def worn_in(self) -> bool:
        """Whether the contact is worn in: it slips no more, or its work of friction per cycle is a thousandth of the largest."""
        return bool(self._table["work"].iloc[-1] <= _WORN_IN * self._table["work"].max())

    def to_frame(self) -> pd.DataFrame:
        """One row for the unworn contact and one after each jump.

        Columns: cycles; work, of friction per cycle; largest_depth and volume worn off so far;
        slipping, number of nodes that slip; stick_width, length (area in space) of those that
        neither slip nor open; outcome, the name of an `Outcome`.
        """
        return self._table.copy()

    def _answer(self) -> Mapping[str, object]:
        numbers = {
            name: float(self._table[name].iloc[-1])
            for name in ("cycles", "work", "largest_depth", "volume")
        }
        return {"jumps": len(self._table) - 1, **numbers, "reason": self.reason}


@warns_of_odd_values
def wear(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    coefficient: ArrayLike,
    cycles: float | None = None,
    initial_state: ContactState | None = None,
    tolerance: float = 0.01,
    steps: int | None = None,
    progress: bool = True,
) -> WearHistory:
    """Follow a contact while it wears, in jumps of many load cycles from one steady state to the next.

    In each steady cycle node i loses the depth `coefficient / width_i` times the integral of `p_i
    |dv_i|` (Archard), which is its work of friction over its coefficient of friction; a surface
    that shears off at its strength wears by that work too. Depths add to the gap. The bodies stay
    elastic and their stiffness stays, so depths must be small beside the contact. A jump is a step
    of a Rosenbrock method of second order, linearly implicit: pressure that wears off slows wear
    down within the jump. Its length follows from an estimate of its error. After each jump the
    transient goes on from the state before it, while the wear is taken off, to the next steady
    state, which is judged as every other. Theory, eq. (29).

    Without `cycles` the history ends when the contact is worn in: when it slips no more, or its
    work of friction per cycle is a thousandth of the largest. It also ends where wear goes on at
    rates that never change, because it changes no pressure any more.

    Parameters
    ----------
    system, cycle, friction, load_factor
        The contact, with its `width`, its load cycle, its coefficient of friction, one or one per
        node, and the load factor, >= 0.
    coefficient
        Archard's coefficient of wear, volume per normal force and way slid, of both bodies
        together, one or one per node, >= 0: 1e-8 for 1e-8 mm^3/(N mm), where forces are in N and
        lengths in mm. Lengths of another unit change it, see the tutorial. A volume per work of
        friction, times the coefficient of friction, is one.
    cycles
        Number of load cycles, >= 1; None: until the contact is worn in.
    initial_state
        A state to start from, such as `state` of an earlier history with its `system`, which goes
        on from there; None: no slip.
    tolerance
        Estimated error of the depth that a jump may add, over the largest depth at its end. The
        estimate is that of a method of first order. It is no bound of the error of the whole
        history, to which all jumps add: of most it is less than this, of some several times as
        much. Ask again with a quarter of it to see.
    steps, progress
        Number of increments from corner to corner, see `steady_state`, and whether to show after
        two seconds how far it is.

    Raises
    ------
    ModelError
        Bad input, a contact without width, or without friction at a node with a coefficient of
        wear, where wear does not follow from the work.
    NoContinuation, SolverError
        A worn contact has no steady state, or none that passes the checks. Where wear has begun,
        the attribute `history` of the error holds what is done by then, as it does that of a
        KeyboardInterrupt (Ctrl-C).

    Notes
    -----
    Jumps: Verwer, Spee, Blom & Hundsdorfer 1999, SIAM J. Sci. Comput. 20, 1456-1480. Wear: Archard
    1953, J. Appl. Phys. 24, 981-988; by energy: Fouvry, Kapsa & Vincent 1996, Wear 200, 186-205.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=32, half_length=1.0, E_star=1e5, R=100.0)  # a cylinder; N and mm
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays, width=[2 / 32] * 32)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> history = fo.wear(cylinder, cycle, friction=0.5, load_factor=100.0, coefficient=1e-8)
    >>> history.worn_in, f"{history.cycles[-1]:.1e} cycles, {1e3 * history.depth[-1].max():.2f} micrometres"
    (True, '2.2e+06 cycles, 0.61 micrometres')
    """
    per_work = _per_work(
        checked_round(system, "the depth needs ways along it as they are"), friction, coefficient
    )
    most = np.inf if cycles is None else finite_number("cycles", cycles, least=1.0)
    tolerance = finite_number("tolerance", tolerance, above=0.0)
    begun = initial_state

    def settle(worn: ContactSystem, state: ContactState | None) -> SteadyState:
        nonlocal begun
        begun = state
        run = Run(
            path_of(worn, cycle, friction, load_factor, None, state, steps=steps).start(),
            MOST_CYCLES,
        )
        return reported(run, run.settled(), np.inf if run.path.steps else 0.0)

    def told() -> str:
        return (
            f"{course.cycles:.4g} cycles, {course.rows[-1]['largest_depth']:.3g} deep so far"
            if course
            else ""
        )

    def kept(error: BaseException) -> tuple[str, object, str] | None:
        where = "cycles are in the attribute `history`; from its `system` and `state` wear goes on"
        return (
            (
                "history",
                course.history(f"{type(error).__name__}: {error}"),
                f"{course.cycles:.6g} {where}",
            )
            if course
            else None
        )

    course: Course | None = None
    with bar_of(
        progress,
        "wear",
        "jump",
        best=told,
        keeps=kept,
        on=(KeyboardInterrupt, NoContinuation, SolverError),
    ) as bar:
        course = Course(per_work, tolerance, settle, settle(system, initial_state))
        while not (reason := course.ended(most)):
            course.jump(most)
            bar.update()
        # the error of its increments, which takes two more transients, is asked of the last state
        # alone
        if course.steady.steps:
            course.steady = steady_state(
                course.steady.system, cycle, friction, load_factor, initial_state=begun, steps=steps
            )
        return course.history(reason)


class Course:
    """A contact while it wears: its steady state, its load cycles so far, the length of the next jump, and what is known after each jump.

    `per_work` is the (N,) depth per work of friction, `settle` gives the steady state of a worn
    contact from a state.
    """

    def __init__(
        self,
        per_work: Array,
        tolerance: float,
        settle: Callable[[ContactSystem, ContactState | None], SteadyState],
        steady: SteadyState,
    ) -> None:
        self.per_work, self.tolerance, self.settle, self.steady = (
            per_work,
            tolerance,
            settle,
            steady,
        )
        self.cycles, self.started, self.gap, self.rows = (
            0.0,
            perf_counter(),
            steady.system.gap,
            list[dict[str, Any]](),
        )
        self.keep()
        fastest = float(self.damping.diagonal().max())
        self.length = float(np.sqrt(tolerance)) / fastest if fastest > 0 else np.inf

    def keep(self) -> None:
        """Keep what the history says of the contact as it is worn now."""
        steady, system, state = self.steady, self.steady.system, self.steady.state
        assert system.width is not None
        p = (
            state.bonded_p
            + (system.S @ joined(state.slip, state.gap - system.gap))[-system.nodes :]
        )
        depth = system.gap - self.gap
        row: dict[str, Any] = {
            "cycles": self.cycles,
            "work": steady.dissipation,
            "largest_depth": float(depth.max()),
        }
        row |= {"volume": float(depth @ system.width), "slipping": int(steady.slipping.sum())}
        row |= {
            "stick_width": float(system.width[~(steady.slipping | steady.open)].sum()),
            "outcome": steady.outcome.name,
        }
        self.rows.append(
            row
            | {
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
        """(N, N) change of the rate with the depths, for the pressure that they take off."""
        return (self.per_work * self.steady.friction * self.steady.sliding_distance)[
            :, None
        ] * self.steady.system.C

    def after(self, h: Array) -> SteadyState:
        """The steady state after a depth h has been worn off, from the state in equilibrium: its bonded reactions grow by what the depth carried."""
        worn, state = self.steady.system.with_gap(self.steady.system.gap + h), self.steady.state
        q, p = parted(worn.S[:, -worn.nodes :] @ h, worn.tangents + 1)
        return self.settle(
            worn, replace(state, bonded_q=state.bonded_q + q, bonded_p=state.bonded_p + p)
        )

    def jump(self, most: float) -> None:
        """The next jump, as long as the tolerance allows, to `most` cycles in all."""
        rate, damping = self.rate(self.steady), self.damping
        for _ in range(_FAILURES):
            cycles = min(self.cycles + self.length, most)
            length = cycles - self.cycles
            implicit = np.eye(len(rate)) + _GAMMA * length * damping
            first = np.maximum(np.linalg.solve(implicit, rate), 0.0)
            second = np.linalg.solve(implicit, self.rate(self.after(length * first)) - 2 * first)
            h = np.maximum(length * (1.5 * first + 0.5 * second), 0.0)
            error = float(np.abs(h - length * first).max()) / (
                self.tolerance * float((self.rows[-1]["depth"] + h).max())
            )
            self.length = (
                length * float(np.clip(_SAFE / np.sqrt(error), _LEAST, _MOST))
                if error > 0
                else length * _MOST
            )
            if error <= 1:
                self.steady, self.cycles = self.after(h), cycles
                return self.keep()
        raise SolverError(
            f"wear: after {self.cycles:.6g} cycles a jump of {length:.1e} is too long for the tolerance {self.tolerance:g}; allow more"
        )

    def ended(self, most: float) -> str:
        """Why the history ends here, in words; empty where it goes on."""
        work, largest, rate = (
            self.steady.dissipation,
            max(row["work"] for row in self.rows),
            self.rate(self.steady),
        )
        if work == 0:
            return (
                "worn in: the contact slips no more"
                if largest > 0
                else "the contact does not slip, and does not wear"
            )
        if not rate.any():
            return "no node that slips has a coefficient of wear above 0"
        if self.cycles >= most:
            return f"{most:.6g} cycles are over"
        if np.isfinite(most):
            return ""
        if work <= _WORN_IN * largest:
            return f"worn in: the work of friction per cycle is {work / largest:.1e} of its largest"
        late = np.linalg.solve(
            np.eye(len(rate)) + _FAR / (np.abs(self.damping).max() or 1.0) * self.damping, rate
        )
        unchanged = np.abs(late - rate).max() <= self.tolerance * rate.max()
        return (
            "the contact wears on at rates that never change: they take off no pressure; give `cycles`"
            if unchanged
            else ""
        )

    def history(self, reason: str) -> WearHistory:
        """What is done so far."""
        table = pd.DataFrame(self.rows)
        depth, pressure, residual = (
            np.array(table.pop(name).to_list()) for name in ("depth", "pressure", "residual")
        )
        record = SolveRecord(
            self.steady.record.solver, (), float(residual.max()), (), perf_counter() - self.started
        )
        return WearHistory(self.steady, frozen(depth), frozen(pressure), reason, record, table)


def _per_work(system: ContactSystem, friction: ArrayLike, coefficient: ArrayLike) -> Array:
    """(N,) depth per work of friction."""
    less = "give a coefficient of wear >= 0, volume per normal force and way slid"
    f, k = (
        friction_coefficients(friction, system.nodes),
        per_node("coefficient", coefficient, system.nodes, less),
    )
    width = checked_width(system, "without it a worn volume has no depth")
    if (smooth := (f == 0) & (k > 0)).any():
        where = f"friction: 0 at node {int(smooth.argmax())}{in_contact(system, smooth.argmax())}, and wear follows from the work of friction"
        raise ModelError(f"{where}; give friction above 0, or a coefficient of 0 there")
    return np.divide(k, f * width, out=np.zeros(system.nodes), where=k > 0)
