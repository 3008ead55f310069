"""The dual of a program whose unknowns are themselves in cones: as small as the equations that tie them together.

The forces of a balance are of this kind: two or three unknowns a node, in a cone of their own, and
few equations for each body. Many of these cones are at their end in the solution, where interior
points lose digits; in the multipliers of the few equations they keep them. With the slacks `right -
matrix @ x` in cones, the multipliers y obey `matrix' y = -cost`. Those of rows that are about
unknowns of their own follow from the others, and only these others are unknowns of the dual. Its
multipliers are the slacks, which tell x.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, dia_array, vstack

from ..base import Array, Booleans, Integers
from .arrays import Arrays
from .solvers import INFEASIBLE, UNBOUNDED

_SMALLER = 0.5  # unknowns of the dual, over those of the program, up to which it is worth it


@dataclass(frozen=True, eq=False)
class Plain:
    """A program as it stands, with the methods of `Flipped`."""

    arrays: Arrays
    said: ClassVar[Mapping[str, str]] = {}

    def above(self, value: float) -> float:
        """The number that an objective has to be above, where a solver may end once it is not."""
        return value

    def back(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The unknowns and multipliers of the program."""
        return x, y


@dataclass(frozen=True, eq=False)
class Flipped:
    """The dual of a program as `arrays`: a row for each of the unknowns `free`, then the multiplier of each row in a cone as a slack."""

    program: Arrays
    arrays: Arrays
    kept: Integers  # rows whose multipliers are the unknowns
    following: Integers  # rows whose multipliers follow, those of one entry first
    owned: Integers  # the unknown that each of these owns
    free: Integers  # unknowns that no row owns
    share: Array  # by which the slacks of the dual are larger than the multipliers of the program
    said: ClassVar[Mapping[str, str]] = {
        INFEASIBLE: UNBOUNDED,
        UNBOUNDED: INFEASIBLE,
    }  # of the program where a solver says so of its dual

    def above(self, value: float) -> float:
        """None: the dual is bounded from the other side."""
        return -np.inf

    def back(self, y: Array, slacks: Array) -> tuple[Array, Array]:
        """The unknowns and multipliers of the program, from those of its dual."""
        program, matrix, count = self.program, self.program.matrix, len(self.free)
        multipliers = np.empty(len(program.right))
        multipliers[program.zero :] = self.arrays.slack(y)[count:] / self.share
        multipliers[self.kept] = y
        x = np.zeros(len(program.cost))
        x[self.free] = -slacks[:count]
        lacks = (
            program.right[self.following]
            - (slacks[count:] * self.share)[self.following - program.zero]
        )
        pivots, alone = _pivots(program, self.following, self.owned)
        x[self.owned[alone]] = (lacks / pivots)[alone]
        x[self.owned[~alone]] = ((lacks - matrix[self.following] @ x) / pivots)[~alone]
        return x, program.admissible(multipliers)


def flipped(program: Arrays) -> Flipped | None:
    """The dual of a program of sparse rows in cones, where it has much fewer unknowns; else None."""
    width, zero, inside = len(program.cost), program.zero, len(program.right) - program.zero
    if len(program.block) or program.sizes.max(initial=1) == 1:
        return None
    following, owned = _owners(program)
    kept, free = (
        np.setdiff1d(np.arange(zero + inside), following),
        np.setdiff1d(np.arange(width), owned),
    )
    if len(kept) > _SMALLER * width:
        return None
    matrix, (pivots, alone) = program.matrix, _pivots(program, following, owned)
    columns = csr_array(matrix.T)
    by, later = _diagonal(-1 / pivots), _diagonal((~alone).astype(float))
    across = (
        by @ (csr_array(columns[owned][:, following]) - _diagonal(pivots)) @ later
    )  # unknowns of one row in rows of others
    constant, slopes = by @ program.cost[owned], by @ csr_array(columns[owned][:, kept])
    constant, slopes = constant + across @ constant, csr_array(slopes + across @ slopes)
    right, own = np.zeros(inside), kept[kept >= zero]
    right[following - zero] = constant
    rows = _places(following - zero, np.arange(len(following)), (inside, len(following))) @ slopes
    rows = rows + _places(own - zero, np.flatnonzero(kept >= zero), (inside, len(kept)))
    share = np.where(
        np.repeat(program.sizes, program.sizes) > 1, np.count_nonzero(program.sizes > 1), 1.0
    )  # many cones share one load
    arrays = Arrays(
        sparse=csr_array(vstack([columns[free][:, kept], -(_diagonal(share) @ rows)])),
        block=np.zeros((0, len(kept))),
        right=np.r_[-program.cost[free], share * right],
        cost=program.right[kept] + slopes.T @ program.right[following],
        zero=len(free),
        sizes=program.sizes,
    )
    return Flipped(program, arrays, kept, following, owned, free, share)


def _owners(program: Arrays) -> tuple[Integers, Integers]:
    """Rows that own an unknown each, and these unknowns: rows of one entry, then cones of rows of one entry each besides these unknowns."""
    matrix, zero = program.matrix, program.zero
    owner = np.full(len(program.cost), -1)
    linear = zero + int((program.sizes == 1).sum())
    for row in range(zero, linear):
        entries = matrix.indices[matrix.indptr[row] : matrix.indptr[row + 1]]
        if len(entries) == 1 and owner[entries[0]] < 0:
            owner[entries[0]] = row
    early = owner >= 0
    for cone in program.cones:
        for rows in cone if cone.shape[1] > 1 else ():
            entries = [matrix.indices[matrix.indptr[row] : matrix.indptr[row + 1]] for row in rows]
            own = [columns[~early[columns]] for columns in entries]
            unknowns = np.concatenate(own)
            if (
                all(len(each) == 1 for each in own)
                and len(np.unique(unknowns)) == len(rows)
                and (owner[unknowns] < 0).all()
            ):
                owner[unknowns] = rows
    owned = np.flatnonzero(owner >= 0)
    order = np.argsort(owner[owned], kind="stable")
    return owner[owned][order], owned[order]


def _pivots(program: Arrays, following: Integers, owned: Integers) -> tuple[Array, Booleans]:
    """The coefficient of the unknown that each row owns, and whether it is a linear row, of this entry alone."""
    entries = program.matrix[following].tocoo()
    pivots, own = np.zeros(len(following)), owned[entries.row] == entries.col
    pivots[entries.row[own]] = entries.data[own]
    return pivots, following < program.zero + int((program.sizes == 1).sum())


def _diagonal(values: Array) -> dia_array:
    return dia_array((values[None], 0), shape=(len(values),) * 2)


def _places(rows: Integers, columns: Integers, shape: tuple[int, int]) -> csr_array:
    return csr_array((np.ones(len(rows)), (rows, columns)), shape=shape)
