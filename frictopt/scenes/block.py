"""What punches on a block share, in the plane and in space: meshes, supports and load cases."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from skfem import MeshHex, MeshQuad

from ..contact.checks import Array, choice
from ..fem.bodies import Body, Support
from ..fem.elasticity import ELEMENT_NAMES, ElementName, Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from .grading import away
from .scene import Scene


@dataclass(frozen=True)
class PunchOnBlock(Scene):
    """Base of scenes of a punch on a block; the last coordinate goes up from the contact."""

    elements: int = 10
    half_width: float = 1.0
    punch_height: float = 2.0
    block_half_width: float = 4.0
    block_depth: float = 3.0
    growth: float = 1.7
    punch_material: Material = Material()
    block_material: Material = Material()
    element: ElementName = "linear"

    _within = (("half_width", "block_half_width"),)
    _directions = "xy"

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        super().__post_init__()

    @property
    @abstractmethod
    def contact_nodes(self) -> Array:
        """Coordinates of the nodes along the contact, exactly mirror-symmetric."""

    @property
    def corner_size(self) -> float:
        """Size of the contact element at the corner, length."""
        return float(self.contact_nodes[-1] - self.contact_nodes[-2])

    @property
    def _supports(self) -> Sequence[Support]:
        return [Support("block", "bottom")]

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        face, half = self.contact_nodes, self.block_half_width
        up, down, beside = (away(length, self.corner_size, self.growth) for length in (self.punch_height, self.block_depth, half - self.half_width))
        side = self.half_width + beside[1:]
        side[-1] = half
        across = len(self._directions) - 1
        return [face] * across + [up], [np.r_[-side[::-1], face, side]] * across + [-down[::-1]]

    def model(self) -> ContactModel:
        """The two meshes with supports and load cases."""
        kind = MeshQuad if self._directions == "xy" else MeshHex
        punch, block = (kind.init_tensor(*lines) for lines in self._grids)
        punch = punch.with_boundaries({"contact": lambda x: x[-1] == 0, "top": lambda x: x[-1] == self.punch_height})
        block = block.with_boundaries(
            {
                "contact": lambda x: (x[-1] == 0) & (np.abs(x[:-1]) < self.half_width).all(axis=0),
                "bottom": lambda x: x[-1] == -self.block_depth,
                "left": lambda x: x[0] == -self.block_half_width,
                "right": lambda x: x[0] == self.block_half_width,
            }
        )
        *across, up = list(self._directions)
        shears = {name: f"Q{name}" if len(across) > 1 else "Q" for name in across}
        return ContactModel(
            bodies={"punch": Body(punch, self.punch_material, self.element), "block": Body(block, self.block_material, self.element)},
            supports=self._supports,
            loads={
                "P": [Traction("punch", "top", **{up: -1.0})],
                **{case: [Traction("punch", "top", **{name: 1.0})] for name, case in shears.items()},
                "sigma": [Traction("block", "left", x=-1.0), Traction("block", "right", x=1.0)],
            },
        )
