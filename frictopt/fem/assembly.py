"""The bodies of a model in one numbering: stiffness, loads, supports and pairs of nodes."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags, identity, vstack
from scipy.sparse.csgraph import connected_components

from ..base import ROUNDING, SAME_POINT, Array, Booleans, Integers, choice, first_of, place, shown
from ..contact.frames import frames_of
from ..errors import ModelError
from .bodies import Body
from .bolts import BoltPreload, Cut, cut_bodies, released
from .coincidence import mesh_errors, one_point
from .condense import Glued
from .contacts import Contact, Interference, check_touching, joined, normals_into, shares
from .cyclic import Cyclic, sector_of
from .elasticity import Kinematics, body_stiffness, midside_ties
from .interface import ASKEW, Interface, blocks_of, guided, openings, own_directions
from .loads import (
    BodyForce,
    Centrifugal,
    Displacement,
    Expansion,
    NodalForces,
    Pressure,
    Traction,
    values_at,
)
from .rigid import NO_ROWS, assemblies, free_motions, node_graph
from .supports import Support, along_axes, nodes_of, normals_along

Load: TypeAlias = (
    Traction
    | Pressure
    | BodyForce
    | Centrifugal
    | Expansion
    | Displacement
    | Interference
    | BoltPreload
    | NodalForces
)


class Assembly:
    """The parts of a `ContactModel`; all nodes are counted body after body, of each body all x displacements come first, then all y, and so on.

    `points` and `errors` are (nodes, d) coordinates and their errors, `rows` and `free_rows`
    unknowns, -1 where held, -2 where following others by the matrix `tied`, as nodes amid edges of
    contact faces do. Free rows are those along `directions` (nodes, d, d): of `oblique` nodes,
    which supports hold along other normals than the axes, their own. A corner of several contacts
    is in as many of the N pairs as move independently. The pairs have number of the contact, gap
    and width (N,), and `sides`, (N, nodes) matrices of the nodes of body 1, and of the places of
    body 2, that they lie at.
    """

    def __init__(
        self,
        bodies: Mapping[str, Body],
        supports: Sequence[Support | Cyclic],
        contacts: Sequence[Contact],
        bolts: Sequence[BoltPreload],
        kinematics: Kinematics,
    ) -> None:
        self.bodies, cuts = cut_bodies(bodies, bolts, kinematics)
        self.kinematics, self.supports = (
            kinematics,
            [support for support in supports if isinstance(support, Support)],
        )
        self.sector = sector_of(
            [support for support in supports if isinstance(support, Cyclic)],
            self.bodies,
            kinematics,
        )
        meshes = [body.mesh for body in self.bodies.values()]
        first = np.cumsum([0, *(mesh.p.shape[1] for mesh in meshes)]).tolist()
        self.first_node = dict(zip(bodies, first, strict=False))
        self.points = np.concatenate([mesh.p.T for mesh in meshes])
        self.errors = np.concatenate([mesh_errors(mesh) for mesh in meshes])
        own = [np.arange(mesh.p.size).reshape(mesh.p.shape).T for mesh in meshes]
        self.rows: Integers = np.concatenate(
            [
                len(mesh.p) * start + rows
                for start, mesh, rows in zip(first, meshes, own, strict=False)
            ]
        )
        self._join(contacts)
        self._hold()
        self.tied = self._tie(contacts)
        self._pair(contacts)
        self._open(cuts)

    @cached_property
    def whole(self) -> csr_matrix:
        """Stiffness of the separate bodies, midside nodes of contact faces tied, cuts open."""
        parts = [
            body_stiffness(body.mesh, body.material, body.element, self.kinematics)
            for body in self.bodies.values()
        ]
        return csr_matrix(self.tied.T @ block_diag(parts, format="csr") @ self.tied)

    @cached_property
    def release(self) -> tuple[csr_matrix, csr_matrix]:
        """Matrices R and D of `u = R y + D F`, the displacements under loads F on the bodies, see `released`; y are those of the free rows."""
        R, D = released(self.whole, self.rows, self.cuts)
        return self.turned(R), D

    def turned(self, R: csr_matrix) -> csr_matrix:
        """A matrix of displacements along the axes, with columns for those along `directions` instead."""
        if not len(self.oblique):
            return R
        by_rows = csr_matrix(
            (np.ones(self.rows.size), (np.arange(self.rows.size), self.rows.ravel())), shape=R.shape
        )
        return csr_matrix(R @ by_rows.T @ blocks_of(self.directions.swapaxes(1, 2)) @ by_rows)

    @cached_property
    def glued(self) -> Glued:
        """The bodies, with the faces of each cut tied across its axis, and their pairs, with normals that free bodies slide along."""
        K = (
            csr_matrix(self.release[0].T @ self.whole @ self.release[0])
            if self.cuts or len(self.oblique)
            else self.whole
        )
        rows, x, graph = self.free_rows, self.points, node_graph(K, self.free_rows)
        motions = free_motions(
            K,
            rows,
            x,
            connected_components(graph, directed=False)[1],
            directions=self.pairs.directions,
        )
        return Glued(
            K, rows, x, graph, self.pairs.sliding(motions, rows), motions, self._called, NO_ROWS
        )

    def body(self, argument: str, name: str) -> Body:
        """The body of that name."""
        return self.bodies[choice(f"{argument}: body", name, self.bodies)]

    def _called(self, node: int) -> str:
        """The number of a node in the mesh of its body, in words."""
        name, first = [(name, first) for name, first in self.first_node.items() if first <= node][
            -1
        ]
        return f"node {node - first} of body {name!r}"

    def axes(self, argument: str, name: str, directions: str | None) -> list[int]:
        """Numbers of some directions of a body, None: of all."""
        d = self.points.shape[1]
        if d == 2 and "z" in (directions or ""):
            raise ModelError(
                f"{argument}: directions {shown(directions)} of body {name!r}, which is plane; give x and y alone"
            )
        return ["xyz".index(direction) for direction in directions or "xyz"[:d]]

    def nodes(self, argument: str, part: Support | Displacement) -> Integers:
        """Nodes that a support holds, or a displacement moves."""
        return np.asarray(
            nodes_of(self.body(argument, part.body), part.body, part.where)
            + self.first_node[part.body]
        )

    def _hold(self) -> None:
        """Hold what supports hold; the nodes that one of them holds along an oblique normal have directions of their own."""
        d, held, oblique = (
            self.points.shape[1],
            np.zeros(self.points.shape, dtype=bool),
            defaultdict[int, list[Array]](list),
        )
        if self.kinematics == "axisymmetric":
            held[self.points[:, 0] == 0, 0] = True
        for support in self.supports:
            if not support.normal:
                held[
                    self.nodes("supports", support)[:, None],
                    self.axes("supports", support.body, support.directions),
                ] = True
        ways = self.sector.held()
        for name in dict.fromkeys(support.body for support in self.supports if support.normal):
            body, own = (
                self.body("supports", name),
                [support for support in self.supports if support.normal and support.body == name],
            )
            first, seam = self.first_node[name], self.sector.seam(self.first_node[name], body)
            ways += [(first + nodes, normals) for nodes, normals in normals_along(body, own, seam)]
        for nodes, normals in ways:
            straight, most = along_axes(normals)
            held[nodes[straight], most[straight]] = True
            for node, normal in zip(nodes[~straight].tolist(), normals[~straight], strict=True):
                oblique[node].append(normal)
        self.free_rows, self.directions = (
            np.where(held, -1, self.rows),
            np.tile(np.eye(d), (len(held), 1, 1)),
        )
        self.oblique = np.array(sorted(oblique), dtype=np.intp)
        for node, along in oblique.items():
            self.directions[node], count = own_directions([*along, *np.eye(d)[held[node]]])
            self.free_rows[node] = np.where(np.arange(d) < count, -1, self.rows[node])

    def _held(self, nodes: Integers, direction: Array, rows: Booleans) -> Booleans:
        """(n,) whether some nodes are held along a direction, or in part, of those of their rows (nodes, d) that are said."""
        return np.asarray(
            (rows[nodes] & (np.abs(self.directions[nodes] @ direction) > SAME_POINT)).any(axis=1)
        )

    def _join(self, contacts: Sequence[Contact]) -> None:
        """Join the nodes of each contact; none is forgotten."""
        self.names = [str(contact.name) for contact in contacts]
        if again := [name for i, name in enumerate(self.names) if name in self.names[:i]]:
            raise ModelError(f"contacts: two are called {again[0]!r}; give each a name")
        self.joints, touched = [], defaultdict[tuple[str, str], list[Integers]](list)
        bodies = {
            name: self.body("contacts", name).through_corners
            for contact in contacts
            for name in (contact.body_1, contact.body_2)
        }
        for contact, normals in zip(contacts, normals_into(contacts, bodies), strict=True):
            one, two = (bodies[name] for name in (contact.body_1, contact.body_2))
            self.joints.append(joint := joined(contact, one, two, normals, self.kinematics))
            touched[contact.body_1, contact.body_2].append(joint.nodes)
            touched[contact.body_2, contact.body_1].append(joint.projection.indices)
        check_touching(self.bodies, touched)

    def _tie(self, contacts: Sequence[Contact]) -> csr_matrix:
        """Let the midside nodes on contact faces follow, and the cut faces of sectors; what a support holds stays so."""
        faces = {name: [np.zeros(0, int)] for name in self.bodies}
        for contact in contacts:
            for name, boundary in (
                (contact.body_1, contact.boundary_1),
                (contact.body_2, contact.boundary_2),
            ):
                faces[name].append(self.bodies[name].boundary(boundary, "contacts"))
        for name, facets in self.sector.unlike.items():
            faces[name].append(facets)
        parts = [
            midside_ties(
                self.bodies[name].mesh, np.unique(np.concatenate(own)), f"contacts: body {name!r}"
            )
            for name, own in faces.items()
        ]
        links, unknowns = block_diag(parts).tocoo(), self.rows.ravel()
        for support in self.supports:
            if (
                not isinstance(support.where, str)
                and np.isin(
                    self.nodes("supports", support), links.row // self.points.shape[1]
                ).any()
            ):
                raise ModelError(
                    f"supports: {support} is a midside node of a contact face, which follows the corners; hold corners"
                )
        self._let_follow(links.row // self.points.shape[1], links.col // self.points.shape[1])
        free = self.free_rows.ravel()[links.row] >= 0
        row, column, follows = (
            unknowns[links.row[free]],
            unknowns[links.col[free]],
            np.zeros(len(unknowns)),
        )
        follows[row] = 1.0
        self.free_rows[follows[self.rows] > 0] = -2
        midside = csr_matrix(
            diags(1 - follows)
            + csr_matrix((links.data[free], (row, column)), shape=(len(follows),) * 2)
        )
        return csr_matrix(
            midside @ self.sector.follow(self.rows, self.free_rows, self.directions, self.points)
        )

    def _let_follow(self, midside: Integers, corners: Integers) -> None:
        """Let midside nodes that are held along oblique normals follow their corners, if these are held so: all stay in the plane."""
        held = self.free_rows < 0
        for node in np.intersect1d(midside, self.oblique).tolist():
            near = np.unique(corners[midside == node])
            along = np.einsum(
                "nk,nkw->nw",
                held[near],
                (self.directions[near] @ self.directions[node][held[node]].T) ** 2,
            )
            if along.min() < 1 - ASKEW:
                raise ModelError(
                    f"supports: the midside node at {place(self.points[node])} of a contact face follows the corners of the face, which are not held "
                    "along its normal; hold a plane, or mesh with linear elements"
                )
            self.free_rows[node], self.directions[node] = (
                self.rows[node],
                np.eye(self.points.shape[1]),
            )

    def _pair(self, contacts: Sequence[Contact]) -> None:
        """Make the pairs of all contacts, one contact after the other."""
        starts = [
            (self.first_node[contact.body_1], self.first_node[contact.body_2])
            for contact in contacts
        ]
        ones = np.concatenate(
            [start + joint.nodes for (start, _), joint in zip(starts, self.joints, strict=True)]
        )
        placed = [
            (joint.projection, start) for (_, start), joint in zip(starts, self.joints, strict=True)
        ]
        projection = csr_matrix(
            vstack(
                [
                    csr_matrix(
                        (P.data, i + P.indices, P.indptr), shape=(P.shape[0], len(self.points))
                    )
                    for P, i in placed
                ]
            )
        )
        number = np.repeat(np.arange(len(contacts)), [len(joint.nodes) for joint in self.joints])
        normals, widths, gap = (
            np.concatenate([getattr(joint, name) for joint in self.joints])
            for name in ("normals", "widths", "gap")
        )
        every = number, ones, projection, normals, widths, gap
        number, ones, projection, normals, widths, gap = self.sector.once(
            self.names, every, self.points, self.errors
        )
        links, others, node = (
            projection.tocoo(),
            np.full(len(ones), -1),
            ones[projection.tocoo().row],
        )
        lie = one_point(
            self.points[links.col] - self.points[node], self.errors[links.col] + self.errors[node]
        )
        others[links.row[lie]] = links.col[lie]
        kept, means, normals = shares(
            contacts, number, ones, others, self.points[ones], normals, widths, self.errors[ones]
        )
        opening = csr_matrix(means @ openings(ones, projection))
        directions = self.directions if len(self.oblique) else None
        normals, ways, able = guided(
            ones[kept], opening, self.free_rows, normals, self.points, self.errors, directions
        )
        self.pairs = Interface(ones[kept], opening, frames_of(normals, ways), able, directions)
        self.sides = identity(len(self.points), format="csr")[ones[kept]], projection[kept]
        self.contact, self.gap, self.width = (
            number[kept],
            np.asarray(means @ gap),
            np.asarray((means > 0) @ np.where(ones == others, 0.0, widths)),
        )

    def _open(self, cuts: Sequence[Cut]) -> None:
        """Let the far faces of cuts follow the near ones."""
        self.cuts, taken = [], np.r_[self.pairs.opening.indices, self.sector.on_cuts]
        for cut in cuts:
            near, far = (self.first_node[cut.bolt.body] + face for face in (cut.near, cut.far))
            if (
                self._held(near, cut.axis, self.free_rows < 0).any()
                or np.isin(taken, [near, far]).any()
            ):
                raise ModelError(
                    f"bolt {cut.bolt.body!r}: its section at {place(self.points[near].mean(axis=0))} has nodes on a cut of a sector, in a contact, "
                    "in another section, or held along the axis; put it where the shank is free"
                )
            self.free_rows[far], taken = -2, np.r_[taken, near, far]
            self.cuts.append(Cut(cut.bolt, near, far, cut.axis))

    def check_ends(self) -> None:
        """Check that contacts join what lies on either side of a cut, or that supports hold both along its axis."""
        part = (
            assemblies(node_graph(self.whole, self.rows), self.pairs) if self.cuts else np.zeros(0)
        )
        for cut in self.cuts:
            ends = {int(part[cut.near[0]]), int(part[cut.far[0]])}
            for end in ends if len(ends) == 2 else ():
                if not self._held(
                    np.flatnonzero(part == end), cut.axis, self.free_rows == -1
                ).any():
                    raise ModelError(
                        f"bolt {cut.bolt.body!r}: nothing holds what is around {place(self.points[part == end].mean(axis=0))} against the force "
                        "along the axis; add the Contact of the head or the nut there, or a Support"
                    )

    def case(self, argument: str, parts: Sequence[Load]) -> tuple[Array, Array, Array]:
        """Nodal forces (size,), displacements (size,) that are given with all else at rest, and overlaps (N,).

        Given are those of moved supports, of what is glued to them, and of the far face of a locked
        bolt, by a shortening of 1.
        """
        forces, moved, amounts = (
            np.zeros(self.points.size),
            np.full(self.points.size, np.nan),
            dict.fromkeys(self.names, 0.0),
        )
        for part in parts:
            if isinstance(part, Interference):
                amounts[choice(f"{argument}: contact", part.contact, amounts)] += part.amount
            elif isinstance(part, Displacement):
                self._move(argument, part, moved)
            elif not (isinstance(part, BoltPreload) and part.locked):
                body, first = (
                    self.body(argument, part.body),
                    self.points.shape[1] * self.first_node[part.body],
                )
                if isinstance(part, Traction | Pressure):
                    body.boundary(part.boundary, argument)
                forces[first : first + body.mesh.p.size] += part._forces(
                    body, self.kinematics
                ).ravel()
        forces = self.tied.T @ forces
        self._check_felt(argument, parts, forces)
        moved = self._followed(argument, moved, parts)
        for cut in self.cuts:
            moved[self.rows[cut.far]] = moved[self.rows[cut.near]] - cut.axis * (
                cut.bolt.locked and cut.bolt in parts
            )
        return forces, moved, np.array(list(amounts.values()))[self.contact]

    def _followed(self, argument: str, moved: Array, parts: Sequence[Load]) -> Array:
        """Displacements (size,) of supports, nan where none is given, and of what is glued to them."""
        self.sector.check_moved(
            argument, moved[self.rows], (self.tied @ np.nan_to_num(moved))[self.rows], self.points
        )
        self.sector.check_loads(argument, parts)
        given, moved = ~np.isnan(moved), np.nan_to_num(moved)
        if not moved.any():
            return moved
        following, _, Q = self.pairs.followers
        rows = self.rows[following]
        follow, whole = Q @ moved[self.rows], Q @ (self.free_rows < 0)
        differs = (
            np.abs(moved[rows] * whole - follow) > ROUNDING * np.abs(moved).max()
        )  # on a plane of symmetry from the nodes on it
        if (i := first_of((given[rows] & differs).any(axis=1))) is not None:
            at = place(self.points[following[i]])
            raise ModelError(
                f"{argument}: a displacement moves both bodies at {at}, in different ways; give one to both"
            )
        moved[rows] = np.where(given[rows], moved[rows], follow)
        return moved

    def _check_felt(self, argument: str, parts: Sequence[Load], forces: Array) -> None:
        """Check that supports do not take all of a load case of boundaries where it acts."""
        named = [
            (part.body, part.boundary) for part in parts if isinstance(part, Traction | Pressure)
        ]
        along = np.einsum("nka,na->nk", self.directions, forces[self.rows])
        felt, most = np.abs(along[self.free_rows != -1]).max(initial=0.0), np.abs(forces).max()
        if len(named) == len(parts) and felt <= ROUNDING * most and most > 0:
            own = [support for support in self.supports if support.body in dict(named)]
            at = " and ".join(f"{name!r} of body {body!r}" for body, name in named)
            raise ModelError(
                f"{argument}: acts on boundary {at} only where supports hold it, {own}; load another boundary, or hold less"
            )

    def _move(self, argument: str, part: Displacement, moved: Array) -> None:
        """Enter a displacement into those of all unknowns, nan where none is given."""
        nodes = self.nodes(argument, part)
        for name, amount in ((name, getattr(part, name)) for name in "xyz"):
            if amount is None:
                continue
            (axis,) = self.axes(argument, part.body, name)
            if np.isin(nodes, self.oblique).any():
                raise ModelError(
                    f"{argument}: {part} moves nodes that a Support holds along oblique normals; hold them along x, y or z"
                )
            unknowns, values = (
                self.rows[nodes, axis],
                values_at(f"displacement {name}", amount, self.points[nodes].T),
            )
            if np.any(self.free_rows[nodes, axis] != -1):
                raise ModelError(
                    f"{argument}: {part} moves nodes in {name} that no support holds; hold them by a Support"
                )
            if (
                self.kinematics == "axisymmetric"
                and axis == 0
                and (off := values[(self.points[nodes, 0] == 0) & (values != 0)]).size
            ):
                raise ModelError(
                    f"{argument}: {part} moves nodes by {off[0]:g} off the axis, x = 0; give a function of x that is zero there"
                )
            if (
                i := first_of(~np.isnan(moved[unknowns]) & (moved[unknowns] != values))
            ) is not None:
                at = place(self.points[nodes[i]])
                raise ModelError(
                    f"{argument}: {part} and another displacement move the node at {at} differently in {name}; give one"
                )
            moved[unknowns] = values
