"""The program of an order of events as arrays: load factor and places of the events are unknown.

Each event lies at an unknown place of its segment. If only the scaled loads vary there, the
unknown of the program is the place times the load factor; if only fixed loads vary, it is the
place. If both vary, the load of the event contains the product of load factor and place. The
program is then linearised about given values of both, see `About`.

`printed/listing.py` lists the program.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base import Array, Integers
from ..program.assembled import law_rows
from ..program.question import Question
from ..program.rest_program import RestProgram
from ..program.solution import Mechanism, Solution, Solved
from .lift_off import LiftOff, varying, way_of


@dataclass(frozen=True)
class About:
    """The load factor and the places of all events about which their products are linearised."""

    load_factor: float
    places: Sequence[float]


@dataclass(frozen=True, eq=False)
class Forces:
    """The forces at the instants of an order, as functions of the unknowns of its program.

    Attributes
    ----------
    start
        (m, M) forces without slip, with all unknowns zero.
    effects
        Name of an unknown -> forces due to its units at each instant, (m, M) or (m, M, k).
    responses, response_of
        Forces due to unit slips, (M, t N) each; and (m,) the index of the response at each instant.
    """

    start: Array
    effects: Mapping[str, Array]
    responses: Sequence[Array]
    response_of: Integers


def forces_of_order(question: LiftOff, load_factor: float | None, about: About | None) -> Forces:
    """The forces at all instants, for events that move along their segments; see `About`."""
    axes = question.system.tangents
    count, entries = len(question.sets), len(question.system.S)
    start = np.zeros((count, entries))
    rate = np.zeros((count, entries))
    effects: dict[str, Array] = {}
    later = np.zeros((count, entries, axes * len(question.later)))
    responses = list[Array]()
    keys = dict[tuple[int, bytes], int]()
    response_of = np.zeros(count, dtype=int)
    for m, (instant, of_set) in enumerate(zip(question.at, question.sets, strict=True)):
        corner = question.path.stops[instant.segment]
        start[m] = of_set.start[corner]
        rate[m] = of_set.rate[corner]
        # Instants with the same open nodes and episodes share one response.
        first_episode = question.episodes[m] <= 0
        key = id(of_set), first_episode.tobytes()
        if key not in keys:
            keys[key] = len(responses)
            responses.append(of_set.response * np.tile(first_episode, axes))
        response_of[m] = keys[key]
        later[m] = of_set.response @ np.kron(np.eye(axes), question.placed(m))
        if instant.event is not None:
            change, taken, added = _moved_by_event(question, m, instant.event, load_factor, about)
            start[m] -= taken
            rate[m] += added
            effect = effects.setdefault(f"way{instant.event}", np.zeros((count, entries)))
            effect[m] = change
    if load_factor is None:
        effects["load_factor"] = rate
    else:
        start = start + load_factor * rate
    if question.later:
        effects["later_slip"] = later
    return Forces(start, effects, responses, response_of)


def _moved_by_event(
    question: LiftOff, m: int, event: int, load_factor: float | None, about: About | None
) -> tuple[Array, Array, Array]:
    """The change (M,) of the forces as an event moves along its segment, and two corrections.

    The corrections are zero unless the forces contain the product of the load factor and the place
    of the event, because fixed and scaled loads both vary. The product is then linearised about
    given values of both: a constant is taken off the forces, and a rate with the load factor is
    added.
    """
    at_zero, scaled = _changes(question, m)
    fixed_varies, scaled_varies = varying(question, question.at[m].segment)
    if not (fixed_varies and scaled_varies):
        nothing = np.zeros_like(scaled)
        return at_zero if fixed_varies else scaled, nothing, nothing
    at = (load_factor if about is None else about.load_factor) or 0.0
    # With a given load factor the forces are linear in the place, and need no correction.
    place = 0.0 if about is None or load_factor is not None else about.places[event]
    rate = place * scaled
    return at_zero + at * scaled, at * rate, rate


def ordered_program(
    question: LiftOff,
    load_factor: float | None = None,
    about: About | None = None,
) -> RestProgram:
    """The program of an order. Its goal with a given `load_factor` is the largest `margin`."""
    system = question.system
    axes = system.tangents
    units: dict[str, Any] = {"margin": 1.0}
    if load_factor is None:
        units = {"load_factor": question.load_unit}
    for event, segment in enumerate(question.order.on_segments):
        units[f"way{event}"] = question.load_unit if is_scaled(question, segment) else 1.0
    if question.later:
        nodes = [node for node, _ in question.later]
        slip_unit = question.shear_unit / system.own_stiffness[: system.nodes]
        units["later_slip"] = np.tile(slip_unit[nodes], axes)

    forces = forces_of_order(question, load_factor, about)
    program = RestProgram(
        [question],
        units,
        forces.start,
        forces.effects,
        responses=(forces.responses, forces.response_of),
    )
    if load_factor is None:
        program.row("load_factor", {"load_factor": 1.0})
    else:
        program.row("cap", {"margin": -1.0}, 1.0)
    sticks, opened = question.statuses
    reserve = None if load_factor is None else sticks | opened
    law_rows(program, question, ~opened, opened, reserve=reserve)
    _touch_without_force(program, question)
    _follow_each_other(program, question, load_factor)
    return program


def is_scaled(question: LiftOff, segment: int) -> bool:
    """Whether the unknown place of an event is its share of the segment times the load factor."""
    fixed_varies, _ = varying(question, segment)
    return not fixed_varies


def _changes(question: LiftOff, m: int) -> tuple[Array, Array]:
    """Changes of the forces from the first to the last corner of the segment of an event."""
    first, last = question.path.segments[question.at[m].segment]
    of_set = question.sets[m]
    return of_set.start[last] - of_set.start[first], of_set.rate[last] - of_set.rate[first]


def _touch_without_force(program: RestProgram, question: LiftOff) -> None:
    """Add the rows by which nodes have no force at the event at which they open or close."""
    before, after = question.opened
    at, nodes = np.nonzero(before ^ after)
    for axis in range(question.system.tangents + 1):
        label = "event_p" if axis == question.system.tangents else f"event_q{axis}"
        program.no_force(label, axis, at, nodes, question.node_unit)


def _follow_each_other(program: RestProgram, question: LiftOff, load_factor: float | None) -> None:
    """Add the rows by which events of a segment follow each other, from 0 to its end."""
    on_segments = question.order.on_segments
    number = 0
    for segment in dict.fromkeys(on_segments):
        events = [f"way{event}" for event, of in enumerate(on_segments) if of == segment]
        # Places go from 0 to the load factor if no fixed part varies on the segment, else to 1.
        end: dict[str, float] = {}
        last = 1.0
        if is_scaled(question, segment):
            last = load_factor or 0.0
            end = {"load_factor": 1.0} if load_factor is None else {}
        earlier: dict[str, float] = {}
        for event in events:
            program.row(f"way[{number}]", {event: 1.0, **earlier})
            earlier = {event: -1.0}
            number += 1
        program.row(f"way[{number}]", {**end, **earlier}, last)
        number += 1


def read_solution(
    question: Question, solution: Solution, load_factor: float | None = None
) -> tuple[Question, Array, Mechanism]:
    """The question with its events placed, the slip of all nodes, and the mechanism.

    If nodes open and close, the slip is the slip of their first episodes. `load_factor`: the given
    load factor; None if the solution contains it.
    """
    if not isinstance(question, LiftOff):
        return question, solution.slip_of_nodes, solution.motion
    system = question.system
    places = _places(question, solution)
    if load_factor is None:
        load_factor = solution.load_factor
    first = solution.closed_slip()
    shifts = np.zeros((len(question.sets), *system.slip_shape))
    if question.later:
        later = solution.values("later_slip").reshape(-1, len(question.later)).T
        later = later.reshape(len(question.later), *system.slip_shape[1:])
        for m in range(len(shifts)):
            placed = question.placed(m)
            taken = placed.any(axis=1)
            shifts[m][taken] = (placed @ later)[taken] - first[taken]
    placed_question = replace(placed_order(question, places, load_factor), shifts=shifts)

    moves = np.zeros((len(question.sets), *question.r1.shape[1:]))
    for m, of_set in enumerate(question.sets):
        moves[m] = Mechanism.of(of_set, solution.moves[[m]]).moves[0]
    _, opened = question.statuses
    motion = Mechanism(moves, question.friction * ~opened, open=opened)
    return placed_question, question.slip_at_mean_load(first), motion


def _places(question: LiftOff, solution: Solution) -> list[float]:
    """The unknown places of the events."""
    events = range(len(question.order.on_segments))
    return [float(solution.values(f"way{event}")[0]) for event in events]


def solved_program(question: Question, solution: Solution, goal: str, **values: Any) -> Solved:
    """The solved program as data, with the places of events and later slips if it has them.

    `goal`: see `Solved`; the goal of the program of an order is "ordered".
    """
    if isinstance(question, LiftOff):
        goal = "ordered"
        values["ways"] = np.array(_places(question, solution))
        if question.later:
            axes = question.system.tangents
            values["later_slip"] = solution.values("later_slip").reshape(axes, -1).T
    return solution.solved(goal, **values)


def placed_order(question: LiftOff, places: Sequence[float], load_factor: float) -> LiftOff:
    """The order with its events at these places.

    If the load factor scales the loads that vary on a segment, it multiplies the places there.
    """
    order = question.order
    shares = []
    for segment, place in zip(order.on_segments, places, strict=True):
        if is_scaled(question, segment):
            place = place / load_factor if load_factor > 0 else 0.0
        shares.append(place)
    return replace(question, way=way_of(question.at, shares))
