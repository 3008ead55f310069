"""The safe slips of one load factor as a function of friction, for the least friction."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from ..base import Bar, Booleans, Table, frame
from ..errors import SolverError
from .moving_limit import moving_areas_at
from .question import Question, with_friction, with_open
from .safe_slip import SafeSlip, SafeSlips


class SafeByFriction:
    """The safe slips of one load factor for any friction and open nodes, each computed once.

    The bar counts the programs. An interrupt keeps the frictions tried.
    """

    def __init__(self, question: Question, load_factor: float, events: bool, bar: Bar) -> None:
        self.question = question
        self.load_factor = load_factor
        self.started = perf_counter()
        # The same for every friction above 0.
        self.areas = moving_areas_at(question, load_factor)
        self._bar = bar
        self._safe_slips = SafeSlips()
        self._events = events
        self._solved: dict[tuple[float, bytes, bool], SafeSlip] = {}

    @property
    def within(self) -> str:
        """The slip bound, as a part of a reason."""
        return "" if self.question.slip_bound is None else " within the slip bound"

    def at(
        self, friction: float, open_nodes: Booleans | None = None, events: bool = True
    ) -> SafeSlip:
        """The safe slip with the largest margin.

        `open_nodes=None`: the open nodes are searched until a slip is safe, and with events the
        orders in which they open and close, if the question has them. Nodes of moving areas are
        always searched.
        """
        if self.areas is not None:
            open_nodes = None
        events = events and self._events
        key = friction, b"" if open_nodes is None else open_nodes.tobytes(), events
        if key not in self._solved:
            self._bar.update()
            safe = self._solve(with_friction(self.question, friction), open_nodes, events)
            self._solved[key] = safe
            # A search ends with the program of the open nodes that it finds.
            self._solved.setdefault((friction, safe.open.tobytes(), False), safe)
            less, more = self.bracket()
            best = f"between {less:.4g} and {more:.4g} so far"
            note = f"{best}; the frictions tried are in the attribute `table`"
            self._bar.keep("table", self._table, note, best)
        return self._solved[key]

    def _solve(self, question: Question, open_nodes: Booleans | None, events: bool) -> SafeSlip:
        if open_nodes is not None:
            opened = with_open(question, open_nodes)
            assert opened is not None  # it has a limit
            return self._safe_slips.of_set(opened, self.load_factor)
        return self._safe_slips.of_question(
            question, self.load_factor, events=events, enough=self.load_factor
        )

    def exists(
        self, friction: float, open_nodes: Booleans | None = None, events: bool = True
    ) -> bool | None:
        """Whether a safe slip exists: True and False are proven; None if there is no proof."""
        try:
            return self.at(friction, open_nodes, events).exists
        except SolverError:
            return None

    def bracket(self) -> tuple[float, float]:
        """The largest friction proven too little, and the smallest one proven enough."""
        enough = [friction for (friction, *_), safe in self._solved.items() if safe.exists]
        least_enough = min(enough, default=np.inf)
        too_little = [friction for (friction, *_), safe in self._solved.items() if not safe.exists]
        below = (friction for friction in too_little if friction < least_enough)
        return max(below, default=0.0), least_enough

    def largest_slip(self, friction: float) -> float:
        """Size of the first safe slip that was found with a friction."""
        slips = (safe for (f, *_), safe in self._solved.items() if f == friction and safe.exists)
        return next(slips).largest_slip

    def _table(self) -> Table:
        """The frictions tried so far."""
        rows = {(f, safe.exists, safe.margin) for (f, *_), safe in self._solved.items()}
        return frame(sorted(rows), names=["friction", "safe", "margin"])
