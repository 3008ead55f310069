"""The scatter of friction and of preloads, and its corners."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np

from ..base import ROUNDING, Array, distribution, finite_number, is_distribution, listed, shown
from ..base.checks import checked_cases
from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..errors import ModelError

NOMINAL = "the nominal input"
"""Name of the corner of the nominal input."""
QUANTILES = (0.025, 0.5, 0.975)
"""The least, the nominal and the most of a distribution: 95 % of it is between the ends."""


@dataclass(frozen=True)
class Corner:
    """A friction (N,) and a load cycle, with their name in words."""

    name: str
    friction: Array
    cycle: LoadCycle


@dataclass(frozen=True)
class Scatter:
    """The nominal input of a report, and the ranges of its friction and its preloads.

    Frictions are (N,); `least_friction` and `most_friction` are None if the friction has no range.
    `preload` maps a load case of the mean load to its least and largest amplitude. `friction_law`
    and `preload_laws` are the distributions of ranges that come from one.
    """

    cycle: LoadCycle
    friction: Array
    least_friction: Array | None = None
    most_friction: Array | None = None
    preload: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    friction_law: Any = None
    preload_laws: Mapping[str, Any] = field(default_factory=dict)

    @property
    def exists(self) -> bool:
        """Whether anything scatters."""
        return self.least_friction is not None or bool(self.preload)

    def frictions(self) -> dict[str, Array]:
        """The ends of the range of friction by their names; without a range the nominal one."""
        if self.least_friction is None or self.most_friction is None:
            return {"": self.friction}
        return {
            f"least friction {_range_of(self.least_friction)}": self.least_friction,
            f"most friction {_range_of(self.most_friction)}": self.most_friction,
        }

    def nominal(self) -> Corner:
        """The nominal input as a corner."""
        return Corner(NOMINAL, self.friction, self.cycle)

    def corners(self) -> list[Corner]:
        """All corners of the ranges; the least friction and preloads come first."""
        return [
            corner
            for friction_name, friction in self.frictions().items()
            for corner in self._corners_of_preload(friction_name, friction)
        ]

    def corners_of_least_friction(self) -> list[Corner]:
        """The corners of the preloads with the least friction."""
        friction_name, friction = next(iter(self.frictions().items()))
        return list(self._corners_of_preload(friction_name, friction))

    def _corners_of_preload(self, friction_name: str, friction: Array) -> Iterator[Corner]:
        for amplitudes in product(*self.preload.values()):
            loads = dict(zip(self.preload, amplitudes, strict=True))
            names = [f"{case} {amplitude:g}" for case, amplitude in loads.items()]
            if friction_name:
                names.insert(0, friction_name)
            cycle = replace(self.cycle, mean={**self.cycle.mean, **loads})
            yield Corner(", ".join(names) or NOMINAL, friction, cycle)

    def in_words(self) -> str:
        """The ranges in words; "" if nothing scatters."""
        texts = []
        if self.least_friction is not None and self.most_friction is not None:
            text = (
                f"friction of {_range_of(self.least_friction)} to {_range_of(self.most_friction)}"
            )
            texts.append(text + _in_words(self.friction_law))
        for case, (least, most) in self.preload.items():
            law = _in_words(self.preload_laws.get(case))
            texts.append(f"{case} of {least:g} to {most:g}{law}")
        return ", ".join(texts)


def _in_words(law: Any) -> str:
    """A distribution in words; "" if it is None."""
    if law is None:
        return ""
    return (
        f" in 95 % of all joints ({law.dist.name}, mean {law.mean():.3g}, standard deviation "
        f"{law.std():.3g})"
    )


def _range_of(friction: Array) -> str:
    least, most = float(friction.min()), float(friction.max())
    return f"{least:g}" if least == most else f"{least:g} to {most:g}"


def checked_scatter(
    system: ContactSystem, cycle: LoadCycle, friction: object, preload: object
) -> Scatter:
    """Check the friction of a report, a tuple of three or a distribution, and the preloads."""
    given: Any = dict(preload) if isinstance(preload, Mapping) else preload
    laws = dict[str, Any]()
    for case, law in given.items() if isinstance(given, dict) else ():
        if is_distribution(law):
            laws[case] = distribution(f"preload[{case!r}]", law)
            given[case] = tuple(law.ppf(QUANTILES[::2]))
    preloads = _checked_preload(cycle, given)
    friction_law = None
    if is_distribution(friction):
        friction_law = distribution("friction", friction)
        friction = tuple(friction_law.ppf(QUANTILES))
    if not isinstance(friction, tuple) or len(friction) != 3:
        friction = _coefficients(friction, system)
        return Scatter(cycle, friction, preload=preloads, preload_laws=laws)
    least, nominal, most = (_coefficients(part, system) for part in friction)
    if (least > nominal).any() or (nominal > most).any():
        raise ModelError(
            f"friction: {shown(friction)}; a tuple of three is (least, nominal, most), which must "
            "not fall; give one coefficient per node as a list or an array"
        )
    return Scatter(cycle, nominal, least, most, preloads, friction_law, laws)


def _coefficients(friction: Any, system: ContactSystem) -> Array:
    return np.array(friction_coefficients(friction, system))


def _checked_preload(cycle: LoadCycle, preload: object) -> dict[str, tuple[float, float]]:
    """Check the ranges of preloads, which lie around their amplitudes in the mean load."""
    if preload is None:
        return {}
    cases = checked_cases("preload", preload, "(least, most) amplitude in the mean load")
    # Largest number of preloads that scatter. Each doubles the number of corners, and each corner
    # has a steady state of its own.
    most = 4
    if len(cases) > most:
        raise ModelError(
            f"preload: {len(cases)} load cases; give at most {most}, and put bolts with the same "
            "scatter into one load case"
        )
    ranges = dict[str, tuple[float, float]]()
    for case, ends in cases.items():
        name = f"preload[{case!r}]"
        if case not in cycle.mean:
            raise ModelError(
                f"{name}: the mean load has no such load case; it has {sorted(cycle.mean)}"
            )
        pair = [finite_number(name, end) for end in listed(name, ends)]
        nominal = cycle.mean[case]
        rounding = ROUNDING * abs(nominal)
        is_range = len(pair) == 2 and pair[0] - rounding <= nominal <= pair[1] + rounding
        if not is_range:
            raise ModelError(
                f"{name}: {shown(ends)}; give (least, most) around {nominal:g}, its amplitude in "
                "the mean load"
            )
        ranges[case] = pair[0], pair[1]
    return ranges
