"""Nodes that open and close in each cycle, where the load goes to and fro between two corners: the limit of a given order of openings and closings.

A contact also rests if nodes lift off on the way, carry nothing, and come down where they left. At an event m, where its nodes just touch, the load
is on the line between the corners, at a part of the way that is an unknown, so that a given order of events is a linear program, in space a cone
program::

    q[m] = q0 + load_factor q1[0] + way[m] (q1[1] - q1[0]) + A slip        0 <= way[1] <= way[2] <= ... <= load_factor

and so for p and the gaps, with A and the loads of the nodes that are closed before or after it. Between the instants, that is the corners and events,
all is linear and no node opens or closes: nodes that stick at both ends stick in between. On the way back it is the same the other way round.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import accumulate, pairwise
from time import perf_counter
from types import SimpleNamespace
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from ..contact import Array, Booleans, LimitKind, LoadCycle, SolveRecord
from .answered import Mechanism, duals
from .models import Unknowns, events, named, ordered, rest, shakedown, stuck, times, unknowns
from .programs import Program
from .question import Question
from .shakedown_result import ShakedownLimit, upper_bound

Nodes = frozenset[int]


def among(nodes: Nodes, count: int) -> Booleans:
    """Which of all nodes these are."""
    return np.isin(np.arange(count), sorted(nodes))


class Order(NamedTuple):
    """Which nodes are open at the first corner, and those that open or close at each event on the way to the last."""

    start: Nodes
    events: tuple[Nodes, ...] = ()

    @property
    def between(self) -> list[Nodes]:
        """Nodes that are open from the first corner to the first event, and so on up to the last corner."""
        return list(accumulate(self.events, frozenset.symmetric_difference, initial=self.start))

    @property
    def through(self) -> list[Nodes]:
        """Nodes that are open before and after each instant."""
        sets = self.between
        return [sets[0], *(before & after for before, after in pairwise(sets)), sets[-1]]


@dataclass(frozen=True, eq=False, kw_only=True)
class LiftOff(Question):
    """A question with nodes that open and close in each cycle; `open` are those that are open all through it.

    Attributes
    ----------
    order
        Which nodes open and close, and when.
    way
        (M,) part of the way from the first corner to the last at which each instant is.
    sets
        The same question with the nodes open that are open at each instant.
    """

    order: Order
    way: Array
    sets: tuple[Question, ...]

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Slips and gaps, and reactions, at the corners and events; see `Question.instants`."""
        found = {each: each.states(load_factor, slip) for each in dict.fromkeys(self.sets)}
        blends = [[(1 - s) * part[0] + s * part[-1] for part in found[each]] for each, s in zip(self.sets, self.way, strict=True)]
        return np.array([u for u, _ in blends]), np.array([r for _, r in blends])

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """The same at the corners."""
        ends = self.sets[0].states(load_factor, slip), self.sets[-1].states(load_factor, slip)
        return np.stack([ends[0][0][0], ends[1][0][-1]]), np.stack([ends[0][1][0], ends[1][1][-1]])

    def at_instants(self, load_factor: float) -> Array:
        """See `Question.at_instants`."""
        (first, last), way = super().at_instants(load_factor), self.way[:, None]
        return np.asarray((1 - way) * first + way * last)

    def by_corner(self, moves: Array) -> Array:
        """Motions at events by the shares that the loads of the corners have in them."""
        return np.tensordot([1 - self.way, self.way], moves, 1)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Loads of the cycle at the corners and events, at load factor 1."""
        first, last = self.cycle.corners
        cases = dict.fromkeys([*first, *last])
        blends = [{case: (1 - s) * first.get(case, 0.0) + s * last.get(case, 0.0) for case in cases} for s in self.way.tolist()]
        return LoadCycle(self.cycle.mean, blends).corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """See `Question.events`."""
        found = zip(self.order.events, self.order.between, self.way[1:-1].tolist(), self.names[1:-1], strict=False)
        return [(i, "closes" if i in opened else "opens", way, name) for nodes, opened, way, name in found for i in sorted(nodes)]

    @property
    def open_share(self) -> Array:
        """See `Question.open_share`."""
        opened = [among(nodes, len(self.open)) for nodes in self.order.between]
        return np.asarray(np.diff(self.way) @ opened)

    @property
    def pattern(self) -> str:
        """See `Question.pattern`."""
        count, opened = len(frozenset().union(*self.order.events)), ", these nodes open" * bool(self.open.any())
        return f" with {count} nodes that open and close in this order{opened} and the others closed"

    def violation(self, load_factor: float, slip: Array) -> float:
        """Largest violation of the contact law at the corners and events, by what a node carries where it opens or closes, and by their order."""
        r = self.instants(load_factor, slip)[1]
        touching = [np.abs(r[m][:, sorted(nodes)]).max() / self.force for m, nodes in enumerate(self.order.events, start=1)]
        off = np.max([super().violation(load_factor, slip), *touching, -np.diff(self.way).min()])
        return float(np.nan_to_num(off, nan=np.inf))


def of_order(
    task: Question, order: Order, of_set: Callable[[Nodes], Question | None], solver: str | None, above: float = -np.inf
) -> ShakedownLimit | None:
    """The limit of a given order; `of_set` gives the question with some nodes open. None if the others do not hold them.

    Raises
    ------
    SolverError
        No answer that passes the checks, or it is proven not to be `above` a load factor.
    """
    sets = [each for nodes in order.through if (each := of_set(nodes))]
    always = of_set(frozenset.intersection(*order.through))
    if always is None or len(sets) < len(order.through):
        return None
    x = unknowns(task.system.slip_shape, range(len(sets)))
    f, way = cp.Parameter(task.system.nodes, nonneg=True, name="f"), [cp.Variable(name=f"way[{m}]") for m in range(1, len(sets) - 1)]
    f.value = task.friction
    parts = [_listed(each, x, f, way, [m for m, one in enumerate(sets) if one is each], k) for k, each in enumerate(dict.fromkeys(sets))]
    rows = [row for part in parts for row in part.rows] + events(x, {m: sorted(nodes) for m, nodes in enumerate(order.events, start=1)})
    units = {variable: unit for part in parts for variable, unit in part.units.items()} | dict.fromkeys(way, task.load_unit)
    program = parts[0].compiled(shakedown(x, rows + ordered(x.load_factor, way)), task.load_unit, units, parts[1:])

    def asked(shares: list[float]) -> LiftOff:
        known = {each.name: getattr(always, each.name) for each in fields(always)}
        return LiftOff(**known, order=order, way=np.array([0.0, *shares, 1.0]), sets=tuple(sets))

    def judged() -> ShakedownLimit:
        load_factor, proof = program.load_factor, program.chain.proof
        bound = upper_bound(proof, above)
        question = asked([float(part.value) / load_factor if load_factor > 0 else 0.0 for part in way])
        slip, opened = always.rested(np.array(x.slip.value)), np.array([each.open for each in sets])
        record = SolveRecord(residual=float(np.nan_to_num(max(question.violation(load_factor, slip), proof.gap), nan=np.inf)))
        motion = Mechanism(np.sum([part.motion.moves for part in parts], axis=0), task.friction * ~opened, open=opened)
        return ShakedownLimit(load_factor, slip, record, question, motion, LimitKind.FINITE, bound)

    def without_limit() -> ShakedownLimit | None:
        growth = program.chain.growth(solver)
        if growth is None:
            return None
        ahead = program.chain.value_along(growth, x.load_factor)
        question = asked([program.chain.value_along(growth, part) / ahead for part in way])
        still, record = Mechanism(np.zeros((len(sets), *task.r1.shape[1:])), task.friction), SolveRecord(residual=growth.residual)
        return ShakedownLimit(np.inf, np.full(x.slip.shape, np.nan), record, question, still, LimitKind.UNBOUNDED, np.inf)

    limit, record = program.chain.solve(judged, solver, no_optimum=without_limit, above=above)
    return replace(limit, record=replace(record, seconds=perf_counter() - task.started), problem=program.problem, _duals=duals(program.problem))


def _listed(task: Question, x: Unknowns, f: cp.Parameter, way: list[cp.Variable], instants: list[int], number: int) -> Program:
    """The rows of instants with the same nodes open before and after."""
    of, last = f"_{number}" * (number > 0), len(way) + 1
    first, then = task.loads(0), task.loads(1)
    changes = [named(then[f"{part}1[1]"] - first[f"{part}1[0]"], f"d{part}{of}") for part in "qpw"]
    more = {m: [times(way[m - 1], change) for change in changes] for m in instants if 0 < m < last}
    mine = replace(unknowns(task.system.slip_shape, (), x.load_factor, of), slip=x.slip, q=x.q, p=x.p)
    contact = SimpleNamespace(A=task.A, B=task.B, W=task.W, loads=lambda m: then if m == last else first)
    rows = rest(contact, mine, instants, more, of)
    return Program(task, mine, f, instants, rows + stuck(mine, f, instants, task.little))
