"""A collar shrunk onto a shaft, axisymmetric."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from skfem import MeshQuad

from ..contact import ContactSystem
from ..contact.checks import Array, finite_number, listed, shown, whole_number
from ..errors import ModelError
from ..fem.assembly import Load
from ..fem.bodies import Body, Support
from ..fem.contacts import Contact, Interference
from ..fem.elasticity import Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from .grading import along, away, steps
from .scene import Scene

_MOST_ELEMENTS = 10_000  # along the contact: S is dense and takes 3 GB then
_MOST_NODES = 1_000_000
_LONGEST = 1e6  # length over the radius of the shaft
_CASES = ("fit", "tension", "push")
_REFUSED = {
    "torsion": "it makes slips around the axis, across the meridian in which this model has its slips",
    "bending": "it makes stresses that change around the axis, of which an axisymmetric model has none",
}


@dataclass(frozen=True)
class PressFit(Scene):
    """A collar on a shaft, in axisymmetry: shrunk on by an interference, and under axial loads; meshed in quadrilaterals.

    x is the radius, y runs along the shaft, from the middle of the collar. Body 1 is the collar, body 2 the shaft; the nodes of the contact go from
    its upper to its lower end, against y, and so do positive slips. Forces are those of the whole circumference. Load cases:

    - "fit", a radial interference of 1, half the diametral one;
    - "tension", a tension of 1 on both ends of the shaft;
    - "push", an axial force of 1 along +y on the lower face of the collar, taken up at the upper end of the shaft.

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
    loads
        Load cases to make, of those above. "torsion" and "bending" are no axisymmetric friction problems of this kind and are refused.

    Raises
    ------
    ModelError
        Sizes that are not positive or do not fit, odd numbers of elements, other loads, a mesh of more than a million nodes.

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
    loads: Sequence[str] = _CASES

    def __post_init__(self) -> None:
        values: dict[str, float] = {"elements": whole_number("elements", self.elements, least=2, most=_MOST_ELEMENTS)}
        if values["elements"] % 2:
            raise ModelError(f"elements: {self.elements}; give an even number, so that a node lies in the middle")
        values["shaft_radius"] = finite_number("shaft_radius", self.shaft_radius, above=0.0)
        values["bore_radius"] = finite_number("bore_radius", self.bore_radius, least=0.0, below=values["shaft_radius"])
        values["collar_radius"] = finite_number("collar_radius", self.collar_radius, above=values["shaft_radius"])
        values["collar_length"] = finite_number("collar_length", self.collar_length, above=0.0)
        values["shaft_length"] = finite_number("shaft_length", self.shaft_length, above=values["collar_length"])
        values["grading"] = finite_number("grading", self.grading, least=1.0, below=1e15)
        values["growth"] = finite_number("growth", self.growth, above=1.0, below=100.0)
        for name in ("shaft_material", "collar_material"):
            if not isinstance(getattr(self, name), Material):
                raise ModelError(f"{name}: {shown(getattr(self, name))}; give a Material")
        loads = tuple(_checked_case(case) for case in listed("loads", self.loads))
        if not loads:
            raise ModelError(f"loads: none; give some of {', '.join(map(repr, _CASES))}")
        for name, value in {**values, "loads": loads}.items():
            object.__setattr__(self, name, value)
        self._check_sizes()

    def _check_sizes(self) -> None:
        radius = self.shaft_radius
        walls = {"bore_radius": radius - self.bore_radius, "collar_radius": self.collar_radius - radius}
        for name, size in {**walls, "collar_length": self.collar_length, "shaft_length": self.shaft_length - self.collar_length}.items():
            if not 1 / _LONGEST <= size / radius <= _LONGEST:
                raise ModelError(f"{name}: it leaves {size:g} beside shaft_radius = {radius:g}; give at most {_LONGEST:g} times more or less")
        if not (np.diff(self._contact) > 0).all():
            raise ModelError(f"grading: {self.grading:g}; elements at the ends are smaller than rounding, give a lower grading or fewer elements")
        first = self.corner_size
        up = self.elements + 2 * steps((self.shaft_length - self.collar_length) / 2, first, self.growth)
        across = steps(radius - self.bore_radius, first, self.growth) + steps(self.collar_radius - radius, first, self.growth)
        if not up * across <= _MOST_NODES:
            raise ModelError(f"elements, grading, growth: they make a mesh of {up * across:.0e} nodes, the most are {_MOST_NODES:.0e}; give less")

    @property
    def _contact(self) -> Array:
        return along(self.collar_length / 2, self.elements, self.grading)

    @property
    def corner_size(self) -> float:
        """Size of the contact element at the end of the collar, length."""
        return float(self._contact[-1] - self._contact[-2])

    def model(self) -> ContactModel:
        """The two meshes with contact, supports and load cases."""
        a, first, z = self.shaft_radius, self.corner_size, self._contact
        half, end = self.collar_length / 2, self.shaft_length / 2
        beyond = half + away(end - half, first, self.growth)[1:]
        beyond[-1] = end
        inward = a - away(a - self.bore_radius, first, self.growth)[::-1]
        inward[[0, -1]] = self.bore_radius, a
        outward = a + away(self.collar_radius - a, first, self.growth)
        collar = MeshQuad.init_tensor(outward, z).with_boundaries({"contact": lambda x: x[0] == a, "lower": lambda x: x[1] == -half})
        shaft = MeshQuad.init_tensor(inward, np.r_[-beyond[::-1], z, beyond]).with_boundaries(
            {"contact": lambda x: (x[0] == a) & (np.abs(x[1]) < half), "lower": lambda x: x[1] == -end, "upper": lambda x: x[1] == end}
        )
        face, section = np.pi * (self.collar_radius**2 - a**2), np.pi * (a**2 - self.bore_radius**2)
        cases: dict[str, list[Load]] = {
            "fit": [Interference("contact")],
            "tension": [Traction("shaft", "upper", y=1.0), Traction("shaft", "lower", y=-1.0)],
            "push": [Traction("collar", "lower", y=1 / face), Traction("shaft", "upper", y=-1 / section)],
        }
        return ContactModel(
            bodies={"collar": Body(collar, self.collar_material), "shaft": Body(shaft, self.shaft_material)},
            contacts=[Contact("collar", "shaft")],
            supports=[Support("shaft", (self.bore_radius, 0.0), "y")],
            loads={case: cases[case] for case in self.loads},
            kinematics="axisymmetric",
        )

    def condense(self) -> ContactSystem:
        """Mesh, assemble and condense to the contact."""
        return self.model().condense()


def _checked_case(case: object) -> str:
    if isinstance(case, str) and case in _REFUSED:
        raise ModelError(f"loads: {case!r}: {_REFUSED[case]}; take a model in three dimensions")
    if not isinstance(case, str) or case not in _CASES:
        raise ModelError(f"loads: {shown(case)}; give some of {', '.join(map(repr, _CASES))}")
    return case
