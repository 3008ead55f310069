"""The bodies of a model in one numbering: stiffness, loads, supports and pairs of nodes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy.sparse import block_diag, csr_matrix, identity, vstack

from ..contact.checks import Array
from ..errors import ModelError
from .bodies import Body, Traction
from .contacts import Contact, Interference, Joint, joined
from .corners import shares
from .elasticity import Kinematics, body_stiffness, circumference
from .frames import place, plane_frames
from .given import held_nodes, same_point
from .interface import Interface, openings
from .loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure
from .numbering import NumberedBodies
from .ordering import Integers
from .recovery import Recovery
from .touching import check_touching

__all__ = ["LOADS", "Assembly", "Load"]

LOADS = (Traction, Pressure, BodyForce, Centrifugal, Expansion, Displacement, Interference)
Load: TypeAlias = Traction | Pressure | BodyForce | Centrifugal | Expansion | Displacement | Interference


@dataclass(frozen=True, eq=False)
class Assembly(NumberedBodies[Body]):
    """The parts of a `ContactModel`, all nodes counted body after body."""

    loads: Mapping[str, Sequence[Load]]
    contacts: Sequence[Contact]
    kinematics: Kinematics

    @cached_property
    def recovery(self) -> Recovery:
        """The factorisation that gives displacements back."""
        return Recovery(self.stiffness, self.interface, self.free_rows, self.points)

    @cached_property
    def stiffness(self) -> csr_matrix:
        """Stiffness of the separate bodies."""
        parts = [body_stiffness(body.mesh, body.material, body.element, self.kinematics) for body in self.bodies.values()]
        return csr_matrix(block_diag(parts, format="csr"))

    @cached_property
    def free_rows(self) -> Integers:
        """(nodes, 2) unknowns of all nodes, -1 where they are held."""
        return np.where(np.isin(self.rows, self.held()), -1, self.rows)

    @cached_property
    def interface(self) -> Interface:
        """The N pairs; a corner of several contacts is in so many of them as move independently."""
        kept, means = self._shares
        frames = plane_frames(np.concatenate([joint.face.normals for joint in self.joints])[kept])
        nodes, projection = self._sides
        return Interface(nodes[kept], csr_matrix(means @ openings(nodes, projection)), frames, held_nodes(self.free_rows))

    @cached_property
    def sides(self) -> tuple[csr_matrix, csr_matrix]:
        """(N, nodes) matrices of the nodes of body 1, and of the places of body 2, that the pairs lie at."""
        (nodes, projection), (kept, _) = self._sides, self._shares
        return identity(len(self.points), format="csr")[nodes[kept]], projection[kept]

    @cached_property
    def contact(self) -> Integers:
        """(N,) number of the contact of each pair."""
        return np.repeat(np.arange(len(self.joints)), [len(joint.face.nodes) for joint in self.joints])[self._shares[0]]

    @cached_property
    def gap(self) -> Array:
        """(N,) initial gap."""
        return np.asarray(self._shares[1] @ np.concatenate([joint.gap for joint in self.joints]))

    @cached_property
    def _sides(self) -> tuple[Integers, csr_matrix]:
        """All nodes of body 1 on the contacts, one contact after the other, and the places of body 2 that face them."""
        nodes, places = [], []
        for contact, joint in zip(self.contacts, self.joints, strict=True):
            nodes.append(self.first_node[contact.body_1] + joint.face.nodes)
            places.append(self._widened(contact.body_2, joint.projection, len(self.points)))
        return np.concatenate(nodes), csr_matrix(vstack(places))

    @cached_property
    def _shares(self) -> tuple[Integers, csr_matrix]:
        """Which of these are the N pairs, and the means of the relative motions that they stand for."""
        (nodes, projection), near = self._sides, same_point(self.points)
        links = projection.tocoo()
        lie = np.linalg.norm(self.points[links.col] - self.points[nodes[links.row]], axis=1) <= near
        others = np.full(len(nodes), -1)
        others[links.row[lie]] = links.col[lie]
        number = np.repeat(np.arange(len(self.joints)), [len(joint.face.nodes) for joint in self.joints])
        return shares(self.contacts, number, nodes, others, self.points[nodes], self._widths, near)

    @cached_property
    def _widths(self) -> Array:
        return np.concatenate([joint.face.widths(circumference(joint.face.points[:, 0], self.kinematics)) for joint in self.joints])

    def modulus(self, name: str) -> float:
        """Modulus of a body for its part of E*."""
        material = self.bodies[name].material
        return material.E if self.kinematics == "plane_stress" else material.plane_modulus

    @cached_property
    def joints(self) -> list[Joint]:
        """The joined nodes of each contact."""
        return [joined(contact, *self.bodies_of(contact), self.kinematics) for contact in self.contacts]

    def _widened(self, name: str, projection: csr_matrix, nodes: int) -> csr_matrix:
        """A projection with the columns of all nodes, from one with those of a body."""
        return csr_matrix((projection.data, self.first_node[name] + projection.indices, projection.indptr), shape=(projection.shape[0], nodes))

    def force(self, case: str) -> Array:
        """Nodal forces of a load case on all unknowns, without those of moved supports."""
        forces = np.zeros(sum(2 * body.mesh.p.shape[1] for body in self.bodies.values()))
        for part in self.loads[case]:
            if not isinstance(part, Interference | Displacement):
                body = self.body(f"loads[{case!r}]", part.body)
                if isinstance(part, Traction | Pressure):
                    body.boundary_nodes(part.boundary, f"loads[{case!r}]")
                forces[self.unknowns(part.body)] += part._forces(body, self.kinematics).T
        return forces

    def moved(self, case: str) -> Array:
        """Displacements of all unknowns if a load case moves supports, and what is glued to them, and all else stays."""
        moved = np.zeros(sum(2 * body.mesh.p.shape[1] for body in self.bodies.values()))
        given = np.full(len(moved), False)
        for part in self.loads[case]:
            if isinstance(part, Displacement):
                nodes = self.nodes(f"loads[{case!r}]", part)
                for direction, values in part._values(self.bodies[part.body].mesh.p[:, nodes]).items():
                    unknowns = self.unknowns(part.body)[nodes, "xy".index(direction)]
                    if not np.isin(unknowns, self.held()).all():
                        raise ModelError(f"loads[{case!r}]: {part} moves nodes in {direction} that no support holds; hold them by a Support")
                    if (other := given[unknowns] & (moved[unknowns] != values)).any():
                        at = place(self.bodies[part.body].mesh.p[:, nodes[other][0]])
                        raise ModelError(
                            f"loads[{case!r}]: {part} and another displacement move the node at {at} differently in {direction}; give one"
                        )
                    moved[unknowns], given[unknowns] = values, True
        if moved.any():
            following, _, Q = self.interface.followers
            moved[self.rows[following]] = Q @ moved[self.rows]
        return moved

    def load(self, case: str) -> Array:
        """Nodal forces of a load case on all unknowns: those of moved supports stand for the displacements."""
        moved = self.moved(case)
        return self.force(case) - self.stiffness @ moved if moved.any() else self.force(case)

    def overlap(self, case: str) -> Array:
        """(N,) interference of a load case."""
        amounts = dict.fromkeys([contact.name for contact in self.contacts], 0.0)
        for part in self.loads[case]:
            if isinstance(part, Interference):
                if part.contact not in amounts:
                    raise ModelError(f"loads[{case!r}]: contact {part.contact!r} is unknown; this model has {list(amounts)}")
                amounts[part.contact] += part.amount
        return np.array(list(amounts.values()))[self.contact]

    def held(self) -> Integers:
        """Unknowns that the supports hold, and the radial ones on the axis of axisymmetric bodies."""
        held = super().held()
        if self.kinematics != "axisymmetric":
            return held
        return np.unique(np.concatenate([held, *(self.unknowns(name)[body.mesh.p[0] == 0, 0] for name, body in self.bodies.items())]))

    def check_contacts(self) -> None:
        """Check the names of the contacts, and that none is forgotten."""
        names = [contact.name for contact in self.contacts]
        if again := [name for i, name in enumerate(names) if name in names[:i]]:
            raise ModelError(f"contacts: two are called {again[0]!r}; give each a name")
        joined: dict[tuple[str, str], list[Integers]] = {}
        for contact, joint in zip(self.contacts, self.joints, strict=True):
            joined.setdefault((contact.body_1, contact.body_2), []).append(joint.face.nodes)
            joined.setdefault((contact.body_2, contact.body_1), []).append(joint.projection.indices)
        check_touching(self.bodies, joined)

    @property
    def widths(self) -> Array:
        """(N,) tributary lengths of the pairs; axisymmetric: areas."""
        return np.asarray((self._shares[1] > 0) @ self._widths)
