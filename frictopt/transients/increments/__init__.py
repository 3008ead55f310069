"""An increment of load with friction.

The increment is solved by sweeps (`sweeps.py`) and by Newton's method (`newton.py`): `by_newton.py`
combines both. `increment.py` has the problem in dimensionless units, and its result. `programs.py`
has the same increment as cvxpy problems to print and solve: with a frozen bound (form "qp"), with
booleans ("milp"), and by complementarity ("complementarity").
"""

from .by_newton import NewtonIncrement
from .increment import Increment

__all__ = ["Increment", "NewtonIncrement"]


def __dir__() -> list[str]:
    return __all__
