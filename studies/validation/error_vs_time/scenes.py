"""The scenes on which the computations are compared."""

from dataclasses import dataclass
from math import pi

import frictopt as fo
from frictopt.reference import LineContact, half_plane_contact

from ...paper import LOADS
from .parameters import Parameters

CYLINDER = LineContact(P=1.0, R=1.0, E_star=4 / pi, f=0.3)
"""Cylinder on a half-plane, contact of half-width 1."""

SHEAR = 0.75 * CYLINDER.f * CYLINDER.P
"""Amplitude of its shear force: slip from the edges to half the half-width."""

CYLINDER_LOADS = fo.LoadCycle({"P": CYLINDER.P}, [{"Q": 1.0}, {"Q": -1.0}])
"""Its load cycle; the load factor is the amplitude of the shear force."""


@dataclass(frozen=True)
class Scene:
    """The paper's scene on one mesh, and its shakedown limit."""

    name: str
    system: fo.ContactSystem
    limit: float


def punch(parameters: Parameters, elements: int) -> Scene:
    """The paper's scene with so many elements on the contact, default grading."""
    system = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    return Scene(f"paper's scene, {elements} elements", system, fo.shakedown_limit(system, LOADS, parameters.friction).load_factor)


def cylinder(cells: int) -> fo.ContactSystem:
    """The cylinder on so many cells, the interface a quarter longer than the contact."""
    return fo.ContactSystem.from_blocks(**half_plane_contact(cells, 1.25 * CYLINDER.half_width, CYLINDER.E_star, R=CYLINDER.R))
