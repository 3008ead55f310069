"""Safety factors of a joint and verdicts on its thresholds, with the scatter of its input.

A safety factor is the number by which the cyclic load may grow. If equilibrium determines the
gross-slip load, theorems locate the worst input. More friction never lowers this load. The load is
also a concave function of the preloads, so its minimum is at a corner of their ranges. Steady slip
has no such theorem, so the nominal input and all corners of the ranges are followed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ..base import CONDENSATION, ROUNDING, Array, Booleans, Loads, progress_bar
from ..contact import ContactState, ContactSystem, LoadCycle, joined, reactions
from ..contact.components import null_space
from ..contact.diagnosis import nodes_of_contacts
from ..errors import NoContinuation, SolverError
from ..limits import GrossSlip, gross_slip
from ..limits.balance.statics import (
    MOVES,
    FaceLoad,
    drives,
    slides_in_full_at,
)
from ..limits.program.question import outer_corners
from ..transients import SteadyState, steady_state
from ..transients.fretting import rows_of_corners
from ..transients.march import mean_state, path_of
from ..transients.steady import settled_from
from .scatter import NOMINAL, Corner, Scatter
from .thresholds import (
    BELOW_GROSS_SLIP,
    FACE_SLIP,
    GROSS_SLIP,
    LARGEST_LOAD,
    QUANTITIES,
    SLIP_RANGE,
    SLIPPING_SHARE,
    TOLERANCE,
    Judged,
    load_at_threshold,
    place_of_node,
)

# The table of the faces of a joint: when each one slides in full, its utilisation, its slip.


def face_table(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Array,
    mean: ContactState,
    steady: SteadyState | None,
    gross_slip: GrossSlip | None,
    model: Any,
) -> pd.DataFrame:
    """A row for each contact, and for each tie of the model, see `Report.contacts`."""
    faces = nodes_of_contacts(system)
    table = pd.DataFrame({"contact": list(faces)})
    ties = table[:0]
    corners = {"slides_at": _under_mean_load(system, cycle, mean)}
    if steady is not None:
        table = steady.by_contact(model)
        table, ties = table[: len(faces)].copy(), table[len(faces) :]
        with np.errstate(divide="ignore", invalid="ignore"):
            used = [np.abs(table[f"Q_{k}"]) / table[f"fP_{k}"] for k in range(len(cycle.corners))]
        utilisation = np.nan_to_num(used, nan=0.0).max(axis=0)
        table["utilisation"] = np.where(utilisation > ROUNDING, utilisation, 0.0)
        corners["slides_at_steady"] = _in_steady_state(corners["slides_at"], steady)
    for name, of_cycle in corners.items():
        table[name] = _slide_in_full_at(system, friction, of_cycle)
    if gross_slip is not None:
        share = gross_slip.carried()
        table["carries"] = [share[face].sum() for face in faces.values()]
        # If a face moves when bodies slide off, it slides in full at this load or below.
        moves = [np.abs(gross_slip.phi[:, face]).max() > MOVES for face in faces.values()]
        for name in corners:
            table[name] = np.fmin(table[name], np.where(moves, factor_of(gross_slip), np.inf))
    if steady is not None:
        ranges = np.asarray(steady.fretting_table()["slip_range"])
        table["where"] = [_place_of_most(system, ranges, face) for face in faces.values()]
    return pd.concat([table, ties], ignore_index=True) if len(ties) else table


def _slide_in_full_at(
    system: ContactSystem, friction: Array, loads: Mapping[int, FaceLoad]
) -> list[float]:
    """The load factor at which each face slides in full, under the loads at some corners."""
    faces = nodes_of_contacts(system).values()
    return [slides_in_full_at(system, friction, face, loads.values()) for face in faces]


def factor_of(gross: GrossSlip) -> float:
    """The safety factor of a sliding-off load.

    The factor is 0 if no state of rest exists at load factor 1 or below.
    """
    if np.isnan(gross.load_factor) or gross.least > 1 + ROUNDING:
        return 0.0
    return gross.load_factor


def _under_mean_load(
    system: ContactSystem, cycle: LoadCycle, mean: ContactState
) -> dict[int, FaceLoad]:
    """Loads at the vertices of the hull of the load corners, with the normal forces of `mean`."""
    bonded = joined(mean.bonded_q, mean.bonded_p)
    p = (bonded + system.S @ joined(mean.slip, mean.gap - system.gap))[-system.nodes :]
    motions = system.rigid_motions
    slides = motions @ null_space(motions[-system.nodes :], CONDENSATION)

    def driving(loads: Loads) -> dict[str, float]:
        """The loads that slide a body. Slip relieves all other loads, such as preloads."""
        if not motions.size:
            return dict(loads)
        return {
            case: amplitude
            for case, amplitude in loads.items()
            if drives(slides, reactions(system, [{case: 1.0}])[0])
        }

    constant = reactions(system, cycle.unscaled)
    shear = reactions(system, [driving(loads) for loads in cycle.unscaled])
    cyclic = reactions(system, cycle.corners)
    # Without fixed parts all corners have the same constant load.
    last = len(constant) - 1
    return {
        k: FaceLoad(constant[min(k, last)], shear[min(k, last)], cyclic[k], p, bonded)
        for k in outer_corners(cycle)
    }


def _in_steady_state(corners: Mapping[int, FaceLoad], steady: SteadyState) -> dict[int, FaceLoad]:
    """The loads at the corners, with the normal forces of the steady state there."""
    states = steady.states()
    rows = rows_of_corners(states)
    return {
        k: corner._replace(p=states.p[rows[k]], of_state=corner.constant + corner.cyclic)
        for k, corner in corners.items()
    }


def _place_of_most(system: ContactSystem, values: Array, face: Booleans) -> str:
    """The place of the node of a face at which values (N,) are largest; "" if all are 0."""
    node = int(np.argmax(np.where(face, values, -np.inf)))
    return place_of_node(system, node) if values[node] > 0 else ""


_NO_SCATTER = "at the nominal input, because nothing scatters"
_BY_THEOREM = (
    "by a theorem: the load from equilibrium never falls with friction, and is a "
    "concave function of the preloads"
)
_BY_CORNERS = (
    "at the nominal input and the corners of the ranges; no theorem covers the inputs between them"
)
_NO_STEADY_STATE = "no steady state: {reason}"

SAFETY_COLUMNS = ["against", "nominal", "worst", "at", "by"]
VERDICT_COLUMNS = ["quantity", "value", "limit", "unit", "passed", "margin", "where", "at"]

SteadyAnswer = SteadyState | NoContinuation | SolverError


@dataclass
class SteadyStates:
    """Steady states of a joint for corners of the scatter and load factors, each followed once.

    With increments, a steady state at a load factor other than 1 begins at the state under the mean
    load, which is computed once per corner. Such a steady state has no `step_error`.
    """

    system: ContactSystem
    scatter: Scatter
    steps: int | None
    known: dict[tuple[str, float], SteadyAnswer] = field(default_factory=dict)
    mean_states: dict[str, ContactState] = field(default_factory=dict)

    def all_corners(self) -> list[Corner]:
        """The nominal input, and the corners of the ranges if anything scatters."""
        corners = self.scatter.corners() if self.scatter.exists else []
        return [self.scatter.nominal(), *corners]

    def at(self, corner: Corner, factor: float) -> SteadyAnswer:
        """The steady state of a corner at a load factor, or the error in its place."""
        key = corner.name, factor
        if key not in self.known:
            answer: SteadyAnswer
            try:
                answer = self._followed(corner, factor)
            except (NoContinuation, SolverError) as error:
                answer = error
            self.known[key] = answer
        return self.known[key]

    def _followed(self, corner: Corner, factor: float) -> SteadyState:
        """The steady state of a corner at a load factor."""
        asked = self.system, corner.cycle, corner.friction
        if factor == 1.0 or self.steps is None:
            return steady_state(*asked, factor, steps=self.steps)
        begin = self.mean_state(corner)
        path = path_of(*asked, factor, None, begin, steps=self.steps)
        return settled_from(path.start(), np.nan)

    def mean_state(self, corner: Corner) -> ContactState:
        """The state of a corner under the mean load, from no slip."""
        if corner.name not in self.mean_states:
            self.mean_states[corner.name] = mean_state(
                self.system, corner.cycle, corner.friction, steps=self.steps
            )
        return self.mean_states[corner.name]

    def judged(self, name: str, corner: Corner, factor: float) -> Judged:
        """A quantity in the steady state of a corner; infinite if there is no steady state."""
        steady = self.at(corner, factor)
        if not isinstance(steady, SteadyState):
            return Judged(np.nan, _NO_STEADY_STATE.format(reason=steady), np.inf)
        try:
            return QUANTITIES[name].judged(steady)
        except SolverError as error:
            return Judged(np.nan, str(error), np.inf)


def safety_table(
    states: SteadyStates, nominal: GrossSlip | None, limits: Mapping[str, float]
) -> pd.DataFrame:
    """A row for each safety factor, with columns `SAFETY_COLUMNS`.

    Rows are gross slip, and the limits on face slip, slip range and slipping share if given.
    """
    rows = list[tuple[object, ...]]()
    end = np.inf
    if nominal is not None:
        rows.append(_against_gross_slip(states, nominal))
        if nominal.self_stress is None:
            end = BELOW_GROSS_SLIP * factor_of(nominal)
    if FACE_SLIP in limits:
        rows.append(_against_face_slip(states))
    for name in (SLIP_RANGE, SLIPPING_SHARE):
        if name in limits:
            rows.append(_against_slip(states, name, limits[name], end))
    return pd.DataFrame(rows, columns=SAFETY_COLUMNS)


def _against_gross_slip(states: SteadyStates, nominal: GrossSlip) -> tuple[object, ...]:
    """The row of gross slip."""
    scatter = states.scatter
    _, *corners = states.all_corners()
    question: Callable[..., GrossSlip] = gross_slip
    by = _BY_CORNERS
    if nominal.self_stress is None:
        question = partial(gross_slip, seconds=0.0)
        by = _BY_THEOREM
        corners = [corner for corner in corners if corner.friction is scatter.frictions[0]]
    factors = {NOMINAL: factor_of(nominal)}
    for corner in corners:
        factors[corner.name] = factor_of(question(states.system, corner.cycle, corner.friction))
    return _row(GROSS_SLIP, factors, by if scatter.exists else _NO_SCATTER)


def _against_face_slip(states: SteadyStates) -> tuple[object, ...]:
    """The row of the first face that slides in full."""
    factors = dict[str, float]()
    for corner in states.all_corners():
        try:
            mean = states.mean_state(corner)
        except (NoContinuation, SolverError):
            factors[corner.name] = 0.0
            continue
        loads = _under_mean_load(states.system, corner.cycle, mean)
        faces = _slide_in_full_at(states.system, corner.friction, loads)
        factors[corner.name] = float(np.nanmin([np.inf, *faces]))
    return _row(FACE_SLIP, factors, _BY_CORNERS if states.scatter.exists else _NO_SCATTER)


def _against_slip(
    states: SteadyStates, name: str, threshold: float, end: float
) -> tuple[object, ...]:
    """The row of a quantity of the steady state, at all corners.

    A corner is not followed further if it keeps the threshold at the least load factor found for
    the corners before it.
    """
    tolerance = TOLERANCE[states.system.tangents - 1]
    nominal, *corners = states.all_corners()
    what = f"safety factor against {name}"
    with progress_bar(True, what, "input", total=1 + len(corners)) as bar:
        factors = {NOMINAL: _factor(states, name, threshold, nominal, end)}
        for corner in corners:
            bar.update()
            above = min(factors.values()) * (1 + tolerance)
            if np.isfinite(above) and states.judged(name, corner, above).judged <= threshold:
                continue
            factors[corner.name] = _factor(states, name, threshold, corner, above)
    by = _BY_CORNERS if states.scatter.exists else _NO_SCATTER
    return _row(f"{name} of {threshold:g}", factors, by)


def _row(against: str, factors: Mapping[str, float], by: str) -> tuple[object, ...]:
    """A row of the table of safety factors; `factors` maps the name of a corner to its factor."""
    worst = min(factors, key=lambda name: factors[name])
    return against, factors[NOMINAL], factors[worst], worst, by


def _factor(states: SteadyStates, name: str, threshold: float, corner: Corner, end: float) -> float:
    """The load factor up to which a corner keeps a threshold; inf if none exceeds it."""

    def value_at(factor: float) -> float:
        return states.judged(name, corner, factor).judged

    followed = [factor for at, factor in states.known if at == corner.name]
    known = {factor: value_at(factor) for factor in followed}
    tolerance = TOLERANCE[states.system.tangents - 1]
    kept, above = load_at_threshold(value_at, known, threshold, min(end, LARGEST_LOAD), tolerance)
    not_reached = above == np.inf and end >= LARGEST_LOAD
    return np.inf if not_reached else kept


def verdict_table(
    states: SteadyStates,
    safety: pd.DataFrame,
    limits: Mapping[str, float],
    units: Mapping[str, str],
) -> pd.DataFrame:
    """A row for each threshold, with columns `VERDICT_COLUMNS`: the worst of all corners.

    The margin is the threshold divided by the value that is compared with it. For gross slip and
    face slip, the margin is the safety factor divided by the threshold.
    """
    rows = list[tuple[object, ...]]()
    for name, threshold in limits.items():
        if name in (GROSS_SLIP, FACE_SLIP):
            rows.append(_verdict_on_factor(name, safety, threshold))
            continue
        corners = states.all_corners()
        judged = list[tuple[Judged, str]]()
        with progress_bar(True, f"verdict on {name}", "input", total=len(corners)) as bar:
            for corner in corners:
                judged.append((states.judged(name, corner, 1.0), corner.name))
                bar.update()
        worst, at = max(judged, key=lambda pair: pair[0].judged)
        unit = units[QUANTITIES[name].unit]
        passed = bool(worst.judged <= threshold)
        margin = _margin(threshold, worst.judged)
        rows.append((name, worst.value, threshold, unit, passed, margin, worst.where, at))
    return pd.DataFrame(rows, columns=VERDICT_COLUMNS)


def _verdict_on_factor(name: str, safety: pd.DataFrame, threshold: float) -> tuple[object, ...]:
    """The verdict on the safety factor against gross slip, or against the slip of a face."""
    rows = safety[safety["against"] == name]
    if rows.empty:
        return name, np.nan, threshold, "load factor", False, 0.0, "no answer", NOMINAL
    row = rows.iloc[0]
    factor = float(row["worst"])
    margin = _margin(factor, threshold)
    return name, factor, threshold, "load factor", factor >= threshold, margin, "", row["at"]


def _margin(allowed: float, value: float) -> float:
    """The quotient `allowed / value`: inf for a value of 0, and 0 for an infinite value."""
    if value == 0:
        return np.inf
    return allowed / value
