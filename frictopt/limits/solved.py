"""A solved program as data, from which its printed problem and the proof of an answer follow."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..base import Array, kept
from .question import Question

OPTIMAL = "optimal"
INFEASIBLE = "infeasible"
UNBOUNDED = "unbounded"


@kept
@dataclass(frozen=True, eq=False)
class Solved:
    """A solved program: its question and goal, the values of its unknowns, and its multipliers.

    Attributes
    ----------
    goal
        Name of the function of `listing.py` that lists it.
    status
        "optimal"; "infeasible" if the multipliers prove that no values obey all rows; "unbounded".
    values
        The unknowns by name: load_factor, slip (N,) or (N, 2) of the closed nodes, margin, ... If
        the problem is unbounded, the load factor and the slip that grow.
    moves
        (K, M) multipliers of the equations of q and p, and of the gaps of open nodes. A further
        instant has those of q_r and p_r in the rows of a critical node.
    multipliers
        Those of the rows by label, (K, N) for rows of corners.
    own
        Multipliers of the rows of the user by name.
    unknowns, problem
        The variables of the model that was asked, and its problem if it has rows of the user. Both
        stay in memory.
    """

    goal: str
    question: Question
    status: str
    values: Mapping[str, Any]
    moves: Array
    multipliers: Mapping[str, Array]
    own: Mapping[str, Array] = field(default_factory=dict)
    unknowns: Any = None
    problem: Any = field(default=None)  # of cvxpy, with rows of the user; files have none

    def __getstate__(self) -> dict[str, Any]:
        """Copies have variables of their own."""
        return {**vars(self), "unknowns": None, "problem": copy.deepcopy(self.problem)}

    def of_model(self, unknowns: Any, user: Any) -> Solved:
        """A solved program with the variables of the model that asks, and its `UserRows`."""
        solved = replace(self, unknowns=unknowns)
        return solved if user is None else user.listed(solved)
