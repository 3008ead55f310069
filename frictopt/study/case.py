"""A transient of a study: its contact, load cycle and friction, its load factor and its start.

A run has the same key on every processor, although arrays differ by rounding. The key consists of
the key of its contact, which a store finds by a sketch of the contact, and of digests of numbers
with nine digits.
"""

import hashlib
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

# Digits of numbers in keys; other processors may change later digits.
_DIGITS = 9
# Square root of the rounding of a stiffness, relative to the largest stiffness. Sizes of nodes
# below this share of the largest size are raised to this share.
_ROUNDING_OF_SIZE = 1e-8

KEY = 20
"""Length of a digest, such as the key of a contact."""


def sketch(system: ContactSystem, cycle: LoadCycle) -> Array:
    """Numbers that distinguish a contact under a load cycle from other contacts and load cycles.

    They are three weighted sums of each row of the scaled stiffness, the scales, and the reactions,
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
    """Numbers whose differences are the relative differences of the values.

    Below a thousandth of the largest value the difference is relative to that thousandth, because
    rounding is relative to the largest value.
    """
    largest = float(np.abs(values).max(initial=0.0)) or 1.0
    return np.append(np.arcsinh(1e3 * values / largest), np.log(largest))


@dataclass(eq=False)
class Case:
    """The input that all runs of a study at one friction and load cycle share.

    `contact` is the key of contact and load cycle, `number` the place of the friction in its list,
    `label` the name of the load cycle, "" if the study has a single one. `limit` is the shakedown
    limit, None until it is found.
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
        """The key of this contact with its loads and friction: its limit is stored under it."""
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
        may find different safe slips. For a random slip, it uses family, amplitude and seed.
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


# The columns of a study. A column is *stored* in the file of the study, *shown* in its table, or
# both. Its values come from a function below, or from `runs.py`. The docstring of
# `dissipation_study` explains each column. If you change the stored columns, change the version in
# `store.py`, too.

Row = dict[str, Any]
"""Column name -> value, of one run."""

FAILED = "FAILED"
"""Outcome of a run that has no result."""

SLIDES_OFF = "SLIDES_OFF"
"""Outcome of a run whose loads no forces within friction balance: the bodies slide off."""

LIMIT_COLUMNS = ("load_ratio", "shakedown_limit")
"""Columns of a table that has shakedown limits."""

# Column -> its type in a DataFrame, in their order.
_TYPES = {
    "key": "str",
    "friction": "float64",
    "friction_std": "float64",
    "friction_number": "int64",
    "cycle": "str",
    "loads": "str",
    "load_factor": "float64",
    "load_ratio": "float64",
    "shakedown_limit": "float64",
    "start": "str",
    "family": "str",
    "seed": "Int64",
    "amplitude": "float64",
    "outcome": "str",
    "dissipation": "float64",
    "dissipation_scaled": "float64",
    "first_cycle": "float64",
    "largest_share": "float64",
    "cycles": "Int64",
    "slipping": "Int64",
    "open": "Int64",
    "residual": "float64",
    "engine": "str",
    "seconds": "float64",
    "error": "str",
    "version": "str",
}
_NOT_STORED = (*LIMIT_COLUMNS, "friction_number", "family", "seed", "dissipation_scaled")
_NOT_SHOWN = ("key", "loads", "version")

STORED = {name: kind for name, kind in _TYPES.items() if name not in _NOT_STORED}
"""Stored column -> its type in a DataFrame."""

SHOWN = {name: kind for name, kind in _TYPES.items() if name not in _NOT_SHOWN}
"""Column of the table -> its type."""


def row_of_run(run: Run) -> Row:
    """The values that follow from the run alone."""
    case, start = run.case, run.start
    # A uniform friction is returned without the rounding of a mean.
    uniform = np.ptp(case.friction) == 0
    return {
        "key": run.key,
        "friction": float(case.friction[0] if uniform else case.friction.mean()),
        "friction_std": 0.0 if uniform else float(case.friction.std()),
        "friction_number": case.number,
        "cycle": case.label,
        "loads": case.loads,
        "load_factor": run.load_factor,
        "start": start.name,
        "family": start.family,
        "seed": start.seed,
        "version": written_by()["version"],
    }


def row_of_steady(steady: SteadyState) -> Row:
    """The values that follow from the steady state."""
    return {
        "outcome": steady.outcome.name,
        "dissipation": steady.dissipation,
        "first_cycle": steady.first_cycle,
        "largest_share": float(steady.dissipation_per_node.max() / (steady.dissipation or 1.0)),
        "cycles": steady.cycles,
        "slipping": int(np.count_nonzero(steady.slipping)),
        "open": int(np.count_nonzero(steady.open)),
        "residual": steady.residual,
        "engine": steady.engine,
    }


def shown_row(run: Run, row: Row, limit: float | None) -> Row:
    """The row of the table of a study, from a row that may come from a store.

    A store may have kept the run under other names of its start and load cycle. The row has the
    names of this study. `limit` is the shakedown limit of the run, None if it is not known.
    `dissipation_scaled` is `W E* / P^2` in the plane, with P the normal force under the mean load.
    """
    shakedown = np.nan if limit is None else limit
    system = run.case.system
    squared_force = run.case.force * run.case.force
    scaled = np.nan
    if system.E_star and system.tangents == 1 and squared_force:
        scaled = float(row.get("dissipation", np.nan)) * system.E_star / squared_force
    whole = {
        **row,
        **row_of_run(run),
        "load_ratio": run.load_factor / shakedown if 0 < shakedown < np.inf else np.nan,
        "shakedown_limit": shakedown,
        "dissipation_scaled": scaled,
    }
    return {name: value for name, value in whole.items() if name in SHOWN}
