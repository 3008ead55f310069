"""Supports: what they hold, along axes or along the normals of a boundary, and the directions of the nodes that are held so."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from ..base import (
    SAME_POINT,
    Array,
    Booleans,
    Integers,
    check_text,
    choice,
    finite_numbers,
    first_of,
    flag,
    place,
    shown,
)
from ..errors import ModelError
from .bodies import Body
from .coincidence import mesh_errors
from .elasticity import corner_weights, facet_nodes, places_of
from .faces import facets_around, normals_of
from .normals import SMOOTH, normals_of_faces

Place = str | tuple[float, ...]
"""Name of a boundary, or the coordinates of one node."""
Seam: TypeAlias = tuple[Integers, Integers, Array]
"""Nodes of a body on a cut of a sector, the nodes that they copy, and the matrix that turns what is there to them."""


@dataclass(frozen=True)
class Support:
    """A support: nodes of one body whose displacements are zero.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        Name of a boundary, or the coordinates (x, y), in space (x, y, z), of one node.
    directions
        The displacements that are zero: "x", "y", "z", or several of them, such as "xy"; None: all
        that the body has.
    normal
        True: each node of the boundary is held along the normal there and free across it, as on an
        oblique plane of symmetry or in a cylinder. `directions` is then None, and no `Displacement`
        moves the nodes. At the edge where two such boundaries meet, nodes are held along both
        normals; where they go on as one, with normals less than 25 degrees apart, along that of
        both together.

    Raises
    ------
    ModelError
        No such directions, a body that is no text, a place that is neither a text nor a point;
        `normal` with directions or of a single node. In a model: a boundary with an edge, where a
        node has two normals.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.Support("block", "bottom", "y")
    Support(body='block', where='bottom', directions='y', normal=False)
    >>> fo.Support("block", (0, -1), "x")
    Support(body='block', where=(0.0, -1.0), directions='x', normal=False)
    >>> sector = [fo.Support("flange", cut, normal=True) for cut in ("first cut", "second cut")]
    """

    body: str
    where: Place
    directions: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] | None = None
    normal: bool = False

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        if self.directions is not None:
            choice("directions", self.directions, ("x", "y", "z", "xy", "xz", "yz", "xyz"))
        object.__setattr__(self, "where", checked_place(self.where))
        if flag("normal", self.normal) and (
            self.directions is not None or not isinstance(self.where, str)
        ):
            given = (
                f"directions {shown(self.directions)}"
                if self.directions is not None
                else f"where: {self.where}"
            )
            raise ModelError(
                f"{given} with normal=True; name a boundary, and leave the directions out"
            )


def checked_place(where: object) -> Place:
    """Check the name of a boundary or the coordinates of a point."""
    return (
        where
        if isinstance(where, str)
        else checked_point(
            "where", where, "the name of a boundary or one point (x, y), in space (x, y, z)"
        )
    )


def checked_point(
    name: str, point: object, words: str, sizes: tuple[int, ...] = (2, 3)
) -> tuple[float, ...]:
    """Check a row of two or three coordinates, which error messages describe in words."""
    if not isinstance(point, tuple | list) or len(point) not in sizes:
        raise ModelError(f"{name}: {shown(point)}; give {words}")
    return tuple(finite_numbers(name, point))


def checked_axis(part: Any) -> None:
    """Check the centre and the direction of the axis of a part of a model, and make tuples of them."""
    if part.centre is not None:
        object.__setattr__(
            part,
            "centre",
            checked_point("centre", part.centre, "one point (x, y), in space (x, y, z)"),
        )
    object.__setattr__(
        part, "axis", checked_point("axis", part.axis, "one direction (x, y, z)", (3,))
    )
    if not np.linalg.norm(part.axis) > 0:  # also of one whose square is zero
        raise ModelError(f"axis: {part.axis}; give the direction of the axis")


def axis_of(part: Any, d: int) -> tuple[Array, Array]:
    """A point (d,) of the axis of a part of a model, and the unit vector (3,) along it."""
    centre = np.zeros(d) if part.centre is None else np.array(part.centre)
    if len(centre) != d:
        raise ModelError(
            f"centre: {part.centre}; give the {d} coordinates of a point for body {part.body!r}"
        )
    if d == 2 and part.axis[:2] != (0.0, 0.0):
        raise ModelError(
            f"axis: {part.axis}; body {part.body!r} is plane, and its axis a normal of the plane, or x = 0 if axisymmetric"
        )
    return centre, np.array(part.axis) / np.linalg.norm(part.axis)


def nodes_of(body: Body, name: str, where: Place) -> Integers:
    """Nodes of the mesh of a body at the place of a support or a displacement."""
    x = body.mesh.p
    if isinstance(where, str):
        return body.boundary_nodes(where, f"support of body {name!r}")
    if len(where) != len(x):
        raise ModelError(
            f"where: {where}; give the {len(x)} coordinates of a node of body {name!r}"
        )
    distance = np.linalg.norm(x - np.array(where)[:, None], axis=0)
    if distance.min() > np.linalg.norm(2 * mesh_errors(body.mesh)[distance.argmin()]):
        raise ModelError(
            f"support of body {name!r}: no node at {where}; the nearest is at {tuple(x[:, distance.argmin()].tolist())}"
        )
    return np.array([distance.argmin()])


def normals_along(
    body: Body, supports: Sequence[Support], seam: Seam | None = None
) -> list[tuple[Integers, Array]]:
    """Nodes of a body that each of its supports holds along their normals, and these unit normals (n, d).

    Nodes amid edges have the mean of their corners'. Faces that go on smoothly are one: nodes that
    they share have the normal of both together. So have those on the seam of a sector.
    """
    mesh, points = body.mesh, body.mesh.p.T
    faces = [
        body.boundary(str(support.where), f"support of body {support.body!r}")
        for support in supports
    ]
    around = [facets_around(mesh, facets) for facets in faces]
    weighted = np.array(normals_of_faces(around, points))
    if seam:
        high, low, turn = seam
        both = np.all(
            [weighted[:, side].any(axis=2, keepdims=True) for side in (low, high)], axis=0
        )
        weighted[:, low] += both * (weighted[:, high] @ turn)
        weighted[:, high] = np.where(both, weighted[:, low] @ turn.T, weighted[:, high])
    smooth = np.einsum("and,bnd->abn", _unit(weighted), _unit(weighted)) > SMOOTH
    found = []
    for support, facets, corners, own in zip(
        supports, faces, around, _unit(np.einsum("abn,bnd->and", smooth, weighted)), strict=True
    ):
        lean = np.einsum("fcd,fd->fc", own[corners], normals_of(points[corners])).min(axis=1)
        if (i := first_of(lean < SMOOTH, -lean)) is not None:
            raise ModelError(
                f"supports: {support} has an edge around {place(points[corners[i]].mean(axis=0))}, where its nodes have two normals; name the face "
                "on either side of the edge, and give each a support, or mesh a curved face finer"
            )
        elements, _ = places_of(mesh, facets)
        total = np.zeros_like(points)
        np.add.at(
            total,
            mesh.dofs.element_dofs[:, elements],
            np.einsum("lc,cfd->lfd", corner_weights(type(mesh)), own[mesh.t[:, elements]]),
        )
        nodes = facet_nodes(mesh, facets)
        found.append((nodes, _unit(total)[nodes]))
    return found


def _unit(vectors: Array) -> Array:
    return np.asarray(
        vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), np.finfo(float).tiny)
    )


def along_axes(normals: Array) -> tuple[Booleans, Integers]:
    """(n,) which of some unit normals (n, d) are along axes, and along which one each is most."""
    most = np.abs(normals).argmax(axis=1)
    return np.sum(normals**2, axis=1) - np.take_along_axis(normals, most[:, None], axis=1)[
        :, 0
    ] ** 2 <= SAME_POINT**2, most
