"""The limit of the best set of open nodes, by a search whose programs need no proof.

The search compares quick limits (`quick_limits.py`). The best set is then solved and proven as
every limit is. If its proven limit is not what the search promises, the search is made again with
proven limits.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..base import Booleans
from ..errors import SolverError
from .question import Question
from .quick_limits import QUICK, QuickLimit, quick_limit
from .set_search import best_open_set
from .shakedown_answer import ShakedownAnswer


def best_set(limits: Any, question: Question, start_by: float, enough: float) -> Any:
    """The limit of the best set of open nodes, with its proof; see `best_open_set`.

    `limits` computes proven limits by `of_set`.
    """
    return _best(limits, question, start_by, enough, closed_needs_proof=True)


def best_open_nodes(limits: Any, question: Question, start_by: float, enough: float) -> Booleans:
    """(N,) the open nodes of `best_set`. The limit with all nodes closed is not proven."""
    open_nodes: Booleans = _best(limits, question, start_by, enough, closed_needs_proof=False).open
    return open_nodes


def _best(
    limits: Any, question: Question, start_by: float, enough: float, closed_needs_proof: bool
) -> Any:
    """The best limit by quick limits; by proven ones if the quick limits promise too much."""
    limit = _SetSearch(limits, True, closed_needs_proof).run(question, start_by, enough)
    if limit is not None:
        return limit
    return _SetSearch(limits, False, closed_needs_proof=True).run(question, start_by, enough)


class _SetSearch:
    """A search by quick limits, or by proven ones.

    `closed_needs_proof`: whether the limit with all nodes closed may be an answer. It is then
    solved with its proof at once, because it usually is the best one.
    """

    def __init__(self, limits: Any, quick: bool, closed_needs_proof: bool) -> None:
        self._limits = limits
        self._quick = quick
        self._closed_needs_proof = closed_needs_proof
        # The last question with a proven limit.
        self._last: Question | None = None

    def run(self, question: Question, start_by: float, enough: float) -> Any:
        """The proven limit of the best set; None if it is below the quick limit."""
        try:
            if self._quick and (_may_open(question) or not self._closed_needs_proof):
                closed = self._limit(question, -np.inf)
            else:
                closed = self._proven(question)
            best = best_open_set(self._limit, closed, start_by, enough, self._answer)
            if not (self._closed_needs_proof or best.open.any()):
                return best
            answer = self._answer(best)
        except SolverError:
            if self._quick:
                return None
            raise
        return answer if _agree(answer, best) else None

    def _limit(self, question: Question, above: float) -> Any:
        """A limit for the search; it may raise an error if it is at most `above`."""
        if self._quick:
            try:
                return quick_limit(question, above)
            except SolverError:
                pass
        return self._proven(question, above)

    def _proven(self, question: Question, above: float = -np.inf) -> Any:
        self._last = question
        return self._limits.of_set(question, above=above)

    def _answer(self, limit: Any) -> Any:
        """The proven limit of the set of a limit."""
        if isinstance(limit, QuickLimit):
            return self._proven(limit._question)
        if self._last is limit._question:
            return limit
        # Solve again, so that the problem of the answer holds the values of the answer.
        return replace(self._proven(limit._question), least=limit.least)


def _may_open(question: Question) -> bool:
    """Whether nodes have gaps, or the mean load pulls nodes; then some nodes usually open."""
    return bool(question.system.gap.any() or (question.r0[:, -1] < 0).any())


def _agree(answer: ShakedownAnswer, best: ShakedownAnswer) -> bool:
    """Whether a proven limit reaches the limit of the search.

    If safe load factors begin with another set, the limits of all these sets need proofs.
    """
    if not isinstance(best, QuickLimit):
        return True
    if np.isnan(best.load_factor):
        return bool(np.isnan(answer.load_factor))
    error = QUICK.differs * best._question.load_unit
    reaches = answer.load_factor >= best.load_factor - error
    return bool(reaches and answer.least <= best.least + error)
