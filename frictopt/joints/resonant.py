"""Responses and largest forces at the resonance of the mode of a backbone curve."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from ..base import Array, finite_number, frozen, listed, progress_bar
from ..errors import ModelError, NoContinuation, SolverError
from ..transients import steady_state
from .curve_question import load_of_curve, measured_cycle
from .forced_response import (
    ForcedResponse,
    detached_of,
    folds_of,
    positive_numbers,
    response_curves,
)
from .modal_oscillator import ModalOscillator, OtherModes, checked_modes, interaction_at

# Steady states at the amplitudes that a response needs. They are added to the points of its curve.
#
# Between the load factors of a curve, stiffness and loss are interpolated. A steady state at the
# amplitude of a peak shows the force that the peak needs.

# A mode, and the amplitudes at which states are wanted, each with the name of the force or of the
# limit that needs it.
Wanted: TypeAlias = tuple[ModalOscillator, Iterable[tuple[str, float]]]

# A function of the points of a curve.
WantedOf: TypeAlias = Callable[[pd.DataFrame], Wanted]


# The numbers of the check.

# A state counts as being at a wanted amplitude up to this relative difference in amplitude, and in
# the force that the amplitude needs.
_SAME = 0.01
# Largest number of steady states for one name. 300 forces on random joints of one mass needed at
# most 10.
_MOST = 20
# Every third state halves an interval of load factors, because interpolation fails where a small
# rise of the load moves the joint far.
_HALVED = 3


def checked_points(
    points: pd.DataFrame, wanted_of: WantedOf, follow: Callable[[float], dict[str, Any]]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Follow the joint at wanted amplitudes, until the curve has a state at each of them.

    Parameters
    ----------
    points
        The points of the curve, with the columns load_factor, displacement, resonance, steady and
        all columns that `wanted_of` needs; load factor and displacement rise from row to row.
    wanted_of, follow
        See `WantedOf`; and a function that returns the row of a point at a load factor, with its
        steady state.

    Returns
    -------
    DataFrame
        The points of the curve, with the added states.
    dict
        Name -> reason why no state is at its amplitude.
    """
    unchecked = dict[str, str]()
    followed = Counter[str]()
    while True:
        oscillator, wanted = wanted_of(points)
        far = (
            (name, a)
            for name, a in wanted
            if name not in unchecked and not _has_state_at(oscillator, a)
        )
        name, a = next(far, ("", np.nan))
        if np.isnan(a):
            return points, unchecked
        if followed[name] == _MOST:
            unchecked[name] = f"{_MOST} steady states near it are not enough"
            continue
        followed[name] += 1
        factor = _load_factor(points, a, followed[name] % _HALVED == 0)
        try:
            row = pd.DataFrame([follow(factor)], columns=points.columns)
        except (NoContinuation, SolverError) as error:
            unchecked[name] = f"no steady state at the load factor {factor:g}: {error}"
            continue
        joined = pd.concat([points, row], ignore_index=True).sort_values("load_factor")
        if row["resonance"].isna().all():
            unchecked[name] = f"no resonance at the load factor {factor:g}"
        elif not (np.diff(joined["displacement"]) > 0).all():
            unchecked[name] = f"the amplitude does not rise at the load factor {factor:g}"
        else:
            points = joined.reset_index(drop=True)


def _has_state_at(oscillator: ModalOscillator, a: float) -> bool:
    """Whether a known state has an amplitude, and the force that this amplitude needs."""
    nearest = oscillator.amplitude[np.abs(oscillator.amplitude - a).argmin()]
    needed, wanted = oscillator.needed(np.array([nearest, a]))
    return bool(abs(nearest - a) <= _SAME * a and abs(needed - wanted) <= _SAME * wanted)


def _load_factor(points: pd.DataFrame, a: float, is_halved: bool) -> float:
    """Load factor of an amplitude by interpolation, or halfway between its two neighbours."""
    amplitudes = np.append(0.0, points["displacement"])
    factors = np.append(0.0, points["load_factor"])
    if is_halved:
        above = int(np.searchsorted(amplitudes, a))
        return float(factors[above - 1 : above + 1].mean())
    return float(PchipInterpolator(amplitudes, factors)(a))


# Fewest load factors with a resonance: two points show no curve.
_FEWEST = 3
# The peak under this share of a force shows how strongly the peak changes with the force. Checked
# peaks are right to about 1 %, so a share closer to 1 would show their errors.
_WEAKER = 0.95


class Resonant:
    """Base of curves whose load may be the load of a mode."""

    def response(
        self: Any,
        forces: ArrayLike,
        *,
        damping: float = 0.0,
        scale: float = 1.0,
        other_modes: Sequence[str] = (),
        progress: bool = True,
    ) -> ForcedResponse:
        """The response to harmonic forces near the resonance of the mode.

        The stiffness of the mode follows from the first harmonic of its loop, and its loss from the
        work of friction. Both are interpolated over the amplitude. Steady states at the amplitude
        of each peak are added to the points of the curve until the force balances to 1 %. The
        answer is an approximation, not a bound. See "The forced response" in both Validity and
        Theory.

        Parameters
        ----------
        forces
            (F,) amplitudes of the modal force, > 0, in units of force / square root of mass.
            `Modes.force` returns the modal force of a load, or of a shaken base.
        damping
            Damping ratio of material and air for the glued mode, at least 0 and below 1. With 0,
            friction alone damps, and it cannot balance every force once the contact slides in full.
        scale
            Motion of a point per modal amplitude, > 0. All amplitudes are then amplitudes of this
            point.
        other_modes
            Names of load cases that are the loads of other modes, see `Modes.load`.
            `ForcedResponse.interaction` then shows how strongly these modes take part.
        progress
            Whether to show a bar after two seconds, which counts the steady states.

        Raises
        ------
        ModelError
            Bad input; a curve without frequencies, with fewer than three load factors that have a
            resonance, or with an amplitude that falls; names in `other_modes` that are not loads of
            modes.

        Examples
        --------
        >>> import numpy as np
        >>> import frictopt as fo
        >>> loads = {"N": ([0.0], [1.0]), "mode": ([-1.0], [0.0])}
        >>> blocks = [[1.0]], [[0.0]], [[1.0]], [0.0], loads
        >>> slider = fo.ContactSystem.from_blocks(*blocks, compliance=[[0, 0], [0, 1]])
        >>> cycle = fo.LoadCycle({"N": 2.0}, [{"mode": 1.0}, {"mode": -1.0}])
        >>> factors = np.geomspace(0.5, 8.0, 30)
        >>> curve = fo.joints.backbone_curve(
        ...     slider, cycle, 1.0, factors, natural_frequency=0.5 / np.pi
        ... )
        >>> answer = curve.response([0.02, 0.6], damping=0.01)  # 1 / (2 x 0.01) x 0.02 = 1
        >>> answer.peak.round(2).tolist(), answer.beyond.tolist()
        ([1.0, 3.46], [False, False])
        """
        wanted = positive_numbers("forces", forces)
        ratio = finite_number("damping", damping, least=0.0, below=1.0)
        size = finite_number("scale", scale, above=0.0)
        names = listed("other_modes", other_modes)
        own = _points_of(self)
        others = checked_modes(self.system, self.cycle, names) if len(names) else None

        def peaks(points: pd.DataFrame) -> Wanted:
            oscillator = _oscillator(self, points, ratio)
            pairs = (
                (f"{force:g}", a)
                for force in wanted.tolist()
                for part in (1.0, _WEAKER)
                for a in oscillator.peaks(part * force)
            )
            return oscillator, pairs

        points, unchecked = _checked(self, own, peaks, progress)
        oscillator = _oscillator(self, points, ratio)
        return _Answer(self, points, wanted, size, oscillator, others, unchecked).result()

    def largest_force(
        self: Any,
        *,
        amplitude: float | None = None,
        slip_range: float | None = None,
        slipping: float | None = None,
        work: float | None = None,
        damping: float = 0.0,
        scale: float = 1.0,
        progress: bool = True,
    ) -> float:
        """The largest modal force whose resonance, swept from rest, stays within a limit.

        The curve turns the limit into an amplitude. Steady states at this amplitude, and at the
        amplitude that needs the largest force, are added to the points of the curve until the force
        balances to 1 %.

        Parameters
        ----------
        amplitude, slip_range, slipping, work
            The largest amplitude (of the point of `scale`), slip range of a node, share of the
            contact that slips, or work of friction per cycle, > 0; one of the four.
        damping, scale, progress
            See `response`.

        Raises
        ------
        ModelError
            Not exactly one of the four limits is given, or the curve does not reach it; and the
            errors of `response`.
        SolverError
            No steady state is found at an amplitude.

        Examples
        --------
        >>> import numpy as np
        >>> import frictopt as fo
        >>> loads = {"N": ([0.0], [1.0]), "mode": ([-1.0], [0.0])}
        >>> blocks = [[1.0]], [[0.0]], [[1.0]], [0.0], loads
        >>> slider = fo.ContactSystem.from_blocks(*blocks, compliance=[[0, 0], [0, 1]])
        >>> cycle = fo.LoadCycle({"N": 2.0}, [{"mode": 1.0}, {"mode": -1.0}])
        >>> factors = np.geomspace(0.5, 8.0, 40)
        >>> curve = fo.joints.backbone_curve(
        ...     slider, cycle, 1.0, factors, natural_frequency=0.5 / np.pi
        ... )
        >>> round(curve.largest_force(amplitude=4.0), 2)  # 4 (1 - 2 / 4) / pi
        0.64
        """
        ratio = finite_number("damping", damping, least=0.0, below=1.0)
        size = finite_number("scale", scale, above=0.0)
        limits = {
            "amplitude": amplitude,
            "slip_range": slip_range,
            "slipping": slipping,
            "work": work,
        }
        named = {name: value for name, value in limits.items() if value is not None}
        if len(named) != 1:
            values = ", ".join(f"{name}={value}" for name, value in named.items()) or "none"
            raise ModelError(f"{', '.join(limits)}: {values}; give one of the four")
        ((name, value),) = named.items()
        limit = finite_number(name, value, above=0.0)

        def amplitudes(points: pd.DataFrame) -> Wanted:
            oscillator = _oscillator(self, points, ratio)
            end = _amplitude_at(points, name, limit, size)
            return oscillator, [(name, end), (name, oscillator.strongest(end))]

        points, unchecked = _checked(self, _points_of(self), amplitudes, progress)
        if unchecked:
            raise SolverError(
                f"{name}: {limit:g}, and the force there is not known to 1 %: {unchecked[name]}; "
                "give a smaller limit"
            )
        oscillator, ((_, _), (_, strongest)) = amplitudes(points)
        return float(oscillator.needed(strongest))


def _checked(
    curve: Any, points: pd.DataFrame, wanted_of: WantedOf, progress: bool
) -> tuple[pd.DataFrame, dict[str, str]]:
    """The points of a curve with further steady states, see `checked_points`."""
    load = load_of_curve(curve.system, curve.cycle, curve.friction, curve.natural_frequency)
    with progress_bar(progress, "response", "steady state") as bar:

        def follow(factor: float) -> dict[str, Any]:
            steady = steady_state(
                curve.system,
                curve.cycle,
                curve.friction,
                factor,
                steps=curve.steps,
                progress=False,
            )
            bar.update()
            row, _ = measured_cycle(steady, load)
            return {**row, "steady": steady}

        return checked_points(points, wanted_of, follow)


def _points_of(curve: Any) -> pd.DataFrame:
    """The load factors up to the first one without a resonance; their amplitudes rise."""
    if np.isnan(curve.natural_frequency):
        raise ModelError(
            "natural_frequency: not known to the curve; give it to `backbone_curve`, with the load "
            "of a mode (`Modes.load`)"
        )
    names = (
        "load_factor",
        "displacement",
        "resonance",
        "damping",
        "work",
        "slip_range",
        "slipping",
    )
    table = pd.DataFrame({name: getattr(curve, name) for name in names})
    table["steady"] = curve.steady_states
    known = table[["displacement", "resonance", "damping"]].notna().all(axis=1).cumprod() > 0
    points = table[known].reset_index(drop=True)
    if len(points) < _FEWEST:
        found = f"{len(points)}, and all have a resonance; "
        if len(points) < len(table):
            found = (
                f"{len(points)} of {len(table)} up to the first one without a resonance "
                f"({curve.note}); "
            )
        raise ModelError(f"load_factors: {found}give at least {_FEWEST}, better 20")
    if not (np.diff(points["displacement"], prepend=0.0) > 0).all():
        raise ModelError(
            f"displacement: {points['displacement'].tolist()}; the amplitude of this curve does "
            "not rise with the load factor, so a resonance cannot be read from it"
        )
    return points


def _oscillator(curve: Any, states: pd.DataFrame, damping: float) -> ModalOscillator:
    """The mode in some steady states at rising load factors."""
    columns = ["load_factor", "displacement", "resonance", "damping"]
    factor, a, resonance, ratio = states[columns].to_numpy(dtype=float).T
    # The damping ratio of friction is W / (2 pi load_factor a), and the loss W / (pi a^2).
    loss = frozen(2 * ratio * factor / a)
    stiffness = frozen((2 * np.pi * resonance) ** 2)
    return ModalOscillator(frozen(a), stiffness, loss, 2 * np.pi * curve.natural_frequency, damping)


def _extreme(
    curve: Any, points: pd.DataFrame, extreme: str, damping: float
) -> ModalOscillator | None:
    """The mode in its states of least or most damping.

    None if a point has no such state, if a state has no resonance, or if their amplitudes do not
    rise.
    """
    states = curve.extremes[curve.extremes["extreme"] == extreme]
    states = states[states["load_factor"].isin(points["load_factor"])]
    complete = len(states) == len(points) and states["resonance"].notna().all()
    if not complete or not (np.diff(states["displacement"], prepend=0.0) > 0).all():
        return None
    return _oscillator(curve, states, damping)


def _amplitude_at(points: pd.DataFrame, name: str, limit: float, scale: float) -> float:
    """Modal amplitude up to which a column of the curve stays at or below a limit."""
    a = np.append(0.0, points["displacement"])
    values = scale * a if name == "amplitude" else np.append(0.0, points[name])
    above = np.flatnonzero(values > limit)
    if len(above):
        pair = slice(above[0] - 1, above[0] + 1)
        return float(np.interp(limit, values[pair], a[pair]))
    if limit > values.max():
        raise ModelError(
            f"{name}: {limit:g}, and the curve reaches {values.max():.6g}; give a smaller limit, "
            "or compute a curve with more load_factors"
        )
    return float(a[-1])


@dataclass(frozen=True)
class _Answer:
    """The data of a response: a curve, its points with a resonance, the forces, and the mode."""

    curve: Any
    points: pd.DataFrame
    forces: Array
    scale: float
    oscillator: ModalOscillator
    others: OtherModes | None
    unchecked: Mapping[str, str]

    def result(self) -> ForcedResponse:
        """The response to all forces."""
        curves = pd.concat(
            [response_curves(self.oscillator, force) for force in self.forces], ignore_index=True
        )
        curves["amplitude"] *= self.scale
        detached = pd.DataFrame(
            [row for force in self.forces for row in detached_of(self.oscillator, float(force))],
            columns=["force", "least", "most"],
        )
        detached[["least", "most"]] *= self.scale
        rows = pd.DataFrame([self._row(float(force)) for force in self.forces])
        least, most = self._band(rows["peak"].to_numpy())
        rows[["peak", "least_peak", "most_peak"]] = (
            self.scale * np.array([rows["peak"], least, most]).T
        )
        return ForcedResponse(
            **{name: frozen(rows[name]) for name in rows if name != "beyond"},
            beyond=rows["beyond"].to_numpy(dtype=bool),
            branches=curves,
            folds=folds_of(curves),
            detached=detached,
            damping=self.oscillator.damping,
            scale=self.scale,
            oscillator=self.oscillator,
            note="; ".join(self._notes(rows, detached)),
            units=self.curve.system.units,
        )

    def _row(self, force: float) -> dict[str, Any]:
        """Numbers of the peak of one force, in modal amplitudes."""
        peak = next(iter(self.oscillator.peaks(force)), np.inf)
        if peak == np.inf:
            names = ("resonance", "lag", "sensitivity", "interaction")
            return {"force": force, "peak": peak, "beyond": True} | dict.fromkeys(names, np.nan)
        nearest = np.abs(self.oscillator.amplitude - peak).argmin()
        omega = float(self.oscillator.resonance(peak))
        balance = complex(self.oscillator.balance(peak, omega))
        weaker = self.oscillator.peaks(_WEAKER * force)[0]
        gain = np.log(weaker / peak) / np.log(_WEAKER)
        left_out = interaction_at(self.points["steady"].iloc[nearest], self.others, omega)
        return {
            "force": force,
            "peak": peak,
            "beyond": False,
            "resonance": omega / (2 * np.pi),
            "lag": np.angle(balance, deg=True),
            "sensitivity": gain * self.oscillator.friction_share(peak),
            "interaction": gain * left_out,
        }

    def _band(self, peaks: Array) -> tuple[Array, Array]:
        """Least and most peak over the residual slips of the range; NaN without a range."""
        found = [peaks]
        points = _points_of(self.curve)
        for extreme in ("most", "least"):
            oscillator = _extreme(self.curve, points, extreme, self.oscillator.damping)
            if oscillator is None:
                unknown = np.full(len(peaks), np.nan)
                return unknown, unknown
            found.append(
                np.array([next(iter(oscillator.peaks(force)), np.inf) for force in self.forces])
            )
        return np.min(found, axis=0), np.max(found, axis=0)

    def _notes(self, rows: pd.DataFrame, detached: pd.DataFrame) -> list[str]:
        """Sentences about effects that the numbers do not include."""
        notes = ["an approximation by one mode, not a bound"]
        last = self.curve.load_factor[-1]
        used = self.points["load_factor"].iloc[-1]
        if used < last:
            notes.append(
                f"the curve is used up to the load factor {used:g}, above which it has no resonance"
            )
        strongest = self.oscillator.strongest(self.oscillator.largest)
        holds = float(self.oscillator.needed(strongest))
        # Above this interaction a peak may change much. In the tables of the study
        # "forced_response", the error of a peak is at most 7 % up to this interaction.
        largest = 0.05
        doubtful = ~(rows["interaction"] <= largest) & ~rows["beyond"]
        said = {
            f"the peak lies beyond the curve, which holds forces up to {holds:.6g}: give more "
            "load factors, or the damping of the material": rows["beyond"],
            f"the interaction is not below {largest:g}: other harmonics or other modes, which the "
            "approximation leaves out, may change the peak by more than a tenth": doubtful,
            "a sweep from rest does not reach the detached curve": rows["force"].isin(
                detached["force"]
            ),
        }
        for sentence, holds_for in said.items():
            if holds_for.any():
                names = ", ".join(f"{force:g}" for force in self.forces[holds_for.to_numpy()])
                notes.append(f"force {names}: {sentence}")
        notes += [
            f"force {name}: the peak is not checked: {reason}"
            for name, reason in self.unchecked.items()
        ]
        if self.others is None:
            notes.append("without other_modes it is unknown whether other modes interact")
        if np.isnan(rows["least_peak"]).all():
            notes.append(
                "the peak has no range: the curve has no range, or its states have no resonance"
            )
        return notes
