"""Contacts of round bodies, one shrunk onto or into the other.

A collar on a shaft is axisymmetric; the contact of a pin in a plate is a closed ring.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from skfem import MeshQuad

from ..base import SAME_POINT, Array, Integers
from ..errors import ModelError
from ..fem.bodies import Body
from ..fem.contacts import Contact, Interference
from ..fem.elasticity import Material
from ..fem.loads import BodyForce, Traction
from ..fem.model import ContactModel
from ..fem.supports import Support
from .scene import Scene, along, away


@dataclass(frozen=True)
class PressFit(Scene):
    """A collar that is shrunk onto a shaft, in axisymmetry; meshed in quadrilaterals.

    x is the radius, y runs along the shaft, from the middle of the collar. Body 1 is the collar,
    body 2 the shaft. The nodes of the contact are ordered from its upper to its lower end, against
    y. Positive slips have the same direction. Forces are totals over the circumference. Load cases:
    "fit", a radial interference of 1, which is half of the diametral interference; "tension", a
    tension of 1 on both ends of the shaft; "push", an axial force of 1 along +y on the lower face
    of the collar, taken up at the upper end of the shaft. Torsion and bending need a model in
    space, because slips or stresses then vary around the axis.

    Parameters
    ----------
    shaft_radius, bore_radius, collar_radius
        Radius of the contact, of the shaft's bore (0 for a solid shaft), and outer radius of the
        collar.
    collar_length, shaft_length
        Lengths of collar and shaft along the axis. The shaft must be longer.
    elements
        Number of elements along the contact, even (N = elements + 1 node pairs).
    grading, growth
        Size of the middle element of the contact divided by the size of its end element, >= 1;
        ratio of neighbouring sizes away from the contact, > 1.
    shaft_material, collar_material
        The two materials.

    Raises
    ------
    ModelError
        Sizes that are not positive or do not fit, odd numbers of elements, a mesh of more than a
        million nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.PressFit(elements=4, growth=2.0).condense()
    >>> system.nodes
    5
    >>> round(float(system.bonded["push"][0].sum()), 9)  # along -y: the shaft holds the collar
    1.0
    """

    shaft_radius: float = 1.0
    bore_radius: float = 0.0
    collar_radius: float = 2.0
    collar_length: float = 2.0
    shaft_length: float = 8.0
    elements: int = 80
    grading: float = 20.0
    growth: float = 1.15
    shaft_material: Material = Material()
    collar_material: Material = Material()

    _within = (
        ("bore_radius", "shaft_radius"),
        ("shaft_radius", "collar_radius"),
        ("collar_length", "shaft_length"),
    )

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        a = self.shaft_radius
        half = self.collar_length / 2
        end = self.shaft_length / 2
        past_collar = half + away(end - half, self.corner_size, self.growth)[1:]
        inward = a - away(a - self.bore_radius, self.corner_size, self.growth)[::-1]
        outward = a + away(self.collar_radius - a, self.corner_size, self.growth)
        # Sums may be off by rounding.
        past_collar[-1] = end
        inward[[0, -1]] = self.bore_radius, a
        along_shaft = np.r_[-past_collar[::-1], self.contact_nodes, past_collar]
        return (outward, self.contact_nodes), (inward, along_shaft)

    @property
    def contact_nodes(self) -> Array:
        """(N,) distances along the contact from its middle, upwards."""
        return along(self.collar_length / 2, self.elements, self.grading)

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        collar_face = np.pi * (self.collar_radius**2 - self.shaft_radius**2)
        shaft_section = np.pi * (self.shaft_radius**2 - self.bore_radius**2)
        return ContactModel(
            bodies={"collar": self._collar(), "shaft": self._shaft()},
            contacts=[Contact("collar", "shaft")],
            supports=[Support("shaft", (self.bore_radius, 0.0), "y")],
            loads={
                "fit": [Interference("contact")],
                "tension": [Traction("shaft", "upper", y=1.0), Traction("shaft", "lower", y=-1.0)],
                "push": [
                    Traction("collar", "lower", y=1 / collar_face),
                    Traction("shaft", "upper", y=-1 / shaft_section),
                ],
            },
            kinematics="axisymmetric",
        )

    def _collar(self) -> Body:
        """Body 1, with the boundaries "contact" and "lower"."""
        mesh = MeshQuad.init_tensor(*self._grids[0]).with_boundaries(
            {
                "contact": lambda x: x[0] == self.shaft_radius,
                "lower": lambda x: x[1] == -self.collar_length / 2,
            }
        )
        return Body(mesh, self.collar_material)

    def _shaft(self) -> Body:
        """Body 2, with the boundaries "contact", "lower" and "upper"."""
        half = self.collar_length / 2
        end = self.shaft_length / 2
        mesh = MeshQuad.init_tensor(*self._grids[1]).with_boundaries(
            {
                "contact": lambda x: (x[0] == self.shaft_radius) & (np.abs(x[1]) < half),
                "lower": lambda x: x[1] == -end,
                "upper": lambda x: x[1] == end,
            }
        )
        return Body(mesh, self.shaft_material)


# Half the side of the square in the middle of the pin, divided by the radius of the pin.
_CORE = 0.5


@dataclass(frozen=True)
class PinInPlate(Scene):
    """A solid pin in the hole of a square plate, meshed in quadrilaterals.

    Body 1 is the pin, body 2 the plate, held at its two lower corners against rigid motions. The
    contact is the whole ring; its first node is at the angle 0, the others follow
    counter-clockwise. Load cases: "fit", an overlap of one unit of length between the radii of pin
    and hole; "Fx" and "Fy", a unit force per depth on the pin along +x and +y, as a uniform body
    force, balanced by a uniform traction on all sides of the plate; "sigma", unit tension on the
    right and left sides of the plate. No load case needs a reaction of the supports. With equal
    materials and a large plate, an overlap d causes the pressure `E / (1 - nu^2) d / (2 radius)`.

    Parameters
    ----------
    elements
        Number of elements around the ring, a multiple of 8 (N = elements node pairs).
    radius, plate_half_width
        Radius of the pin, and half of the side of the plate, more than 1.5 radii, length.
    growth, pin_material, plate_material
        Ratio of neighbouring element sizes away from the ring, > 1; the two materials.

    Raises
    ------
    ModelError
        Sizes that are not positive, a plate that is too small, a number of elements that is no
        multiple of 8, a mesh of more than a million nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.PinInPlate(elements=16, growth=1.5).condense()
    >>> system.nodes, sorted(system.bonded)
    (16, ['Fx', 'Fy', 'fit', 'sigma'])
    """

    elements: int = 80
    radius: float = 1.0
    plate_half_width: float = 10.0
    growth: float = 1.15
    pin_material: Material = Material()
    plate_material: Material = Material()

    _multiple = 8

    def _check_sizes(self) -> None:
        if not 1.5 * self.radius < self.plate_half_width:
            raise ModelError(
                f"plate_half_width: {self.plate_half_width:g}; "
                f"it must be more than 1.5 radius = {1.5 * self.radius:g}"
            )

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        """Grids of the square in the pin, of the pin around it and of the plate.

        The coordinates of the first grid are x and y. The coordinates of the other grids are shares
        of the way along a ray, and positions on the ring. The rays lead from the square to the
        ring, and from the ring to the edge of the plate.
        """
        angles = np.linspace(-np.pi / 4, np.pi / 4, self.elements // 4 + 1)
        line = _CORE * self.radius * np.tan(angles)
        pin_size = self.corner_size / ((1 - _CORE) * self.radius)
        plate_size = self.corner_size / (self.plate_half_width - self.radius)
        in_pin = 1 - away(1.0, pin_size, self.growth)[-2::-1]
        in_plate = away(1.0, plate_size, self.growth)
        return (line, line), (in_pin, self._rays[0]), (in_plate, self._rays[0])

    @property
    def contact_nodes(self) -> Array:
        """(elements + 1,) distances along the chords of the ring, once around from angle 0."""
        chord = 2 * self.radius * np.sin(np.pi / self.elements)
        return np.asarray(chord * np.arange(self.elements + 1))

    @property
    def _rays(self) -> Array:
        """(2, N) directions of the nodes on the ring."""
        angle = 2 * np.pi * np.arange(self.elements) / self.elements
        return np.array([np.cos(angle), np.sin(angle)])

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        half = self.plate_half_width
        # The meshed pin is a polygon.
        area = self.elements / 2 * self.radius**2 * np.sin(2 * np.pi / self.elements)
        density = 1 / area
        taken_up = -1 / (8 * half)
        return ContactModel(
            bodies={"pin": self._pin(), "plate": self._plate()},
            contacts=[Contact("pin", "plate", "ring", "ring")],
            supports=[Support("plate", (-half, -half)), Support("plate", (half, -half), "y")],
            loads={
                "fit": [Interference("ring", 1.0)],
                "Fx": [BodyForce("pin", x=density), Traction("plate", "outside", x=taken_up)],
                "Fy": [BodyForce("pin", y=density), Traction("plate", "outside", y=taken_up)],
                "sigma": [Traction("plate", "right", x=1.0), Traction("plate", "left", x=-1.0)],
            },
        )

    def _pin(self) -> Body:
        """Body 1, with the boundary "ring"."""
        (square, _), (share, _), _ = self._grids
        core = MeshQuad.init_tensor(square, square)
        on_square = self._on_square(_CORE * self.radius)
        rings = self._rings(on_square, self.radius * self._rays, share)
        # (core nodes, N) distance of each node of the core from each ray's end on the square
        distance = np.hypot(core.p[0][:, None] - on_square[0], core.p[1][:, None] - on_square[1])
        on_core = distance.argmin(axis=0)
        on_rings = core.p.shape[1] + np.arange(share.size * self.elements)
        numbers = np.concatenate([on_core[None], on_rings.reshape(share.size, -1)])
        points = np.concatenate([core.p, rings], axis=1)
        mesh = MeshQuad(points, np.concatenate([core.t, _between(numbers)], axis=1))
        return Body(mesh.with_boundaries({"ring": mesh.boundary_facets()}), self.pin_material)

    def _plate(self) -> Body:
        """Body 2, with the boundaries "ring", "right", "left" and "outside"."""
        half = self.plate_half_width
        share = self._grids[2][0]
        rings = self._rings(self.radius * self._rays, self._on_square(half), share)
        numbers = np.arange(share.size * self.elements).reshape(share.size, -1)
        mesh = MeshQuad(rings, _between(numbers))
        near = SAME_POINT * half
        sides = {
            "right": lambda x: np.abs(x[0] - half) < near,
            "left": lambda x: np.abs(x[0] + half) < near,
            "outside": lambda x: half - np.abs(x).max(axis=0) < near,
            # The plate begins at 1 radius, and its sides are more than 1.5 radii away.
            "ring": lambda x: np.hypot(*x) < 1.25 * self.radius,
        }
        return Body(mesh.with_boundaries(sides), self.plate_material)

    def _on_square(self, half: float) -> Array:
        """(2, N) points at which the rays meet a square."""
        return np.asarray(half * self._rays / np.abs(self._rays).max(axis=0))

    def _rings(self, inner: Array, outer: Array, share: Array) -> Array:
        """(2, rings N) nodes of rings, at shares of the way from inner to outer points (2, N)."""
        rings = inner[:, None, :] + share[:, None] * (outer - inner)[:, None, :]
        return rings.reshape(2, -1)


def _between(numbers: Integers) -> Integers:
    """(4, m) elements between successive rings of nodes, (rings, N)."""
    following = np.roll(numbers, -1, axis=1)
    corners = [numbers[:-1], numbers[1:], following[1:], following[:-1]]
    return np.array([nodes.ravel() for nodes in corners])
