"""Search for the best set of open nodes: its limit, and a bound of the limits of all sets.

Branch and bound compares many sets of open nodes by one program. In a branch some nodes are open,
some are closed, and the others are loose (`loose_nodes.py`). If the bound of a branch is not above
the best limit so far, no set of the branch needs a program of its own. Otherwise the branch is
divided in two: one loose node opens in the first part and closes in the second. Contacts of many
nodes would need too many programs. There a local search begins at the nodes that the mean load
opens, and opens or closes nodes that govern (theory, "The search of the open nodes").

The search calls a function that returns the limit of a set, and does not depend on the program
behind it. Each limit passes the usual checks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from ...base import (
    FLOOR,
    RESIDUAL,
    Bar,
    Booleans,
    Integers,
    progress_bar,
)
from ...errors import FrictoptError, SolverError
from ..answers.shakedown_answer import Searched, ShakedownAnswer
from ..program.question import Question, with_open
from ..program.solution import NotAbove
from .likely_sets import (
    GAIN,
    PROGRAMS,
    WORK,
    governing,
    motion_of,
    next_to,
    open_under_mean,
    settled_sets,
    tends_to_open,
)
from .loose_nodes import Branches, LooseNodes, loose

# Numbers of the comparison of all sets.

# Largest number of nodes, in the plane and in space, of a contact whose sets are all compared by
# default; and largest number of programs that compare them. Blocks of 12 nodes need 100 to 400
# programs, clamps of 14 nodes 300 to 2000.
_SMALL = (14, 8)
MOST_COMPARED = 2000
# Largest number of motions of loose nodes (nodes times axes times corners) in one program: by
# default, and if the user gives a number of programs.
_MOTIONS = (240, 3000)

# A shakedown limit.
L = TypeVar("L", bound=ShakedownAnswer)


def best_open_set(
    limit_of: Callable[[Question, float], L],
    closed: L,
    start_by: float = np.inf,
    enough: float = np.inf,
    programs: int | None = None,
) -> L:
    """The best limit over sets of open nodes that the search finds.

    `closed` is the limit with all nodes closed. `limit_of(question, above)` computes the limit of a
    question with other open nodes, or raises `NotAbove` if this limit is at most `above`.

    Sets that are safe only above `start_by`, or only above the limit of the best set, do not count.
    If the contact is small or `programs` is given, all sets are compared, as far as the number of
    programs allows; otherwise only sets near the mean load and near the best set. The search ends

    - at once in a contact that is not small, without `programs`, if zero slip is safe under the
      mean load and no node governs;
    - if a comparison of all nodes has no branch left: then no set that counts has a higher limit
      or, with `enough`, no set reaches `enough`;
    - if the next comparison in a large contact would have too many motions of loose nodes;
    - if a local search finds no neighbour with a higher limit, and `programs` is None;
    - if the number of programs is used up;
    - if the best limit reaches `enough`;
    - by Ctrl-C: the KeyboardInterrupt has the best limit so far as its attribute `limit`.

    If no set counts, and solvers failed for some set, a SolverError is raised: that set may be
    safe.
    """
    question = closed._question
    small = is_small([question])
    if not small and programs is None and question.settles_closed and not len(governing(closed)):
        return replace(closed, _searched=Searched(programs=1))
    with progress_bar(True, "open nodes", "program") as bar:
        most = programs or (MOST_COMPARED if small else PROGRAMS)
        search = _SetSearch(limit_of, closed, start_by, enough, most, bar)
        if not small:
            search.locally()
        elif not _counts(closed, start_by):
            search.from_mean_load()
        if small or programs is not None:
            search.compare()
    if search.failed is not None and not _counts(search.best, start_by):
        raise search.failed
    return search.answer()


def is_small(questions: Sequence[Question]) -> bool:
    """Whether all sets of open nodes of all questions together are compared by default."""
    system = questions[0].system
    nodes = len(questions) * system.nodes
    motions = sum(_motions(question, system.nodes) for question in questions)
    return nodes <= _SMALL[system.tangents - 1] and motions <= _MOTIONS[0]


def _motions(question: Question, nodes: int) -> int:
    """Number of motions in the program that compares all sets of so many loose nodes."""
    return nodes * (question.system.tangents + 1) * len(question.r1)


def may_open(question: Question) -> bool:
    """Whether nodes have gaps, or the mean load pulls nodes; then some nodes usually open."""
    return bool(question.system.gap.any() or (question.r0[:, -1] < 0).any())


def _counts(limit: ShakedownAnswer, start_by: float) -> bool:
    """Whether some load factor is safe, and the least safe one is at most `start_by`."""
    return not (np.isnan(limit.load_factor) or limit.least > start_by)


class _SetSearch(Generic[L]):
    """The sets whose limits are known, and the best limit so far, which an interrupt keeps."""

    def __init__(
        self,
        limit_of: Callable[[Question, float], L],
        closed: L,
        start_by: float,
        enough: float,
        programs: int,
        bar: Bar,
    ) -> None:
        self.best = closed
        self.failed: SolverError | None = None
        self._closed = closed
        self._limit_of = limit_of
        self._start_by = start_by
        self._enough = enough
        self._most = programs
        self._programs = 1
        self._bar = bar
        # The bound of each set that is known; -inf for a set that does not count, or that is
        # separate (its limit is not safe at the best load factor).
        self._bounds = {closed.open.tobytes(): _bound(closed)}
        self._separate = list[L]()
        # The branches, once they contain all sets together.
        self._branches: Branches | None = None
        keep_best(bar, self.answer)

    def answer(self) -> L:
        """The best limit, and what is known about all other sets."""
        separate = min((limit.least for limit in self._separate), default=np.inf)
        return replace(self.best, _searched=Searched(self._programs, self.bound, separate))

    @property
    def bound(self) -> float:
        """The load factor that no set exceeds, apart from separate sets."""
        if self._branches is None:
            return np.inf
        # The bound is NaN if no load factor is safe with any set so far.
        return float(np.fmax(self._branches.bound, self.best.bound))

    @property
    def _above(self) -> float:
        """A limit above this load factor is higher than the best one."""
        best = self.best
        if not _counts(best, self._start_by):
            return -np.inf
        unit = FLOOR * best._question.load_unit
        return best.load_factor + GAIN * max(best.load_factor, unit)

    def _goes_on(self) -> bool:
        reached = _counts(self.best, self._start_by) and self.best.load_factor >= self._enough
        return self._programs < self._most and not reached

    def compare(self) -> None:
        """Bound the limits of all sets, until no other set may have a higher limit.

        In a large contact, first only the fourteen nodes that move most may open and close. If this
        finds no better set, twice as many nodes may open and close, and so on until all nodes may,
        or until a program would have too many motions.
        """
        question = self._closed._question
        total = question.system.nodes
        count = min(_SMALL[0], total)
        while self._goes_on() and _motions(question, count) <= _MOTIONS[1]:
            best = self.best
            nodes = np.sort(np.argsort(-motion_of(best), kind="stable")[:count])
            self._compare(nodes)
            if count == total:
                return
            if self.best is best:
                count = min(2 * count, total)

    def _compare(self, nodes: Integers) -> None:
        """Bound the limits of the sets that differ from the best one only in some nodes."""
        fixed = self.best.open.copy()
        fixed[nodes] = False
        question = with_open(self._closed._question, fixed)
        assert question is not None  # fewer nodes are open than in the best set

        def bound_of(opens: Booleans) -> float:
            open_nodes = fixed.copy()
            open_nodes[nodes] = opens[0]
            self.limit(open_nodes, self._above)
            return self._bounds[open_nodes.tobytes()]

        # If some set counts, load factors above this value do not matter.
        largest = max(self._reach, question.load_unit)
        program = LooseNodes(loose(question, nodes), nodes, largest)
        branches = Branches(program, lambda: self._wanted, bound_of)
        if len(nodes) == len(fixed):
            self._branches = branches
        while branches.left and self._goes_on():
            self._count()
            branches.step()

    @property
    def _wanted(self) -> float:
        """The load factor that a set must exceed for its limit to be computed."""
        enough = self._enough * (1 - RESIDUAL) if self._enough < np.inf else -np.inf
        return max(self._above, enough)

    def from_mean_load(self) -> None:
        """Try the sets that the mean load opens, so that the search begins near them."""
        with suppress(SolverError):
            for opened in open_under_mean(self._closed._question):
                self._neighbour(opened)

    def locally(self) -> None:
        """Search near the nodes that the mean load opens, and near the nodes that govern.

        Under a static load only the nodes that the mean load opens are tried: a search would open
        more nodes until a body slides off.
        """
        closed = self._closed
        question = closed._question
        moves = not question.static and self._goes_on() and _counts(closed, self._start_by)
        tending = moves and bool(tends_to_open(closed).any())
        self._climb(closed)
        if tending or not question.settles_closed:
            safe = _counts(self.best, self._start_by)
            self._climb_from(settled_sets(question, tending, safe))

    def _climb(self, start: L) -> None:
        """Move to a neighbouring set with a higher limit, as long as there is one."""
        current: L | None = start
        moves = not start._question.static
        while current and moves and self._goes_on() and _counts(self.best, self._start_by):
            above = current.load_factor * (1 + GAIN)
            neighbours = (self._neighbour(opened, above) for opened in next_to(current))
            current = next(filter(None, neighbours), None)

    def _climb_from(self, sets: Iterator[Booleans]) -> None:
        """Climb from the best of some sets and, if the programs are small, also from the last."""
        starts = [limit for limit in map(self._neighbour, sets) if limit is not None]
        if not starts:
            return
        self._climb(max(starts, key=lambda limit: limit.load_factor))
        # The last start has the least friction, and differs most from the start with the best
        # limit.
        if len(self._bounds) * starts[-1].slip.size < WORK:
            self._climb(starts[-1])

    def _neighbour(self, open_nodes: Booleans, above: float = -np.inf) -> L | None:
        return self.limit(open_nodes, above) if self._goes_on() else None

    def limit(self, open_nodes: Booleans, above: float) -> L | None:
        """The limit of a new set; None if it does not count, or is at most `above`."""
        key = open_nodes.tobytes()
        if key in self._bounds:
            return None
        # As long as nothing is proven, the limit of the set may have any value.
        self._bounds[key] = np.inf
        try:
            question = None
            if not open_nodes.all():
                question = with_open(self._closed._question, open_nodes)
            if question is None:
                # If the closed nodes do not hold the open nodes, there is no limit.
                self._bounds[key] = -np.inf
                return None
            self._count()
            limit = self._limit_of(question, above)
        except NotAbove:
            return None
        except SolverError as error:
            self.failed = error
            return None
        except FrictoptError:
            return None
        self._bounds[key] = _bound(limit)
        if np.isnan(limit.load_factor) or limit.load_factor <= above:
            return None
        if not _counts(limit, self._start_by) or not self._compared(limit):
            self._bounds[key] = -np.inf
            return None
        return limit

    def _compared(self, limit: L) -> bool:
        """Keep the better limit; False if load factors between both limits are not safe."""
        if limit.load_factor <= self._above:
            return True
        self._separate.append(limit)
        joined = [limit]
        while joined:
            joined = [other for other in self._separate if self._joins(other)]
            if joined:
                highest = max(joined, key=lambda other: other.load_factor)
                least = highest.least
                if _counts(self.best, self._start_by):
                    least = min(self.best.least, least)
                self.best = replace(highest, least=least)
            above = self._above
            self._separate = [other for other in self._separate if other.load_factor > above]
        return limit not in self._separate

    def _joins(self, limit: L) -> bool:
        """Whether the set of a higher limit is also safe at the best load factor."""
        return not limit.least > self._reach * (1 + GAIN)

    @property
    def _reach(self) -> float:
        """Sets that are safe only above this load factor do not count; inf if no set counts yet."""
        if not _counts(self.best, self._start_by):
            return np.inf
        return max(self.best.load_factor, self._start_by if self._start_by < np.inf else 0.0)

    def _count(self) -> None:
        self._programs += 1
        self._bar.update()


def _bound(limit: ShakedownAnswer) -> float:
    """The proven bound of a set; -inf if no load factor is safe."""
    if not np.isnan(limit.load_factor):
        return limit.bound
    # Without a solved program, only a solver says that no load factor is safe, which is no proof.
    return np.inf if limit._solved is None else -np.inf


def keep_best(bar: Bar, answer: Callable[[], ShakedownAnswer]) -> None:
    """Keep the best limit for an interrupt, and show it with the bound of all sets."""

    def so_far() -> str:
        limit = answer()
        if np.isnan(limit.load_factor):
            return "none safe so far"
        most = limit._searched.bound
        bound = f", at most {most:.4g}" if most < np.inf else ""
        return f"at least {limit.load_factor:.4g}{bound} so far"

    bar.keep("limit", answer, "the best limit by then is in the attribute `limit`", so_far)
