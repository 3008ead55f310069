"""A program during its reduction, and the interface of the steps of the reduction."""

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
from scipy.sparse import csr_array

from ..base import Array, Booleans, Integers
from .arrays import RowsInCones
from .compiled import Block

After = TypeVar("After")


@dataclass(frozen=True, eq=False)
class Program(RowsInCones):
    """A program `min cost @ z` over the z that obey dense equations and whose slacks are in cones.

    The slacks are `right - sparse @ z`. `unit` holds the units of z, 0 where unknown. The dense
    equations are `z[block.defined] = block.matrix @ z[block.of]`.
    """

    sparse: csr_array
    right: Array
    cost: Array
    zero: int
    sizes: Integers
    unit: Array
    blocks: tuple[Block, ...]

    @cached_property
    def in_blocks(self) -> Booleans:
        """Which unknowns occur in dense equations."""
        mask = np.zeros(len(self.cost), dtype=bool)
        for block in self.blocks:
            mask[block.defined] = True
            mask[block.of] = True
        return mask


class Step(Generic[After]):
    """A step of a reduction: the constructor takes the program before it.

    A step changes the unknowns or the rows, or both. The others are the same before and after.
    """

    after: After
    """The program after the step."""


class ChangesUnknowns(Step[After]):
    """A step with the way back for the unknowns of an answer."""

    def values(self, x: Array) -> Array:
        """The unknowns of the program before the step, from those of the program after it."""
        raise NotImplementedError


class ChangesRows(Step[After]):
    """A step with the way back for the multipliers of an answer."""

    def multipliers(self, y: Array, cost_factor: float) -> Array:
        """The multipliers of the program before the step, from those of the program after it.

        `cost_factor` is 1 for multipliers of an optimum, which balance the cost. It is 0 for
        multipliers that prove a contradiction, in whose balance there is no cost.
        """
        raise NotImplementedError
