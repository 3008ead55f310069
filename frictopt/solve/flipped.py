"""The dual of a program whose unknowns are in cones.

The dual has about as many unknowns as there are equations that couple the unknowns. The forces of a
balance are of this kind: each node has two or three unknowns in a cone of their own, and each body
has few equations. In the solution many of these cones are at their apex, where interior points lose
digits. The multipliers of the few equations keep their digits.

With the slacks `right - matrix @ x` in cones, the multipliers y obey `matrix' y = -cost`. Some rows
*own* an unknown, see `_owners`: their multipliers follow from the other ones, so that only these
are unknowns of the dual. The multipliers of the dual are the slacks of the program, from which x
follows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, dia_array, vstack

from ..base import Array, Booleans, Integers
from .arrays import Arrays
from .solvers import INFEASIBLE, UNBOUNDED


@dataclass(frozen=True, eq=False)
class Flipped:
    """The dual of a program as `arrays`.

    It has a row for each of the unknowns `free`, then the multiplier of each row in a cone as a
    slack.
    """

    program: Arrays
    arrays: Arrays
    multiplier_rows: Integers
    """Rows whose multipliers are the unknowns."""
    following: Integers
    """Rows whose multipliers follow; rows of one entry come first."""
    owned: Integers
    """The unknown that each of these rows owns."""
    free: Integers
    """Unknowns that no row owns."""
    share: Array
    """Ratio of the slacks of the dual to the multipliers of the program."""
    outcomes: ClassVar[Mapping[str, str]] = {INFEASIBLE: UNBOUNDED, UNBOUNDED: INFEASIBLE}
    """Status of the dual -> status of the program."""

    def cutoff(self, above: float) -> float:
        """No cutoff, because the objective is another one."""
        return -np.inf

    def back(self, y: Array, slacks: Array) -> tuple[Array, Array]:
        """The unknowns and multipliers of the program, from those of its dual."""
        program, count = self.program, len(self.free)
        multipliers = np.empty(len(program.right))
        multipliers[program.zero :] = self.arrays.slack(y)[count:] / self.share
        multipliers[self.multiplier_rows] = y
        x = np.zeros(len(program.cost))
        x[self.free] = -slacks[:count]
        primal_slacks = (slacks[count:] * self.share)[self.following - program.zero]
        terms = program.right[self.following] - primal_slacks
        pivots, alone = _pivots(program, self.following, self.owned)
        x[self.owned[alone]] = (terms / pivots)[alone]
        rest = program.matrix[self.following] @ x
        x[self.owned[~alone]] = ((terms - rest) / pivots)[~alone]
        return x, program.admissible(multipliers)


def flipped(program: Arrays) -> Flipped | None:
    """The dual of a program of sparse rows in cones if it has fewer unknowns; else None."""
    width, zero = len(program.cost), program.zero
    inside = len(program.right) - zero
    if len(program.block) or program.sizes.max(initial=1) == 1:
        return None
    following, owned = _owners(program)
    multiplier_rows = np.delete(np.arange(zero + inside), following)
    free = np.delete(np.arange(width), owned)
    if len(multiplier_rows) >= width:
        return None
    pivots, alone = _pivots(program, following, owned)
    columns = csr_array(program.matrix.T)

    # The multipliers that follow are constant + slopes @ y. An owned unknown may also occur in the
    # row of another owner: `across` adds these terms.
    over_pivots = _diagonal(-1 / pivots)
    later = _diagonal((~alone).astype(float))
    across = over_pivots @ (csr_array(columns[owned][:, following]) - _diagonal(pivots)) @ later
    constant = over_pivots @ program.cost[owned]
    slopes = over_pivots @ csr_array(columns[owned][:, multiplier_rows])
    constant = constant + across @ constant
    slopes = csr_array(slopes + across @ slopes)

    # The multipliers of all rows in cones are right + rows @ y.
    right = np.zeros(inside)
    right[following - zero] = constant
    in_cones = multiplier_rows >= zero
    places = _places(following - zero, np.arange(len(following)), (inside, len(following)))
    rows = places @ slopes
    rows = rows + _places(
        multiplier_rows[in_cones] - zero, np.flatnonzero(in_cones), (inside, len(multiplier_rows))
    )
    of_cones = np.repeat(program.sizes, program.sizes) > 1
    share = np.where(of_cones, np.count_nonzero(program.sizes > 1), 1.0)  # cones share the load
    arrays = Arrays(
        sparse=csr_array(vstack([columns[free][:, multiplier_rows], -(_diagonal(share) @ rows)])),
        block=np.zeros((0, len(multiplier_rows))),
        right=np.r_[-program.cost[free], share * right],
        cost=program.right[multiplier_rows] + slopes.T @ program.right[following],
        zero=len(free),
        sizes=program.sizes,
    )
    return Flipped(program, arrays, multiplier_rows, following, owned, free, share)


def _owners(program: Arrays) -> tuple[Integers, Integers]:
    """Rows that own an unknown each, and these unknowns.

    Rows of one entry come first. Then come cones whose rows have one entry each, besides the
    unknowns of the first kind.
    """
    owner = _owners_by_linear_rows(program)
    early = owner >= 0
    cones = [rows for cone in program.cones if cone.shape[1] > 1 for rows in cone]
    for rows in cones:
        unknowns = [_entries(program.matrix, row) for row in rows]
        unknowns = [columns[~early[columns]] for columns in unknowns]
        one_each = all(len(columns) == 1 for columns in unknowns)
        together = np.concatenate(unknowns)
        if one_each and len(np.unique(together)) == len(rows) and (owner[together] < 0).all():
            owner[together] = rows
    owned = np.flatnonzero(owner >= 0)
    order = np.argsort(owner[owned], kind="stable")
    return owner[owned][order], owned[order]


def _owners_by_linear_rows(program: Arrays) -> Integers:
    """(unknowns,) the first linear row that has an entry for this unknown alone, else -1."""
    owner = np.full(len(program.cost), -1)
    for row in range(program.zero, program.linear):
        entries = _entries(program.matrix, row)
        if len(entries) == 1 and owner[entries[0]] < 0:
            owner[entries[0]] = row
    return owner


def _entries(matrix: csr_array, row: int) -> Integers:
    """The unknowns in a row."""
    stored = slice(matrix.indptr[row], matrix.indptr[row + 1])
    return np.asarray(matrix.indices[stored][matrix.data[stored] != 0])


def _pivots(program: Arrays, following: Integers, owned: Integers) -> tuple[Array, Booleans]:
    """The coefficient of the unknown that each row owns, and whether the row is linear.

    A linear row has no other entry.
    """
    entries = program.matrix[following].tocoo()
    is_pivot = owned[entries.row] == entries.col
    pivots = np.zeros(len(following))
    pivots[entries.row[is_pivot]] = entries.data[is_pivot]
    return pivots, following < program.linear


def _diagonal(values: Array) -> dia_array:
    """The diagonal matrix of these values."""
    return dia_array((values[None], 0), shape=(len(values),) * 2)


def _places(rows: Integers, columns: Integers, shape: tuple[int, int]) -> csr_array:
    """The matrix with a 1 in each of these places."""
    return csr_array((np.ones(len(rows)), (rows, columns)), shape=shape)
