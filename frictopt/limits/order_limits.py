"""The limits of orders of events, and the best one that the search finds.

If only the scaled or only the fixed loads vary where nodes open or close, the limit of an order is
one convex program. If both vary there, the program has products of the load factor and places:
linear programs then follow each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from ..base import LimitKind
from .lift_off import LiftOff, among, with_order
from .load_path import ends_of, may_open_and_close, meets_mean_load, path_of
from .order_search import best_order
from .ordered import About, ordered_program, read_order
from .question import pose, with_open
from .reasons import nothing_with_events
from .settled_order import Settled
from .shakedown_answer import ShakedownAnswer
from .solution import Judged, Solution, solve


@dataclass(frozen=True)
class ProductSettings:
    """Numbers of the programs with products of the load factor and places of events."""

    # Largest number of linearised programs.
    programs: int = 20
    # Change of the load factor, in its unit, and of places below which the solution stays.
    stays: float = 1e-8


PRODUCTS = ProductSettings()

# A shakedown limit.
L = TypeVar("L", bound=ShakedownAnswer)


def best_with_events(limits: Any, best: L, enough: float = np.inf) -> L:
    """The best limit with nodes that open and close in each cycle; `best` if none is better.

    `best` is the limit of nodes that stay open or closed. The search ends with the first limit that
    reaches `enough`. No order is searched if nodes cannot open and close in a state of rest.
    """
    question = best._question
    path = path_of(question.cycle)
    if path is None or not may_open_and_close(question, path):
        return best
    if path.closed or len(question.cycle.corners) == 2:
        found: L = _searched(limits, best, enough)
    else:
        found = _between_ends(limits, best, enough)
    if found.kind is LimitKind.NO_SAFE_SLIP:
        return replace(found, _why=nothing_with_events(found))
    return found


def _between_ends(limits: Any, best: Any, enough: float) -> Any:
    """The best limit of a load on a line, whose two ends stand for all its corners."""
    question = best._question
    path = path_of(question.cycle)
    assert path is not None  # the load is not static
    ends = pose(
        question.system,
        ends_of(question.cycle, path),
        question.friction,
        simplify=question.simplify,
    )
    opened = with_open(ends, question.open_nodes)
    assert opened is not None  # it has a limit with all corners
    of_ends = type(limits)(limits.solver)
    found = _searched(of_ends, of_ends.of_set(opened), enough)
    if not isinstance(found._question, LiftOff):
        return _again(limits, best, found)

    order = found._question.order
    nodes = question.system.nodes
    with_corners = with_order(
        question, order, lambda opened: with_open(question, among(opened, nodes))
    )
    assert with_corners is not None  # the order has a limit between the ends
    settled = Settled(order, found._question.shares, found.load_factor)
    limit = _limit_of(limits, with_corners, settled, -np.inf)
    return replace(limit, least=found.least)


def _searched(limits: Any, best: Any, enough: float) -> Any:
    """The best limit of `best_order`."""

    def limit_of(question: LiftOff | None, settled: Settled, above: float) -> Any:
        if question is not None:
            return _limit_of(limits, question, settled, above)
        opened = with_open(best._question, among(settled.order.start, best.system.nodes))
        assert opened is not None  # a transient rests with these nodes open
        return limits.of_set(opened, above=above)

    found = best_order(limit_of, best, enough)
    if isinstance(found._question, LiftOff):
        return found
    return _again(limits, best, found)


def _again(limits: Any, best: Any, found: Any) -> Any:
    """The limit with the open nodes of `found`; it is `best` if they are the same.

    It is solved again, so that the problem of the answer holds the values of the answer.
    """
    if (found.open == best.open).all():
        return best
    opened = with_open(best._question, found.open)
    assert opened is not None  # it has a limit
    return replace(limits.of_set(opened), least=found.least)


def _limit_of(limits: Any, question: LiftOff, settled: Settled, above: float) -> Any:
    """The limit of an order; SolverError if it is proven to be at most `above`.

    If the load meets the mean load on a line, all smaller load factors are safe. Else a second
    program gives the least one, unless the order is that of a pivot.
    """
    if question.both_vary:
        return _limit_of_products(limits, question, settled)
    program = ordered_program(question)
    limit = limits.of_order(question, program, 1.0, above)
    if meets_mean_load(question, question.path):
        return replace(limit, least=0.0)
    if not settled.shares:
        return limit
    return replace(limit, least=limits.of_order(question, program, -1.0).load_factor)


def _limit_of_products(limits: Any, question: LiftOff, settled: Settled) -> Any:
    """The limit of an order whose program has products of the load factor and places.

    The program is linearised about the last solution and solved again, until the solution no longer
    changes. The solution obeys the contact law. It has no bound, and the least safe load factor is
    not known.
    """
    about = About(settled.load_factor, settled.shares)
    for _ in range(PRODUCTS.programs):
        program = ordered_program(question, about=about)
        judged, _ = solve(program, "load_factor", 1.0, _judged, limits.solver)
        assert judged is not None
        placed, _, _ = read_order(question, judged.said)
        load_factor = judged.said.load_factor
        change = abs(load_factor - about.load_factor) / question.load_unit
        moved = np.abs(np.subtract(placed.shares, about.places)).max()
        about = About(load_factor, placed.shares)
        if max(change, moved) <= PRODUCTS.stays:
            break
    return replace(limits.of_order(question, program, 1.0), bound=np.inf)


def _judged(solution: Solution) -> Judged:
    """A solution of a linearised program, which counts if its multipliers prove its optimum."""
    return Judged(solution, solution.gap)
