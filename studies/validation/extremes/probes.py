"""A question with extreme input: its form, sizes and loads."""

from collections.abc import Callable
from dataclasses import dataclass

import frictopt as fo

from ...paper import LOADS

SHEAR = fo.LoadCycle(mean={"P": 1.0}, corners=[{"Q": -1.0}, {"Q": 1.0}])
_EXACT = 1e-7


@dataclass(frozen=True)
class Sizes:
    """How large the cases are."""

    elements: int = 40
    most_nodes: tuple[int, ...] = (2, 4, 10, 40, 124, 250, 500, 1000)
    most_guaranteed: int = 250
    gradings: tuple[float, ...] = (1.0, 1e2, 1e4, 1e6, 1e9, 1e12)
    corners: int = 1000
    cycles: int = 100_000


@dataclass(frozen=True)
class Answer:
    """An answer: its number, its residual, its solver, and the number of solvers that failed before."""

    number: float
    residual: float
    solver: str
    fallbacks: int = 0


@dataclass(frozen=True)
class Probe:
    """One question.

    Attributes
    ----------
    extreme, value, question
        What is extreme, how extreme, and what is asked.
    ask
        Gives the answer.
    expected
        Gives the number that is known from elsewhere, None if the reference cannot say; None if there is none.
    reference
        Where from.
    tolerance
        Relative error above which an answer is wrong; inf where the error is that of the mesh and to be reported.
    floor
        Size below which a number counts as this large in its relative error.
    """

    extreme: str
    value: str
    question: str
    ask: Callable[[], Answer]
    expected: Callable[[], float | None] | None
    reference: str
    tolerance: float = _EXACT
    floor: float = 1e-3


def nearly_separated(elements: int) -> tuple[fo.ContactSystem, dict[str, fo.LoadCycle]]:
    """A scene, and load cycles whose mean load leaves a share of its pressure to the node that a shear on the punch unloads most, by that share."""
    system = fo.scenes.PunchOnHalfPlane(elements=elements, growth=1.3).condense()
    (_, pressed), (_, tilted) = system.bonded["P"], system.bonded["Q"]
    tilt = float((pressed[tilted < 0] / -tilted[tilted < 0]).min())
    left = (1e-3, 1e-6, 1e-9, 0.0, -1e-3)
    return system, {f"{share:g}": fo.LoadCycle({"P": 1.0, "Q": (1 - share) * tilt}, LOADS.corners) for share in left}
