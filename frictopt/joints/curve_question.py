"""The input of a backbone curve, and its steady cycle at one load factor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ..base import Array, Outcome
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import GrossSlip, GuaranteedLimit
from ..study.case import FAILED, SLIDES_OFF
from ..study.dissipation_range import dissipation_range
from ..transients import SteadyState, steady_state
from .curve_load import CurveLoad


@dataclass(frozen=True)
class CurveCycle:
    """A load factor: its row of the curve, its rows by contact, and the state or the error.

    `extremes` are the rows of the states of least and most damping, with a range.
    """

    row: dict[str, Any]
    by_contact: pd.DataFrame = field(default_factory=pd.DataFrame)
    extremes: pd.DataFrame = field(default_factory=pd.DataFrame)
    steady: SteadyState | None = None
    error: NoContinuation | SolverError | None = None


@dataclass(frozen=True)
class CurveQuestion:
    """The input of a curve, with its gross-slip load and, if it has a range, its limits.

    `gross` is the error if no solver finds a gross-slip load. `limits` are the load factor of the
    shakedown limit, and the guaranteed limit. `steady_at` gives the steady state at a load factor;
    None: it is followed.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    load: CurveLoad
    gross: GrossSlip | SolverError
    limits: tuple[float, GuaranteedLimit] | None
    steps: int | None
    steady_at: Callable[[float], SteadyState] | None = None

    def follow(self, factor: float) -> CurveCycle:
        """Follow the contact to its steady cycle at one load factor."""
        try:
            steady = self._steady(factor)
            row, contacts = measured_cycle(steady, self.load)
        except (NoContinuation, SolverError) as error:
            outcome = SLIDES_OFF if self._slides_off(factor) else FAILED
            return CurveCycle({"load_factor": factor, "outcome": outcome}, error=error)
        extremes = pd.DataFrame()
        if self.limits is not None:
            ranges, extremes = self._range_at(factor, steady)
            row |= ranges
        return CurveCycle(row, contacts.assign(load_factor=factor), extremes, steady)

    def _steady(self, factor: float) -> SteadyState:
        if self.steady_at is not None:
            return self.steady_at(factor)
        return steady_state(self.system, self.cycle, self.friction, factor, steps=self.steps)

    def _range_at(
        self, factor: float, steady: SteadyState
    ) -> tuple[dict[str, float], pd.DataFrame]:
        """Columns of the range over the residual slips, the residual, and the extreme states."""
        assert self.limits is not None
        _, guaranteed = self.limits
        residual = steady.residual
        states = [steady]
        # Up to a proven guaranteed limit no start leads to steady work.
        if not (guaranteed.proven and factor <= guaranteed.load_factor):
            span = dissipation_range(
                self.system, self.cycle, self.friction, factor, steps=self.steps
            )
            residual = max(residual, span.residual)
            states += span.steady_states
        table = pd.DataFrame([self.load.measured(state) for state in states])
        ranges = {
            "residual": residual,
            "least_damping": table["damping"].min(),
            "most_damping": table["damping"].max(),
            "least_frequency": table["frequency"].min(),
            "most_frequency": table["frequency"].max(),
        }
        known = table.dropna(subset="damping")
        if known.empty:
            return ranges, pd.DataFrame()
        rows = [known["damping"].argmin(), known["damping"].argmax()]
        extremes = known.iloc[rows].assign(load_factor=factor, extreme=["least", "most"])
        return ranges, extremes

    def _slides_off(self, factor: float) -> bool:
        """Whether statics proves that the bodies slide off.

        If they do so under the mean load alone, both load factors are NaN.
        """
        if isinstance(self.gross, SolverError):
            return False
        return not self.gross.rests_at(factor)

    def notes(self, cycles: Sequence[CurveCycle]) -> list[str]:
        """Values of the curve that are NaN, and the reasons, in words."""
        return [*self._notes_on_question(), *self._notes_on_cycles(cycles)]

    def _notes_on_question(self) -> list[str]:
        """Columns that are NaN at all load factors, and the meaning of shares, in words."""
        notes = list[str]()
        if self.load.missing:
            notes.append(f"no displacement, stiffness, damping and frequency: {self.load.missing}")
        elif np.isnan(self.load.natural_frequency):
            notes.append("no frequency: it needs the load of a mode, and its natural_frequency")
        if self.system.width is None:
            notes.append("shares are of the nodes: the system has no width")
        return notes

    def _notes_on_cycles(self, cycles: Sequence[CurveCycle]) -> list[str]:
        """Notes on the load factors at which values are NaN."""
        notes = list[str]()
        sliding = [
            f"{cycle.row['load_factor']:g}"
            for cycle in cycles
            if cycle.row["outcome"] == SLIDES_OFF
        ]
        if isinstance(self.gross, SolverError):
            notes.append(f"no sliding-off load: {self.gross}")
        else:
            if sliding:
                notes.append(f"load factors {', '.join(sliding)}: {self.gross.reason}")
            if self.gross.self_stress is not None:
                notes.append(
                    "equilibrium does not determine the pressure of the fit: the sliding-off "
                    "load comes from transients without initial slip"
                )
        for cycle in cycles:
            name = f"load factor {cycle.row['load_factor']:g}"
            if cycle.row["outcome"] == FAILED:
                notes.append(f"{name}: {cycle.error}")
            elif cycle.row["outcome"] == Outcome.RATCHETING.name and not self.load.missing:
                notes.append(f"{name}: the contact ratchets, so its displacement has no range")
            elif np.isfinite(cycle.row.get("frequency", np.nan)) and np.isnan(
                cycle.row["resonance"]
            ):
                notes.append(
                    f"{name}: no resonance, because its displacement turns back between the "
                    "corners, or its steady state repeats after two cycles"
                )
        return notes


def measured_cycle(steady: SteadyState, load: CurveLoad) -> tuple[dict[str, Any], pd.DataFrame]:
    """The row of a curve, and its rows by contact, that follow from a steady state."""
    contacts = steady.by_contact()[["contact", "slipping", "work", "slip_range"]]
    row = {
        "load_factor": steady.load_factor,
        "outcome": steady.outcome.name,
        "work": steady.dissipation,
        "slipping": steady.slipping_share,
        "slip_range": contacts["slip_range"].max(),
        "residual": steady.residual,
        **load.measured(steady),
    }
    return row, contacts


def default_factors(gross: GrossSlip | SolverError) -> Array:
    """Eight load factors below the load that slides the bodies off."""
    if isinstance(gross, SolverError):
        raise gross
    if not 0 < gross.load_factor < np.inf:
        raise ModelError(
            "load_factors: None, and the load that slides the bodies off is "
            f"{gross.load_factor:g}; give load factors"
        )
    return gross.load_factor * np.geomspace(0.05, 0.95, 8)
