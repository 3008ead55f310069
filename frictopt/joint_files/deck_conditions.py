"""The parts of a deck apart from its mesh: materials, contacts, bolts, supports, loads of steps."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..base import ROUNDING, Array
from ..readers.deck import Deck
from ..readers.deck_text import Block, entries, number, reading
from ..readers.keywords import KEPT
from ..readers.listing import HELD_BY_NAME
from .refused import OUTPUT, WITHOUT_EFFECT
from .states import InForce, Key, State

# Keywords that are read before all others, wherever they stand, because other keywords refer to
# them: loads to bolts and couplings, contact pairs to interactions, and the axis of a ring to a
# tie.
_FIRST = set(
    "PRE-TENSIONSECTION COUPLING KINEMATIC DISTRIBUTING RIGIDBODY TIE SURFACEINTERACTION "
    "SURFACEBEHAVIOR FRICTION".split()
)

# Largest number of times within a step that become states: load cycles have few corners, but
# measured loads have thousands.
_MOST_TURNS = 100


class Pair(NamedTuple):
    """A contact pair or tie: its surfaces, its interaction ("" in a *TIE), and its block.

    `adjust` is the distance within which nodes of the slave move onto the master, or the rows of
    the nodes that move.
    """

    slave: str
    master: str
    interaction: str
    block: Block
    adjust: float | Sequence[int] | None


class Coupled(NamedTuple):
    """A face that is coupled to a point; `turns` is the node that has the point's rotations."""

    where: str
    is_rigid: bool
    turns: int | None
    block: str


class Conditions:
    """The content of a deck apart from its mesh. Nodes are given as rows of the deck.

    Each method `_read_...` reads the blocks of the keyword in its name. If faces are rough,
    contacts have the stiffness that the deck gives.
    """

    def __init__(self, deck: Deck, blocks: Sequence[Block], *, is_rough: bool) -> None:
        self.deck = deck
        self.is_rough = is_rough
        self.left_out = dict[str, None]()
        # material -> keyword -> constants
        self.materials = dict[str, dict[str, list[float]]]()
        # element set, and its material
        self.sections = list[tuple[str, str]]()
        # interaction -> friction
        self.friction = dict[str, float]()
        # interaction -> tangential and normal stiffness of its faces
        self.stiffness = dict[str, list[float]]()
        self.pairs = list[Pair]()
        self.ties = list[Pair]()
        # interactions whose pairs are ties at present
        self.glued = set[str]()
        # tie of a sector, and two points (3,) on its axis
        self.cuts = dict[str, Pair]()
        self.axes = dict[str, Array]()
        # surfaces of a pair -> gap; a negative gap is an overlap
        self.clearances = dict[tuple[str, str], float]()
        # node -> section
        self.bolts = dict[int, str]()
        self.couplings = dict[int, Coupled]()
        # node with a *TRANSFORM -> its axes: (3, 3) matrix whose rows are unit vectors
        self.turned = dict[int, Array]()
        self.states = list[State]()

        self._row = {int(node): row for row, node in enumerate(deck.numbers)}
        # amplitude -> its times and values, and whether the times count from the beginning of all
        # steps
        self._amplitudes = dict[str, tuple[list[float], list[float], bool]]()
        self._initial = dict[int, float]()
        self._in_force = InForce()
        self._step_name = "MODEL"
        self._interaction = ""
        self._constants = dict[str, list[float]]()
        self._coupled: Mapping[str, str] = {}
        self._steps = 0
        self._is_static = False
        # time at which the step begins, its duration, and the time within it at which loads are
        # read
        self._start, self._period, self._time = 0.0, 1.0, 1.0
        steps = [i for i, block in enumerate(blocks) if block.keyword == "STEP"]
        model = blocks[: (steps or [len(blocks)])[0]]
        for block in sorted(model, key=_rank):
            self._read(block)
        for start, end in pairwise([*steps, len(blocks)]):
            self._follow(blocks[start:end])

    def _follow(self, blocks: Sequence[Block]) -> None:
        """Read the blocks of a step at each of its times that become states, and at its end."""
        self._steps += 1
        self._step_name = blocks[0].parameters.get("NAME", f"STEP {self._steps}")
        self._is_static = False
        self._period = 1.0
        self._is_linear = "PERTURBATION" in blocks[0].parameters
        for block in blocks:
            if block.keyword == "STATIC":
                self._read(block)
        before = self._in_force
        # AMPLITUDE=STEP: loads without an amplitude of their own jump at the beginning of the step.
        is_jump = blocks[0].parameters.get("AMPLITUDE") == "STEP"
        for time in [*self._turns(blocks), self._period]:
            self._time = time
            self._in_force = before.next_step(1.0 if is_jump else time / self._period)
            for block in blocks:
                self._read(block)
            if self._is_static:
                at = f"@{time:g}" if time < self._period else ""
                name = f"{self._step_name}{at}"
                self.states.append(self._in_force.state(name, self.friction, self.glued))
        self._start += self._period
        if not self._is_static:
            self.left_out[f"{self._step_name}: no *STATIC, or a PERTURBATION"] = None

    def _turns(self, blocks: Sequence[Block]) -> list[float]:
        """The times within a static step at which amplitude tables of its loads have an entry."""
        turns = {
            time
            for block in blocks[1:]
            if block.parameters.get("AMPLITUDE") in self._amplitudes
            for time in self._table(block)[0].tolist()
        }
        within = sorted(time for time in turns if 0 < time < self._period and self._is_static)
        if len(within) > _MOST_TURNS:
            text = f"{self._step_name}: states at {len(within)} times of its amplitudes"
            self.left_out[text] = None
            return []
        return within

    def _read(self, block: Block) -> None:
        read = getattr(self, f"_read_{block.keyword.lower().replace('-', '')}", None)
        if read is None:
            known = {*KEPT, *WITHOUT_EFFECT}
            if block.keyword not in known and not block.keyword.endswith(OUTPUT):
                self.left_out[f"*{block.keyword}: not read"] = None
            return
        with reading(block):
            read(block)

    def _rows(self, entry: str) -> Sequence[int]:
        """Nodes that an entry names, by a number or a set."""
        return [self._row[int(entry)]] if entry.isdecimal() else self.deck.nodes(entry).tolist()

    def _target(self, keyword: str, entry: str, label: str = "") -> str:
        """The name of the load case of an entry; all node numbers of a step share one load case."""
        if entry.isdecimal():
            return f"{keyword} ({self._step_name})"
        return f"{keyword} {entry.upper()} {label}".strip()

    def _factor(self, block: Block) -> float | None:
        """The amplitude of a block at the time that is read; None if it names no amplitude."""
        if "AMPLITUDE" not in block.parameters:
            return None
        return float(np.interp(self._time, *self._table(block)))

    def _table(self, block: Block) -> tuple[Array, list[float]]:
        """The times (counted in this step) and the values of the amplitude of a block."""
        times, values, of_all_steps = self._amplitudes[block.parameters["AMPLITUDE"]]
        delay = number(block.parameters.get("TIMEDELAY", "0"))
        return np.array(times) + delay - of_all_steps * self._start, values

    # The model.

    def _read_element(self, block: Block) -> None:
        kind = block.parameters["TYPE"]
        if kind.startswith(("C3D", "CP", "CAX")) and kind[-1] in "RI":
            self.left_out[f"{kind}: its elements are integrated in full"] = None

    def _read_material(self, block: Block) -> None:
        self._constants = self.materials.setdefault(block.parameters["NAME"], {})

    def _read_elastic(self, block: Block) -> None:
        self._constants[block.keyword] = [number(entry or "0") for entry in entries(block.lines[0])]

    _read_density = _read_expansion = _read_elastic

    def _read_plastic(self, block: Block) -> None:
        self.left_out[f"*{block.keyword}: bodies are elastic"] = None

    _read_creep = _read_hyperelastic = _read_plastic
    _read_cyclichardening = _read_deformationplasticity = _read_plastic

    def _read_solidsection(self, block: Block) -> None:
        self.sections.append((block.parameters["ELSET"], block.parameters["MATERIAL"]))

    def _read_surfaceinteraction(self, block: Block) -> None:
        self._interaction = block.parameters["NAME"]
        self.friction[self._interaction] = 0.0
        self.stiffness[self._interaction] = [np.inf, np.inf]

    def _read_friction(self, block: Block) -> None:
        coefficient, *slope = entries(block.lines[0])
        self.friction[self._interaction] = number(coefficient)
        if any(slope) and self.is_rough:
            self.stiffness[self._interaction][0] = number(slope[0])
        elif any(slope):
            self.left_out["*FRICTION: stick slope"] = None

    def _read_surfacebehavior(self, block: Block) -> None:
        kind = block.parameters.get("PRESSURE-OVERCLOSURE", "HARD")
        self.glued.discard(self._interaction)
        if kind == "TIED":
            self.glued.add(self._interaction)
        elif kind == "LINEAR" and self.is_rough:
            self.stiffness[self._interaction][1] = number(block.rows[0][0])
        elif kind != "HARD" and self.is_rough:
            raise ValueError(f'stiffness="deck" needs LINEAR, not {kind}')
        elif kind != "HARD":
            self.left_out["*SURFACE BEHAVIOR: contact stiffness (penalty)"] = None

    def _read_contactpair(self, block: Block) -> None:
        if self._steps:
            raise ValueError("write it above the first *STEP")
        interaction = block.parameters["INTERACTION"]
        _ = self.friction[interaction]  # an error if it is not in this deck
        self.pairs += self._pairs(block, interaction, "ADJUST")

    def _pairs(self, block: Block, interaction: str, parameter: str) -> Iterator[Pair]:
        """The pairs of a block, whose `parameter` says which nodes move onto the master."""
        adjust: float | Sequence[int] | None = None
        if entry := block.parameters.get(parameter):
            adjust = self.deck.nodes(entry).tolist() if entry in self.deck.sets else number(entry)
        for row in block.rows:
            slave, master = [*map(str.upper, row), ""][:2]
            yield Pair(slave, master, interaction, block, adjust)

    def _read_tie(self, block: Block) -> None:
        pairs = self._pairs(block, "", "POSITIONTOLERANCE")
        if "CYCLICSYMMETRY" in block.parameters:
            (self.cuts[block.parameters.get("NAME", "")],) = pairs
        else:
            self.ties += pairs

    def _read_cyclicsymmetrymodel(self, block: Block) -> None:
        name = block.parameters.get("TIE") or next(iter(self.cuts), "")
        if name not in self.cuts:
            raise ValueError(f"there is no *TIE, CYCLIC SYMMETRY, NAME={name}")
        self.axes[name] = np.reshape([*map(number, block.rows[0])], (2, 3))

    def _read_clearance(self, block: Block) -> None:
        surfaces = self._surfaces_of_pair(block.parameters["SLAVE"], block.parameters["MASTER"])
        self.clearances[surfaces] = number(block.parameters["VALUE"])

    def _surfaces_of_pair(self, slave: str, master: str) -> tuple[str, str]:
        surfaces = slave.upper(), master.upper()
        if surfaces not in [pair[:2] for pair in self.pairs]:
            raise ValueError(f"no *CONTACT PAIR has the surfaces {surfaces}")
        return surfaces

    def _read_pretensionsection(self, block: Block) -> None:
        self.bolts[self._row[int(block.parameters["NODE"])]] = block.parameters["SURFACE"]

    def _read_coupling(self, block: Block) -> None:
        self._coupled = block.parameters

    def _read_kinematic(self, block: Block) -> None:
        axes = [int(entry) for row in block.rows for entry in row]
        if axes and (min(axes) > 1 or max(axes) < 3):
            raise ValueError("it leaves displacements free; give 1, 3")
        self._couple(block, self._coupled, "SURFACE")

    _read_distributing = _read_kinematic

    def _read_rigidbody(self, block: Block) -> None:
        self._couple(block, block.parameters, "NSET")

    def _couple(self, block: Block, parameters: Mapping[str, str], where: str) -> None:
        turns = block.parameters.get("ROTNODE")
        is_rigid = block.keyword != "DISTRIBUTING"
        row = None if turns is None else self._row[int(turns)]
        node = self._row[int(parameters["REFNODE"])]
        self.couplings[node] = Coupled(parameters[where], is_rigid, row, block.title)

    def _read_transform(self, block: Block) -> None:
        points = [number(entry) for row in block.rows for entry in row]
        if len(points) != 6:
            raise ValueError(f"{len(points)} coordinates; give those of two points")
        one, two = np.reshape(points, (2, 3))
        for row in self._rows(block.parameters["NSET"]):
            first, third = one, np.cross(one, two)
            if block.parameters.get("TYPE") == "C":
                # The first axis points away from the line through both points.
                third = two - one
                first = np.cross(third, np.cross(self.deck.points[row] - one, third))
            axes = np.array([first, np.cross(third, first), third])
            lengths = np.linalg.norm(axes, axis=1, keepdims=True)
            if lengths.min() <= ROUNDING * lengths.max():
                raise ValueError(f"no axes at node {self.deck.numbers[row]}; leave it out")
            self.turned[row] = axes / lengths

    def _read_amplitude(self, block: Block) -> None:
        values = [number(entry) for row in block.rows for entry in row]
        if not values or len(values) % 2 or (np.diff(values[::2]) <= 0).any():
            raise ValueError(
                "give a time and a value, and so on; times rise, also at a jump: .5, .501"
            )
        of_all_steps = block.parameters.get("TIME", "").startswith("TOTAL")
        self._amplitudes[block.parameters["NAME"]] = values[::2], values[1::2], of_all_steps

    def _read_initialconditions(self, block: Block) -> None:
        if block.parameters["TYPE"] != "TEMPERATURE":
            return
        for where, temperature, *_ in block.rows:
            self._initial.update(dict.fromkeys(self._rows(where), number(temperature)))

    # The steps.

    def _read_step(self, block: Block) -> None:
        if any(state.name == self._step_name for state in self.states):
            raise ValueError("another step has this name; give each its own")
        if block.parameters.get("NLGEOM", "NO") != "NO":
            self.left_out["NLGEOM: displacements are small"] = None

    def _read_static(self, block: Block) -> None:
        self._is_static = not self._is_linear
        _, period, *_ = [*entries("".join(block.lines[:1])), "", ""]
        # A period that is missing or 0 counts as 1.
        self._period = number(period or "1") or 1.0
        if self._period < 0:
            raise ValueError(f"period {period}; give one above 0")

    def _read_modelchange(self, block: Block) -> None:
        for row in block.rows:
            surfaces = self._surfaces_of_pair(*row[:2])
            self._in_force.removed[surfaces] = None
            if "REMOVE" not in block.parameters:
                del self._in_force.removed[surfaces]

    def _read_changefriction(self, block: Block) -> None:
        self._interaction = block.parameters["INTERACTION"]
        _ = self.friction[self._interaction]  # an error if it is not in this deck

    _read_changesurfacebehavior = _read_changefriction

    def _read_boundary(self, block: Block) -> None:
        self._in_force.begin(block, "BOUNDARY")
        for line in block.lines:
            where, first, last, value, *_ = [*entries(line), "", "", ""]
            axes = HELD_BY_NAME.get(first.upper()) or range(_axis(first), _axis(last or first) + 1)
            for row in self._rows(where):
                for axis in axes:
                    if row in self.bolts:
                        self._hold_bolt(block, row, axis)
                    elif "FIXED" in block.parameters:
                        raise ValueError("FIXED is read for bolts; give the displacement")
                    else:
                        self._in_force.held[row, axis] = None
                        place = ("BOUNDARY", row, axis)
                        target = self._target("BOUNDARY", where)
                        moved = number(value or "0")
                        self._in_force.replace(place, target, moved, self._factor(block))

    def _hold_bolt(self, block: Block, row: int, axis: int) -> None:
        if axis > 0:
            return
        if "FIXED" not in block.parameters:
            raise ValueError("tighten a bolt by *CLOAD, and keep its length by *BOUNDARY, FIXED")
        self._in_force.locked[row] = None

    def _read_cload(self, block: Block) -> None:
        self._in_force.begin(block, "CLOAD", "BOLT")
        for line in block.lines:
            where, axis, value = entries(line)[:3]
            for row in self._rows(where):
                key: Key = ("CLOAD", row, _axis(axis))
                target = self._target("CLOAD", where)
                if row in self.bolts:
                    key = ("BOLT", row)
                    target = f"BOLT {self.bolts[row]}"
                elif row in self.couplings:
                    target = f"CLOAD {where.upper()}"
                self._in_force.add(key, target, number(value), self._factor(block))

    def _read_dload(self, block: Block) -> None:
        self._in_force.begin(block, "FACE", "GRAV", "CENTRIF")
        for line in block.lines:
            where, label, *listed = entries(line.upper())
            size, *axis = [number(entry) for entry in listed]
            factor = self._factor(block)
            if label == "GRAV":
                axis = (np.array(axis) / np.linalg.norm(axis)).tolist()
            if label in ("GRAV", "CENTRIF"):
                self._in_force.add((label, where, *axis), self._target(label, where), size, factor)
                continue
            for face in self._faces(block, where, label):
                self._in_force.add(face, self._target(block.keyword, where, label), size, factor)

    _read_dsload = _read_dload

    def _faces(self, block: Block, where: str, label: str) -> Iterator[Key]:
        """The faces that a pressure acts on: element, and number of the face."""
        if block.keyword == "DSLOAD" and label == "P":
            for members, face in self.deck.surfaces[where]:
                yield from (("FACE", element, face) for element in members.tolist())
        elif block.keyword == "DLOAD" and label[:1] == "P" and label[1:].isdecimal():
            elements = [int(where)] if where.isdecimal() else self.deck.element_sets[where]
            yield from (("FACE", int(element), int(label[1:])) for element in elements)
        else:
            raise ValueError(f"the load {label} is not read; give P1 to P6, P, GRAV or CENTRIF")

    def _read_temperature(self, block: Block) -> None:
        self._in_force.begin(block, "TEMPERATURE")
        for where, temperature, *_ in block.rows:
            factor = self._factor(block)
            value = number(temperature) * (1.0 if factor is None else factor)
            of_rise = None if factor is None else 1.0
            for row in self._rows(where):
                rise = value - self._initial.get(row, 0.0)
                target = self._target("TEMPERATURE", where)
                self._in_force.replace(("TEMPERATURE", row, 0), target, rise, of_rise)


def _rank(block: Block) -> int:
    """Rank of a block of the model: lower ranks are read first, equal ranks in their order."""
    # A clearance refers to a contact pair, so it is read last.
    return 2 if block.keyword == "CLEARANCE" else block.keyword not in _FIRST


def _axis(direction: str) -> int:
    if not 1 <= int(direction) <= 6:
        raise ValueError(f"direction {direction}; give 1 to 3, and 4 to 6 for rotations")
    return int(direction) - 1
