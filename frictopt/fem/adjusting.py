"""Moves nodes of contacts onto the opposite face before assembly, without strain.

Coordinates of meshes have noise, and meshes of round faces overlap a little. `Contact.adjust`
corrects both, like the position tolerance or the adjustment of other codes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import Mesh

from ..base import Array, Integers, first_of, number_of, place
from ..errors import ModelError
from .bodies import Body, check_elements
from .contacts import Contact, Tie, Tied
from .elasticity import corner_weights
from .faces import Face, mortar_projection, unit_vectors
from .mortar import edge_length, faces_of, facing, sags, without_slivers
from .normals import Planes, node_normals
from .supports import Place, nodes_of

# Limits of moves, relative to the shortest edge at the node.

# A larger move would change the elements.
_LARGEST_MOVE = 0.1
# The nodes of a face move into one plane only if no move exceeds this limit. A face that needs
# larger moves may be curved.
_INTO_PLANE = 0.02
# Two nodes of matching meshes are at most this far apart.
_SAME_NODE = 0.01
# The overlap of two faces is even if it varies along the contact by at most this share of its mean.
_EVEN = 0.01
# Tolerance of ties, relative to the mean edge, as in CalculiX.
_TIED = 0.025


def adjusted(
    bodies: Mapping[str, Body], ties: Sequence[Tie], contacts: Sequence[Contact]
) -> tuple[dict[str, Body], list[Tied], list[Integers], list[str]]:
    """The bodies after the moves, the nodes of each tie, the nodes that touch, and notes.

    The nodes that touch belong to body 1 of each contact. A node that belongs to several contacts
    moves only along the faces of the earlier contacts.
    """
    moves = _Moves(bodies)
    tied = [moves.tie(tie) for tie in ties]
    touching = [
        np.zeros(0, dtype=np.intp) if contact.adjust is None else moves.fit(contact, contact.adjust)
        for contact in contacts
    ]
    notes = [*moves.notes, *notes_on_moves("adjust", bodies, moves.bodies)]
    return moves.bodies, tied, touching, notes


def even_overlap(contact: Contact, bodies: Mapping[str, Body]) -> float:
    """Depth by which the faces of a contact overlap; 0 if the depth varies along them."""
    distance = _Moves(bodies).measured(contact, 0.0).distance
    depth = -float(distance.mean())
    noise = sum(float(bodies[name].errors.max()) for name in (contact.body_1, contact.body_2))
    is_even = np.abs(distance + depth).max() <= noise + _EVEN * depth
    return depth if is_even and depth > noise else 0.0


def notes_on_moves(cause: str, before: Mapping[str, Body], after: Mapping[str, Body]) -> list[str]:
    """A note for each body with corner nodes that have moved: how many, and by how much.

    ModelError if a node moves by too large a share of its shortest edge, or if an element is no
    longer valid.
    """
    notes = []
    for name, body in before.items():
        argument = f"{cause}, body {name!r}"
        moved = after[name].mesh
        count = moved.nvertices
        length = np.linalg.norm(moved.p - body.mesh.p, axis=0)[:count]
        length[length <= np.linalg.norm(body.errors[:count], axis=1)] = 0.0
        if not length.any():
            continue
        edge = _shortest_edges(body.mesh)
        if (i := first_of(length > _LARGEST_MOVE * edge, length / edge)) is not None:
            raise ModelError(
                f"{argument}: node {body.numbers[i]} at {place(body.mesh.p[:, i])} would move by "
                f"{length[i]:.3g}, and an element there has an edge of {edge[i]:.3g}; a node may "
                f"move by {_LARGEST_MOVE:g} of the shortest edge: reduce the tolerance, or repair "
                "the mesh"
            )
        check_elements(moved)
        nodes = number_of(int(np.count_nonzero(length)), "node")
        notes.append(f"{argument}: {nodes} moved, by up to {length.max():.3g}")
    return notes


def _shortest_edges(mesh: Mesh) -> Array:
    """(corner nodes,) at each node, the shortest distance between two corners of an element."""
    corners = mesh.p[:, mesh.t]  # (d, corners, elements)
    distance = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=0)
    size = float(np.ptp(mesh.p, axis=1).max())
    distance[distance == 0] = size  # a corner and itself, or a repeated corner
    edge = np.full(mesh.nvertices, size)
    shortest = distance.min(axis=(0, 1))
    for nodes in mesh.t:
        np.minimum.at(edge, nodes, shortest)
    return edge


class _Measured(NamedTuple):
    """Distances (n,) from nodes of face 1, at `points` (n, d), to face 2 along `normals` (n, d).

    On round faces, a node may miss the opposite facets by its `sag` (n,).
    """

    face_2: Face
    nodes: Integers
    points: Array
    normals: Array
    distance: Array
    sag: Array


class _Moves:
    """Bodies whose nodes move, contact after contact."""

    def __init__(self, bodies: Mapping[str, Body]) -> None:
        self.bodies = dict(bodies)
        d = next(iter(bodies.values())).mesh.dim()
        self._planes = Planes(d)
        self._axes = list(np.eye(d))
        # Orthonormal directions in which a node of a body must not move any more.
        self._fixed: dict[tuple[str, int], list[Array]] = {}
        self.notes = list[str]()

    def tie(self, tie: Tie) -> Tied:
        """Move nodes of face 1 to their places on face 2; return the nodes within the tolerance.

        A second pass finds the places of the nodes after the first move. A node that would spoil
        its elements stays, and is glued where it is.
        """
        for _ in range(1 + tie.adjust):
            face_1, face_2, nodes, P = self._placed(tie)
            off = face_1.points[nodes] - P @ face_2.points
            tolerance = tie.tolerance or _TIED * edge_length(face_1.corners)
            sag = sags(face_1, face_2, nodes, P)
            distance = np.linalg.norm(off, axis=1)
            near = distance <= tolerance + sag
            if not near.any():
                raise ModelError(
                    f"ties: {tie.title}: no node of the face of body {tie.body_1!r} lies within "
                    f"{tolerance:.3g} of the other face; give a larger tolerance, or exchange the "
                    "faces"
                )
            edge = _shortest_edges(self.bodies[tie.body_1].mesh)[nodes]
            too_far = near & (distance > _LARGEST_MOVE * edge)
            if tie.adjust:
                moves = near & ~too_far
                places = face_1.points[nodes[moves]] - off[moves]
                normals = unit_vectors(off[moves])
                self._move(tie.body_1, nodes[moves], places, normals, stays=False)
        if too_far.any():
            count = number_of(int(np.count_nonzero(too_far)), "node")
            farthest = distance[too_far].max()
            self.notes.append(f"{tie.title}: {count} glued at a distance, of up to {farthest:.3g}")
        # From now on these nodes stay where they are: later moves would part the faces again.
        for name, face_nodes in ((tie.body_1, nodes[near]), (tie.body_2, face_2.facets.ravel())):
            self._fixed.update(dict.fromkeys(((name, k) for k in face_nodes.tolist()), self._axes))
        others = np.setdiff1d(face_1.facets, nodes[near])
        return Tied(nodes[near], P[near], len(others), tolerance)

    def fit(self, contact: Contact, adjust: float | Place) -> Integers:
        """Move nodes of body 1 onto body 2, and return the nodes that touch afterwards."""
        tolerance = adjust if isinstance(adjust, float) else 0.0
        face_2, nodes, points, normals, distance, sag = self.measured(contact, tolerance)
        edge = _shortest_edges(self.bodies[contact.body_1].mesh)
        if isinstance(adjust, float):
            touches = distance <= tolerance + sag
        else:
            chosen = nodes_of(self.bodies[contact.body_1], contact.body_1, adjust)
            touches = np.isin(nodes, chosen)
        moves = touches & (np.abs(distance) > sag)
        places = points - (moves * distance)[:, None] * normals

        corners = np.unique(face_2.facets)
        off, nearest = cKDTree(face_2.points[corners]).query(places)
        same = touches & (off <= np.minimum(tolerance, _SAME_NODE * edge[nodes]))
        places[same] = face_2.points[corners[nearest[same]]]
        self._move(contact.body_1, nodes[touches], places[touches], normals[touches])
        return nodes[touches]

    def measured(self, contact: Contact, tolerance: float) -> _Measured:
        """The distances of a contact, after a nearly plane face 2 has been made plane."""
        _, face_2 = faces_of(contact, self.bodies)
        is_plane = self._straighten(contact.body_2, face_2, tolerance)
        face_1, face_2, nodes, P = self._placed(contact)
        points = face_1.points[nodes]
        inward = node_normals(face_2, self._planes)
        normals = -unit_vectors(P @ unit_vectors(inward))
        distance = np.sum((points - P @ face_2.points) * normals, axis=1)
        sag = np.zeros(len(nodes))
        if not is_plane:
            sag = sags(face_1, face_2, nodes, P)
        return _Measured(face_2, nodes, points, normals, distance, sag)

    def _placed(self, part: Contact | Tie) -> tuple[Face, Face, Integers, csr_matrix]:
        """Both faces, the nodes of face 1 that lie opposite face 2, and their places there."""
        face_1, face_2 = faces_of(part, self.bodies)
        overlaps, share = facing(face_1, face_2, part)
        overlaps, opposite, _ = without_slivers(overlaps, face_1, share)
        nodes = np.unique(opposite.facets)
        return face_1, face_2, nodes, mortar_projection(overlaps, nodes, len(face_2.points))[0]

    def _straighten(self, name: str, face: Face, tolerance: float) -> bool:
        """Move the nodes of a face of body 2 into one plane, if the face is nearly plane.

        Returns whether the face is now plane.
        """
        nodes = np.unique(face.facets)
        edge = _shortest_edges(self.bodies[name].mesh)[nodes].min()
        most = min(tolerance, _INTO_PLANE * edge)
        errors = np.maximum(face.errors, most / 2)
        normal = self._planes.normal_of(replace(face, errors=errors), askew=np.inf)
        if normal is None:
            return False
        if tolerance > 0:
            heights = face.points[nodes] @ normal
            middle = (heights.min() + heights.max()) / 2
            places = face.points[nodes] + np.outer(middle - heights, normal)
            self._move(name, nodes, places, np.tile(normal, (len(nodes), 1)))
        return True

    def _move(
        self, name: str, nodes: Integers, places: Array, normals: Array, *, stays: bool = True
    ) -> None:
        """Move corner nodes of a body to places (n, d), and its midside nodes with them.

        A node that must stay in other faces moves only along these faces, up to the plane through
        its place in `places`, normal to its row of `normals` (n, d). With `stays`, the node remains
        in this plane in later moves.
        """
        mesh = self.bodies[name].mesh
        steps = np.zeros(mesh.p.shape)
        for node, to, normal in zip(nodes.tolist(), places, normals, strict=True):
            step = to - mesh.p[:, node]
            fixed = self._fixed.setdefault((name, node), [])
            free = normal - sum((way * (way @ normal) for way in fixed), np.zeros(len(normal)))
            size = float(np.linalg.norm(free))
            # If faces have nearly the same direction, the node stays where the first of them has
            # put it.
            same_direction = 0.1
            if size > same_direction:
                if fixed:
                    step = free * (normal @ step) / size**2
                if stays:
                    fixed.append(free / size)
                steps[:, node] = step
        if steps.any():
            corners = steps[:, mesh.t]  # (d, corners, elements)
            weights = corner_weights(type(mesh))
            elements = mesh.dofs.element_dofs
            steps[:, elements] = np.einsum("lc,ace->ale", weights, corners)
            self.bodies[name] = self.bodies[name].moved(mesh.p + steps)
