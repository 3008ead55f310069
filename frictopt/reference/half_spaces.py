"""Half-planes and half-spaces of similar material as discrete contacts.

Their stiffness is the inverse of the exact influence of tractions on cells of the surface.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ..base import Array, finite_number, whole_number
from ..errors import ModelError


def half_plane_influence(nodes: int, E_star: float) -> Array:
    """Relative surface displacement of each of N equal cells per force on each cell.

    The displacement is the same for shear and for pressure. Opposite forces F per depth on the
    surfaces of both half-planes move these apart at the distance y by `-2 F / (pi E_star) log|y|`
    (line load, Johnson 1985, see `half_plane_contact`), up to a rigid motion of the half-planes.
    Force is spread evenly over a cell and displacement is the mean over a cell::

        G_ij = -2 / (pi E_star) (L(y + h) - 2 L(y) + L(y - h)) / h^2,    y = x_i - x_j,    L(y) =
        y^2 log|y| / 2 - 3 y^2 / 4

    G is an energy: `r G r / 2` is the work of the tractions. If the forces add up to zero,
    differences of displacements do not depend on the rigid motion. All other results depend on the
    choice of the zero displacement. Here lengths are in units of the length of the interface, so
    that the logarithm is zero at this distance. With this choice G is positive definite, and does
    not depend on the length.

    Parameters
    ----------
    nodes
        Number of cells N, at least 2.
    E_star
        Contact modulus of the pair, see `LineContact`, stress, positive.

    Returns
    -------
    Array
        (N, N), symmetric positive definite, length per force per depth.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> from frictopt.reference import half_plane_influence
    >>> half_plane_influence(nodes=2, E_star=1.0).round(4).tolist()
    [[1.3962, 0.5137], [0.5137, 1.3962]]
    """
    N = whole_number("nodes", nodes, least=2, most=10_000)
    E_star = finite_number("E_star", E_star, above=0.0)
    # Distance in cells, except 0.
    d = np.arange(1.0, N)
    # The second difference of L without log(d h): the remainder is of order d, not d^2 log d, and
    # cancels with less rounding.
    from_nearer = np.r_[0.0, (d[1:] - 1) ** 2 * np.log1p(-1 / d[1:])]
    apart = np.log(d / N) + ((d + 1) ** 2 * np.log1p(1 / d) + from_nearer) / 2 - 1.5
    by_distance = -2 / (pi * E_star) * np.r_[np.log(1 / N) - 1.5, apart]
    distance = np.abs(np.subtract.outer(np.arange(N), np.arange(N)))
    return np.asarray(by_distance[distance])


def half_plane_contact(
    nodes: int, half_length: float, E_star: float, *, R: float | None = None, beta: float = 0.0
) -> dict[str, Any]:
    """Contact of two half-planes, of one material or of two, as a contact system.

    Body 2 is flat. Body 1 is a cylinder of radius R with the initial gap `x^2 / (2 R)`. Without R
    it touches body 2 along the whole interface and nowhere else. Both bodies deform like
    half-planes. So without R, the pressure under P alone is the pressure of a rigid flat punch.
    Without `beta`, shear and pressure are uncoupled (`B = 0`) and have the same stiffness, `A = C`.
    This is exact for similar materials, for example for two equal materials. With `beta`, a shear
    force on a cell moves the surfaces apart by `beta / E_star` on one side of the cell, and
    together on the other side.

    The bodies are free to translate against each other (and do not rotate). Let G be the influence
    matrix, see `half_plane_influence`, and c an unknown translation. Then `u = G r + c`, and the
    forces of one direction add up to the load F. Solved for the forces::

        r = A u + F e      A = G^-1 - k e e^T      e = G^-1 1 / k      k = 1^T G^-1 1

    So a translation needs no force (`A 1 = 0`), A is positive semi-definite, and the bonded
    reactions `F e`, which are the forces of a uniform displacement, carry the whole load.

    Parameters
    ----------
    nodes, E_star
        See `half_plane_influence`; the nodes are the middles of the cells.
    half_length
        Half the length of the interface, length, positive. With R, it must exceed the half-width of
        the contact.
    R
        Radius of the cylinder, length, positive; None for the flat punch.
    beta
        Second constant of Dundurs of the two materials, between -0.5 and 0.5; 0 for similar
        materials.

    Returns
    -------
    dict[str, Any]
        Arguments A, B, C, x, bonded and gap of `ContactSystem.from_blocks`. Load cases: "P", the
        normal force, and "Q", the tangential force. Each is the resultant of the reactions of the
        half-plane on the punch, force per depth.

    References
    ----------
    K. L. Johnson (1985), Contact Mechanics, Cambridge University Press: the line load, the
    cylinder, the flat punch, and the constants of Dundurs.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> from frictopt.reference import half_plane_contact
    >>> contact = half_plane_contact(nodes=4, half_length=1.0, E_star=1.0)
    >>> contact["bonded"]["P"][1].round(4).tolist()  # like a rigid punch: more at the edges
    [0.3458, 0.1542, 0.1542, 0.3458]
    """
    G = half_plane_influence(nodes, E_star)
    half_length = finite_number("half_length", half_length, above=0.0)
    curvature = 0.0 if R is None else 1 / finite_number("R", R, above=0.0)
    beta = finite_number("beta", beta, above=-0.5, below=0.5)
    x: Array = half_length / nodes * np.arange(1.0 - nodes, nodes, 2.0)
    gap = curvature * x**2 / 2
    # A unit shear force opens the gap `coupling` on one side of it, and `-coupling` on the other.
    coupling = beta / E_star
    side = np.sign(np.subtract.outer(np.arange(nodes), np.arange(nodes)))
    inverse = np.linalg.inv(np.block([[G, coupling * side.T], [coupling * side, G]]))
    inverse = (inverse + inverse.T) / 2
    translations = np.kron(np.eye(2), np.ones((nodes, 1)))
    forces = inverse @ translations
    share = forces @ np.linalg.inv(translations.T @ forces)
    S = inverse - share @ forces.T
    S = (S + S.T) / 2
    return dict(
        A=S[:nodes, :nodes],
        B=S[nodes:, :nodes],
        C=S[nodes:, nodes:],
        x=x,
        bonded={
            "P": (share[:nodes, 1], share[nodes:, 1]),
            "Q": (share[:nodes, 0], share[nodes:, 0]),
        },
        gap=gap,
    )


def half_space_contact(
    cells: int, half_length: float, R: float, E: float, nu: float
) -> dict[str, object]:
    """Arguments of the `ContactSystem` of a sphere on a half-space of the same material.

    Its nodes are the cells of a square grid within a circle. Tractions are uniform on each cell and
    displacements are taken at its middle (Boussinesq, Cerruti; Johnson 1985, sections 3.2 to 3.6).
    Equal materials leave shear and pressure uncoupled. Its load cases move the far end of the
    sphere by a unit length: "approach" presses, "x" and "y" shear towards +x and +y. Forces are
    sums over cells.

    Parameters
    ----------
    cells
        Number of cells along the diameter of the circle, from 3 to 80.
    half_length, R
        Radius of the circle, which should exceed the radius of the contact, and radius of the
        sphere, length.
    E, nu
        Young's modulus, force per area, and Poisson's ratio of both bodies.

    Returns
    -------
    dict
        Arguments of `ContactSystem` by their names.

    Raises
    ------
    ModelError
        A value is out of its range.

    Examples
    --------
    >>> import frictopt as fo
    >>> contact = fo.reference.half_space_contact(cells=5, half_length=1.0, R=5.0, E=1.0, nu=0.3)
    >>> fo.ContactSystem(**contact)
    ContactSystem(nodes=21, tangents=2, loads=['approach', 'x', 'y'], gap=True)
    """
    whole_number("cells", cells, least=3, most=80)
    half_length = finite_number("half_length", half_length, above=0.0)
    R = finite_number("R", R, above=0.0)
    E = finite_number("E", E, above=0.0)
    nu = finite_number("nu", nu, above=-1.0, most=0.5)
    size = 2 * half_length / cells
    if not 0 < size**2 < np.inf:
        raise ModelError(
            f"half_length: {half_length:g}; its square is too large or too small; give the length "
            "in another unit"
        )
    line = (np.arange(cells) + 0.5) * size - half_length
    x, y = (grid.ravel() for grid in np.meshgrid(line, line, indexing="ij"))
    inside = np.hypot(x, y) < half_length
    x = x[inside]
    y = y[inside]
    normal, along, across, mixed = influence(x[:, None] - x, y[:, None] - y, size / 2)
    # 1 / (2 pi G) for two bodies, per unit force on a cell
    scale = 2 * (1 + nu) / (np.pi * E * size**2)
    shear = scale * np.block(
        [
            [(1 - nu) * normal + nu * along, nu * mixed],
            [nu * mixed, (1 - nu) * normal + nu * across],
        ]
    )
    n = len(x)
    S = np.zeros((3 * n, 3 * n))
    S[: 2 * n, : 2 * n] = np.linalg.inv(shear)
    S[2 * n :, 2 * n :] = np.linalg.inv(scale * (1 - nu) * normal)
    S = (S + S.T) / 2
    # Forces of a uniform displacement along x, y and the normal.
    along_x, along_y, pressing = np.kron(np.eye(3), np.ones(n)) @ S
    return {
        "S": S,
        "points": np.column_stack([x, y, np.zeros(n)]),
        "bonded": {"approach": pressing, "x": -along_x, "y": -along_y},
        "gap": (x**2 + y**2) / (2 * R),
    }


def influence(x: Array, y: Array, half: float) -> tuple[Array, Array, Array, Array]:
    """Integrals of 1/r, x^2/r^3, y^2/r^3 and x y/r^3 over a square cell around the origin.

    r is the distance from (x, y), and `half` is half the side of the cell.
    """
    integrals = np.zeros((3, *x.shape))
    # The antiderivatives at the corners of the cell, with alternating signs.
    for sx in (-1, 1):
        for sy in (-1, 1):
            X = x + sx * half
            Y = y + sy * half
            along = Y * np.arcsinh(X / np.abs(Y))
            across = X * np.arcsinh(Y / np.abs(X))
            integrals += sx * sy * np.array([along, across, -np.hypot(X, Y)])
    along, across, mixed = integrals
    return along + across, along, across, mixed
