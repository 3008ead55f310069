"""What stands below cvxpy. This room knows no contact.

In comes a cvxpy problem with the units of its unknowns; out come its values, multipliers and a
proof. `chain.py` is the way of a problem to its answer: `compiled.py` reads it as cvxpy compiles
it, `reduced.py` makes it small and well scaled, `solvers.py` and `interior_point.py` solve it,
`arrays.py` makes the solution exact, and `compiled.py` says what the multipliers prove.
`problem.py` prints, copies and explains problems.
"""

from .solvers import LP_SOLVERS

__all__ = ["LP_SOLVERS"]
