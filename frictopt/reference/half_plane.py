"""Two half-planes of similar material in contact along a line, discretised by the exact influence of their surface tractions."""

from math import pi
from typing import Any

import numpy as np

from ..contact.checks import Array, finite_number, whole_number


def half_plane_influence(nodes: int, E_star: float) -> Array:
    """Relative surface displacement of each of N equal cells per force on each cell, the same for shear and for pressure.

    A force F per depth on the surface of both half-planes, opposite on the two, moves them apart at the distance y by
    `-2 F / (pi E_star) log|y|`, up to a rigid motion of the half-planes, which the forces do not determine. Force is spread evenly over a cell and
    displacement is the mean over a cell, so that with `L'' = log`::

        G_ij = -2 / (pi E_star) (L(y + h) - 2 L(y) + L(y - h)) / h^2,    y = x_i - x_j,    L(y) = y^2 log|y| / 2 - 3 y^2 / 4

    which is symmetric, and is an energy: `r G r / 2` is the work of the tractions. Forces that add up to zero, `1^T r = 0`, and differences of
    displacements do not depend on that motion. All else depends on the zero of the displacement: with all lengths in units of the interface's, the
    logarithm vanishes at its far end. That makes G positive definite, and independent of the length.

    Parameters
    ----------
    nodes
        Number of cells N, at least 2.
    E_star
        Contact modulus of the pair, see `contact_modulus`, stress, positive.

    Returns
    -------
    Array
        (N, N), symmetric positive definite, length per force per depth.

    Raises
    ------
    ModelError
        Fewer than two cells, a modulus that is not real and finite or not positive.

    References
    ----------
    K. L. Johnson (1985), Contact Mechanics, Cambridge University Press: the line load on a half-plane.

    Examples
    --------
    >>> from frictopt.reference import half_plane_influence
    >>> half_plane_influence(nodes=2, E_star=1.0).round(4).tolist()
    [[1.3962, 0.5137], [0.5137, 1.3962]]
    """
    N, E_star = whole_number("nodes", nodes, least=2, most=10_000), finite_number("E_star", E_star, above=0.0)
    d = np.arange(1.0, N)  # distance in cells
    # The second difference of L with log(d h) taken out: what is left is of order d, not d^2 log d, and cancels with less rounding.
    nearer = np.r_[0.0, (d[1:] - 1) ** 2 * np.log1p(-1 / d[1:])]
    apart = np.log(d / N) + ((d + 1) ** 2 * np.log1p(1 / d) + nearer) / 2 - 1.5
    by_distance = -2 / (pi * E_star) * np.r_[np.log(1 / N) - 1.5, apart]
    distance = np.abs(np.subtract.outer(np.arange(N), np.arange(N)))
    return np.asarray(by_distance[distance])


def half_plane_contact(nodes: int, half_length: float, E_star: float, *, R: float | None = None) -> dict[str, Any]:
    """Contact of two half-planes of similar material, as a contact system with the load cases "P" and "Q".

    Body 2 is flat. Body 1 is a cylinder of radius R with the initial gap `x^2 / (2 R)`. Without R it touches body 2 along the whole interface and
    nowhere else. Both deform like half-planes; under P alone, their pressure is that of a rigid flat punch. Shear and pressure are uncoupled
    (`B = 0`, exact for materials whose shear does not change the pressure, two equal ones above all) and have one stiffness, `A = C`.

    The bodies are free to translate against each other (and do not rotate). Forces r and displacements u, of one direction, then obey
    `u = G r + c` with the influence matrix G and an unknown translation c, and the forces add up to the load F. Solved for the forces::

        r = A u + F e      A = G^-1 - k e e^T      e = G^-1 1 / k      k = 1^T G^-1 1

    so that a translation meets no force (`A 1 = 0`), A is positive semi-definite, and the bonded reactions `F e` carry the whole load: they
    are the forces of a uniform displacement. The arbitrary zero of the displacement in G changes neither A nor e.

    Parameters
    ----------
    nodes
        Number of equal cells N, at least 2; the nodes are their middles.
    half_length
        Half the length of the interface, length, positive; with R, more than the half-width of the contact to come.
    E_star
        Contact modulus of the pair, see `contact_modulus`, stress, positive.
    R
        Radius of the cylinder, length, positive; None for the flat punch.

    Returns
    -------
    dict[str, Any]
        Arguments A, B, C, x, bonded and gap of `ContactSystem.from_blocks`.
        Load cases: "P", the normal force, and "Q", the tangential one, each the resultant of the
        reactions of the half-plane on the punch, force per depth.

    Raises
    ------
    ModelError
        Fewer than two cells, values that are not real and finite or not positive.

    References
    ----------
    K. L. Johnson (1985), Contact Mechanics, Cambridge University Press: the line load, the cylinder and the flat punch.

    Examples
    --------
    >>> from frictopt.reference import half_plane_contact
    >>> arrays = half_plane_contact(nodes=4, half_length=1.0, E_star=1.0)
    >>> arrays["bonded"]["P"][1].round(4).tolist()  # pressed like a rigid punch: more at the edges
    [0.3458, 0.1542, 0.1542, 0.3458]
    """
    G, half = half_plane_influence(nodes, E_star), finite_number("half_length", half_length, above=0.0)
    curvature = 0.0 if R is None else 1 / finite_number("R", R, above=0.0)
    inverse = np.linalg.inv(G)
    inverse = (inverse + inverse.T) / 2
    share = inverse.sum(axis=1) / inverse.sum()
    A = inverse - inverse.sum() * np.outer(share, share)
    x: Array = half / nodes * np.arange(1.0 - nodes, nodes, 2.0)
    none = np.zeros(nodes)
    return dict(A=A, B=np.zeros_like(A), C=A.copy(), x=x, bonded={"P": (none, share), "Q": (share, none)}, gap=curvature * x**2 / 2)
