"""An increment of friction.

By sweeps and Newton's method (`by_newton.py`), and as cvxpy problems to print and solve
(`programs.py`, `by_booleans.py`): frozen bound, booleans, complementarity. `held.py` puts the
states of a path into these problems.
"""

from .by_booleans import ExactIncrement
from .by_newton import NewtonIncrement
from .increment import Increment
from .programs import ComplementarityProblem, FrozenBoundIncrement, complementarity_problem

__all__ = [
    "ComplementarityProblem",
    "ExactIncrement",
    "FrozenBoundIncrement",
    "Increment",
    "NewtonIncrement",
    "complementarity_problem",
]


def __dir__() -> list[str]:
    return __all__
