"""Displacements that a stiffness matrix does not have: what the deck says of them, and where the loads on them go."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.checks import Array
from ...contact.tolerances import ROUNDING
from ...errors import ModelError
from ..ordering import Flags, Integers
from .blocks import Block, fields, number

Equation: TypeAlias = tuple[tuple[int, int, float], ...]  # row of the node, axis and coefficient of each term; the first one depends on the others

CONSTRAINING = {"BOUNDARY", "EQUATION", "RIGIDBODY", "COUPLING", "KINEMATIC"} | {  # those below follow rules of the code that are not in the deck
    "TIE", "MPC", "DISTRIBUTING", "DISTRIBUTINGCOUPLING", "KINEMATICCOUPLING", "CYCLICSYMMETRYMODEL", "PRE-TENSIONSECTION", "EMBEDDEDELEMENT"
}  # fmt: skip
_ABAQUS_NAMES = {"XSYMM": [0], "YSYMM": [1], "ZSYMM": [2], "XASYMM": [1, 2], "YASYMM": [0, 2], "ZASYMM": [0, 1]}
_ABAQUS_NAMES |= {"PINNED": [0, 1, 2], "ENCASTRE": [0, 1, 2]}


@dataclass(frozen=True, eq=False)
class Rigid:
    """Nodes that move as one: `u_i = u_reference + rotation x (x_i - x_reference)` along some axes.

    Parameters
    ----------
    reference, rotation
        Rows of two nodes: the displacements of the second one are the rotations. None where the code generates it.
    nodes
        Rows of the nodes that follow.
    axes
        The axes, 0 to 2, along which they follow.
    """

    reference: int
    rotation: int | None
    nodes: Integers
    axes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Constraints:
    """Held displacements, and those that follow others.

    Parameters
    ----------
    held
        (nodes, 3) whether `*BOUNDARY` holds a displacement.
    equations
        Those of `*EQUATION`.
    rigid
        Those of `*RIGID BODY` and `*COUPLING` with `*KINEMATIC`.
    others
        Keywords whose equations are not in the deck.
    """

    held: Flags
    equations: tuple[Equation, ...]
    rigid: tuple[Rigid, ...]
    others: tuple[str, ...]

    def passed_on(self, forces: Array, present: Flags, numbers: Integers) -> Array:
        """(nodes, 3) the same forces, those on displacements that follow others moved to these: `T^T f`.

        Parameters
        ----------
        forces
            (nodes, 3) nodal forces.
        present
            (nodes, 3) whether a displacement is in the matrix.
        numbers
            Numbers of the nodes.

        Raises
        ------
        ModelError
            A force on a displacement that is neither in the matrix nor held, and that no equation determines.
        """
        wanting = ~(present | self.held)
        own = [equation for equation in self.equations if wanting[equation[0][0], equation[0][1]]]
        terms = [(3 * a + i, 3 * b + j, -weight / first) for (a, i, first), *rest in own for b, j, weight in rest]
        row, column, weights = np.array(terms).reshape(-1, 3).T
        follow = csr_matrix((weights, (row.astype(int), column.astype(int))), shape=(forces.size,) * 2)
        follows = np.zeros(forces.size, dtype=bool)
        follows[[3 * a + i for (a, i, _), *_ in own]] = True
        moved = forces.ravel()
        for _ in own:  # a chain of equations is not longer
            if not moved[follows].any():
                break
            moved = np.where(follows, 0.0, moved) + follow.T @ np.where(follows, moved, 0.0)
        lost = wanting.ravel() & (np.abs(moved) > ROUNDING * np.abs(forces).max(initial=0.0))
        if lost.any():
            node, axis = divmod(int(lost.argmax()), 3)
            why = f"the deck has {', '.join(self.others)}" if self.others else "give the deck of the same job"
            raise ModelError(
                f"force: it acts on node {numbers[node]}, direction {axis + 1}, that neither the matrix nor *BOUNDARY has, and no *EQUATION says "
                f"what it follows ({why}); load nodes that follow no others, write the constraint as *EQUATION, or merge tied nodes"
            )
        return np.asarray(moved.reshape(forces.shape))


def constraints_of(found: Sequence[Block], row: Mapping[int, int], sets: Mapping[str, Integers]) -> Constraints:
    """The constraints of a deck; a block that cannot be read is one of the `others`, for it may say nothing of the loads.

    Parameters
    ----------
    found
        Blocks of the keywords `CONSTRAINING`.
    row
        Number of a node -> its row.
    sets
        Node set or surface of nodes -> rows.
    """
    held = np.zeros((len(row), 3), dtype=bool)
    equations: list[Equation] = []
    rigid: list[Rigid] = []
    others: list[str] = []
    coupling: dict[str, str] = {}

    def rows_of(field: str) -> Integers:
        return np.array([row[int(field)]]) if field.isdecimal() else sets[field.upper()]

    for keyword, options, lines in found:
        coupling = options if keyword == "COUPLING" else coupling
        try:
            if keyword == "BOUNDARY":
                for line in lines:
                    where, *rest = fields(line)
                    axes = _ABAQUS_NAMES[rest[0].upper()] if rest and not rest[0].isdecimal() else _span(rest)
                    held[rows_of(where)[:, None], axes] = True
            elif keyword == "EQUATION" and not options:
                equations += _equations(lines, rows_of)
            elif keyword == "RIGIDBODY":
                rotation = row[int(options["ROTNODE"])] if "ROTNODE" in options else None
                rigid.append(Rigid(row[int(options["REFNODE"])], rotation, sets[options["NSET"]], (0, 1, 2)))
            elif keyword == "KINEMATIC":
                axes = sorted({axis for line in lines for axis in _span(fields(line))})
                rigid.append(Rigid(row[int(coupling["REFNODE"])], None, sets[coupling["SURFACE"]], tuple(axes)))
            elif keyword != "COUPLING":
                others.append(f"*{keyword}")
        except (KeyError, ValueError, IndexError) as error:
            others.append(f"a block *{keyword} that cannot be read here: {error}")
    return Constraints(held, tuple(equations), tuple(rigid), tuple(dict.fromkeys(others)))


def _span(ends: Sequence[str]) -> list[int]:
    """Axes from the first to the last direction; rotations, temperatures and the like are none."""
    return [direction - 1 for direction in range(int(ends[0]), int(ends[1] if len(ends) > 1 else ends[0]) + 1) if direction <= 3]


def _equations(lines: Sequence[str], rows_of: Callable[[str], Integers]) -> list[Equation]:
    """Equations: how many terms, then node, direction and coefficient of each; a set of nodes in the first term makes one for each."""
    found: list[Equation] = []
    entries = [field for line in lines for field in fields(line)]
    while entries:
        size = 1 + 3 * int(entries[0])
        terms = [(rows_of(entries[i]), int(entries[i + 1]) - 1, number(entries[i + 2])) for i in range(1, size, 3)]
        if any(axis > 2 or (len(nodes) != 1 and i) for i, (nodes, axis, _) in enumerate(terms)):
            raise ValueError("directions beyond 3, or a set of nodes that is not the first term")
        (first, axis, weight), *rest = terms
        found += [((int(node), axis, weight), *((int(nodes[0]), a, w) for nodes, a, w in rest)) for node in first]
        entries = entries[size:]
    return found
