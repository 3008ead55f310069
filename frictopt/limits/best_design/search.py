"""The search for the open nodes of a best design. Theory, "The best design".

The best design with given open nodes is one program. But with the design built in, other nodes may
open under the mean load, and its limit is then lower than the program promises. So design and open
nodes are computed in turn, from several starts. A design counts only if `shakedown_limit` confirms
its load factor.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ...base import Bar, Booleans
from ...errors import ModelError, SolverError
from ..program.question import Question, with_open
from ..search.loose_nodes import Branches, LooseNodes
from ..search.set_search import MOST_COMPARED
from ..shakedown import ShakedownLimit, ShakedownLimits
from .design import Design, OpenNodes

_CARRIES_LESS = (
    "design: {opened}the best design has the load factor {load_factor:.6g}, but other nodes open "
    "under its mean load, and its shakedown limit is lower; bound the design more tightly"
)


class NoneSafeError(ModelError):
    """No design is safe with the given nodes open. With other nodes open, one may be safe."""


# Numbers of the search for the open nodes of a design.

# Number of sets of open nodes that are tried.
_MOST_SETS = 8
# Smallest relative difference of two values, or of two load factors, that counts.
_GAIN = 1e-7


class DesignSearch:
    """The designs that count, and the reasons that other designs do not count.

    Parameters
    ----------
    best_with
        Function that returns the best design with given open nodes.
    listed
        Function that adds its printed problem to a design.
    goal
        Name of the value of a design, for a bar.
    solver
        Name of the solver of limits, or None.
    bar
        Counts the programs. An interrupt keeps the best design.
    """

    def __init__(
        self,
        best_with: Callable[[OpenNodes], Design],
        listed: Callable[[Design], Design],
        goal: str,
        solver: str | None,
        bar: Bar,
    ) -> None:
        self._best_with = best_with
        self._listed = listed
        self._goal = goal
        self._solver = solver
        self._bar = bar
        self.counted: list[Design] = []
        # Sets of open nodes for which no solver's answer passes the checks.
        self._failed = set[bytes]()
        # Whether no design with other open nodes is better.
        self.is_best_of_all = False
        self._refused: list[Exception] = []
        # Best design for each set of open nodes, or None if it counts or does not exist.
        self._uncounted: dict[bytes, Design | None] = {}

    @property
    def best(self) -> Design | None:
        """The best design so far."""
        return max(self.counted, key=lambda design: design.value, default=None)

    @property
    def refusal(self) -> Exception:
        """The error that explains why no design counts."""
        first = self._refused[0]
        return ModelError(*first.args) if isinstance(first, NoneSafeError) else first

    def alternate(self, open_nodes: OpenNodes | None) -> None:
        """Compute the best design and its open nodes in turn, until the open nodes are not new."""
        while (
            open_nodes
            and len(self._uncounted) < _MOST_SETS
            and _key(open_nodes) not in self._uncounted
        ):
            open_nodes = self._nodes_that_open(open_nodes)

    def from_no_design(self, open_nodes: OpenNodes) -> None:
        """Start from the nodes that are open without a design."""
        try:
            self.alternate(open_nodes)
        # With these open nodes the design grows without end.
        except ModelError:
            if not self.counted:
                raise

    def compare(self, loose: LooseNodes, scenarios: int) -> None:
        """Bound the designs of all sets of open nodes, until no other set may have a better one."""
        branches = Branches(loose, lambda: self._wanted, partial(self._bound_of, scenarios))
        programs = 0
        while branches.left and programs < MOST_COMPARED:
            programs += 1
            self._bar.update()
            branches.step()
        higher = [design for design in self._uncounted.values() if design is not None]
        known = all(self._reaches(design.value) for design in higher)
        self.is_best_of_all = known and branches.bound <= self._wanted

    @property
    def _wanted(self) -> float:
        """The value above which a design is better than the best one."""
        best = self.best
        if best is None:
            return -np.inf
        return best.value + _GAIN * abs(best.value)

    def _bound_of(self, scenarios: int, opens: Booleans) -> float:
        """Compute the best design of a set, which counts or does not: -inf; inf if it fails."""
        open_nodes = [*opens.reshape(scenarios, -1)]
        if _key(open_nodes) not in self._uncounted:
            self._nodes_that_open(open_nodes)
        return np.inf if _key(open_nodes) in self._failed else -np.inf

    def _nodes_that_open(self, open_nodes: OpenNodes) -> OpenNodes | None:
        """Compute the best design with given open nodes, and the nodes that it leaves open.

        None if there is no such design.
        """
        key = _key(open_nodes)
        self._uncounted[key] = None
        self._bar.update()
        try:
            design = self._best_with(open_nodes)
        except (NoneSafeError, SolverError) as error:
            self._refused.append(error)
            if isinstance(error, SolverError):
                self._failed.add(key)
            return None
        limits = self._limits(design, open_nodes)
        if _counts(design, open_nodes, limits):
            self._keep(design)
        else:
            self._uncounted[key] = design
            why = _CARRIES_LESS.format(opened=design._opened, load_factor=design.load_factor)
            self._refused.insert(0, SolverError(why))
        return [limit.open for limit in limits]

    def _limits(self, design: Design, open_nodes: OpenNodes) -> list[ShakedownLimit]:
        """The limits with a design built in; empty if all nodes are closed and stay closed."""
        if np.any(open_nodes) or design.touches:
            return limits_of(design._questions, self._solver)
        return []

    def _keep(self, design: Design) -> None:
        """Keep a design that counts, and the best one for an interrupt."""
        self.counted.append(design)
        best = self.best
        assert best is not None
        self._bar.keep(
            "design",
            partial(self._listed, best),
            "the best by then is in the attribute `design`",
            best=f"{self._goal} {best.value:.4g} so far",
        )

    def _reaches(self, value: float) -> bool:
        return self.best is not None and self.best.value >= value


def limits_of(questions: Sequence[Question], solver: str | None) -> list[ShakedownLimit]:
    """The limits of the questions, each with its best open nodes; empty if one has no answer."""
    limits: list[ShakedownLimit] = []
    try:
        for question in questions:
            closed = with_open(question, np.zeros_like(question.open_nodes)) or question
            limits.append(ShakedownLimits(solver).of_any_set(closed))
    except SolverError:
        return []
    return limits


def _counts(design: Design, open_nodes: OpenNodes, limits: Sequence[ShakedownLimit]) -> bool:
    """Whether the limit with a design built in reaches the load factor of its program.

    With all nodes closed this is always so.
    """
    if not np.any(open_nodes):
        return True
    promised = design.load_factor * (1 - _GAIN)
    return bool(limits) and all(limit.load_factor >= promised for limit in limits)


def _key(open_nodes: OpenNodes) -> bytes:
    return np.array(open_nodes).tobytes()
