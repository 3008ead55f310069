"""What the multipliers of a cone program mean: slips that limit the load, and their bound on the load factor."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..contact.checks import Array
from ..contact.tolerances import SHARE
from .polish import Point
from .scaling import ConeLoads

__all__ = ["Mechanism3D", "mechanism_of"]


@dataclass(frozen=True, eq=False)
class Mechanism3D:
    """A closed cycle of slips and openings of node i at corner k; the multipliers of the circles are one.

    Its net motion stresses nothing, `A d + B^T l = 0` with d the sum of slips and l the sum of `f |slip| + opening`, so no residual slip helps
    against it (the kinematic dual of the safe-slip theorem, Bjorkman & Klarbring 1987, with circles).

    Attributes
    ----------
    slips
        (K, N, 2) slips along the tangents, in any one unit.
    opening
        (K, N) openings without slip.
    friction
        (N,) coefficients of friction.
    """

    slips: Array
    opening: Array
    friction: Array

    @property
    def size(self) -> Array:
        """(K, N) sizes of the slips."""
        return np.asarray(np.linalg.norm(self.slips, axis=-1))

    @property
    def lift(self) -> Array:
        """(K, N) factors of the normal reactions in the mechanism's work: slip times friction, and opening."""
        return self.friction * self.size + self.opening

    def work(self, loads: ConeLoads) -> tuple[float, float]:
        """Resistance of the mean load and drive of the cyclic load at load factor 1, both as work on the mechanism.

        A safe slip at load factor lam needs `lam * drive <= resistance`.
        """
        resistance = np.sum(self.slips.sum(axis=0) * loads.q0) + self.lift.sum(axis=0) @ loads.p0
        return float(resistance), float(-np.sum(self.slips * loads.q1) - np.sum(self.lift * loads.p1))

    def scaled(self, factor: float) -> "Mechanism3D":
        """The same mechanism with all motions multiplied."""
        return Mechanism3D(self.slips * factor, self.opening * factor, self.friction)

    def table(self, points: Array) -> pd.DataFrame:
        """One row for each motion: node, x, y, z, corner, slip1 and slip2 (a unit vector, zero for an opening), share of all; largest first."""
        whole = float(self.size.sum() + self.opening.sum()) or 1.0
        parts = []
        for size, along in ((self.size, self.slips), (self.opening, np.zeros_like(self.slips))):
            corner, node = np.nonzero(size > SHARE * whole)
            direction = along[corner, node] / size[corner, node][:, None]
            columns = {"node": node, **dict(zip("xyz", points[node].T, strict=True)), "corner": corner}
            parts.append(pd.DataFrame({**columns, "slip1": direction[:, 0], "slip2": direction[:, 1], "share": size[corner, node] / whole}))
        table = pd.concat(parts, ignore_index=True)
        return table.sort_values(["share", "node", "corner"], ascending=[False, True, True], ignore_index=True)


def mechanism_of(point: Point, unit: Array, friction: Array, kept: list[int], corners: int) -> Mechanism3D:
    """The mechanism of all corners from the dimensionless multipliers of the kept ones.

    Where the force multiplier of a circle exceeds its slip (a node that carries nothing), friction times the excess opens the node.
    """
    slips, opening = np.zeros((corners, len(unit), 2)), np.zeros((corners, len(unit)))
    excess = np.maximum(point.force - np.linalg.norm(point.slips, axis=-1), 0.0)
    slips[kept], opening[kept] = point.slips / unit[:, None], (point.opening + friction * excess) / unit
    return Mechanism3D(slips, opening, friction)
