"""The loads of a question as parameters, so that one compiled program serves many load cycles."""

from __future__ import annotations

from typing import Any

import cvxpy as cp

from ..base import Array
from .question import Question


class LoadParameters:
    """The matrices of a question, and its loads as parameters; see `models.rest`."""

    def __init__(self, question: Question) -> None:
        self.A: Array = question.A
        self.B: Array = question.B
        self.W: Array = question.W
        self._parameters = dict[str, cp.Parameter]()
        self._question = question

    def loads(self, k: int) -> dict[str, Any]:
        """Reactions and gaps of corner k, see `Question.loads`; arrays without entries stay."""
        loads: dict[str, Any] = dict(self._question.loads(k))
        for name, value in loads.items():
            if value.size:
                parameter = cp.Parameter(value.shape, value=value, name=name)
                loads[name] = self._parameters.setdefault(name, parameter)
        return loads

    def take(self, question: Question) -> None:
        """Take the loads of another load cycle of the same contact and open nodes."""
        for k in range(len(question.r1)):
            for name, value in question.loads(k).items():
                if name in self._parameters:
                    self._parameters[name].value = value
