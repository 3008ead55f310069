"""An increment of load with friction.

By sweeps (`sweeps.py`) and Newton's method (`newton.py`): `by_newton.py` has the solver,
`increment.py` its question and its result. `programs.py` has the same increment as cvxpy problems
to print and solve: with a frozen bound (form "qp"), with booleans ("milp"), and by complementarity
("complementarity").
"""

from .by_newton import NewtonIncrement
from .increment import Increment

__all__ = ["Increment", "NewtonIncrement"]


def __dir__() -> list[str]:
    return __all__
