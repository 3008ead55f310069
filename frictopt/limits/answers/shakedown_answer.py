"""The data of a shakedown limit, and its proofs about states that its program does not cover."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...base import (
    FLOOR,
    RESIDUAL,
    ROUNDING,
    Array,
    Kept,
    LimitKind,
    Loads,
    Table,
    components,
    finite_array,
    finite_number,
    frame,
    frozen,
    kept,
    number_of,
    places,
)
from ...contact import ContactSystem, LoadCycle, joined, lengths, parted
from ...errors import ModelError, SolverError
from ..moving.moving_areas import has_all_states
from ..program.question import Question
from ..program.rest_program import is_held
from .answered import Proven, check_bound, check_contradiction, check_growth, check_slip


@dataclass(frozen=True, eq=False, repr=False)
class LeastSlip(Kept):
    """Proven lower bound of slip and gaps in every cycle at a load factor, from every start.

    The sum over the corners of `g @ v + h @ w` is at least `bound`. Theory, eq. (20). `v` and `w`
    are slips and gaps at the corners of any cycle, also before the motion is periodic. A bound that
    is not positive proves nothing. If nodes are open at the limit, the bound holds while these
    nodes carry no force.

    Attributes
    ----------
    load_factor, system, cycle
        The load factor, the contact and its load cycle.
    bound
        Load factor minus lambda_2, where lambda_2 is the upper bound that the multipliers prove.
    g, h
        (K, N) or (K, N, 2) weights of the slip and (K, N) weights of the gap at the corners, 1 /
        length. The sum of g over the corners is zero: only slip from corner to corner counts. The
        weights h matter only if nodes open.
    weight
        (N,) largest contribution of a node to the sum, per unit of slip between corners. It is half
        the sum of `abs(g)` over the corners; in space, if more than two corners have weights, the
        sum divided by sqrt(3).
    residual
        The larger of two errors: the residual of the limit; and the largest entry of the sum of g
        over the corners, divided by the largest force that the motions of one corner may cause.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> least = fo.shakedown_limit(rod, cycle, friction=0.5).least_slip(1.0)
    >>> round(least.bound, 6), round(least.total, 6), sorted(least.to_frame()["node"])
    (0.5, 1.0, [0, 1])
    """

    _shown_names = ("load_factor", "bound", "total", "residual")
    load_factor: float
    bound: float
    g: Array = field(repr=False)
    h: Array = field(repr=False)
    weight: Array = field(repr=False)
    system: ContactSystem = field(repr=False)
    cycle: LoadCycle = field(repr=False)
    residual: float

    @property
    def total(self) -> float:
        """Proven lower bound of the slip between corners, summed over the nodes, length.

        It holds while all nodes are closed. Inf if no cycle keeps all nodes closed.
        """
        largest = float(self.weight.max())
        if largest == 0:
            return np.inf if self.bound > 0 else 0.0
        return max(self.bound, 0.0) / largest

    def of(self, slip: Any, gap: Any = None) -> float:
        """The sum of `g @ slip + h @ gap` over the corners of a cycle, to compare with `bound`.

        Slips (K, N), in space (K, N, 2), and gaps (K, N) are lengths. If `gap` is None, all nodes
        are closed.

        Raises
        ------
        ModelError
            Other shapes, or numbers that are not finite.
        """
        total = np.sum(self.g * finite_array("slip", slip, self.g.shape))
        if gap is not None:
            total += np.sum(self.h * finite_array("gap", gap, self.h.shape))
        return float(total)

    def to_frame(self) -> Any:
        """The nodes that must slip, largest weight first.

        In every cycle that keeps all nodes closed, at least one of these nodes slips. Columns:
        node; its place; weight; alone, the slip of this node between corners if no other node
        slips, length; its weight `g` at each corner, with the loads of the corner in the name (in
        space `g1`, `g2`).
        """
        nodes = np.flatnonzero(self.weight)
        nodes = nodes[np.argsort(-self.weight[nodes], kind="stable")]
        weight = self.weight[nodes]
        table: dict[str, Any] = {"node": nodes}
        for name, values in places(self.system).items():
            table[name] = values[nodes]
        table["weight"] = weight
        table["alone"] = max(self.bound, 0.0) / weight
        for loads, g in zip(self.cycle.corner_names, self.g, strict=True):
            for name, column in components("g", g[nodes]).items():
                table[f"{name} at {loads}"] = column
        return frame(table)


@kept
class Searched(NamedTuple):
    """Proven facts on all sets of nodes that stay open, from the search of open nodes."""

    programs: int = 0
    # A load factor above which no set is safe; -inf if no set has a safe load factor. Sets that are
    # not safe at the limit are an exception: they may be safe above the bound, from the load factor
    # `separate` on.
    bound: float = np.inf
    separate: float = np.inf


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownAnswer(Proven):
    """Base of `ShakedownLimit`, whose docstring describes the fields."""

    kind: LimitKind
    bound: float
    least: float = np.nan
    objective: float | None = None
    gap: float | None = None
    # Why there is no largest safe load factor, in words, or a text that replaces the usual reason.
    _why: str = ""
    _searched: Searched = Searched()
    # Whether no state of rest exists just above the limit, for all openings and closings.
    _ends_rests: bool = False

    def check_kept(self) -> None:
        """Check the numbers, slip and mechanism of a limit from a file; ValueError if one is wrong.

        With a slip bound or rows of the user, which have further multipliers, or with nodes that
        open and close, the mechanism alone is no proof, and is not checked.
        """
        question = self._question
        plain = type(question) is Question and question.slip_bound is None
        plain = plain and not self.constraints and self.objective is None
        number = {LimitKind.UNBOUNDED: np.inf, LimitKind.NO_SAFE_SLIP: np.nan}.get(self.kind)
        if number is not None:
            if not np.array_equal([self.load_factor], [number], equal_nan=True):
                raise ValueError(f"its load factor is {self.load_factor:g}, its kind {self.kind}")
            if plain and self.kind is LimitKind.NO_SAFE_SLIP:
                check_contradiction(question, self._motion)
            elif plain and self._solved is not None:
                check_growth(question, self._solved)
            return
        check_slip(question, self.load_factor, self.slip)
        if self.least > self.load_factor + RESIDUAL * question.load_unit:
            raise ValueError(f"its least load factor {self.least:g} is above {self.load_factor:g}")
        if plain:
            # With a gap the mechanism need not agree with the lower number, which the slip proves.
            lower = self.load_factor if self.gap is None else self.bound
            check_bound(question, self._motion, lower, self.bound)

    def _check_exact(self, name: str) -> None:
        if self.gap is not None:
            raise ModelError(
                f"{name}: the multipliers of a limit with a gap prove its bound, and are too rough "
                "for more; ask for the limit with gap=None"
            )

    @property
    def _ruling(self) -> int:
        """The node that moves most in the mechanism."""
        motion = self._motion
        opened = self._question.open_nodes if motion.open is None else motion.open
        moves = np.where(opened, 0.0, motion.size + motion.opening)
        return int(moves.sum(axis=0).argmax())

    @cached_property
    def mechanism(self) -> Table:
        """The nodes that limit the load, largest share of the slip first.

        A symmetric contact has several such mechanisms; one is shown. Columns: node, contact (if
        several), x (x, y, z in space), corner, its loads, direction (+1 slips along +x, -1 against
        it, 0 opens; in space slip1 and slip2), share.
        """
        return self._mechanism

    @cached_property
    def friction_rate(self) -> Array:
        """(N,) rate of the limit with the friction of each node; the sum is the rate for all nodes.

        If the mechanism is not unique the limit has a kink, and this is one of its supergradients.
        NaN without a finite limit. ModelError for a limit with a gap.
        """
        self._check_exact("friction_rate")
        return frozen(self._by_friction)

    @property
    def _rated(self) -> bool:
        finite = bool(np.isfinite(self.load_factor))
        return finite and not self.constraints and not self._question.moves

    @cached_property
    def load_rates(self) -> Table:
        """Rate of the limit with each amplitude of the load cycle.

        Columns: load, part ("mean", or the loads of a corner), amplitude, rate. The mean part lists
        all load cases of the system, also unused ones: the bolt to tighten is the row with the
        largest rate. The limit has a kink if several nodes, such as mirror images, govern at once;
        each rate then lies between the rates of the two sides. The rates are NaN without a finite
        limit, and under user constraints, which may depend on the loads. They are NaN, too, if
        loads alone open and close nodes in each cycle (`events`): the loads then move the events,
        and the mechanism does not show this.
        """
        self._check_exact("load_rates")
        cycle = self.cycle
        moves = self._question.by_corner(self._motion.moves)  # (K, t + 1, N)
        net_motion = moves.sum(axis=0)
        rows = list[dict[str, Any]]()

        def add(loads: Loads, part: str, moves: Array, factor: float = 1.0) -> None:
            for case, amplitude in loads.items():
                work = float(moves.ravel() @ joined(*self.system.bonded[case]))
                rate = factor * work if self._rated else np.nan
                rows.append({"load": case, "part": part, "amplitude": amplitude, "rate": rate})

        absent = {case: 0.0 for case in self.system.bonded if case not in cycle.mean}
        add({**cycle.mean, **absent}, "mean", net_motion)
        for k, loads in enumerate(cycle.fixed or ()):
            add(loads, f"fixed at {cycle.corner_names[k]}", moves[k])
        for k, loads in enumerate(cycle.corners):
            add(loads, cycle.corner_names[k], moves[k], self.load_factor)
        return frame(rows, names=["load", "part", "amplitude", "rate"])

    @cached_property
    def interference_rate(self) -> Array:
        """(N,) rate of the limit with an interference at each node, 1 / length.

        The rate with a gap (profile) has the opposite sign. NaN if `load_rates` is NaN.
        """
        self._check_exact("interference_rate")
        rate = self.system.S[-self.system.nodes :] @ self._motion.moves.sum(axis=0).ravel()
        return frozen(rate if self._rated else np.full_like(rate, np.nan))

    @property
    def covers(self) -> str:
        """The states of rest for which `bound` holds, in words."""
        if self._all_states:
            return "all states of rest, for all openings and closings"
        if self._question.moves or self._ends_rests:
            return (
                "states of rest just above it, for all openings and closings; at higher load "
                "factors the contact may shake down again (`intervals`)"
            )
        if self._question.both_vary:
            return (
                f"no states, because it is infinite: even{self._question.node_states} the "
                "contact may shake down above the limit"
            )
        if self._question.events:
            return (
                f"states of rest{self._question.node_states}; with other nodes, or in another "
                "order, the contact may shake down above it"
            )
        states = "all nodes closed"
        if self.open.any():
            opened = number_of(int(self.open.sum()), "node")
            states = f"{opened} open (`open`) and the others closed"
        others = "with other nodes open, or"
        if self.best_of_all:
            states = f"any nodes open (here {states})"
            others = "with"
            if self._searched.separate < np.inf:
                least = self._searched.separate
                others = f"with other nodes open from {least:.6g} on, or with"
        return (
            f"states of rest with {states} all through the cycle; {others} nodes that open and "
            "close, the contact may shake down above it"
        )

    @property
    def programs(self) -> int:
        """The number of programs that the search of open nodes solved; 0 if the set was given."""
        return self._searched.programs

    @property
    def best_of_all(self) -> bool:
        """Whether no other set of nodes that stay open all through the cycle has a higher limit.

        Branch and bound proves it up to a relative difference of 1e-7, for all sets whose closed
        nodes hold the open nodes. Sets that are safe at no load factor up to the limit do not
        count; `covers` names the load factor from which they are safe. False if the search ended
        early, or if the set was given.
        """
        if not np.isfinite(self.load_factor):
            return bool(self._searched.bound == -np.inf or self.load_factor > 0)
        unit = FLOOR * self._question.load_unit
        # Twice the gain that counts in the search.
        return bool(self._searched.bound <= self.load_factor + 2e-7 * max(self.load_factor, unit))

    @property
    def _of_every_start(self) -> bool:
        """Whether the theorem of uncoupled contacts covers the limit of an uncoupled contact.

        If nodes open and close in each cycle, the proof of the theorem needs supports that hold the
        bodies.
        """
        if self.kind is LimitKind.NO_SAFE_SLIP:
            return False
        return not self._question.moves or is_held(self._question)

    @property
    def _all_states(self) -> bool:
        """Whether the limit covers all states of rest, see `has_all_states`."""
        if self.constraints or self.objective is not None:
            return False
        return has_all_states(self._question)

    @cached_property
    def apart(self) -> float:
        """Largest distance of the slip from the slip that the mean load causes, length.

        The mean load is applied to a contact without slip. NaN if the limit is not finite. If the
        distance is far larger than the slip that assembly can leave, usual starts do not lead to
        the state of rest; only a start with `slip` itself does. NoContinuation or SolverError if no
        state under the mean load is found.
        """
        # Imported here, because other results do not need it.
        from ...transients.march import mean_state

        settled = mean_state(self.system, self.cycle, self.friction).slip
        return float(lengths(np.reshape(settled, self.slip.shape) - self.slip, self.friction).max())

    def least_slip(self, load_factor: float) -> LeastSlip:
        """Proven lower bound of slip and gaps in every cycle at a load factor, from every start.

        It is positive above the limit. If nodes are open at the limit, the bound holds for cycles
        in which these nodes carry no force.

        Raises
        ------
        ModelError, SolverError
            Bad load factor; a limit that is not finite, or with events; a slip bound or user
            constraints, because the limit then proves nothing about other slips; multipliers that
            do not balance to the tolerance.
        """
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        question = self._question
        if question.events:
            raise ModelError(
                "least_slip: nodes open and close at the limit, so its multipliers do not bound "
                "the slip; use shakedown_limit without events"
            )
        finite = np.isfinite(self.load_factor)
        if not finite or self.constraints or question.slip_bound is not None:
            constrained = " under constraints on the slip" if finite else ""
            raise ModelError(
                f"least_slip: the limit (load factor {self.load_factor:g}{constrained}) bounds no "
                "slip from below; use a finite limit without slip bound and constraints"
            )
        system = question.system
        motion = self._motion
        axes = system.tangents + 1
        # Forces (K, M) that the motions cause at each corner, and the size of their largest term.
        forces = motion.moves.reshape(len(motion.moves), -1) @ system.S
        sizes = motion.size + motion.opening
        terms = np.tile(sizes, axes - 1) @ np.abs(system.A) + sizes @ np.abs(system.B)
        largest = float(terms.max())

        g, h = parted(forces, axes)
        unbalanced = float(np.abs(g.sum(axis=0)).max()) / largest if largest > 0 else 0.0
        residual = max(unbalanced, self.residual)
        if not residual <= RESIDUAL:
            raise SolverError(
                f"least slip: the multipliers of the limit are off by {residual:.1e} (tolerance "
                f"{RESIDUAL:g}); reactions or stiffnesses may differ too much in size"
            )

        # Weights that are only rounding are set to zero.
        g = np.where(np.abs(g) > ROUNDING * largest, g, 0.0)
        weights = lengths(g, h)
        many_corners = (weights > 0).sum(axis=0) > 2
        in_circle = many_corners & (system.tangents > 1)
        weight = weights.sum(axis=0) / np.where(in_circle, np.sqrt(3.0), 2.0)
        bound = load_factor - self.bound
        return LeastSlip(load_factor, bound, g, h, weight, system, self.cycle, residual)
