"""Parameters of the study of peers."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameters:
    """Sizes and repetitions.

    Attributes
    ----------
    sphere_cells, siconos_cells
        Cells across the grid of the sphere, for frictopt and for Siconos.
    tamaas_cells, tamaas_radii
        Cells along the periodic box, and radii of the contact over the side of the box.
    tamaas_iterations, siconos_iterations
        Largest numbers of iterations of tamaas, and of Siconos in one increment.
    cylinder_cells, cylinder_steps
        Cells of the cylinder, and its increments per segment.
    block_elements, kratos_increments
        Elements along each side of the block, and the increments of Kratos per segment.
    elements, tolerances
        Elements of the punch of the printed problems, and tolerances of solvers called directly.
    repetitions
        Largest number of repetitions of a timing.
    seconds
        Seconds after which a peer is stopped.
    """

    sphere_cells: tuple[int, ...] = (10, 16, 24, 32)
    tamaas_cells: tuple[int, ...] = (32, 64, 128)
    tamaas_radii: tuple[float, ...] = (0.15, 0.3)
    tamaas_iterations: int = 3000
    siconos_cells: tuple[int, ...] = (10, 15)
    siconos_iterations: int = 500
    cylinder_cells: tuple[int, ...] = (40, 80)
    cylinder_steps: tuple[int, ...] = (5, 20)
    block_elements: tuple[int, ...] = (4, 16)
    kratos_increments: tuple[int, ...] = (1, 8)
    elements: tuple[int, ...] = (16, 40)
    tolerances: tuple[float, ...] = (1e-6, 1e-9)
    repetitions: int = 5
    seconds: float = 300.0


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
