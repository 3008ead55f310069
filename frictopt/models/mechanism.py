"""What the multipliers of a safe-slip program mean: the slip mechanism, its bound on the load factor, and rates of the limit."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from .interface import Interface
from .rows import LoadRows, Loads

__all__ = ["Mechanism", "expand_duals"]

_SHARE = 1e-9  # rows with a smaller share of the mechanism are left out of its table


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A closed cycle of slips `forward[k, i], backward[k, i] >= 0` of node i at corner k; the multipliers of the safe-slip rows are one.

    Its net slip stresses nothing, `A d + B^T (f s) = 0` with d the sum of forward minus backward and s the sum of both, so no residual slip
    helps against it (the kinematic dual of the safe-slip theorem, Bjorkman & Klarbring 1987).

    Attributes
    ----------
    forward, backward
        (K, N) slip of each node at each corner, in any one unit.
    """

    forward: Array
    backward: Array

    @property
    def net(self) -> Array:
        """(N,) forward minus backward slip over the cycle."""
        return np.asarray(self.forward.sum(axis=0) - self.backward.sum(axis=0))

    @property
    def total(self) -> Array:
        """(N,) forward plus backward slip over the cycle."""
        return np.asarray(self.forward.sum(axis=0) + self.backward.sum(axis=0))

    def work(self, loads: Loads, friction: Array) -> tuple[float, float]:
        """Resistance of the mean load and drive of the cyclic load at load factor 1, both as work on the mechanism.

        A safe slip at load factor lam needs `lam * drive <= resistance`.
        """
        resistance = self.net @ loads.q0 + self.total @ (friction * loads.p0)
        drive = -np.sum((self.forward - self.backward) * loads.q1) - np.sum((self.forward + self.backward) * friction * loads.p1)
        return float(resistance), float(drive)

    def stress(self, system: ContactSystem, friction: Array) -> Array:
        """(N,) `A d + B^T (f s)`, which is zero for a true mechanism."""
        return np.asarray(system.A @ self.net + system.B.T @ (friction * self.total))

    def scaled(self, factor: float) -> "Mechanism":
        """The same mechanism with all slips multiplied."""
        return Mechanism(self.forward * factor, self.backward * factor)

    def table(self, x: Array) -> pd.DataFrame:
        """One row for each slip: node, x, corner, direction (+1 along +x, -1 against), share of the total slip; largest first."""
        parts = []
        whole = float(self.total.sum()) or 1.0
        for direction, slips in ((1, self.forward), (-1, self.backward)):
            corner, node = np.nonzero(slips > _SHARE * whole)
            parts.append(pd.DataFrame({"node": node, "x": x[node], "corner": corner, "direction": direction, "share": slips[corner, node] / whole}))
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

        def work(case: str, net: Array, total: Array) -> float:
            q, p = system.bonded[case]
            return float(net @ q + total @ (friction * p))

        rows: list[dict[str, Any]] = [
            {"load": case, "part": "mean", "amplitude": amplitude, "rate": work(case, self.net, self.total)} for case, amplitude in cycle.mean.items()
        ]
        for k, corner in enumerate(cycle.corners):
            net, total = self.forward[k] - self.backward[k], self.forward[k] + self.backward[k]
            rows += [
                {"load": case, "part": f"corner {k}", "amplitude": amplitude, "rate": load_factor * work(case, net, total)}
                for case, amplitude in corner.items()
            ]
        return pd.DataFrame(rows, columns=["load", "part", "amplitude", "rate"])


def expand_duals(interface: Interface, rows: LoadRows, duals: tuple[Array, Array], nodes: int, corners: int) -> Mechanism:
    """The mechanism of all nodes and corners that the multipliers of the kept rows stand for."""
    slips = []
    for dual, corner in zip(duals, (rows.forward_corner, rows.backward_corner), strict=True):
        slip = np.zeros((corners, nodes))
        np.add.at(slip, (corner, interface.nodes[rows.node]), dual / interface.unit[rows.node])
        slips.append(slip)
    forward, backward = slips
    if interface.mirror:
        forward, backward = (forward + backward[:, ::-1]) / 2, (backward + forward[:, ::-1]) / 2
    return Mechanism(forward, backward)
