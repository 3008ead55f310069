"""Sectors of rings, one of whose cut faces follows the other, turned about the axis of the ring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags, identity, kron
from scipy.sparse.linalg import LinearOperator, cg
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..base import (
    COUNTS,
    ROUNDING,
    SAME_POINT,
    Array,
    Booleans,
    Integers,
    check_text,
    first_of,
    place,
)
from ..contact.frames import frames_of
from ..errors import ModelError
from .bodies import Body
from .coincidence import mesh_errors
from .elasticity import Kinematics, facet_nodes
from .faces import FACED, areas_of, faced, facet_overlaps, facets_around, mortar_projection, sag
from .interface import ASKEW, blocks_of
from .supports import Seam, axis_of, checked_axis

_WHOLE = 0.9  # least share of all of it
_MOST = 1000  # sectors of a ring


@dataclass(frozen=True)
class Cyclic:
    """One sector stands for a ring of sectors: the displacements of one cut face are those of the other, turned about the axis.

    It is given among the supports of a model, once for each body that is cut. The sectors must be
    alike, and so must their loads: turned by the angle of a sector, each load is that of the next
    sector. The answers are then those of the ring: limits and slips its own; forces, areas, widths,
    works and compliances those of one sector. The ring may turn about its axis and move along it
    where nothing holds it, and so may each body; it cannot move in any other way. Like a half of a
    joint, a sector knows alone the slips that repeat. Faces at which neighbouring sectors slide on
    each other, such as shrouds of blades, are no cut faces.

    Nodes that match are joined one to one, others by the dual mortar method, of quadratic elements
    through their corners. A contact may reach the cut where its own nodes match, and those of both
    cut faces. Theory, "Sectors of a ring".

    Parameters
    ----------
    body
        Name of the body in its model.
    low, high
        Names of the two cut faces, boundaries of its mesh: `high` is `low` turned about the axis by
        360 degrees over a whole number, which is found. They may meet on the axis.
    axis
        Direction (x, y, z) of the axis of a body in space, of any length. In the plane the axis is
        normal to it.
    centre
        Point (x, y), in space (x, y, z), of the axis; None: the origin.

    Raises
    ------
    ModelError
        Names that are no texts, one name for both faces, an axis without direction. In a model:
        faces that are no turned copies of each other, with the largest distance between them; two
        axes or angles; what is held on `high` and not on `low`, or moved differently; contacts that
        reach the cut with nodes that do not match; axisymmetric bodies.

    Examples
    --------
    >>> import numpy as np
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> grid = MeshQuad.init_tensor([1.0, 1.5, 2.0], np.linspace(0, np.pi / 2, 5))
    >>> cuts = {"low": lambda x: x[1] < 1e-9, "high": lambda x: x[0] < 1e-9}
    >>> mesh = MeshQuad(grid.p[0] * np.array([np.cos(grid.p[1]), np.sin(grid.p[1])]), grid.t).with_boundaries(cuts)
    >>> mesh = mesh.with_boundaries({"bore": lambda x: np.hypot(*x) < 1.01, "rim": lambda x: np.hypot(*x) > 1.9})
    >>> disc = MeshQuad(2 * mesh.p, mesh.t).with_boundaries(mesh.boundaries)
    >>> model = fo.ContactModel(
    ...     {"ring": fo.Body(mesh), "rim": fo.Body(disc)},
    ...     supports=[fo.Cyclic("ring", "low", "high"), fo.Cyclic("rim", "low", "high"), fo.Support("rim", "rim")],
    ...     loads={"fit": [fo.Interference("rim", 1e-3)]},
    ...     contacts=[fo.Contact("ring", "rim", "rim", "bore")],
    ... )
    >>> system = model.condense()  # the nodes on both cuts are one
    >>> system.nodes, round(float(system.width.sum()), 3)
    (4, 3.121)
    """

    body: str
    low: str
    high: str
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    centre: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        check_text("body", self.body, "the name of a body of the model")
        for side in ("low", "high"):
            check_text(side, getattr(self, side), "the name of a boundary of the mesh")
        if self.low == self.high:
            raise ModelError(
                f"high: {self.high!r} is `low` too; name the two cut faces of the sector"
            )
        checked_axis(self)


@dataclass(frozen=True, eq=False)
class Sector:
    """Nodes that follow others around an axis, `u_i = Q sum_j P_ij u_j`: those of the high faces of a sector follow those of the low ones."""

    nodes: Integers  # (n,) that follow
    places: csr_matrix  # (n, all nodes) matrix P
    copies: Integers  # (all nodes,) node that each is a turned copy of; -1: none
    fixed: Integers  # nodes on the axis, which both faces have
    turn: Array  # (d, d) matrix Q
    shift: Array  # (d,) where the origin is turned to
    along: Array  # (d,) unit vector along the axis; zero in the plane
    count: int  # of the sectors of the ring
    unlike: Mapping[str, Integers]  # body -> facets of its faces, where they do not match

    def held(self) -> list[tuple[Integers, Array]]:
        """The nodes on the axis, with each direction (n, d) across it: in these they are held."""
        across = frames_of(self.along[None])[0, :2] if self.along.any() else np.eye(2)
        return [(self.fixed, np.tile(way, (len(self.fixed), 1))) for way in across]

    @property
    def on_cuts(self) -> Integers:
        """All nodes that follow, or are followed."""
        return np.concatenate([self.nodes, self.places.indices, self.fixed])

    def follow(
        self, rows: Integers, free_rows: Integers, directions: Array, points: Array
    ) -> csr_matrix:
        """The matrix (size, size) of `u = C u` that lets nodes follow; those of faces that do not match stay where they are held.

        Given are the parts of an assembly; the free rows (nodes, d), -1 where held along the
        directions (nodes, d, d), become -2 where nodes follow.
        """
        d, copied, held = rows.shape[1], self.copies[self.nodes] >= 0, free_rows == -1
        self._check_held(self.nodes[copied], directions, held, points)
        free_rows[self.nodes] = np.where(held[self.nodes], -1, -2)
        own, stays = directions[self.nodes], held[self.nodes] & ~copied[:, None]
        free = np.eye(d) - np.einsum("nka,nk,nkb->nab", own, stays, own)
        by_nodes = csr_matrix(
            (np.ones(rows.size), (rows.ravel(), np.arange(rows.size))), shape=(rows.size,) * 2
        )
        rest = np.ones(rows.size)
        rest[rows[self.nodes][~stays]] = 0.0
        follow = blocks_of(free @ self.turn) @ kron(self.places, identity(d)) @ by_nodes.T
        return csr_matrix(
            diags(rest) + by_nodes[:, (d * self.nodes[:, None] + np.arange(d)).ravel()] @ follow
        )

    def _check_held(
        self, copied: Integers, directions: Array, held: Booleans, points: Array
    ) -> None:
        """Check that what is held of copies is held of the nodes that they follow."""
        of = self.copies[copied]
        share = np.einsum(
            "nl,nkl->nk",
            held[of],
            np.einsum("nka,nla->nkl", directions[copied] @ self.turn, directions[of]) ** 2,
        )
        if (i := first_of((held[copied] & (share < 1 - ASKEW)).any(axis=1))) is not None:
            raise ModelError(
                f"supports: the node at {place(points[copied[i]])} is held, and not so the one at {place(points[of[i]])}, which it copies on "
                "the other cut face of the sector; hold both, for what is held repeats from sector to sector"
            )

    def check_moved(self, argument: str, moved: Array, turned: Array, points: Array) -> None:
        """Check that the displacements (nodes, d) of supports repeat: those of nodes that follow are (nodes, d), nan where none is given."""
        own = np.abs(moved - turned)[self.nodes] > ROUNDING * np.nanmax(np.abs(moved), initial=0.0)
        if (i := first_of(own.any(axis=1))) is not None:
            raise ModelError(
                f"{argument}: the displacement of the node at {place(points[self.nodes[i]])}, on a cut face of a sector, is not that of the "
                "other face, turned; give displacements that repeat from sector to sector"
            )

    def check_loads(self, argument: str, loads: Sequence[Any]) -> None:
        """Check that spins, and loads of constants, are those of the next sector, too; what functions say is the user's."""
        turn, d = self.turn, len(self.turn)
        for load in loads:
            spins, parts = hasattr(load, "centre"), [getattr(load, axis, 0.0) for axis in "xyz"[:d]]
            centre, axis = (
                axis_of(load, d)
                if spins
                else (
                    np.zeros(d),
                    np.array([0.0 if callable(part) else part or 0.0 for part in parts]),
                )
            )
            off = np.abs(
                [turn @ axis[:d] - axis[:d], turn @ centre + self.shift * spins - centre]
            ).max()
            if off > SAME_POINT * np.abs([axis[:d], centre, self.shift]).max():
                told = (
                    f"{load} is another one in the next sector, turned by 360/{self.count} degrees"
                )
                raise ModelError(
                    f"{argument}: {told}; give functions of the coordinates that turn so, a spin about the axis, or the whole ring"
                )

    def once(
        self, names: Sequence[str], pairs: tuple[Any, ...], points: Array, errors: Array
    ) -> tuple[Any, ...]:
        """The pairs but those of copied nodes: in the ring each is one pair with that of the node that it copies, and adds normal and width to it.

        Of each pair are given the number of its contact, its node of body 1, its place on body 2, a
        row over all nodes, normal, width and gap.
        """
        contact, nodes, projection, normals, widths, gap = pairs
        copy, high = self.copies, np.flatnonzero(np.isin(nodes, self.nodes))
        number = {
            pair: k for k, pair in enumerate(zip(contact.tolist(), nodes.tolist(), strict=True))
        }
        low = np.array(
            [number.get((int(contact[k]), int(copy[nodes[k]])), -1) for k in high], dtype=np.intp
        )
        links = projection.tocoo()
        turned = csr_matrix(
            (links.data, (links.row, np.where(copy[links.col] >= 0, copy[links.col], links.col))),
            shape=projection.shape,
        )
        wrong = np.bincount(links.row, np.isin(links.col, self.nodes), minlength=len(nodes)) > 0
        wrong |= np.isin(nodes, copy[copy >= 0]) & ~np.isin(np.arange(len(nodes)), low)
        wrong[high] = (low < 0) | (
            np.asarray(abs(turned[high] - projection[low]).sum(axis=1)).ravel() > COUNTS
        )
        if (k := first_of(wrong)) is not None:
            raise ModelError(
                f"contacts: {names[contact[k]]!r} reaches the cut of the sector at {place(points[nodes[k]])}, and its nodes there are not the same "
                "on both bodies and on both cut faces; let nodes match there (gmsh: fragment the bodies, and setPeriodic from cut to cut), call the "
                "faces on one side `low` of both bodies, or cut where no contact is"
            )
        written = 4 * np.linalg.norm(
            errors[nodes[high]], axis=1
        )  # the gap of each has the errors of two places
        if (
            k := first_of(np.abs(gap[high] - gap[low]) > COUNTS * gap.max(initial=0.0) + written)
        ) is not None:
            at = f"{names[contact[high[k]]]!r} at {place(points[nodes[high[k]]])}"
            told = f"{at} is {gap[high[k]]:g}, and {gap[low[k]]:g} at the node that it copies"
            raise ModelError(
                f"contacts: the gap of {told}, on the other cut face; give gaps that repeat from sector to sector"
            )
        widths[low] += widths[high]
        normals[low] += normals[high] @ self.turn
        return tuple(part[np.delete(np.arange(len(nodes)), high)] for part in pairs)

    def seam(self, first: int, body: Body) -> Seam | None:
        """Copied nodes of a body, whose nodes begin with that number, the nodes that they copy, and Q; None if it has none."""
        copied = np.flatnonzero(self.copies[first : first + body.mesh.p.shape[1]] >= 0)
        return (copied, self.copies[first + copied] - first, self.turn) if len(copied) else None


def sector_of(cuts: Sequence[Cyclic], bodies: Mapping[str, Body], kinematics: Kinematics) -> Sector:
    """The nodes of all bodies, one body after the other, that follow others: none in a whole, the one sector of its ring."""
    if cuts and kinematics == "axisymmetric":
        raise ModelError(
            f"supports: {cuts[0]} in an axisymmetric model, which is the whole ring; leave it out, or mesh the sector in space"
        )
    found: dict[str, Sector] = {}
    for cut in cuts:
        if cut.body not in bodies or cut.body in found:
            raise ModelError(
                f"supports: body {cut.body!r} of {cut} is unknown, or has another Cyclic; this model has {sorted(bodies)}"
            )
        found[cut.body] = _sector(bodies[cut.body], cut)
    none, d = np.zeros(0, dtype=np.intp), next(iter(bodies.values())).mesh.dim()
    uncut = Sector(none, csr_matrix((0, 0)), none, none, np.eye(d), np.zeros(d), np.zeros(d), 1, {})
    (one, first), *others = found.items() or [("", uncut)]
    for name, other in others:
        off = np.abs(
            np.r_[
                (other.turn - first.turn).ravel(),
                (other.shift - first.shift) / np.ptp(bodies[one].mesh.p),
            ]
        )
        if off.max() > SAME_POINT:
            raise ModelError(
                f"supports: the sectors of bodies {one!r} and {name!r} turn about other axes or by other angles; give all the same"
            )
    sizes = {name: body.mesh.p.shape[1] for name, body in bodies.items()}
    whole = {
        name: replace(uncut, places=csr_matrix((0, n)), copies=np.full(n, -1))
        for name, n in sizes.items()
    }
    parts = list(zip(np.cumsum([0, *sizes.values()]), (whole | found).values(), strict=False))
    return replace(
        first,
        nodes=np.concatenate([start + part.nodes for start, part in parts]),
        places=csr_matrix(block_diag([part.places for _, part in parts])),
        copies=np.concatenate(
            [np.where(part.copies < 0, -1, start + part.copies) for start, part in parts]
        ),
        fixed=np.concatenate([start + part.fixed for start, part in parts]),
        unlike={name: facets for _, part in parts for name, facets in part.unlike.items()},
    )


def _sector(body: Body, cut: Cyclic) -> Sector:
    """Find the angle between the cut faces of one body, and the places of the nodes of one on the other."""
    mesh, x, d = body.through_corners.mesh, body.mesh.p.T, body.mesh.dim()
    (centre, along), errors = axis_of(cut, d), mesh_errors(body.mesh)
    low, high = (
        body.boundary(name, f"sector of body {cut.body!r}") for name in (cut.low, cut.high)
    )
    arms = [_middle(x[facets_around(mesh, facets)]) - centre for facets in (low, high)]
    one, two = (np.pad(arm, (0, 3 - d)) for arm in arms)
    angle = float(np.arctan2(along @ np.cross(one, two), one @ two - (along @ one) * (along @ two)))
    count = round(2 * np.pi / max(abs(angle), 2 * np.pi / _MOST))
    if angle < 0 and count > 2:
        low, high = high, low
    turn = Rotation.from_rotvec(2 * np.pi / count * along).as_matrix()[:d, :d]
    middles = x[mesh.facets[:, low]].mean(axis=0)
    onward = np.cross(along, np.pad(middles - centre, ((0, 0), (0, 3 - d))))[:, :d]
    if count > 2 and (onward * (x[mesh.t[:, mesh.f2t[0, low]]].mean(axis=0) - middles)).sum() < 0:
        told = f"{cut.body!r} goes the long way round from {cut.low!r} to {cut.high!r}, {360 - 360 / count:g} of 360 degrees"
        raise ModelError(f"supports: body {told}; a sector is 360 degrees over a whole number")
    nodes, others = (facet_nodes(body.mesh, facets) for facets in (high, low))
    fixed, back, turned = (
        np.intersect1d(nodes, others),
        (x - centre) @ turn + centre,
        errors @ np.abs(turn),
    )
    off, nearest = (np.asarray(found) for found in cKDTree(x[others]).query(back[nodes]))
    allowed = np.linalg.norm(turned[nodes] + errors[others[nearest]], axis=1)
    match = len(nodes) == len(others) and (off <= allowed).all()
    if match:
        places = csr_matrix(
            (np.ones(len(nodes)), (np.arange(len(nodes)), others[nearest])),
            shape=(len(nodes), len(x)),
        )
    else:
        off = np.maximum(off, cKDTree(back[nodes]).query(x[others])[0].max())
        around, behind = facets_around(mesh, high), facets_around(mesh, low)
        overlaps = facet_overlaps(around, back, behind, x)
        if (
            faced(overlaps, back[around]).min() > FACED
            and overlaps.weights.sum() > _WHOLE * np.linalg.norm(areas_of(x[behind]), axis=1).sum()
        ):
            nodes = np.unique(around)
            places, _ = mortar_projection(overlaps, nodes, len(x))
            off = np.linalg.norm(back[nodes] - places @ x, axis=1)
            allowed = (
                np.linalg.norm(turned[nodes] + abs(places) @ errors, axis=1)
                + sag(around, back, turned)[nodes]
            )
            allowed += np.maximum.reduceat(
                sag(behind, x, errors)[places.indices], places.indptr[:-1]
            )
    far = np.r_[
        off - allowed,
        np.linalg.norm(back[fixed] - x[fixed], axis=1)
        - np.linalg.norm(turned + errors, axis=1)[fixed],
    ]
    if far.max() > 0:
        aside = (
            f"; their middles are {np.degrees(angle):.6g} degrees apart"
            if abs(abs(angle) * count - 2 * np.pi) > SAME_POINT
            else ""
        )
        raise ModelError(
            f"supports: the faces {cut.high!r} and {cut.low!r} of body {cut.body!r} are no turned copies of each other: turned by 360/{count} "
            f"degrees about the axis, they are up to {off.max():.4g} apart, more than {allowed.max():.1g}{aside}; give two that are, 360 degrees "
            "over a whole number apart, and check axis and centre"
        )
    own, copies = ~np.isin(nodes, fixed), np.full(len(x), -1)
    nodes, places = nodes[own], csr_matrix(places[own])
    if match:
        copies[nodes] = places.indices
    unlike = {} if match else {cut.body: np.r_[low, high]}
    return Sector(
        nodes, places, copies, fixed, turn, centre - turn @ centre, along[:d], count, unlike
    )


def _middle(corners: Array) -> Array:
    """(d,) the middle of the area of facets (facets, corners, d)."""
    sizes = np.linalg.norm(areas_of(corners), axis=1)
    return np.asarray(sizes @ corners.mean(axis=1) / sizes.sum())


def on_seam(
    mass: csr_matrix, moments: Sequence[Array], entries: Sequence[int], seam: Seam
) -> list[Array]:
    """Nodal components of a symmetric tensor by their moments with the functions of the nodes; those of nodes that copy others are turned.

    The entries are the numbers of the components in a matrix of three rows. A mass is well
    conditioned: conjugate gradients take few steps.
    """
    (high, low, turn), (a, b), n = seam, np.divmod(entries, 3), mass.shape[0]
    Q, whole, follows, turns = (
        np.eye(3),
        np.zeros((n, 3, 3)),
        np.arange(n),
        np.tile(np.eye(9), (n, 1, 1)),
    )
    Q[: len(turn), : len(turn)], whole[:, a, b], whole[:, b, a] = (
        turn,
        np.transpose(moments),
        np.transpose(moments),
    )
    follows[high], turns[high] = low, np.kron(Q, Q)
    leads = identity(n, format="csr")[follows][:, np.delete(np.arange(n), high)]
    spread, scale = (
        csr_matrix(blocks_of(turns) @ kron(leads, identity(9))),
        np.repeat(leads.T @ mass.diagonal(), 9),
    )
    spread.eliminate_zeros()  # it gives all values by those of nodes that copy none
    M = LinearOperator(
        (len(scale),) * 2,
        matvec=lambda z: spread.T @ (mass @ (spread @ z).reshape(n, 9)).ravel(),
        dtype=np.float64,
    )
    found = (
        spread @ cg(M, spread.T @ whole.ravel(), rtol=ROUNDING, M=diags(1 / scale))[0]
    ).reshape(whole.shape)
    return [found[:, i, j] for i, j in zip(a, b, strict=True)]
