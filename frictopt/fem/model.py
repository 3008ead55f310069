"""A contact of meshed bodies: its description by the user, with checks, and its condensation."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar, get_args

import numpy as np
import skfem

from ..base import (
    Array,
    Plotted,
    Shown,
    Table,
    checked_cases,
    frame,
    number_of,
    progress_bar,
    shown,
)
from ..base.checks import checked_units, listed_parts
from ..contact import ContactProducts, ContactSystem
from ..errors import ModelError, ModelWarning
from .assembly import Assembly
from .bodies import Body, checked_kinematics, units_apart
from .bolts import bolts_of, by_their_forces
from .condense import condensed
from .contacts import Contact, Tie
from .couplings import Coupling
from .elasticity import Kinematics
from .fields import Recoverable
from .load_cases import Load, load_case, load_sizes
from .matrix_checks import check_order
from .mixed import MIXED
from .modes import Vibrating
from .products import products_of
from .sector import Cyclic
from .supports import Support

S = TypeVar("S", bound=ContactSystem)


@dataclass(frozen=True, eq=False, repr=False)
class ContactModel(Recoverable, Shown, Plotted, Vibrating):
    """Elastic bodies that meet along any number of faces, in the plane or in space.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports. With the contacts glued, the supports must prevent all rigid motions; a body that
        other bodies hold may be free. For symmetric bodies, model one half and hold it across the
        plane of symmetry. A `RigidCoupling` or a `DistributingCoupling` supports nodes through a
        point, whose displacements and rotations it can hold. Nodes of a contact on the plane of
        symmetry, or on the axis of axisymmetric bodies, do not slip across it. A pair whose two
        nodes cannot move at all, such as where both bodies are clamped, is left out, and `notes`
        names it. For a ring of equal sectors, model one sector, with a `Cyclic` for each body that
        is cut.
    loads
        Load case name -> its loads: Traction, Pressure, PointForce, RemoteForce, BodyForce,
        Centrifugal, Expansion, Displacement, Interference, BoltPreload, or the load of a mode
        (`Modes.load`).
    contacts
        The contacts, with different names. Without contacts there must be two bodies, which meet
        along the boundary "contact" of both; the first one is body 1. A corner node belongs to all
        contacts whose faces end there. If its motion in the last of these contacts follows from its
        motions in the others, it has no pair in the last contact, whose next node represents both
        nodes. If the faces continue smoothly, the corner node belongs to the first contact only.
    kinematics
        For plane meshes "plane_strain" (or None), "plane_stress", or "axisymmetric"; for meshes in
        space "space" (or None). In axisymmetric models x is the radius, and x = 0 the axis.
        Stiffness, forces and widths (areas) refer to the whole circumference, and slips are along
        the meridian.
    units
        Names of the units of force and length, such as "N, mm", for pictures and tables, see
        `ContactSystem`.
    ties
        Faces that are glued for good.

    Raises
    ------
    ModelError
        A body or boundary is unknown. Two contacts have one name. Faces do not meet (see
        `Contact`), or all their nodes are corners of other contacts. Flat facets of two bodies
        coincide without a contact. A load case has no loads, or supports carry all of it. Meshes do
        not fit each other or the kinematics.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> x = [0.0, 0.5, 1.0]
    >>> upper = MeshQuad.init_tensor(x, [0.0, 1.0]).with_boundaries(
    ...     {"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1}
    ... )
    >>> lower = MeshQuad.init_tensor(x, [-1.0, 0.0]).with_boundaries(
    ...     {"contact": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -1}
    ... )
    >>> model = fo.fem.ContactModel(
    ...     bodies={"punch": fo.fem.Body(upper), "block": fo.fem.Body(lower)},
    ...     supports=[fo.fem.Support("block", "bottom")],
    ...     loads={"P": [fo.fem.Traction("punch", "top", y=-1.0)]},
    ... )
    >>> system = model.condense()
    >>> system
    ContactSystem(nodes=3, x=0 .. 1, loads=['P'], gap=False)
    >>> q, p = system.bonded["P"]
    >>> round(float(p.sum()), 6)  # the whole pressure
    1.0
    """

    bodies: Mapping[str, Body]
    supports: Sequence[Support | Cyclic | Coupling]
    loads: Mapping[str, Sequence[Load]]
    contacts: Sequence[Contact] = ()
    kinematics: Kinematics | None = None
    stays_in_memory: ClassVar[bool] = True  # files of reports leave it out
    units: str | None = None
    ties: Sequence[Tie] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.bodies, Mapping) or not self.bodies:
            raise ModelError(f"bodies: {shown(self.bodies)}; give a mapping, name -> Body")
        kinematics = checked_kinematics(self.kinematics, self.bodies)
        vars(self).update(
            bodies=MappingProxyType(dict(self.bodies)),
            contacts=self._checked_contacts(),
            loads=MappingProxyType(self._checked_loads()),
            supports=listed_parts("supports", self.supports, Support, Cyclic, *get_args(Coupling)),
            kinematics=kinematics,
            units=checked_units(self.units),
            ties=listed_parts("ties", self.ties, Tie),
        )
        _ = self._cases  # assembles the model, which checks that its parts fit each other
        for text in self._doubts(kinematics):
            warnings.warn(text, ModelWarning, stacklevel=3)  # the line that makes the model

    def _checked_contacts(self) -> Sequence[Contact]:
        """The contacts; if none is given, the contact of the two bodies."""
        contacts = listed_parts("contacts", self.contacts, Contact)
        if contacts:
            return contacts
        if len(self.bodies) != 2:
            raise ModelError(
                f"contacts: none, with {number_of(len(self.bodies), 'body', 'bodies')}; give a "
                "Contact for each face at which two of them meet"
            )
        body_1, body_2 = self.bodies
        return (Contact(body_1, body_2),)

    def _checked_loads(self) -> dict[str, Sequence[Load]]:
        """The load cases: at least one, each with at least one load."""
        loads: dict[str, Sequence[Load]] = {}
        for name, parts in checked_cases("loads", self.loads, "list of Traction").items():
            loads[name] = listed_parts(f"loads[{name!r}]", parts, *get_args(Load))
        hint = "no load; give at least one, or leave the load case out"
        if not loads:
            raise ModelError(f"loads: {hint}")
        for name, parts in loads.items():
            if not parts:
                raise ModelError(f"loads[{name!r}]: {hint}")
        return loads

    def _doubts(self, kinematics: Kinematics) -> Iterator[str]:
        """Warnings of likely mistakes in a model: units, meshes, faces and free nodes."""
        for contact, joint in zip(self.contacts, self._assembly.joints, strict=True):
            names = contact.body_1, contact.body_2
            if joint.beyond > 0:
                size = "area" if kinematics == "space" else "length"
                yield (
                    f"contacts: {contact.name!r}: of the face of body {names[0]!r}, the {size} "
                    f"{joint.beyond:.3g} ({joint.share_beyond:.1%}) has no opposite part of body "
                    f"{names[1]!r} and is free; if it should touch, name more of body {names[1]!r}"
                )
            yield from units_apart(names, [self.bodies[name] for name in names])
            # If the edges of body 1 are longer than those of body 2 by this factor, the nodes of
            # the contact are too far apart.
            if joint.coarser > 4.0:
                yield (
                    f"contacts: {contact.name!r}: the edges of body {names[0]!r} are "
                    f"{joint.coarser:.1f} times as long as those of body {names[1]!r}; the "
                    "contact has the nodes of body 1: exchange the bodies, or mesh it finer"
                )
            widest = float(joint.gap.max())
            if joint.missed > 0.5 * widest:
                yield (
                    f"contacts: {contact.name!r}: its facets may miss curved faces by "
                    f"{joint.missed:.2g}, and the widest measured gap is {widest:.2g}; mesh finer"
                )
        for tie, of_tie in zip(self.ties, self._assembly.of_ties, strict=True):
            if of_tie.others:
                yield (
                    f"ties: {tie.title}: {number_of(of_tie.others, 'node')} of the face of body "
                    f"{tie.body_1!r} farther than {of_tie.tolerance:.3g} from the other face are "
                    "free; give a larger tolerance if they should be tied"
                )
        yield from locking(self.bodies, kinematics)

    def condense(self, *, progress: bool = True) -> ContactSystem:
        """Condense the glued bodies to the relative motions of the contacts.

        See `frictopt.condense`. A model is condensed once, and keeps the system. The nodes belong
        to body 1 of each contact, contact after contact. In the plane they run in the direction in
        which body 1 is on the left.

        Parameters
        ----------
        progress
            Whether to show a progress bar after two seconds.

        Raises
        ------
        ModelError
            A rigid motion is free, supports hold both nodes of a pair along their normal, or the
            stiffness cannot be factorised accurately.
        """
        with progress_bar(progress, "condensation"):
            return self._condensed

    def products(self, *, progress: bool = True) -> ContactProducts:
        """The contact by products with the glued bodies, for thousands of nodes in space.

        The call takes two factorisations (of the glued bodies, and of the bodies that slip freely)
        and N solutions in blocks. The model keeps the contact, with the second factorisation and a
        matrix of `8 N^2` bytes in space. Gaps, overlaps (`Interference`) and springs of contacts
        need `condense`.

        Parameters
        ----------
        progress
            Whether to show a progress bar after two seconds.

        Raises
        ------
        ModelError
            As for `condense`; a contact with a gap, an overlap or springs; products that are not
            exact, because stiffnesses differ too much.

        Examples
        --------
        >>> import frictopt as fo
        >>> bodies = fo.scenes.SquarePunch(elements=3).model().products()
        >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
        >>> limit = fo.shakedown_limit(bodies, cycle, friction=0.5, gap=0.01)
        >>> limit.gap <= 0.01
        True
        """
        with progress_bar(progress, "products"):
            return self._products

    @cached_property
    def _condensed(self) -> ContactSystem:
        return self._contact(ContactSystem, condensed)

    @cached_property
    def _products(self) -> ContactProducts:
        return self._contact(ContactProducts, products_of)

    def _contact(self, kind: type[S], reduced: Callable[..., tuple[Any, Any, Any]]) -> S:
        """The contact of this kind, from stiffness or products, bonded reactions and compliance."""
        assembly = self._assembly
        glued = assembly.glued
        points = assembly.points[assembly.pairs.nodes]
        frames = glued.interface.frames
        contact = [assembly.names[number] for number in assembly.contact]
        is_of_deck = all(body.deck_node is not None for body in assembly.bodies.values())
        if self.kinematics != "space":
            check_order(points, frames, contact)
        assembly.check_ends()

        # Forces (size, cases) on the bodies if only the moved supports have moved.
        force, moved, overlaps = self._cases
        net_force = force - assembly.whole @ moved
        R, D = assembly.release
        try:
            bodies, reactions, compliance = reduced(glued, R.T @ net_force)
        except ModelError as error:
            if cause := incompressible(self.bodies, assembly.kinematics):
                raise ModelError(f"{cause}{error}") from error
            raise
        # The loads also do work on the motions of moved supports and of cut bolts.
        compliance += force.T @ moved + moved.T @ net_force + net_force.T @ (D @ net_force)
        bonded, compliance, bolts = by_their_forces(self.loads, reactions, compliance)

        system = kind(
            **bodies,
            points=points,
            bonded=bonded,
            gap=assembly.gap,
            frames=frames,
            contact=np.array(contact),
            width=assembly.width,
            E_star=self._contact_modulus(),
            compliance=compliance,
            bolts=bolts,
            units=self.units,
            axisymmetric=self.kinematics == "axisymmetric",
            deck_node=assembly.numbers[assembly.pairs.nodes] if is_of_deck else None,
            load_size=load_sizes(self.loads, self.bodies, assembly.kinematics),
        )
        if overlaps.any():
            by_case = zip(self.loads, overlaps.T, strict=True)
            system = system.with_interference({name: of for name, of in by_case if of.any()})
        tangential, normal = self._springs
        if np.isfinite(self._springs).any():
            return system.with_contact_stiffness(tangential=tangential, normal=normal)
        return system

    def _contact_modulus(self) -> float | None:
        """The contact modulus E* if all contacts have the same modulus; otherwise None."""
        moduli = {}
        for name, body in self.bodies.items():
            is_stress = self.kinematics == "plane_stress"
            moduli[name] = body.material.E if is_stress else body.material.plane_modulus
        E_star = {
            1 / (1 / moduli[contact.body_1] + 1 / moduli[contact.body_2])
            for contact in self.contacts
        }
        return E_star.pop() if len(E_star) == 1 else None

    def to_frame(self) -> Table:
        """A row for each body: body, E, nu, its size along the axes, and its mesh.

        The mesh has the columns nodes, elements and largest_element, the length of its longest
        edge.
        """
        bodies = self.bodies.values()
        meshes = [body.mesh for body in bodies]
        extents = [np.ptp(mesh.p, axis=1) for mesh in meshes]
        columns = {
            "body": [*self.bodies],
            "E": [body.material.E for body in bodies],
            "nu": [body.material.nu for body in bodies],
            "size": [" x ".join(f"{extent:.4g}" for extent in each) for each in extents],
            "nodes": [mesh.p.shape[1] for mesh in meshes],
            "elements": [mesh.nelements for mesh in meshes],
            "largest_element": [mesh.param() for mesh in meshes],
        }
        return frame(columns, units=self.units)

    def _answer(self) -> Mapping[str, object]:
        bodies = {
            row.body: f"E={row.E:g}, nu={row.nu:g}, {row.size}, {row.nodes} nodes"
            for row in self.to_frame().itertuples()
        }
        assembly = self._assembly
        nodes = np.bincount(assembly.contact, minlength=len(self.contacts)).tolist()
        answer: dict[str, object] = {
            "bodies": bodies,
            "contacts": dict(zip(assembly.names, nodes, strict=True)),
            "supports": len(self.supports),
        }
        if self.ties:
            answer["ties"] = [tie.name for tie in self.ties]
        if assembly.sector.count > 1:
            answer["sector"] = f"1 of {assembly.sector.count}"
        answer |= {"loads": list(self.loads), "kinematics": self.kinematics}
        return answer | ({"notes": list(self.notes)} if self.notes else {})

    @property
    def notes(self) -> tuple[str, ...]:
        """Statements on what the model does although its arguments do not say so.

        Notes name pairs that are left out, the largest moves due to `Contact.adjust` and to the
        tolerance of `Cyclic`, and the largest gap that is measured in each contact.
        """
        assembly = self._assembly
        notes = [*assembly.notes]
        for number, contact in enumerate(self.contacts):
            gap = assembly.gap[assembly.contact == number]
            if not callable(contact.gap) and gap.any():
                share = f"{np.count_nonzero(gap)} of {number_of(len(gap), 'node')}"
                notes.append(f"{contact.title}: {share} apart, by up to {gap.max():.3g}")
        return tuple(notes)

    @cached_property
    def _assembly(self) -> Assembly:
        return Assembly(
            self.bodies,
            self.supports,
            self.contacts,
            self.ties,
            bolts_of(self.loads),
            self.kinematics or "plane_strain",
        )

    @cached_property
    def _cases(self) -> tuple[Array, Array, Array]:
        """Forces, displacements (size, cases) and overlaps (N, cases), see `load_case`."""
        cases = [
            load_case(self._assembly, f"loads[{name!r}]", loads)
            for name, loads in self.loads.items()
        ]
        force, moved, overlaps = map(np.column_stack, zip(*cases, strict=True))
        return force, moved, overlaps

    @cached_property
    def _springs(self) -> tuple[Array, Array]:
        """(N,) tangential and normal stiffness of the surfaces at the nodes."""
        tangential = np.array([contact.tangential_stiffness for contact in self.contacts])
        normal = np.array([contact.normal_stiffness for contact in self.contacts])
        return tangential[self._assembly.contact], normal[self._assembly.contact]


def locking(bodies: Mapping[str, Body], kinematics: Kinematics) -> Iterator[str]:
    """Warnings of bodies whose elements lock: these bodies are too stiff, and limits are wrong.

    From nu = 0.49 on, linear triangles deform at least a tenth less than they should.
    """
    if kinematics == "plane_stress":
        return
    for name, body in bodies.items():
        nu = body.material.nu
        mesh = body.mesh
        # In triangles, tetrahedra and most wedges the dilatation is uniform anyway.
        has_simplices = isinstance(mesh, (skfem.MeshTri1, skfem.MeshTet1, *MIXED))
        is_averaged = body.element == "mean_dilatation" and not has_simplices
        if nu >= 0.49 and body.element != "quadratic" and not is_averaged:
            yield (
                f"bodies[{name!r}]: nu = {nu!r} and element {body.element!r} on a "
                f"{type(mesh).__name__}, which locks near nu = 0.5: the body is too stiff, and "
                "limits are wrong; give it quadratic elements"
            )


def incompressible(bodies: Mapping[str, Body], kinematics: Kinematics) -> str:
    """Text before an error that a body with nu close to 0.5 may cause; empty without such a body.

    The stiffness of this body is nearly all resistance to a change of volume. The resistance
    to a change of shape, on which supports and contacts depend, then has few exact digits or none.
    """
    for name, body in bodies.items():
        ratio = 1 / (1 - 2 * body.material.nu)
        if ratio > 1e6 and kinematics != "plane_stress":
            return (
                f"bodies[{name!r}]: nu = {body.material.nu!r} is too close to 0.5: its resistance "
                f"to a change of volume is {ratio:.1e} times its resistance to a change of shape, "
                "of which rounding leaves too few digits; take nu = 0.4999 and quadratic elements. "
                "Without these digits: "
            )
    return ""
