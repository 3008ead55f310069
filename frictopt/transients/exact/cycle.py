"""One load cycle on the exact path."""

from dataclasses import dataclass

from ...contact.checks import Array

__all__ = ["Cycle"]


@dataclass(frozen=True, eq=False)
class Cycle:
    """One load cycle on the path.

    Attributes
    ----------
    work
        (N,) work of friction.
    signature
        Number that identifies the changes of status; their order within a segment does not matter.
    corners
        `u, r`, (2N,) each, at the corners.
    before, after
        (2N,) `u` at the beginning and at the end.
    energy
        Error of the energy balance (work of the loads, less work of friction, less elastic energy gained), or negative work of friction at a node,
        over the largest energy in the balance.
    slid
        (N,) way slid by each closed node, length.
    """

    work: Array
    signature: int
    corners: list[tuple[Array, Array]]
    before: Array
    after: Array
    energy: float
    slid: Array
