"""A cvxpy problem that can be copied and pickled, whatever solver has had it, and prints rows of many corners as one."""

import copy
import re
from typing import Any

import cvxpy as cp
from cvxpy.reductions.solution import Solution


class Problem(cp.Problem):  # type: ignore[misc]  # cvxpy does not say its type
    """A problem whose deep copies and pickles have its values, and unknowns and parameters of their own.

    cvxpy numbers the unknowns, and keeps parts that it has compiled by these numbers. In a plain copy the numbers are others, which ends Python. Nor
    can what solvers leave in a problem be pickled. So both stay behind.
    """

    def __str__(self) -> str:
        lines = dict[tuple[str, int], list[str]]()  # by what they are of a number k
        for line in super().__str__().split("\n"):
            numbers, again = set(re.findall(r"\[(\d+)\]", line)), 0
            kind, k = (re.sub(r"\[\d+\]", "[k]", line), *numbers) if len(numbers) == 1 else (line, "")
            while k in lines.get((kind, again), ()):
                again += 1
            lines.setdefault((kind, again), []).append(k)
        return "\n".join(_line(kind, ks) for (kind, _), ks in lines.items())

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.objective, self.constraints, self.status, self.value)

    def __deepcopy__(self, memo: dict[Any, Any]) -> "Problem":
        return _again(self.objective, self.constraints, self.status, self.value, memo)


def _line(kind: str, ks: list[str]) -> str:
    if len(ks) == 1:
        return kind.replace("[k]", f"[{ks[0]}]")
    return f"{kind}  for k = {', '.join(ks if len(ks) < 5 else [*ks[:2], '...', ks[-1]])}"


def _again(objective: Any, constraints: list[cp.Constraint], status: str, value: float, memo: Any = None) -> Problem:
    """A problem with numbers of its own: those of another process may stand for others here."""
    objective, constraints = copy.deepcopy((objective, constraints), memo)
    parts = [objective, *constraints]
    while parts:
        part = parts.pop()
        for name in [name for name in vars(part) if name.startswith("_lazy") or name == "__deepcopy__"]:  # which is None in cvxpy's own copies
            delattr(part, name)
        parts += part.args
    problem = Problem(objective, constraints)
    if status in ("optimal", "optimal_inaccurate"):
        problem.unpack(Solution(status, value, {part.id: part.value for part in problem.variables()}, {}, {}))
    return problem
