"""A scene in three dimensions: a square punch pressed on a block."""

from dataclasses import dataclass

import numpy as np
from skfem import MeshHex

from ..contact.checks import Array, choice
from ..fem.bodies import Body, Support
from ..fem.elasticity import ELEMENT_NAMES, ElementName, Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from .grading import away, steps
from .scene import Scene


@dataclass(frozen=True)
class SquarePunch(Scene):
    """A punch of square section on a block, in structured hexahedra.

    The contact is `|x|, |y| <= half_width`, z = 0; the block's bottom is held. Load cases, each of unit traction: "P", pressure on the top of the
    punch; "Qx" and "Qy", shear there along x and y; "sigma", tension along x on the two sides of the block.

    Parameters
    ----------
    elements
        Number of elements along each side of the contact, at least 2: N = (elements + 1)^2 node pairs. 24 make 48,000 unknowns.
    half_width, punch_height
        Half the side `a` of the contact, and height of the punch, length.
    block_half_width, block_depth
        Size of the block, length.
    growth
        Ratio of neighbouring element sizes away from the contact, > 1; the first one has the size of those on the contact.
    punch_material, block_material
        The two materials.
    element
        "linear", or "mean_dilatation": hexahedra that do not lock as nu approaches 0.5.

    Raises
    ------
    ModelError
        Sizes that are not positive or too far apart, a block narrower than the punch.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.SquarePunch(elements=2, growth=2.0).condense()
    >>> system
    ContactSystem(nodes=9, tangents=2, loads=['P', 'Qx', 'Qy', 'sigma'], gap=False)
    >>> q, p = system.reaction({"P": 1.0})
    >>> round(float(p.sum()), 6)  # the whole pressure, (2 a)^2
    4.0
    """

    elements: int = 10
    half_width: float = 1.0
    punch_height: float = 1.5
    block_half_width: float = 4.0
    block_depth: float = 3.0
    growth: float = 1.7
    punch_material: Material = Material()
    block_material: Material = Material()
    element: ElementName = "linear"

    _multiple = 1
    _within = (("half_width", "block_half_width"),)

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        super().__post_init__()

    @property
    def _size(self) -> float:
        return 2 * self.half_width / self.elements

    def _nodes(self) -> float:
        lengths = self.block_half_width - self.half_width, self.punch_height, self.block_depth
        side, up, down = (steps(length, self._size, self.growth) for length in lengths)
        return max((self.elements + 1) ** 2 * (1 + up), (self.elements + 1 + 2 * side) ** 2 * (1 + down))

    def _away(self, length: float) -> Array:
        return away(length, self._size, self.growth)

    def model(self) -> ContactModel:
        """The two meshes with supports and load cases."""
        a, half, depth = self.half_width, self.block_half_width, self.block_depth
        face = a * np.arange(-self.elements, self.elements + 1, 2) / self.elements
        side = a + self._away(half - a)[1:]
        side[-1] = half
        line = np.r_[-side[::-1], face, side]
        punch = MeshHex.init_tensor(face, face, self._away(self.punch_height))
        block = MeshHex.init_tensor(line, line, -self._away(depth)[::-1])
        top = punch.p[2].max()
        punch = punch.with_boundaries({"contact": lambda x: x[2] == 0, "top": lambda x: x[2] == top})
        bottom = block.p[2].min()
        block = block.with_boundaries(
            {
                "contact": lambda x: (x[2] == 0) & (np.abs(x[0]) < a) & (np.abs(x[1]) < a),
                "bottom": lambda x: x[2] == bottom,
                "left": lambda x: x[0] == -half,
                "right": lambda x: x[0] == half,
            }
        )
        return ContactModel(
            bodies={"punch": Body(punch, self.punch_material, self.element), "block": Body(block, self.block_material, self.element)},
            supports=[Support("block", "bottom")],
            loads={
                "P": [Traction("punch", "top", z=-1.0)],
                "Qx": [Traction("punch", "top", x=1.0)],
                "Qy": [Traction("punch", "top", y=1.0)],
                "sigma": [Traction("block", "left", x=-1.0), Traction("block", "right", x=1.0)],
            },
        )
