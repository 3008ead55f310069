"""A contact of meshed bodies: its description by the user, and the checks of it."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array, check_name, check_text, checked_loads, choice, finite_array, listed_parts, shown
from ..contact.show import Plotted, Shown
from ..contact.tolerances import COUNTS
from ..errors import ModelError, ModelWarning
from .assembly import LOADS, Assembly, Load
from .bodies import Body, Support, Traction
from .condense import plane_system, reactions
from .contacts import Contact
from .elasticity import KINEMATICS, Kinematics
from .frames import check_course
from .loads import Expansion, Pressure
from .numbering import described, warn_of_contrast
from .ordering import Integers
from .recovery import BodyFields, body_fields
from .rigid import node_graph

__all__ = ["ContactModel"]

COARSE = 4.0  # edges of body 1 that are so much longer than those of body 2 do not see what happens between their nodes


@dataclass(frozen=True, eq=False, repr=False)
class ContactModel(Shown, Plotted):
    """Elastic bodies that meet along any number of faces; plane strain, plane stress, or axisymmetric.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports. With the contacts glued, they must prevent all rigid motions; a body that other bodies hold may be free.
    loads
        Load case name -> its loads: Traction, Pressure, BodyForce, Centrifugal, Expansion, Displacement, Interference.
    contacts
        The contacts, each of another name. None given: two bodies, the first of them body 1, meet along the boundary "contact" of both. A corner node
        belongs to as many contacts as faces end there. Where its motion in the last of them follows from the others, the next node stands for both.
    kinematics
        "plane_strain", "plane_stress", or "axisymmetric": x is then the radius and x = 0 the axis, and stiffness, forces and widths (which are areas)
        are those of the whole circumference. Nothing twists or bends: slips are along the meridian.

    Raises
    ------
    ModelError
        A body or boundary that is unknown, contacts of the same name, faces that do not meet (see `Contact`), flat facets of two bodies that lie on
        each other in no contact, a load case without loads.

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
    loads: Mapping[str, Sequence[Load]]
    contacts: Sequence[Contact] = ()
    kinematics: Kinematics = "plane_strain"

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
        choice("kinematics", self.kinematics, KINEMATICS)
        for name, body in self.bodies.items():
            if self.kinematics == "axisymmetric":
                _check_axisymmetric(name, body)
        loads = {name: listed_parts(f"loads[{name!r}]", parts, *LOADS) for name, parts in self.loads.items()}
        contacts = listed_parts("contacts", self.contacts, Contact)
        if not contacts and len(self.bodies) != 2:
            raise ModelError(f"contacts: none, with {len(self.bodies)} bodies; give a Contact for each face at which two of them meet")
        object.__setattr__(self, "bodies", MappingProxyType(dict(self.bodies)))
        object.__setattr__(self, "supports", listed_parts("supports", self.supports, Support))
        object.__setattr__(self, "loads", MappingProxyType(loads))
        if not contacts:
            one, two = self.bodies
            contacts = (Contact(one, two),)
        object.__setattr__(self, "contacts", contacts)
        for name, parts in loads.items():
            if not parts:
                raise ModelError(f"loads[{name!r}]: no load; give at least one, or leave the load case out")
        self._parts.check_contacts()
        self._parts.held()
        for name in loads:
            self._parts.force(name)
            self._parts.overlap(name)
            self._parts.moved(name)
        warn_of_contrast(self.bodies, contacts)
        for contact, joint in zip(contacts, self._parts.joints, strict=True):
            if joint.coarser > COARSE:
                warnings.warn(
                    f"contacts: {contact.name!r}: the edges of body {contact.body_1!r} are {joint.coarser:.1f} times as long as those of body "
                    f"{contact.body_2!r}; the nodes of body 1 are those of the contact: exchange the bodies, or mesh it finer",
                    ModelWarning,
                    stacklevel=3,
                )

    def condense(self) -> ContactSystem:
        """Condense the glued bodies to the relative motion of the contacts, see `frictopt.condense`.

        The nodes are those of body 1 of each contact, contact after contact, in the direction in which body 1 is on the left.

        Raises
        ------
        ModelError
            Rigid motions that nothing prevents, supports on both nodes of a pair, a contact that is all corners of others, a stiffness that cannot be
            factorised, or not accurately enough (extreme materials, sizes or elements).
        """
        parts = self._parts
        moduli = [[parts.modulus(name) for name in (contact.body_1, contact.body_2)] for contact in self.contacts]
        E_star = {1 / (1 / one + 1 / two) for one, two in moduli}
        names = [str(self.contacts[number].name) for number in parts.contact]
        points = parts.points[parts.interface.nodes]
        check_course(points, parts.interface.frames, names)
        overlaps = {name: overlap for name in self.loads if (overlap := parts.overlap(name)).any()}
        F = {name: parts.load(name) for name in self.loads}
        graph = node_graph(parts.stiffness, parts.free_rows)
        return plane_system(
            *reactions(parts.stiffness, F, overlaps, parts.interface, parts.free_rows, parts.points, graph, names),
            parts.interface,
            points=points,
            contact=names,
            gap=parts.gap,
            width=parts.widths,
            E_star=E_star.pop() if len(E_star) == 1 else None,
        )

    def recover(self, loads: Mapping[str, float], slip: Any, gap: Any = None) -> BodyFields:
        """Displacements and stresses in the bodies at a state of the contact: one solve with a factorisation that is kept from the first time on.

        Parameters
        ----------
        loads
            The loads of the state, load case name -> amplitude.
        slip, gap
            (N,) slip v and gap w of the state, length. The gap of a state contains the initial one of this model; no gap means just that one.

        Warns
        -----
        ModelWarning
            Nodes that are open carry force: the slip and the gap are not those of a state under these loads, or the system has another initial gap
            (`ContactSystem.with_gap`) than the model.

        Raises
        ------
        ModelError
            An unknown load case, or slips and gaps that are not (N,) finite numbers.

        Examples
        --------
        >>> import frictopt as fo
        >>> scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
        >>> fields = scene.recover({"P": 1.0}, slip=[0.0] * 5)  # glued
        >>> fields
        BodyFields(bodies=['punch', 'block'], nodes=5)
        >>> bool(abs(fields.q).max() < 1), round(float(fields.p.sum()), 9)
        (True, 2.0)
        """
        amplitudes, n = checked_loads("loads", loads), len(self._parts.contact)
        if unknown := sorted(set(amplitudes) - set(self.loads)):
            raise ModelError(f"load case {unknown[0]!r}: unknown; this model has {sorted(self.loads)}")
        initial = self._parts.gap
        v, w = finite_array("slip", slip, (n,)), initial if gap is None else finite_array("gap", gap, (n,))
        size = self._parts.stiffness.shape[0]
        force, lift, overlap, expansions = np.zeros(size), np.zeros(size), np.zeros(n), []
        for name, amplitude in amplitudes.items():
            force += amplitude * self._parts.force(name)
            lift += amplitude * self._parts.moved(name)
            overlap += amplitude * self._parts.overlap(name)
            expansions += [(amplitude, part) for part in self.loads[name] if isinstance(part, Expansion)]
        u, r = self._parts.recovery.displacements(force, lift, np.concatenate([v, w - initial + overlap]))
        moved = {name: u[self._parts.rows[first : first + len(self.bodies[name].mesh.p.T)]].T for name, first in self._parts.first_node.items()}
        if gap is not None:
            _warn_of_open_nodes(w, r, float(np.abs(u).max()))
        return body_fields(self.bodies, self.kinematics, moved, expansions, r, self._parts.interface.frames[:, 0], self._parts.sides)

    @property
    def held_nodes(self) -> tuple[Integers, ...]:
        """Numbers of the nodes that each support holds, in the mesh of its body."""
        return tuple(self._parts.nodes("supports", support) for support in self.supports)

    @property
    def surface_loads(self) -> tuple[tuple[str, str, Integers, Array], ...]:
        """Tractions and pressures of all load cases, one after the other: load case, body, numbers of its loaded nodes, (2, nodes) forces on them."""
        found = []
        for case, parts in self.loads.items():
            for part in parts:
                if isinstance(part, Traction | Pressure):
                    body = self.bodies[part.body]
                    nodes = body.boundary_nodes(part.boundary, f"loads[{case!r}]")
                    found.append((case, part.body, nodes, part._forces(body, self.kinematics)[:, nodes]))
        return tuple(found)

    def _answer(self) -> Mapping[str, Any]:
        counts = np.bincount(self._parts.contact, minlength=len(self.contacts)).tolist()
        contacts = {contact.name: count for contact, count in zip(self.contacts, counts, strict=True)}
        model = {"bodies": described(self.bodies), "contacts": contacts, "supports": len(self.supports), "loads": list(self.loads)}
        return {**model, "kinematics": self.kinematics}

    @cached_property
    def _parts(self) -> Assembly:
        return Assembly(self.bodies, self.supports, self.loads, self.contacts, self.kinematics)


def _warn_of_open_nodes(w: Array, r: Array, moved: float) -> None:
    """Warn of forces (2N,) at nodes that are open, beside displacements of the bodies."""
    forces = np.hypot(*np.split(r, 2))
    carries = (w > COUNTS * moved) & (forces > COUNTS * forces.max())
    if carries.any():
        i = int(np.argmax(forces * carries))
        warnings.warn(
            f"recover: node {i} is open by {w[i]:g} and carries a force of {forces[i]:.3g}: these are no slip and gap of a state under these loads; "
            "the loads must be all those of the state, and an initial gap that `with_gap` gave to the system belongs into the model (`Contact.gap`)",
            ModelWarning,
            stacklevel=3,
        )


def _check_axisymmetric(name: str, body: Body) -> None:
    """Check that a body lies on one side of the axis, and that its elements have stresses there."""
    radius = body.mesh.p[0]
    if radius.min() < 0:
        raise ModelError(f"bodies[{name!r}]: x = {radius.min():g} at node {int(radius.argmin())}; of an axisymmetric body x is the radius, >= 0")
    if body.element != "linear":
        raise ModelError(f"bodies[{name!r}]: element {body.element!r}; axisymmetric bodies have element='linear'")
