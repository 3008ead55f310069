"""The slip mechanism that the multipliers of a limit form, and its table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base import RESIDUAL, Array, Booleans, Integers, Table, kept, places
from ...contact import ContactSystem
from .question import Question


@kept
@dataclass(frozen=True, eq=False)
class Mechanism:
    """A slip mechanism: a closed cycle of slips and lifts of node i at corner k.

    The multipliers of a safe slip form it. Its net motion causes no stress: `A d + B^T l = 0` with
    the sums d of the slips and l of the lifts. So no residual slip resists it (Bjorkman & Klarbring
    1987). Under a slip bound it may stress nodes whose slip is at the bound.

    Attributes
    ----------
    moves
        (K, t + 1, N) slips along the tangents, and lifts, all in one arbitrary unit. The lift is
        friction times the size of the slip; more if the node opens, and less if the surface shears
        off.
    friction, open
        (N,) coefficients of friction; mask of the open nodes, which follow the others without
        force (None if all are closed).
    """

    moves: Array
    friction: Array
    open: Booleans | None = None

    @classmethod
    def of(cls, question: Question, moves: Array) -> Mechanism:
        """The mechanism of multipliers (K, M) of the forces, see `Question.response`.

        Open nodes follow the closed ones. The multipliers of their gaps, if they are positive, are
        forces with which they touch.
        """
        shape = (len(moves), *question.r1.shape[1:])
        if question.compliance is None:
            return cls(moves.reshape(shape), question.friction)
        normals = moves.shape[1] - question.system.nodes
        opened = np.r_[np.zeros(normals, dtype=bool), question.open_nodes]
        press = np.where(opened, moves.clip(0.0), 0.0)
        moves = np.where(opened, 0.0, moves)
        moves = moves - (moves @ question.system.S + press) @ question.compliance
        friction = question.friction * ~question.open_nodes
        return cls(moves.reshape(shape), friction, open=question.open_nodes)

    @property
    def size(self) -> Array:
        """(K, N) sizes of the slips."""
        return np.asarray(np.hypot.reduce(self.moves[:, :-1], axis=1, initial=0.0))

    @property
    def opening(self) -> Array:
        """(K, N) openings without slip, >= 0, of nodes with little friction or pressure."""
        return (self.moves[:, -1] - self.friction * self.size).clip(0.0)

    def parts(self, system: ContactSystem) -> Array:
        """(2, K, N) sizes of the slips and of the openings; of open nodes, how far they touch."""
        along = self.size
        opening = self.opening
        if self.open is not None:
            forces = -self.moves.reshape(len(along), -1) @ system.S[:, -system.nodes :]
            touching = (forces / system.stiffness_scale).clip(0.0)
            along = np.where(self.open, 0.0, along)
            opening = np.where(self.open, touching, opening)
        return np.stack([along, opening])

    def drive(self, question: Question) -> float:
        """Work of the cyclic loads, at load factor 1, on the mechanism."""
        return -float(np.sum(self.moves.reshape(len(self.moves), -1) * question.bonded[1]))

    def table(self, system: ContactSystem, corners: Sequence[str]) -> Table:
        """A row for each motion, largest first; `corners` are the names of the K corners.

        Columns: node, contact (if several), x (x, y, z in space), corner, its loads, direction,
        share of the sum of all motions. The direction is +1 for slip along +x, -1 for slip against
        it, 0 for an opening or the touching of an open node. In space it is a unit vector (slip1,
        slip2), zero for an opening.
        """
        import pandas as pd  # imported here, because only tables need it

        sizes = self.parts(system)  # (2, K, N): slips, openings
        share = sizes / (float(sizes.sum()) or 1.0)
        # Smaller shares have the error of the answer.
        kind, corner, node = np.nonzero(share > RESIDUAL)
        order = np.lexsort([corner, node, -share[kind, corner, node]])
        kind = kind[order]
        corner = corner[order]
        node = node[order]
        columns: dict[str, Any] = {
            **of_nodes(system, node),
            "corner": corner,
            "loads": pd.Series([corners[k] for k in corner.tolist()], dtype=str),
        }
        slips = self.moves[:, :-1]  # (K, t, N)
        sense = np.stack([slips, np.zeros_like(slips)])[kind, corner, :, node].T
        if system.tangents == 1:
            columns["direction"] = np.sign(sense[0]).astype(int)
        else:
            columns["slip1"], columns["slip2"] = sense / sizes[kind, corner, node]
        columns["share"] = share[kind, corner, node]
        return pd.DataFrame(columns)


def of_nodes(system: ContactSystem, node: Integers) -> dict[str, np.ndarray]:
    """Columns of a table of some nodes: node, contact (if several), x (x, y, z in space)."""
    columns: dict[str, np.ndarray] = {"node": node}
    if system.contact is not None and len(np.unique(system.contact)) > 1:
        columns["contact"] = system.contact[node]
    for name, values in places(system).items():
        columns[name] = values[node]
    return columns
