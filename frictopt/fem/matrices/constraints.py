"""Which rows of a matrix are displacements of nodes; those that it does not have: what the deck says of them, and where the loads on them go."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from ...contact import ROUNDING, Array, Booleans, Integers, whole, whole_array
from ...errors import ModelError
from .text import Block, entries, fields, number

Terms = list[tuple[int, int, float]]  # what follows, what leads, and the weight: 6 i + k is displacement k of node i, from 3 on its rotation

_HELD = {"XSYMM": [0, 4, 5], "YSYMM": [1, 3, 5], "ZSYMM": [2, 3, 4], "XASYMM": [1, 2, 3], "YASYMM": [0, 2, 4], "ZASYMM": [0, 1, 5]}
_HELD |= {"PINNED": [0, 1, 2], "ENCASTRE": [0, 1, 2, 3, 4, 5]}


@dataclass(frozen=True, eq=False)
class Constraints:
    """Held displacements and rotations, and those that follow others; those of node i are the unknowns 6 i to 6 i + 5.

    They are those of `*BOUNDARY`, `*EQUATION`, `*RIGID BODY`, and of `*COUPLING` with `*KINEMATIC`, where `u_i = u_ref + rotation x (x_i - x_ref)`.
    """

    held: Booleans  # (nodes, 6)
    ends: Integers = field(default_factory=lambda: np.zeros((0, 2), dtype=np.intp))  # (m, 2) unknowns, the first of which follows the second
    weights: Array = field(default_factory=lambda: np.zeros(0))  # (m,) how much
    rigid: tuple[tuple[int, int | None], ...] = ()  # rows of the reference of a rigid part, and of the node of its rotation: None, the code makes it
    others: tuple[str, ...] = ()  # keywords whose equations are not in the deck

    def passed_on(self, forces: Array, present: Booleans, numbers: Integers) -> Array:
        """(nodes, 6) the same forces and moments, those on unknowns that follow others moved to these; `present` are those in the matrix."""
        wanting, moved = ~(present | self.held).ravel(), forces.ravel()
        own = wanting[self.ends[:, 0]]
        (row, column), follows = self.ends[own].T, np.zeros(forces.size, dtype=bool)
        follow = csr_matrix((self.weights[own], (row, column)), shape=(forces.size,) * 2)
        follows[row] = True
        for _ in row:  # a chain is not longer
            if not moved[follows].any():
                break
            moved = np.where(follows, 0.0, moved) + follow.T @ np.where(follows, moved, 0.0)
        lost = wanting & (np.abs(moved) > ROUNDING * np.abs(forces).max(initial=0.0))
        if lost.any():
            node, axis = divmod(int(lost.argmax()), 6)
            why = f"the deck has {', '.join(self.others)}" if self.others else "give the deck of the same job"
            raise ModelError(
                f"force: it acts on node {numbers[node]}, direction {axis + 1}, that neither the matrix nor *BOUNDARY has, and no *EQUATION says "
                f"what it follows ({why}); load nodes that follow no others, write the constraint as *EQUATION, or merge tied nodes"
            )
        return np.asarray(moved.reshape(forces.shape))

    def part(self, reference: int) -> tuple[Integers, Array]:
        """Unknowns (m,) that follow the displacements of a node, and (m, 6) how much they follow these and its rotation."""
        first = 6 * reference
        leads = (self.ends[:, 1] >= first) & (self.ends[:, 1] < first + 6)
        unknowns = np.unique(self.ends[leads & (self.ends[:, 1] < first + 3), 0])
        follow = csr_matrix((self.weights[leads], (self.ends[leads, 0], self.ends[leads, 1] - first)), shape=(self.held.size, 6))
        return unknowns, follow[unknowns].toarray()

    def following(self, ends: Integers, weights: Array) -> "Constraints":
        """The same, with more unknowns that follow others."""
        return replace(self, ends=np.concatenate([self.ends, ends]), weights=np.concatenate([self.weights, weights]))


@dataclass
class _Joined:
    """What the blocks that constrain nodes have given so far; an error in one leaves the others as they are."""

    row: Mapping[int, int]
    sets: Mapping[str, Integers]
    held: Booleans
    terms: Terms = field(default_factory=list)
    rigid: list[tuple[int, int | None, Integers, list[int]]] = field(default_factory=list)
    surface: dict[str, str] = field(default_factory=dict)

    def _nodes(self, entry: str) -> Integers:
        return np.array([self.row[int(entry)]]) if entry.isdecimal() else self.sets[entry.upper()]

    def boundary(self, _: Mapping[str, str], lines: Sequence[str]) -> None:
        for line in lines:
            where, *rest = entries(line)
            axes = _HELD[rest[0].upper()] if rest and not rest[0].isdecimal() else _span(rest)
            self.held[self._nodes(where)[:, None], axes] = True

    def equation(self, options: Mapping[str, str], lines: Sequence[str]) -> None:
        """How many terms, then node, direction and coefficient of each; a set of nodes in the first term makes an equation for each."""
        if options:
            raise ValueError(", ".join(options))
        found, entries = list[tuple[int, int, float]](), [entry for line in lines for entry in fields(line)]
        while entries:
            size = 1 + 3 * int(entries[0])
            terms = [(self._nodes(entries[i]), int(entries[i + 1]) - 1, number(entries[i + 2])) for i in range(1, size, 3)]
            if any(axis > 2 for _, axis, _ in terms) or any(len(nodes) != 1 for nodes, _, _ in terms[1:]):
                raise ValueError("directions beyond 3, or a set of nodes that is not the first term")
            (first, axis, weight), *rest = terms
            leading = [(6 * int(nodes[0]) + a, -w / weight) for nodes, a, w in rest]
            found += [(6 * int(node) + axis, *lead) for node in first for lead in leading or [(6 * int(node) + axis, 0.0)]]
            entries = entries[size:]
        self.terms += found

    def rigid_body(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        rotation = self.row[int(options["ROTNODE"])] if "ROTNODE" in options else None
        self.rigid.append((self.row[int(options["REFNODE"])], rotation, self.sets[options["NSET"]], [0, 1, 2]))

    def coupling(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        self.surface = dict(options)

    def kinematic(self, _: Mapping[str, str], lines: Sequence[str]) -> None:
        axes = sorted({axis for line in lines for axis in _span(fields(line)) if axis < 3})
        self.rigid.append((self.row[int(self.surface["REFNODE"])], None, self.sets[self.surface["SURFACE"]], axes))


def _span(ends: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; temperatures and the like are none."""
    return [direction - 1 for direction in range(int(ends[0]), int(ends[1] if len(ends) > 1 and ends[1] else ends[0]) + 1) if direction <= 6]


def _turning(reference: int, rotation: int | None, nodes: Integers, axes: Sequence[int], points: Array) -> Terms:
    """Terms of a rigid part: its nodes, and the displacements of the node of its rotation, follow the reference."""
    turns = np.cross(np.eye(3), (points[nodes] - points[reference])[:, None])  # of each node, about each axis
    found = [] if rotation is None else [(6 * rotation + axis, 6 * reference + 3 + axis, 1.0) for axis in range(3)]
    for node, turn in zip(nodes.tolist(), turns, strict=True):
        for axis in axes if node != reference else ():
            found.append((6 * node + axis, 6 * reference + axis, 1.0))
            found += [(6 * node + axis, 6 * reference + 3 + about, float(weight)) for about, weight in enumerate(turn[:, axis]) if weight]
    return found


def constraints_of(found: Sequence[Block], row: Mapping[int, int], sets: Mapping[str, Integers], points: Array) -> Constraints:
    """The constraints of a deck; a block that cannot be read is one of the `others`, for it may say nothing of the loads."""
    read, others = _Joined(row, sets, np.zeros((len(row), 6), dtype=bool)), list[str]()
    for keyword, options, lines in found:
        reader = CONSTRAINING[keyword]
        try:
            others += [f"*{keyword}"] if reader is None else reader(read, options, lines) or []
        except (KeyError, ValueError, IndexError, ZeroDivisionError) as error:
            others.append(f"a block *{keyword} that cannot be read here: {error}")
    determined = {end for end, *_ in read.terms}
    for reference, rotation, nodes, axes in read.rigid:
        if rotation is not None:
            read.held[reference, 3:] |= read.held[rotation, :3]
        read.terms += [term for term in _turning(reference, rotation, nodes, axes, points) if term[0] not in determined]
    ends = np.array([term[:2] for term in read.terms], dtype=np.intp).reshape(-1, 2)
    weights = np.array([weight for *_, weight in read.terms])
    return Constraints(read.held, ends, weights, tuple(part[:2] for part in read.rigid), tuple(dict.fromkeys(others)))


CONSTRAINING: dict[str, Callable[[_Joined, Mapping[str, str], Sequence[str]], None] | None] = {
    "BOUNDARY": _Joined.boundary,
    "EQUATION": _Joined.equation,
    "RIGIDBODY": _Joined.rigid_body,
    "COUPLING": _Joined.coupling,
    "KINEMATIC": _Joined.kinematic,
    # rules of the code that are not in the deck
    **dict.fromkeys(("TIE", "MPC", "DISTRIBUTING", "DISTRIBUTINGCOUPLING", "KINEMATICCOUPLING"), None),
    **dict.fromkeys(("CYCLICSYMMETRYMODEL", "PRE-TENSIONSECTION", "EMBEDDEDELEMENT"), None),
}


def checked_labels(values: ArrayLike) -> Integers:
    """Check that labels are distinct pairs of whole numbers, some of them displacements, and return them read-only."""
    labels = whole_array("labels", values, (None, 2), least=-(10**12), most=10**12)
    if not displaced(labels).any():
        raise ModelError("labels: none is that of a displacement, a node and direction 1, 2 or 3; without any there is no contact")
    if twice := len(labels) - len(np.unique(labels, axis=0)):
        raise ModelError(f"labels: {twice} labels are given twice; write the matrix of solids alone: shells, beams and trusses have several rows")
    return whole(labels)


def displaced(labels: Integers) -> Booleans:
    """(n,) whether a label is that of a displacement of a node."""
    return np.asarray((labels[:, 0] > 0) & (labels[:, 1] >= 1) & (labels[:, 1] <= 3))


def rows_of_nodes(labels: Integers, numbers: Integers, constraints: Constraints) -> Integers:
    """(nodes, 6) row of each node's displacements and rotations, -1 where the deck holds them, -2 where there is none else."""
    if len(lost := np.setdiff1d(labels[displaced(labels), 0], numbers)):
        raise ModelError(f"deck: node {lost[0]} of the matrix is not in it; give the deck of the same job, of solids alone, not shells or beams")
    rows = np.flatnonzero(np.isin(labels[:, 0], numbers) & (labels[:, 1] >= 1) & (labels[:, 1] <= 6))
    order = np.argsort(numbers)
    node = order[np.searchsorted(numbers, labels[rows, 0], sorter=order)]
    unknowns = np.where(constraints.held, -1, -2)
    unknowns[node, labels[rows, 1] - 1] = rows
    return whole(unknowns)
