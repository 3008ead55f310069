"""The conditions in force at the end of each step of a deck, as amplitudes of load cases."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from ..base import ROUNDING
from ..readers.deck_text import Block

Key: TypeAlias = tuple[object, ...]
"""A place where a load acts, after the name of its kind, such as ("CLOAD", row, axis)."""
Field: TypeAlias = Mapping[Key, float]
"""Place -> value of a load."""


@dataclass(frozen=True)
class State:
    """The conditions in force at the end of a step.

    `fields` maps the name of a target, such as "CLOAD NSIDE", to its loads. `held` are rows and
    axes of nodes, `locked` the nodes of bolts that keep their lengths.
    """

    name: str
    fields: Mapping[str, Field]
    held: frozenset[tuple[int, int]]
    locked: frozenset[int]


@dataclass
class InForce:
    """The conditions that are in force while steps are read.

    A load replaces that of earlier steps at its place. Loads of one step at one place add up.
    """

    loads: dict[Key, dict[str, float]] = field(default_factory=dict)
    held: dict[tuple[int, int], None] = field(default_factory=dict)
    locked: dict[int, None] = field(default_factory=dict)
    # tension of bolts at the end of the last step
    _tensions: dict[Key, dict[str, float]] = field(default_factory=dict)
    # places that got a load in this step, and kinds of its blocks
    _of_this_step: set[Key] = field(default_factory=set)
    _begun: set[tuple[str, ...]] = field(default_factory=set)

    def begin_step(self) -> None:
        """Begin a step: it replaces earlier loads."""
        self._of_this_step.clear()
        self._begun.clear()

    def begin(self, block: Block, *kinds: str) -> None:
        """Begin a block: the first one of its kinds in a step may remove all before it."""
        if block.parameters.get("OP") == "NEW" and kinds not in self._begun:
            self.loads = {key: load for key, load in self.loads.items() if key[0] not in kinds}
            if "BOUNDARY" in kinds:
                self.held.clear()
                self.locked.clear()
        self._begun.add(kinds)

    def add(self, key: Key, target: str, value: float) -> None:
        """Add a load to those of this step at its place."""
        if key not in self._of_this_step:
            self.loads[key] = {}
        self._of_this_step.add(key)
        here = self.loads[key]
        here[target] = here.get(target, 0.0) + value

    def replace(self, key: Key, target: str, value: float) -> None:
        """Replace the load at a place."""
        self.loads[key] = {target: value}

    def hold(self, row: int, axis: int, value: float, target: str) -> None:
        """Hold a node, and move it by a value."""
        self.held[row, axis] = None
        self.replace(("BOUNDARY", row, axis), target, value)

    def state(self, name: str) -> State:
        """The conditions that are in force now; a locked bolt keeps its last tension."""
        locked = {("BOLT", row) for row in self.locked}
        self.loads |= {key: load for key, load in self._tensions.items() if key in locked}
        self._tensions = {key: load for key, load in self.loads.items() if key[0] == "BOLT"}
        fields = defaultdict[str, dict[Key, float]](dict)
        for key, load in self.loads.items():
            for target, value in load.items():
                if value:
                    fields[target][key] = value
        return State(name, fields, frozenset(self.held), frozenset(self.locked))


def load_cases(
    states: Sequence[State],
) -> tuple[dict[str, Field], dict[str, dict[str, float]]]:
    """Load case -> its loads at amplitude 1; and state -> the amplitudes of the load cases.

    A load case is the load of a target as it is first given. If a later state gives the target a
    multiple, it is the same load case, and another one otherwise.
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
    """The number by which a load is a multiple of another one; 0 if it is none."""
    if given.keys() != unit.keys():
        return 0.0
    largest = max(unit, key=lambda key: abs(unit[key]))
    ratio = given[largest] / unit[largest]
    error = max(abs(value - ratio * unit[key]) for key, value in given.items())
    return ratio if error <= ROUNDING * abs(given[largest]) else 0.0
