"""One increment of friction as three cvxpy problems: frozen bound, booleans, complementarity."""

from .complementarity import ComplementarityProblem, complementarity_problem
from .exact import ExactIncrement
from .frozen_bound import FrozenBoundIncrement
from .increment import Increment

__all__ = [
    "ComplementarityProblem",
    "ExactIncrement",
    "FrozenBoundIncrement",
    "Increment",
    "complementarity_problem",
]
