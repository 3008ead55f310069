"""What the answers of limit questions have in common: the state under a residual slip at a load factor, and the mechanism that proves them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import Any, TypeVar

import cvxpy as cp
import numpy as np
import pandas as pd

from ..base import (
    RESIDUAL,
    Array,
    Booleans,
    Integers,
    Plotted,
    Recorded,
    SolveRecord,
    components,
    frame,
    frozen,
    kept,
    places,
)
from ..contact import ContactState, ContactSystem, LoadCycle, joined, lengths, most_shear, parted
from ..contact.diagnosis import counted
from ..solve.problem import Duals, Explained, duals
from .question import Question

_BARE = (
    10 * RESIDUAL
    # share of the mean friction bound below which a node carries nothing, and its traction ratio is
    # rounding
)
_OF_CORNER = re.compile(
    r"(?:q|p|gap|stuck|strength|pressed|apart)(?:_\d+)?\[(\d+)\]"
)  # how rows of a corner are called
# parts of a mechanism below this share of it are left out of its table: they have the error of the
# answer
_SHARE = RESIDUAL


@kept
@dataclass(frozen=True, eq=False)
class Mechanism:
    """A closed cycle of slips and lifts of node i at corner k; the multipliers of the safe-slip rows are one.

    The net motion stresses nothing, `A d + B^T l = 0` with the sums d of the slips and l of the
    lifts, so no residual slip helps against it (Bjorkman & Klarbring 1987); under a slip bound it
    may stress nodes that the bound holds.

    Attributes
    ----------
    moves
        (K, t + 1, N) slips along the tangents, in any one unit, and lifts, at least friction times
        the slip; more where the node opens without slip, less where the surface shears off.
    friction, open
        (N,) coefficients of friction; nodes that are open and follow the others without force, None
        where none is.
    """

    moves: Array
    friction: Array
    open: Booleans | None = None

    @property
    def size(self) -> Array:
        """(K, N) sizes of the slips."""
        return np.asarray(np.hypot.reduce(self.moves[:, :-1], axis=1, initial=0.0))

    @property
    def opening(self) -> Array:
        """(K, N) openings without slip, >= 0 (of nodes with little or no friction, or without pressure)."""
        return np.asarray((self.moves[:, -1] - self.friction * self.size).clip(0.0))

    def parts(self, system: ContactSystem) -> Array:
        """(2, K, N) sizes of the slips, and of the openings, or of the touching of open nodes."""
        along, opening = self.size, self.opening
        if self.open is not None:
            touching = (
                -self.moves.reshape(len(along), -1)
                @ system.S[:, -system.nodes :]
                / system.stiffness_scale
            )
            along, opening = (
                np.where(self.open, 0.0, along),
                np.where(self.open, touching.clip(0.0), opening),
            )
        return np.stack([along, opening])

    def drive(self, question: Question) -> float:
        """Work that what a load factor of 1 adds does on the mechanism."""
        return -float(np.sum(self.moves.reshape(len(self.moves), -1) * question.bonded[1]))

    def table(self, system: ContactSystem, corners: Sequence[str]) -> pd.DataFrame:
        """One row for each motion, largest first; `corners` are the names of the K corners.

        Columns node, contact (where there are several), x (x, y, z in space), corner and its loads,
        direction (+1 slip along +x, -1 against it, 0 opening, or touching of an open node; in space
        slip1 and slip2, a unit vector, zero for an opening), share of all.
        """
        sizes, slips = (
            self.parts(system),
            np.stack([self.moves[:, :-1], np.zeros_like(self.moves[:, :-1])]),
        )
        share = sizes / (float(sizes.sum()) or 1.0)
        way, corner, node = np.nonzero(share > _SHARE)
        order = np.lexsort([corner, node, -share[way, corner, node]])
        way, corner, node = way[order], corner[order], node[order]
        columns: dict[str, Any] = {
            **of_nodes(system, node),
            "corner": corner,
            "loads": pd.Series([corners[k] for k in corner.tolist()], dtype=str),
        }
        sense = slips[way, corner, :, node].T
        if system.tangents == 1:
            columns["direction"] = np.sign(sense[0]).astype(int)
        else:
            columns["slip1"], columns["slip2"] = sense / sizes[way, corner, node]
        return pd.DataFrame({**columns, "share": share[way, corner, node]})


def of_nodes(system: ContactSystem, node: Integers) -> dict[str, np.ndarray]:
    """Columns of a table of some nodes: node, contact (where there are several), x (x, y, z in space)."""
    names: dict[str, np.ndarray] = (
        {}
        if system.contact is None or len(np.unique(system.contact)) < 2
        else {"contact": np.asarray(system.contact)}
    )
    return {
        "node": node,
        **{name: values[node] for name, values in (names | places(system)).items()},
    }


@dataclass(frozen=True, eq=False, repr=False)
class Answered(Recorded, Plotted):
    """Base of results that answer a limit question by a residual slip at a load factor."""

    load_factor: float
    slip: Array
    record: SolveRecord
    _question: Question

    @property
    def system(self) -> ContactSystem:
        """The contact."""
        return self._question.system

    @property
    def cycle(self) -> LoadCycle:
        """The load cycle."""
        return self._question.cycle

    @property
    def friction(self) -> Array:
        """(N,) coefficients of friction."""
        return self._question.friction

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) or (K, N, 2) and (K, N) reactions `q, p` at the corners under the slip at the load factor, force; NaN where it is not finite."""
        return self._carried(self._question.states, len(self._question.r1))

    def _carried(
        self, states: Callable[[float, Array], tuple[Array, Array]], count: int
    ) -> tuple[Array, Array]:
        nan, n = (
            np.isnan(self.slip).any() or not np.isfinite(self.load_factor),
            self.slip.size + self.system.nodes,
        )
        return parted(
            np.full((count, n), np.nan)
            if nan
            else states(self.load_factor, self.slip)[1].reshape(count, n),
            self.system.tangents + 1,
        )

    @property
    def _instants(self) -> tuple[Sequence[str], Array, Array]:
        """Names of the corners, and the reactions there; of nodes that open and close in each cycle also of the events between them."""
        return self._question.names, *self._carried(
            self._question.instants, len(self._question.names)
        )

    @property
    def open(self) -> Booleans:
        """(N,) which nodes are open at all corners."""
        return self._question.open_nodes

    @property
    def events(self) -> pd.DataFrame:
        """Which nodes open and close on the way from the first corner to the last, in turn; on the way back in reverse. Mostly empty.

        Columns node, contact (if several), x (x, y, z in space), event ("opens" or "closes"), way
        (part of the way, 0 to 1), loads (there, at load factor 1).
        """
        found = pd.DataFrame(self._question.events, columns=["node", "event", "way", "loads"])
        found = found.astype({"node": int, "event": str, "way": float, "loads": str})
        return pd.DataFrame({**of_nodes(self.system, found.pop("node").to_numpy()), **found})

    @property
    def open_share(self) -> Array:
        """(N,) part of the cycle in which each node is open: 1 where it is open all through, in between where it opens and closes."""
        return frozen(self._question.open_share)

    @property
    def largest_slip(self) -> float:
        """Largest size of the slip at a closed node, length; NaN without a slip. If it is far above what assembly can leave, give a `slip_bound`."""
        sizes = lengths(self.slip, self.friction)
        return float(sizes[~self.open].max(initial=0.0)) if np.isfinite(sizes).all() else np.nan

    @property
    def _opened(self) -> str:
        """How many nodes are open, by contact, as the beginning of a reason."""
        return (
            f"with {counted(self.system, self.open)}: ".replace("nodes", "nodes open", 1)
            if self.open.any()
            else ""
        )

    @property
    def state(self) -> ContactState | None:
        """The state at the last corner, from which a transient at this load factor rests where the slip is safe; None where it is not finite."""
        if not np.isfinite(self.load_factor) or not np.isfinite(self.slip).all():
            return None
        v, w = parted(
            self._question.states(self.load_factor, self.slip)[0][-1].ravel(),
            self.system.tangents + 1,
        )
        bonded = self.system.reaction(self.cycle.at(self.load_factor)[-1])
        return ContactState(v, w.clip(0.0), *bonded, next_loads=self.cycle.corner_names[0])

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the slip; NaN where the pressure or the friction vanishes, or without a slip.

        Where the surface has a shear strength below f p, the ratio is that to it.
        """
        (q, p), f = self.reactions, self.friction
        pressed, bound = f * p > _BARE * self._question.mean_bound, most_shear(self.system, f, p)
        return np.where(pressed, lengths(q, p) / np.where(pressed, bound, 1.0), np.nan)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its slip, and whether it is open where one is."""
        return frame(self._places(), units=self.system.units)

    def _places(self) -> dict[str, object]:
        """Columns of a table with one row for each node: node, its place, its slip, and whether it is open where one is."""
        opened = {"open": self.open} if self.open.any() else {}
        return {
            "node": range(self.system.nodes),
            **places(self.system),
            **components("slip", self.slip),
            **opened,
        }


@dataclass(frozen=True, eq=False, repr=False)
class Proven(Answered, Explained):
    """Base of answers that a mechanism proves, maybe under constraints of the user's own."""

    _motion: Mechanism
    constraints: tuple[str, ...] = field(default=(), kw_only=True)
    problem: cp.Problem | None = field(default=None, kw_only=True)
    _duals: Duals = field(default=(), kw_only=True)

    @property
    def multipliers(self) -> pd.DataFrame:
        """Multipliers of the rows of `problem`, in its units: columns row (its label), corner, node, component, multiplier.

        Of rows `q[k] == ...` and `p[k] == ...` they are slips and lifts of the mechanism, over
        force for a load factor; of `stuck[k]` sizes of these slips, of `strength[k]` of those in
        which the surface shears off. A row without a label is named by its left side, or its right
        side if the left is constant. In your own rows, node is the first index of an entry and
        component the others. Empty without a program.
        """
        none = pd.DataFrame(
            {"row": [], "corner": [], "node": [], "component": [], "multiplier": []}
        )
        tables = [none.astype({"row": str, "corner": int, "node": int, "component": int})] * (
            not self._duals
        )
        for name, dual in self._duals:
            corner = int(found.group(1)) if (found := _OF_CORNER.fullmatch(name)) else -1
            values = dual.reshape(len(dual), int(np.prod(dual.shape[1:])))
            node, component = (part.ravel() for part in np.indices(values.shape))
            node = (
                np.flatnonzero(np.isfinite(self.system.shear_strength))[node]
                if name.startswith("strength")
                else node
            )
            tables.append(
                pd.DataFrame(
                    {
                        "row": name,
                        "corner": corner,
                        "node": node,
                        "component": component,
                        "multiplier": values.ravel(),
                    }
                )
            )
        return pd.concat(tables, ignore_index=True)

    @property
    def _by_friction(self) -> Array:
        """(N,) rate with the friction of each node: the multipliers of its bounds times its pressures."""
        p, rows = (
            self._instants[2],
            dict(reversed(self._duals)),
        )  # the first of a name: your own rows come last
        return np.asarray(
            np.sum(
                [np.maximum(rows.get(f"stuck[{k}]", 0.0), 0.0) * p[k] for k in range(len(p))],
                axis=0,
            )
        )


A = TypeVar("A", bound=Answered)


def answered(claim: A, record: SolveRecord, program: Any) -> A:
    """The claim that has passed, with its program and how it was found."""
    question, left_out = claim._question, list(record.left_out)
    idle = len(program.x.q) - len(program.corners)
    left_out += [f"corners: {idle} of {len(program.x.q)} are within the hull of the others"] * bool(
        idle
    )
    opened = int(question.open_nodes.sum())
    left_out += [f"nodes: {opened} of {len(question.open_nodes)} stay open"] * bool(opened)
    record = replace(record, left_out=tuple(left_out), seconds=perf_counter() - question.started)
    return replace(claim, record=record, problem=program.problem, _duals=duals(program.problem))  # type: ignore[call-arg]  # which all that are judged have


class Rated(Proven):
    """Base of limits whose motion gives their rates with the loads."""

    @property
    def _rated(self) -> bool:
        return bool(np.isfinite(self.load_factor)) and not self.constraints

    @cached_property
    def load_rates(self) -> pd.DataFrame:
        """Rate of the limit with each amplitude of the load cycle: columns load, part ("mean", or the loads of a corner), amplitude, rate.

        The mean part has all load cases of the system, so the bolt to tighten is the row with the
        largest rate. The rates of a guaranteed limit are those of the critical state of `node`:
        where several nodes, such as mirror images, are critical first, or more corners than needed,
        the limit has a kink, and this is the rate of one side. NaN without a finite limit, where a
        guaranteed limit is `least`, and under constraints of your own, which may change with the
        loads.
        """
        moves, cycle, system = self._question.by_corner(self._motion.moves), self.cycle, self.system

        def row(
            case: str, part: str, amplitude: float, moves: Array, factor: float = 1.0
        ) -> dict[str, Any]:
            return {
                "load": case,
                "part": part,
                "amplitude": amplitude,
                "rate": factor * float(moves.ravel() @ joined(*system.bonded[case])),
            }

        net = moves.sum(axis=0)
        rows = [
            row(case, "mean", cycle.mean.get(case, 0.0), net)
            for case in dict.fromkeys([*cycle.mean, *system.bonded])
        ]
        for k, fixed in enumerate(cycle.fixed or ()):
            rows += [
                row(case, f"fixed at {cycle.corner_names[k]}", amplitude, moves[k])
                for case, amplitude in fixed.items()
            ]
        for k, corner in enumerate(cycle.corners):
            rows += [
                row(case, cycle.corner_names[k], amplitude, moves[k], self.load_factor)
                for case, amplitude in corner.items()
            ]
        rates = pd.DataFrame(rows, columns=["load", "part", "amplitude", "rate"])
        return rates if self._rated else rates.assign(rate=np.nan)

    @cached_property
    def interference_rate(self) -> Array:
        """(N,) rate of the limit with an interference at each node, 1 over length; minus that with a profile. NaN where `load_rates` is."""
        rate = self.system.S[-self.system.nodes :] @ self._motion.moves.sum(axis=0).ravel()
        return frozen(rate if self._rated else np.full_like(rate, np.nan))
