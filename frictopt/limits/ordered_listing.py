"""The printed problem of an order of events: the rows of all instants, at unknown places.

The load of an event lies at an unknown place of its leg. If only the scaled loads vary on a leg,
the unknown is the place times the load factor; if only fixed ones vary, it is the place. If both
vary, the load of the event has the product of load factor and place: the problem is linear about
the load factor and the places of the answer, which are parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, TypeAlias

import cvxpy as cp
import numpy as np

from ..base import Array
from ..solve.problem import Problem, printed_as
from . import models
from .filled import fill
from .lift_off import LiftOff, varying
from .models import Row, Unknowns, constant, defines, times, unknowns
from .ordered import LaterSlips, is_scaled
from .solved import Solved

# The friction rows at some instants.
Friction: TypeAlias = Callable[[Unknowns, cp.Parameter, Sequence[int]], list[Row]]


class OrderedProblem:
    """The rows of an order of events over its unknowns, with their values and multipliers.

    `load_factor`: a parameter if the load factor is given. `friction` lists the friction rows.
    """

    def __init__(self, solved: Solved, friction: Friction, load_factor: Any = None) -> None:
        question = solved.question
        assert isinstance(question, LiftOff)
        self._question = question
        self._solved = solved
        self.x = unknowns(question.system.slip_shape, range(len(question.sets)), load_factor)
        self._f = models.friction(question.friction)
        self._friction = friction
        events = [m for m, instant in enumerate(question.at) if instant.event is not None]
        self._way = [cp.Variable(name=f"way[{m}]") for m in events]
        self.values = {
            self.x.slip: solved.values["slip"],
            self.x.load_factor: solved.values["load_factor"],
            **dict(zip(self._way, solved.values["ways"], strict=True)),
        }
        self._slips, slip_rows = self._slips_of_instants()
        touching = {m: sorted(question.at[m].switching) for m in events}
        self._shared = [
            *slip_rows,
            *models.ordered(self._ways_of_legs()),
            *models.events(self.x, touching),
        ]
        self._on_events = self._multipliers_of_events(touching)

        # Instants with the same open nodes and slips have the same A, B and W.
        grouped = dict[tuple[int, cp.Variable], list[int]]()
        for m, of_set in enumerate(question.sets):
            grouped.setdefault((id(of_set), self._slips[m]), []).append(m)
        self._parts = [
            (self._rows_of(instants, number), instants)
            for number, instants in enumerate(grouped.values())
        ]
        self.rows = [row for rows, _ in self._parts for row in rows] + self._shared

    def filled(self, problem: Problem) -> Problem:
        """The problem of these rows, after the values and multipliers of the answer are put in."""
        of_slips = {
            name: np.zeros(slip.shape)
            for name, slip in ((slip.name(), slip) for slip in self._slips)
            if slip is not self.x.slip
        }
        parts = []
        for rows, instants in self._parts:
            moves = np.zeros_like(self._solved.moves)
            moves[instants] = self._solved.moves[instants]
            of_set = self._question.sets[instants[0]]
            parts.append((rows, replace(self._solved, question=of_set, moves=moves)))
            name = self._slips[instants[0]].name()
            if name in of_slips:
                work = of_set.response.T @ moves.sum(axis=0)
                of_slips[name] += work.reshape(of_slips[name].shape, order="F")
        multipliers = {**self._solved.multipliers, **self._on_events, **of_slips}
        whole = replace(self._solved, multipliers=multipliers)
        own = [row for row in problem.constraints if row.label in ("load_factor", "cap")]
        # The slips of the instants follow first, because the rows of the instants contain them.
        fill(problem, [*self._shared, *own], whole, self.values)
        for rows, part in parts:
            fill(problem, rows, part, {})
        return problem

    def _slips_of_instants(self) -> tuple[list[cp.Variable], list[Row]]:
        """The slip variable of each instant, and the rows that tie them.

        All instants share the slip of the first episodes, unless a node is closed in a later one.
        """
        question = self._question
        slip = self.x.slip
        slips = LaterSlips.of(question)
        at = [slip] * len(question.sets)
        rows = list[Row]()
        if not slips.later:
            return at, rows
        later_slips = cp.Variable((len(slips.later), *slip.shape[1:]), name="later_slip")
        later_values = self._solved.values["later_slip"]
        self.values[later_slips] = later_values.reshape(later_slips.shape)
        by_nodes = dict[bytes, cp.Variable]()
        for m in range(len(at)):
            placed = slips.placed(m)
            taken = placed.any(axis=1)
            if not taken.any():
                continue
            key = placed.tobytes()
            if key not in by_nodes:
                kept = constant(np.diag((~taken).astype(float)), f"first[{m}]")
                by_nodes[key] = cp.Variable(slip.shape, name=f"slip_at[{m}]")
                both = kept @ slip + constant(placed, f"later[{m}]") @ later_slips
                rows.append(defines(by_nodes[key], both))
            at[m] = by_nodes[key]
        return at, rows

    def _ways_of_legs(self) -> Iterator[tuple[list[cp.Variable], Any]]:
        """The unknown places of the events of each leg, and the place of its end."""
        on_legs = self._question.order.on_legs
        for leg in dict.fromkeys(on_legs):
            places = [place for place, of in zip(self._way, on_legs, strict=True) if of == leg]
            yield places, self.x.load_factor if is_scaled(self._question, leg) else 1.0

    def _multipliers_of_events(self, touching: Mapping[int, Sequence[int]]) -> dict[str, Array]:
        """Multipliers of the rows without force at events; the arrays have them by component."""
        of_rows = self._solved.multipliers
        axes = self._question.system.tangents
        multipliers = dict[str, Array]()
        for m, nodes in touching.items():
            by_axis = [of_rows[f"event_q{axis}"][m][nodes] for axis in range(axes)]
            multipliers[f"event_q[{m}]"] = np.concatenate(by_axis)
            multipliers[f"event_p[{m}]"] = of_rows["event_p"][m][nodes]
        return multipliers

    def _rows_of(self, instants: list[int], number: int) -> list[Row]:
        """The rows of instants with the same A, B, W.

        The loads of an event are the loads of the first corner of its leg plus the unknown share
        `way` of the change to the last corner.
        """
        question = self._question
        of_set = question.sets[instants[0]]
        suffix = f"_{number}" if number else ""
        corners = dict[int, Mapping[str, Array]]()
        event_loads = dict[int, list[cp.Expression]]()
        for m in instants:
            instant = question.at[m]
            corners[m] = of_set.loads(question.path.stops[instant.leg])
            if instant.event is not None:
                several = len(question.path.legs) > 1
                name = f"{suffix}[{instant.leg}]" if several else suffix
                event_loads[m] = self._change(m, name)
        x = replace(
            unknowns(question.system.slip_shape, (), self.x.load_factor, suffix),
            slip=self._slips[instants[0]],
            q=self.x.q,
            p=self.x.p,
        )
        contact = SimpleNamespace(A=of_set.A, B=of_set.B, W=of_set.W, loads=lambda m: corners[m])
        rows = models.rest(contact, x, instants, event_loads)
        return rows + self._friction(x, self._f, instants)

    def _change(self, m: int, name: str) -> list[cp.Expression]:
        """Changes of q, p and gaps from the first corner of a leg to an event."""
        question = self._question
        instant = question.at[m]
        assert instant.event is not None
        place = self._way[instant.event]
        first, last = (question.sets[m].loads(end) for end in question.path.legs[instant.leg])
        fixed_varies, scaled_varies = varying(question, instant.leg)
        product = None
        if fixed_varies and scaled_varies:
            product = self._product(place, float(self.values[place]))
        terms = []
        for part in "qpw":
            at_zero, scaled = (_change_of(first, last, part + kind) for kind in "01")
            if product is not None:
                fixed = times(place, constant(at_zero, f"d{part}0{name}"))
                terms.append(fixed + times(product, constant(scaled, f"d{part}1{name}")))
            else:
                change = at_zero if fixed_varies else scaled
                terms.append(times(place, constant(change, f"d{part}{name}")))
        return terms

    def _product(self, place: cp.Variable, value: float) -> cp.Expression:
        """The product of the load factor and a place, linear about the answer."""
        load_factor = self.x.load_factor
        expression = load_factor * place
        if not isinstance(load_factor, cp.Parameter):
            about = float(self.values[load_factor])
            values = {
                "load_factor": about,
                place.name(): value,
                f"load_factor_{place.name()}": about * value,
            }
            at = [cp.Parameter(name=f"at_{of}", value=number) for of, number in values.items()]
            expression = at[0] * place + at[1] * load_factor - at[2]
        return printed_as(expression, f"load_factor {place.name()}")


def _change_of(first: Mapping[str, Array], last: Mapping[str, Array], kind: str) -> Array:
    """Change of the loads `q0`, `p0`, `w0`, `q1`, `p1` or `w1` from corner to corner."""
    of_first, of_last = (
        next(value for name, value in loads.items() if name.startswith(kind))
        for loads in (first, last)
    )
    return of_last - of_first


def ordered(solved: Solved) -> cp.Problem:
    """The largest load factor of an order of events."""
    order = OrderedProblem(solved, models.stuck)
    return order.filled(models.shakedown(order.x, order.rows))


def ordered_safe_slip(solved: Solved) -> cp.Problem:
    """The slip with the largest margin at a load factor, in an order of events."""
    question = solved.question
    margin = cp.Variable(name="margin")
    value = solved.values["load_factor"]
    load_factor = cp.Parameter(nonneg=True, name="load_factor", value=value)
    spare: dict[int, cp.Expression] = {}
    press: dict[int, cp.Expression] = {}
    for m, sticks in enumerate(question.statuses[0]):
        spare[m] = times(margin, constant(question.mean_bound * sticks, f"mean_bound[{m}]"))
        press[m] = times(margin, constant(question.mean_pressure * sticks, f"mean_pressure[{m}]"))
    apart = times(margin, constant(question.clearance, "clearance"))
    friction = partial(models.inside, spare=spare, press=press, apart=apart)
    order = OrderedProblem(solved, friction, load_factor)
    order.values[margin] = solved.values["margin"]
    return order.filled(models.safe_slip(margin, order.rows))
