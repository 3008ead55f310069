"""Search for the open nodes of a state of rest.

The search stays near the settled mean load (theory, "Contacts that open"). The largest limit over
all sets is not useful for design: sets far from the settled state also obey the contact law, but no
usual start leads to them. The limit of a given set never falls as friction grows, so that the open
nodes at less friction are good starts. The open nodes at more friction are starts from the other
side.

The search calls a function that returns a limit; it does not depend on the program behind it. Each
limit passes the usual checks, and its bound holds for its own open nodes only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from ..base import RESIDUAL, Array, Bar, Booleans, Integers, progress_bar
from ..contact import reactions
from ..errors import FrictoptError, SolverError
from ..transients.statics import Statics, note_balanced
from .open_nodes import TOUCHES, open_under_mean
from .question import Question, with_open
from .shakedown_answer import ShakedownAnswer


@dataclass(frozen=True)
class SearchSettings:
    """Numbers of the searches of sets and of orders (`order_search.py`)."""

    # Shares of the friction with which the mean load may open other nodes.
    frictions: tuple[float, ...] = (1.0, 1.5, 0.7, 0.5, 0.35, 0.2, 0.1, 0.02)
    # A node governs the limit if its motion in the mechanism is above this share of the largest.
    governs: float = 0.02
    # The same share for a node that touches, also in a search of orders: an open node without gap
    # at a corner, or a closed node without pressure. The motion of an open node is in the unit of
    # its gap, and can be far smaller than the slips of closed nodes.
    governs_touching: float = 1e-6
    # Pressed nodes of a closed contact are opened only if nodes have gaps, or if the contact has at
    # most this number of nodes. In a larger closed contact this costs a program for each of them,
    # and in the contacts measured it gains nothing.
    small: int = 16
    # Smallest relative gain of a limit that counts; a smaller one may be rounding.
    gain: float = 1e-7
    # Largest number of programs of one search.
    programs: int = 60
    # Largest number of programs times unknown slips, in a search of orders; up to it, a search of
    # sets climbs from a second start.
    work: int = 20_000
    # In space, more than `few` governing nodes are flipped in groups of `group` nodes.
    few: int = 16
    group: int = 4


SEARCH = SearchSettings()

# A shakedown limit.
L = TypeVar("L", bound=ShakedownAnswer)


def best_open_set(
    limit_of: Callable[[Question, float], L],
    closed: L,
    start_by: float,
    enough: float,
) -> L:
    """The best limit over sets of open nodes that the search finds.

    `closed` is the limit with all nodes closed. It is the answer if zero slip is safe under the
    mean load and no governing node may open. `limit_of(question, above)` computes the limit of a
    question with other open nodes; it may raise an error if this limit is at most `above`.

    Sets that are safe only above `start_by`, or only above the limit of the best set, do not count.
    The first limit that reaches `enough` ends the search. Under a static load only the nodes that
    the mean load opens are tried: a search would open more nodes until a body slides off.

    If no set counts, and solvers failed for some set, a SolverError is raised: that set may be
    safe.
    """
    question = closed._question
    may_change = not question.static
    searches = may_change and _counts(closed, start_by) and closed.load_factor < enough
    may_open = searches and len(_governing(closed)) > 0
    tends_to_open = searches and bool(_tends_to_open(closed).any())
    no_slip = np.zeros(question.system.slip_shape)
    # If zero slip is safe, the mean load alone leaves all nodes closed, as `closed` does.
    settles_closed = question.violation(0.0, no_slip) <= RESIDUAL
    if settles_closed and not may_open:
        return closed
    if not question.fixed and question.violation(0.0, closed.slip) <= RESIDUAL:
        # The search for a motion of bodies under the mean load would factorise the stiffness.
        mean = reactions(question.system, [question.cycle.mean])[0]
        note_balanced(question.system, question.friction, mean)

    with progress_bar(True, "open nodes", "program") as bar:
        search = _SetSearch(limit_of, closed, start_by, enough, may_change, bar)
        search.climb(closed)
        if tends_to_open or not settles_closed:
            safe = _counts(search.best, start_by)
            search.climb_from(_settled(question, tends_to_open, safe))
    if search.failed is not None and not _counts(search.best, start_by):
        raise search.failed
    return search.best


def may_open(question: Question) -> bool:
    """Whether nodes have gaps, or the mean load pulls nodes; then some nodes usually open."""
    return bool(question.system.gap.any() or (question.r0[:, -1] < 0).any())


def _counts(limit: ShakedownAnswer, start_by: float) -> bool:
    """Whether some load factor is safe, and the least safe one is at most `start_by`."""
    return not (np.isnan(limit.load_factor) or limit.least > start_by)


class _SetSearch(Generic[L]):
    """The sets that have been tried, and the best limit so far, which an interrupt keeps."""

    def __init__(
        self,
        limit_of: Callable[[Question, float], L],
        closed: L,
        start_by: float,
        enough: float,
        moves: bool,
        bar: Bar,
    ) -> None:
        self.best = closed
        self.failed: SolverError | None = None
        self.tried = {closed.open.tobytes()}
        self._question = closed._question
        self._limit_of = limit_of
        self._start_by = start_by
        self._enough = enough
        self._moves = moves
        self._bar = bar
        self._keep(closed)

    def climb(self, start: L) -> None:
        """Move to a neighbouring set with a higher limit, as long as there is one."""
        current: L | None = start
        while current and self._moves and self._goes_on():
            above = current.load_factor * (1 + SEARCH.gain)
            neighbours = (self.limit(open_nodes, above) for open_nodes in _next_to(current))
            current = next(filter(None, neighbours), None)

    def climb_from(self, sets: Iterator[Booleans]) -> None:
        """Climb from the best of some sets and, if that is no great work, from the last one."""
        starts = [limit for limit in map(self.limit, sets) if limit is not None]
        if not starts:
            return
        self.climb(max(starts, key=lambda limit: limit.load_factor))
        # The last start has the least friction. Other sets are close to it.
        if len(self.tried) * starts[-1].slip.size < SEARCH.work:
            self.climb(starts[-1])

    def _goes_on(self) -> bool:
        return _counts(self.best, self._start_by) and self.best.load_factor < self._enough

    def limit(self, open_nodes: Booleans, above: float = -np.inf) -> L | None:
        """The limit of a new set; None if it does not count or is at most `above`."""
        if open_nodes.tobytes() in self.tried or len(self.tried) > SEARCH.programs:
            return None
        self.tried.add(open_nodes.tobytes())
        self._bar.update()
        limit = self._solved(open_nodes, above)
        if limit is None or not _counts(limit, self._start_by) or limit.load_factor <= above:
            return None
        if not self._compared(limit):
            return None
        self._keep(self.best)
        return limit

    def _keep(self, limit: L) -> None:
        keep_best(self._bar, limit)

    def _solved(self, open_nodes: Booleans, above: float) -> L | None:
        """The limit of a set; None if its answer fails, or the closed nodes do not hold it."""
        if open_nodes.all():
            return None
        try:
            question = with_open(self._question, open_nodes)
            if question is not None:
                return self._limit_of(question, above)
        except SolverError as error:
            self.failed = error
        except FrictoptError:
            pass
        return None

    def _compared(self, limit: L) -> bool:
        """Keep the better limit; False if load factors between both limits are not safe."""
        best = self.best
        if not _counts(best, self._start_by):
            self.best = limit
            return True
        gain = 1 + SEARCH.gain
        if limit.load_factor > best.load_factor * gain:
            reach = max(best.load_factor, self._start_by if self._start_by < np.inf else 0.0)
            if limit.least > reach * gain:
                return False
            self.best = replace(limit, least=min(best.least, limit.least))
        return True


def keep_best(bar: Bar, limit: ShakedownAnswer) -> None:
    """Keep the best limit for an interrupt."""
    best = f"at least {limit.load_factor:.4g} so far"
    if np.isnan(limit.load_factor):
        best = "none safe so far"
    bar.keep("limit", limit, "the best limit by then is in the attribute `limit`", best)


def _settled(question: Question, tends_to_open: bool, safe: bool) -> Iterator[Booleans]:
    """Open nodes under the mean load, for the given friction, for more and for less.

    If the mean load opens no node with the given friction, other frictions are tried only if some
    governing node `tends_to_open`. `safe`: whether some set is known to be safe.
    """
    for share in SEARCH.frictions:
        try:
            opened = open_under_mean(question, share * question.friction)
        except SolverError:
            # The state under the mean load is not known, so that this start is missing. If no other
            # state of rest is known, raise: a failed solver does not prove that none exists. A body
            # that slides off has no such state.
            if share == 1.0 and not safe and not _slides_off(question):
                raise
            continue
        yield from opened
        if share == 1.0 and not (opened or tends_to_open):
            return


def _slides_off(question: Question) -> bool:
    """Whether the mean load slides a body off at the pressures of the closed contact."""
    statics = Statics(question.system, question.friction)
    return any(
        statics.slides_off("the mean load", forces.ravel()) is not None for forces in question.r0
    )


def _next_to(limit: ShakedownAnswer) -> Iterator[Booleans]:
    """Neighbouring sets of open nodes: some governing nodes of the limit are opened or closed.

    First all governing nodes change, then only the nodes at the border between open and closed
    nodes. In the plane the whole border follows, from outside or from inside, because a mechanism
    may govern on one side only. Then governing nodes change one by one, in space in small groups,
    beginning at the border.
    """
    question = limit._question
    open_nodes = question.open_nodes
    plane = question.system.tangents == 1
    governing = _governing(limit)
    changes = np.roll(open_nodes, 1) != open_nodes
    border = changes | np.roll(changes, -1)
    edge = governing[border[governing]]
    inner = governing[~border[governing]]

    groups = [governing, edge]
    if plane:
        groups += [np.flatnonzero(border & (open_nodes == state)) for state in (False, True)]
    size = 1 if plane or len(governing) <= SEARCH.few else SEARCH.group
    for part in (edge, inner):
        groups += [part[start : start + size] for start in range(0, len(part), size)]
    for nodes in groups:
        flipped = open_nodes.copy()
        flipped[nodes] ^= True
        yield flipped


def _governing(limit: ShakedownAnswer) -> Integers:
    """Nodes that govern a limit and may change, largest motion first.

    In a large closed contact without gaps, only nodes that tend to open govern.
    """
    question = limit._question
    motion = _motion(limit)
    share = np.where(_touching(limit), SEARCH.governs_touching, SEARCH.governs)
    governs = motion > share * motion.max()
    if not (question.open_nodes.any() or _pressed_nodes_may_open(question)):
        governs = _tends_to_open(limit)
    order = np.argsort(-motion, kind="stable")
    return np.asarray(order[governs[order]])


def _tends_to_open(closed: ShakedownAnswer) -> Booleans:
    """(N,) governing nodes of a closed contact without pressure, or pulled by the mean load."""
    motion = _motion(closed)
    unpressed = _touching(closed) & (motion > SEARCH.governs_touching * motion.max())
    pulled = closed._question.r0[:, -1].max(axis=0) < 0
    return np.asarray(unpressed | pulled & (motion > SEARCH.governs * motion.max()))


def _motion(limit: ShakedownAnswer) -> Array:
    """(N,) motions of the nodes in the mechanism of a limit; of open nodes, how far they touch."""
    motion: Array = limit._motion.parts(limit._question.system).sum(axis=(0, 1))
    return motion


def _pressed_nodes_may_open(question: Question) -> bool:
    """Whether pressed nodes are opened, too, while all nodes are closed."""
    system = question.system
    has_gaps = bool((system.gap > TOUCHES * question.clearance).any())
    return has_gaps or system.nodes <= SEARCH.small


def _touching(limit: ShakedownAnswer) -> Booleans:
    """(N,) open nodes whose gap closes at a corner, and closed nodes without pressure at one."""
    question = limit._question
    if not np.isfinite(limit.load_factor):
        return np.zeros(question.system.nodes, dtype=bool)
    u, r = question.states(limit.load_factor, limit.slip)
    shut = u[:, -1].min(axis=0) <= TOUCHES * question.clearance
    unpressed = r[:, -1].min(axis=0) <= TOUCHES * question.force
    return np.asarray(np.where(question.open_nodes, shut, unpressed))
