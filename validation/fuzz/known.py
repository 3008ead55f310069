"""What the questions to a random case share: the case with its limits, and how two numbers are compared."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

import frictopt as fo
from validation import oracles
from validation.fuzz.cases import Case


class Wrong(Exception):
    """An answer that an independent one contradicts."""


class Missed(Exception):
    """An answer that is right as far as it says, beside which an independent one is better."""


class NotAsked(Exception):
    """The question makes no sense for a case."""


class Asked:
    """A case, its units, and the limit that frictopt finds."""

    none = 1e-6  # limits up to this count as none to be below of
    options: ClassVar[Mapping[str, Any]] = {}  # of transients

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
        """Whether there is a limit to be below or above of."""
        return self.value is not None and bool(np.isfinite(self.value)) and self.value > self.none

    @property
    def load_factor(self) -> float:
        """The load factor of the case."""
        return self.case.share * (self.value if self.value is not None and self.finite else 1.0)


class Known(Asked):
    """A case, and the shakedown limit that several questions need, by the plain linear program."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        self.limit = oracles.largest_load_factor(case.system, case.cycle, case.friction)

    @property
    def value(self) -> float | None:
        """That of the plain linear program."""
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
    name: str, found: float, expected: float, relative: float = 1e-6, absolute: float = 0.0
) -> None:
    """Raise Wrong where two numbers differ by more than that."""
    if not (
        found == expected
        or (np.isnan(found) and np.isnan(expected))
        or abs(found - expected) <= relative * abs(expected) + absolute
    ):
        raise Wrong(f"{name} {found!r}, expected {expected!r}")


def transformed(
    known: Known,
    name: str,
    ask: Callable[..., fo.results.ShakedownLimit | fo.results.GuaranteedLimit],
    value: Callable[[Any], float],
    answered: Any,
) -> tuple[float, bool]:
    """The same limit in other units, mirrored, renumbered, with other corners' order, after residual slip, and with nothing left out."""
    system, cycle, friction = known.args
    n, rng = system.nodes, np.random.default_rng(known.case.seed)
    order = rng.permutation(n)
    slip = rng.normal(size=n) * known.length
    forms: tuple[Callable[[], fo.results.ShakedownLimit | fo.results.GuaranteedLimit], ...] = (
        lambda: ask(
            oracles.redescribed(system, force=10.0 ** rng.uniform(-12, 12)), cycle, friction
        ),
        lambda: ask(
            oracles.redescribed(system, np.arange(n)[::-1], sense=-1.0), cycle, friction[::-1]
        ),
        lambda: ask(oracles.redescribed(system, order), cycle, friction[order]),
        lambda: ask(system, fo.LoadCycle(cycle.mean, cycle.corners[::-1]), friction),
        lambda: ask(
            system.with_bonded(
                {
                    "mean": (
                        system.bonded["mean"][0] + system.A @ slip,
                        system.bonded["mean"][1] + system.B @ slip,
                    )
                }
            ),
            cycle,
            friction,
        ),
        lambda: ask(system, cycle, friction, simplify=False),
    )
    form = int(rng.integers(len(forms)))
    again = forms[form]()
    if form == 4 and (answered.open.any() or again.open.any()):
        return (
            again.residual,
            False,
        )  # which nodes the mean load opens depends on the slip before it
    same(
        f"{name} in form {form}",
        value(again),
        value(answered),
        relative=1e-7 if form != 4 else 1e-6,
        absolute=1e-8,
    )
    return again.residual, True
