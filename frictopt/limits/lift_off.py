"""Nodes that open and close in each cycle, where the load goes to and fro between two corners: the limit of a given order of openings and closings.

At event m the load is at an unknown part of the way between the corners, so the order is a linear
program, in space a cone program (theory, "Nodes that open and close in each cycle"). Each instant
(corner or event) has A, B and loads of the nodes that are closed before or after it.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import accumulate, pairwise
from types import SimpleNamespace
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from ..base import Array, Booleans, kept
from ..contact import LoadCycle
from .answered import Mechanism
from .models import Row, constant, events, ordered, rest, stuck, times, unknowns
from .programs import Program
from .question import Question

Nodes = frozenset[int]


def among(nodes: Nodes, count: int) -> Booleans:
    """Which of all nodes these are."""
    return np.isin(np.arange(count), sorted(nodes))


@kept
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


@kept
@dataclass(frozen=True, eq=False, kw_only=True)
class LiftOff(Question):
    """A question with nodes that open and close in each cycle; `open` are those that are open all through it.

    `way` (M,) is the part of the way from the first corner to the last at each instant; `sets` have
    the nodes open that are open at each instant.
    """

    order: Order
    way: Array
    sets: tuple[Question, ...]

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Slips and gaps, and reactions, at the corners and events; see `Question.instants`."""
        found = {each: each.states(load_factor, slip) for each in dict.fromkeys(self.sets)}
        blends = [
            [(1 - s) * part[0] + s * part[-1] for part in found[each]]
            for each, s in zip(self.sets, self.way, strict=True)
        ]
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

    @property
    def statuses(self) -> tuple[Booleans, Booleans]:
        """See `Question.statuses`."""
        opened = np.array([each.open_nodes for each in self.sets])
        touching = np.array(
            [among(nodes, len(self.open_nodes)) for nodes in [Nodes(), *self.order.events, Nodes()]]
        )
        return ~(opened | touching), opened

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Loads of the cycle at the corners and events, at load factor 1."""
        first, last = self.cycle.corners
        cases = dict.fromkeys([*first, *last])
        blends = [
            {case: (1 - s) * first.get(case, 0.0) + s * last.get(case, 0.0) for case in cases}
            for s in self.way.tolist()
        ]
        return LoadCycle(self.cycle.mean, blends).corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """See `Question.events`."""
        found = zip(
            self.order.events,
            self.order.between,
            self.way[1:-1].tolist(),
            self.names[1:-1],
            strict=False,
        )
        return [
            (i, "closes" if i in opened else "opens", way, name)
            for nodes, opened, way, name in found
            for i in sorted(nodes)
        ]

    @property
    def open_share(self) -> Array:
        """See `Question.open_share`."""
        opened = [among(nodes, len(self.open_nodes)) for nodes in self.order.between]
        return np.asarray(np.diff(self.way) @ opened)

    @property
    def pattern(self) -> str:
        """See `Question.pattern`."""
        count, opened = (
            len(frozenset().union(*self.order.events)),
            ", these nodes open" * bool(self.open_nodes.any()),
        )
        return (
            f" with {count} nodes that open and close in this order{opened} and the others closed"
        )

    def violation(self, load_factor: float, slip: Array) -> float:
        """Largest violation of the contact law at the corners and events, by what a node carries where it opens or closes, and by their order."""
        r = self.instants(load_factor, slip)[1]
        touching = [
            np.abs(r[m][:, sorted(nodes)]).max() / self.force
            for m, nodes in enumerate(self.order.events, start=1)
        ]
        off = np.max([super().violation(load_factor, slip), *touching, -np.diff(self.way).min()])
        return float(np.nan_to_num(off, nan=np.inf))


def with_order(
    question: Question, order: Order, of_set: Callable[[Nodes], Question | None]
) -> LiftOff | None:
    """The question with an order of events, not yet on their places; `of_set` gives it with some nodes open. None if the others do not hold them."""
    sets = [each for nodes in order.through if (each := of_set(nodes))]
    always = of_set(frozenset.intersection(*order.through))
    if always is None or len(sets) < len(order.through):
        return None
    known = {each.name: getattr(always, each.name) for each in fields(always)}
    return LiftOff(**known, order=order, way=np.linspace(0.0, 1.0, len(sets)), sets=tuple(sets))


class Ordered(Program):
    """The listing of an order of events at unknown places, with a goal of this `unit`; `friction` as `models.stuck`; a load factor may be given."""

    def __init__(
        self,
        asked: LiftOff,
        goal: Callable[[Program], cp.Problem],
        unit: float,
        friction: Callable[..., list[Row]] = stuck,
        load_factor: Any = None,
    ) -> None:
        sets, self._asked, self.own = asked.sets, asked, {}
        self.x, self.corners = (
            unknowns(asked.system.slip_shape, range(len(sets)), load_factor),
            list(range(len(sets))),
        )
        self.f = cp.Parameter(asked.system.nodes, nonneg=True, name="f", value=asked.friction)
        self.way = [cp.Variable(name=f"way[{m}]") for m in self.corners[1:-1]]
        of_sets = [
            (each, [m for m, one in enumerate(sets) if one is each]) for each in dict.fromkeys(sets)
        ]
        self._parts = [
            self._part(each, instants, number, friction)
            for number, (each, instants) in enumerate(of_sets)
        ]
        touching = {m: sorted(nodes) for m, nodes in enumerate(asked.order.events, start=1)}
        self.rows = [row for part in self._parts for row in part.rows]
        self.rows += events(self.x, touching) + ordered(self.x.load_factor, self.way)
        units = {
            variable: size for part in self._parts for variable, size in part.units.items()
        } | dict.fromkeys(self.way, asked.load_unit)
        self.chain = self._parts[0].compiled(goal(self), unit, units, self._parts[1:]).chain

    def _part(
        self,
        question: Question,
        instants: list[int],
        number: int,
        friction: Callable[..., list[Row]],
    ) -> Program:
        """The rows of instants with the same nodes open before and after."""
        of, last, x = f"_{number}" * (number > 0), len(self.corners) - 1, self.x
        first, then = question.loads(0), question.loads(1)
        changes = [
            constant(then[f"{part}1[1]"] - first[f"{part}1[0]"], f"d{part}{of}") for part in "qpw"
        ]
        more = {
            m: [times(self.way[m - 1], change) for change in changes]
            for m in instants
            if 0 < m < last
        }
        mine = replace(
            unknowns(question.system.slip_shape, (), x.load_factor, of), slip=x.slip, q=x.q, p=x.p
        )
        contact = SimpleNamespace(
            A=question.A, B=question.B, W=question.W, loads=lambda m: then if m == last else first
        )
        rows = rest(contact, mine, instants, more)
        return Program(question, mine, self.f, instants, rows + friction(mine, self.f, instants))

    @property
    def question(self) -> LiftOff:  # type: ignore[override]  # it follows from the solution
        """The question, with the events where they are in the solution."""
        return self.placed(
            [float(part.value) for part in self.way], float(self.x.load_factor.value)
        )

    def placed(self, way: list[float], load_factor: float) -> LiftOff:
        """The question with its events at these parts of the load factor."""
        return replace(
            self._asked,
            way=np.array(
                [0.0, *(part / load_factor if load_factor > 0 else 0.0 for part in way), 1.0]
            ),
        )

    @property
    def slip(self) -> Array:
        """See `Program.slip`."""
        return self._asked.slip_at_mean_load(np.array(self.x.slip.value))

    @property
    def motion(self) -> Mechanism:
        """See `Program.motion`."""
        opened = np.array([each.open_nodes for each in self._asked.sets])
        return Mechanism(
            np.sum([part.motion.moves for part in self._parts], axis=0),
            self._asked.friction * ~opened,
            open=opened,
        )
