"""What the multipliers of a safe-slip program mean: the slip mechanism, its bound on the load factor, and rates of the limit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, Booleans
from ..contact.coulomb import lengths
from ..contact.parts import joined, parted
from ..contact.show import places
from ..contact.tolerances import RESIDUAL

_SHARE = RESIDUAL  # parts of a mechanism below this share of it are left out of its table: they have the error of the answer


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A closed cycle of slips and lifts of node i at corner k; the multipliers of the safe-slip rows are one.

    Its net motion stresses nothing, `A d + B^T l = 0` with d the sum of the slips and l that of the lifts, so no residual slip helps against it (the
    kinematic dual of the safe-slip theorem, Bjorkman & Klarbring 1987).
    Under a bound on the slip, the net motion may stress nodes that their bound holds.

    Attributes
    ----------
    slips
        (K, N) slips along +x in the plane, (K, N, 2) along the tangents in space, in any one unit.
    lift
        (K, N) factors of the normal reactions in the mechanism's work: at least friction times the slip, more where the node opens without slip.
    friction
        (N,) coefficients of friction.
    hold
        (N,) or (N, 2) stress that the slip bound takes up at each node, along the tangents; None without a bound.
    press
        (K, O) forces that keep O open nodes from touching, where the mechanism is of the closed ones alone; None where it is of all.
    open
        (N,) nodes that are open, which follow the others without force; None where none is.
    """

    slips: Array
    lift: Array
    friction: Array
    hold: Array | None = None
    press: Array | None = None
    open: Booleans | None = None

    @property
    def size(self) -> Array:
        """(K, N) sizes of the slips."""
        return lengths(self.slips, self.lift)

    @property
    def opening(self) -> Array:
        """(K, N) openings without slip, >= 0 (of nodes with little or no friction, or without pressure)."""
        return np.asarray((self.lift - self.friction * self.size).clip(0.0))

    def stress(self, system: ContactSystem) -> Array:
        """(t N,) `A d + B^T l` less what the slip bound holds, ordered by component, which is zero for a true mechanism."""
        held = 0.0 if self.hold is None else self.hold.T.ravel()
        return np.asarray(system.A @ self.slips.sum(axis=0).T.ravel() + system.B.T @ self.lift.sum(axis=0) - held)

    def scaled(self, factor: float) -> "Mechanism":
        """The same mechanism with all motions multiplied by a factor >= 0."""
        hold, press = (None if part is None else part * factor for part in (self.hold, self.press))
        return replace(self, slips=self.slips * factor, lift=self.lift * factor, hold=hold, press=press)

    def table(self, system: ContactSystem, corners: Sequence[str]) -> pd.DataFrame:
        """One row for each motion, largest first; `corners` are the names of the K corners.

        Columns node, contact (where there are several), x (x, y, z in space), corner and its loads, direction (+1 slip along +x, -1 against it, 0
        opening, or touching of an open node; in space slip1 and slip2, a unit vector, zero for an opening), share of all.
        """
        names, along, opening = np.zeros(system.nodes) if system.contact is None else np.asarray(system.contact), self.size, self.opening
        if self.open is not None:
            touching = -parted(joined(self.slips, self.lift) @ system.S, system.tangents + 1)[1] / system.stiffness_scale
            along, opening = np.where(self.open, 0.0, along), np.where(self.open, touching.clip(0.0), opening)
        whole, parts = float(along.sum() + opening.sum()) or 1.0, []
        for size, slips in ((along, self.slips), (opening, np.zeros_like(self.slips))):
            corner, node = np.nonzero(size > _SHARE * whole)
            columns: dict[str, Any] = {
                "node": node,
                "contact": names[node],
                **{axis: place[node] for axis, place in places(system).items()},
                "corner": corner,
                "loads": [corners[k] for k in corner.tolist()],
            }
            sense = slips[corner, node]
            if system.tangents == 1:
                columns["direction"] = np.sign(sense).astype(int)
            else:
                columns["slip1"], columns["slip2"] = (sense / size[corner, node][:, None]).T
            parts.append(pd.DataFrame({**columns, "share": size[corner, node] / whole}))
        table = pd.concat(parts, ignore_index=True)
        table = table if len(np.unique(names)) > 1 else table.drop(columns="contact")
        return table.sort_values(["share", "node", "corner"], ascending=[False, True, True], ignore_index=True)

    def load_rates(self, system: ContactSystem, cycle: LoadCycle, load_factor: float) -> pd.DataFrame:
        """Rate of the limit with the amplitudes of all load cases in the mean load, and of those of the corners (for a mechanism of unit drive)."""

        def row(case: str, part: str, amplitude: float, factor: float, slips: Array, lift: Array) -> dict[str, Any]:
            q, p = system.bonded[case]
            return {"load": case, "part": part, "amplitude": amplitude, "rate": factor * float(np.sum(slips * q) + lift @ p)}

        net = self.slips.sum(axis=0), self.lift.sum(axis=0)
        rows = [row(case, "mean", cycle.mean.get(case, 0.0), 1.0, *net) for case in dict.fromkeys([*cycle.mean, *system.bonded])]
        for k, fixed in enumerate(cycle.fixed or ()):
            rows += [row(case, f"fixed at {cycle.corner_names[k]}", amplitude, 1.0, self.slips[k], self.lift[k]) for case, amplitude in fixed.items()]
        for k, corner in enumerate(cycle.corners):
            rows += [row(case, cycle.corner_names[k], amplitude, load_factor, self.slips[k], self.lift[k]) for case, amplitude in corner.items()]
        return pd.DataFrame(rows, columns=["load", "part", "amplitude", "rate"])

    def interference_rate(self, system: ContactSystem) -> Array:
        """(N,) rate of the limit with an interference at each node (for a mechanism of unit drive)."""
        return np.asarray(system.S[-system.nodes :] @ joined(self.slips.sum(axis=0), self.lift.sum(axis=0)))
