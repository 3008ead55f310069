"""The search for the open nodes of a best design: design and open nodes in turn, from several starts. Theory, "The best design"."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn, TypeAlias

import cvxpy as cp
import numpy as np

from ..base import Booleans
from ..errors import ModelError, SolverError
from ..solve.problem import standing
from .question import Question
from .shakedown import ShakedownLimit


class NoneSafeError(ModelError):
    """No design is safe with given nodes open; with others one may be."""


_MOST = 8  # sets of open nodes
_GAINS = 1e-7  # relative difference that counts
_SHARE, _SHARES = (
    0.25,
    8,
)  # of the size of a design that opens other nodes, by which it is made smaller, and how often
_HALVES = 24  # of the interval between a size that counts and one that does not
_BUT = "but under its mean load other nodes open, and no limit that passes the checks confirms it; bound the design more tightly"

Design: TypeAlias = Any  # its file searches with this one

Sets: TypeAlias = list[Booleans]  # of each scenario


@dataclass(frozen=True)
class Found:
    """A design that counts, and what then stands in the unknowns and multipliers of its problem."""

    design: Design
    values: Mapping[cp.Variable, Any]


class DesignSearch:
    """Designs that count: with each built in, `shakedown_limit` finds no less than it promises.

    `of_sets` gives the best design with given open nodes, maybe of a share of the size of another
    one. `limits_of` gives the limits with a design built in, none where one has no answer. `tell`
    counts the programs.
    """

    def __init__(
        self,
        of_sets: Callable[..., Design],
        limits_of: Callable[[Sequence[Question]], list[ShakedownLimit]],
    ) -> None:
        self._of_sets, self._limits_of = of_sets, limits_of
        self.tell: Callable[[], object] = lambda: None
        self.found, self._refused = list[Found](), list[Exception]()
        self._tried = dict[bytes, Design | None]()  # by open nodes: what does not count

    @property
    def best(self) -> Found | None:
        """The best design so far."""
        return max(self.found, key=lambda each: each.design.value, default=None)

    def alternate(self, opened: Sets | None) -> None:
        """Design and open nodes in turn, until these stay."""
        while (
            opened
            and len(self._tried) < _MOST
            and (key := np.array(opened).tobytes()) not in self._tried
        ):
            self._tried[key] = None
            self.tell()
            try:
                design = self._of_sets(opened)
            except (NoneSafeError, SolverError) as why:
                self._refused.append(why)
                return
            counts, limits = self._counts(design, opened)
            if counts:
                self.found.append(Found(design, standing(design.problem)))
            else:
                self._tried[key] = design
                said = f"design: {design._opened}the best one would carry {design.load_factor:.6g}, {_BUT}"
                self._refused.insert(0, SolverError(said))
            opened = [limit.open for limit in limits]

    def from_no_design(self, opened: Sets) -> None:
        """The same from the nodes that are open without a design; if the best one with these opens others, a smaller one that does not."""
        if not np.any(opened):
            return
        try:
            self.alternate(opened)
        except ModelError:  # it grows without end with these nodes open
            if not self.found:
                raise
        most = self._tried.get(np.array(opened).tobytes())
        if most is None or (self.best and self.best.design.value >= most.value):
            return
        self._smaller(opened, most)

    def _smaller(self, opened: Sets, most: Design) -> None:
        """The largest size up to that of a design at which the best one counts, by bisection.

        Near no design the nodes are open that are so without it. A size at which nothing obeys the
        constraints is too small.
        """
        low, high = (0.0, -np.inf), (1.0, most.value)  # share of the size, and value
        share = _SHARE
        for _ in range(_SHARES + _HALVES):
            self.tell()
            design = self._of_share(opened, most, share)
            if design is None:
                low = share, -np.inf
            elif self._counts(design, opened)[0]:
                low = share, design.value
                design = replace(design, bound=most.bound, _stops=True)
                self.found.append(Found(design, standing(design.problem)))
            else:
                high = share, design.value
            settled = np.isfinite(low[1]) and high[1] - low[1] <= _GAINS * abs(low[1])
            if (
                settled
                or high[0] < _SHARE**_SHARES
                or (self.best and self.best.design.value >= high[1])
            ):
                return
            share = (low[0] + high[0]) / 2 if low[0] else high[0] * _SHARE

    def _of_share(self, opened: Sets, most: Design, share: float) -> Design | None:
        """The best design of a share of the size of another one; None where there is none."""
        try:
            return self._of_sets(opened, share, most)
        except (ModelError, SolverError):
            return None

    def refuse(self) -> NoReturn:
        """Say why no design counts."""
        first = self._refused[0]
        raise ModelError(*first.args) if isinstance(first, NoneSafeError) else first

    def _counts(self, design: Design, opened: Sets) -> tuple[bool, list[ShakedownLimit]]:
        """Whether a design counts, and the limits with it built in."""
        limits = self._limits_of(design._questions) if np.any(opened) or design.touches else []
        least = design.load_factor * (1 - _GAINS)
        counts = not np.any(opened)  # with all closed it never carries less
        if limits and all(limit.load_factor >= least for limit in limits):
            counts = True
        return counts, limits
