"""Fields in the bodies of a model, at a state of its contact or during a steady cycle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    EQUILIBRIUM,
    RESIDUAL,
    SIMULTANEOUS,
    Array,
    checked_loads,
    finite_array,
    frozen,
    progress_bar,
)
from ..contact import ContactSystem, compliances, joined, parted
from ..errors import ModelError
from .load_cases import LoadCase
from .loads import Expansion
from .recovery import BodyFields, Recovery, Steady, strain_and_stress, warn_of_open_nodes


class Recoverable:
    """Base of models that recover fields in their bodies."""

    def recover(
        self: Any,
        loads: Mapping[str, float] | Steady,
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
            model: its last corner is the state.
        slip, gap
            Slip v, (N,) or (N, 2) in space, and gap w, (N,), of the state, length. Leave both out
            for a steady state. The gap includes the initial gap of this model; None: it is the
            initial gap.
        progress
            Whether to show a progress bar for the factorisation after two seconds.

        Warns
        -----
        ModelWarning
            Open nodes carry force. Then slip and gap do not belong to a state under these loads. Or
            the system has another initial gap or contact stiffness than the model (see
            `ContactSystem.with_gap`, `with_contact_stiffness`, and `Contact`).

        Raises
        ------
        ModelError
            A load case is unknown, slips or gaps have another shape or are not finite, or they are
            given beside a steady state.

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

        case = self._combined_case(amplitudes)
        moved = case.displacements
        net_force = case.forces - assembly.whole @ moved
        motion = joined(v, w - assembly.gap)
        if np.isfinite(self._springs).any():
            # The relative motion of the bodies is the motion of their surfaces minus the
            # deformation of the springs between them.
            system = self._condensed
            forces = joined(*system.reaction(amplitudes)) + system.S @ motion
            tangential, normal = self._springs
            motion -= compliances(tangential, normal, assembly.width, d - 1) * forces
        motion[-n:] += case.overlaps
        R, D = assembly.release
        with progress_bar(progress, "recovery"):
            y, reactions = self._recovery.displacements(R.T @ net_force, motion)
        if gap is not None:
            warn_of_open_nodes(w, reactions, float(np.abs(y).max()))
        u = assembly.tied @ (R @ y + D @ net_force + moved)
        displacement, strain, stress = self._body_fields(u, amplitudes)
        q, p = parted(reactions, d)
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

    def _state(
        self: Any,
        loads: Mapping[str, float] | Steady,
        slip: ArrayLike | None,
        gap: ArrayLike | None,
    ) -> tuple[Mapping[str, float], ArrayLike, ArrayLike | None]:
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

    def _combined_case(self: Any, amplitudes: Mapping[str, float]) -> LoadCase:
        """The sum of the load cases, times their amplitudes.

        The load case of a locked bolt is computed for a shortening of 1. At amplitude 1 the bolt is
        shortened until it has its force in the glued bodies.
        """
        assembly = self._assembly
        has_locked_bolt = any(cut.bolt.locked for cut in assembly.cuts)
        bolts = self._condensed.bolts if has_locked_bolt else {}
        forces = np.zeros(assembly.points.size)
        displacements = np.zeros(assembly.points.size)
        overlaps = np.zeros(len(assembly.contact))
        for name, amplitude in amplitudes.items():
            _, shortening = bolts.get(name, (0.0, 1.0))
            factor = amplitude * shortening
            case = self._cases[name]
            forces += factor * case.forces
            displacements += factor * case.displacements
            overlaps += factor * case.overlaps
        return LoadCase(forces, displacements, overlaps)

    def _body_fields(
        self: Any, u: Array, amplitudes: Mapping[str, float]
    ) -> tuple[dict[str, Array], dict[str, Array], dict[str, Array]]:
        """Displacement, strain and stress of each body, from the displacements u (size,)."""
        assembly = self._assembly
        expansions = [
            (amplitude, load)
            for name, amplitude in amplitudes.items()
            for load in self.loads[name]
            if isinstance(load, Expansion)
        ]
        displacement = {}
        strain = {}
        stress = {}
        for name, body in assembly.bodies.items():
            first = assembly.first_node[name]
            rows = assembly.rows[first : first + body.mesh.p.shape[1]]
            displacement[name] = frozen(u[rows].T)
            seam = assembly.sector.seam(first, body)
            strain[name], stress[name] = strain_and_stress(
                name, body, assembly.kinematics, displacement[name], expansions, seam
            )
        return displacement, strain, stress

    def _over(
        self: Any, steady: Steady, *, every: bool
    ) -> Iterator[tuple[float, BodyFields, dict[str, Any]]]:
        """Time, fields, and contact values (status and work) for states of a steady cycle.

        The states are the corners, or with `every` all states. A node slips if it has slipped since
        the state before.
        """
        states = steady.states()
        is_last = np.append(np.diff(states.time) > SIMULTANEOUS, True)  # last state of each time
        is_corner = np.abs(states.time - np.round(states.time)) <= SIMULTANEOUS
        before = 0
        for k in np.flatnonzero(is_last if every else is_last & is_corner).tolist():
            fields = self._fields_of_state(states, k)
            work = states.work[k] - states.work[0]
            slip = np.ptp(states.slip[before : k + 1], axis=0).reshape(len(work), -1).max(axis=1)
            slipped = slip > RESIDUAL * np.abs(states.slip).max()
            status = np.where(states.gap[k] > 0, 2, slipped).astype(np.int32)
            yield (
                float(states.time[k]),
                fields,
                {"status": status, "work": work, "work_density": work / self._assembly.width},
            )
            before = k

    def _fields_of_state(self: Any, states: Any, k: int) -> BodyFields:
        """The fields of state k of a steady cycle; they must agree with its reactions."""
        stretch = states.system.stretch
        loads = {
            case: amplitude
            for case, amplitude in zip(states.system.bonded, states.amplitudes[k], strict=True)
            if amplitude
        }
        fields: BodyFields = self.recover(loads, states.slip[k] / stretch, states.gap[k])
        error = max(
            np.abs(fields.q - states.q[k] * stretch).max(), np.abs(fields.p - states.p[k]).max()
        )
        if error > EQUILIBRIUM * np.abs(states.p).max():
            raise ModelError(
                "model: the reactions of its fields differ from the reactions of the steady "
                f"state by {error:.1e}; give "
                "the model that its system was condensed from"
            )
        return fields

    @cached_property
    def _condensed(self: Any) -> ContactSystem:
        """The condensed system, for `recover`."""
        system: ContactSystem = self.condense()
        return system

    @cached_property
    def _recovery(self: Any) -> Recovery:
        """The factorisation for `recover`."""
        return Recovery(self._assembly)
