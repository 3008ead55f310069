"""A random case with its limits, and comparisons of two numbers, shared by all questions."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

import frictopt as fo
from studies.validation import oracles
from studies.validation.fuzz.cases import Case

AnyLimit = fo.results.ShakedownLimit | fo.results.GuaranteedLimit


class Wrong(Exception):
    """An answer that an independent one contradicts."""


class Missed(Exception):
    """A limit that is right for its open nodes, while other open nodes have a larger limit."""


class NotApplicable(Exception):
    """The question does not apply to a case."""


class Subject:
    """A case, its units, and the limit that frictopt finds."""

    # A limit up to this load factor counts as zero: no load is below it.
    none = 1e-6
    # Options of all transients.
    options: ClassVar[Mapping[str, Any]] = {}

    def __init__(self, case: Case) -> None:
        self.case = case

    @cached_property
    def force(self) -> float:
        """Force scale of the case."""
        return oracles.units(self.case.system, self.case.cycle)[0]

    @cached_property
    def length(self) -> float:
        """Slip scale of the case."""
        return self.force / self.case.system.stiffness_scale

    @property
    def args(self) -> tuple[Any, Any, Any]:
        """System, cycle, friction."""
        return self.case.system, self.case.cycle, self.case.friction

    @cached_property
    def answered_limit(self) -> fo.results.ShakedownLimit:
        """The limit that frictopt finds."""
        return fo.shakedown_limit(*self.args)

    @property
    def value(self) -> float | None:
        """The limit as a number; None if it is not known."""
        return self.answered_limit.load_factor

    @property
    def finite(self) -> bool:
        """Whether the limit is known, finite and above zero."""
        return self.value is not None and bool(np.isfinite(self.value)) and self.value > self.none

    @property
    def load_factor(self) -> float:
        """The load factor of the case: its share of the limit, or of 1 without a finite limit."""
        if self.value is not None and self.finite:
            return self.case.share * self.value
        return self.case.share


class Known(Subject):
    """A plane case with its shakedown limit by a plain linear program, for several questions."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        self.limit = oracles.largest_load_factor(case.system, case.cycle, case.friction)

    @property
    def value(self) -> float | None:
        """The limit of the plain linear program."""
        return self.limit

    @cached_property
    def answered_guarantee(self) -> fo.results.GuaranteedLimit:
        """The guaranteed limit that frictopt finds."""
        return fo.guaranteed_limit(*self.args)

    @cached_property
    def answered_safe_slip(self) -> fo.results.SafeSlip:
        """The safe slip that frictopt finds at the load factor of the case."""
        return fo.safe_slip(*self.args, self.load_factor)


def same(
    name: str, value: float, expected: float, relative: float = 1e-6, absolute: float = 0.0
) -> None:
    """Raise Wrong if two numbers differ by more than the relative and the absolute tolerance."""
    both_infinite_or_nan = value == expected or (np.isnan(value) and np.isnan(expected))
    if both_infinite_or_nan:
        return
    # The condition is false if one of the numbers is nan.
    if not abs(value - expected) <= relative * abs(expected) + absolute:
        raise Wrong(f"{name} {value!r}, expected {expected!r}")


def transformed(
    known: Known,
    name: str,
    question: Callable[..., AnyLimit],
    limit: AnyLimit,
) -> tuple[float, bool]:
    """Compare a limit with the limit of the same contact in another description.

    The description is one of six, chosen by the seed: other units of force, mirrored, renumbered,
    the corners in reverse order, a residual slip in the mean load, or nothing omitted.
    """
    system, cycle, friction = known.args
    n = system.nodes
    rng = np.random.default_rng(known.case.seed)
    order = rng.permutation(n)
    slip = rng.normal(size=n) * known.length

    def other_units() -> AnyLimit:
        force = 10.0 ** rng.uniform(-12, 12)
        return question(oracles.redescribed(system, force=force), cycle, friction)

    def mirrored() -> AnyLimit:
        behind = oracles.redescribed(system, np.arange(n)[::-1], sense=-1.0)
        return question(behind, cycle, friction[::-1])

    def renumbered() -> AnyLimit:
        return question(oracles.redescribed(system, order), cycle, friction[order])

    def reversed_corners() -> AnyLimit:
        return question(system, fo.LoadCycle(cycle.mean, cycle.corners[::-1]), friction)

    def after_slip() -> AnyLimit:
        q0, p0 = system.bonded["mean"]
        mean = q0 + system.A @ slip, p0 + system.B @ slip
        return question(system.with_bonded({"mean": mean}), cycle, friction)

    def nothing_omitted() -> AnyLimit:
        return question(system, cycle, friction, simplify=False)

    forms = (
        other_units,
        mirrored,
        renumbered,
        reversed_corners,
        after_slip,
        nothing_omitted,
    )
    number = int(rng.integers(len(forms)))
    form = forms[number]
    again = form()
    # The nodes that the mean load opens depend on the slip before it.
    if form is after_slip and (limit.open.any() or again.open.any()):
        return again.residual, False
    same(
        f"{name} in form {number}",
        float(again.load_factor),
        float(limit.load_factor),
        relative=1e-6 if form is after_slip else 1e-7,
        absolute=1e-8,
    )
    return again.residual, True
