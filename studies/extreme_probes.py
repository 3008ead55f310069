"""A question at the edge of what can be asked: its form, sizes and loads."""

from collections.abc import Callable
from dataclasses import dataclass

import frictopt as fo

__all__ = ["CYCLE", "SHEAR", "Answer", "Probe", "Sizes"]

CYCLE = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
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
    """What an answer says: its number, its residual, who gave it, and who was asked before."""

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
