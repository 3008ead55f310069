"""Parameters of the study of error against run time, and its scenes."""

from dataclasses import dataclass
from math import pi

import frictopt as fo
from frictopt.reference import LineContact, half_plane_contact
from studies.paper import LOADS


@dataclass(frozen=True)
class Parameters:
    """Sizes, settings and repetitions."""

    # Numbers of elements of the paper's scene with the default grading.
    elements: tuple[int, ...] = (16, 40, 124)
    friction: float = 0.7
    # Friction of lambda_1. On fine meshes lambda_1 falls to 0 near a friction of 0.7.
    guaranteed_friction: float = 0.5
    # Largest number of repetitions of a timing. All repetitions of a method take at most 2 s.
    # With 0 the first run is timed.
    repetitions: int = 7
    # Meshes of the questions about the accuracy of the mesh.
    mesh_elements: tuple[int, ...] = (16, 40, 124, 252)
    mesh_gradings: tuple[float, ...] = (1.0, 20.0, 1000.0)
    # Numbers of cells of the cylinder on a half-plane.
    cells: tuple[int, ...] = (20, 40, 80, 160, 320)
    # Tolerances of the solvers of linear and quadratic programs that are called directly.
    tolerances: tuple[float, ...] = (1e-4, 1e-6, 1e-8, 1e-10)
    # Load factor of the margin of a safe slip, relative to the shakedown limit.
    margin_share: float = 0.9
    # Load factor of increments and transients, relative to the shakedown limit.
    overload: float = 1.4
    # Numbers of increments per segment.
    steps: tuple[int, ...] = (5, 10, 20, 40, 80)
    # Numbers of elements of the paper's scene for one increment.
    increment_elements: tuple[int, ...] = (24, 124, 500)
    # Tolerances of the solvers that iterate over frozen bounds.
    increment_tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
    # Load factor of steady states, relative to the shakedown limit.
    steady_overload: float = 1.05
    # Numbers of cycles for a steady state without proof.
    steady_cycles: tuple[int, ...] = (1, 2, 3, 4, 6, 10)
    # Number of cycles of the reference of a steady state.
    reference_cycles: int = 100
    # Amplitude of the initial slip of steady states, in coefficients of the six lowest
    # Chebyshev polynomials.
    start: float = 0.3
    seed: int = 0
    # Numbers of elements of the paper's scene in space, for transients. With 125 nodes they
    # take minutes.
    space_elements: tuple[int, ...] = (16, 40)
    # Numbers of increments per segment in space.
    space_steps: tuple[int, ...] = (4, 8, 16, 32, 64)
    space_friction: float = 0.5
    # Numbers of cells across the contact of a sphere.
    sphere_cells: tuple[int, ...] = (8, 12, 16, 20)
    region_tolerances: tuple[float, ...] = (1e-1, 1e-2, 1e-3)
    # Numbers of increments per segment, for limits after a protocol and for ranges.
    search_steps: tuple[int, ...] = (4, 8, 16)


FULL = Parameters()
QUICK = Parameters(
    elements=(4,),
    repetitions=0,
    mesh_elements=(16, 40),
    mesh_gradings=(20.0,),
    cells=(20, 40),
    tolerances=(1e-4, 1e-8),
    steps=(4, 8, 16, 32),
    increment_elements=(4,),
    increment_tolerances=(1e-3, 1e-6),
    steady_cycles=(1, 2, 4),
    reference_cycles=40,
    space_elements=(4,),
    space_steps=(4, 16),
    sphere_cells=(6, 12),
    region_tolerances=(1e-1, 1e-2),
    search_steps=(4, 12),
)


CYLINDER = LineContact(P=1.0, R=1.0, E_star=4 / pi, f=0.3)
"""Cylinder on a half-plane, contact of half-width 1."""

SHEAR = 0.75 * CYLINDER.f * CYLINDER.P
"""Amplitude of the shear force on the cylinder. It slips from the edges to half the half-width."""

CYLINDER_LOADS = fo.LoadCycle({"P": CYLINDER.P}, [{"Q": 1.0}, {"Q": -1.0}])
"""Load cycle of the cylinder; the load factor is the amplitude of the shear force."""


@dataclass(frozen=True)
class Scene:
    """The paper's scene on one mesh, and its shakedown limit."""

    name: str
    system: fo.ContactSystem
    limit: float


def punch(parameters: Parameters, elements: int) -> Scene:
    """The paper's scene with a number of elements on the contact and the default grading."""
    system = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    return Scene(
        f"paper's scene, {elements} elements",
        system,
        fo.shakedown_limit(system, LOADS, parameters.friction).load_factor,
    )


def cylinder(cells: int) -> fo.ContactSystem:
    """The cylinder with a number of cells; the interface is a quarter longer than the contact."""
    return fo.ContactSystem.from_blocks(
        **half_plane_contact(cells, 1.25 * CYLINDER.half_width, CYLINDER.E_star, R=CYLINDER.R)
    )
