"""The columns of a study, in their order. A new column is one more line of `COLUMNS`.

A column is *stored* in the file of the study, *shown* in its table, or both. Its value is computed
by a function: from the run, from the steady state, or from the other columns of the row. Columns
without a function are filled by `runs.py`, and the shakedown limit by the study. The docstring of
`dissipation_study` explains each column. If you change the stored columns, change the version in
`store.py`, too.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.files import written_by
from ..transients import SteadyState
from .case import Run

Row = dict[str, Any]
"""Column name -> value, of one run."""

FAILED = "FAILED"
"""Outcome of a run that has no result."""

SLIDES_OFF = "SLIDES_OFF"
"""Outcome of a run at whose loads no forces within friction balance: the bodies slide off."""


@dataclass(frozen=True)
class Column:
    """A column of a study: its name, its type in a DataFrame, and where its value comes from."""

    name: str
    dtype: str = "float64"
    stored: bool = True
    shown: bool = True
    of_run: Callable[[Run], object] | None = None
    of_steady: Callable[[SteadyState], object] | None = None
    of_row: Callable[[Run, Row], object] | None = None


def _friction(run: Run) -> float:
    """Mean coefficient of friction; a uniform one is returned without the rounding of a mean."""
    friction = run.case.friction
    uniform = np.ptp(friction) == 0
    return float(friction[0] if uniform else friction.mean())


def _friction_std(run: Run) -> float:
    friction = run.case.friction
    uniform = np.ptp(friction) == 0
    return 0.0 if uniform else float(friction.std())


def _load_ratio(run: Run, row: Row) -> float:
    limit = float(row["shakedown_limit"])
    return run.load_factor / limit if 0 < limit < np.inf else np.nan


def _dissipation_scaled(run: Run, row: Row) -> float:
    """`W E* / P^2` in the plane, with P the normal force under the mean load."""
    system = run.case.system
    squared_force = run.case.force * run.case.force
    if not system.E_star or system.tangents == 2 or squared_force == 0:
        return np.nan
    return float(row.get("dissipation", np.nan)) * system.E_star / squared_force


def _largest_share(steady: SteadyState) -> float:
    if steady.dissipation == 0:
        return 0.0
    return float(steady.dissipation_per_node.max() / steady.dissipation)


LIMIT_COLUMNS = ("load_ratio", "shakedown_limit")
"""Columns of a table that has shakedown limits."""

COLUMNS = (
    Column("key", "str", shown=False, of_run=lambda run: run.key),
    Column("friction", of_run=_friction),
    Column("friction_std", of_run=_friction_std),
    Column("friction_number", "int64", stored=False, of_run=lambda run: run.case.number),
    Column("cycle", "str", of_run=lambda run: run.case.label),
    Column("loads", "str", shown=False, of_run=lambda run: run.case.loads),
    Column("load_factor", of_run=lambda run: run.load_factor),
    Column("load_ratio", stored=False, of_row=_load_ratio),
    Column("shakedown_limit", stored=False),
    Column("start", "str", of_run=lambda run: run.start.name),
    Column("family", "str", stored=False, of_run=lambda run: run.start.family),
    Column("seed", "Int64", stored=False, of_run=lambda run: run.start.seed),
    Column("amplitude"),
    Column("outcome", "str", of_steady=lambda steady: steady.outcome.name),
    Column("dissipation", of_steady=lambda steady: steady.dissipation),
    Column("dissipation_scaled", stored=False, of_row=_dissipation_scaled),
    Column("first_cycle", of_steady=lambda steady: steady.first_cycle),
    Column("largest_share", of_steady=_largest_share),
    Column("cycles", "Int64", of_steady=lambda steady: steady.cycles),
    Column("slipping", "Int64", of_steady=lambda steady: int(np.count_nonzero(steady.slipping))),
    Column("open", "Int64", of_steady=lambda steady: int(np.count_nonzero(steady.open))),
    Column("residual", of_steady=lambda steady: steady.residual),
    Column("engine", "str", of_steady=lambda steady: steady.engine),
    Column("seconds"),
    Column("error", "str"),
    Column("version", "str", shown=False, of_run=lambda run: written_by()["version"]),
)

STORED = {column.name: column.dtype for column in COLUMNS if column.stored}
"""Stored column -> its type in a DataFrame."""

SHOWN = {column.name: column.dtype for column in COLUMNS if column.shown}
"""Column of the table -> its type."""


def row_of_run(run: Run) -> Row:
    """The values that follow from the run alone."""
    return {column.name: column.of_run(run) for column in COLUMNS if column.of_run is not None}


def row_of_steady(steady: SteadyState) -> Row:
    """The values that follow from the steady state."""
    return {
        column.name: column.of_steady(steady) for column in COLUMNS if column.of_steady is not None
    }


def shown_row(run: Run, row: Row, limit: float | None) -> Row:
    """The row of the table of a study, from a row that may come from a store.

    A store may have kept the run under other names of its start and load cycle. The row has the
    names of this study. `limit` is the shakedown limit of the run, None if it is not known.
    """
    named = row | row_of_run(run) | {"shakedown_limit": np.nan if limit is None else limit}
    derived = {
        column.name: column.of_row(run, named) for column in COLUMNS if column.of_row is not None
    }
    return {name: value for name, value in (named | derived).items() if name in SHOWN}
