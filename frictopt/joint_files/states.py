"""The conditions in force at the end of each step of a deck, as amplitudes of load cases."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from ..base import ROUNDING
from ..readers.deck_text import Block

Key: TypeAlias = tuple[object, ...]
"""The kind of a load and the place where it acts, such as ("CLOAD", row, axis)."""
Field: TypeAlias = Mapping[Key, float]
"""Place -> value of a load."""


@dataclass(frozen=True)
class State:
    """The conditions in force at the end of a step, or at a time within it.

    `fields` maps the name of a target, such as "CLOAD NSIDE", to its loads. `locked` are the nodes
    of bolts that keep their lengths.
    """

    name: str
    fields: Mapping[str, Field]
    setting: "Setting"
    locked: frozenset[int]


@dataclass(frozen=True)
class Setting:
    """The parts of a state that all states of a load cycle share.

    `held` has the rows and axes of held nodes, and `removed` the surfaces of pairs that are not in
    force. `friction` maps interactions to coefficients, and `glued` has the interactions whose
    pairs are ties.
    """

    held: frozenset[tuple[int, int]]
    removed: frozenset[tuple[str, ...]]
    friction: Mapping[str, float]
    glued: frozenset[str]


@dataclass
class InForce:
    """The conditions that are in force while steps are read.

    A load replaces the load of earlier steps at the same place. Loads of one step at one place add
    up. A load without an amplitude changes in proportion to the time of its step; `share` is the
    part of the step that is over.
    """

    loads: dict[Key, dict[str, float]] = field(default_factory=dict)
    held: dict[tuple[int, int], None] = field(default_factory=dict)
    locked: dict[int, None] = field(default_factory=dict)
    removed: dict[tuple[str, ...], None] = field(default_factory=dict)
    share: float = 1.0
    # loads at the end of the last step
    _before: Mapping[Key, Mapping[str, float]] = field(default_factory=dict)
    # places that have got a load in this step, and the kinds of blocks that have begun in it
    _of_this_step: set[Key] = field(default_factory=set)
    _begun: set[tuple[str, ...]] = field(default_factory=set)

    def next_step(self, share: float) -> "InForce":
        """The conditions at the beginning of the next step."""
        return InForce(
            {**self.loads}, {**self.held}, {**self.locked}, {**self.removed}, share, self.loads
        )

    def begin(self, block: Block, *kinds: str) -> None:
        """Begin a block.

        With OP=NEW, the first block of these kinds in a step removes earlier loads.
        """
        if block.parameters.get("OP") == "NEW" and kinds not in self._begun:
            for key in [key for key in self.loads if key[0] in kinds]:
                self.loads[key] = self._fading(key)
            if "BOUNDARY" in kinds:
                self.held.clear()
                self.locked.clear()
        self._begun.add(kinds)

    def _fading(self, key: Key) -> dict[str, float]:
        """The load of earlier steps that is left at a place."""
        earlier = self._before.get(key, {})
        return {target: value * (1 - self.share) for target, value in earlier.items()}

    def add(self, key: Key, target: str, value: float, amplitude: float | None) -> None:
        """Add a load to the loads of this step at the same place."""
        if key not in self._of_this_step:
            self.loads[key] = self._fading(key) if amplitude is None else {}
        self._of_this_step.add(key)
        here = self.loads[key]
        factor = self.share if amplitude is None else amplitude
        here[target] = here.get(target, 0.0) + value * factor

    def replace(self, key: Key, target: str, value: float, amplitude: float | None) -> None:
        """Replace the load at a place."""
        self._of_this_step.discard(key)
        self.add(key, target, value, amplitude)

    def state(self, name: str, friction: Mapping[str, float], glued: Iterable[str]) -> State:
        """The conditions in force now; a locked bolt keeps its load of the last step."""
        locked = {("BOLT", row) for row in self.locked}
        self.loads |= {key: dict(self._before[key]) for key in locked if key in self._before}
        fields = defaultdict[str, dict[Key, float]](dict)
        for key, load in self.loads.items():
            for target, value in load.items():
                if value:
                    fields[target][key] = value
        setting = Setting(
            frozenset(self.held), frozenset(self.removed), {**friction}, frozenset(glued)
        )
        return State(name, fields, setting, frozenset(self.locked))


def load_cases(
    states: Sequence[State],
) -> tuple[dict[str, Field], dict[str, dict[str, float]]]:
    """Load case -> its loads at amplitude 1; and state -> the amplitudes of the load cases.

    The first load on a target is a load case. If a later load on this target is a multiple of the
    first, both are amplitudes of one load case; otherwise the later load is a new load case.
    """
    cases: dict[str, Field] = {}
    of_target = defaultdict[str, list[str]](list)
    amplitudes: dict[str, dict[str, float]] = {}
    for state in states:
        amplitudes[state.name] = {}
        for target, given in state.fields.items():
            for name in of_target[target]:
                amplitude = _multiple(given, cases[name])
                if amplitude:
                    break
            else:
                name = f"{target} ({state.name})" if of_target[target] else target
                amplitude = 1.0
                cases[name] = given
                of_target[target].append(name)
            amplitudes[state.name][name] = amplitude
    return cases, amplitudes


def _multiple(given: Field, unit: Field) -> float:
    """The number by which a load is a multiple of another load; 0 if it is not a multiple."""
    if given.keys() != unit.keys():
        return 0.0
    largest = max(unit, key=lambda key: abs(unit[key]))
    ratio = given[largest] / unit[largest]
    error = max(abs(value - ratio * unit[key]) for key, value in given.items())
    return ratio if error <= ROUNDING * abs(given[largest]) else 0.0
