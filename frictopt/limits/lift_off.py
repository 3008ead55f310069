"""Nodes that open and close in each cycle: the limit of a given order of openings and closings.

The load goes to and fro between two corners. At event m the load is at an unknown place between the
corners. The limit of a given order is a linear program, in space a cone program (theory, "Nodes
that open and close in each cycle"). Instants are the corners and the events. At each instant, A, B
and the loads belong to the nodes that are closed before or after it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import accumulate, pairwise
from types import SimpleNamespace
from typing import Any, ClassVar, NamedTuple

import cvxpy as cp
import numpy as np

from ..base import Array, Booleans, kept, number_of
from ..contact import LoadCycle
from .answered import Mechanism
from .models import Row, constant, events, ordered, rest, stuck, times, unknowns
from .programs import Program
from .question import Question

Nodes = frozenset[int]


def among(nodes: Nodes, count: int) -> Booleans:
    """(count,) mask of some nodes."""
    return np.isin(np.arange(count), sorted(nodes))


@kept
class Order(NamedTuple):
    """The nodes that are open at the first corner, and the nodes that switch at each event.

    A node switches if it opens or closes. Events are listed in their order from the first to the
    last corner.
    """

    start: Nodes
    events: tuple[Nodes, ...] = ()

    @property
    def between(self) -> list[Nodes]:
        """Open nodes of each interval between instants, from the first to the last corner."""
        return list(accumulate(self.events, frozenset.symmetric_difference, initial=self.start))

    @property
    def through(self) -> list[Nodes]:
        """Nodes that are open before and after each instant."""
        sets = self.between
        return [sets[0], *(before & after for before, after in pairwise(sets)), sets[-1]]


@kept
@dataclass(frozen=True, eq=False, kw_only=True)
class LiftOff(Question):
    """A question with nodes that open and close in each cycle.

    `open_nodes` are open during the whole cycle. `way` (M,) is the place of each instant, from 0 at
    the first corner to 1 at the last. `sets` has a question for each instant, with the nodes open
    that are open before and after it.
    """

    order: Order
    way: Array
    sets: tuple[Question, ...]

    KEPT_FIELDS: ClassVar[tuple[str, ...]] = (*Question.KEPT_FIELDS, "order", "way", "sets")

    @classmethod
    def from_kept(cls, fields_in_file: Mapping[str, Any]) -> "LiftOff":
        """See `Question.from_kept`."""
        of_question = {name: fields_in_file[name] for name in Question.KEPT_FIELDS}
        own_fields = {name: fields_in_file[name] for name in ("order", "way", "sets")}
        return cls(**fields_of(Question.from_kept(of_question)), **own_fields)

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the corners and events; see `Question.instants`."""
        at_corners = {}
        for question in dict.fromkeys(self.sets):
            at_corners[question] = question.states(load_factor, slip)
        motions = list[Array]()
        reactions = list[Array]()
        for question, place in zip(self.sets, self.way, strict=True):
            u, r = at_corners[question]
            motions.append((1 - place) * u[0] + place * u[-1])
            reactions.append((1 - place) * r[0] + place * r[-1])
        return np.array(motions), np.array(reactions)

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the corners."""
        u_first, r_first = self.sets[0].states(load_factor, slip)
        u_last, r_last = self.sets[-1].states(load_factor, slip)
        return np.stack([u_first[0], u_last[-1]]), np.stack([r_first[0], r_last[-1]])

    def at_instants(self, load_factor: float) -> Array:
        """See `Question.at_instants`."""
        first, last = super().at_instants(load_factor)
        way = self.way[:, None]
        return np.asarray((1 - way) * first + way * last)

    def by_corner(self, moves: Array) -> Array:
        """Motions at the corners. The motion at an event is divided according to its place."""
        return np.tensordot([1 - self.way, self.way], moves, 1)

    @property
    def statuses(self) -> tuple[Booleans, Booleans]:
        """See `Question.statuses`."""
        opened = np.array([question.open_nodes for question in self.sets])
        switching = [Nodes(), *self.order.events, Nodes()]
        touching = np.array([among(nodes, len(self.open_nodes)) for nodes in switching])
        return ~(opened | touching), opened

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Loads of the cycle at the corners and events, at load factor 1."""
        first, last = self.cycle.corners
        blends = []
        for place in self.way.tolist():
            blends.append(
                {
                    case: (1 - place) * first.get(case, 0.0) + place * last.get(case, 0.0)
                    for case in dict.fromkeys([*first, *last])
                }
            )
        return LoadCycle(self.cycle.mean, blends).corner_names

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """See `Question.events`."""
        rows = []
        places = self.way[1:-1].tolist()
        before = self.order.between
        for m, nodes in enumerate(self.order.events):
            for node in sorted(nodes):
                event = "closes" if node in before[m] else "opens"
                rows.append((node, event, places[m], self.names[m + 1]))
        return rows

    @property
    def open_share(self) -> Array:
        """See `Question.open_share`."""
        opened = [among(nodes, len(self.open_nodes)) for nodes in self.order.between]
        return np.asarray(np.diff(self.way) @ opened)

    @property
    def pattern(self) -> str:
        """See `Question.pattern`."""
        count = len(frozenset().union(*self.order.events))
        opened = ", these nodes open" if self.open_nodes.any() else ""
        moving = number_of(count, "node that opens and closes", "nodes that open and close")
        return f" with {moving} in this order{opened} and the others closed"

    def violation(self, load_factor: float, slip: Array) -> float:
        """Distance of a slip from being safe, see `Question.violation`.

        It includes forces on a node at the event at which it opens or closes, and events in a wrong
        order.
        """
        _, r = self.instants(load_factor, slip)
        touching = [
            np.abs(r[m][:, sorted(nodes)]).max() / self.force
            for m, nodes in enumerate(self.order.events, start=1)
        ]
        worst = np.max([super().violation(load_factor, slip), *touching, -np.diff(self.way).min()])
        return float(np.nan_to_num(worst, nan=np.inf))


def fields_of(question: Question) -> dict[str, Any]:
    """Name -> value of the fields of a question."""
    return {part.name: getattr(question, part.name) for part in fields(question)}


def with_order(
    question: Question, order: Order, of_set: Callable[[Nodes], Question | None]
) -> LiftOff | None:
    """The question with an order of events, at preliminary places.

    `of_set` returns the question with some nodes open at all corners. The result is None if the
    closed nodes do not hold the open ones.
    """
    sets = list[Question]()
    for nodes in order.through:
        opened = of_set(nodes)
        if opened is None:
            return None
        sets.append(opened)
    always = of_set(frozenset.intersection(*order.through))
    if always is None:
        return None
    return LiftOff(
        **fields_of(always), order=order, way=np.linspace(0.0, 1.0, len(sets)), sets=tuple(sets)
    )


class Ordered(Program):
    """The program of an order of events at unknown places. `unit` is the unit of its goal.

    `friction` lists the friction rows, as `models.stuck` does. `load_factor`: a parameter if the
    load factor is given.
    """

    def __init__(
        self,
        lift_off: LiftOff,
        goal: Callable[[Program], cp.Problem],
        unit: float,
        friction: Callable[..., list[Row]] = stuck,
        load_factor: Any = None,
    ) -> None:
        instants = range(len(lift_off.sets))
        self._lift_off = lift_off
        self.user_rows = {}
        self.x = unknowns(lift_off.system.slip_shape, instants, load_factor)
        self.corners = list(instants)
        self.f = cp.Parameter(lift_off.system.nodes, nonneg=True, name="f", value=lift_off.friction)
        self.way = [cp.Variable(name=f"way[{m}]") for m in self.corners[1:-1]]
        self._parts = list[Program]()
        for number, question in enumerate(dict.fromkeys(lift_off.sets)):
            at_instants = [m for m in instants if lift_off.sets[m] is question]
            self._parts.append(self._part(question, at_instants, number, friction))

        touching = {m: sorted(nodes) for m, nodes in enumerate(lift_off.order.events, start=1)}
        self.rows = [row for part in self._parts for row in part.rows]
        self.rows += events(self.x, touching)
        self.rows += ordered(self.x.load_factor, self.way)
        units = dict[cp.Variable, Any]()
        for part in self._parts:
            units |= part.units
        units |= dict.fromkeys(self.way, lift_off.load_unit)
        self.chain = self._parts[0].compiled(goal(self), unit, units, self._parts[1:]).chain

    def _part(
        self,
        question: Question,
        instants: list[int],
        number: int,
        friction: Callable[..., list[Row]],
    ) -> Program:
        """The rows of the instants with the same open nodes, and so with the same A, B and W.

        The loads of an event are the loads of the first corner plus the unknown share `way` of the
        change to the last corner.
        """
        suffix = f"_{number}" if number else ""
        last = self.corners[-1]
        loads_first = question.loads(0)
        loads_last = question.loads(1)
        changes = []
        for part in "qpw":
            change = loads_last[f"{part}1[1]"] - loads_first[f"{part}1[0]"]
            changes.append(constant(change, f"d{part}{suffix}"))
        event_loads = {}
        for m in instants:
            if 0 < m < last:
                event_loads[m] = [times(self.way[m - 1], change) for change in changes]
        x = replace(
            unknowns(question.system.slip_shape, (), self.x.load_factor, suffix),
            slip=self.x.slip,
            q=self.x.q,
            p=self.x.p,
        )
        contact = SimpleNamespace(
            A=question.A,
            B=question.B,
            W=question.W,
            loads=lambda m: loads_last if m == last else loads_first,
        )
        rows = rest(contact, x, instants, event_loads)
        return Program(question, x, self.f, instants, rows + friction(x, self.f, instants))

    @property
    def question(self) -> LiftOff:  # type: ignore[override]  # it follows from the solution
        """The question, with the events at their places in the solution."""
        places = [float(place.value) for place in self.way]
        return self.placed(places, float(self.x.load_factor.value))

    def placed(self, places: list[float], load_factor: float) -> LiftOff:
        """The question with its events at these places, which are given times the load factor."""
        shares = [place / load_factor if load_factor > 0 else 0.0 for place in places]
        return replace(self._lift_off, way=np.array([0.0, *shares, 1.0]))

    @property
    def slip(self) -> Array:
        """See `Program.slip`."""
        return self._lift_off.slip_at_mean_load(np.array(self.x.slip.value))

    @property
    def motion(self) -> Mechanism:
        """See `Program.motion`."""
        opened = np.array([question.open_nodes for question in self._lift_off.sets])
        moves = np.sum([part.motion.moves for part in self._parts], axis=0)
        return Mechanism(moves, self._lift_off.friction * ~opened, open=opened)
