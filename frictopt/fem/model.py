"""A contact of meshed bodies: its description by the user, and the checks of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    EQUILIBRIUM,
    RESIDUAL,
    SIMULTANEOUS,
    Array,
    Shown,
    bar_of,
    checked_cases,
    checked_loads,
    finite_array,
    frozen,
    shown,
)
from ..base.checks import checked_units, listed_parts
from ..contact import ContactSystem, compliances, joined, parted
from ..errors import ModelError, ModelWarning
from .assembly import Assembly, Load
from .bodies import Body, checked_kinematics, units_apart
from .bolts import bolts_of, by_their_forces
from .condense import condensed
from .contacts import Contact, Joint
from .cyclic import Cyclic
from .elasticity import Kinematics
from .interface import check_course
from .load_sizes import load_sizes
from .loads import Expansion
from .modes import Vibrating
from .recovery import BodyFields, Recovery, Steady, Viewed, strain_and_stress, warn_of_open_nodes
from .supports import Support

# edges of body 1 that are so much longer than those of body 2 do not see what happens between their
# nodes
_COARSE = 4.0
_MISSED = 0.5  # share of the widest measured gap by which facets may miss curved faces


@dataclass(frozen=True, eq=False, repr=False)
class ContactModel(Shown, Viewed, Vibrating):
    """Elastic bodies that meet along any number of faces, in the plane or in space as their meshes are.

    Parameters
    ----------
    bodies
        Name -> body.
    supports
        Supports. With the contacts glued, they must prevent all rigid motions; a body that other
        bodies hold may be free. Of symmetric bodies a half does, held across the plane of symmetry:
        nodes of a contact there, as on the axis of axisymmetric bodies, do not slip across it. Of a
        ring of equal sectors one does: a `Cyclic` for each body that is cut.
    loads
        Load case name -> its loads: Traction, Pressure, BodyForce, Centrifugal, Expansion,
        Displacement, Interference, BoltPreload, or what `Modes.load` gives.
    contacts
        The contacts, each of another name. None given: two bodies, the first of them body 1, meet
        along the boundary "contact" of both. A corner node belongs to as many contacts as faces end
        there. Where its motion in the last of them follows from the others, the next node stands
        for both; where the faces go on smoothly, the first contact has it alone.
    kinematics
        Of plane meshes "plane_strain" (None says so too), "plane_stress", or "axisymmetric": x is
        then the radius and x = 0 the axis, and stiffness, forces and widths (which are areas) are
        those of the whole circumference; slips are along the meridian. Of meshes in space "space"
        (or None).
    units
        Names of the units of force and length, such as "N, mm", for pictures and tables, see
        `ContactSystem`.

    Raises
    ------
    ModelError
        A body or boundary that is unknown, contacts of the same name, faces that do not meet (see
        `Contact`) or are all corners of other contacts, flat facets of two bodies that lie on each
        other in no contact, a load case without loads or one that supports take where it acts,
        meshes that do not fit each other or kinematics.

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
    supports: Sequence[Support | Cyclic]
    loads: Mapping[str, Sequence[Load]]
    contacts: Sequence[Contact] = ()
    kinematics: Kinematics | None = None
    units: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.bodies, Mapping) or not self.bodies:
            raise ModelError(f"bodies: {shown(self.bodies)}; give a mapping, name -> Body")
        kinematics, contacts = (
            checked_kinematics(self.kinematics, self.bodies),
            listed_parts("contacts", self.contacts, Contact),
        )
        if not contacts and len(self.bodies) != 2:
            raise ModelError(
                f"contacts: none, with {len(self.bodies)} bodies; give a Contact for each face at which two of them meet"
            )
        one, *others = self.bodies
        given = checked_cases("loads", self.loads, "list of Traction")
        loads = {
            name: listed_parts(f"loads[{name!r}]", parts, *get_args(Load))
            for name, parts in given.items()
        }
        if not loads or not all(loads.values()):
            empty = [f"[{name!r}]" for name, parts in loads.items() if not parts]
            raise ModelError(
                f"loads{(empty or [''])[0]}: no load; give at least one, or leave the load case out"
            )
        vars(self).update(
            bodies=MappingProxyType(dict(self.bodies)),
            loads=MappingProxyType(loads),
            contacts=contacts or (Contact(one, others[0]),),
        )
        vars(self).update(
            supports=listed_parts("supports", self.supports, Support, Cyclic),
            kinematics=kinematics,
            units=checked_units(self.units),
        )
        _ = self._cases
        for contact, joint in zip(self.contacts, self._parts.joints, strict=True):
            self._warn_of(contact, joint)

    def _warn_of(self, contact: Contact, joint: Joint) -> None:
        """Warn of bodies in different units, and of meshes that are too coarse."""
        names = contact.body_1, contact.body_2
        for text in units_apart(names, [self.bodies[name] for name in names]):
            _warn(text)
        if joint.coarser > _COARSE:
            _warn(
                f"contacts: {contact.name!r}: the edges of body {names[0]!r} are {joint.coarser:.1f} times as long as those of body {names[1]!r}; "
                "the nodes of body 1 are those of the contact: exchange the bodies, or mesh it finer"
            )
        if joint.missed > _MISSED:
            _warn(
                f"contacts: {contact.name!r}: its facets may miss curved faces by {joint.missed:.2g} of the widest measured gap; mesh finer"
            )

    def condense(self, *, progress: bool = True) -> ContactSystem:
        """Condense the glued bodies to the relative motion of the contacts, see `frictopt.condense`.

        The nodes are those of body 1 of each contact, contact after contact, in the plane in the
        direction in which body 1 is on the left.

        Parameters
        ----------
        progress
            Whether to show after two seconds how far it is.

        Raises
        ------
        ModelError
            Rigid motions that nothing prevents, supports on both nodes of a pair, a stiffness that
            cannot be factorised accurately.
        """
        parts, glued, (R, D) = self._parts, self._parts.glued, self._parts.release
        names, points, frames = (
            [parts.names[number] for number in parts.contact],
            parts.points[parts.pairs.nodes],
            glued.interface.frames,
        )
        if self.kinematics != "space":
            check_course(points, frames, names)
        parts.check_ends()
        force, moved, _ = (
            np.column_stack(columns) for columns in zip(*self._cases.values(), strict=True)
        )
        left = force - parts.whole @ moved
        with bar_of(progress, "condensation"):
            S, bonded, L = condensed(glued, dict(zip(self._cases, (R.T @ left).T, strict=True)))
        L += (
            force.T @ moved + moved.T @ left + left.T @ (D @ left)
        )  # of moved supports, and of bolts that are cut
        bonded, L, bolts = by_their_forces(self.loads, bonded, L)
        stress = self.kinematics == "plane_stress"
        moduli = {
            name: body.material.E if stress else body.material.plane_modulus
            for name, body in self.bodies.items()
        }
        E_star = {
            1 / (1 / moduli[contact.body_1] + 1 / moduli[contact.body_2])
            for contact in self.contacts
        }
        E, contact = E_star.pop() if len(E_star) == 1 else None, np.array(names)
        known: dict[str, Any] = {"E_star": E, "compliance": L, "bolts": bolts, "units": self.units}
        known["load_size"] = load_sizes(self.loads, self.bodies, self.kinematics or "plane_strain")
        rigid = ContactSystem(
            S,
            points,
            bonded,
            gap=parts.gap,
            frames=frames,
            contact=contact,
            width=parts.width,
            **known,
        )
        if overlaps := {
            name: overlap for name, (_, _, overlap) in self._cases.items() if overlap.any()
        }:
            rigid = rigid.with_interference(overlaps)
        tangential, normal = self._springs
        return (
            rigid.with_contact_stiffness(tangential=tangential, normal=normal)
            if np.isfinite(self._springs).any()
            else rigid
        )

    def recover(
        self,
        loads: Mapping[str, float] | Steady,
        slip: ArrayLike | None = None,
        gap: ArrayLike | None = None,
        *,
        progress: bool = True,
    ) -> BodyFields:
        """Displacements and stresses in the bodies at a state of the contact: one solve with a factorisation that is kept from the first time on.

        Parameters
        ----------
        loads
            The loads of the state, load case name -> amplitude; or a steady state of the condensed
            model, whose last corner is the state.
        slip, gap
            Slip v, (N,) or (N, 2) in space, and gap w, (N,), of the state, length; of a steady
            state neither, for it has them. The gap of a state contains the initial one of this
            model; no gap means just that one.
        progress
            Whether to show after two seconds how far the factorisation is.

        Warns
        -----
        ModelWarning
            Nodes that are open carry force: the slip and the gap are not those of a state under
            these loads, or the system has another initial gap or contact stiffness
            (`ContactSystem.with_gap`, `with_contact_stiffness`) than the model (`Contact`).

        Raises
        ------
        ModelError
            An unknown load case, slips and gaps of another shape or not finite, or beside a steady
            state.

        Examples
        --------
        >>> import frictopt as fo
        >>> scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
        >>> fields = scene.recover({"P": 1.0}, slip=[0.0] * 5)  # glued
        >>> sorted(fields.stress), fields.p.shape
        (['block', 'punch'], (5,))
        >>> bool(abs(fields.q).max() < 1), round(float(fields.p.sum()), 9)
        (True, 2.0)
        """
        if isinstance(loads, Steady):
            if slip is not None or gap is not None:
                raise ModelError(
                    "slip, gap: the steady state has its own; leave them out, or give the loads of the state instead of it"
                )
            steady: Any = loads
            slip, gap, loads = (
                steady.slip / steady.system.stretch,
                steady.gap,
                steady.cycle.at(steady.load_factor)[-1],
            )
        if slip is None:
            raise ModelError(
                "slip: None; give the slip (and the gap) of the state under these loads, or a steady state instead of the loads"
            )
        amplitudes, parts = checked_loads("loads", loads), self._parts
        if unknown := sorted(set(amplitudes) - set(self.loads)):
            raise ModelError(
                f"load case {unknown[0]!r}: unknown; this model has {sorted(self.loads)}"
            )
        n, d = len(parts.contact), parts.points.shape[1]
        v, w = (
            finite_array("slip", slip, (n,) if d == 2 else (n, 2)),
            parts.gap if gap is None else finite_array("gap", gap, (n,)),
        )
        bolts = self._condensed.bolts if any(cut.bolt.locked for cut in parts.cuts) else {}
        units = {name: shortening for name, (_, shortening) in bolts.items()}
        cases = [
            [amplitude * units.get(name, 1.0) * part for part in self._cases[name]]
            for name, amplitude in amplitudes.items()
        ]
        nothing = [np.zeros(parts.points.size), np.zeros(parts.points.size), np.zeros(n)]
        force, moved, overlap = (np.sum(some, axis=0) for some in zip(nothing, *cases, strict=True))
        (R, D), left = parts.release, force - parts.whole @ moved
        motion = joined(v, w - parts.gap)
        if np.isfinite(self._springs).any():  # the bodies move by what the springs give, too
            system = self._condensed
            motion -= compliances(*self._springs, parts.width, d - 1) * (
                joined(*system.reaction(amplitudes)) + system.S @ motion
            )
        motion[-n:] += overlap
        with bar_of(progress, "recovery"):
            u, r = self._recovery.displacements(R.T @ left, motion)
        if gap is not None:
            warn_of_open_nodes(w, r, float(np.abs(u).max()))
        u = parts.tied @ (R @ u + D @ left + moved)
        shifts = {
            name: frozen(u[parts.rows[first : first + parts.bodies[name].mesh.p.shape[1]]].T)
            for name, first in parts.first_node.items()
        }
        expanded = [
            (amplitude, part)
            for name, amplitude in amplitudes.items()
            for part in self.loads[name]
            if isinstance(part, Expansion)
        ]
        seams = {
            name: parts.sector.seam(parts.first_node[name], body)
            for name, body in parts.bodies.items()
        }
        tensors = {
            name: strain_and_stress(
                name, body, parts.kinematics, shifts[name], expanded, seams[name]
            )
            for name, body in parts.bodies.items()
        }
        strain, stress = ({name: both[i] for name, both in tensors.items()} for i in (0, 1))
        q, p, v, w = map(frozen, (*parted(r, d), v, w))
        return BodyFields(
            shifts,
            stress,
            strain,
            q,
            p,
            v,
            w,
            parts.bodies,
            self.units,
            parts.glued.interface.frames,
            parts.sides,
        )

    def _over(
        self, steady: Steady, *, every: bool
    ) -> Iterator[tuple[float, BodyFields, dict[str, Any]]]:
        """The states of a steady cycle, at its corners or all: corners visited since the last one, fields, and status and work at the contact."""
        states = steady.states()
        last = np.append(np.diff(states.time) > SIMULTANEOUS, True)  # of the states of one time
        corner = np.abs(states.time - np.round(states.time)) <= SIMULTANEOUS
        before = 0
        for state in np.flatnonzero(last if every else last & corner).tolist():
            loads = {
                case: amplitude
                for case, amplitude in zip(
                    states.system.bonded, states.amplitudes[state], strict=True
                )
                if amplitude
            }
            fields = self.recover(
                loads, states.slip[state] / states.system.stretch, states.gap[state]
            )
            off = max(
                np.abs(fields.q - states.q[state] * states.system.stretch).max(),
                np.abs(fields.p - states.p[state]).max(),
            )
            if off > EQUILIBRIUM * np.abs(states.p).max():
                raise ModelError(
                    f"model: its fields miss the reactions of the steady state by {off:.1e}; give the one its system was condensed from"
                )
            work = states.work[state] - states.work[0]
            way = np.ptp(states.slip[before : state + 1], axis=0).reshape(len(work), -1).max(axis=1)
            slipped = way > RESIDUAL * np.abs(states.slip).max()
            status = np.where(states.gap[state] > 0, 2, slipped).astype(np.int32)
            yield (
                float(states.time[state]),
                fields,
                {"status": status, "work": work, "work_density": work / self._parts.width},
            )
            before = state

    def _answer(self) -> Mapping[str, object]:
        counts = np.bincount(self._parts.contact, minlength=len(self.contacts)).tolist()
        bodies = {}
        for name, body in self.bodies.items():
            extents = " x ".join(f"{extent:.4g}" for extent in np.ptp(body.mesh.p, axis=1))
            bodies[name] = (
                f"E={body.material.E:g}, nu={body.material.nu:g}, {extents}, {body.mesh.p.shape[1]} nodes"
            )
        model = {
            "bodies": bodies,
            "contacts": dict(zip(self._parts.names, counts, strict=True)),
            "supports": len(self.supports),
        }
        if self._parts.sector.count > 1:
            model["sector"] = f"1 of {self._parts.sector.count}"
        return {**model, "loads": list(self.loads), "kinematics": self.kinematics}

    @cached_property
    def _parts(self) -> Assembly:
        return Assembly(
            self.bodies,
            self.supports,
            self.contacts,
            bolts_of(self.loads),
            self.kinematics or "plane_strain",
        )

    @cached_property
    def _cases(self) -> dict[str, tuple[Array, Array, Array]]:
        """Nodal forces, displacements that are given, and overlaps of each load case."""
        return {
            name: self._parts.case(f"loads[{name!r}]", parts) for name, parts in self.loads.items()
        }

    @cached_property
    def _springs(self) -> tuple[Array, Array]:
        """(N,) tangential and normal stiffness of the surfaces at the nodes."""
        stiffness = np.array(
            [(contact.tangential_stiffness, contact.normal_stiffness) for contact in self.contacts]
        )[self._parts.contact]
        return stiffness[:, 0], stiffness[:, 1]

    @cached_property
    def _condensed(self) -> ContactSystem:
        """The contact, where recovery needs it."""
        return self.condense()

    @cached_property
    def _recovery(self) -> Recovery:
        """The factorisation that gives displacements back."""
        return Recovery(self._parts)


def _warn(text: str) -> None:
    warnings.warn(text, ModelWarning, stacklevel=5)  # where the model is made
