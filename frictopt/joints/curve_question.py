"""The input of a backbone curve, and its steady cycle at one load factor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ..base import CONDENSATION, ROUNDING, Array, Integers, Outcome, finite_number
from ..contact import ContactSystem, LoadCycle, amplitudes_of, joined
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import GrossSlip, GuaranteedLimit, ShakedownLimit
from ..study.case import FAILED, SLIDES_OFF
from ..study.dissipation_range import dissipation_range
from ..transients import SteadyState
from ..transients.march import open_at_rest

# The load of a curve: its displacement over a cycle, its stiffness, damping and frequency.

# The loop of a load whose displacement swings like a cosine, and its harmonics.

# The numbers of the harmonics of a loop.

# A displacement may turn back between two corners by this share of its range, because so small a
# distance is rounding of the path.
_TURNING = 1e-9
# If the distance between two states is at most this share of half the range, the sine at their
# middle is taken as the mean sine between them: a quotient of two so small differences would be
# rounding.
_STEP = 1e-8
# Number of times in a cycle at which harmonics are sampled, and number of harmonics.
_TIMES = 512
_HARMONICS = 12


@dataclass(frozen=True)
class Swing:
    """The states of a load cycle to and fro, with the displacement `mean + a cos t`.

    Attributes
    ----------
    ways
        Numbers of the states from the low end to the high end: the states on the way up, and the
        states on the way down in reverse order.
    place
        (T,) displacement of the states, -1 at the low end and 1 at the high end.
    """

    ways: tuple[Integers, Integers]
    place: Array

    def first_harmonic(self, force: Array) -> float:
        """(1 / pi) times the integral of a force (T,) times cos t over a cycle.

        Integration by parts turns it into the integral of sin t with respect to the force. Between
        two states the force is linear in the displacement, so the mean of the sine is known in
        closed form.
        """
        total = 0.0
        for way in self.ways:
            place = np.maximum.accumulate(self.place[way])
            sine = np.sqrt(1 - place**2)
            area = (place * sine + np.arcsin(place)) / 2
            step = np.diff(place)
            middle = (place[1:] + place[:-1]) / 2
            mean_sine = np.sqrt(1 - middle**2)
            np.divide(np.diff(area), step, out=mean_sine, where=step > _STEP)
            total += float(np.diff(force[way]) @ mean_sine)
        return total / np.pi

    def harmonics(self, values: Array) -> Array:
        """(1 + harmonics, m) complex amplitudes of values (T, m). Row 0 is their mean."""
        half = _TIMES // 2
        place = np.cos(np.pi * np.arange(half) / half)
        up, down = self.ways
        series = np.empty((_TIMES, values.shape[1]))
        for number, column in enumerate(values.T):
            series[:half, number] = np.interp(place, self.place[down], column[down])
            series[half:, number] = np.interp(-place, self.place[up], column[up])
        transformed = 2 * np.fft.rfft(series, axis=0) / _TIMES
        transformed[0] /= 2
        return np.asarray(transformed[: 1 + _HARMONICS])


def swing_of(level: Array, displacement: Array) -> Swing | None:
    """The swing of a load whose level rises from one corner to the other, and falls back.

    None if the displacement stands still or turns back between the corners: then no motion like a
    cosine has this loop.
    """
    length = np.ptp(displacement)
    if not length > 0:
        return None
    place = (2 * displacement - displacement.max() - displacement.min()) / length
    top = int(np.argmax(level))
    ways = np.arange(top + 1), np.arange(top, len(level))[::-1]
    for way in ways:
        rises = (np.diff(place[way]) >= -_TURNING).all()
        ends = np.abs(place[way[[0, -1]]] - [-1, 1]).max() <= _TURNING
        if not (rises and ends):
            return None
    return Swing(ways, np.clip(place, -1.0, 1.0))


@dataclass(frozen=True)
class CurveLoad:
    """A load with its amplitudes (cases,) at load factor 1 and its compliance on the glued bodies.

    `natural_frequency` is NaN if the load is not the load of a mode. `missing` says why the load
    has no displacement; it is "" if the load has one.
    """

    direction: Array = field(default_factory=lambda: np.zeros(0))
    compliance: float = np.nan
    natural_frequency: float = np.nan
    missing: str = ""

    def measured(self, steady: SteadyState) -> dict[str, float]:
        """Columns of the curve that follow from the displacement over a steady cycle."""
        load_factor = steady.load_factor
        displacement, harmonic = self._motion(steady)
        stiffness = load_factor / displacement
        frequency = np.nan
        resonance = np.nan
        if np.isfinite(self.natural_frequency):
            frequency = np.sqrt(stiffness) / (2 * np.pi)
            resonance = np.sqrt(harmonic / displacement) / (2 * np.pi)
        # Divided one by one, because the product of two tiny numbers may be 0.
        damping = steady.dissipation / displacement / load_factor / (2 * np.pi)
        return {
            "displacement": displacement,
            "stiffness": stiffness,
            "frequency": frequency,
            "resonance": resonance,
            "damping": damping,
        }

    def _motion(self, steady: SteadyState) -> tuple[float, float]:
        """Half the range of the displacement of the load, and the first harmonic of the load.

        Both are NaN if the displacement drifts or is not known. The harmonic is NaN if no motion
        like a cosine has this loop, see `swing_of`, or if the state repeats after two cycles.
        """
        if self.missing or steady.outcome is Outcome.RATCHETING:
            return np.nan, np.nan
        if moves_as_glued(steady):
            return self.compliance * steady.load_factor, steady.load_factor
        level, displacements = loop_of(steady, self.direction)
        displacement = displacements @ self.direction
        swing = swing_of(level, displacement) if steady.period == 1 else None
        harmonic = np.nan if swing is None else swing.first_harmonic(level)
        return float(np.ptp(displacement) / 2), harmonic


def moves_as_glued(steady: SteadyState) -> bool:
    """Whether all nodes stay closed and friction holds them, so that the loop is a line."""
    rests = steady.outcome is Outcome.SHAKEDOWN
    return rests and bool(steady.friction.all()) and not steady.open.any()


def loop_of(steady: SteadyState, direction: Array) -> tuple[Array, Array]:
    """The level (T,) of a load and the displacements (T, m) of all loads at the states of a cycle.

    `direction` (m,) are the amplitudes of the load at the level 1.
    """
    path = steady.states()
    level = path.amplitudes @ direction / (direction @ direction)
    return level, path.system.displacements(path.amplitudes, path.slip, path.gap)


def load_size(system: ContactSystem, cycle: LoadCycle) -> float:
    """Size of the cyclic load at load factor 1, force, at its first corner; NaN if not known."""
    size = 0.0
    for case, amplitude in cycle.corners[0].items():
        if amplitude:
            size += abs(amplitude) * system.load_size.get(case, np.nan)
    return size or np.nan


def load_of_curve(
    system: ContactSystem, cycle: LoadCycle, friction: Array, natural_frequency: float | None
) -> CurveLoad:
    """The load of a curve; a natural frequency needs a load with a displacement."""
    direction = opposed_direction(system, cycle)
    missing = _missing(system, cycle, direction)
    if natural_frequency is None and missing:
        return CurveLoad(missing=missing)
    if missing:
        raise ModelError(f"natural_frequency: {natural_frequency}, and {missing}")
    assert direction is not None and system.compliance is not None
    compliance = float(direction @ system.compliance @ direction)
    if natural_frequency is None:
        return CurveLoad(direction, compliance)
    given = finite_number("natural_frequency", natural_frequency, above=0.0)
    of_open_nodes = _compliance_of_open_nodes(system, cycle, friction)
    frequency = _checked_frequency(given, [compliance, compliance + of_open_nodes])
    return CurveLoad(direction, compliance, frequency)


def _missing(system: ContactSystem, cycle: LoadCycle, direction: Array | None) -> str:
    """The reason why a load has no displacement, and a remedy; "" if it has a displacement."""
    if direction is None:
        return (
            "the cycle does not have two opposed corners; give two, [{'mode': 1.0}, {'mode': "
            "-1.0}], around a mean load, and no fixed part"
        )
    if system.compliance is None:
        return "the system has no compliance; `condense` finds it, or give it to the system"
    compliance = float(direction @ system.compliance @ direction)
    if not compliance > ROUNDING * _compliance_scale(system, cycle, direction):
        return (
            f"the load does no work on the glued bodies (compliance {compliance:g}); give a load "
            "of forces"
        )
    return ""


def opposed_direction(system: ContactSystem, cycle: LoadCycle) -> Array | None:
    """(cases,) amplitudes of the first corner; None unless the cycle has just two opposed corners.

    Corners count as opposed up to rounding, because amplitudes about a computed mean load, such as
    the mean load of a history, have rounding errors.
    """
    if cycle.fixed or len(cycle.corners) != 2:
        return None
    first, second = amplitudes_of(cycle.corners, system.bonded)
    scale = np.maximum(np.abs(first), np.abs(second)).max(initial=0.0)
    is_opposed = (np.abs(first + second) <= ROUNDING * scale).all()
    return first if is_opposed and first.any() else None


def _compliance_scale(system: ContactSystem, cycle: LoadCycle, direction: Array) -> float:
    """Scale of the terms that add up to the compliance along a direction of loads.

    If the terms cancel, the compliance itself is only rounding.
    """
    assert system.compliance is not None
    reactions = joined(*system.reaction(cycle.corners[0]))
    of_bodies = np.abs(direction) @ np.abs(system.compliance) @ np.abs(direction)
    return float(of_bodies + reactions @ reactions / system.stiffness_scale)


def _compliance_of_open_nodes(system: ContactSystem, cycle: LoadCycle, friction: Array) -> float:
    """Compliance that the load of a corner gains from open nodes, which follow it without force."""
    is_open = np.tile(open_at_rest(system, cycle, friction), system.tangents + 1)
    reactions = joined(*system.reaction(cycle.corners[0]))[is_open]
    stiffness = system.S[np.ix_(is_open, is_open)]
    motion = np.linalg.lstsq(stiffness, reactions, rcond=CONDENSATION)[0]
    return float(reactions @ motion)


def _checked_frequency(natural_frequency: float, compliances: list[float]) -> float:
    """The natural frequency that follows from a compliance and is closest to the given one."""
    frequencies = [1 / (2 * np.pi * np.sqrt(compliance)) for compliance in compliances]
    closest = min(frequencies, key=lambda frequency: abs(frequency / natural_frequency - 1))
    # Relative difference up to which two natural frequencies count as frequencies of one mode.
    # Other codes write them with few digits.
    same_mode = 1e-2
    if abs(closest / natural_frequency - 1) > same_mode:
        raise ModelError(
            f"natural_frequency: {natural_frequency:g}, and the compliance of the load says "
            f"{closest:g}; give the load of a mass-normalised mode (`Modes.load`), or leave the "
            "natural frequency out"
        )
    return float(closest)


@dataclass(frozen=True)
class CurveCycle:
    """The answer at a load factor: row of the curve, rows by contact, and the state or the error.

    `extremes` are the rows of the states with the least and the most damping, if the curve has a
    range.
    """

    row: dict[str, Any]
    by_contact: pd.DataFrame = field(default_factory=pd.DataFrame)
    extremes: pd.DataFrame = field(default_factory=pd.DataFrame)
    steady: SteadyState | None = None
    error: NoContinuation | SolverError | None = None


@dataclass(frozen=True)
class CurveQuestion:
    """The input of a curve, with its sliding-off load and, if it has a range, its limits.

    `gross` has the sliding-off load, or the error if no solver finds it. `limits` are the shakedown
    limit and the guaranteed limit. `steady_at` returns the steady state at a load factor.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    load: CurveLoad
    gross: GrossSlip | SolverError
    limits: tuple[ShakedownLimit, GuaranteedLimit] | None
    steps: int | None
    steady_at: Callable[[float], SteadyState]

    def follow(self, factor: float) -> CurveCycle:
        """Follow the contact to its steady cycle at one load factor."""
        try:
            steady = self.steady_at(factor)
            row, contacts = measured_cycle(steady, self.load)
        except (NoContinuation, SolverError) as error:
            outcome = SLIDES_OFF if self._slides_off(factor) else FAILED
            return CurveCycle({"load_factor": factor, "outcome": outcome}, error=error)
        extremes = pd.DataFrame()
        if self.limits is not None:
            ranges, extremes = self._range_at(factor, steady)
            row |= ranges
        return CurveCycle(row, contacts.assign(load_factor=factor), extremes, steady)

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

        The result is also True if the bodies slide off under the mean load alone.
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
