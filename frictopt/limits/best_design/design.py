"""The best design: preloads and a profile of the faces with the largest shakedown limit.

With an objective of the user it may be the cheapest design for a given load. `model.py`
solves for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ...base import Array, Booleans
from ...contact import LoadCycle
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
from ..program.mean_load import TOUCHES, is_safe_at_mean_load
from ..program.question import Question
from ..shakedown import ShakedownLimits

if TYPE_CHECKING:
    import pandas as pd

# The open nodes (N,) of each scenario.
OpenNodes: TypeAlias = Sequence[Booleans]


@dataclass(frozen=True)
class Found:
    """Scenarios of a design and the solution of its program, which its printed problem needs."""

    scenarios: Any
    solution: Any


@dataclass(frozen=True, eq=False, repr=False)
class Design(Answered, Explained):
    """A best design. `system` and `cycle` are the contact with the design, for other functions.

    The profile is in the initial gap of the system. Added material that overlaps is in the load
    case "profile". From some starts slip may continue for ever below the largest load factor: call
    `guaranteed_limit(design.system, design.cycle, friction)`, too.

    Attributes
    ----------
    load_factor, objective
        Without an objective: the largest load factor that is safe with the design in all scenarios
        (their least shakedown limit), and None. With an objective: the load factor at its maximum,
        which is no limit, and the largest value of the objective.
    least
        All load factors from `least` to `load_factor` are safe with the design, in all scenarios.
        It is 0 if the design is safe under the mean load. It is above 0 if no such design was found
        for these open nodes, for example because the cyclic loads have to press the contact. Below
        `least` no slip is safe with the same nodes open. NaN if rounding hides it.
    bound
        Upper bound of the load factor (or objective), from the multipliers, for all designs with
        the same open nodes that satisfy the constraints. It equals the value up to `residual`.
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
        grows if the constraint is relaxed, in your units and in the shape of the constraint. For an
        equation it is the rate with respect to the right side. If the best design is not unique,
        the rates need not be unique.
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
    # What the printed problem needs; None once it is listed.
    _found: Found | None = None
    # Whether no design with other open nodes is better.
    _is_best_of_all: bool = False
    # Whether the design had to be safe under the mean load, too.
    _for_mean_load: bool = False

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
            _, r = question.states(self.load_factor, slip)
            without_pressure = r[:, -1].min(axis=0) <= TOUCHES * question.force
            pulled = question.r0[:, -1].max(axis=0) < 0
            if ((without_pressure | pulled) & ~question.open_nodes).any():
                return True
        return False

    @property
    def reason(self) -> str:
        """Explanation that no design is better, and the open nodes for which this holds."""
        node_states = self._question.node_states
        sentence = BEST_SAFE_DESIGN if self._for_mean_load else BEST_DESIGN
        reason = sentence(opened=self._opened, node_states=node_states)
        if self._is_best_of_all:
            reason += NO_OTHER_DESIGNS_OPEN()
        elif any(nodes.any() for nodes in self.opens):
            reason += OTHER_DESIGNS_OPEN()
        if np.isnan(self.least):
            reason += START_UNKNOWN()
        elif self.least > 0:
            reason += UNSAFE_BELOW(node_states=f"{node_states[1:]} ", least=self.least)
        return reason

    @cached_property
    def _is_safe_at_mean_load(self) -> bool:
        """Whether in each scenario some slip is safe under the mean load alone."""
        if self._for_mean_load:
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
            least.append(ShakedownLimits().of_set(question).least)
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
