"""A contact of meshed bodies: its description by the user, and the checks of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix, vstack

from ..contact import ContactSystem
from ..contact.checks import Array, check_name, check_text, shown
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from .bodies import Body, BodyForce, Support, Traction
from .condense import condense
from .contacts import Contact, Interference, Joint, joined
from .elasticity import body_stiffness
from .frames import place
from .ordering import Integers

__all__ = ["ContactModel"]


@dataclass(frozen=True, eq=False)
class ContactModel:
    """Elastic bodies that meet along any number of faces; plane strain.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports. With the contacts glued, they must prevent all rigid motions; a body that other bodies hold may be free.
    loads
        Load case name -> its tractions, body forces and interferences.
    contacts
        The contacts, each of another name. None given: two bodies, the first of them body 1, meet along the boundary "contact" of both.

    Raises
    ------
    ModelError
        A body or boundary that is unknown, contacts of the same name, faces that do not meet (see `Contact`), a node of body 1 in two contacts or on
        both sides, a load case without loads.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> x = [0.0, 0.5, 1.0]
    >>> upper = MeshQuad.init_tensor(x, [0.0, 1.0]).with_boundaries({"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1})
    >>> lower = MeshQuad.init_tensor(x, [-1.0, 0.0]).with_boundaries({"contact": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -1})
    >>> model = fo.ContactModel(
    ...     bodies={"punch": fo.Body(upper), "block": fo.Body(lower)},
    ...     supports=[fo.Support("block", "bottom")],
    ...     loads={"P": [fo.Traction("punch", "top", y=-1.0)]},
    ... )
    >>> system = model.condense()
    >>> system
    ContactSystem(nodes=3, x=0 .. 1, loads=['P'], gap=False)
    >>> q, p = system.bonded["P"]
    >>> round(float(p.sum()), 6)  # the whole pressure
    1.0
    """

    bodies: Mapping[str, Body]
    supports: Sequence[Support]
    loads: Mapping[str, Sequence[Traction | BodyForce | Interference]]
    contacts: Sequence[Contact] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.bodies, Mapping) or not self.bodies:
            raise ModelError(f"bodies: {shown(self.bodies)}; give a mapping, name -> Body")
        for name, body in self.bodies.items():
            check_text("bodies: name", name, "a printable text")
            if not isinstance(body, Body):
                raise ModelError(f"bodies[{name!r}]: a {type(body).__name__}; give a Body(mesh, material)")
        if not isinstance(self.loads, Mapping) or not self.loads:
            raise ModelError(f"loads: {shown(self.loads)}; give at least one load case, name -> list of Traction")
        for name in self.loads:
            check_name("loads", name)
        loads = {name: _listed(f"loads[{name!r}]", parts, Traction, BodyForce, Interference) for name, parts in self.loads.items()}
        contacts = _listed("contacts", self.contacts, Contact)
        if not contacts and len(self.bodies) != 2:
            raise ModelError(f"contacts: none, with {len(self.bodies)} bodies; give a Contact for each face at which two of them meet")
        object.__setattr__(self, "bodies", MappingProxyType(dict(self.bodies)))
        object.__setattr__(self, "supports", _listed("supports", self.supports, Support))
        object.__setattr__(self, "loads", MappingProxyType(loads))
        if not contacts:
            one, two = self.bodies
            contacts = (Contact(one, two),)
        object.__setattr__(self, "contacts", contacts)
        for name, parts in loads.items():
            if not parts:
                raise ModelError(f"loads[{name!r}]: no load; give at least one, or leave the load case out")
        self._check_contacts()
        self._held()  # these raise on names that are unknown
        for name in loads:
            self._force(name)
            self._overlap(name)

    def condense(self) -> ContactSystem:
        """Condense the glued bodies to the relative motion of the contacts, see `frictopt.condense`.

        The nodes are those of body 1 of each contact, contact after contact, in the direction in which body 1 is on the left.

        Raises
        ------
        ModelError
            Rigid motions that nothing prevents, a support on a node of body 1 on a contact, a stiffness that cannot be factorised, or not accurately
            enough (extreme materials, sizes or elements).
        """
        parts = [body_stiffness(body.mesh, body.material, body.element) for body in self.bodies.values()]
        points = np.concatenate([body.mesh.p.T for body in self.bodies.values()])
        joints = list(zip(self.contacts, self._joints, strict=True))
        moduli = {contact: [self.bodies[name].material.plane_modulus for name in (contact.body_1, contact.body_2)] for contact in self.contacts}
        E_star = {1 / (1 / one + 1 / two) for one, two in moduli.values()}
        return condense(
            csr_matrix(block_diag(parts, format="csr")),
            loads={name: self._force(name) for name in self.loads},
            pairs=np.concatenate([self._first_node[contact.body_1] + joint.face.nodes for contact, joint in joints]),
            normals=np.concatenate([joint.face.normals for joint in self._joints]),
            unknowns=np.concatenate([self._unknowns(name) for name in self.bodies]),
            points=points,
            held=self._held(),
            projection=vstack([self._widened(contact.body_2, joint.projection, len(points)) for contact, joint in joints]),
            gap=np.concatenate([joint.gap for joint in self._joints]),
            interference={name: overlap for name in self.loads if (overlap := self._overlap(name)).any()},
            contact=[contact.name for contact, joint in joints for _ in joint.face.nodes],
            width=np.concatenate([joint.face.widths for joint in self._joints]),
            E_star=E_star.pop() if len(E_star) == 1 else None,
        )

    @cached_property
    def _joints(self) -> list[Joint]:
        """The joined nodes of each contact."""
        bodies = [(self._body("contacts", contact.body_1), self._body("contacts", contact.body_2)) for contact in self.contacts]
        return [joined(contact, *pair) for contact, pair in zip(self.contacts, bodies, strict=True)]

    @cached_property
    def _first_node(self) -> dict[str, int]:
        """Number of the first node of each body, when all nodes are counted body after body."""
        sizes = [body.mesh.p.shape[1] for body in self.bodies.values()]
        return dict(zip(self.bodies, (np.cumsum(sizes) - sizes).tolist(), strict=True))

    def _body(self, argument: str, name: str) -> Body:
        if name not in self.bodies:
            raise ModelError(f"{argument}: body {name!r} is unknown; this model has {sorted(self.bodies)}")
        return self.bodies[name]

    def _unknowns(self, name: str) -> Integers:
        """(nodes, 2) unknowns of a body: its x displacements, then its y displacements, body after body."""
        nodes = self.bodies[name].mesh.p.shape[1]
        return np.asarray(2 * self._first_node[name] + np.arange(nodes)[:, None] + [0, nodes])

    def _widened(self, name: str, projection: csr_matrix, nodes: int) -> csr_matrix:
        """A projection with the columns of all nodes, from one with those of a body."""
        return csr_matrix((projection.data, self._first_node[name] + projection.indices, projection.indptr), shape=(projection.shape[0], nodes))

    def _force(self, case: str) -> Array:
        """Nodal forces of a load case, on all unknowns."""
        forces = np.zeros(sum(2 * body.mesh.p.shape[1] for body in self.bodies.values()))
        for part in self.loads[case]:
            if not isinstance(part, Interference):
                body = self._body(f"loads[{case!r}]", part.body)
                if isinstance(part, Traction):
                    body.boundary_nodes(part.boundary, f"loads[{case!r}]")
                forces[self._unknowns(part.body)] += body.force(part).T
        return forces

    def _overlap(self, case: str) -> Array:
        """(N,) interference of a load case."""
        amounts = dict.fromkeys([contact.name for contact in self.contacts], 0.0)
        for part in self.loads[case]:
            if isinstance(part, Interference):
                if part.contact not in amounts:
                    raise ModelError(f"loads[{case!r}]: contact {part.contact!r} is unknown; this model has {list(amounts)}")
                amounts[part.contact] += part.amount
        return np.repeat(list(amounts.values()), [len(joint.face.nodes) for joint in self._joints])

    def _held(self) -> Integers:
        """Unknowns that the supports hold."""
        held = [np.zeros(0, dtype=np.intp)]
        for support in self.supports:
            nodes = self._support_nodes(support)
            held += [self._unknowns(support.body)[nodes, "xy".index(direction)] for direction in support.directions]
        return np.unique(np.concatenate(held))

    def _support_nodes(self, support: Support) -> Integers:
        """Nodes that a support holds."""
        body = self._body("supports", support.body)
        if isinstance(support.where, str):
            return body.boundary_nodes(support.where, f"support of body {support.body!r}")
        distance = np.hypot(*(body.mesh.p - np.array(support.where)[:, None]))
        if distance.min() > SAME_POINT * np.ptp(body.mesh.p):
            nearest = tuple(float(value) for value in body.mesh.p[:, distance.argmin()])
            raise ModelError(f"support of body {support.body!r}: no node at {support.where}; the nearest is at {nearest}")
        return np.array([distance.argmin()])

    def _check_contacts(self) -> None:
        """Check the names of the contacts, and that no node is body 1's in two of them, or on both sides."""
        names = [contact.name for contact in self.contacts]
        if again := [name for i, name in enumerate(names) if name in names[:i]]:
            raise ModelError(f"contacts: two are called {again[0]!r}; give each a name")
        owner: dict[tuple[str, int], str | None] = {}
        for contact, joint in zip(self.contacts, self._joints, strict=True):
            for node, point in zip(joint.face.nodes.tolist(), joint.face.points, strict=True):
                if (contact.body_1, node) in owner:
                    raise ModelError(
                        f"contacts: node {node} of body {contact.body_1!r} at {place(point)} is in {owner[contact.body_1, node]!r} and in "
                        f"{contact.name!r}; let a corner belong to one contact alone: end the other one edge before it"
                    )
                owner[contact.body_1, node] = contact.name
        for contact, joint in zip(self.contacts, self._joints, strict=True):
            for node in np.unique(joint.projection.indices).tolist():
                if (contact.body_2, node) in owner:
                    raise ModelError(
                        f"contacts: node {node} of body {contact.body_2!r} at {place(self.bodies[contact.body_2].mesh.p[:, node])} is body 1's in "
                        f"{owner[contact.body_2, node]!r} and body 2's in {contact.name!r}; let it be in one of them, or exchange the bodies of one"
                    )


def _listed(argument: str, parts: Any, *kinds: type) -> tuple[Any, ...]:
    """Check a list of parts of some kinds."""
    if isinstance(parts, str) or not isinstance(parts, Sequence) or not all(isinstance(part, kinds) for part in parts):
        raise ModelError(f"{argument}: {shown(parts)}; give a list of {' or '.join(kind.__name__ for kind in kinds)}")
    return tuple(parts)
