"""The shakedown limit of an uncoupled contact in three dimensions: the smallest circle around the shears of each node."""

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array
from ..errors import ModelError
from ._checks import per_node

_INSIDE = 1e-12  # a point this far outside a circle, over the size of the points, is on it


def smallest_circle(points: ArrayLike) -> tuple[Array, float]:
    """Centre and radius of the smallest circle around some points of the plane: through two of them, or through three.

    Parameters
    ----------
    points
        (K, 2) points, in any one unit; a handful of them, because all pairs and triples are tried.

    Raises
    ------
    ModelError
        No points, or points that are not real and finite.

    Examples
    --------
    >>> from frictopt.reference import smallest_circle
    >>> centre, radius = smallest_circle([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.5]])
    >>> centre.tolist(), radius
    ([0.0, 0.0], 1.0)
    """
    array = finite_array("points", points, (None, 2))
    if not len(array):
        raise ModelError("points: none; give at least one")
    middle = array.mean(axis=0)
    size = float(np.abs(array - middle).max())
    if size == 0:
        return array[0], 0.0
    unit = (array - middle) / size
    circles = [((one + two) / 2, float(np.hypot(*(one - two)) / 2)) for one, two in combinations(unit, 2)]
    for a, b, c in combinations(unit, 3):
        matrix = 2 * np.array([b - a, c - a])
        if abs(np.linalg.det(matrix)) > _INSIDE:
            centre = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
            circles.append((centre, float(np.hypot(*(a - centre)))))
    holding = [circle for circle in circles if np.hypot(*(unit - circle[0]).T).max() <= circle[1] + _INSIDE]
    centre, radius = min(holding, key=lambda circle: circle[1])
    return middle + size * centre, size * radius


def smallest_circle_limit(p0: ArrayLike, q1: ArrayLike, f: ArrayLike) -> float:
    """Limit lambda_2 of an uncoupled contact in three dimensions (B = 0) whose corners change the shear forces alone.

    A residual slip moves the shear forces of each node at all corners by the same vector, which is free where A is positive definite. The node is
    safe if a circle of radius `f p0` holds its corners, so the weakest node rules::

        lambda = min over nodes of  f p0 / (radius of the smallest circle around the corners' q1)

    Parameters
    ----------
    p0
        Normal forces of the mean load, compression positive, (N,) or one number, force.
    q1
        (K, N, 2) shear forces of the corners at load factor one, force.
    f
        Coefficient of friction, (N,) or one number, positive.

    Returns
    -------
    float
        Dimensionless; inf if the load does not shear the nodes, nan if a node pulls under the mean load.

    Raises
    ------
    ModelError
        Values that are not real and finite, lengths that do not match, friction not positive.

    References
    ----------
    A. Klarbring, M. Ciavarella and J. R. Barber (2007), Shakedown in elastic contact problems with Coulomb friction, International Journal of
    Solids and Structures 44, 8355-8365: uncoupled contacts shake down below it from every start.

    Examples
    --------
    >>> from frictopt.reference import smallest_circle_limit
    >>> smallest_circle_limit(p0=[1.0, 3.0], q1=[[[1.0, 0.0], [1.0, 0.0]], [[-1.0, 0.0], [-1.0, 0.0]]], f=0.5)
    0.5
    """
    shear = finite_array("q1", q1, (None, None, 2))
    if not shear.size:
        raise ModelError(f"q1: shape {shear.shape}; give the shear forces (K, N, 2) of at least one corner and node")
    p0, f = per_node(shear.shape[1], p0=p0, f=f)
    if p0.min() < 0:
        return float("nan")
    radii = np.array([smallest_circle(shear[:, node])[1] for node in range(shear.shape[1])])
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(radii > 0, f * p0 / radii, np.inf).min())
