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

_CLEARANCE = 0.2  # of the slot beside neck and foot, over their height


@dataclass(frozen=True)
class Dovetail(Scene):
    """A blade root, wider below than above, held by both flanks in the slot of a disc; meshed in quadrilaterals.

    Body 1 is the blade, body 2 the disc, clamped at its bottom. The contacts are "right" and
    "left"; the first node is at the bottom of the right flank, the last one at the bottom of the
    left flank. Load cases, each of unit traction on the top of the blade: "pull" along +y, "sway"
    along +x. With friction of at least the cotangent of the angle the flanks lock: they hold a
    blade that is wedged in without any load.

    Parameters
    ----------
    angle
        Angle of the flanks to the horizontal, degrees, from 10 to 80.
    elements
        Number of elements along each flank, even (N = 2 elements + 2 node pairs).
    flank_length, neck_half_width, neck_height, foot_height
        Length of each flank, size of the blade above the flanks, and its height below them; the
        slot is 1.2 times as deep.
    lug_height, disc_half_width, disc_depth
        Height of the disc above the flanks, its half-width, and its depth below the middle of the
        flanks, length.
    edge_radius, edge_length
        Radius at both ends of the blade's flanks, which then open along a parabola of that
        curvature over that length before the end; 0: sharp.
    grading, growth
        Size of the middle element of a flank over that of its end element, >= 1; ratio of
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
                f"edge_length: {self.edge_length:g}; it must be at most half of flank_length = {self.flank_length:g}"
            )
        wall = max(self._foot, self.neck_half_width + _CLEARANCE * self.lug_height)
        if not self.disc_half_width > wall or not self.disc_depth > self._slot:
            sizes = f"{self.disc_half_width:g}, {self.disc_depth:g}; the slot takes {wall:g}, {self._slot:g}"
            raise ModelError(f"disc_half_width, disc_depth: {sizes}; give more")
        if not self.corner_size > SAME_POINT * max(self.disc_half_width, self.disc_depth):
            raise ModelError(
                f"grading: {self.grading:g}; elements at the ends are smaller than rounding, give a lower grading or fewer elements"
            )

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        """Of the blade and of the disc, x over the width at each height."""
        h, first, y = self._half_height, self.corner_size, self.contact_nodes * -self._direction[1]
        heights = self.foot_height, self.neck_height, self.lug_height, self._slot - h
        below, above, lug, slot = (away(height, first, self.growth) for height in heights)
        half, inner, side = (
            away(1.0, first / width, self.growth)
            for width in (self.neck_half_width, self._foot, self.disc_half_width - self._foot)
        )
        base = away(self.disc_depth - self._slot, slot[-1] - slot[-2], self.growth)
        columns, under = (
            np.r_[1.0 - inner[:0:-1], 1.0 + side],
            np.r_[h + slot[1:], self._slot + base[1:]],
        )
        blade = np.r_[-(1.0 - half), 1.0 - half[-2::-1]], np.r_[-h - below[:0:-1], y, h + above[1:]]
        return blade, (np.r_[-columns[:0:-1], columns], np.r_[-under[::-1], y, h + lug[1:]])

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

    def _flank(self, y: Array) -> Array:
        """Half-width at some heights between the ends of the flanks, and the one of the nearer end elsewhere."""
        down = (
            self._half_height - np.clip(y, -self._half_height, self._half_height)
        ) / -self._direction[1]
        return np.asarray(self.neck_half_width + down * self._direction[0])

    def model(self) -> ContactModel:
        """The two meshes with contacts, supports and load cases; rounded ends are an initial gap."""
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
        beyond = np.maximum(
            np.abs(y / self._direction[1]) - (self.flank_length / 2 - self.edge_length), 0.0
        )
        return np.asarray(beyond**2 / (2 * self.edge_radius))

    def _blade(self) -> Body:
        """Body 1, with the boundaries "right", "left" and "top"."""
        columns, levels = self._grids[0]
        mesh = MeshQuad.init_tensor(columns, levels)
        mesh = mesh.with_boundaries(
            _flanks(self._half_height) | {"top": lambda x: x[1] == levels[-1]}
        )
        below = np.maximum(-mesh.p[1] - self._half_height, 0.0)
        width = self._flank(mesh.p[1]) * (1 - _CLEARANCE * below / self.foot_height)
        return Body(
            replace(mesh, doflocs=np.array([mesh.p[0] * width, mesh.p[1]])), self.blade_material
        )

    def _disc(self) -> Body:
        """Body 2, with the boundaries "right", "left" and "bottom"."""
        columns, levels = self._grids[1]
        mesh = MeshQuad.init_tensor(columns, levels)
        middle = mesh.p[:, mesh.t].mean(axis=1)
        mesh = mesh.remove_elements(
            np.flatnonzero((np.abs(middle[0]) < 1) & (middle[1] > -self._slot))
        )
        mesh = mesh.with_boundaries(
            _flanks(self._half_height) | {"bottom": lambda x: x[1] == levels[0]}
        )
        wall = self._flank(mesh.p[1]) + _CLEARANCE * np.maximum(mesh.p[1] - self._half_height, 0.0)
        out = np.maximum(np.abs(mesh.p[0]) - 1, 0.0)
        x = np.sign(mesh.p[0]) * np.where(
            out > 0, wall + out * (self.disc_half_width - wall), np.abs(mesh.p[0]) * wall
        )
        return Body(replace(mesh, doflocs=np.array([x, mesh.p[1]])), self.disc_material)


def _flanks(half_height: float) -> dict[str, Callable[..., Booleans]]:
    """The flanks in the straight mesh, where they are at x = 1 and -1."""
    return {
        name: lambda x, at=at: (np.abs(x[0] - at) < SAME_POINT) & (np.abs(x[1]) < half_height)
        for name, at in (("right", 1.0), ("left", -1.0))
    }
