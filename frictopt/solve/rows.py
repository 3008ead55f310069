"""Rows of programs by their entries, and the arrays of rows whose quantities are the unknowns."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ..base import Array, Integers
from .arrays import Arrays

EQUATION = 0
LINEAR = 1
CONE = 2


class Rows(NamedTuple):
    """Rows or cones of one label: a unit, an instant and a node for each, and their entries."""

    label: str
    kind: int  # EQUATION, LINEAR or CONE
    sizes: Integers  # (n,) 1, or the size of each cone
    at: Integers  # (entries,) number of the row of each entry, cones row by row
    quantities: Integers  # (entries,)
    weights: Array  # (entries,) in user units
    constants: Array  # (rows,)
    unit: Array  # (n,)
    instants: Integers  # (n,)
    nodes: Integers  # (n,)


Term = tuple[Integers, Array]
"""Quantities (n,) and their weights (n,) in n rows."""


def rows_of(
    label: str,
    kind: int,
    parts: Sequence[Sequence[Term]],
    constant: Array,
    unit: Array,
    instants: Integers | None = None,
    nodes: Integers | None = None,
) -> Rows:
    """Rows with the same terms. `parts` lists the terms of the first part of each cone, and so on.

    `constant` (n,) belongs to the first part. Rows without instants or nodes have the number -1.
    """
    n, size = len(constant), len(parts)
    none = np.full(n, -1)
    instants = none if instants is None else instants
    nodes = none if nodes is None else nodes
    first = size * np.arange(n)
    constants = np.zeros(n * size)
    constants[first] = constant
    terms = [(first + part, *term) for part, of_part in enumerate(parts) for term in of_part]
    at, quantities, weights = (np.concatenate(entries) for entries in zip(*terms, strict=True))
    sizes = np.full(n, size)
    return Rows(label, kind, sizes, at, quantities, weights, constants, unit, instants, nodes)


class Stacked(NamedTuple):
    """The rows of a program one after the other: equations, linear rows, cones."""

    rows: list[Rows]
    units: Array  # (R,)
    at: Integers  # (entries,) number of the row of each entry
    quantities: Integers  # (entries,)
    weights: Array  # (entries,)
    constants: Array  # (R,)


def stacked(rows: Sequence[Rows]) -> Stacked:
    """All rows, in the order of the solver."""
    in_order = sorted(rows, key=lambda part: part.kind)
    firsts = np.cumsum([0, *(len(part.constants) for part in in_order)])
    return Stacked(
        in_order,
        np.concatenate([np.repeat(part.unit, part.sizes) for part in in_order]),
        np.concatenate([part.at + first for part, first in zip(in_order, firsts, strict=False)]),
        np.concatenate([part.quantities for part in in_order]),
        np.concatenate([part.weights for part in in_order]),
        np.concatenate([part.constants for part in in_order]),
    )


def program_of(rows: Sequence[Rows], units: Array, cost: Array) -> Arrays:
    """The program that minimises `cost @ x` over quantities `units * x` that obey the rows."""
    in_order, row_units, at, quantities, weights, constants = stacked(rows)
    values = -weights * units[quantities] / row_units[at]
    shape = len(row_units), len(units)
    return Arrays(
        sparse=csr_array((values, (at, quantities)), shape=shape),
        block=np.zeros((0, len(units))),
        right=constants / row_units,
        cost=cost,
        zero=sum(len(part.constants) for part in in_order if part.kind == EQUATION),
        sizes=np.concatenate([part.sizes for part in in_order if part.kind != EQUATION]),
    )
