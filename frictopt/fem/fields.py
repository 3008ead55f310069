"""Displacements and stresses in the bodies of a model: at a state, or during a steady cycle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, lil_matrix

from ..base import (
    EQUILIBRIUM,
    SIMULTANEOUS,
    Array,
    Integers,
    Loads,
    checked_loads,
    finite_array,
    finite_number,
    frozen,
    place,
    progress_bar,
    whole_number,
)
from ..contact import StressMap, amplitudes_of, compliances, joined, parted
from ..errors import ModelError
from .elasticity import basis_of
from .loads import Expansion
from .recovery import BodyFields, NodalFields, Recovery, Steady, tensors_of, warn_of_open_nodes

_ANOTHER = "give the ContactModel that the system was condensed from"
# Number of loads and motions whose fields are in memory together.
_BLOCK = 128


class Recoverable:
    """Base of models that recover fields in their bodies."""

    def recover(
        self: Any,
        loads: Loads | Steady,
        slip: ArrayLike | None = None,
        gap: ArrayLike | None = None,
        *,
        progress: bool = True,
    ) -> BodyFields:
        """Displacements and stresses in the bodies at a state of the contact.

        The first call factorises the stiffness; each call then takes one solve.

        Parameters
        ----------
        loads
            The loads of the state, load case name -> amplitude. Or a steady state of the condensed
            model, whose state at the last load corner is taken.
        slip, gap
            Slip v, (N,), in space (N, 2), and gap w, (N,), of the state, length. Leave both out
            for a steady state. The gap includes the initial gap of this model; None: it is the
            initial gap.
        progress
            Whether to show a progress bar for the factorisation after two seconds.

        Warns
        -----
        ModelWarning
            Open nodes carry force. Either slip and gap do not belong to a state under these loads,
            or the system has another initial gap or contact stiffness than the model (see
            `ContactSystem.with_gap`, `with_contact_stiffness`, and `Contact`).

        Raises
        ------
        ModelError
            A load case is unknown. Slips or gaps have another shape, are not finite, or are given
            beside a steady state.

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
        assembly = self._assembly
        amplitudes, slip, gap = self._state(loads, slip, gap)
        n = len(assembly.contact)
        d = assembly.points.shape[1]
        v = finite_array("slip", slip, (n,) if d == 2 else (n, 2))
        w = assembly.gap if gap is None else finite_array("gap", gap, (n,))

        motion = joined(v, w - assembly.gap)
        with progress_bar(progress, "recovery"):
            u, reactions, _ = self._displacements([amplitudes], motion[:, None])
        if gap is not None:
            warn_of_open_nodes(w, reactions[:, 0], float(np.abs(u).max()))
        displacement = {}
        strain = {}
        stress = {}
        for name in assembly.bodies:
            displacement[name] = frozen(u[assembly.rows[assembly.own_nodes[name]], 0].T)
            fields = self._nodal_fields(name, u, [amplitudes])
            strain[name], stress[name] = (frozen(field[..., 0]) for field in fields)
        q, p = parted(reactions[:, 0], d)
        return BodyFields(
            displacement,
            stress,
            strain,
            frozen(q),
            frozen(p),
            frozen(v),
            frozen(w),
            assembly.bodies,
            self.units,
            assembly.glued.interface.frames,
            assembly.sides,
        )

    def stress_map(
        self: Any,
        points: ArrayLike | None = None,
        depth: float | None = None,
        *,
        side: int = 1,
        body: str | None = None,
        progress: bool = True,
    ) -> StressMap:
        """Stress and strain at points as linear functions of the loads and the contact's motions.

        Give points and the name of their body, or a depth. There is one factorisation for all loads
        and motions.

        Parameters
        ----------
        points, body
            (P, d) places, and the name of the body that contains them. Nodal stresses are
            interpolated.
        depth, side
            Distance of the points from the nodes of the contact, along the normal into body `side`
            (1 or 2). 0: the points are on the face. Otherwise elements should be at most half as
            large as the depth.
        progress
            Whether to show a progress bar after two seconds.

        Returns
        -------
        StressMap
            Its system is the condensed model.

        Raises
        ------
        ModelError
            Points with a depth, or neither; points outside of their body; an unknown body or side.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
        >>> stresses = model.stress_map(points=[[0.0, -0.5]], body="block")
        >>> stress, strain = stresses.tensors({"P": 1.0}, slip=[0.0] * 5)
        >>> bool(stress[0, 1, 1] < 0)
        True
        """
        number = whole_number("side", side, least=1, most=2)
        assembly = self._assembly
        if depth is None and points is not None and body is not None:
            assembly.body("stress_map", body)
            at = finite_array("points", points, (None, assembly.points.shape[1]))
            names = np.full(len(at), body)
        elif depth is not None and points is None and body is None:
            depth = finite_number("depth", depth, least=0.0)
            sides = [(contact.body_1, contact.body_2)[number - 1] for contact in self.contacts]
            names = np.array(sides)[assembly.contact]
            shift = depth if number == 1 else -depth - assembly.gap
            normals = assembly.glued.interface.frames[:, -1]
            at = assembly.points[assembly.pairs.nodes] + np.multiply(shift, normals.T).T
        else:
            raise ModelError(
                "points, body, depth: give points and the name of their body, or a depth; a depth "
                "of half of the critical distance is common, and depth=0 has the points on the face"
            )
        on_face = depth == 0
        picked = assembly.sides[number - 1] if on_face else self._picked(at, names)
        cases = [{name: 1.0} for name in self.loads]
        size = len(assembly.contact) * assembly.points.shape[1]
        loads = [*cases, *([{}] * size)]
        motions = np.hstack([np.zeros((size, len(cases))), np.eye(size)])
        tensors = []
        with progress_bar(progress, "stress map", "motion", total=len(loads)) as bar:
            for first in range(0, len(loads), _BLOCK):
                block = slice(first, first + _BLOCK)
                u, _, _ = self._displacements(loads[block], motions[:, block])
                tensors.append(self._tensors_at(picked, u, loads[block]))
                bar.update(u.shape[1])
        both = np.concatenate(tensors)
        of_loads = dict(zip(self.loads, both, strict=False))
        return StressMap(self._condensed, at, of_loads, both[len(cases) :], on_face)

    def grids(self: Any, result: BodyFields | Steady | None = None) -> Any:
        """The bodies and the contacts as grids of PyVista (extra `view`), with their fields.

        `grids.plot()` shows them, in a notebook too, and `grids.save("joint.vtm")` writes a file
        for ParaView. `grids["contact"].plot(scalars="pressure")` shows a field.

        Parameters
        ----------
        result
            Fields from `recover`; or a steady state of the condensed model, shown at its last load
            corner; None: the meshes alone.

        Returns
        -------
        pyvista.MultiBlock
            A grid for each body, by its name, with "displacement", "von_mises", "stress" and
            "strain" (xx, yy, zz, xy, yz, xz). The last grid is "contact", the face of body 1 of
            every contact, with "displacement", "normal" (into body 1), "slip", "gap", "shear" (of
            body 2 on body 1, force per area) and "pressure"; for a steady state also with
            "work_density", the work of friction per cycle and area. The values "contact" of its
            cells are the numbers of their contacts.

        Raises
        ------
        ModelError
            pyvista is not installed; a result of another kind or of another model.

        Examples
        --------
        >>> import frictopt as fo
        >>> model = fo.scenes.SquarePunch(elements=2, growth=3.0).model()
        >>> fields = model.recover({"P": 1.0, "Qx": 0.3}, slip=[[0.0, 0.0]] * 9)
        >>> grids = model.grids(fields)
        >>> grids.keys()
        ['punch', 'block', 'contact']
        >>> f"{grids['contact']['pressure'].max():.3f}"
        '2.301'
        """
        # Imported here, because it needs models.
        from .grids import grids_of

        return grids_of(self, result)

    def _picked(self: Any, points: Array, names: Array) -> csr_matrix:
        """(P, all nodes) shape functions of the nodes at P points, each in the body of its name."""
        assembly = self._assembly
        picked = lil_matrix((len(points), len(assembly.points)))
        for name in np.unique(names).tolist():
            body = assembly.bodies[name]
            here = np.flatnonzero(names == name)
            try:
                functions = basis_of(body.mesh).probes(points[here].T)
            except ValueError as error:
                raise ModelError(
                    f"points, depth: a point is outside of body {name!r}; the points are from "
                    f"{place(points[here].min(axis=0))} to {place(points[here].max(axis=0))}; "
                    "move them, or reduce the depth"
                ) from error
            picked[np.ix_(here, assembly.own_nodes[name])] = functions
        return csr_matrix(picked)

    def _tensors_at(self: Any, picked: csr_matrix, u: Array, loads: Sequence[Loads]) -> Array:
        """(n, 2, P, 3, 3) stress and strain at points under n displacements u (size, n)."""
        found = np.zeros((2, picked.shape[0], 3, 3, u.shape[1]))
        for name, nodes in self._assembly.own_nodes.items():
            part = picked[:, nodes]
            if part.nnz:
                strain, stress = self._nodal_fields(name, u, loads)
                for of_kind, rows in zip(found, (stress, strain), strict=True):
                    of_kind += tensors_of([part @ row for row in rows])
        return np.moveaxis(found, -1, 0)

    def _state(
        self: Any,
        loads: Loads | Steady,
        slip: ArrayLike | None,
        gap: ArrayLike | None,
    ) -> tuple[Loads, ArrayLike, ArrayLike | None]:
        """Amplitudes of the load cases, slip and gap of the state that `recover` is called with."""
        if isinstance(loads, Steady):
            if slip is not None or gap is not None:
                raise ModelError(
                    "slip, gap: a steady state includes them; leave them out, or give the loads "
                    "of the state instead of the steady state"
                )
            steady: Any = loads
            loads = steady.cycle.at(steady.load_factor)[-1]
            slip = steady.slip / steady.system.stretch
            gap = steady.gap
        if slip is None:
            raise ModelError(
                "slip: None; give the slip (and the gap) of the state under these loads, or a "
                "steady state instead of the loads"
            )
        amplitudes = checked_loads("loads", loads)
        if unknown := sorted(set(amplitudes) - set(self.loads)):
            raise ModelError(
                f"load case {unknown[0]!r}: unknown; this model has {sorted(self.loads)}"
            )
        return amplitudes, slip, gap

    def _displacements(
        self: Any, loads: Sequence[Loads], motions: Array
    ) -> tuple[Array, Array, Array]:
        """(size, n) displacements and (d N, n) reactions under n loads and motions (d N, n).

        The third result has the forces (size, n) of supports and ties. A motion consists of slips,
        and of gaps minus initial gaps.
        """
        assembly = self._assembly
        n, d = len(assembly.contact), assembly.points.shape[1]
        has_locked_bolt = any(cut.bolt.locked for cut in assembly.cuts)
        bolts = self._condensed.bolts if has_locked_bolt else {}
        # The load case of a locked bolt is computed for a shortening of 1. At amplitude 1 the bolt
        # is shortened until it has its force in the glued bodies.
        shortenings = [bolts.get(name, (0.0, 1.0))[1] for name in self.loads]
        amounts = (amplitudes_of(loads, self.loads) * shortenings).T
        force, moved, overlaps = (part @ amounts for part in self._cases)
        net_force = force - assembly.whole @ moved
        if np.isfinite(self._springs).any():
            # The relative motion of the bodies is the motion of their surfaces minus the
            # deformation of the springs between them.
            system = self._condensed
            bonded = [joined(*system.reaction(amplitudes)) for amplitudes in loads]
            forces = np.column_stack(bonded) + system.S @ motions
            tangential, normal = self._springs
            compliance = compliances(tangential, normal, assembly.width, d - 1)
            motions = motions - compliance[:, None] * forces
        motions = motions + np.pad(overlaps, ((len(motions) - n, 0), (0, 0)))
        R, D = assembly.release
        y, reactions = self._recovery.displacements(R.T @ net_force, motions)
        w = R @ y + D @ net_force + moved
        return assembly.tied @ w, reactions, assembly.whole @ w - force

    def _nodal_fields(
        self: Any, name: str, u: Array, loads: Sequence[Loads]
    ) -> tuple[Array, Array]:
        """(components, nodes, n) strain and stress of a body under displacements u (size, n)."""
        assembly = self._assembly
        own = assembly.own_nodes[name]
        if name not in self._projections:
            seam = assembly.sector.seam(own)
            body = assembly.bodies[name]
            self._projections[name] = NodalFields(body, assembly.kinematics, seam)
        expansions = [
            (load, np.array([amplitudes.get(case, 0.0) for amplitudes in loads]))
            for case, parts in self.loads.items()
            if any(case in amplitudes for amplitudes in loads)
            for load in parts
            if isinstance(load, Expansion) and load.body == name
        ]
        fields: NodalFields = self._projections[name]
        return fields.of(u[assembly.rows[own]].transpose(1, 0, 2), expansions)

    def _over(self: Any, steady: Steady, *, every: bool) -> Iterator[BodyFields]:
        """The fields at the corners of a steady cycle, or with `every` at all its states."""
        states = steady.states()
        is_last = np.append(np.diff(states.time) > SIMULTANEOUS, True)  # last state of each time
        is_corner = np.abs(states.time - np.round(states.time)) <= SIMULTANEOUS
        for k in np.flatnonzero(is_last if every else is_last & is_corner).tolist():
            yield self._fields_of_state(states, k)

    def _fields_of_state(self: Any, states: Any, k: int) -> BodyFields:
        """The fields of state k of a steady cycle; they must agree with its reactions."""
        stretch = states.system.stretch
        loads = {
            case: amplitude
            for case, amplitude in zip(states.system.bonded, states.amplitudes[k], strict=True)
            if amplitude
        }
        fields: BodyFields = self.recover(loads, states.slip[k] / stretch, states.gap[k])
        _check_reactions(joined(fields.q, fields.p)[:, None], states, [k])
        return fields

    def _through_ties(self: Any, states: Any, rows: Integers) -> dict[str, Array]:
        """Tie -> (3, n) normal force, shear and moment at n states of a steady cycle."""
        assembly, system = self._assembly, states.system
        if self._condensed.points.shape != system.points.shape:
            raise ModelError(f"model: another one; {_ANOTHER}")
        loads = [dict(zip(system.bonded, states.amplitudes[k], strict=True)) for k in rows]
        motions = joined(states.slip / system.stretch, states.gap - assembly.gap)[rows].T
        _, reactions, forces = self._displacements(loads, motions)
        thickness = system.thickness or 1.0
        _check_reactions(thickness * reactions, states, rows)
        through = assembly.through_ties(forces, reactions)
        return {name: thickness * of_tie for name, of_tie in through.items()}

    @cached_property
    def _projections(self: Any) -> dict[str, NodalFields]:
        """The nodal fields of the bodies by name, each computed when it is first needed."""
        return {}

    @cached_property
    def _recovery(self: Any) -> Recovery:
        """The factorisation for `recover`."""
        return Recovery(self._assembly.glued)


def _check_reactions(reactions: Array, states: Any, rows: Sequence[int] | Integers) -> None:
    """Check that reactions (d N, n) of a model equal those of n states of a steady cycle."""
    expected = joined(states.q * states.system.stretch, states.p)[rows].T
    error = np.abs(reactions - expected).max()
    if error > EQUILIBRIUM * np.abs(states.p).max():
        raise ModelError(
            f"model: its reactions differ from those of the steady state by {error:.1e}; {_ANOTHER}"
        )
