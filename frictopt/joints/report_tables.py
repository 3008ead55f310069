"""Tables of a report: its numbers with units and meaning, and the curve with units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ..base import Array, Outcome
from ..contact import ContactState, ContactSystem, LoadCycle
from ..limits import (
    GrossSlip,
    GuaranteedLimit,
    RequiredFriction,
    ShakedownLimit,
    moving_areas,
    pose,
)
from ..study.protocols import FrictionAfterProtocol, LimitAfterProtocol
from ..transients import SteadyState
from .backbone import BackboneCurve
from .curve_question import load_of_curve, load_size
from .safety import SAFETY_COLUMNS, VERDICT_COLUMNS
from .thresholds import QUANTITIES, SLIP_RANGE

# The answers that a report is made of, and the numbers that follow from several of them.


@dataclass(frozen=True, eq=False, repr=False)
class ReportParts:
    """The answers of a report, see `Report`. A part is None if `missing` has the reason."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    missing: Mapping[str, str]
    scatter: str
    life: pd.DataFrame
    title: str
    notes: str
    origin: str
    states: Mapping[tuple[str, float], SteadyState | str]
    identity: Array
    mean_state: ContactState | None = None
    gross_slip: GrossSlip | None = None
    steady: SteadyState | None = None
    curve: BackboneCurve | None = None
    limit: ShakedownLimit | None = None
    guaranteed: GuaranteedLimit | None = None
    required: RequiredFriction | None = None
    assembled: LimitAfterProtocol | None = None
    required_assembled: FrictionAfterProtocol | None = None
    safety: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=SAFETY_COLUMNS))
    verdicts: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=VERDICT_COLUMNS))
    contacts: pd.DataFrame = field(default_factory=pd.DataFrame)
    probability: pd.DataFrame = field(default_factory=pd.DataFrame)
    bodies: pd.DataFrame = field(default_factory=pd.DataFrame)
    model: Any = None


def mean_load_opens(parts: ReportParts) -> bool:
    """Whether the mean load leaves nodes open."""
    return parts.mean_state is not None and bool(parts.mean_state.open.any())


def areas_move(system: ContactSystem, cycle: LoadCycle, friction: Array) -> bool:
    """Whether normal loads alone open and close nodes in each cycle, as under a roller.

    Then slip changes no pressure, and limits hold for all openings and closings.
    """
    question = pose(system, cycle, friction, question_name="shakedown_limit")
    return moving_areas(question) is not None


def limits_change_with_mesh(parts: ReportParts) -> bool:
    """Whether a closed node beside nodes that the mean load opens may govern the limits."""
    return mean_load_opens(parts) and not areas_move(parts.system, parts.cycle, parts.friction)


def many_nodes_slip(parts: ReportParts) -> bool:
    """Whether so many nodes slip that their work hardly depends on the mesh."""
    # With at least this many slipping nodes, work and share change by a few per cent with the mesh.
    many = 20
    return parts.steady is not None and int(parts.steady.slipping.sum()) >= many


def increments_are_coarse(steady: SteadyState) -> bool:
    """Whether finer increments may change the work by more than a few per cent."""
    # Increments are too coarse if the estimated relative error of their work is above this.
    coarse = 0.05
    return steady.steps > 0 and steady.step_error > coarse


def motion_of_load(parts: ReportParts) -> float:
    """Half the range over which the load moves at load factor 1; not finite if it is not known."""
    if parts.steady is None:
        return np.nan
    load = load_of_curve(parts.system, parts.cycle, parts.friction, None)
    displacement = load.measured(parts.steady)["displacement"]
    return displacement / load_size(parts.system, parts.cycle)


def motions_of_points(parts: ReportParts) -> dict[str, float]:
    """Point -> half the range of its motion at load factor 1, along its force.

    A load case of forces marks a point if its amplitude in the cycle is 0.
    """
    steady, system, cycle = parts.steady, parts.system, parts.cycle
    if steady is None or steady.outcome is Outcome.RATCHETING or system.compliance is None:
        return {}
    loads = [cycle.mean, *cycle.corners, *(cycle.fixed or ())]
    named = dict.fromkeys(case for corner in loads for case in corner)
    return {
        case: float(np.ptp(steady.displacement(case)) / 2 / system.load_size[case])
        for case in named
        if case in system.load_size and not any(corner.get(case, 0.0) for corner in loads)
    }


_Row = tuple[str, float, str, str, str]
_COLUMNS = ["number", "value", "unit", "converges", "meaning"]
SLIP_RANGE_ROW = "largest slip range"
LIVES = {
    "best": "in the best state of rest",
    "assembled": "as assembled",
    "worst": "in the worst state of rest of its point",
}
"""Columns of `FatigueBand.life` that a report has, and their meanings."""


def numbers_of(parts: ReportParts) -> pd.DataFrame:
    """A row for each number: columns number, value, unit, converges, meaning."""
    return pd.concat([numbers_at_load(parts), numbers_of_limits(parts)], ignore_index=True)


def numbers_at_load(parts: ReportParts) -> pd.DataFrame:
    """The rows of the first page: the gross-slip load, and the steady state at load factor 1."""
    rows = list[_Row]()
    if parts.gross_slip is not None:
        rows.append(_gross_slip_row(parts.gross_slip))
    if parts.steady is not None:
        rows += _steady_rows(parts, parts.steady)
    converges = "if the points are below the face"
    for name, cycles in parts.life.reindex(columns=[*LIVES]).min().dropna().items():
        meaning = f"of the point with the shortest life, {LIVES[name]}, by the given S-N line"
        rows.append((f"cycles to failure, {name}", cycles, "cycles", converges, meaning))
    return pd.DataFrame(rows, columns=_COLUMNS)


def numbers_of_limits(parts: ReportParts) -> pd.DataFrame:
    """The rows of both limits and the required friction."""
    return pd.DataFrame([*_limit_rows(parts)], columns=_COLUMNS)


def _gross_slip_row(gross_slip: GrossSlip) -> _Row:
    converges = "yes" if gross_slip.self_stress is None else "if the pressure of the fit converges"
    value = gross_slip.load_factor
    return "gross-slip load", value, "load factor", converges, gross_slip.reason


def _steady_rows(parts: ReportParts, steady: SteadyState) -> Iterator[_Row]:
    """Numbers of the steady state at load factor 1."""
    units = units_of(parts)
    converges = _converges(parts, steady)
    of_cycle = "in each cycle of this steady state"

    meaning = f"of friction, from assembly without slip, at load factor 1: {steady.outcome.value}"
    if steady.steps:
        if np.isinf(steady.step_error):
            meaning += "; finer increments may have another answer"
        else:
            meaning += f"; finer increments may change it by {100 * steady.step_error:.2g} %"
    elif steady.unproven:
        meaning += (
            f"; at {steady.unproven} events it is not proven that no other continuation exists"
        )
    yield "work per cycle", steady.dissipation, units["work"], converges, meaning

    meaning = f"{units['share']} of all contacts, {of_cycle}"
    yield "share that slips", steady.slipping_share, units["share"], converges, meaning

    slip_range = QUANTITIES[SLIP_RANGE].judged(steady)
    where = f"{of_cycle}, at {slip_range.where}" if slip_range.value else of_cycle
    yield SLIP_RANGE_ROW, slip_range.value, units["slip_range"], converges, where

    if steady.outcome is Outcome.RATCHETING:
        meaning = "largest slip that a node gains in each cycle"
        yield "drift per cycle", steady.drift, units["drift"], converges, meaning

    motion = motion_of_load(parts)
    if np.isfinite(motion):
        meaning = (
            "half the range of the mean motion of the loaded faces, along the load, in "
            "this steady state"
        )
        yield "motion of the load", motion, units["motion"], _if_fine(steady), meaning
    for point, motion in motions_of_points(parts).items():
        meaning = "half the range of its motion, along its force, in this steady state"
        yield f"motion of {point}", motion, units["motion"], _if_fine(steady), meaning


def _converges(parts: ReportParts, steady: SteadyState) -> str:
    """Whether work and slip converge with the mesh, and under which condition."""
    slipping = int(steady.slipping.sum())
    if many_nodes_slip(parts):
        return _if_fine(steady)
    if slipping:
        return f"if more nodes slip; here {slipping} slip"
    return "unless nodes slip on finer meshes"


def _if_fine(steady: SteadyState) -> str:
    """That a number converges with the mesh; for coarse increments, that finer ones are needed."""
    return "with finer increments" if increments_are_coarse(steady) else "yes"


def _limit_rows(parts: ReportParts) -> Iterator[_Row]:
    """Rows of limits and required frictions, which depend on the mesh beside open nodes."""
    limit, guaranteed, required = parts.limit, parts.guaranteed, parts.required
    depends = limits_change_with_mesh(parts)
    converges = "no" if depends else "unless edges are sharp"
    if mean_load_opens(parts) and not depends:
        converges = "compare with a finer mesh"
    if limit is not None:
        name = "shakedown limit"
        if depends and parts.system.tangents == 2:
            name += " with these nodes open"
        meaning = f"{limit.reason}. It covers {limit.covers}"
        yield name, limit.load_factor, "load factor", converges, meaning
    if guaranteed is not None:
        value = guaranteed.load_factor
        yield "guaranteed limit", value, "load factor", converges, guaranteed.reason
    if parts.assembled is not None:
        assembled = parts.assembled
        meaning = (
            "from no slip the contact comes to rest at all of the load factors tried up to it, "
            f"and not at {assembled.upper:.4g}"
        )
        yield "limit as assembled", assembled.load_factor, "load factor", converges, meaning
    if required is not None:
        meaning = f"at load factor 1: {required.reason}"
        yield "required friction", required.required, "coefficient", converges, meaning
    if parts.required_assembled is not None:
        friction = parts.required_assembled
        meaning = (
            "at load factor 1: from no slip the contact comes to rest with all frictions tried "
            f"from it on, and not with {friction.lower:.4g}"
        )
        yield "friction as assembled", friction.required, "coefficient", converges, meaning
    for name, value, _, meaning in parts.probability.itertuples(index=False):
        yield name, value, "probability", converges, meaning


def units_of(parts: ReportParts) -> dict[str, str]:
    """Column of a table -> its unit. A column without a unit is a ratio or a name."""
    force, length = (parts.system.units or "force, length").split(", ")
    per_depth = " per depth" if parts.system.per_depth else ""
    return {
        "work": f"{force} {length}{per_depth}",
        "slip_range": length,
        "motion": length,
        "drift": length,
        "work_density": f"{force} per {length}",
        "Ruiz": f"{force} per {length}",
        "area": length if parts.system.per_depth else f"{length}^2",
        "E": f"{force} per {length}^2",
        "size": length,
        "largest_element": length,
        "stiffness": f"{force}{per_depth} per {length}",
        "displacement": f"{force} {length}{per_depth} per load factor",
        "P": f"{force}{per_depth}",
        "Q": f"{force}{per_depth}",
        "fP": f"{force}{per_depth}",
        "M": f"{force} {length}{per_depth}",
        "slides_at": "load factor",
        "slides_at_steady": "load factor",
        "share": "of the nodes" if parts.system.width is None else "of the area",
    }


def columns_with_units(parts: ReportParts, table: pd.DataFrame) -> dict[str, tuple[str, str]]:
    """Column of a table -> (name, unit), such as ("P_0", "N"); the unit is "" if there is none."""
    units = units_of(parts)
    names = dict[str, tuple[str, str]]()
    for column in table.columns:
        quantity = column.split("_")[0] if column[-1:].isdigit() else column
        # The displacement of a curve is the work of the load per load factor.
        name = "work of the load" if column == "displacement" else column
        names[column] = name, units.get(quantity, "")
    return names


def with_units(parts: ReportParts, table: pd.DataFrame) -> pd.DataFrame:
    """A table with the unit of each column in its name, such as "P_0 (N per depth)"."""
    names = {
        column: f"{name} ({unit})" if unit else column
        for column, (name, unit) in columns_with_units(parts, table).items()
    }
    return table.rename(columns=names)


def curve_table(parts: ReportParts, curve: BackboneCurve) -> pd.DataFrame:
    """The known columns of a curve; if the motion is known, the stiffness is force per motion."""
    table = curve.to_frame().drop(columns="stiffness")
    size = load_size(parts.system, parts.cycle)
    if np.isfinite(size):
        table = table.drop(columns="displacement")
        place = table.columns.get_loc("motion") + 1
        table.insert(place, "stiffness", curve.stiffness * size**2)
    return table.dropna(axis=1, how="all")
