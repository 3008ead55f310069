"""The course of wear: the contact as it is worn so far, and its next jump of load cycles."""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from ..base import Array
from ..contact import ContactState, ContactSystem, joined, parted
from ..errors import SolverError
from ..transients import SteadyState

# Numbers of the jumps.

# A contact is worn in if its work of friction per cycle falls to this share of its largest.
WORN_IN = 1e-3
# Parameter of the Rosenbrock method, with which fast changes decay without oscillation.
_GAMMA = 1 - 1 / np.sqrt(2)
# Number of cycles after which remaining rates count as constant, in units of the time in which
# the stiffest node loses its pressure.
_FAR = 1e6
# Largest and smallest growth of the length of a jump, and share of the growth that the error
# estimate allows.
_LARGEST_GROWTH = 4.0
_SMALLEST_GROWTH = 0.2
_SAFETY = 0.9
# Attempts at a jump, each shorter.
_ATTEMPTS = 20


class Course:
    """A contact while it wears, between two jumps of many load cycles.

    Attributes
    ----------
    per_work, tolerance
        (N,) depth per work of friction, and tolerance of a jump.
    settle
        Finds the steady state of a worn contact from a state.
    steady, began
        The steady state, and the state from which it was followed.
    cycles, length
        Load cycles so far, and those of the next jump.
    rows, started
        Rows of the history, for the unworn contact and after each jump; and the time of the first.
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
        """(N, N) decrease of the rate with the depths, by the pressure that they take off."""
        steady = self.steady
        per_pressure = self.per_work * steady.friction * steady.sliding_distance
        return per_pressure[:, None] * steady.system.C

    def after(self, depth: Array) -> tuple[SteadyState, ContactState]:
        """The steady state after a further depth has been worn off, and its beginning.

        It begins at the current state, which stays in equilibrium: the bonded reactions grow by the
        pressure that the depth carried.
        """
        state = self.steady.state
        worn = self.steady.system.with_gap(self.steady.system.gap + depth)
        q, p = parted(worn.S[:, -worn.nodes :] @ depth, worn.tangents + 1)
        began = replace(state, bonded_q=state.bonded_q + q, bonded_p=state.bonded_p + p)
        return self.settle(worn, began), began

    def jump(self, most_cycles: float) -> None:
        """The next jump, as long as the tolerance allows, to at most `most_cycles` in all.

        A step of a Rosenbrock method of second order, linearly implicit; its first stage is a step
        of first order, which estimates the error.
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
        """Whether the rates (N,) are the same after all pressure that wear takes off is gone."""
        damping = self.damping
        cycles = _FAR / (np.abs(damping).max() or 1.0)
        late = np.linalg.solve(np.eye(len(rate)) + cycles * damping, rate)
        return bool(np.abs(late - rate).max() <= self.tolerance * rate.max())


def _growth(error: float) -> float:
    """Length of the next jump, or of the next attempt, over that of a jump with this error."""
    if error == 0:
        return _LARGEST_GROWTH
    growth = _SAFETY / np.sqrt(error)
    return float(np.clip(growth, _SMALLEST_GROWTH, _LARGEST_GROWTH))
