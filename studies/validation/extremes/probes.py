"""A question with extreme input: its form, sizes and loads."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

import frictopt as fo
from studies.paper import LOADS

SHEAR = fo.LoadCycle(mean={"P": 1.0}, corners=[{"Q": -1.0}, {"Q": 1.0}])
_EXACT = 1e-7


@dataclass(frozen=True)
class Sizes:
    """Sizes of the cases.

    Attributes
    ----------
    elements, unit_elements
        Numbers of elements of the usual punch, and of the punch in other units whose ranges are
        computed.
    most_nodes
        Numbers of elements of the question about many nodes.
    most_guaranteed
        Largest number of elements for which the guaranteed limit is computed.
    gradings
        Gradings of the contact.
    corners, cycles
        Numbers of corners and cycles of the questions about many corners and many cycles.
    every
        1: all values of each extreme. 2: every second value, and the last one.
    """

    elements: int = 40
    unit_elements: int = 8
    most_nodes: tuple[int, ...] = (2, 4, 10, 40, 124, 250, 500, 1000)
    most_guaranteed: int = 250
    gradings: tuple[float, ...] = (1.0, 1e2, 1e4, 1e6, 1e9, 1e12)
    corners: int = 1000
    cycles: int = 100_000
    every: int = 1


@dataclass(frozen=True)
class Answer:
    """An answer: its number, its residual, its solver."""

    number: float
    residual: float
    solver: str

    @classmethod
    def of(cls, result: Any, number: float) -> Self:
        """The answer with a number of a result."""
        return cls(number, result.residual, result.record.solver)


@dataclass(frozen=True)
class Probe:
    """One question.

    Attributes
    ----------
    extreme, value, question
        The extreme quantity, its value, and the name of the question.
    ask
        Function that returns the answer.
    expected
        Function that returns the independent number, or None if the reference has no answer. None:
        there is no reference.
    reference
        Source of the independent number.
    tolerance
        Relative error above which an answer is wrong. The tolerance is inf if the error is the
        error of the mesh, which is only reported.
    floor
        Smallest size to which an error is relative.
    """

    extreme: str
    value: str
    question: str
    ask: Callable[[], Answer]
    expected: Callable[[], float | None] | None
    reference: str
    tolerance: float = _EXACT
    floor: float = 1e-3


def shakedown(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, open_nodes: Any = None
) -> Answer:
    """The shakedown limit, with `open_nodes` only for these open nodes."""
    limit = fo.shakedown_limit(system, cycle, friction, open_nodes=open_nodes)
    return Answer.of(limit, limit.load_factor)


def punch_in_units(
    force: float, length: float, elements: int = 8
) -> tuple[fo.ContactSystem, fo.LoadCycle]:
    """A small punch whose mesh and material are in other units, and its load cycle."""
    material, pressure = fo.fem.Material(force / length), force / length
    sizes = length, 2 * length, 12 * length, 12 * length
    scene = fo.scenes.PunchOnHalfPlane(
        elements, *sizes, growth=1.5, punch_material=material, block_material=material, grading=5.0
    )
    return scene.condense(), fo.LoadCycle(
        {"P": pressure}, [{"sigma": -pressure}, {"sigma": pressure}]
    )


def one_node(A: float, B: float, C: float, q0: float, p0: float) -> fo.ContactSystem:
    """One node under the loads of the paper."""
    loads = {"P": (np.array([q0]), np.array([p0])), "sigma": (np.array([1.0]), np.array([0.2]))}
    return fo.ContactSystem.from_blocks(
        np.array([[A]]), np.array([[B]]), np.array([[C]]), np.zeros(1), loads
    )


def loose() -> fo.ContactSystem:
    """Two nodes that only friction holds along the contact."""
    one = np.ones(2)
    none = np.zeros((2, 2))
    return fo.ContactSystem.from_blocks(
        none,
        none,
        np.eye(2),
        np.arange(2.0),
        {"P": (0 * one, one), "sigma": (np.array([0.3, -0.3]), 0 * one)},
    )


def nearly_separated(elements: int) -> tuple[fo.ContactSystem, dict[str, fo.LoadCycle]]:
    """A scene, and load cycles whose mean load leaves little pressure at one node.

    A shear on the punch unloads this node most. The names of the cycles are the shares of its
    pressure that the mean load leaves.
    """
    system = fo.scenes.PunchOnHalfPlane(elements=elements, growth=1.3).condense()
    (_, pressed), (_, tilted) = system.bonded["P"], system.bonded["Q"]
    tilt = float((pressed[tilted < 0] / -tilted[tilted < 0]).min())
    shares = (1e-3, 1e-6, 1e-9, 0.0, -1e-3)
    return system, {
        f"{share:g}": fo.LoadCycle({"P": 1.0, "Q": (1 - share) * tilt}, LOADS.corners)
        for share in shares
    }
