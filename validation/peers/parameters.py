"""What the study of peers varies."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameters:
    """Sizes and repetitions."""

    sphere_cells: tuple[int, ...] = (10, 16, 24, 32)  # across the grid of the sphere
    tamaas_cells: tuple[int, ...] = (32, 64, 128)  # along the periodic box
    tamaas_radii: tuple[float, ...] = (0.15, 0.3)  # of the contact over the side of the box
    tamaas_iterations: int = 3000
    siconos_cells: tuple[int, ...] = (10, 15)  # across the grid of the sphere
    siconos_iterations: int = 500  # of one increment
    cylinder_cells: tuple[int, ...] = (40, 80)
    cylinder_steps: tuple[int, ...] = (5, 20)  # increments from corner to corner
    block_elements: tuple[int, ...] = (4, 16)  # along each side of the block
    kratos_increments: tuple[int, ...] = (1, 8)  # from corner to corner
    elements: tuple[int, ...] = (16, 40)  # of the punch, for the printed problems
    tolerances: tuple[float, ...] = (1e-6, 1e-9)  # of solvers that are called directly
    repetitions: int = 5  # of a timing at most
    seconds: float = 300.0  # after which a peer is stopped


FULL = Parameters()
QUICK = Parameters(
    sphere_cells=(8,),
    tamaas_cells=(16, 32),
    tamaas_radii=(0.15, 0.3),
    tamaas_iterations=50,
    siconos_cells=(6,),
    siconos_iterations=500,
    cylinder_cells=(20,),
    cylinder_steps=(4,),
    block_elements=(2,),
    kratos_increments=(1,),
    elements=(4,),
    tolerances=(1e-8,),
    repetitions=0,
)
