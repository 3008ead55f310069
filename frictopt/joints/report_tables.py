"""Tables of a report: its numbers with units and meaning, and the curve with units."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ..limits import GrossSlip
from ..transients import SteadyState
from .backbone import BackboneCurve
from .curve_load import load_size
from .report_parts import ReportParts, many_nodes_slip, mean_load_opens, motion_of_load

_Row = tuple[str, float, str, str, str]


def numbers_of(parts: ReportParts) -> pd.DataFrame:
    """A row for each number: columns number, value, unit, settles (with the mesh), meaning."""
    rows = list[_Row]()
    if parts.gross_slip is not None:
        rows.append(_gross_slip_row(parts.gross_slip))
    if parts.steady is not None:
        rows += _steady_rows(parts, parts.steady)
    rows += _limit_rows(parts)
    return pd.DataFrame(rows, columns=["number", "value", "unit", "settles", "meaning"])


def _gross_slip_row(gross_slip: GrossSlip) -> _Row:
    settles = "yes" if gross_slip.self_stress is None else "as the pressure of the fit does"
    value = gross_slip.load_factor
    return "gross-slip load", value, "load factor", settles, gross_slip.reason


def _steady_rows(parts: ReportParts, steady: SteadyState) -> Iterator[_Row]:
    """Numbers of the steady state at load factor 1."""
    units = units_of(parts)
    slipping = int(steady.slipping.sum())
    if many_nodes_slip(parts):
        settles = "yes"
    elif slipping:
        settles = f"once more nodes slip, {slipping} do here"
    else:
        settles = "unless nodes slip on finer meshes"
    of_cycle = "in each cycle of this steady state"

    meaning = f"of friction, from assembly without slip, at load factor 1: {steady.outcome.value}"
    if steady.steps:
        meaning += f"; finer increments may change it by {steady.step_error:.1g} of it"
    elif steady.unproven:
        meaning += f"; at {steady.unproven} events it is not proven that there is no other way on"
    yield "work per cycle", steady.dissipation, units["work"], settles, meaning

    has_width = parts.system.width is not None
    whole = "the area of all contacts" if has_width else "the nodes of all contacts"
    share = steady.slipping_share
    yield (
        "share that slips",
        share,
        "of 1",
        settles,
        f"of {whole}, in each cycle of this steady state",
    )

    slip_range = float(parts.contacts["slip_range"].max())
    yield "largest slip range", slip_range, units["slip_range"], settles, of_cycle

    motion = motion_of_load(parts)
    if np.isfinite(motion):
        meaning = (
            "half the range of the mean motion of what the load acts on, along the load, in this "
            "steady state"
        )
        yield "motion of the load", motion, units["motion"], "yes", meaning


def _limit_rows(parts: ReportParts) -> Iterator[_Row]:
    """Both limits, and the required friction. They depend on the mesh beside open nodes."""
    limit, guaranteed, required = parts.limit, parts.guaranteed, parts.required
    settles = "no" if mean_load_opens(parts) else "unless edges are sharp"
    if limit is not None:
        name = "shakedown limit"
        if mean_load_opens(parts) and parts.system.tangents == 2:
            name += " with these nodes open"
        meaning = f"{limit.reason}. It covers {limit.covers}"
        yield name, limit.load_factor, "load factor", settles, meaning
    if guaranteed is not None:
        value = guaranteed.load_factor
        yield "guaranteed limit", value, "load factor", settles, guaranteed.reason
    if required is not None:
        meaning = f"at load factor 1: {required.reason}"
        yield "required friction", required.required, "coefficient", settles, meaning


def units_of(parts: ReportParts) -> dict[str, str]:
    """Column of a table -> its unit. A column without a unit is a share, a ratio or a name."""
    force, length = (parts.system.units or "force, length").split(", ")
    in_plane = parts.system.tangents == 1
    per_depth = " per depth" if in_plane else ""
    return {
        "work": f"{force} {length}{per_depth}",
        "slip_range": length,
        "motion": length,
        "area": length if in_plane else f"{length}^2",
        "stiffness": f"{force}{per_depth} per {length}",
        "displacement": f"{force} {length}{per_depth} per load factor",
        "P": f"{force}{per_depth}",
        "Q": f"{force}{per_depth}",
        "fP": f"{force}{per_depth}",
    }


def with_units(parts: ReportParts, table: pd.DataFrame) -> pd.DataFrame:
    """A table with the unit of each column in its name, such as "P_0 (N per depth)"."""
    units = units_of(parts)
    names = dict[str, str]()
    for column in table.columns:
        quantity = column.split("_")[0] if column[-1:].isdigit() else column
        if quantity in units:
            # The displacement of a curve is the work of the load over its load factor.
            name = "work of the load" if column == "displacement" else column
            names[column] = f"{name} ({units[quantity]})"
    return table.rename(columns=names)


def curve_table(parts: ReportParts, curve: BackboneCurve) -> pd.DataFrame:
    """The known columns of a curve; the stiffness is force over motion if the motion is known."""
    table = curve.to_frame().drop(columns="stiffness")
    size = load_size(parts.system, parts.cycle)
    if np.isfinite(size):
        table = table.drop(columns="displacement")
        place = table.columns.get_loc("motion") + 1
        table.insert(place, "stiffness", size * curve.load_factor / curve.motion)
    return table.dropna(axis=1, how="all")
