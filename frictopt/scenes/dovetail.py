"""A dovetail root of a blade in the slot of a disc: two inclined flanks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from skfem import MeshQuad

from ..base import SAME_POINT, Array, Booleans
from ..errors import ModelError
from ..fem.bodies import Body
from ..fem.contacts import Contact
from ..fem.elasticity import Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from ..fem.supports import Support
from .scene import Scene, along, away

# Width of the gap between slot and blade, at neck and foot, divided by their height.
_CLEARANCE = 0.2


@dataclass(frozen=True)
class Dovetail(Scene):
    """A blade root that is held by two flanks in the slot of a disc; meshed in quadrilaterals.

    The root widens downwards. Body 1 is the blade, body 2 the disc, clamped at its bottom. The
    contacts are "right" and "left"; the first node is at the bottom of the right flank, the last
    one at the bottom of the left flank. Load cases, each of unit traction on the top of the blade:
    "pull" along +y, "sway" along +x. If friction is at least the cotangent of the angle, the flanks
    lock: they hold a wedged blade without any load.

    Parameters
    ----------
    angle
        Angle of the flanks to the horizontal, degrees, from 10 to 80.
    elements
        Number of elements along each flank, even (N = 2 elements + 2 node pairs).
    flank_length, neck_half_width, neck_height, foot_height
        Length of each flank, half-width and height of the blade above the flanks, and its height
        below them. The slot is 1.2 times as deep below them.
    lug_height, disc_half_width, disc_depth
        Height of the disc above the flanks, half-width of the disc, and its depth below the middle
        of the flanks, length.
    edge_radius, edge_length
        Radius at both ends of the blade's flanks (0: sharp ends), and the length before each end
        over which the gap is a parabola with the curvature of this radius.
    grading, growth
        Size of the middle element of a flank divided by the size of its end element, >= 1; ratio of
        neighbouring sizes away from the flanks, > 1.
    blade_material, disc_material
        The two materials.

    Raises
    ------
    ModelError
        Sizes that are not positive or do not fit, odd numbers of elements, a mesh of more than a
        million nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.scenes.Dovetail(angle=50, elements=4, growth=2.0).condense()
    ContactSystem(nodes=10, x=-1.34938 .. 0.900624, contacts=['right', 'left'], loads=['pull',
    'sway'], gap=False)
    """

    angle: float = 45.0
    elements: int = 40
    flank_length: float = 1.0
    neck_half_width: float = 1.0
    neck_height: float = 2.0
    foot_height: float = 0.8
    lug_height: float = 0.8
    disc_half_width: float = 5.0
    disc_depth: float = 5.0
    edge_radius: float = 0.0
    edge_length: float = 0.2
    grading: float = 10.0
    growth: float = 1.15
    blade_material: Material = Material()
    disc_material: Material = Material()

    def _check_sizes(self) -> None:
        if not self.edge_length <= self.flank_length / 2:
            raise ModelError(
                f"edge_length: {self.edge_length:g}; "
                f"it must be at most half of flank_length = {self.flank_length:g}"
            )
        wall = max(self._foot, self.neck_half_width + _CLEARANCE * self.lug_height)
        if not self.disc_half_width > wall or not self.disc_depth > self._slot:
            raise ModelError(
                f"disc_half_width, disc_depth: {self.disc_half_width:g}, {self.disc_depth:g}; "
                f"the slot takes {wall:g}, {self._slot:g}; give more"
            )
        if not self.corner_size > SAME_POINT * max(self.disc_half_width, self.disc_depth):
            raise ModelError(
                f"grading: {self.grading:g}; the elements at the ends are too small for the "
                "rounding of coordinates; give a lower grading or fewer elements"
            )

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        """Grids of blade and disc: x divided by the half-width at each height, and heights."""
        return self._blade_grid, self._disc_grid

    @property
    def _flank_heights(self) -> Array:
        return np.asarray(self.contact_nodes * -self._direction[1])

    @property
    def _blade_grid(self) -> tuple[Array, Array]:
        h = self._half_height
        below = away(self.foot_height, self.corner_size, self.growth)
        above = away(self.neck_height, self.corner_size, self.growth)
        half = away(1.0, self.corner_size / self.neck_half_width, self.growth)
        columns = np.r_[-(1.0 - half), 1.0 - half[-2::-1]]
        return columns, np.r_[-h - below[:0:-1], self._flank_heights, h + above[1:]]

    @property
    def _disc_grid(self) -> tuple[Array, Array]:
        """Grid of the disc, whose x is 1 at the wall of the slot and 2 at the side of the disc."""
        h = self._half_height
        first = self.corner_size
        lug = away(self.lug_height, first, self.growth)
        slot = away(self._slot - h, first, self.growth)
        below_slot = away(self.disc_depth - self._slot, slot[-1] - slot[-2], self.growth)
        depths = np.r_[h + slot[1:], self._slot + below_slot[1:]]

        inner = away(1.0, first / self._foot, self.growth)
        outer = away(1.0, first / (self.disc_half_width - self._foot), self.growth)
        columns = np.r_[1.0 - inner[:0:-1], 1.0 + outer]
        heights = np.r_[-depths[::-1], self._flank_heights, h + lug[1:]]
        return np.r_[-columns[:0:-1], columns], heights

    @property
    def contact_nodes(self) -> Array:
        """(elements + 1,) distances along a flank from its middle, upwards."""
        return along(self.flank_length / 2, self.elements, self.grading)

    @property
    def _direction(self) -> Array:
        """Unit vector along the right flank, downwards."""
        return np.array([np.cos(np.radians(self.angle)), -np.sin(np.radians(self.angle))])

    @property
    def _half_height(self) -> float:
        return float(self.flank_length / 2 * -self._direction[1])

    @property
    def _foot(self) -> float:
        """Half-width of the blade at the bottom of the flanks."""
        return float(self.neck_half_width + self.flank_length * self._direction[0])

    @property
    def _slot(self) -> float:
        """Depth of the slot below the middle of the flanks."""
        return self._half_height + (1 + _CLEARANCE) * self.foot_height

    def _half_width(self, y: Array) -> Array:
        """Half-width of the blade at some heights, constant beyond the flanks."""
        h = self._half_height
        down_the_flank = (h - np.clip(y, -h, h)) / -self._direction[1]
        return np.asarray(self.neck_half_width + down_the_flank * self._direction[0])

    def model(self) -> ContactModel:
        """The two meshes with contacts, supports and load cases; rounded ends are a gap."""
        gap = self._rounded if self.edge_radius else None
        return ContactModel(
            bodies={"blade": self._blade(), "disc": self._disc()},
            contacts=[Contact("blade", "disc", name, name, gap=gap) for name in ("right", "left")],
            supports=[Support("disc", "bottom")],
            loads={
                "pull": [Traction("blade", "top", y=1.0)],
                "sway": [Traction("blade", "top", x=1.0)],
            },
        )

    def _rounded(self, _: Array, y: Array) -> Array:
        """The gap at rounded ends of the flanks."""
        from_middle = np.abs(y / self._direction[1])
        past_flat = np.maximum(from_middle - (self.flank_length / 2 - self.edge_length), 0.0)
        return np.asarray(past_flat**2 / (2 * self.edge_radius))

    def _blade(self) -> Body:
        """Body 1, with the boundaries "right", "left" and "top"."""
        columns, heights = self._blade_grid
        top = heights[-1]
        mesh = MeshQuad.init_tensor(columns, heights)
        mesh = mesh.with_boundaries(self._flanks | {"top": lambda x: x[1] == top})
        x, y = mesh.p
        below = np.maximum(-y - self._half_height, 0.0)
        half_width = self._half_width(y) * (1 - _CLEARANCE * below / self.foot_height)
        return Body(replace(mesh, doflocs=np.array([x * half_width, y])), self.blade_material)

    def _disc(self) -> Body:
        """Body 2, with the boundaries "right", "left" and "bottom"."""
        columns, heights = self._disc_grid
        bottom = heights[0]
        mesh = MeshQuad.init_tensor(columns, heights)
        middle_x, middle_y = mesh.p[:, mesh.t].mean(axis=1)
        in_slot = (np.abs(middle_x) < 1) & (middle_y > -self._slot)
        mesh = mesh.remove_elements(np.flatnonzero(in_slot))
        mesh = mesh.with_boundaries(self._flanks | {"bottom": lambda x: x[1] == bottom})
        x, y = mesh.p
        wall = self._half_width(y) + _CLEARANCE * np.maximum(y - self._half_height, 0.0)
        # Share of the way from the wall of the slot to the side of the disc.
        outward = np.maximum(np.abs(x) - 1, 0.0)
        beside_slot = wall + outward * (self.disc_half_width - wall)
        distance = np.where(outward > 0, beside_slot, np.abs(x) * wall)
        points = np.array([np.sign(x) * distance, y])
        return Body(replace(mesh, doflocs=points), self.disc_material)

    @property
    def _flanks(self) -> dict[str, Callable[[Array], Booleans]]:
        """The flanks in the straight meshes, where they are at x = 1 and -1."""
        return {
            "right": lambda x: self._is_on_flank(x, 1.0),
            "left": lambda x: self._is_on_flank(x, -1.0),
        }

    def _is_on_flank(self, x: Array, side: float) -> Booleans:
        is_at_side = np.abs(x[0] - side) < SAME_POINT
        return np.asarray(is_at_side & (np.abs(x[1]) < self._half_height))
