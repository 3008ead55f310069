"""The bodies of a model in one numbering: stiffness, supports, and pairs of nodes."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags, identity, kron, vstack

from ..base import (
    COUNTS,
    ROUNDING,
    Array,
    Booleans,
    Integers,
    choice,
    number_of,
    place,
    shown,
)
from ..errors import ModelError
from .adjusting import adjusted, notes_on_moves
from .bodies import Body, numbered_nodes, on_axis
from .bolts import BoltPreload, Cut, cut_bodies, joined_by_elements, released
from .coincidence import coincide
from .contacts import Contact, Tie, contact_names, followers_of, independent_pairs
from .couplings import Coupling, coupled
from .elasticity import Kinematics, body_stiffness, midside_ties
from .interface import interface_of, openings
from .loads import Displacement
from .mortar import Joint, check_touching, faces_of, join_faces, normals_into, resultants
from .rigid import Glued, assemblies, glued_bodies, node_graph
from .sector import Cyclic, sector_of
from .supports import Support, nodes_of


class Assembly:
    """The parts of a `ContactModel`, assembled.

    Nodes are numbered body after body. The unknowns are the displacements along x, y (and z) of the
    first node, then those of the next.

    Attributes
    ----------
    own_nodes
        Body -> numbers of its nodes.
    points, errors, numbers
        (nodes, d) coordinates, their (nodes, d) errors, and the (nodes,) numbers of the nodes in
        error messages, see `Body.numbers`.
    rows
        (nodes, d) unknown of each displacement along the axes.
    free_rows
        (nodes, d) unknown of each displacement: -1 if a support holds it, -2 if it follows other
        displacements. Supports are marked first, then ties, then cuts.
    tied
        Matrix by which dependent displacements follow others. Displacements are dependent at
        midside nodes of contact faces, at nodes of ties and couplings, and on cut faces of sectors.
    of_ties, followers
        The nodes of each tie with their places, and all nodes that follow others in ties.
    joints
        The joined faces of each contact.
    pairs
        The `Interface` of N pairs. A corner of several contacts is in several pairs, if their
        motions are independent.
    contact, gap, width
        (N,) number of the contact, initial gap and width of each pair.
    untied
        (N, nodes) matrix of the openings of the pairs if there were no ties.
    sides
        Two (N, nodes) matrices for the pairs: their nodes of body 1, and their places on body 2.
    held
        The pairs that are left out because both sides are held: their nodes of body 1, and their
        openings.
    cuts
        The cut sections of bolts.
    notes
        Sentences on what the model does beyond what its arguments say.
    """

    def __init__(
        self,
        bodies: Mapping[str, Body],
        supports: Sequence[Support | Cyclic | Coupling],
        contacts: Sequence[Contact],
        ties: Sequence[Tie],
        bolts: Sequence[BoltPreload],
        kinematics: Kinematics,
    ) -> None:
        cut, cuts = cut_bodies(bodies, bolts, kinematics)
        self.ties = ties
        self.bodies, self.of_ties, self.touching, self.notes = adjusted(cut, ties, contacts)
        self.kinematics = kinematics
        self.supports = [support for support in supports if isinstance(support, Support)]
        cyclic = [support for support in supports if isinstance(support, Cyclic)]
        self.couplings = [support for support in supports if isinstance(support, Coupling)]
        self.sector = sector_of(cyclic, self.bodies, kinematics)
        open_ring = self.bodies
        self.bodies = self.sector.closed(open_ring)
        self.notes += notes_on_moves("sector", open_ring, self.bodies)
        self._number_nodes()
        self.names = contact_names(contacts)
        self.followers = followers_of(ties, self.of_ties, self.own_nodes)
        self.joints = self._joined_faces(contacts, ties)
        self._hold_nodes()
        self.tied = self._ties(contacts, ties)
        self._make_pairs(contacts)
        self.cuts = self._closed_cuts(cuts)

    @cached_property
    def whole(self) -> csr_matrix:
        """Stiffness of the separate bodies: dependent nodes follow others, and cuts are open."""
        parts = [
            body_stiffness(body.mesh, body.material, body.element, self.kinematics)
            for body in self.bodies.values()
        ]
        return csr_matrix(self.tied.T @ block_diag(parts, format="csr") @ self.tied)

    @cached_property
    def release(self) -> tuple[csr_matrix, csr_matrix]:
        """Matrices R and D of `u = R y + D F`, with loads F on the bodies, see `released`."""
        return released(self.whole, self.rows, self.cuts)

    @cached_property
    def glued(self) -> Glued:
        """The glued bodies; at each cut, the two faces are tied across the axis of the bolt."""
        K = self.whole
        if self.cuts:
            R = self.release[0]
            K = csr_matrix(R.T @ self.whole @ R)
        return glued_bodies(K, self.free_rows, self.points, self.pairs, self._name_of_node)

    def through_ties(self, forces: Array, reactions: Array) -> dict[str, Array]:
        """Tie -> (3, n) normal force, shear and moment (`resultants`) of body 2 on body 1.

        In each of n states, `forces` (size, n) push the faces apart, and `reactions` (d N, n) act
        in the contacts; the reactions are needed because a node of a tie may also be in a contact.
        Supports carry the forces on the nodes that they hold.
        """
        by_pairs = kron(self.untied.T, identity(self.points.shape[1]))
        of_contacts = by_pairs @ (self.glued.interface.frames_to_axes @ reactions)
        of_ties = (forces - of_contacts).reshape(*self.rows.shape, -1)
        of_ties[self.free_rows == -1] = 0.0
        through = {}
        # All nodes of a tie may already belong to earlier ties.
        for number in np.unique(self.followers.tie[self.followers.nodes]):
            tie = self.ties[number]
            face, _ = faces_of(tie, self.bodies)
            nodes = np.flatnonzero(self.followers.tie == number)
            own = nodes - self.own_nodes[tie.body_1][0]
            # Two ties of the same faces may differ in their tolerance.
            name = f"{tie.name} {number + 1}" if tie.name in through else tie.name
            through[name] = resultants(face, own, of_ties[nodes])
        return through

    def body(self, argument: str, name: str) -> Body:
        """The body with this name; `argument` is for the error message."""
        return self.bodies[choice(f"{argument}: body", name, self.bodies)]

    def nodes(self, argument: str, part: Support | Displacement) -> Integers:
        """Nodes that a support holds, or a displacement moves."""
        nodes = nodes_of(self.body(argument, part.body), part.body, part.where)
        return self.own_nodes[part.body][nodes]

    def axes(self, argument: str, body: str, directions: str | None) -> list[int]:
        """Numbers of the axes in `directions`, such as "xz"; None: all axes."""
        d = self.points.shape[1]
        if d == 2 and "z" in (directions or ""):
            raise ModelError(
                f"{argument}: directions {shown(directions)} of body {body!r}, which is plane; "
                "give x and y alone"
            )
        return ["xyz".index(direction) for direction in directions or "xyz"[:d]]

    def check_ends(self) -> None:
        """Check that contacts join both ends of each cut bolt, or that supports hold both ends."""
        if not self.cuts:
            return
        # Nodes in couplings may have no stiffness left in the matrix, but elements still join them.
        meshes = [body.mesh for body in self.bodies.values()]
        graph = node_graph(self.whole, self.rows) + joined_by_elements(meshes)
        part = assemblies(graph, self.pairs)
        for cut in self.cuts:
            ends = {int(part[cut.near[0]]), int(part[cut.far[0]])}
            for end in ends if len(ends) > 1 else ():
                nodes = np.flatnonzero(part == end)
                by_supports = (self.free_rows[nodes][:, cut.along] == -1).any()
                if not by_supports and not self.coupled.hold(nodes, cut.axis):
                    raise ModelError(
                        f"bolt {cut.bolt.body!r}: nothing holds the part around "
                        f"{place(self.points[nodes].mean(axis=0))} against the force along the "
                        "axis; add the Contact of the head or the nut there, or a Support"
                    )

    def _number_nodes(self) -> None:
        """Number nodes and unknowns, body after body."""
        self.own_nodes = numbered_nodes(self.bodies)
        self.points = np.concatenate([body.mesh.p.T for body in self.bodies.values()])
        self.rows: Integers = np.arange(self.points.size).reshape(self.points.shape)
        self.errors = np.concatenate([body.errors for body in self.bodies.values()])
        self.numbers = np.concatenate([body.numbers for body in self.bodies.values()])

    def _name_of_node(self, node: int) -> str:
        """A node in words: its number in the mesh or deck, and its body."""
        owner = next(name for name, own in self.own_nodes.items() if node in own)
        return f"node {self.numbers[node]} of body {owner!r}"

    def _joined_faces(self, contacts: Sequence[Contact], ties: Sequence[Tie]) -> list[Joint]:
        """Join the faces of each contact, and check that touching faces have a contact or a tie."""
        faces = [faces_of(contact, self.bodies) for contact in contacts]
        joints = []
        touched = defaultdict[tuple[str, str], list[Integers]](list)
        of_contacts = zip(
            contacts, faces, normals_into(contacts, faces), self.touching, strict=True
        )
        for contact, both, normals, touching in of_contacts:
            joint = join_faces(contact, *both, normals, touching, self.kinematics)
            joints.append(joint)
            touched[contact.body_1, contact.body_2].append(joint.opposite)
            touched[contact.body_2, contact.body_1].append(joint.projection.indices)
        for tie, of_tie in zip(ties, self.of_ties, strict=True):
            touched[tie.body_1, tie.body_2].append(of_tie.nodes)
            touched[tie.body_2, tie.body_1].append(of_tie.places.indices)
        check_touching(self.bodies, touched)
        return joints

    def _hold_nodes(self) -> None:
        """Set `free_rows` according to the supports."""
        held = np.zeros(self.points.shape, dtype=bool)
        if self.kinematics == "axisymmetric":
            held[on_axis(self.points[:, 0]), 0] = True
        held[np.ix_(self.sector.fixed, self.sector.across)] = True
        for support in self.supports:
            axes = self.axes("supports", support.body, support.directions)
            held[self.nodes("supports", support)[:, None], axes] = True
        self.free_rows = np.where(held, -1, self.rows)

    def _ties(self, contacts: Sequence[Contact], ties: Sequence[Tie]) -> csr_matrix:
        """Matrix `tied`: which displacements follow others, and by how much.

        Midside nodes of contact faces follow corner nodes, nodes of ties follow the opposite face,
        nodes of couplings follow each other, and the cut faces of sectors follow the opposite cut
        faces. Displacements that a support holds stay held; dependent displacements are marked in
        `free_rows`.
        """
        links = block_diag(self._midside_ties([*contacts, *ties]), format="csr")
        has_corners = (np.diff(links.indptr) > 0).reshape(self.rows.shape)
        midside = np.flatnonzero(has_corners.any(axis=1))
        for support in self.supports:
            is_point = isinstance(support.where, tuple)
            if is_point and np.isin(self.nodes("supports", support), midside).any():
                raise ModelError(
                    f"supports: {support} is a midside node of a contact face, which follows the "
                    "corners; hold corners"
                )
        follows = has_corners & (self.free_rows >= 0)
        self.free_rows[follows] = -2
        moves = follows.ravel().astype(float)
        by_corners = diags(1 - moves) + diags(moves) @ links
        held = self.free_rows < 0
        by_ties = self.followers.motion(held, self.sector.on_cuts, self.points)
        tied = self.followers.nodes
        self.free_rows[tied] = np.where(held[tied], -1, -2)
        by_couplings = self._couple(contacts, midside)
        by_sector = self.sector.follow(self.free_rows, self.points)
        return csr_matrix(by_corners @ by_ties @ by_couplings @ by_sector)

    def _couple(self, contacts: Sequence[Contact], midside: Integers) -> csr_matrix:
        """Matrix by which nodes of couplings follow each other. `free_rows` marks these nodes."""
        if self.couplings and self.sector.count > 1:
            raise ModelError(
                f"supports: {self.couplings[0]} beside a Cyclic; a coupling cannot include nodes "
                "of other sectors: model the whole ring, or use a Support"
            )
        _, nodes, projection, *_ = self._all_pairs(contacts)
        self.coupled = coupled(
            self.couplings,
            self.bodies,
            self.own_nodes,
            self.free_rows >= 0,
            np.r_[midside, self.followers.nodes, nodes, projection.indices],
            self.points,
            self.kinematics,
        )
        matrix = self.coupled.matrix
        bound = matrix.diagonal() == 0
        follows = np.diff(matrix.indptr)[bound] > 0
        self.free_rows.ravel()[bound] = np.where(follows, -2, -1)
        return matrix

    def _midside_ties(self, contacts: Sequence[Contact | Tie]) -> list[csr_matrix]:
        """For each body, the matrix by which midside nodes on contacts and ties follow corners."""
        faces = {name: [np.zeros(0, int)] for name in self.bodies}
        for contact in contacts:
            for name, boundary in (
                (contact.body_1, contact.boundary_1),
                (contact.body_2, contact.boundary_2),
            ):
                faces[name].append(self.bodies[name].boundary(boundary, "contacts"))
        return [
            midside_ties(
                self.bodies[name].mesh,
                np.unique(np.concatenate(facets)),
                f"contacts: body {name!r}",
            )
            for name, facets in faces.items()
        ]

    def _make_pairs(self, contacts: Sequence[Contact]) -> None:
        """Make the pairs of all contacts, contact after contact."""
        pairs_once = self.sector.once(
            self.names, self._all_pairs(contacts), self.points, self.errors
        )
        number, nodes, projection, normals, widths, gap, inside = self._that_move(pairs_once)

        # Node of body 2 that coincides with the node of body 1; -1 if there is no such node.
        links = projection.tocoo()
        node = nodes[links.row]
        coincides = coincide(
            self.points[links.col] - self.points[node], self.errors[links.col] + self.errors[node]
        )
        partners = np.full(len(nodes), -1)
        partners[links.row[coincides]] = links.col[coincides]

        same = self.followers.same
        pairs, means, normals = independent_pairs(
            contacts,
            number,
            same[nodes],
            np.where(partners < 0, -1, same[partners]),
            self.points[nodes],
            self.errors[nodes],
            normals,
            widths,
            inside,
        )
        self.untied = csr_matrix(means @ openings(nodes, projection))
        opening = csr_matrix(self.untied @ self.followers.matrix)
        opening.data[np.abs(opening.data) <= ROUNDING] = 0.0
        opening.eliminate_zeros()
        self.pairs = interface_of(
            nodes[pairs],
            opening,
            self.free_rows,
            normals,
            self.points,
            self.errors,
            self.numbers,
        )
        self.sides = (
            identity(len(self.points), format="csr")[nodes[pairs]],
            projection[pairs],
        )
        self.contact = number[pairs]
        self.gap = means @ gap
        # At the tip of a crack both faces share a node, which adds no width to the next pair.
        self.width = (means > 0) @ np.where(nodes == partners, 0.0, widths)

    def _all_pairs(self, contacts: Sequence[Contact]) -> tuple[Any, ...]:
        """Contact, node of body 1, place on body 2, normal, width and gap of all pairs.

        The last result is whether the node of body 1 lies opposite body 2.
        """
        nodes = []
        projections = []
        for contact, joint in zip(contacts, self.joints, strict=True):
            nodes.append(self.own_nodes[contact.body_1][joint.nodes])
            P = joint.projection
            columns = self.own_nodes[contact.body_2][P.indices]
            shape = (P.shape[0], len(self.points))
            projections.append(csr_matrix((P.data, columns, P.indptr), shape=shape))
        number = np.repeat(np.arange(len(contacts)), [len(own) for own in nodes])
        of_joints = (
            np.concatenate([getattr(joint, name) for joint in self.joints])
            for name in ("normals", "widths", "gap", "inside")
        )
        return number, np.concatenate(nodes), csr_matrix(vstack(projections)), *of_joints

    def _that_move(self, pairs: tuple[Any, ...]) -> tuple[Any, ...]:
        """The pairs that can move: supports or ties hold both sides of all other pairs.

        No load moves a pair that is held on both sides. Supports and ties carry its pressure and
        shear, so its width is not added to other pairs.
        """
        contact, nodes, projection, *_ = pairs
        weights = openings(nodes, projection)
        opening = weights @ self.followers.matrix
        is_free = (self.free_rows != -1).any(axis=1)
        # Rounding may join a held node to its neighbours by tiny weights. A node at a crack tip,
        # which both faces share, has no weights and counts as free.
        moves = abs(opening) @ is_free >= COUNTS * np.asarray(abs(weights).sum(axis=1)).ravel()
        self.held = nodes[~moves], opening[~moves]
        self._note_held(contact, nodes, moves)
        return tuple(part[moves] for part in pairs)

    def _note_held(self, contact: Integers, nodes: Integers, moves: Booleans) -> None:
        """Make a note of the pairs of each contact that cannot move; ModelError if none can.

        Arguments are, for each pair, the number of its contact, its node of body 1, and whether it
        moves.
        """
        for number, name in enumerate(self.names):
            held = nodes[~moves & (contact == number)]
            if not len(held):
                continue
            if not moves[contact == number].any():
                raise ModelError(
                    f"contacts: no pair of {name!r} can move, because supports or ties hold both "
                    "sides; leave the contact out, or hold fewer nodes"
                )
            listed = ", ".join(map(self._name_of_node, held.tolist()))
            count = number_of(len(held), "pair")
            self.notes.append(f"contact {name!r}: {count} that cannot move left out: {listed}")

    def _closed_cuts(self, cuts: Sequence[Cut]) -> list[Cut]:
        """The cuts in node numbers of the model; the far faces follow the near faces."""
        closed = []
        taken = np.r_[
            self.pairs.opening.indices,
            self.sector.on_cuts,
            self.coupled.nodes,
            self.followers.nodes,
        ]
        for cut in cuts:
            near, far = (self.own_nodes[cut.bolt.body][face] for face in (cut.near, cut.far))
            is_held = (self.free_rows[near][:, cut.along] < 0).any()
            if is_held or np.isin(taken, [near, far]).any():
                raise ModelError(
                    f"bolt {cut.bolt.body!r}: its section at "
                    f"{place(self.points[near].mean(axis=0))} has nodes on a cut of a sector, in a "
                    "contact, in another section, or held along the axis or by a coupling; put it "
                    "where the shank is free"
                )
            self.free_rows[far] = -2
            taken = np.r_[taken, near, far]
            closed.append(Cut(cut.bolt, near, far, cut.axis))
        return closed
