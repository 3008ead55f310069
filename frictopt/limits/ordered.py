"""The program of an order of events: the largest load factor, or another goal, at unknown places.

The load of an event lies at an unknown place of its leg. If only the scaled loads vary on a leg,
the unknown is the place times the load factor; if only fixed ones vary, it is the place.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from ..base import Array
from .answered import Mechanism
from .lift_off import LiftOff, episodes, varying, way_of
from .models import (
    Row,
    constant,
    defines,
    events,
    ordered,
    printed_as,
    rest,
    stuck,
    times,
    unknowns,
)
from .programs import Program
from .question import Question


class Ordered(Program):
    """The program of an order of events at unknown places. `unit` is the unit of its goal.

    `friction` lists the friction rows, as `models.stuck` does. `load_factor`: a parameter if the
    load factor is given.

    If fixed and scaled loads both vary on a leg that has an event, the load of the event has the
    product of load factor and place. The program is then linear about a load factor and the places
    that `turn` sets.
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
        system = lift_off.system
        self._lift_off = lift_off
        self.user_rows = {}
        self.x = unknowns(system.slip_shape, instants, load_factor)
        self.corners = list(instants)
        self.f = cp.Parameter(system.nodes, nonneg=True, name="f", value=lift_off.friction)
        self.way = []
        self._products = dict[int, _Product]()
        for m, instant in enumerate(lift_off.at):
            if instant.event is not None:
                place = cp.Variable(name=f"way[{m}]")
                self.way.append(place)
                if all(varying(lift_off, instant.leg)):
                    self._products[instant.event] = _Product.of(self.x.load_factor, place)

        slips = _Slips(lift_off, self.x.slip)
        self._slips = slips.at
        self._parts = list[Program]()
        grouped = dict[tuple[int, cp.Variable], list[int]]()
        for m in instants:
            grouped.setdefault((id(lift_off.sets[m]), slips.at[m]), []).append(m)
        for number, at_instants in enumerate(grouped.values()):
            slip = slips.at[at_instants[0]]
            question = lift_off.sets[at_instants[0]]
            self._parts.append(self._part(question, slip, at_instants, number, friction))

        touching = {
            m: sorted(instant.switching)
            for m, instant in enumerate(lift_off.at)
            if instant.event is not None
        }
        self.rows = [row for part in self._parts for row in part.rows]
        self.rows += slips.rows
        self.rows += events(self.x, touching)
        self.rows += ordered(self._ways_of_legs())
        units = dict[cp.Variable, Any]()
        for part in self._parts:
            units |= part.units
        units |= {place: self._unit_of_place(event) for event, place in enumerate(self.way)}
        self.chain = self._parts[0].compiled(goal(self), unit, units, self._parts[1:]).chain

    def _is_scaled(self, leg: int) -> bool:
        """Whether the unknown place of an event is its share of the leg times the load factor."""
        fixed_varies, _ = varying(self._lift_off, leg)
        return not fixed_varies

    def _unit_of_place(self, event: int) -> float:
        scaled = self._is_scaled(self._lift_off.order.on_legs[event])
        return self._lift_off.load_unit if scaled else 1.0

    def _ways_of_legs(self) -> Iterator[tuple[list[cp.Variable], Any]]:
        """The unknown places of the events of each leg, and the place of its end."""
        on_legs = self._lift_off.order.on_legs
        for leg in dict.fromkeys(on_legs):
            places = [place for place, of in zip(self.way, on_legs, strict=True) if of == leg]
            yield places, self.x.load_factor if self._is_scaled(leg) else 1.0

    def _part(
        self,
        question: Question,
        slip: cp.Variable,
        instants: list[int],
        number: int,
        friction: Callable[..., list[Row]],
    ) -> Program:
        """The rows of the instants with the same open nodes and slips, so with the same A, B, W.

        The loads of an event are the loads of the first corner of its leg plus the unknown share
        `way` of the change to the last corner.
        """
        suffix = f"_{number}" if number else ""
        lift_off = self._lift_off
        legs = lift_off.path.legs
        corners = dict[int, dict[str, Array]]()
        event_loads = dict[int, list[cp.Expression]]()
        for m in instants:
            instant = lift_off.at[m]
            corners[m] = question.loads(lift_off.path.stops[instant.leg])
            if instant.event is not None:
                first, last = legs[instant.leg]
                name = f"{suffix}[{instant.leg}]" if len(legs) > 1 else suffix
                event_loads[m] = self._change(question, first, last, instant.event, name)
        x = replace(
            unknowns(question.system.slip_shape, (), self.x.load_factor, suffix),
            slip=slip,
            q=self.x.q,
            p=self.x.p,
        )
        contact = SimpleNamespace(
            A=question.A, B=question.B, W=question.W, loads=lambda m: corners[m]
        )
        rows = rest(contact, x, instants, event_loads)
        return Program(question, x, self.f, instants, rows + friction(x, self.f, instants))

    def _change(
        self, question: Question, first: int, last: int, event: int, name: str
    ) -> list[cp.Expression]:
        """Changes of q, p and gaps from the corner `first` to an event."""
        leg = self._lift_off.order.on_legs[event]
        fixed_varies, scaled_varies = varying(self._lift_off, leg)
        both = fixed_varies and scaled_varies
        loads = question.loads(first), question.loads(last)
        terms = []
        for part in "qpw":
            at_zero, scaled = (_changes(*loads, part, kind) for kind in "01")
            if both:
                fixed = times(self.way[event], constant(at_zero, f"d{part}0{name}"))
                more = times(self._products[event].expression, constant(scaled, f"d{part}1{name}"))
                terms.append(fixed + more)
            else:
                change = at_zero if fixed_varies else scaled
                terms.append(times(self.way[event], constant(change, f"d{part}{name}")))
        return terms

    def turn(self, load_factor: float, places: Sequence[float]) -> None:
        """Make the program linear about a load factor and the places of the events."""
        for event, product in self._products.items():
            product.turn(load_factor, places[event])

    @property
    def places(self) -> list[float]:
        """The places of the events in the solution."""
        return [float(place.value) for place in self.way]

    @property
    def question(self) -> LiftOff:  # type: ignore[override]  # it follows from the solution
        """The question, with the events and the slips of its episodes as in the solution."""
        slips = np.array([slip.value for slip in self._slips])
        question = self.placed(self.places, float(self.x.load_factor.value))
        return replace(question, shifts=slips - np.array(self.x.slip.value))

    def placed(self, places: Sequence[float], load_factor: float) -> LiftOff:
        """The question with its events at these places.

        On a leg on which the load factor scales the loads, a place is given times the load factor.
        """
        order = self._lift_off.order
        shares = []
        for leg, place in zip(order.on_legs, places, strict=True):
            if self._is_scaled(leg):
                place = place / load_factor if load_factor > 0 else 0.0
            shares.append(place)
        return replace(self._lift_off, way=way_of(order, self._lift_off.at, shares))

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


def _changes(first: Mapping[str, Array], last: Mapping[str, Array], part: str, kind: str) -> Array:
    """Change of the loads `q0`, `p0`, `w0` (kind "0") or `q1`, `p1`, `w1` from corner to corner."""
    of_first, of_last = (
        next(value for name, value in loads.items() if name.startswith(part + kind))
        for loads in (first, last)
    )
    return of_last - of_first


class _Product(NamedTuple):
    """The product of the load factor and the place of an event, linear about given values."""

    expression: cp.Expression
    at_load_factor: cp.Parameter
    at_place: cp.Parameter
    at_product: cp.Parameter

    @classmethod
    def of(cls, load_factor: Any, place: cp.Variable) -> "_Product":
        """The product, which is linear if the load factor is a parameter."""
        about = [
            cp.Parameter(name=f"at_{name}", value=0.0)
            for name in ("load_factor", place.name(), f"load_factor_{place.name()}")
        ]
        expression = load_factor * place
        if not isinstance(load_factor, cp.Parameter):
            expression = about[0] * place + about[1] * load_factor - about[2]
        return cls(printed_as(expression, f"load_factor {place.name()}"), *about)

    def turn(self, load_factor: float, place: float) -> None:
        """Make the product linear about these values."""
        self.at_load_factor.value = load_factor
        self.at_place.value = place
        self.at_product.value = load_factor * place


class _Slips:
    """The slip variable of each instant, `at`, and the rows that tie them.

    All instants share the slip of the first episodes, unless a node is closed in a later one.
    """

    def __init__(self, lift_off: LiftOff, slip: cp.Variable) -> None:
        numbers = episodes(lift_off.at, lift_off.system.nodes, lift_off.path.closed)
        keys = [(int(node), int(row[node])) for row in numbers for node in np.flatnonzero(row > 0)]
        later = {key: place for place, key in enumerate(dict.fromkeys(keys))}
        self.at = [slip] * len(numbers)
        self.rows = list[Row]()
        if not later:
            return
        later_slips = cp.Variable((len(later), *slip.shape[1:]), name="later_slip")
        by_nodes = dict[bytes, cp.Variable]()
        for m, row in enumerate(numbers):
            nodes = np.flatnonzero(row > 0)
            key = np.where(row > 0, row, 0).tobytes()
            if not len(nodes):
                continue
            if key not in by_nodes:
                chosen = np.zeros((len(row), len(later)))
                chosen[nodes, [later[int(node), int(row[node])] for node in nodes]] = 1.0
                kept = constant(np.diag((row <= 0).astype(float)), f"first[{m}]")
                placed = constant(chosen, f"later[{m}]")
                by_nodes[key] = cp.Variable(slip.shape, name=f"slip_at[{m}]")
                slips = kept @ slip + placed @ later_slips
                self.rows.append(defines(by_nodes[key], slips))
            self.at[m] = by_nodes[key]
