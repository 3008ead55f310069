"""A transient of a study: its contact, load cycle and friction, its load factor and its start.

The key of a run is the same on another processor, though arrays there differ by rounding. It is
made of the key of its contact, which its store finds by a sketch of the contact, and of numbers
with nine digits.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import Array
from ..base.files import written_by
from ..contact import ContactSystem, LoadCycle, joined
from ..limits import GrossSlip, ShakedownLimit, gross_slip
from ..transients import SteadyState
from .starts import Start

# Digits of numbers in keys; other processors change digits behind them.
_DIGITS = 9
# Root of the rounding of a stiffness, relative to the largest one: less is as good as nothing.
_ROUNDING_OF_SIZE = 1e-8

KEY = 20
"""Length of a digest, such as the key of a contact."""


def sketch(system: ContactSystem, cycle: LoadCycle) -> Array:
    """Numbers that tell a contact under a load cycle from others.

    They are sums of its stiffness with fixed weights, in the units of its nodes, and its reactions,
    gaps and strengths. Two contacts are the same if their sketches differ by 1e-9 at most.
    """
    size = np.sqrt(np.diag(system.S).clip(0.0))
    size = np.maximum(size, _ROUNDING_OF_SIZE * size.max()) if size.any() else np.ones_like(size)
    places = np.arange(1.0, len(size) + 1)
    weights = np.cos(np.outer(places * places, [1.0, 2.0, 3.0]))  # (M, 3)
    stiffness = (system.S / size) @ weights / size[:, None]
    reactions = [
        joined(*part) for part in (cycle.mean_reaction(system), cycle.corner_reactions(system))
    ]
    if cycle.fixed is not None:
        reactions.append(joined(*cycle.unscaled_reactions(system)))
    parts = [*np.vstack(reactions), system.gap]
    if system.capped:
        finite = np.isfinite(system.shear_strength)
        parts += [finite * 1.0, np.where(finite, system.shear_strength, 0.0)]
    return np.concatenate([stiffness.ravel(), np.log(size), *map(_graded, parts)])


def _graded(values: Array) -> Array:
    """Numbers that differ as much as the values do, relative to each of them.

    Below a thousandth of the largest value the difference is relative to that thousandth, because
    rounding is relative to the largest value.
    """
    largest = float(np.abs(values).max(initial=0.0)) or 1.0
    return np.append(np.arcsinh(1e3 * values / largest), np.log(largest))


@dataclass(frozen=True, eq=False)
class Case:
    """The input that all runs of a study at one friction and load cycle share.

    `contact` is the key of contact and load cycle, `number` the place of the friction in its list,
    `label` the name of the load cycle, "" if the study has a single one. `limit` is the shakedown
    limit for starts that need it, None if none does or no solver proves one.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    contact: str
    number: int = 0
    label: str = ""
    limit: ShakedownLimit | None = None

    @cached_property
    def force(self) -> float:
        """Sum of the normal reactions under the mean load."""
        _, p = self.cycle.mean_reaction(self.system)
        return float(p.sum())

    @cached_property
    def statics(self) -> GrossSlip:
        """The load factors at which forces within friction balance the loads, for all starts."""
        return gross_slip(self.system, self.cycle, self.friction, seconds=0.0, progress=False)

    @cached_property
    def loads(self) -> str:
        """Digest of the load case names and amplitudes of the cycle, without the contact."""
        parts = [self.cycle.mean, *self.cycle.corners, {}, *(self.cycle.fixed or ())]
        return digest(
            *(sorted((name, _number(size)) for name, size in part.items()) for part in parts)
        )

    @cached_property
    def key(self) -> str:
        """The key of contact, load cycle and friction, and of their shakedown limit in a store."""
        return self.contact + digest(_numbers(self.friction))


@dataclass(frozen=True, eq=False)
class Run:
    """A transient of a study: its case, its load factor and its start."""

    case: Case
    load_factor: float
    start: Start

    @cached_property
    def key(self) -> str:
        """The key of the case, and a digest of load factor and start.

        For a start at a multiple of the safe slip, the digest uses the multiple, because solvers
        may find different safe slips; for a random slip its family, amplitude and seed.
        """
        start = self.start
        state = start.state
        content: list[object] = [start.family, start.amplitude, start.seed]
        if start.amplitude is None:
            content = [_numbers(start.slip)]
        if state is not None:
            arrays = (state.slip, state.gap, state.bonded_q, state.bonded_p)
            content += [*map(_numbers, arrays), state.next_corner]
        numbers = (self.load_factor, start.safe_multiple, start.overload)
        return self.case.key + digest(*content, *map(_number, numbers))


def digest(*content: object) -> str:
    """A short text for a content of numbers and texts."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:KEY]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value + 0.0:.{_DIGITS}g}"


def _numbers(values: Array | None) -> str:
    """Text of an array in units of its largest entry."""
    if values is None:
        return ""
    unit = float(_number(float(np.abs(values).max(initial=0.0)))) or 1.0
    whole = np.rint(values / unit * 10.0**_DIGITS).astype(np.int64)
    return f"{unit} {values.shape} {hashlib.sha256(whole.tobytes()).hexdigest()}"


# The columns of a study, in their order. A new column is one more line of `COLUMNS`.
#
# A column is *stored* in the file of the study, *shown* in its table, or both. Its value is
# computed by a function: from the run, from the steady state, or from the other columns of the row.
# Columns without a function are filled by `runs.py`, and the shakedown limit by the study. The
# docstring of `dissipation_study` explains each column. If you change the stored columns, change
# the version in `store.py`, too.

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
