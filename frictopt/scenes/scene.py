"""What all scenes share: the checks of their fields, graded coordinates, and that they condense their model."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from ..base import Array, Plotted, finite_number, shown, whole_number
from ..contact import ContactSystem
from ..errors import ModelError
from ..fem.elasticity import Material
from ..fem.model import ContactModel

_MOST_ELEMENTS = 10_000  # along a contact: in the plane S is dense and takes 3 GB then
_MOST_NODES = 1_000_000  # twenty times those of the paper's scene
_APART = 1e6  # the largest length over the smallest
_RANGES: dict[str, dict[str, float]] = {  # of numbers that are not positive lengths
    "angle": {"least": 10.0, "below": 80.000_001},
    "bore_radius": {"least": 0.0},
    "edge_radius": {"least": 0.0},
    "flat_half_width": {"least": 0.0},
    "grading": {"least": 1.0, "below": 1e15},
    "growth": {"above": 1.0, "below": 100.0},
}


@dataclass(frozen=True)
class Scene(Plotted):
    """Base of scenes, whose fields are numbers, materials, and `elements`, the number of them along the contact."""

    _multiple: ClassVar[int] = 2  # of which `elements` is one, so that nodes lie in the middle
    _within: ClassVar[
        Sequence[tuple[str, str]]
    ] = ()  # lengths of which the first is less than the second

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(
                self, field.name, self._checked(field.name, field.type, getattr(self, field.name))
            )
        lengths = {
            field.name: float(getattr(self, field.name))
            for field in fields(self)
            if field.type is float and field.name not in _RANGES
        }
        for inner, outer in self._within:
            if not getattr(self, inner) < getattr(self, outer):
                raise ModelError(
                    f"{outer}: {getattr(self, outer):g}; it must be more than {inner} = {getattr(self, inner):g}"
                )
        small, large = (pick(lengths, key=lambda name: lengths[name]) for pick in (min, max))
        if lengths[large] > _APART * lengths[small]:
            raise ModelError(
                f"{large}: {lengths[large]:g} beside {small} = {lengths[small]:g}; give at most {_APART:g} times as much"
            )
        self._check_sizes()
        nodes = sum(np.prod([float(len(line)) for line in lines]) for lines in self._grids)
        if nodes > _MOST_NODES:
            given = ", ".join(
                f"{name} = {getattr(self, name)}"
                for name in ("elements", *lengths, "grading", "growth")
                if hasattr(self, name)
            )
            raise ModelError(
                f"{given}: they make a mesh of {nodes:.0e} nodes, the most are {_MOST_NODES:.0e}; give less, or more growth"
            )

    def _checked(self, name: str, kind: object, value: Any) -> Any:
        """The value of a field of some kind."""
        if name == "elements":
            value = whole_number(name, value, least=max(2, self._multiple), most=_MOST_ELEMENTS)
            if value % self._multiple:
                raise ModelError(
                    f"elements: {value}; give a multiple of {self._multiple}, so that nodes lie in the middle"
                )
        if kind is Material and not isinstance(value, Material):
            raise ModelError(f"{name}: {shown(value)}; give a Material")
        return (
            finite_number(name, value, **_RANGES.get(name, {"above": 0.0}))
            if kind is float
            else value
        )

    def _check_sizes(self) -> None:
        """Refuse sizes that do not fit."""

    @property
    def contact_nodes(self) -> Array:
        """Rising coordinates of the nodes along a contact, length."""
        raise NotImplementedError

    @property
    def corner_size(self) -> float:
        """Size of the element at the end of the contact, length."""
        return float(np.diff(self.contact_nodes)[-1])

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        """Coordinates along the axes of the structured mesh of each body."""
        raise NotImplementedError

    def model(self) -> ContactModel:
        """The meshes with contacts, supports and load cases."""
        raise NotImplementedError

    def condense(self) -> ContactSystem:
        """Mesh, assemble and condense to the contact."""
        return self.model().condense()


def along(half_length: float, elements: int, grading: float) -> Array:
    """(elements + 1,) coordinates, mirror-symmetric, of even elements in geometric progression: in the middle `grading` times the end."""
    sizes = grading ** -np.linspace(0.0, 1.0, elements // 2)
    right = half_length * np.cumsum(sizes) / sizes.sum()
    right[-1] = half_length
    if not (np.diff(right, prepend=0.0) > 0).all():
        raise ModelError(
            f"grading: {grading:g}; elements at the ends are smaller than rounding, give a lower grading or fewer elements"
        )
    return np.concatenate([-right[::-1], [0.0], right])


def away(length: float, first: float, growth: float) -> Array:
    """Coordinates from 0 to exactly `length`, steps growing by `growth` from about `first`."""
    steps = max(1.0, np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
    if steps > _MOST_NODES:
        raise ModelError(
            f"growth: {growth:g} makes {steps:.0e} elements from {first:g} on over {length:g}, the most are {_MOST_NODES:g}; give more"
        )
    nodes = np.concatenate([[0.0], np.cumsum(growth ** np.arange(steps))])
    nodes *= length / nodes[-1]
    nodes[-1] = length
    return nodes
