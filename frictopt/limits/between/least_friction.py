"""The least friction with a safe slip at one load factor, between two proven numbers.

For a friction, the room of the rows proves that it is enough or too little. Both narrow a bracket.
A safe point needs no more friction than its largest ratio of shear to pressure.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base import Array, worst
from ..program.question import Question
from ..program.solution import Mechanism
from .cones import Cones
from .judged import mechanism_of, work_of_stress
from .search import margins, most_room, raised

# Frictions that are tried until one is enough, or until neither proof is found.
_FIRST = tuple(4.0**k for k in range(8))
# Ratio of the two frictions that is assumed while no friction is known to be too little.
_LOWER = 1 / 16
# If the two frictions are within three gaps, the next friction is so close to `enough` that the
# bracket is within the gap if this friction is too little: `enough` is usually the better of the
# two. Its distance from `enough` is this share of the gap.
_CLOSE, _SHARE = 3.0, 0.9


class FrictionBracket:
    """The largest friction that is proven too little, and the smallest that is proven enough.

    Attributes
    ----------
    too_little, enough
        The two frictions; at first 0, and the friction that the residual shear of a contact without
        friction needs.
    moves
        Multipliers (K, t + 1, R) that prove that no slip is safe with `too_little`.
    shear
        (t, N) residual shear that is safe with `enough`.
    steps
        Number of steps of all searches.
    """

    def __init__(self, cones: Cones, load_factor: float) -> None:
        """`cones` are those of friction 1 with all nodes closed."""
        start = cones.start + load_factor * cones.rate
        self._cones = replace(cones, start=start, rate=np.zeros_like(start))
        self.shear = self._cones.relaxed()
        self.too_little, self.enough = 0.0, self._enough_for(self.shear)
        self.moves = np.zeros_like(start)
        self.steps = 0

    def _with_friction(self, friction: float) -> Cones:
        """The cones at the load factor, with this friction."""
        start = self._cones.start.copy()
        start[:, -1] *= friction
        return replace(self._cones, slope=friction * self._cones.slope, start=start)

    def narrow(self, gap: float, smallest: float) -> None:
        """Try frictions until the two are within a relative gap, or neither proof is found.

        The search also ends if `smallest` is enough.
        """
        for friction in _FIRST:
            if self.enough < np.inf or not self._try(friction):
                break
        while smallest < self.enough < np.inf and not self.is_within(gap):
            ratio = self.too_little / self.enough or _LOWER
            first = np.sqrt(ratio)
            if ratio > 1 - _CLOSE * gap:
                first = max(first, 1 - _SHARE * gap)
            # Very close to the least friction neither proof is found; then one friction more is
            # tried, nearer to `enough`.
            if not any(self._try(self.enough * share) for share in (first, np.sqrt(first))):
                break

    def is_within(self, gap: float) -> bool:
        """Whether the two frictions are within a relative gap."""
        return self.enough - self.too_little <= gap * self.enough

    def _try(self, friction: float) -> bool:
        """Look for a proof that a friction is enough or too little; True if the bracket shrinks."""
        before = self.too_little, self.enough
        found = most_room(self._with_friction(friction))
        self.steps += found.steps
        assert found.safe.best is not None
        shear = found.safe.best.shear
        enough = self._enough_for(shear)
        if enough < self.enough:
            self.enough, self.shear = enough, shear
        if found.multipliers.bound < found.enough and friction > self.too_little:
            self.too_little, self.moves = friction, found.multipliers.moves
        return before != (self.too_little, self.enough)

    def proof(self, question: Question) -> tuple[Mechanism, float]:
        """The mechanism that proves `too_little`, the friction of the question, and an error.

        The error is the larger of two: the violation of a row by `shear`, and the work that the
        multipliers do because they do not balance exactly, divided by the sum of their lifts.
        """
        rows = self._with_friction(self.enough).at(0.0, self.shear).rows
        cones = self._with_friction(self.too_little)
        moves = raised(self.moves)
        work = work_of_stress(cones, moves, self.shear)
        wrong = max(work, float((moves * cones.start).sum()) + work)
        error = wrong / (float(moves[:, -1].sum()) or 1.0)
        return mechanism_of(question, cones, moves), worst([-margins(rows).min(), error])

    def _enough_for(self, shear: Array) -> float:
        """The least friction with which residual shear (t, N) is safe; inf if it opens a node."""
        rows = self._cones.at(0.0, shear).rows
        pressure = rows[:, -1]
        if pressure.min() <= 0:
            return np.inf
        return float((np.linalg.norm(rows[:, :-1], axis=1) / pressure).max())
