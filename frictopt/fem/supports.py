"""Supports: nodes held along axes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from ..base import (
    Array,
    Integers,
    choice,
    finite_numbers,
    shown,
)
from ..errors import ModelError
from .bodies import Body, check_names

Axes: TypeAlias = Literal["x", "y", "z", "xy", "xz", "yz", "xyz"]
AXES = get_args(Axes)
Place = str | tuple[float, ...] | tuple[tuple[float, ...], ...] | Callable[..., Any]
"""Name of a boundary, coordinates of a node or of several, or a function that selects nodes."""
Seam: TypeAlias = tuple[Integers, Integers, Array]
"""Nodes of a body on a cut of a sector, the nodes that they copy, and the matrix of the turn."""


@dataclass(frozen=True)
class Support:
    """A support: nodes of one body whose displacements are zero.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        Name of a boundary; the coordinates (x, y), in space (x, y, z), of one node, or a list of
        such points; or a function of the coordinates (arrays) that returns True for each node of
        the support. For example, a ring is
        `lambda x, y, z: np.isclose(np.hypot(x, y), 5.0) & (z == 0)`.
    directions
        The displacements that are zero: "x", "y", "z", or several of them, such as "xy"; None: all
        that the body has.

    Raises
    ------
    ModelError
        The directions are unknown, the body is not a string, or the place is of another kind.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.Support("block", "bottom", "y")
    Support(body='block', where='bottom', directions='y')
    >>> fo.fem.Support("block", (0, -1), "x")
    Support(body='block', where=(0.0, -1.0), directions='x')
    """

    body: str
    where: Place
    directions: Axes | None = None

    def __post_init__(self) -> None:
        check_names(self, "body")
        if self.directions is not None:
            choice("directions", self.directions, AXES)
        object.__setattr__(self, "where", checked_place(self.where))


def checked_place(where: object, name: str = "where") -> Place:
    """Check the name of a boundary, the coordinates of points, or a function."""
    if isinstance(where, str) or (callable(where) and not isinstance(where, type)):
        return where
    remedy = (
        "the name of a boundary, one point (x, y), in space (x, y, z), a list of points, or a "
        "function of the coordinates"
    )
    if isinstance(where, tuple | list) and where and isinstance(where[0], tuple | list):
        return tuple(checked_point(name, point, remedy) for point in where)
    return checked_point(name, where, remedy)


def checked_point(
    name: str, point: object, remedy: str, sizes: tuple[int, ...] = (2, 3)
) -> tuple[float, ...]:
    """Check the coordinates of a point or vector; `remedy` says in words what to give."""
    if not isinstance(point, tuple | list) or len(point) not in sizes:
        raise ModelError(f"{name}: {shown(point)}; give {remedy}")
    return tuple(finite_numbers(name, point))


def checked_axis(part: Any) -> None:
    """Check the centre and the direction of the axis of a load or support, and make them tuples."""
    if part.centre is not None:
        centre = checked_point("centre", part.centre, "one point (x, y), in space (x, y, z)")
        object.__setattr__(part, "centre", centre)
    axis = checked_point("axis", part.axis, "one direction (x, y, z)", (3,))
    object.__setattr__(part, "axis", axis)
    if not np.linalg.norm(axis) > 0:  # a tiny axis counts as zero, because its square is zero
        raise ModelError(f"axis: {axis}; give the direction of the axis")


def axis_of(part: Any, d: int) -> tuple[Array, Array]:
    """A point (d,) of the axis of a load or support, and the unit vector (3,) along it."""
    centre = np.zeros(d) if part.centre is None else np.array(part.centre)
    if len(centre) != d:
        raise ModelError(
            f"centre: {part.centre}; give the {d} coordinates of a point for body {part.body!r}"
        )
    if d == 2 and part.axis[:2] != (0.0, 0.0):
        raise ModelError(
            f"axis: {part.axis}; body {part.body!r} is plane, and its axis a normal of the plane, "
            "or x = 0 if axisymmetric"
        )
    return centre, np.array(part.axis) / np.linalg.norm(part.axis)


def nodes_of(body: Body, name: str, where: Place) -> Integers:
    """Nodes of the mesh of a body at the place of a support, a displacement or a force."""
    if isinstance(where, str):
        return body.boundary_nodes(where, f"support of body {name!r}")
    if callable(where):
        return _nodes_by(where, body, name)
    points = np.atleast_2d(np.array(where))
    return np.unique([_node_at(point, body, name) for point in points])


def _node_at(point: Array, body: Body, name: str) -> int:
    """The node of a body at a point (d,)."""
    x = body.written
    where = tuple(point.tolist())
    if len(where) != len(x):
        raise ModelError(
            f"where: {where}; give the {len(x)} coordinates of a node of body {name!r}"
        )
    distance = np.linalg.norm(x - point[:, None], axis=0)
    nearest = int(distance.argmin())
    if distance[nearest] > np.linalg.norm(2 * body.errors[nearest]):
        raise ModelError(
            f"support of body {name!r}: no node at {where}; the nearest is at "
            f"{tuple(x[:, nearest].tolist())}"
        )
    return nearest


def _nodes_by(select: Callable[..., Any], body: Body, name: str) -> Integers:
    """The nodes of a body at which a function of the coordinates is true."""
    count = body.mesh.p.shape[1]
    remedy = f"give one truth value for each of the {count} nodes of body {name!r}"
    try:
        is_meant = np.asarray(select(*body.written))
    except Exception as error:  # a function of the user may raise any error
        raise ModelError(
            f"where: the function raised {type(error).__name__}: {error}; {remedy}"
        ) from error
    if is_meant.dtype != bool or is_meant.shape != (count,):
        raise ModelError(
            f"where: the function gave an array of {is_meant.dtype}, shape {is_meant.shape}; "
            f"{remedy}"
        )
    if not is_meant.any():
        raise ModelError(
            f"where: the function is true at no node of body {name!r}; compare coordinates with "
            "np.isclose"
        )
    return np.flatnonzero(is_meant)
