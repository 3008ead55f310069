"""The best design: preloads and a profile of the faces with the largest shakedown limit.

With an objective of the user it may be the cheapest design for a given load, for example.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ...base import Array, Bar, Booleans
from ...contact import LoadCycle
from ...errors import ModelError, SolverError
from ...solve.explained import Explained
from ..answers.answered import Answered
from ..answers.sentences import (
    BEST_DESIGN,
    BEST_SAFE_DESIGN,
    NO_OTHER_DESIGNS_OPEN,
    OTHER_DESIGNS_OPEN,
    START_UNKNOWN,
    UNSAFE_BELOW,
)
from ..program.question import Question, with_open
from ..search.likely_sets import is_safe_at_mean_load, touching
from ..search.loose_nodes import Branches, LooseNodes
from ..search.set_search import MOST_COMPARED
from ..shakedown import ShakedownLimit, limit_of_any_set, limit_of_set

if TYPE_CHECKING:
    import pandas as pd

# The open nodes (N,) of each scenario.
OpenNodes: TypeAlias = Sequence[Booleans]


@dataclass(frozen=True, eq=False, repr=False)
class Design(Answered, Explained):
    """A best design, built into `system` and `cycle`, which other functions take.

    The profile is contained in the initial gap of the system. If added material overlaps, the
    overlap is in the load case "profile". From some starts slip may continue for ever even below
    the load factor of the design: call `guaranteed_limit(design.system, design.cycle, friction)`,
    too.

    Attributes
    ----------
    load_factor, objective
        Without an objective, `load_factor` is the largest load factor that is safe with the design
        in all scenarios (their least shakedown limit), and `objective` is None. With an objective,
        `objective` is its largest value, and `load_factor` is the load factor there, which is no
        limit.
    least
        All load factors from `least` to `load_factor` are safe with the design, in all scenarios.
        `least` is 0 if the design is safe under the mean load. It is above 0 if, with these open
        nodes, no design was found that is safe under its mean load, for example because the cyclic
        loads have to press the contact. Below `least` no slip is safe with the same nodes open.
        `least` is NaN if rounding hides it.
    bound
        Upper bound of the load factor (or objective), from the multipliers, for all designs with
        the same open nodes that satisfy the constraints. The bound equals the load factor (or
        objective) up to `residual`.
    preload
        Series: amplitude that the design adds to the mean load, for each load case of `preloads`.
    profile
        (N,) depth of material removed at each node, length; negative: added. None if the design has
        no profile.
    slip, slips
        (N,) or (N, 2) a safe residual slip, length; and the tuple of such slips, one per scenario,
        of which `slip` is the first.
    prices
        Name of each user constraint -> the rate, >= 0, at which the load factor (or the objective)
        grows if the constraint is relaxed, in your units and in the shape of the constraint. For
        an equation it is the rate as the right side grows, of either sign. If the best design is
        not unique, the rates need not be unique either.
    record
        Solver, attempts and time. Its `residual`, at most 1e-9, is the largest of three errors: the
        violation of the contact law by the slips at all corners with the design built in, the
        dimensionless violation of your constraints, and the relative distance of `bound`.
    problem
        The solved cvxpy problem. A later solve of the same `DesignModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"bolt": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> cycle = fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> model = fo.DesignModel(node, cycle, preloads=["bolt"])
    >>> design = model.solve(0.5, [(model.preload <= 4.0).set_label("strength")])
    >>> round(design.load_factor, 6), dict(design.cycle.mean)
    (2.0, {'bolt': 4.0})
    >>> round(float(design.prices["strength"][0]), 6)
    0.5
    """

    objective: float | None
    bound: float
    preload: pd.Series
    profile: Array | None
    slips: tuple[Array, ...]
    prices: Mapping[str, Array]
    _questions: tuple[Question, ...]
    problem: Any = None
    # The scenarios and the solution, for the problem to be printed; None once it has been listed.
    _found: tuple[Any, Any] | None = None
    # Whether it is proven that no design with other open nodes is better.
    _is_best_of_all: bool = False
    # If the design had to be safe under the mean load, too: the best value without this condition.
    _without_mean_load: float | None = None

    @property
    def value(self) -> float:
        """The maximized value: the objective if there is one, otherwise the load factor."""
        return self.load_factor if self.objective is None else self.objective

    @property
    def scenarios(self) -> tuple[tuple[LoadCycle, Array], ...]:
        """The pairs (load cycle, friction) of all scenarios, preloads in the mean loads."""
        return tuple((question.cycle, question.friction) for question in self._questions)

    @property
    def opens(self) -> OpenNodes:
        """Open nodes at all corners, (N,) bool for each scenario; `open` is the first."""
        return tuple(question.open_nodes for question in self._questions)

    @property
    def touches(self) -> bool:
        """Whether a closed node has no pressure at a corner, or is pulled by the mean load."""
        for question, slip in zip(self._questions, self.slips, strict=True):
            bare, _ = touching(question, self.load_factor, slip)
            pulled = question.r0[:, -1].max(axis=0) < 0
            if ((bare | pulled) & ~question.open_nodes).any():
                return True
        return False

    @property
    def reason(self) -> str:
        """Why no design is better, and for which open nodes this holds."""
        node_states = self._question.node_states
        sentence = BEST_DESIGN if self._without_mean_load is None else BEST_SAFE_DESIGN
        reason = sentence.format(opened=self._opened, node_states=node_states)
        if self._is_best_of_all:
            reason += NO_OTHER_DESIGNS_OPEN
        elif any(nodes.any() for nodes in self.opens):
            reason += OTHER_DESIGNS_OPEN
        if np.isnan(self.least):
            reason += START_UNKNOWN
        elif self.least > 0:
            reason += UNSAFE_BELOW.format(node_states=f"{node_states[1:]} ", least=self.least)
        return reason

    @cached_property
    def _is_safe_at_mean_load(self) -> bool:
        """Whether in each scenario some slip is safe under the mean load alone."""
        if self._without_mean_load is not None:
            return True
        questions = zip(self._questions, self.slips, strict=True)
        return all(is_safe_at_mean_load(question, slip) for question, slip in questions)

    @cached_property
    def least(self) -> float:
        """The smallest load factor at which the design is safe, see the class."""
        if self._is_safe_at_mean_load:
            return 0.0
        least = []
        for question in self._questions:
            least.append(limit_of_set(question).least)
        return float(np.max(least))

    def to_frame(self) -> pd.DataFrame:
        """A row for each node: node, its place, its slip, and the profile if there is one."""
        table = super().to_frame()
        return table if self.profile is None else table.assign(profile=self.profile)

    def _answer(self) -> Mapping[str, object]:
        answer: dict[str, object] = {"load_factor": self.load_factor}
        if self.objective is not None:
            answer["objective"] = self.objective
        for name in ("least", "bound", "largest_slip", "residual"):
            answer[name] = getattr(self, name)
        for name, amount in self.preload.items():
            answer[f"preload {name}"] = amount
        if self.profile is not None:
            answer["profile"] = f"{self.profile.min():.4g} .. {self.profile.max():.4g}"
        return answer | {"reason": self.reason}

    def _explanation(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "best design", self.value, None, self.reason


class NoneSafeError(ModelError):
    """No design is safe with the given nodes open. With other nodes open, one may be safe."""


# Numbers of the search for the open nodes of a design.

# Largest number of sets of open nodes that are tried.
_MOST_SETS = 8
# A value or load factor counts as larger if it is larger by at least this share.
_GAIN = 1e-7


class DesignSearch:
    """The designs that count, and the reasons that other designs do not count.

    Parameters
    ----------
    best_with
        Function that returns the best design with given open nodes.
    listed
        Function that adds the printed problem to a design.
    bar
        Counts the programs. An interrupt keeps the best design.
    """

    def __init__(
        self,
        best_with: Callable[[OpenNodes], Design],
        listed: Callable[[Design], Design],
        bar: Bar,
    ) -> None:
        self._best_with = best_with
        self._listed = listed
        self._bar = bar
        self.counted: list[Design] = []
        # Sets of open nodes for which no solver's answer passes the checks.
        self._failed = set[bytes]()
        # Whether no design with other open nodes is better.
        self.is_best_of_all = False
        self._refused: list[Exception] = []
        # The best design for each set of open nodes; None if it counts, or if there is none.
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
        """Compute the best design and its open nodes in turn, until a set comes back.

        This also ends if no design has the open nodes, or after `_MOST_SETS` sets.
        """
        while (
            open_nodes
            and len(self._uncounted) < _MOST_SETS
            and _key(open_nodes) not in self._uncounted
        ):
            open_nodes = self._nodes_that_open(open_nodes)

    def compare(self, loose: LooseNodes) -> None:
        """Bound the designs of all sets of open nodes, until no set may have a better design."""
        branches = Branches(loose, lambda: self._wanted, self._bound_of)
        programs = 0
        while branches.left and programs < MOST_COMPARED:
            programs += 1
            self._bar.update()
            branches.step()
        best = -np.inf if self.best is None else self.best.value
        others = [design.value for design in self._uncounted.values() if design is not None]
        # A design of this value may be safe under the mean load with other open nodes.
        others += [
            design._without_mean_load
            for design in self.counted
            if design._without_mean_load is not None
        ]
        self.is_best_of_all = max(others, default=best) <= best and branches.bound <= self._wanted

    @property
    def _wanted(self) -> float:
        """The value that a design must exceed to be better than the best one."""
        best = self.best
        if best is None:
            return -np.inf
        return best.value + _GAIN * abs(best.value)

    def _bound_of(self, opens: Booleans) -> float:
        """Compute the best design with given open nodes; return -inf, or inf if solvers fail.

        They need no bound any more, because their design has been kept, or does not count.
        """
        open_nodes = [*opens]
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
            carries_less = SolverError(
                f"design: {design._opened}the best design has the load factor "
                f"{design.load_factor:.6g}, but other nodes open under its mean load, and its "
                "shakedown limit is lower; bound the design more tightly"
            )
            self._refused.insert(0, carries_less)
        return [limit.open for limit in limits]

    def _limits(self, design: Design, open_nodes: OpenNodes) -> list[ShakedownLimit]:
        """The limits with a design built in; empty if all nodes were closed and stay closed."""
        if np.any(open_nodes) or design.touches:
            return limits_of(design._questions)
        return []

    def _keep(self, design: Design) -> None:
        """Keep a design that counts, and the best one for an interrupt."""
        self.counted.append(design)
        best = self.best
        assert best is not None
        goal = "load factor" if best.objective is None else "objective"
        self._bar.keep(
            "design",
            partial(self._listed, best),
            "the best by then is in the attribute `design`",
            best=f"{goal} {best.value:.4g} so far",
        )


def limits_of(questions: Sequence[Question]) -> list[ShakedownLimit]:
    """The limits of the questions, each with its best open nodes; empty if one has no answer."""
    limits: list[ShakedownLimit] = []
    try:
        for question in questions:
            closed = with_open(question, np.zeros_like(question.open_nodes)) or question
            limits.append(limit_of_any_set(closed))
    except SolverError:
        return []
    return limits


def _counts(design: Design, open_nodes: OpenNodes, limits: Sequence[ShakedownLimit]) -> bool:
    """Whether the limit with a design built in reaches the load factor of the design.

    With all nodes closed it always does.
    """
    if not np.any(open_nodes):
        return True
    promised = design.load_factor * (1 - _GAIN)
    return bool(limits) and all(limit.load_factor >= promised for limit in limits)


def _key(open_nodes: OpenNodes) -> bytes:
    return np.array(open_nodes).tobytes()
