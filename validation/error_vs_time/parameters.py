"""What the study of error against run time varies, and the scenes on which the computations are compared."""

from dataclasses import dataclass
from math import pi

import frictopt as fo
from frictopt.reference import LineContact, half_plane_contact
from studies.paper import LOADS


@dataclass(frozen=True)
class Parameters:
    """Sizes, settings and repetitions."""

    # of the paper's scene, default grading: one question each
    elements: tuple[int, ...] = (16, 40, 124)
    friction: float = 0.7
    guaranteed_friction: float = 0.5  # of lambda_1, which falls to 0 near 0.7 on fine meshes
    # of a timing at most; all repetitions of one method take 2 s together; 0: its first run is
    # timed
    repetitions: int = 7
    # Accuracy of the mesh
    mesh_elements: tuple[int, ...] = (16, 40, 124, 252)
    mesh_gradings: tuple[float, ...] = (1.0, 20.0, 1000.0)
    cells: tuple[int, ...] = (20, 40, 80, 160, 320)  # of the cylinder on a half-plane
    # Settings of solvers and steps
    # of the solvers of linear and quadratic programs that are called directly
    tolerances: tuple[float, ...] = (1e-4, 1e-6, 1e-8, 1e-10)
    # the margin of a safe slip is that at this share of the shakedown limit
    margin_share: float = 0.9
    overload: float = 1.4  # load factor of increments and transients over the shakedown limit
    steps: tuple[int, ...] = (5, 10, 20, 40, 80)  # increments from corner to corner
    milp_steps: tuple[int, ...] = (2, 5, 10)
    increment_elements: tuple[int, ...] = (24, 124, 500)  # of the paper's scene, for one increment
    # of the solvers that sweep over frozen bounds
    increment_tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
    # complementarity with booleans takes over 10 s for 10 steps on 124 elements
    milp_elements: tuple[int, ...] = (16, 40)
    steady_overload: float = 1.05  # load factor of steady states over the shakedown limit
    # cycles followed where the steady state is not proven
    steady_cycles: tuple[int, ...] = (1, 2, 3, 4, 6, 10)
    reference_cycles: int = 100  # cycles that stand for infinitely many
    # amplitude of the initial slip of steady states, in coefficients of the six lowest Chebyshev
    # polynomials
    start: float = 0.3
    seed: int = 0
    # Three dimensions
    # of the paper's scene in space, for transients: with 125 nodes they take minutes
    space_elements: tuple[int, ...] = (16, 40)
    space_steps: tuple[int, ...] = (4, 8, 16, 32, 64)  # increments from corner to corner
    space_friction: float = 0.5
    sphere_cells: tuple[int, ...] = (8, 12, 16, 20)  # across a sphere's contact
    region_tolerances: tuple[float, ...] = (1e-1, 1e-2, 1e-3)
    # increments from corner to corner of limits after a protocol and of ranges
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
    milp_steps=(2,),
    milp_elements=(4,),
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
    return Scene(
        f"paper's scene, {elements} elements",
        system,
        fo.shakedown_limit(system, LOADS, parameters.friction).load_factor,
    )


def cylinder(cells: int) -> fo.ContactSystem:
    """The cylinder on so many cells, the interface a quarter longer than the contact."""
    return fo.ContactSystem.from_blocks(
        **half_plane_contact(cells, 1.25 * CYLINDER.half_width, CYLINDER.E_star, R=CYLINDER.R)
    )
