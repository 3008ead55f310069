"""The scatter of friction, of preloads and of the load, and its corners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from numbers import Real
from typing import Any

from ..base import (
    ROUNDING,
    Array,
    Loads,
    distribution,
    finite_number,
    is_distribution,
    listed,
    shown,
)
from ..base.checks import checked_cases, is_named
from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..errors import ModelError

NOMINAL = "the nominal input"
"""Name of the corner of the nominal input."""
QUANTILES = (0.025, 0.5, 0.975)
"""Shares of a distribution below the least, nominal and largest value; the ends enclose 95 %."""


@dataclass(frozen=True)
class Corner:
    """A friction (N,) and a load cycle, with their name in words."""

    name: str
    friction: Array
    cycle: LoadCycle


@dataclass(frozen=True)
class Scatter:
    """The nominal input of a report, and the ranges of its friction, its preloads and its load.

    Frictions are (N,); `frictions` has the least and the most friction, or the nominal one alone.
    `preload` maps a load case of the mean load to its least and largest amplitude. `load` has the
    least and the largest load factor, or 1 alone. `laws` are arguments of
    `ShakedownLimit.probability`: the distributions that the input has instead of ranges, and the
    correlation length. `tightening` maps a load case to its factor alpha_A.
    """

    cycle: LoadCycle
    friction: Array
    frictions: tuple[Array, ...]
    preload: Mapping[str, tuple[float, float]]
    load: tuple[float, ...]
    laws: Mapping[str, Any]
    tightening: Mapping[str, float]

    @property
    def exists(self) -> bool:
        """Whether anything scatters."""
        return len(self.frictions) > 1 or bool(self.preload) or len(self.load) > 1

    def nominal(self) -> Corner:
        """The nominal input as a corner."""
        return Corner(NOMINAL, self.friction, self.cycle)

    def corners(self) -> list[Corner]:
        """All corners of the ranges; the least friction and preloads come first."""
        return [
            self._corner(friction, factor, dict(zip(self.preload, amplitudes, strict=True)))
            for friction in self.frictions
            for factor, *amplitudes in product(self.load, *self.preload.values())
        ]

    def _corner(self, friction: Array, factor: float, loads: Loads) -> Corner:
        names = list[str]()
        if len(self.frictions) > 1:
            end = "least" if friction is self.frictions[0] else "most"
            names.append(f"{end} friction {range_of(friction)}")
        names += [f"{case} {amplitude:g}" for case, amplitude in loads.items()]
        if len(self.load) > 1:
            names.append(f"load factor {factor:g}")
        corners = [
            {case: factor * amplitude for case, amplitude in corner.items()}
            for corner in self.cycle.corners
        ]
        cycle = replace(self.cycle, mean={**self.cycle.mean, **loads}, corners=corners)
        return Corner(", ".join(names) or NOMINAL, friction, cycle)

    def in_words(self) -> str:
        """The ranges in words; "" if nothing scatters."""
        texts = []
        law = self.laws.get("friction")
        if isinstance(law, Mapping):
            for name, each in law.items():
                least, _, most = each.ppf(QUANTILES)
                texts.append(f"friction of {name} of {least:g} to {most:g}{_in_words(each)}")
        elif len(self.frictions) > 1:
            least, most = map(range_of, self.frictions)
            texts.append(f"friction of {least} to {most}{_in_words(law)}")
        if "correlation_length" in self.laws:
            texts.append(f"correlation length of friction {self.laws['correlation_length']:g}")
        for case, (least, most) in self.preload.items():
            law = _in_words(self.laws.get("preload", {}).get(case))
            text = f"{case} of {least:g} to {most:g}{law}"
            if case in self.tightening:
                text += f", tightening factor alpha_A = {self.tightening[case]:g} of VDI 2230"
            texts.append(text)
        if len(self.load) > 1:
            law = _in_words(self.laws.get("load"))
            texts.append(f"load factor of {self.load[0]:g} to {self.load[1]:g}{law}")
        return ", ".join(texts)


def _in_words(law: Any) -> str:
    """A distribution in words; "" if there is none."""
    if law is None:
        return ""
    return (
        f" in 95 % of all joints ({law.dist.name}, mean {law.mean():.3g}, standard deviation "
        f"{law.std():.3g})"
    )


def range_of(friction: Array) -> str:
    """The least and the largest friction in words: "0.1 to 0.2", or "0.1" if they are equal."""
    least, most = float(friction.min()), float(friction.max())
    return f"{least:g}" if least == most else f"{least:g} to {most:g}"


def checked_scatter(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    preload: object = None,
    load: Any = None,
    correlation_length: Any = None,
) -> Scatter:
    """Check the scatter of a report: ranges, and distributions, which become ranges and laws."""
    laws = dict[str, Any]()
    friction_law = _friction_law(system, friction)
    if friction_law is not None:
        laws["friction"] = friction_law
    nominal, frictions = _checked_frictions(system, friction, friction_law is not None)
    if correlation_length is not None:
        if friction_law is None:
            raise ModelError(
                f"correlation_length: {shown(correlation_length)}, and the friction has no "
                "distribution; give one, or leave the length out"
            )
        laws["correlation_length"] = finite_number(
            "correlation_length", correlation_length, least=0.0
        )
    preloads, preload_laws, tightening = _checked_preload(cycle, preload)
    if preload_laws:
        laws["preload"] = preload_laws
    loads: tuple[float, ...] = (1.0,)
    if load is not None:
        if is_distribution(load):
            laws["load"] = load
        loads = _checked_range("load", load, 1.0)
    return Scatter(cycle, nominal, frictions, preloads, loads, laws, tightening)


def _checked_frictions(
    system: ContactSystem, friction: Any, is_random: bool
) -> tuple[Array, tuple[Array, ...]]:
    """The nominal friction of the nodes, and its range: (least, most), or (nominal,)."""
    named = dict(friction).values() if is_named(friction) else ()
    has_ranges = any(isinstance(part, tuple) for part in named)
    if has_ranges and is_random:
        raise ModelError(f"friction: {shown(friction)}; give ranges or distributions, not both")
    if has_ranges or is_random:
        friction = tuple(at_share(friction, share) for share in QUANTILES)
    if not (isinstance(friction, tuple) and len(friction) == 3):
        nominal = friction_coefficients(friction, system)
        return nominal, (nominal,)
    least, nominal, most = (friction_coefficients(part, system) for part in friction)
    if (least > nominal).any() or (nominal > most).any():
        raise ModelError(
            f"friction: {shown(friction)}; a tuple of three is (least, nominal, most), which must "
            "not fall; give one coefficient per node as a list or an array"
        )
    return nominal, (least, most)


def _friction_law(system: ContactSystem, friction: Any) -> Any:
    """The distribution of friction, or contact -> distribution; None if there is none.

    The distribution of the only contact counts as the distribution of all nodes, because its
    probability is exact.
    """
    if not is_named(friction):
        return distribution("friction", friction) if is_distribution(friction) else None
    laws = {
        name: distribution(f"friction[{name!r}]", law)
        for name, law in dict(friction).items()
        if is_distribution(law)
    }
    if laws and system.contact is not None and len(set(system.contact)) == 1:
        return next(iter(laws.values()))
    return laws or None


def at_share(friction: Any, share: float) -> Any:
    """The friction that this share of all joints stays below; by contact if it has names.

    The parts of a tuple (least, nominal, most) have the shares of `QUANTILES`.
    """
    if isinstance(friction, tuple) and len(friction) == len(QUANTILES):
        return friction[QUANTILES.index(share)]
    if is_distribution(friction):
        return float(friction.ppf(share))
    if is_named(friction):
        return {name: at_share(law, share) for name, law in dict(friction).items()}
    return friction


def _checked_preload(
    cycle: LoadCycle, preload: object
) -> tuple[dict[str, tuple[float, float]], dict[str, Any], dict[str, float]]:
    """The ranges of preloads, their distributions, and their tightening factors."""
    ranges = dict[str, tuple[float, float]]()
    laws = dict[str, Any]()
    tightening = dict[str, float]()
    meaning = "(least, most) amplitude in the mean load"
    cases = {} if preload is None else checked_cases("preload", preload, meaning)
    # Largest number of preloads that scatter. Each doubles the number of corners, and each corner
    # has a steady state of its own.
    most = 4
    if len(cases) > most:
        raise ModelError(
            f"preload: {len(cases)} load cases; give at most {most}, and put bolts with the same "
            "scatter into one load case"
        )
    for case, given in cases.items():
        name = f"preload[{case!r}]"
        if case not in cycle.mean:
            raise ModelError(
                f"{name}: the mean load has no such load case; it has {sorted(cycle.mean)}"
            )
        nominal = cycle.mean[case]
        if isinstance(given, Real):
            # The largest factor of VDI 2230 is 4; a force given by mistake is refused.
            factor = finite_number(f"{name}, a factor alpha_A", given, above=1.0, below=10.0)
            tightening[case] = factor
            given = _tightened(nominal, factor)
        if is_distribution(given):
            laws[case] = given
        ranges[case] = _checked_range(name, given, nominal)
    return ranges, laws, tightening


def _tightened(nominal: float, factor: float) -> Any:
    """The normal distribution of a preload whose largest value is alpha_A times its smallest.

    VDI 2230 gives no distribution. Here 95 % of all preloads are between the smallest and the
    largest, which lie at the same distance from the nominal preload.
    """
    from scipy.stats import norm  # imported here, because scipy.stats is slow to import

    half_range = abs(nominal) * (factor - 1) / (factor + 1)
    return norm(nominal, half_range / norm.ppf(QUANTILES[2]))


def _checked_range(name: str, given: Any, nominal: float) -> tuple[float, float]:
    """Check that the ends of a range, or of a distribution, enclose the nominal value."""
    ends = given
    if is_distribution(given):
        ends = distribution(name, given).ppf(QUANTILES[::2])
    pair = [finite_number(name, end) for end in listed(name, ends)]
    rounding = ROUNDING * abs(nominal)
    is_range = len(pair) == 2 and pair[0] - rounding <= nominal <= pair[1] + rounding
    if not is_range:
        raise ModelError(
            f"{name}: {shown(given)}; give (least, most) around {nominal:g}, the nominal value"
        )
    return pair[0], pair[1]
