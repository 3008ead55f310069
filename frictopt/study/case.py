"""A transient of a study: its contact, load cycle and friction, its load factor and its start.

The key of a run is the same on another processor, though arrays there differ by rounding. It is
made of the key of its contact, which its store finds by a sketch of the contact, and of numbers
with nine digits.
"""

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base import Array
from ..contact import ContactSystem, LoadCycle, joined
from ..limits import GrossSlip, ShakedownLimit, gross_slip
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
