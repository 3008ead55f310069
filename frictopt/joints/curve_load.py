"""The load of a curve: its displacement over a cycle, its stiffness, damping and frequency."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..base import CONDENSATION, ROUNDING, Array, Integers, Outcome, finite_number
from ..contact import ContactSystem, LoadCycle, joined
from ..errors import ModelError
from ..transients import SteadyState
from ..transients.march import open_at_rest

# The loop of a load whose displacement swings like a cosine, and its harmonics.

# The numbers of the harmonics of a loop.

# Distance by which a displacement may turn back between two corners, relative to its range. It
# is rounding of the path.
_TURNING = 1e-9
# Distance between two states, relative to half the range, up to which the mean sine between
# them is that at their middle. The quotient of two small differences would be rounding there.
_STEP = 1e-8
# Number of times in a cycle at which harmonics are sampled, and number of harmonics.
_TIMES = 512
_HARMONICS = 12


@dataclass(frozen=True)
class Swing:
    """A load cycle to and fro at its states, with a displacement `mean + a cos t`.

    Attributes
    ----------
    legs
        Numbers of the states from the low end to the high end, one row for each way between the
        ends: up, and down in reverse order.
    place
        (T,) displacement of the states, -1 at the low end and 1 at the high end.
    """

    legs: tuple[Integers, Integers]
    place: Array

    def first_harmonic(self, force: Array) -> float:
        """(1 / pi) times the integral of a force (T,) times cos t over a cycle.

        Integration by parts turns it into the integral of the sine over the force. Between two
        states the force is linear in the displacement, so the mean of the sine is known in closed
        form.
        """
        total = 0.0
        for leg in self.legs:
            place = np.maximum.accumulate(self.place[leg])
            sine = np.sqrt(1 - place**2)
            area = (place * sine + np.arcsin(place)) / 2
            step = np.diff(place)
            middle = (place[1:] + place[:-1]) / 2
            mean_sine = np.sqrt(1 - middle**2)
            np.divide(np.diff(area), step, out=mean_sine, where=step > _STEP)
            total += float(np.diff(force[leg]) @ mean_sine)
        return total / np.pi

    def harmonics(self, values: Array) -> Array:
        """(1 + harmonics, m) complex amplitudes of values (T, m). Row 0 is their mean."""
        half = _TIMES // 2
        place = np.cos(np.pi * np.arange(half) / half)
        up, down = self.legs
        series = np.empty((_TIMES, values.shape[1]))
        for number, column in enumerate(values.T):
            series[:half, number] = np.interp(place, self.place[down], column[down])
            series[half:, number] = np.interp(-place, self.place[up], column[up])
        transformed = 2 * np.fft.rfft(series, axis=0) / _TIMES
        transformed[0] /= 2
        return np.asarray(transformed[: 1 + _HARMONICS])


def swing_of(level: Array, displacement: Array) -> Swing | None:
    """The swing of a load whose level rises from one corner to the other, and falls back.

    None if the displacement stands still or turns back between the corners: a cosine then has no
    loop.
    """
    length = np.ptp(displacement)
    if not length > 0:
        return None
    place = (2 * displacement - displacement.max() - displacement.min()) / length
    top = int(np.argmax(level))
    legs = np.arange(top + 1), np.arange(top, len(level))[::-1]
    for leg in legs:
        rises = (np.diff(place[leg]) >= -_TURNING).all()
        ends = np.abs(place[leg[[0, -1]]] - [-1, 1]).max() <= _TURNING
        if not (rises and ends):
            return None
    return Swing(legs, np.clip(place, -1.0, 1.0))


@dataclass(frozen=True)
class CurveLoad:
    """A load with its amplitudes (cases,) at load factor 1 and its compliance on the glued bodies.

    `natural_frequency` is NaN if the load is no mode. `missing` says why the load has no
    displacement, "" if it has one.
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

        Both are NaN if the displacement drifts or is not known. The harmonic is NaN if no cosine
        has the loop, see `swing_of`, or if the state repeats after two cycles.
        """
        if self.missing or steady.outcome is Outcome.RATCHETING:
            return np.nan, np.nan
        rests = steady.outcome is Outcome.SHAKEDOWN
        if rests and steady.friction.all() and not steady.open.any():
            return self.compliance * steady.load_factor, steady.load_factor
        path = steady.states()
        displacements = path.system.displacements(path.amplitudes, path.slip, path.gap)
        displacement = displacements @ self.direction
        level = path.amplitudes @ self.direction / (self.direction @ self.direction)
        swing = swing_of(level, displacement) if steady.period == 1 else None
        harmonic = np.nan if swing is None else swing.first_harmonic(level)
        return float(np.ptp(displacement) / 2), harmonic


def load_size(system: ContactSystem, cycle: LoadCycle) -> float:
    """Size of the cyclic load at load factor 1, force, by its first corner; NaN if not known."""
    size = 0.0
    for case, amplitude in cycle.corners[0].items():
        if amplitude:
            size += abs(amplitude) * system.load_size.get(case, np.nan)
    return size or np.nan


def with_compliance(
    system: ContactSystem, cycle: LoadCycle, friction: Array, natural_frequency: float | None
) -> tuple[ContactSystem, CurveLoad]:
    """The load of a curve, and its contact with a compliance.

    A system without compliance gets that which the natural frequency of the load says.
    """
    if natural_frequency is not None:
        natural_frequency = finite_number("natural_frequency", natural_frequency, above=0.0)
    direction = opposed_direction(system, cycle)
    if direction is None:
        remedy = (
            "give two opposed corners, [{'mode': 1.0}, {'mode': -1.0}], around a mean load, and no "
            "fixed part"
        )
        if natural_frequency is not None:
            raise ModelError(f"cycle: {cycle}; a mode has a natural_frequency, so {remedy}")
        return system, CurveLoad(missing=f"the cycle does not have two opposed corners; {remedy}")
    if system.compliance is None:
        return _with_modal_compliance(system, direction, natural_frequency)
    compliance = float(direction @ system.compliance @ direction)
    if not compliance > ROUNDING * _compliance_scale(system, cycle, direction):
        missing = (
            f"the load does no work on the glued bodies (compliance {compliance:g}); give a load "
            "of forces"
        )
        if natural_frequency is not None:
            raise ModelError(f"corners: {missing}")
        return system, CurveLoad(missing=missing)
    if natural_frequency is None:
        return system, CurveLoad(direction, compliance)
    of_open_nodes = _compliance_of_open_nodes(system, cycle, friction)
    frequency = _checked_frequency(natural_frequency, [compliance, compliance + of_open_nodes])
    return system, CurveLoad(direction, compliance, frequency)


def opposed_direction(system: ContactSystem, cycle: LoadCycle) -> Array | None:
    """(cases,) amplitudes of the first corner; None if there are not two opposed corners alone.

    Amplitudes around a mean load that was computed, as that of a history, have its rounding.
    """
    amplitudes = [
        np.array([corner.get(case, 0.0) for case in system.bonded]) for corner in cycle.corners
    ]
    if cycle.fixed or len(amplitudes) != 2:
        return None
    first, second = amplitudes
    scale = np.maximum(np.abs(first), np.abs(second)).max(initial=0.0)
    is_opposed = (np.abs(first + second) <= ROUNDING * scale).all()
    return first if is_opposed and first.any() else None


def _with_modal_compliance(
    system: ContactSystem, direction: Array, natural_frequency: float | None
) -> tuple[ContactSystem, CurveLoad]:
    """The contact with the compliance of one mode, whose modal mass is 1."""
    if natural_frequency is None:
        missing = (
            "the system has no compliance, which `condense` finds; for a mode, give the "
            "natural_frequency"
        )
        return system, CurveLoad(missing=missing)
    compliance = (2 * np.pi * natural_frequency) ** -2
    of_mode = compliance * np.outer(direction, direction) / (direction @ direction) ** 2
    load = CurveLoad(direction, compliance, natural_frequency)
    return replace(system, compliance=of_mode), load


def _compliance_scale(system: ContactSystem, cycle: LoadCycle, direction: Array) -> float:
    """Compliance of this load without cancellation. Other load cases, of any size, do not count."""
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
    """The natural frequency by the compliances that is closest to the given one."""
    frequencies = [1 / (2 * np.pi * np.sqrt(compliance)) for compliance in compliances]
    closest = min(frequencies, key=lambda frequency: abs(frequency / natural_frequency - 1))
    # Relative difference up to which two natural frequencies are of the same mode. Other codes
    # write them with few digits.
    same_mode = 1e-2
    if abs(closest / natural_frequency - 1) > same_mode:
        raise ModelError(
            f"natural_frequency: {natural_frequency:g}, and the compliance of the load says "
            f"{closest:g}; give the load of a mass-normalised mode (`Modes.load`), or leave the "
            "natural frequency out"
        )
    return float(closest)
