"""The contact model of a deck: its bodies, contacts, supports and load cases."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from ..base import SAME_POINT, Array, Booleans, number_of
from ..errors import ModelError
from ..fem.adjusting import even_overlap
from ..fem.bodies import Body, split_bodies, with_parts
from ..fem.bolts import BoltPreload
from ..fem.contacts import Contact, Interference, Tie
from ..fem.couplings import DistributingCoupling, RigidCoupling
from ..fem.elasticity import Kinematics, Material
from ..fem.load_cases import Load
from ..fem.loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure
from ..fem.model import ContactModel
from ..fem.mortar import faces_of
from ..fem.node_forces import PointForce, RemoteForce
from ..fem.sector import Cyclic
from ..fem.supports import Support
from ..readers.meshes import corner_mesh, named_mesh
from .deck_conditions import Conditions, Coupled, Pair
from .refused import FIT
from .states import Field

_Loads: TypeAlias = Mapping[tuple[Any, ...], float]
_KINEMATICS: dict[str, Kinematics] = {
    "C3D": "space",
    "CPS": "plane_stress",
    "CPE": "plane_strain",
    "CAX": "axisymmetric",
}


class _AtNodes:
    """Values at some nodes of a body, as a function of coordinates; 0 at its other nodes.

    Without values, it is True at the nodes.
    """

    def __init__(self, body: Body, nodes: Booleans, values: Any = True) -> None:
        points = body.mesh.p
        self.tree = cKDTree(points[:, nodes].T)
        self.values = np.broadcast_to(values, self.tree.n)
        self.near = 1e-9 * float(np.abs(points).max())

    def __repr__(self) -> str:
        return f"{number_of(len(self.values), 'node')} of the deck"

    def __call__(self, *x: Array) -> Any:
        distance, place = self.tree.query(np.stack(x, axis=-1))
        return self.values[place] * (distance <= self.near)


class DeckModel:
    """The parts of the contact model of a deck with some load cases.

    `friction` maps contacts to coefficients, and `interactions` maps interactions to contacts.
    Errors call the deck by its `name`.
    """

    def __init__(self, conditions: Conditions, cases: Mapping[str, Field], name: str) -> None:
        self.conditions = conditions
        # The model has the setting of the last step.
        self.setting = conditions.states[-1].setting
        self.friction = dict[str, float]()
        self.interactions = defaultdict[str, list[str]](list)
        self.deck = conditions.deck.without_thin()
        surfaces = defaultdict[str, Any](list, self.deck.surfaces)
        for case, field in cases.items():
            for (kind, *place), value in field.items():
                if kind == "FACE":
                    surfaces[f"{case} {value}"].append((np.array(place[:1]), place[1]))
        self.deck = replace(self.deck, surfaces=surfaces)

        mesh, origin = named_mesh(corner_mesh(self.deck, name), self.deck, name)
        self.sets = mesh.subdomains
        self.parts = with_parts(mesh).subdomains
        kinds = {block.kind[:3] for block in self.deck.elements}
        self.kinematics = next(_KINEMATICS[kind] for kind in _KINEMATICS if kind in kinds)
        self.d = mesh.dim()
        self.axes = "xyz"[: self.d]
        self.is_plane = self.kinematics in ("plane_stress", "plane_strain")
        self.thickness = self.deck.thickness if self.is_plane else 1.0
        # body -> keyword -> constants
        self.constants = self._materials(mesh.nelements)
        bodies = {
            part: Material(*[*data["ELASTIC"], 0.0][:2], *data.get("DENSITY", [])[:1])
            for part, data in self.constants.items()
        }
        self.bodies = split_bodies(replace(mesh, _subdomains=self.parts), bodies)
        # `origin` maps a body to the matrix (nodes of the body, nodes of the deck) of the means
        # that give its nodes. `rows` maps a body to the node of the deck for each of its nodes; -1
        # if the node is a mean of several.
        self.origin = {}
        self.rows = {}
        for part, body in self.bodies.items():
            nodes = np.zeros(body.mesh.p.shape[1], dtype=np.intp)
            nodes[body.mesh.dofs.element_dofs] = mesh.dofs.element_dofs[:, self.parts[part]]
            made = self.origin[part] = origin[nodes]
            is_one = np.diff(made.indptr) == 1
            rows = self.rows[part] = np.where(is_one, made.indices[made.indptr[:-1]], -1)
            vars(body).update(deck_node=np.where(is_one, self.deck.numbers[rows], -1))
        used = [(part != 0).sum(axis=0) > 0 for part in self.origin.values()]
        shared = int((np.sum(used, axis=0) > 1).sum())
        if shared:
            text = f"{number_of(shared, 'node')} that bodies share: only faces join elements"
            conditions.left_out[text] = None

    def _materials(self, elements: int) -> dict[str, dict[str, list[float]]]:
        sections = [("", ""), *self.conditions.sections]
        owner = np.zeros(elements, dtype=int)
        for number, (where, _) in enumerate(sections):
            owner[self.sets.get(where, [])] = number
        constants = {}
        for part, members in self.parts.items():
            names = sorted({sections[i][1] for i in owner[members]})
            found = [self.conditions.materials.get(name, {}) for name in names]
            constants[part] = found[0]
            if any(data != found[0] or "ELASTIC" not in data for data in found):
                raise ModelError(
                    f"*SOLID SECTION: body {part!r} has the materials {names}; give all of "
                    "it one *MATERIAL with *ELASTIC"
                )
        return constants

    def model(self, cases: Mapping[str, Field]) -> ContactModel:
        """The model with the supports, pairs and friction of the last step."""
        self.held = self._held()
        contacts, overlaps = self._contacts()
        if not contacts:
            raise ModelError(
                "no *CONTACT PAIR that may slide is in force at the end; a joint needs one: pairs "
                "that are TIED are glued"
            )
        loads = {case: list(self._loads(case, field)) for case, field in cases.items()}
        loads = {case: listed for case, listed in loads.items() if listed}
        if overlaps:
            loads["FIT"] = overlaps
        if not loads:
            raise ModelError(f"no step has a load; if the meshes overlap unevenly by a fit, {FIT}")
        supports = [*self._supports(), *self._couplings(), *self._cyclic()]
        ties = [*self._ties()]
        return ContactModel(self.bodies, supports, loads, contacts, self.kinematics, ties=ties)

    def _held(self) -> Booleans:
        """(nodes, 6) whether displacements and rotations along and about x, y and z are held."""
        held = self._nodal(dict.fromkeys(self.setting.held, 1.0)).reshape(-1, 2, 3)
        for row, axes in self.conditions.turned.items():
            # The held axes must span the same space as some of x, y and z.
            space = np.einsum("ai,pa,aj->pij", axes, held[row], axes)
            held[row] = np.einsum("pii->pi", space) > 0.5
            if np.abs(space - held[row][:, None] * np.eye(3)).max() > SAME_POINT:
                raise ModelError(
                    f"*TRANSFORM: node {self.deck.numbers[row]} is held along an axis other than "
                    "x, y and z; hold it along all axes, or where they are x, y and z"
                )
        return held.reshape(-1, 6) > 0

    def _with(self, boundary: str, what: str) -> list[str]:
        """Names of the bodies that have a boundary."""
        bodies = self.bodies.items()
        names = [name for name, body in bodies if boundary in (body.mesh.boundaries or {})]
        if not names:
            raise ModelError(f"{what}: {boundary!r} has no face of a body; name faces")
        return names

    def _in_force(self, *, glued: bool) -> list[Pair]:
        """The contact pairs in force: only the glued pairs, or only all other pairs."""
        return [
            pair
            for pair in self.conditions.pairs
            if pair[:2] not in self.setting.removed
            and (pair.interaction in self.setting.glued) == glued
        ]

    def _contacts(self) -> tuple[list[Contact], list[Load]]:
        """The contacts of all pairs of bodies, and their overlaps, which form the load of a fit.

        A fit is a *CLEARANCE below 0, or an even overlap of meshes that no ADJUST removes.
        """
        contacts = []
        overlaps: list[Load] = []
        for pair in self._in_force(glued=False):
            bodies = self._pairs_of_bodies(pair)
            clearance = self.conditions.clearances.get(pair[:2])
            gap: Any = "measured"
            if clearance is not None:
                gap = partial(_constant, max(clearance, 0.0))
            for names in bodies:
                name = f"{pair.slave}-{pair.master}"
                name += f" ({', '.join(names)})" if len(bodies) > 1 else ""
                adjust: Any = pair.adjust
                if isinstance(adjust, Sequence):
                    adjust = self._at_rows(names[0], adjust)
                rough = self.conditions.stiffness[pair.interaction]
                contact = Contact(*names, *pair[:2], name, gap, adjust, *rough)
                overlap = max(-(clearance or 0.0), 0.0)
                if clearance is None and adjust is None:
                    overlap = even_overlap(contact, self.bodies)
                    contact = replace(contact, adjust=0.0 if overlap > 0 else None)
                contacts.append(contact)
                self.friction[name] = self.setting.friction[pair.interaction]
                self.interactions[pair.interaction].append(name)
                if overlap > 0:
                    overlaps.append(Interference(name, overlap))
        return contacts, overlaps

    def _ties(self) -> Iterator[Tie]:
        for pair in [*self.conditions.ties, *self._in_force(glued=True)]:
            tolerance = pair.adjust if isinstance(pair.adjust, float) else None
            if pair.interaction:
                tolerance = tolerance or None
            moves = pair.block.parameters.get("ADJUST") != "NO"
            for names in self._pairs_of_bodies(pair):
                yield Tie(*names, *pair[:2], tolerance, moves)

    def _cyclic(self) -> Iterator[Cyclic]:
        d = self.d
        for name, pair in self.conditions.cuts.items():
            if name not in self.conditions.axes:
                raise ModelError(
                    f"{pair.block.title}: there is no *CYCLIC SYMMETRY MODEL, TIE={name}"
                )
            start, end = self.conditions.axes[name].tolist()
            axis = tuple(np.subtract(end, start).tolist())
            tolerance: Any = pair.adjust or 0.0
            slaves, masters = self._sides(pair)
            for body in dict.fromkeys(slaves + masters):
                yield Cyclic(body, *pair[:2], axis, tuple(start[:d]), tolerance)

    def _pairs_of_bodies(self, pair: Pair) -> list[tuple[str, str]]:
        """The bodies on both sides of a contact pair or tie whose faces are near each other."""
        bodies = [*product(*self._sides(pair))]
        near = [names for names in bodies if self._is_near(pair, names)] or bodies
        for one, two in set(bodies).difference(near):
            text = f"*{pair.block.keyword}: {pair.slave} of {one} far from {pair.master} of {two}"
            self.conditions.left_out[text] = None
        return near

    def _sides(self, pair: Pair) -> tuple[list[str], list[str]]:
        """The bodies of the slave and of the master of a pair."""
        title = pair.block.title
        return self._with(pair.slave, title), self._with(pair.master, title)

    def _is_near(self, pair: Pair, names: tuple[str, str]) -> bool:
        """Whether two faces come closer than their longest edge."""
        faces = faces_of(Contact(*names, *pair[:2]), self.bodies)
        longest = max(np.ptp(face.corners, axis=1).max() for face in faces)
        one, two = (face.points[face.facets.ravel()] for face in faces)
        return bool(cKDTree(two).query(one)[0].min() <= longest)

    def _made_of(self, name: str, rows: Booleans) -> Booleans:
        """The nodes of a body that are means of only the given nodes of the deck.

        `rows` (nodes of the deck, ...) may have columns.
        """
        return ~np.asarray((self.origin[name] != 0) @ ~rows)

    def _at_rows(self, name: str, rows: Sequence[int]) -> _AtNodes | None:
        """The place of nodes of the deck in a body; None if the body has none of them."""
        nodes = self._made_of(name, np.isin(np.arange(len(self.deck.points)), rows))
        return _AtNodes(self.bodies[name], nodes) if nodes.any() else None

    def _supports(self) -> Iterator[Support]:
        for name, body in self.bodies.items():
            held = self._made_of(name, self.held[:, : self.d])
            for axes in np.unique(held, axis=0):
                nodes = (held == axes).all(axis=1)
                if axes.any():
                    yield Support(name, _AtNodes(body, nodes), _letters(axes))

    def _couplings(self) -> Iterator[Support | RigidCoupling | DistributingCoupling]:
        for row, coupled in self.conditions.couplings.items():
            held = self._of_point(self.held, row, coupled)
            if not coupled.is_rigid and not held.any():
                continue
            name = self._one_with(coupled.where, coupled.block)
            d = self.d
            if coupled.is_rigid and held.all():
                yield Support(name, coupled.where)
            else:
                kind = RigidCoupling if coupled.is_rigid else DistributingCoupling
                rotations = _letters(held[d:]) if d == 3 else "z" * bool(held[d])
                yield kind(name, coupled.where, _letters(held[:d]), rotations, self._point(row))

    def _of_point(self, nodal: Any, row: int, coupled: Coupled) -> Any:
        """The values at the point of a coupling: first of displacements, then of rotations.

        Rotations are given at the node of the rotations, or at the point itself.
        """
        d = self.d
        turns = nodal[row, 3:]
        if coupled.turns is not None:
            turns = turns + nodal[coupled.turns, :3]
        return np.concatenate([nodal[row, :d], turns if d == 3 else turns[2:]])

    def _one_with(self, boundary: str, what: str) -> str:
        """The body that has a boundary."""
        names = self._with(boundary, what)
        if len(names) != 1:
            raise ModelError(
                f"{what}: {boundary!r} has faces of the bodies {names}; name faces of one body"
            )
        return names[0]

    def _point(self, row: int) -> tuple[float, ...]:
        return tuple(self.deck.points[row, : self.d].tolist())

    def _nodal(self, loads: _Loads) -> Array:
        """(nodes, 6) values of loads at their nodes and axes."""
        values = np.zeros((len(self.deck.points), 6))
        for (row, axis), value in loads.items():
            values[row, axis] = value
        return values

    def _vectors(self, loads: _Loads) -> Array:
        """(nodes, 6) loads as vectors along x, y and z: turned where a node has its own axes."""
        values = self._nodal(loads)
        for row, axes in self.conditions.turned.items():
            values[row] = (values[row].reshape(2, 3) @ axes).ravel()
        return values

    def _loads(self, case: str, field: Field) -> Iterator[Load]:
        """The loads of a load case."""
        by_kind = defaultdict[Any, dict[tuple[Any, ...], float]](dict)
        for (kind, *place), value in field.items():
            by_kind[kind][tuple(place)] = value
        for kind, loads in by_kind.items():
            yield from getattr(self, f"_{kind.lower()}")(case, loads)

    def _face(self, case: str, loads: _Loads) -> Iterator[Load]:
        for value in dict.fromkeys(loads.values()):
            for name in self._with(f"{case} {value}", case):
                yield Pressure(name, f"{case} {value}", value)

    def _cload(self, case: str, loads: _Loads) -> Iterator[Load]:
        force = self._vectors(loads) / self.thickness
        d = self.d
        for row, coupled in self.conditions.couplings.items():
            if force[row].any():
                parts: Any = dict(zip(self.axes, force[row].tolist(), strict=False))
                moment = tuple(force[row, 3:].tolist()) if d == 3 else float(force[row, 5])
                name = self._one_with(coupled.where, coupled.block)
                point = self._point(row)
                yield RemoteForce(name, coupled.where, **parts, moment=moment, point=point)
                force[row] = 0.0
        # Supports carry the forces on the displacements that they hold.
        force[:, :d][self.held[:, :d]] = 0.0
        is_loaded: Booleans = np.any(force, axis=1)
        owners = np.zeros(len(force), dtype=int)
        for name, body in self.bodies.items():
            nodes = is_loaded[self.rows[name]] & (self.rows[name] >= 0)
            rows = self.rows[name][nodes]
            owners[rows] += 1
            if nodes.any():
                parts = (_AtNodes(body, nodes, value) for value in (True, *force[rows, :d].T))
                yield PointForce(name, *parts)
        is_wrong = is_loaded & ((owners != 1) | force[:, d:].any(axis=1))
        for row in np.flatnonzero(is_wrong).tolist():
            raise ModelError(
                f"{case}: node {self.deck.numbers[row]} has forces {force[row].tolist()} and is in "
                f"{owners[row]} bodies; give forces along {', '.join(self.axes)} to nodes of one "
                "body, and moments to the REF NODE of a *COUPLING"
            )

    def _bolt(self, case: str, loads: _Loads) -> Iterator[Load]:
        for (row,), force in loads.items():
            section = self.conditions.bolts[row]
            name = self._one_with(section, "*PRE-TENSION SECTION")
            locked = any(row in state.locked for state in self.conditions.states)
            yield BoltPreload(name, section, force / self.thickness, locked)

    def _of_set(self, case: str, where: str) -> Iterator[tuple[str, float]]:
        """The bodies of an element set, which must consist of whole bodies, and their densities."""
        members = self.sets.get(where, [])
        share = {name: np.isin(part, members).mean() for name, part in self.parts.items()}
        if not set(share.values()) <= {0.0, 1.0} or not any(share.values()):
            raise ModelError(f"{case}: {where!r} is no set of whole bodies; name the set of a body")
        for name in filter(share.get, share):
            if "DENSITY" not in self.constants[name]:
                raise ModelError(f"{case}: body {name!r}: give *DENSITY to its *MATERIAL")
            yield name, self.constants[name]["DENSITY"][0]

    def _grav(self, case: str, loads: _Loads) -> Iterator[Load]:
        for (where, *axis), size in loads.items():
            for name, density in self._of_set(case, where):
                yield BodyForce(name, *[density * size * part for part in axis[: self.d]])

    def _centrif(self, case: str, loads: _Loads) -> Iterator[Load]:
        for (where, *axis), square in loads.items():
            place: dict[str, Any] = {}
            if self.kinematics != "axisymmetric":
                place["centre"] = tuple(axis[: self.d])
            if self.d == 3:
                place["axis"] = tuple(axis[3:])
            for name, density in self._of_set(case, where):
                yield Centrifugal(name, density, square**0.5, **place)

    def _boundary(self, case: str, loads: _Loads) -> Iterator[Load]:
        values = self._vectors(loads)
        d = self.d
        for row, coupled in self.conditions.couplings.items():
            moved = self._of_point(values, row, coupled)
            if not moved.any():
                continue
            is_held = self._of_point(self.held, row, coupled).all()
            if moved[d:].any() or not (coupled.is_rigid and is_held):
                raise ModelError(
                    f"{case}: node {self.deck.numbers[row]} is a REF NODE; give the force on it, "
                    f"or hold all motions of a rigid face, and move it along {self.axes}"
                )
            name = self._one_with(coupled.where, coupled.block)
            yield Displacement(name, coupled.where, *moved[:d].tolist())
        for name, body in self.bodies.items():
            moves = self.origin[name] @ values[:, :d] * self._made_of(name, self.held[:, :d])
            for axis, moved in zip(self.axes, moves.T, strict=True):
                nodes = moved != 0
                if nodes.any():
                    by = {axis: _AtNodes(body, nodes, moved[nodes])}
                    yield Displacement(name, _AtNodes(body, nodes), **by)

    def _temperature(self, case: str, loads: _Loads) -> Iterator[Load]:
        rise = self._nodal(loads)[:, 0]
        for name, origin in self.origin.items():
            strain = origin @ rise * self.constants[name].get("EXPANSION", [0.0])[0]
            if np.ptp(strain) > 1e-9 * np.abs(strain).max():
                raise ModelError(
                    f"{case}: the temperature varies in body {name!r}; give a body one temperature"
                )
            if strain.any():
                yield Expansion(name, float(strain.mean()))


def _constant(value: float, x: Array, *_: Array) -> Array:
    return np.full(x.shape, value)


def _letters(axes: Booleans) -> Any:
    return "".join(letter for letter, is_held in zip("xyz", axes, strict=False) if is_held)
