"""Contacts of round bodies, one shrunk onto or into the other: a collar on a shaft, axisymmetric, and a pin in a plate, a closed ring."""

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
    """A collar on a shaft, in axisymmetry: shrunk on by an interference, and under axial loads; meshed in quadrilaterals.

    x is the radius, y runs along the shaft, from the middle of the collar. Body 1 is the collar,
    body 2 the shaft; the nodes of the contact go from its upper to its lower end, against y, and so
    do positive slips. Forces are those of the whole circumference. Load cases: "fit", a radial
    interference of 1, half the diametral one; "tension", a tension of 1 on both ends of the shaft;
    "push", an axial force of 1 along +y on the lower face of the collar, taken up at the upper end
    of the shaft. Torsion and bending need a model in space: slips or stresses change around the
    axis.

    Parameters
    ----------
    shaft_radius, bore_radius, collar_radius
        Radius of the contact, of the shaft's bore (0 for a solid shaft), and outer radius of the
        collar.
    collar_length, shaft_length
        Lengths along the axis; the shaft is the longer one.
    elements
        Number of elements along the contact, even (N = elements + 1 node pairs).
    grading, growth
        Size of the middle element of the contact over that of its end element, >= 1; ratio of
        neighbouring sizes away from it, > 1.
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
    >>> system.nodes, round(float(system.bonded["push"][0].sum()), 9)  # along the tangent, -y: the shaft holds the collar back
    (5, 1.0)
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
        a, half, end = self.shaft_radius, self.collar_length / 2, self.shaft_length / 2
        lengths = end - half, a - self.bore_radius, self.collar_radius - a
        beyond, inside, outside = (
            away(length, self.corner_size, self.growth) for length in lengths
        )
        beyond, inward = half + beyond[1:], a - inside[::-1]
        beyond[-1], inward[[0, -1]] = end, (self.bore_radius, a)
        return (a + outside, self.contact_nodes), (
            inward,
            np.r_[-beyond[::-1], self.contact_nodes, beyond],
        )

    @property
    def contact_nodes(self) -> Array:
        """(N,) distances along the contact from its middle, upwards."""
        return along(self.collar_length / 2, self.elements, self.grading)

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        a, half, end = self.shaft_radius, self.collar_length / 2, self.shaft_length / 2
        collar, shaft = (MeshQuad.init_tensor(*lines) for lines in self._grids)
        collar = collar.with_boundaries(
            {"contact": lambda x: x[0] == a, "lower": lambda x: x[1] == -half}
        )
        shaft = shaft.with_boundaries(
            {"lower": lambda x: x[1] == -end, "upper": lambda x: x[1] == end}
        )
        shaft = shaft.with_boundaries({"contact": lambda x: (x[0] == a) & (np.abs(x[1]) < half)})
        face, section = np.pi * (self.collar_radius**2 - a**2), np.pi * (a**2 - self.bore_radius**2)
        return ContactModel(
            bodies={
                "collar": Body(collar, self.collar_material),
                "shaft": Body(shaft, self.shaft_material),
            },
            contacts=[Contact("collar", "shaft")],
            supports=[Support("shaft", (self.bore_radius, 0.0), "y")],
            loads={
                "fit": [Interference("contact")],
                "tension": [Traction("shaft", "upper", y=1.0), Traction("shaft", "lower", y=-1.0)],
                "push": [
                    Traction("collar", "lower", y=1 / face),
                    Traction("shaft", "upper", y=-1 / section),
                ],
            },
            kinematics="axisymmetric",
        )


_CORE = 0.5  # half-side of the square in the middle of the pin, over its radius


@dataclass(frozen=True)
class PinInPlate(Scene):
    """A solid pin in the hole of a square plate, meshed in quadrilaterals.

    Body 1 is the pin, body 2 the plate, held at its two lower corners against rigid motions. The
    contact is the whole ring; its first node is at the angle 0, the others follow
    counter-clockwise. Load cases: "fit", an overlap of one unit of length between the radii of pin
    and hole; "Fx" and "Fy", a unit force per depth on the pin along +x and +y, as a uniform body
    force, which a uniform traction on all sides of the plate takes up; "sigma", unit tension on the
    right and left sides of the plate. None needs a reaction of the supports. With equal materials
    and a large plate, the fit of overlap d makes the pressure `E / (1 - nu^2) d / (2 radius)`.

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
                f"plate_half_width: {self.plate_half_width:g}; it must be more than 1.5 radius = {1.5 * self.radius:g}"
            )

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        """Coordinates of the square in the middle; shares of the way to it from the ring, and from the ring to the edge, beside the rays."""
        line = (
            _CORE * self.radius * np.tan(np.linspace(-np.pi / 4, np.pi / 4, self.elements // 4 + 1))
        )
        ways = (1 - _CORE) * self.radius, self.plate_half_width - self.radius
        inner, outer = (away(1.0, self.corner_size / way, self.growth) for way in ways)
        return (line, line), (1 - inner[-2::-1], self._rays[0]), (outer, self._rays[0])

    @property
    def contact_nodes(self) -> Array:
        """(elements + 1,) distances along the ring from the angle 0 and back to it, by its chords."""
        return np.asarray(
            2 * self.radius * np.sin(np.pi / self.elements) * np.arange(self.elements + 1)
        )

    @property
    def _rays(self) -> Array:
        """(2, N) directions of the nodes on the ring."""
        angle = 2 * np.pi * np.arange(self.elements) / self.elements
        return np.array([np.cos(angle), np.sin(angle)])

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        half, area = (
            self.plate_half_width,
            self.elements / 2 * self.radius**2 * np.sin(2 * np.pi / self.elements),
        )
        density, taken_up = 1 / area, -1 / (8 * half)
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
        rays, half = self._rays, _CORE * self.radius
        square, (share, _), _ = self._grids
        core = MeshQuad.init_tensor(*square)
        inner = half * rays / np.abs(rays).max(axis=0)
        rings = inner[:, None, :] + share[:, None] * (self.radius * rays - inner)[:, None, :]
        distance = np.hypot(core.p[0][:, None] - inner[0], core.p[1][:, None] - inner[1])
        first = distance.argmin(axis=0)
        numbers = np.concatenate(
            [
                first[None],
                core.p.shape[1] + np.arange(share.size * self.elements).reshape(share.size, -1),
            ]
        )
        points = np.concatenate([core.p, rings.reshape(2, -1)], axis=1)
        mesh = MeshQuad(points, np.concatenate([core.t, _between(numbers)], axis=1))
        return Body(mesh.with_boundaries({"ring": mesh.boundary_facets()}), self.pin_material)

    def _plate(self) -> Body:
        """Body 2, with the boundaries "ring", "right", "left" and "outside"."""
        rays, half = self._rays, self.plate_half_width
        outer = half * rays / np.abs(rays).max(axis=0)
        share = self._grids[2][0]
        rings = (
            self.radius * rays[:, None, :]
            + share[:, None] * (outer - self.radius * rays)[:, None, :]
        )
        numbers = np.arange(share.size * self.elements).reshape(share.size, -1)
        mesh = MeshQuad(rings.reshape(2, -1), _between(numbers))
        near = SAME_POINT * half
        sides = {
            "right": lambda x: np.abs(x[0] - half) < near,
            "left": lambda x: np.abs(x[0] + half) < near,
        }
        sides |= {
            "outside": lambda x: half - np.abs(x).max(axis=0) < near,
            "ring": lambda x: np.hypot(*x) < 1.25 * self.radius,
        }
        return Body(mesh.with_boundaries(sides), self.plate_material)


def _between(numbers: Integers) -> Integers:
    """(4, m) elements between successive rings of nodes, (rings, N)."""
    after = np.roll(numbers, -1, axis=1)
    return np.array(
        [numbers[:-1].ravel(), numbers[1:].ravel(), after[1:].ravel(), after[:-1].ravel()]
    )
