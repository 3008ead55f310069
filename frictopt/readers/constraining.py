"""Keywords of a deck that hold displacements, or let them follow others."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..base import Array, Booleans, Integers
from .deck import Block, Constraints, entries, fields, number

Terms = list[
    tuple[int, int, float]
    # what follows, what leads, and the weight: 6 i + k is displacement k of node i, from 3 on its
    # rotation
]
_HELD = {
    "XSYMM": [0, 4, 5],
    "YSYMM": [1, 3, 5],
    "ZSYMM": [2, 3, 4],
    "XASYMM": [1, 2, 3],
    "YASYMM": [0, 2, 4],
    "ZASYMM": [0, 1, 5],
}
_HELD |= {"PINNED": [0, 1, 2], "ENCASTRE": [0, 1, 2, 3, 4, 5]}


@dataclass
class _Joined:
    """What the blocks that constrain nodes have given so far; an error in one leaves the others as they are."""

    row: Mapping[int, int]
    sets: Mapping[str, Integers]
    followers: Callable[[str], Integers]  # nodes of the elements of a set
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
        found, entries = (
            list[tuple[int, int, float]](),
            [entry for line in lines for entry in fields(line)],
        )
        while entries:
            size = 1 + 3 * int(entries[0])
            terms = [
                (self._nodes(entries[i]), int(entries[i + 1]) - 1, number(entries[i + 2]))
                for i in range(1, size, 3)
            ]
            if any(axis > 2 for _, axis, _ in terms) or any(
                len(nodes) != 1 for nodes, _, _ in terms[1:]
            ):
                raise ValueError(
                    "directions beyond 3, or a set of nodes that is not the first term"
                )
            (first, axis, weight), *rest = terms
            leading = [(6 * int(nodes[0]) + a, -w / weight) for nodes, a, w in rest]
            found += [
                (6 * int(node) + axis, *lead)
                for node in first
                for lead in leading or [(6 * int(node) + axis, 0.0)]
            ]
            entries = entries[size:]
        self.terms += found

    def rigid_body(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        rotation = self.row[int(options["ROTNODE"])] if "ROTNODE" in options else None
        nodes = (
            self.followers(options["ELSET"]) if "ELSET" in options else self.sets[options["NSET"]]
        )
        self.rigid.append((self.row[int(options["REFNODE"])], rotation, nodes, [0, 1, 2]))

    def coupling(self, options: Mapping[str, str], _: Sequence[str]) -> None:
        self.surface = dict(options)

    def kinematic(self, _: Mapping[str, str], lines: Sequence[str]) -> None:
        axes = sorted({axis for line in lines for axis in _span(fields(line)) if axis < 3})
        self.rigid.append(
            (self.row[int(self.surface["REFNODE"])], None, self.sets[self.surface["SURFACE"]], axes)
        )


def _span(ends: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; temperatures and the like are none."""
    return [
        direction - 1
        for direction in range(
            int(ends[0]), int(ends[1] if len(ends) > 1 and ends[1] else ends[0]) + 1
        )
        if direction <= 6
    ]


def _turning(
    reference: int, rotation: int | None, nodes: Integers, axes: Sequence[int], points: Array
) -> Terms:
    """Terms of a rigid part: its nodes, and the displacements of the node of its rotation, follow the reference."""
    turns = np.cross(
        np.eye(3), (points[nodes] - points[reference])[:, None]
    )  # of each node, about each axis
    found = (
        []
        if rotation is None
        else [(6 * rotation + axis, 6 * reference + 3 + axis, 1.0) for axis in range(3)]
    )
    for node, turn in zip(nodes.tolist(), turns, strict=True):
        for axis in axes if node != reference else ():
            found.append((6 * node + axis, 6 * reference + axis, 1.0))
            found += [
                (6 * node + axis, 6 * reference + 3 + about, float(weight))
                for about, weight in enumerate(turn[:, axis])
                if weight
            ]
    return found


def constraints_of(
    found: Sequence[Block],
    row: Mapping[int, int],
    sets: Mapping[str, Integers],
    followers: Callable[[str], Integers],
    points: Array,
) -> Constraints:
    """The constraints of a deck; a block that cannot be read is one of the `others`, for it may say nothing of the loads."""
    read, others = _Joined(row, sets, followers, np.zeros((len(row), 6), dtype=bool)), list[str]()
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
        read.terms += [
            term
            for term in _turning(reference, rotation, nodes, axes, points)
            if term[0] not in determined
        ]
    ends = np.array([term[:2] for term in read.terms], dtype=np.intp).reshape(-1, 2)
    weights = np.array([weight for *_, weight in read.terms])
    return Constraints(
        read.held,
        ends,
        weights,
        tuple(part[:2] for part in read.rigid),
        tuple(dict.fromkeys(others)),
    )


CONSTRAINING: dict[str, Callable[[_Joined, Mapping[str, str], Sequence[str]], None] | None] = {
    "BOUNDARY": _Joined.boundary,
    "EQUATION": _Joined.equation,
    "RIGIDBODY": _Joined.rigid_body,
    "COUPLING": _Joined.coupling,
    "KINEMATIC": _Joined.kinematic,
    # rules of the code that are not in the deck
    **dict.fromkeys(
        ("TIE", "MPC", "DISTRIBUTING", "DISTRIBUTINGCOUPLING", "KINEMATICCOUPLING"), None
    ),
    **dict.fromkeys(("CYCLICSYMMETRYMODEL", "PRE-TENSIONSECTION", "EMBEDDEDELEMENT"), None),
}
