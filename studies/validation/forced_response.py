"""The forced response of one mode with quasi-static friction, compared with time integration.

Run with `python -m studies forced_response [--quick]`; it prints three tables in Markdown. The
structures are an oscillator of two masses and a wedge between them (Balaji and Ferhatoglu), and a
light and a heavy block on four springs with friction, whose edges lift off as they rock. The time
integration is explicit and shares no code with the package. Each run begins at rest. One run sweeps
the frequency down, and a second run sweeps it up. The larger of the two peaks counts. There are
also random joints of one mass. The mass is shaken from rest at a frequency that follows its
resonance.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

import frictopt as fo
from studies.progress import each
from studies.tables import Row, Study, Table, markdown

from .jointed_mass import random_mass
from .vibrations import Structure, Vibration, rocking, wedges


@dataclass(frozen=True)
class Case:
    """A structure whose mode is shaken by several forces.

    `mode` counts from 0. Load factors of the curve are from `least` to `most`. `point` is the number
    of the mass coordinate at which the force acts; None: on the mode alone.
    """

    about: str
    make: Callable[[], Structure]
    mode: int
    least: float
    most: float
    damping: float
    forces: tuple[float, ...]
    point: int | None = None


_THIRD = "oscillator, third mode"
_SECOND = "oscillator, second mode"
_LIGHT = "light block, lift-off"
CASES = (
    Case(_THIRD, wedges, 2, 50, 6000, 1e-3, (10.0, 20.0, 30.0, 40.0, 50.0)),
    Case(_THIRD, wedges, 2, 50, 6000, 5e-3, (10.0, 20.0, 30.0, 40.0, 50.0)),
    Case(f"{_THIRD}, force at one mass", wedges, 2, 50, 6000, 1e-3, (10.0, 30.0, 50.0), 2),
    Case(_SECOND, wedges, 1, 10, 2000, 1e-3, (2.0, 5.0, 10.0, 15.0, 25.0)),
    Case(_LIGHT, rocking, 0, 5, 700, 5e-3, (0.33, 0.51, 0.83, 1.7)),
    Case(
        "heavy block, lift-off",
        partial(rocking, 4.0, 1.5),
        0,
        5,
        700,
        5e-3,
        (0.54, 0.81, 1.66, 3.7),
    ),
)


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Largest number of forces that are tried in each case.
    most_forces: int = 5
    # Number of load factors of a curve.
    factors: int = 60
    # Number of time steps in a period.
    steps: int = 600
    # Numbers of periods at the first frequency, and at each other frequency.
    first: int = 400
    periods: int = 100
    # Ratio of neighbouring frequencies.
    ratio: float = 1.002
    # A sweep begins above the glued frequency, and ends below the resonance of the approximation.
    above: float = 1.02
    below: float = 0.95
    few_factors: tuple[int, ...] = (8, 20, 40)
    many_factors: int = 200
    # Number of load factors of the curve with a range.
    band_factors: int = 16
    # Number of random joints of one mass, and of load factors of their curves.
    joints: int = 300
    joint_factors: int = 20
    # Number of random residual slips.
    starts: int = 11
    seed: int = 0


FULL = Parameters()
QUICK = Parameters(
    most_forces=1,
    factors=12,
    steps=300,
    first=60,
    periods=15,
    ratio=1.02,
    few_factors=(8,),
    many_factors=20,
    band_factors=4,
    joints=1,
    starts=1,
)


def peaks(parameters: Parameters) -> Iterator[Row]:
    """One row for each case and force."""
    for case in each(CASES, "structures"):
        structure = case.make()
        curve = _curve(case, parameters.factors)
        modes = range(len(structure.mass))
        others = [f"mode {number}" for number in modes if number != case.mode]
        forces = case.forces[: parameters.most_forces]
        answer = curve.response(forces, damping=case.damping, other_modes=others)
        for force, row in zip(forces, answer.to_frame().to_dict("records"), strict=True):
            yield {
                "structure": case.about,
                "damping": case.damping,
                "force": force,
                "peak": row["peak"],
                "resonance": row["resonance"],
                "sensitivity": row["sensitivity"],
                "interaction": row["interaction"],
                "residual": curve.residual,
                **_swept(parameters, case, curve, force, row["resonance"]),
            }


def _curve(case: Case, factors: int, **options: bool) -> fo.results.BackboneCurve:
    load_factors = np.geomspace(case.least, case.most, factors)
    return case.make().curve(case.mode, load_factors, **options)


def _swept(
    parameters: Parameters,
    case: Case,
    curve: fo.results.BackboneCurve,
    force: float,
    resonance: float,
) -> dict[str, float]:
    """The peaks of a sweep down and of a sweep up, and the frequency of the larger peak."""
    high = parameters.above * curve.natural_frequency
    # The peak may be beyond the curve. Then the whole range of the curve is swept.
    if np.isnan(resonance):
        resonance = float(np.nanmin(curve.resonance))
    low = parameters.below * resonance
    frequencies = np.geomspace(high, low, int(np.log(high / low) / np.log(parameters.ratio)) + 2)
    seen = []
    for order in (frequencies, frequencies[::-1]):
        vibration = Vibration(
            case.make(), case.mode, case.damping, parameters.steps, point=case.point
        )
        seen.append(vibration.sweep(force, order, parameters.first, parameters.periods))
    (down, at_down), (up, at_up) = seen
    return {
        "down": down,
        "up": up,
        "seen_peak": max(down, up),
        "seen_resonance": at_down if down >= up else at_up,
    }


def few(parameters: Parameters) -> Iterator[Row]:
    """One row for each number of load factors and force of the first case."""
    case = CASES[0]
    # Above this load factor both wedges slide.
    most = 1000.0
    forces = [10.0, 30.0, 40.0]

    def answer(number: int) -> fo.results.ForcedResponse:
        curve = case.make().curve(case.mode, np.geomspace(case.least, most, number))
        return curve.response(forces, damping=case.damping)

    best = answer(parameters.many_factors)
    for number in each(parameters.few_factors, "numbers of load factors"):
        fewer = answer(number)
        for row, force in enumerate(forces):
            yield {
                "load_factors": number,
                "force": force,
                "peak_error": fewer.peak[row] / best.peak[row] - 1,
                "resonance_error": fewer.resonance[row] / best.resonance[row] - 1,
                "residual": 0.0,
            }


def band(parameters: Parameters) -> Iterator[Row]:
    """One row for each force and start of the first case, swept down."""
    case = CASES[0]
    load_factors = np.geomspace(120, 1000, parameters.band_factors)
    curve = case.make().curve(case.mode, load_factors, with_range=True)
    # Largest random slip. In a cycle a wedge slips by about 1e-3.
    largest = 1.2e-3
    rng = np.random.default_rng(parameters.seed)
    forces = (6.0, 10.0, 20.0, 30.0)[: parameters.most_forces]
    answer = curve.response(forces, damping=case.damping)
    for row, force in enumerate(each(forces, "forces")):
        # The first start is the state of rest.
        for start in range(parameters.starts + 1):
            slip = rng.uniform(-largest, largest, 2) if start else None
            vibration = Vibration(
                case.make(), case.mode, case.damping, parameters.steps, residual_slip=slip
            )
            high = parameters.above * curve.natural_frequency
            low = parameters.below * answer.resonance[row]
            number = int(np.log(high / low) / np.log(parameters.ratio)) + 2
            frequencies = np.geomspace(high, low, number)
            seen, _ = vibration.sweep(force, frequencies, parameters.first, parameters.periods)
            yield {
                "force": force,
                "start": start,
                "least_peak": answer.least_peak[row],
                "most_peak": answer.most_peak[row],
                "seen_peak": seen,
                "residual": curve.residual,
            }


def masses(parameters: Parameters) -> Iterator[Row]:
    """One row for each random joint, which carries one mass, and for each force."""
    for number in each(range(parameters.joints), "random joints"):
        rng = np.random.default_rng([parameters.seed, number])
        joint = random_mass(rng)
        damping = float(rng.choice([0.001, 0.005, 0.02]))
        # Friction alone holds few forces that are larger.
        forces = joint.first_slip * np.array([0.3, 0.6, 1.1])
        curve = joint.curve(joint.first_slip * np.geomspace(0.2, 12.0, parameters.joint_factors))
        answer = curve.response(forces, damping=damping, other_modes=["far"])
        for row in answer.to_frame().to_dict("records"):
            seen = np.nan, np.nan
            if not row["beyond"]:
                seen = joint.peak(row["force"], damping)
            yield {
                "number": number,
                "nodes": len(joint.preload),
                "damping": damping,
                "force": row["force"],
                "peak": row["peak"],
                "resonance": row["resonance"],
                "sensitivity": row["sensitivity"],
                "interaction": row["interaction"],
                "unchecked": "not checked" in answer.note,
                "seen_peak": seen[0],
                "seen_resonance": seen[1],
                "residual": curve.residual,
            }


PEAKS = Table(
    "forced_response",
    "one structure under one force",
    {
        "structure": "which structure and mode",
        "damping": "damping ratio of material and air",
        "force": "modal force",
        "peak": "largest modal amplitude of the approximation; inf beyond the curve",
        "resonance": "its frequency, Hz",
        "sensitivity": "-d ln peak / d ln work of the approximation",
        "interaction": "change of the peak that other harmonics and other modes may cause",
        "down": "largest modal amplitude of a sweep down, by time integration",
        "up": "the same of a sweep up",
        "seen_peak": "the larger one of both",
        "seen_resonance": "its frequency, Hz",
    },
    FULL,
    QUICK,
    peaks,
)
FEW = Table(
    "forced_response_factors",
    "one number of load factors and one force",
    {
        "load_factors": "number of load factors of the curve",
        "force": "modal force",
        "peak_error": "relative difference of the peak to that of the curve with most load factors",
        "resonance_error": "the same of the resonance",
    },
    FULL,
    QUICK,
    few,
)
BAND = Table(
    "forced_response_band",
    "one force and one start; start 0 is the state of rest",
    {
        "force": "modal force",
        "start": "number of the start",
        "least_peak": "least peak of the band over residual slips",
        "most_peak": "largest peak of this band",
        "seen_peak": "largest modal amplitude of a sweep down, by time integration",
    },
    FULL,
    QUICK,
    band,
)
MASSES = Table(
    "forced_response_masses",
    "one mass on a random joint under one force",
    {
        "number": "number of the joint",
        "nodes": "number of its nodes",
        "damping": "damping ratio of material and air",
        "force": "modal force",
        "peak": "largest modal amplitude of the approximation; inf beyond the curve",
        "resonance": "its frequency, Hz",
        "sensitivity": "-d ln peak / d ln work of the approximation",
        "interaction": "change of the peak that other harmonics may cause",
        "unchecked": "whether no steady state is at a peak of the joint",
        "seen_peak": "largest modal amplitude by time integration; NaN beyond the curve",
        "seen_resonance": "its frequency, Hz",
    },
    FULL,
    QUICK,
    masses,
)

# Interaction above which the note of a response doubts its peak.
_SORTED_AT = 0.05


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The errors of peaks, sorted by the interaction; the errors with few load factors; and the band."""
    table = tables[PEAKS.name]
    parts = [_errors(table), _sorting(table), _masses(tables[MASSES.name]), _folds(table)]
    return "\n\n".join([*parts, _few(tables[FEW.name]), _band(tables[BAND.name])])


def _error(table: pd.DataFrame) -> "pd.Series[float]":
    return 100 * (table["peak"] / table["seen_peak"] - 1)


def _errors(table: pd.DataFrame) -> str:
    """A row for each force."""
    rows = []
    shifts = 100 * (table["resonance"] / table["seen_resonance"] - 1)
    for row, error, shift in zip(table.to_dict("records"), _error(table), shifts, strict=True):
        case = [row["structure"], f"{100 * row['damping']:g} %", f"{row['force']:g}"]
        if np.isfinite(row["peak"]):
            numbers = [f"{error:+.1f} %", f"{shift:+.1f} %", f"{row['sensitivity']:.2g}"]
            rows.append([*case, *numbers, f"{row['interaction']:.2g}"])
        else:
            rows.append([*case, "no peak on the curve", "", "", ""])
    head = ["structure and mode", "added damping", "modal force", "error of the peak"]
    head += ["error of the resonance", "sensitivity", "interaction"]
    return markdown(head, rows)


def _sorting(table: pd.DataFrame) -> str:
    """The errors of the peaks with little interaction, and of the others, a sentence for each."""
    known = table[np.isfinite(table["peak"])]
    errors, small = _error(known).abs(), known["interaction"] <= _SORTED_AT
    said = []
    for word, chosen in (("at most", small), ("above", ~small)):
        if chosen.any():
            least, most = errors[chosen].min(), errors[chosen].max()
            said.append(
                f"The interaction is {word} {_SORTED_AT:g} for {chosen.sum()} of {len(known)} "
                f"peaks, with errors of {least:.1f} to {most:.1f} %."
            )
    return " ".join(said)


def _masses(table: pd.DataFrame) -> str:
    """Sentences on the peaks of the random joints."""
    joints = table["number"].nunique()
    beyond = np.isinf(table["peak"]).sum()
    unchecked = table.loc[table["unchecked"], "number"].nunique()
    return (
        f"One mass on {joints} random joints, each with three forces: {beyond} of {len(table)} "
        f"peaks lie beyond the curve, and {unchecked} joints have a peak that is not checked. "
        f"The median error is {_error(table[np.isfinite(table['peak'])]).abs().median():.1f} %. "
        f"{_sorting(table)}"
    )


def _folds(table: pd.DataFrame) -> str:
    """A sentence on the ratio of the peak of a sweep up to the peak of a sweep down."""
    share = table["up"] / table["down"]
    lift_off = table["structure"].str.contains("lift-off")
    said = []
    for name, chosen in (("the blocks, which lift off", lift_off), ("the oscillator", ~lift_off)):
        if chosen.any():
            least, most = share[chosen].min(), share[chosen].max()
            said.append(f"{least:.2f} to {most:.2f} of it for {name}")
    return f"The peak of a sweep up, over the peak of a sweep down: {'; '.join(said)}."


def _few(table: pd.DataFrame) -> str:
    """The largest errors of each number of load factors."""
    rows = []
    for number, group in table.groupby("load_factors"):
        errors = 100 * group[["peak_error", "resonance_error"]].abs().max()
        rows.append([f"{number}", *(f"{error:.2g} %" for error in errors)])
    head = ["load factors", "largest error of a peak", "largest error of a resonance"]
    return markdown(head, rows)


def _band(table: pd.DataFrame) -> str:
    """The band of each force, and the peaks of the sweeps from all starts."""
    rows = []
    for force, group in table.groupby("force"):
        least, most = group["least_peak"].iloc[0], group["most_peak"].iloc[0]
        seen = group["seen_peak"]
        band = f"{1e3 * least:.3f} to {1e3 * most:.3f}"
        peaks = f"{1e3 * seen.min():.3f} to {1e3 * seen.max():.3f}"
        rows.append([f"{force:g}", band, peaks, f"{len(group)}"])
    head = ["modal force", "band of the peak / 1e-3", "peaks of sweeps / 1e-3"]
    head += ["starts of sweeps: without slip, and random residual slips"]
    return markdown(head, rows)


STUDY = Study(
    __name__,
    __doc__,
    "one force for each structure and a coarse sweep that is too short for a peak, in seconds",
    (PEAKS, MASSES, FEW, BAND),
    summary,
)
