"""A contact of meshed bodies in space."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix
from scipy.spatial import cKDTree

from ..contact.checks import Array, check_name, check_text, listed_parts, shown
from ..contact.show import Plotted, Shown
from ..contact.system import ContactSystem
from ..contact.tolerances import SAME_POINT
from ..errors import ModelError
from ..fem.condense import reactions
from ..fem.contacts import Contact
from ..fem.corners import shares
from ..fem.frames import place
from ..fem.given import held_nodes, same_point
from ..fem.interface import Interface, openings
from ..fem.numbering import NumberedBodies, described, warn_of_contrast
from ..fem.ordering import Integers
from ..fem.rigid import node_graph
from ..fem.touching import check_touching
from .bodies import Body3D, BodyForce3D, Support3D, Traction3D
from .condense import frames_of

__all__ = ["ContactModel3D"]


@dataclass(frozen=True, eq=False, repr=False)
class ContactModel3D(Shown, Plotted):
    """Elastic bodies in space, meshes of hexahedra or tetrahedra, that meet along any number of faces; nodes of body 1 lie on nodes of body 2.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports. With the contacts glued, they must prevent all rigid motions; a body that other bodies hold may be free.
    loads
        Load case name -> its tractions and body forces.
    contacts
        The contacts. None given: two bodies, the first of them body 1, meet along the boundary "contact" of both. Corners: see `ContactModel`.

    Raises
    ------
    ModelError
        A body or boundary that is unknown, bodies that are plane, nodes of body 1 that no node of body 2 meets, flat facets of two
        bodies that lie on each other in no contact, a load case without loads.

    Examples
    --------
    >>> from skfem import MeshHex
    >>> import frictopt as fo
    >>> x = [0.0, 0.5, 1.0]
    >>> upper = MeshHex.init_tensor(x, x, [0.0, 1.0]).with_boundaries({"contact": lambda x: x[2] == 0, "top": lambda x: x[2] == 1})
    >>> lower = MeshHex.init_tensor(x, x, [-1.0, 0.0]).with_boundaries({"contact": lambda x: x[2] == 0, "bottom": lambda x: x[2] == -1})
    >>> model = fo.ContactModel3D(
    ...     bodies={"punch": fo.Body3D(upper), "block": fo.Body3D(lower)},
    ...     supports=[fo.Support3D("block", "bottom", "xyz")],
    ...     loads={"P": [fo.Traction3D("punch", "top", z=-1.0)]},
    ... )
    >>> system = model.condense()
    >>> system
    ContactSystem(nodes=9, tangents=2, loads=['P'], gap=False)
    >>> q, p = system.reaction({"P": 1.0})
    >>> round(float(p.sum()), 6)  # the whole pressure
    1.0
    """

    bodies: Mapping[str, Body3D]
    supports: Sequence[Support3D]
    loads: Mapping[str, Sequence[Traction3D | BodyForce3D]]
    contacts: Sequence[Contact] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.bodies, Mapping) or not self.bodies:
            raise ModelError(f"bodies: {shown(self.bodies)}; give a mapping, name -> Body3D")
        for name, body in self.bodies.items():
            check_text("bodies: name", name, "a printable text")
            if not isinstance(body, Body3D):
                raise ModelError(f"bodies[{name!r}]: {shown(body)}; give a Body3D")
        if not isinstance(self.loads, Mapping) or not self.loads:
            raise ModelError(f"loads: {shown(self.loads)}; give at least one load case, name -> list of Traction3D")
        loads = {}
        for name, parts in self.loads.items():
            check_name("loads", name)
            loads[name] = listed_parts(f"loads[{name!r}]", parts, Traction3D, BodyForce3D)
            if not parts:
                raise ModelError(f"loads[{name!r}]: no load; give at least one, or leave the load case out")
        contacts = listed_parts("contacts", self.contacts, Contact)
        if not contacts:
            if len(self.bodies) != 2:
                raise ModelError(f"contacts: none, with {len(self.bodies)} bodies; give a Contact for each face at which two of them meet")
            one, two = self.bodies
            contacts = (Contact(one, two),)
        for name, value in {
            "bodies": MappingProxyType(dict(self.bodies)),
            "supports": listed_parts("supports", self.supports, Support3D),
            "loads": MappingProxyType(loads),
            "contacts": contacts,
        }.items():
            object.__setattr__(self, name, value)
        self._numbered.held()
        for name in loads:
            self._force(name)
        _ = self._pairs
        warn_of_contrast(self.bodies, contacts)

    def condense(self) -> ContactSystem:
        """Condense the glued bodies to the relative motion of the contacts, see `frictopt.condense`.

        Raises
        ------
        ModelError
            Rigid motions that nothing prevents, supports on both nodes of a pair, a contact that is all corners of others, a stiffness that cannot be
            factorised, or not accurately enough (extreme materials, sizes or elements).
        """
        K = csr_matrix(block_diag([body.stiffness() for body in self.bodies.values()], format="csr"))
        numbered, (contact, nodes, others, normals) = self._numbered, self._pairs
        near = same_point(numbered.points)
        kept, means = shares(self.contacts, contact, nodes, others, numbered.points[nodes], np.linalg.norm(normals, axis=1), near)
        rows = np.where(np.isin(numbered.rows, numbered.held()), -1, numbered.rows)
        lie = csr_matrix((np.ones(len(others)), (np.arange(len(others)), others)), shape=(len(others), len(numbered.points)))
        interface = Interface(nodes[kept], csr_matrix(means @ openings(nodes, lie)), frames_of(normals[kept]), held_nodes(rows))
        loads, graph = {name: self._force(name) for name in self.loads}, node_graph(K, rows)
        names = [str(self.contacts[number].name) for number in contact[kept]]
        S, bonded = reactions(K, loads, {}, interface, rows, numbered.points, graph, names)
        return ContactSystem(S, numbered.points[interface.nodes], bonded, frames=interface.frames)

    @property
    def held_nodes(self) -> tuple[Integers, ...]:
        """Numbers of the nodes that each support holds, in the mesh of its body."""
        return tuple(self._numbered.nodes("supports", support) for support in self.supports)

    def _answer(self) -> Mapping[str, Any]:
        contacts = [contact.name for contact in self.contacts]
        return {"bodies": described(self.bodies), "contacts": contacts, "supports": len(self.supports), "loads": list(self.loads)}

    @cached_property
    def _numbered(self) -> NumberedBodies[Body3D]:
        return NumberedBodies(self.bodies, self.supports)

    @cached_property
    def _pairs(self) -> tuple[Integers, Integers, Integers, Array]:
        """Number of the contact, nodes of body 1 and body 2, and normals into body 1 of the pairs, contact after contact; their lengths are areas."""
        pairs, normals, joined = [], [], dict[tuple[str, str], list[np.ndarray]]()
        for number, contact in enumerate(self.contacts):
            if contact.gap is not None:
                raise ModelError(f"contacts: {contact.name!r} has gap={contact.gap!r}; in space the faces touch: set a gap by ContactSystem.with_gap")
            one, two = self._numbered.bodies_of(contact)
            nodes = one.boundary_nodes(contact.boundary_1, f"contact {contact.name!r}")
            others = two.boundary_nodes(contact.boundary_2, f"contact {contact.name!r}")
            distance, nearest = cKDTree(two.mesh.p[:, others].T).query(one.mesh.p[:, nodes].T)
            if distance.max() > SAME_POINT * np.ptp(one.mesh.p):
                point = one.mesh.p[:, nodes[distance.argmax()]]
                raise ModelError(
                    f"contacts: {contact.name!r}: the node of body {contact.body_1!r} at {place(point)} is {distance.max():g} from the next one of "
                    f"body {contact.body_2!r}; mesh the faces with the same nodes"
                )
            first = self._numbered.first_node
            pairs.append([np.full(len(nodes), number), first[contact.body_1] + nodes, first[contact.body_2] + others[nearest]])
            normals.append(one.inward(contact.boundary_1)[nodes])
            joined.setdefault((contact.body_1, contact.body_2), []).append(nodes)
            joined.setdefault((contact.body_2, contact.body_1), []).append(others[nearest])
        check_touching(self.bodies, joined)
        contacts, ones, twos = np.concatenate(pairs, axis=1)
        return contacts, ones, twos, np.concatenate(normals)

    def _force(self, case: str) -> Array:
        """Nodal forces of a load case, on all unknowns."""
        forces = np.zeros(sum(3 * body.mesh.p.shape[1] for body in self.bodies.values()))
        for part in self.loads[case]:
            body = self._numbered.body(f"loads[{case!r}]", part.body)
            if isinstance(part, Traction3D):
                body.boundary_nodes(part.boundary, f"loads[{case!r}]")
            forces[self._numbered.unknowns(part.body)] += body.force(part).T
        return forces
