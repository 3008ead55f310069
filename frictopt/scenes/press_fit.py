"""A collar shrunk onto a shaft, axisymmetric."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from skfem import MeshQuad

from ..contact import Array
from ..fem.bodies import Body, Support
from ..fem.contacts import Contact, Interference
from ..fem.elasticity import Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from .scene import Scene, along, away


@dataclass(frozen=True)
class PressFit(Scene):
    """A collar on a shaft, in axisymmetry: shrunk on by an interference, and under axial loads; meshed in quadrilaterals.

    x is the radius, y runs along the shaft, from the middle of the collar. Body 1 is the collar, body 2 the shaft; the nodes of the contact go from
    its upper to its lower end, against y, and so do positive slips. Forces are those of the whole circumference. Load cases:

    - "fit", a radial interference of 1, half the diametral one;
    - "tension", a tension of 1 on both ends of the shaft;
    - "push", an axial force of 1 along +y on the lower face of the collar, taken up at the upper end of the shaft.

    Torsion makes slips around the axis and bending stresses that change around it: take a model in space for them.

    Parameters
    ----------
    shaft_radius, bore_radius
        Radius of the contact, and of the shaft's bore; 0 for a solid shaft.
    collar_radius
        Outer radius of the collar.
    collar_length, shaft_length
        Lengths along the axis; the shaft is the longer one.
    elements
        Number of elements along the contact, even (N = elements + 1 node pairs).
    grading
        Size of the middle element of the contact over that of its end element, >= 1.
    growth
        Ratio of neighbouring element sizes away from the contact, > 1.
    shaft_material, collar_material
        The two materials.

    Raises
    ------
    ModelError
        Sizes that are not positive or do not fit, odd numbers of elements, a mesh of more than a million nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.PressFit(elements=4, growth=2.0).condense()
    >>> system
    ContactSystem(nodes=5, x=-1 .. 1, loads=['fit', 'push', 'tension'], gap=False)
    >>> round(float(system.bonded["push"][0].sum()), 9)  # along the tangent, -y: the shaft holds the collar back
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

    _within = (("bore_radius", "shaft_radius"), ("shaft_radius", "collar_radius"), ("collar_length", "shaft_length"))

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        a, half, end = self.shaft_radius, self.collar_length / 2, self.shaft_length / 2
        lengths = end - half, a - self.bore_radius, self.collar_radius - a
        beyond, inside, outside = (away(length, self.corner_size, self.growth) for length in lengths)
        beyond, inward = half + beyond[1:], a - inside[::-1]
        beyond[-1], inward[[0, -1]] = end, (self.bore_radius, a)
        return (a + outside, self.contact_nodes), (inward, np.r_[-beyond[::-1], self.contact_nodes, beyond])

    @property
    def contact_nodes(self) -> Array:
        """(N,) distances along the contact from its middle, upwards."""
        return along(self.collar_length / 2, self.elements, self.grading)

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        a, half, end = self.shaft_radius, self.collar_length / 2, self.shaft_length / 2
        collar, shaft = (MeshQuad.init_tensor(*lines) for lines in self._grids)
        collar = collar.with_boundaries({"contact": lambda x: x[0] == a, "lower": lambda x: x[1] == -half})
        shaft = shaft.with_boundaries(
            {"contact": lambda x: (x[0] == a) & (np.abs(x[1]) < half), "lower": lambda x: x[1] == -end, "upper": lambda x: x[1] == end}
        )
        face, section = np.pi * (self.collar_radius**2 - a**2), np.pi * (a**2 - self.bore_radius**2)
        return ContactModel(
            bodies={"collar": Body(collar, self.collar_material), "shaft": Body(shaft, self.shaft_material)},
            contacts=[Contact("collar", "shaft")],
            supports=[Support("shaft", (self.bore_radius, 0.0), "y")],
            loads={
                "fit": [Interference("contact")],
                "tension": [Traction("shaft", "upper", y=1.0), Traction("shaft", "lower", y=-1.0)],
                "push": [Traction("collar", "lower", y=1 / face), Traction("shaft", "upper", y=-1 / section)],
            },
            kinematics="axisymmetric",
        )
