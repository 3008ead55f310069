"""A joint of a file: its contact model, its friction, and the states for its load cycles."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..base import Array, Loads, Shown
from ..base.entries import known
from ..contact import ContactSystem, LoadCycle
from ..contact.diagnosis import nodes_of_contacts
from ..errors import ModelError
from ..fem.model import ContactModel
from ..joints.scatter import at_share
from ..joints.tightening import tightened

_OTHER_TIMES = "; for another time of a step give the load cases then, CASE=X,CASE=Y"


@dataclass(frozen=True, eq=False, repr=False)
class Joint(Shown):
    """A joint of a file, see `read_joint`; `print` shows all that was read.

    Attributes
    ----------
    name
        The name of the file.
    model
        The `ContactModel`. In the plane its forces are per unit depth.
    thickness
        Thickness of plane bodies; the forces of `system()` are totals over it. None: per depth.
    states
        State -> load case -> amplitude. Each static step has a state at its end, such as "STEP 1".
        Within the step, "STEP 1@0.25" is a state at a time at which the amplitude table of a load
        has an entry.
    friction
        Contact -> coefficient of friction, (least, nominal, most), or a distribution.
    interactions
        `*SURFACE INTERACTION` -> its contacts.
    left_out
        Sentences on parts of the file that the model does not have.
    unlike
        States whose supports, contact pairs or friction differ from the last step. The model has
        the supports, pairs and friction of the last step.
    locked
        States in which bolts keep their lengths.
    units
        Names of the units of force and length, such as "N, mm".
    asked
        The load cycle of a joint file: its `mean` and `corners`, or `harmonic` loads.
    of_report
        Arguments of `report` from a joint file: `title`, `preload`, `load`, `correlation_length`,
        `limits`.

    Examples
    --------
    >>> import frictopt as fo
    >>> joint = fo.read_joint("tests/data/block.inp")
    >>> joint.states["STEP 2"]
    {'DLOAD ETOP P3': 1.0, 'CLOAD NLEFT': 1.0}
    """

    name: str
    model: ContactModel
    thickness: float | None
    states: Mapping[str, Loads]
    friction: Mapping[str, Any]
    interactions: Mapping[str, Sequence[str]]
    left_out: Sequence[str] = ()
    unlike: Sequence[str] = ()
    locked: Sequence[str] = ()
    units: str | None = None
    asked: Mapping[str, Any] = field(default_factory=dict)
    of_report: Mapping[str, Any] = field(default_factory=dict)

    def _answer(self) -> Mapping[str, object]:
        states = {}
        for name, loads in self.states.items():
            parts = [f"{case}={amplitude:g}" for case, amplitude in loads.items()]
            states[name] = ", ".join(parts) or "no load"
        return {
            "name": self.name,
            **self.model._answer(),
            "supports": [str(support) for support in self.model.supports],
            "friction": dict(self.friction),
            "states": states,
            "left_out": self.left_out,
        }

    def system(self) -> ContactSystem:
        """The condensed contact, with forces that are totals over the thickness of plane bodies.

        `ContactModel.condense` describes it, and its errors.
        """
        return self._system

    @cached_property
    def _system(self) -> ContactSystem:
        system = replace(self.model.condense(), units=self.units)
        t = self.thickness
        if not system.per_depth or t is None:
            return system
        return replace(
            system,
            S=t * system.S,
            bonded={case: (t * q, t * p) for case, (q, p) in system.bonded.items()},
            width=t * np.asarray(system.width),
            compliance=t * np.asarray(system.compliance),
            bolts={case: (t * force, length) for case, (force, length) in system.bolts.items()},
            load_size={case: t * size for case, size in system.load_size.items()},
            thickness=t,
        )

    def cycle(
        self,
        mean: str | Loads | None = None,
        corners: Iterable[str | Loads] | None = None,
        friction: Any = None,
    ) -> LoadCycle:
        """A load cycle of the joint, from states, from load cases, or from both.

        Parameters
        ----------
        mean
            A state, "STEP 1"; load cases, "BOLT SECTION=1,CLOAD NSIDE=0.5" or a mapping; or both,
            "STEP 1,CLOAD NSIDE=0.5". It must press a contact. None: the mean load of the joint
            file.
        corners
            Load corners in the same form. A corner that names a state is this state minus the mean
            load. Load cases alone act on top of the mean load. None: the corners of the joint file.
        friction
            Friction with which locked bolts are tightened; None: the friction of the file.

        Returns
        -------
        LoadCycle
            At load factor 1 the cycle has the loads of the file. Locked bolts are tightened under
            the loads of the last state before their lengths are kept, see `tightened`.

        Raises
        ------
        ModelError
            A state or load case is unknown. A state has other supports than the model. A corner
            tightens a locked bolt. The mean load presses no contact: the error names load cases
            that do.

        Examples
        --------
        >>> import frictopt as fo
        >>> joint = fo.read_joint("tests/data/block.inp")
        >>> cycle = joint.cycle("STEP 1", ["STEP 2", "CLOAD NLEFT=-2"])
        >>> [dict(corner) for corner in cycle.corners]
        [{'CLOAD NLEFT': 1.0}, {'CLOAD NLEFT': -2.0}]
        """
        mean = self.asked.get("mean") if mean is None else mean
        corners = self._corners() if corners is None else corners
        if mean is None or corners is None:
            raise ModelError(
                f"mean, corners: give both, of the states {[*self.states]}, and of the load cases "
                f"{[*self.model.loads]} as CASE=X"
            )
        state, base = self._loads(mean)
        changes = [self._change(corner, base) for corner in corners]
        system = self.system()
        if not base or not _presses(system, system.reaction(base)[1]):
            raise ModelError(
                f"mean: {mean!r} presses no contact; load cases that press: {self.pressing}; give "
                f"one of them, such as {next(iter(self.pressing), 'BOLT SECTION')}=1"
            )
        cycle = LoadCycle(base, changes)
        if not system.bolts.keys() & base.keys():
            return cycle
        tight = replace(cycle, mean=self._when_tightened(state, base))
        nominal = self.friction if friction is None else friction
        nominal = at_share(nominal, 0.5)
        tight = tightened(system, tight, nominal)
        bolts = {case: tight.mean[case] for case in system.bolts if case in tight.mean}
        return replace(cycle, mean={**base, **bolts})

    def _change(self, corner: str | Loads, base: Loads) -> dict[str, float]:
        """The loads of a corner on top of the mean load."""
        state, change = self._loads(corner)
        if state:
            cases = {**base, **change}
            change = {case: change.get(case, 0.0) - base.get(case, 0.0) for case in cases}
        change = {case: amplitude for case, amplitude in change.items() if amplitude}
        if self.system().bolts.keys() & change.keys():
            raise ModelError(
                f"corners: {corner!r} tightens a bolt whose length is kept in {self.locked}; name "
                "only such states"
            )
        return change

    def _when_tightened(self, state: str, base: Loads) -> Loads:
        """The loads under which the bolts of a mean load are tightened."""
        loads = base
        if state in self.locked:
            for name in [*self.states][: [*self.states].index(state)]:
                loads = loads if name in self.locked else self.states[name]
        return loads

    def _corners(self) -> Any:
        """The corners of the joint file."""
        if "harmonic" not in self.asked:
            return self.asked.get("corners")
        _, loads = self._loads(self.asked["harmonic"])
        points = self.asked.get("points", 16)
        return LoadCycle.harmonic(loads, mean={}, points=points).corners

    def _loads(self, given: str | Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
        """The state that a text names ("" if none), and all loads that the text gives."""
        if not isinstance(given, str):
            cases = self.model.loads
            return "", {known("load case", case, cases): value for case, value in given.items()}
        total = dict[str, float]()
        state = ""
        for part in given.split(","):
            name, equals, value = part.rpartition("=")
            loads: Loads
            if equals:
                loads = {known("load case", name, self.model.loads): _number(part, value)}
            else:
                state = known("state", part, self.states, _OTHER_TIMES)
                loads = self.states[state]
            for case, amplitude in loads.items():
                total[case] = total.get(case, 0.0) + amplitude
        if state in self.unlike:
            raise ModelError(
                f"state {state!r} has other supports, contact pairs or friction than the last "
                "step; write those of a load cycle into all its steps"
            )
        return state, total

    @cached_property
    def pressing(self) -> list[str]:
        """Load cases that press a contact."""
        bonded = self.system().bonded
        return [case for case, (_, p) in bonded.items() if _presses(self.system(), p)]

    @property
    def suggestion(self) -> str:
        """Options for a command: mean load (first state that presses), corners (later states)."""
        names = [name for name in self.states if name not in self.unlike]
        presses = set(self.pressing)
        mean = next((name for name in names if self.states[name].keys() & presses), "")
        corners = names[names.index(mean) + 1 :] if mean else []
        if not corners:
            mean = ",".join(f"{case}=1" for case in self.pressing)
            cases = self.model.loads
            case = next((case for case in cases if case not in presses), next(iter(cases)))
            corners = [f"{case}=0.5", f"{case}=-0.5"]
        corners_in_words = " ".join(f'"{corner}"' for corner in corners)
        return f'--mean "{mean}" --corners {corners_in_words}'

    def friction_with(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The friction, with other values for some contacts or interactions."""
        friction = dict(self.friction)
        for name, value in given.items():
            found = known("friction of", name, {**self.interactions, **self.friction})
            friction.update(dict.fromkeys(self.interactions.get(found, [found]), value))
        return friction


def _presses(system: ContactSystem, p: Array) -> bool:
    """Whether normal forces (N,) press a contact as a whole."""
    sums = [p[nodes].sum() for nodes in nodes_of_contacts(system).values()]
    return bool(max(sums) > 1e-6 * np.abs(p).sum())


def _number(part: str, value: str) -> float:
    try:
        return float(value)
    except ValueError as error:
        raise ModelError(f"{part!r}: {value!r} is no number; give CASE=AMPLITUDE") from error
