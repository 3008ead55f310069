"""A sphere on a half-space as a discrete contact: influence of uniform tractions on square cells, integrated exactly."""

import numpy as np

from ..contact.checks import Array, finite_number, whole_number
from ..errors import ModelError
from ._checks import poisson_ratio


def half_space_contact(cells: int, half_length: float, R: float, E: float, nu: float) -> dict[str, object]:
    """Arguments of the `ContactSystem` of a sphere on a half-space of the same material, on the cells of a square grid within a circle.

    Tractions are uniform on each cell and displacements are taken at its middle (Boussinesq, Cerruti; Johnson 1985, sections 3.2 to 3.6). Equal
    materials leave shear and pressure uncoupled. Its load cases move the far end of the sphere by a unit length: "approach" presses, "x" and "y"
    shear towards +x and +y. Forces are sums over cells.

    Parameters
    ----------
    cells
        Number of cells along the diameter of the circle, from 3 to 80.
    half_length
        Radius of the circle, length; it should exceed that of the contact.
    R
        Radius of the sphere, length.
    E, nu
        Young's modulus, force per area, and Poisson's ratio of both bodies.

    Raises
    ------
    ModelError
        Values that are not real and finite, or out of range.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem(**fo.reference.half_space_contact(cells=5, half_length=1.0, R=5.0, E=1.0, nu=0.3))
    >>> system
    ContactSystem(nodes=21, tangents=2, loads=['approach', 'x', 'y'], gap=True)
    """
    whole_number("cells", cells, least=3, most=80)
    half_length, R, E = (finite_number(name, value, above=0.0) for name, value in (("half_length", half_length), ("R", R), ("E", E)))
    nu, size = poisson_ratio("nu", nu), 2 * half_length / cells
    if not 0 < size**2 < np.inf:
        raise ModelError(f"half_length: {half_length:g}; its square is no number, give the length in another unit")
    line = (np.arange(cells) + 0.5) * size - half_length
    x, y = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    inside = np.hypot(x, y) < half_length
    x, y = x[inside], y[inside]
    normal, along, across, mixed = _influence(x[:, None] - x, y[:, None] - y, size / 2)
    scale = 2 * (1 + nu) / (np.pi * E * size**2)  # 1/(2 pi G) for two bodies, per unit force on a cell
    shear = scale * np.block([[(1 - nu) * normal + nu * along, nu * mixed], [nu * mixed, (1 - nu) * normal + nu * across]])
    n = len(x)
    S = np.zeros((3 * n, 3 * n))
    S[: 2 * n, : 2 * n], S[2 * n :, 2 * n :] = np.linalg.inv(shear), np.linalg.inv(scale * (1 - nu) * normal)
    S = (S + S.T) / 2
    cases = np.kron(np.eye(3), np.ones(n)) @ S
    bonded = {"approach": cases[2], "x": -cases[0], "y": -cases[1]}
    return {"S": S, "points": np.column_stack([x, y, np.zeros(n)]), "bonded": bonded, "gap": (x**2 + y**2) / (2 * R)}


def _influence(x: Array, y: Array, half: float) -> tuple[Array, Array, Array, Array]:
    """Integrals of 1/r, x^2/r^3, y^2/r^3 and x y/r^3 over a square cell around the origin, seen from (x, y)."""
    parts = np.zeros((3, *x.shape))
    for sx in (-1, 1):
        for sy in (-1, 1):
            X, Y = x + sx * half, y + sy * half
            r = np.hypot(X, Y)
            parts += sx * sy * np.array([Y * np.arcsinh(X / np.abs(Y)), X * np.arcsinh(Y / np.abs(X)), -r])
    along, across, mixed = parts
    return along + across, along, across, mixed
