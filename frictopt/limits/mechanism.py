"""What the multipliers of a safe-slip program mean: the slip mechanism, its bound on the load factor, and rates of the limit."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..contact.tolerances import SHARE
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem
from .scaling import Loads

__all__ = ["Mechanism", "expand_duals"]


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A closed cycle of slips and openings of node i at corner k, all >= 0; the multipliers of the safe-slip rows are one.

    Its net motion stresses nothing, `A d + B^T (f s + o) = 0` with d the sum of forward minus backward slips, s the sum of both and o the sum of
    openings, so no residual slip helps against it (the kinematic dual of the safe-slip theorem, Bjorkman & Klarbring 1987).
    Under a bound on the slip, the net motion may stress nodes that their bound holds.

    Attributes
    ----------
    forward, backward, opening
        (K, N) slip along +x, slip against it, and opening without slip (of nodes with little or no friction), in any one unit.
    hold
        (N,) stress that the slip bound takes up at each node, along +x positive.
    """

    forward: Array
    backward: Array
    opening: Array
    hold: Array

    @property
    def net(self) -> Array:
        """(N,) forward minus backward slip over the cycle."""
        return np.asarray(self.forward.sum(axis=0) - self.backward.sum(axis=0))

    @property
    def total(self) -> Array:
        """(N,) forward plus backward slip over the cycle."""
        return np.asarray(self.forward.sum(axis=0) + self.backward.sum(axis=0))

    def lift(self, friction: Array) -> Array:
        """(K, N) factors of the normal reactions in the mechanism's work: slip times friction, and opening."""
        return np.asarray(friction * (self.forward + self.backward) + self.opening)

    def work(self, loads: Loads, friction: Array, most: Array | None) -> tuple[float, float]:
        """Resistance of the mean load and drive of the cyclic load at load factor 1, both as work on the mechanism.

        A safe slip at load factor lam needs `lam * drive <= resistance`; slips of at most `most`, (N,), add the work that they do on `hold`.
        """
        lift = self.lift(friction)
        resistance = self.net @ loads.q0 + lift.sum(axis=0) @ loads.p0 + (0.0 if most is None else np.abs(self.hold) @ most)
        drive = -np.sum((self.forward - self.backward) * loads.q1) - np.sum(lift * loads.p1)
        return float(resistance), float(drive)

    def stress(self, system: ContactSystem, friction: Array) -> Array:
        """(N,) `A d + B^T (f s + o)` less what the slip bound holds, which is zero for a true mechanism."""
        return np.asarray(system.A @ self.net + system.B.T @ self.lift(friction).sum(axis=0) - self.hold)

    def scaled(self, factor: float) -> "Mechanism":
        """The same mechanism with all motions multiplied."""
        return Mechanism(self.forward * factor, self.backward * factor, self.opening * factor, self.hold * factor)

    def table(self, system: ContactSystem) -> pd.DataFrame:
        """One row for each motion, largest first.

        Columns node, contact (where there are several), x, corner, direction (+1 slip along +x, -1 against it, 0 opening), share of all.
        """
        parts, names = [], np.zeros(system.nodes) if system.contact is None else np.asarray(system.contact)
        whole = float(self.total.sum() + self.opening.sum()) or 1.0
        for direction, motions in ((1, self.forward), (-1, self.backward), (0, self.opening)):
            corner, node = np.nonzero(motions > SHARE * whole)
            share = motions[corner, node] / whole
            columns = {"node": node, "contact": names[node], "x": system.x[node], "corner": corner, "direction": direction, "share": share}
            parts.append(pd.DataFrame(columns if len(np.unique(names)) > 1 else {name: columns[name] for name in columns if name != "contact"}))
        table = pd.concat(parts, ignore_index=True)
        return table.sort_values(["share", "node", "corner"], ascending=[False, True, True], ignore_index=True)

    def friction_rate(self, loads: Loads, slip_pressure: Array, load_factor: float) -> Array:
        """(N,) rate of the limit with each node's friction coefficient: slip times the pressure under which it happens.

        For a mechanism of unit drive; `slip_pressure = p0 + B v`.
        """
        pressure = slip_pressure + load_factor * loads.p1
        return np.asarray(((self.forward + self.backward) * pressure).sum(axis=0))

    def load_rates(self, system: ContactSystem, cycle: LoadCycle, friction: Array, load_factor: float) -> pd.DataFrame:
        """Rate of the limit with every amplitude of the load cycle (for a mechanism of unit drive): columns load, part, amplitude, rate."""
        slide, lift = self.forward - self.backward, self.lift(friction)

        def row(case: str, part: str, amplitude: float, factor: float, slide: Array, lift: Array) -> dict[str, Any]:
            q, p = system.bonded[case]
            return {"load": case, "part": part, "amplitude": amplitude, "rate": factor * float(slide @ q + lift @ p)}

        rows = [row(case, "mean", amplitude, 1.0, slide.sum(axis=0), lift.sum(axis=0)) for case, amplitude in cycle.mean.items()]
        for k, corner in enumerate(cycle.corners):
            rows += [row(case, f"corner {k}", amplitude, load_factor, slide[k], lift[k]) for case, amplitude in corner.items()]
        return pd.DataFrame(rows, columns=["load", "part", "amplitude", "rate"])


def expand_duals(model: SafeProblem, rows: RulingLoads, corners: int) -> Mechanism:
    """The mechanism of the whole contact that the multipliers of its part stand for.

    Nodes of one source share its motion. An image slips forward where its source slips backward, and a middle node as far to and fro.
    """
    part, nodes, motions = model.scaled.part, len(model.scaled.unit), []
    for dual, corner in zip(model.duals, rows.corners, strict=True):
        motion = np.zeros((corners, nodes))
        motion[corner, np.arange(nodes)] = dual / model.scaled.unit
        motions.append(part.share * part.even(motion))
    (one, other, opening), same = motions, (1 + part.sign) / 2
    return Mechanism(same * one + (1 - same) * other, same * other + (1 - same) * one, opening, part.share * part.odd(model.hold))
