"""The base of all scenes: checks of their fields, and graded coordinates for their meshes."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from ..base import Array, finite_number, shown, whole_number
from ..contact import ContactSystem
from ..errors import ModelError
from ..fem.elasticity import Material
from ..fem.model import ContactModel

# The largest scenes.

# Elements along the contact: with this number the dense S of a plane contact takes 3 GB.
_ELEMENTS = 10_000
# Nodes of all meshes: twenty times as many as in the paper's scene.
_NODES = 1_000_000
# The largest length divided by the smallest length.
_LENGTH_RATIO = 1e6
# Ranges of the numbers that are not positive lengths.
_RANGES: dict[str, dict[str, float]] = {
    "angle": {"least": 10.0, "most": 80.0},
    "bore_radius": {"least": 0.0},
    "edge_radius": {"least": 0.0},
    "flat_half_width": {"least": 0.0},
    "grading": {"least": 1.0, "below": 1e15},
    "growth": {"above": 1.0, "below": 100.0},
}


@dataclass(frozen=True)
class Scene:
    """Base of scenes: their fields are numbers, materials, and `elements` along the contact."""

    # `elements` is a multiple of this, so that nodes lie in the middle.
    _multiple: ClassVar[int] = 2
    # Pairs of lengths of which the first must be less than the second.
    _within: ClassVar[Sequence[tuple[str, str]]] = ()

    def __post_init__(self) -> None:
        for field in fields(self):
            value = self._checked(field.name, field.type, getattr(self, field.name))
            object.__setattr__(self, field.name, value)
        self._check_lengths()
        self._check_sizes()
        self._check_nodes()

    def _checked(self, name: str, kind: object, value: Any) -> Any:
        """The checked value of a field of this kind."""
        if name == "elements":
            least = max(2, self._multiple)
            value = whole_number(name, value, least=least, most=_ELEMENTS)
            if value % self._multiple:
                raise ModelError(
                    f"elements: {value}; give a multiple of {self._multiple}, "
                    "so that nodes lie in the middle"
                )
        elif kind is Material and not isinstance(value, Material):
            raise ModelError(f"{name}: {shown(value)}; give a Material")
        elif kind is float:
            value = finite_number(name, value, **_RANGES.get(name, {"above": 0.0}))
        return value

    @property
    def _lengths(self) -> dict[str, float]:
        """Name of each positive length -> its value."""
        names = [field.name for field in fields(self) if field.type is float]
        return {name: getattr(self, name) for name in names if name not in _RANGES}

    def _check_lengths(self) -> None:
        """Refuse lengths in the wrong order, or too far apart."""
        for inner, outer in self._within:
            if not getattr(self, inner) < getattr(self, outer):
                raise ModelError(
                    f"{outer}: {getattr(self, outer):g}; "
                    f"it must be more than {inner} = {getattr(self, inner):g}"
                )
        lengths = self._lengths
        smallest = min(lengths, key=lambda name: lengths[name])
        largest = max(lengths, key=lambda name: lengths[name])
        if lengths[largest] > _LENGTH_RATIO * lengths[smallest]:
            raise ModelError(
                f"{largest}: {lengths[largest]:g} beside {smallest} = {lengths[smallest]:g}; "
                f"give at most {_LENGTH_RATIO:g} times as much"
            )

    def _check_sizes(self) -> None:
        """Refuse sizes that do not fit."""

    def _check_nodes(self) -> None:
        """Refuse meshes of too many nodes."""
        nodes = sum(np.prod([float(len(line)) for line in lines]) for lines in self._grids)
        if nodes > _NODES:
            names = ("elements", *self._lengths, "grading", "growth")
            sizes = [f"{name} = {getattr(self, name)}" for name in names if hasattr(self, name)]
            raise ModelError(
                f"{', '.join(sizes)}: they make a mesh of {nodes:.0e} nodes, "
                f"the most are {_NODES:.0e}; give less, or more growth"
            )

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

    def plot(self, ax: Any = None) -> Any:
        """Draw the model of the scene, see `ContactModel.plot`."""
        return self.model().plot(ax)

    def model(self) -> ContactModel:
        """The meshes with contacts, supports and load cases."""
        raise NotImplementedError

    def condense(self, *, progress: bool = True) -> ContactSystem:
        """Mesh, assemble and condense to the contact.

        `progress`: whether to show a progress bar after two seconds.
        """
        return self.model().condense(progress=progress)


def along(half_length: float, elements: int, grading: float) -> Array:
    """(elements + 1,) mirror-symmetric coordinates, for an even number of elements.

    Sizes are in geometric progression; the middle element is `grading` times as large as the end
    element.
    """
    sizes = grading ** -np.linspace(0.0, 1.0, elements // 2)
    right = half_length * np.cumsum(sizes) / sizes.sum()
    right[-1] = half_length
    if not (np.diff(right, prepend=0.0) > 0).all():
        raise ModelError(
            f"grading: {grading:g}; the elements at the ends are too small for the rounding of "
            "coordinates; give a lower grading or fewer elements"
        )
    return np.concatenate([-right[::-1], [0.0], right])


def away(length: float, first: float, growth: float) -> Array:
    """Coordinates from 0 to exactly `length`; steps grow by `growth` from about `first`."""
    steps = max(1.0, np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
    if steps > _NODES:
        raise ModelError(
            f"growth: {growth:g} makes {steps:.0e} elements from {first:g} on over {length:g}, "
            f"the most are {_NODES:g}; give more"
        )
    nodes = np.concatenate([[0.0], np.cumsum(growth ** np.arange(steps))])
    nodes *= length / nodes[-1]
    nodes[-1] = length
    return nodes
