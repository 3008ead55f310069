"""Base classes of the answers to limit questions: a state under a residual slip, and its proof.

`Answered` is the base of answers that consist of a slip at a load factor. `Proven` adds the proof
by a mechanism.

Answers that were read from a file are proven again, from the numbers of the file alone: a slip
that obeys the contact law bounds a limit from below, and the slip mechanism bounds it from above.
Neither check needs a solver.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...base import (
    RESIDUAL,
    ROUNDING,
    Array,
    Booleans,
    Plotted,
    Recorded,
    SolveRecord,
    Table,
    components,
    frame,
    places,
)
from ...contact import (
    ROWS,
    ContactState,
    ContactSystem,
    LoadCycle,
    lengths,
    most_shear,
    parted,
)
from ...contact.diagnosis import counted
from ...errors import ModelError
from ...solve.explained import Explained
from ..guarantee.critical_state import critical_states
from ..program.question import Question
from ..program.solution import Mechanism, Solved, of_nodes

if TYPE_CHECKING:
    import cvxpy as cp

# Tolerance of a slip that was read from a file. It is wider than the tolerance of an answer,
# because on another processor rounding may lift a residual just above that tolerance.
_SLIP = 10 * RESIDUAL
# Relative tolerance for the forces of a mechanism, which balance only up to the tolerance of
# solvers.
_BALANCE = 1e-6


def check_slip(question: Question, load_factor: float, slip: Array) -> None:
    """Check that a slip is safe at a load factor; ValueError if it is not."""
    shape = question.system.slip_shape
    if slip.shape != shape:
        raise ValueError(f"its slip has the shape {slip.shape}, its contact needs {shape}")
    off = question.violation(load_factor, slip)
    # Errors are relative to the friction bounds, which exceed the forces if friction is large.
    largest = max(1.0, question.mean_bound / question.force)
    if not off <= _SLIP * largest + _rounding(question, load_factor, slip):
        raise ValueError(
            f"its slip violates the contact law by {off:.1e} at the load factor {load_factor:g}"
        )


def _rounding(question: Question, load_factor: float, slip: Array) -> float:
    """Rounding error of the forces, divided by the force unit; large if the slip is very large."""
    _, r = question.instants(load_factor, slip)
    return ROUNDING * float(np.abs(r).max()) / question.force


def reserve_of(question: Question, load_factor: float, slip: Array) -> float:
    """The smallest reserve of a slip over nodes and corners, in the unit of the margin."""
    u, r = question.instants(load_factor, slip)
    sticks, opened = question.statuses
    q = np.linalg.norm(r[:, :-1], axis=1)
    p = r[:, -1]
    reserves = np.minimum(
        (question.friction * p - q) / question.mean_bound, p / question.mean_pressure
    )
    of_gaps = np.min(u[:, -1], where=opened, initial=np.inf) / question.clearance
    return float(np.min(reserves, where=sticks, initial=of_gaps))


def check_critical(question: Question, node: int, load_factor: float, slip: Array) -> None:
    """Check that a slip makes a node critical at a load factor; ValueError if it does not."""
    states = critical_states(question)[node]
    off = min((each.distance(question, load_factor, slip) for each in states), default=np.inf)
    if not off <= _SLIP + _rounding(question, load_factor, slip):
        raise ValueError(f"its slip leaves node {node} {off:.1e} away from its critical state")


def check_margin(
    question: Question, load_factor: float, slip: Array, margin: float, bound: float
) -> None:
    """Check that a slip has its margin, and that no slip has more; ValueError if not."""
    tolerance = _SLIP * max(1.0, abs(margin))
    # Nodes that open and close have no reserve at their events.
    if type(question) is Question:
        reserve = reserve_of(question, load_factor, slip)
        if not margin <= reserve + tolerance + _rounding(question, load_factor, slip):
            raise ValueError(f"its margin is {margin:g}, and the reserve of its slip {reserve:g}")
    if not abs(bound - margin) <= tolerance:
        raise ValueError(f"its margin is {margin:g}, and the bound of it {bound:g}")


def check_bound(question: Question, motion: Mechanism, load_factor: float, bound: float) -> None:
    """Check that a mechanism proves the bound of a limit; ValueError if it does not."""
    if not motion.moves.any() and not question.system.B.any():
        return  # Just above the limit, the loads of this uncoupled contact open and close nodes.
    proven = bound_of(question, motion)
    for name, value in (("load factor", load_factor), ("bound", bound)):
        if not abs(proven - value) <= _BALANCE * max(abs(value), question.load_unit):
            raise ValueError(f"its {name} is {value:g}, and its mechanism proves {proven:g}")


def check_growth(question: Question, solved: Solved) -> None:
    """Check that a slip may grow with the load without end; ValueError if it violates the law."""
    rate = solved.values["load_factor"]
    # From this load factor on, the forces that do not grow are less than the share RESIDUAL of the
    # forces that do.
    far = question.load_unit / RESIDUAL
    off = np.inf
    if rate > 0:
        slip = question.slip_at_mean_load(far / rate * solved.values["slip"])
        off = RESIDUAL * question.violation(far, slip)
    if not off <= _SLIP:
        raise ValueError(f"its slip grows with the load and leaves the contact law by {off:.1e}")


def check_contradiction(question: Question, motion: Mechanism) -> None:
    """Check that a mechanism proves that no slip is safe; ValueError if it does not."""
    if not bound_of(question, motion) < 0:
        raise ValueError("it has no safe slip, and its mechanism does not prove this")


def bound_of(question: Question, motion: Mechanism) -> float:
    """The load factor above which a mechanism proves that no slip is safe; nan without a proof.

    If no load factor is safe, this number is below 0.

    In a safe state the forces do no negative work on the mechanism. At a closed node, the shear
    force is at most friction times the pressure, and the mechanism lifts the node by at least
    friction times its slip. At open nodes the mechanism causes no shear force and no pressure. The
    forces of a residual slip do no work on the mechanism, so only the loads do.
    """
    system = question.system
    normals = len(system.S) - system.nodes
    moves = motion.moves.reshape(len(motion.moves), -1)
    forces = moves @ system.S
    scale = _BALANCE * float((np.abs(moves) @ np.abs(system.S)).max(initial=0.0))
    opened = question.open_nodes
    of_opened = np.tile(opened, system.tangents)
    sheared = np.where(opened, 0.0, question.friction * motion.size - moves[:, normals:])
    sheared = sheared.clip(0.0)
    if not system.capped and (sheared > _BALANCE * np.abs(moves).max()).any():
        return np.nan
    unbalanced = (
        np.abs(forces.sum(axis=0)[:normals][~of_opened]).max(initial=0.0),
        np.abs(forces[:, :normals][:, of_opened]).max(initial=0.0),
        forces[:, normals:][:, opened].max(initial=0.0),
    )
    if max(unbalanced) > scale:
        return np.nan
    resistance = float((moves * question.at_instants(0.0)).sum()) + _work_of_shearing(
        question, sheared
    )
    drive = motion.drive(question)
    if drive > 0:
        return resistance / drive
    # If the loads do almost no work on the mechanism, rounding may hide its sign.
    return -np.inf if RESIDUAL * resistance < question.load_unit * drive else np.nan


def _work_of_shearing(question: Question, sheared: Array) -> float:
    """Work at the slips of a mechanism at which the surface shears off.

    At such a slip, the mechanism lifts the node by less than friction times the slip; `sheared` is
    the difference.
    """
    if not question.system.capped:
        return 0.0
    slopes = np.where(question.friction > 0, question.friction, 1.0)
    strength = np.where(sheared.any(axis=0), question.system.shear_strength, 0.0)
    return float((sheared / slopes * strength).sum())


# Labels of the rows of a corner.
_OF_CORNER = re.compile(rf"(?:q|p|gap|{'|'.join(ROWS)}|pressed|apart)(?:_\d+)?\[(\d+)\]")


@dataclass(frozen=True, eq=False, repr=False)
class Answered(Recorded, Plotted):
    """Base of results that answer a limit question by a residual slip at a load factor."""

    load_factor: float
    slip: Array
    record: SolveRecord
    _question: Question

    def check_kept(self) -> None:
        """Check the slip of an answer from a file; ValueError if it should be safe and is not."""
        if self._has_safe_slip:
            check_slip(self._question, self.load_factor, self.slip)

    @property
    def _has_safe_slip(self) -> bool:
        return bool(np.isfinite(self.load_factor))

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
        """Reactions `q, p` at the corners under the slip at the load factor, force.

        (K, N) or (K, N, 2) and (K, N); NaN without a finite load factor.
        """
        return self._carried(self._question.states, len(self._question.r1))

    def _carried(
        self, states: Callable[[float, Array], tuple[Array, Array]], instants: int
    ) -> tuple[Array, Array]:
        """Reactions `q, p` at corners or instants."""
        entries = self.slip.size + self.system.nodes
        if np.isfinite(self.load_factor) and not np.isnan(self.slip).any():
            _, r = states(self.load_factor, self.slip)
        else:
            r = np.full((instants, entries), np.nan)
        return parted(r.reshape(instants, entries), self.system.tangents + 1)

    @property
    def _instants(self) -> tuple[Sequence[str], Array, Array]:
        """Names and reactions of the corners; with events also of the instants between them."""
        names = self._question.names
        q, p = self._carried(self._question.instants, len(names))
        return names, q, p

    @property
    def open(self) -> Booleans:
        """(N,) which nodes are open at all corners."""
        return self._question.open_nodes

    @property
    def events(self) -> Table:
        """The nodes that open and close in each cycle, in the order in which the load meets them.

        Columns: node, contact (if several), x (x, y, z in space), event ("opens" or "closes"), way,
        loads (at this place, for load factor 1). The way counts segments: 2.5 is half way from
        corner 2 to the next one. If the load goes to and fro on a line, the way is 0 at one end and
        1 at the other. The table then has only the events from the first end to the other, because
        the way back has them in reverse. But if normal loads alone open and close nodes, the table
        has all events of the cycle. The table is empty if no node opens and closes.
        """
        import pandas as pd  # imported here, because only tables need it

        columns = {"node": int, "event": str, "way": float, "loads": str}
        table = pd.DataFrame(self._question.events, columns=list(columns)).astype(columns)
        nodes = of_nodes(self.system, table.pop("node").to_numpy())
        return pd.DataFrame({**nodes, **table})

    @property
    def largest_slip(self) -> float:
        """Largest size of the slip at a closed node, length; NaN without a slip.

        If it is far above what assembly can leave, give a `slip_bound`.
        """
        sizes = lengths(self.slip, self.friction)
        if not np.isfinite(sizes).all():
            return np.nan
        return float(sizes[~self.open].max(initial=0.0))

    @property
    def _opened(self) -> str:
        """The beginning of a reason: how many nodes are open, by contact."""
        if not self.open.any():
            return ""
        return f"with {counted(self.system, self.open)}: ".replace("nodes", "nodes open", 1)

    @property
    def state(self) -> ContactState | None:
        """The state at the last corner; None without a finite load factor.

        If the slip is safe, a transient from this state at this load factor stays stuck.
        """
        if not np.isfinite(self.load_factor) or not np.isfinite(self.slip).all():
            return None
        u, _ = self._question.states(self.load_factor, self.slip)
        v, w = parted(u[-1].ravel(), self.system.tangents + 1)
        bonded = self.system.reaction(self.cycle.at(self.load_factor)[-1])
        return ContactState(v, w.clip(0.0), *bonded, next_loads=self.cycle.corner_names[0])

    @property
    def traction_ratios(self) -> Array:
        """(K, N) ratios `|q| / (f p)` at the corners under the slip.

        NaN without a slip, and where pressure or friction vanishes. Where the surface has a shear
        strength below f p, q is divided by the strength.
        """
        q, p = self.reactions
        f = self.friction
        # Smaller bounds are within the error of the answer.
        pressed = f * p > 10 * RESIDUAL * self._question.mean_bound
        bound = np.where(pressed, most_shear(self.system, f, p), 1.0)
        return np.where(pressed, lengths(q, p) / bound, np.nan)

    def to_frame(self) -> Table:
        """A row for each node: node, its place, its slip, and, if any node is open, `open`."""
        opened = {"open": self.open} if self.open.any() else {}
        columns = {
            "node": range(self.system.nodes),
            **places(self.system),
            **components("slip", self.slip),
            **opened,
        }
        return frame(columns, units=self.system.units)


@dataclass(frozen=True, eq=False, repr=False)
class Proven(Answered, Explained):
    """Base of answers that a mechanism proves, possibly under constraints of the user."""

    _motion: Mechanism
    constraints: tuple[str, ...] = field(default=(), kw_only=True)
    _solved: Solved | None = field(default=None, kw_only=True)

    def __getstate__(self) -> dict[str, object]:
        """The fields of a copy, which has its own problem."""
        return {**super().__getstate__(), "_solved": copy.copy(self._solved)}

    def _check_exact(self, name: str) -> None:
        """ModelError if the multipliers are too rough for an attribute of this name."""

    @cached_property
    def problem(self) -> cp.Problem:
        """The cvxpy problem in your units, with the values and multipliers of the answer.

        The problem is made when this attribute is first read. If a model gave this answer, its
        problem has the variables of the model, which then get the values of this answer.
        """
        self._check_exact("problem")
        solved = self._solved
        if solved is None or (self.constraints and solved.problem is None):
            raise ModelError(
                "problem: the file of this result leaves out its problem, as files do if it has "
                "constraints of a model; solve it again, or pickle the result"
            )
        # Imported here, because cvxpy is slow to import, and answers do not need it.
        from ..printed.listing import problem_of

        return problem_of(solved)

    @property
    def multipliers(self) -> Table:
        """Multipliers of the rows of `problem`, in its units.

        Columns: row (its label), corner, node, component, multiplier. The multipliers of `q[k] ==
        ...` and `p[k] == ...` are slips and lifts of the mechanism (1 / force if the goal is a load
        factor). The multipliers of `stuck[k]` are the sizes of these slips; the multipliers of
        `strength[k]` are the sizes of slips at which the surface shears off. A row without a label
        has the name of its left side, or of its right side if the left is constant. In user
        constraints, node is the first index of an entry and component the other indices. The table
        is empty if no program was solved.
        """
        import pandas as pd  # imported here, because only tables need it

        self._check_exact("multipliers")
        # Imported here, because cvxpy is slow to import.
        from ...solve.problem import duals
        from ..printed.listing import problem_of

        solved = self._solved
        rows = {} if solved is None else {**duals(problem_of(solved)), **solved.own}
        if not rows:
            kinds = {"row": str, "corner": int, "node": int, "component": int, "multiplier": float}
            return pd.DataFrame(columns=list(kinds)).astype(kinds)
        return pd.concat([self._table_of(*dual) for dual in rows.items()], ignore_index=True)

    def _table_of(self, name: str, dual: Array) -> Table:
        """The multipliers of one row."""
        corner = _OF_CORNER.fullmatch(name)
        values = dual.reshape(len(dual), int(np.prod(dual.shape[1:])))
        node, component = (index.ravel() for index in np.indices(values.shape))
        for term in self._question.law.terms[1:]:
            if name.startswith(term.row):
                node = term.nodes[node]
        columns = {
            "row": name,
            "corner": int(corner.group(1)) if corner else -1,
            "node": node,
            "component": component,
            "multiplier": values.ravel(),
        }
        return frame(columns)

    @property
    def _mechanism(self) -> Table:
        """The table of the mechanism, see `ShakedownLimit.mechanism`."""
        return self._motion.table(self.system, self._question.names)

    @property
    def _by_friction(self) -> Array:
        """(N,) rate of the goal with each node's friction: friction multipliers times pressures."""
        _, _, p = self._instants
        if self._question.moves:
            # In this program, a corner may be a different instant at each node.
            return np.asarray((self._motion.size * p).sum(axis=0))
        stuck = self._solved.multipliers.get("stuck", 0.0) if self._solved else 0.0
        return np.asarray((np.maximum(stuck, 0.0) * p).sum(axis=0))


A = TypeVar("A", bound=Answered)


def answered(claim: A, record: SolveRecord) -> A:
    """Give an accepted answer its record, which lists what its program leaves out."""
    question = claim._question
    left_out = list(record.left_out)
    corners = len(question.r1)
    listed = len(question.listed_corners)
    # Rows of the user may contain any corner, and events may lie between the outer corners.
    plain = isinstance(claim, Proven) and not claim.constraints and not question.events
    if plain and listed < corners:
        left_out.append(
            f"corners: {corners - listed} of {corners} are within the hull of the others"
        )
    opened = int(question.open_nodes.sum())
    if opened:
        left_out.append(f"nodes: {opened} of {len(question.open_nodes)} stay open")
    seconds = perf_counter() - question.started
    return replace(claim, record=replace(record, left_out=tuple(left_out), seconds=seconds))
