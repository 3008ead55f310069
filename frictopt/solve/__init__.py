"""Programs as arrays: their answers, and proofs that there is none. This room knows no contact.

A program is `min cost @ x` over the x whose slacks `right - sparse @ [x, block @ x]` are zero, at
least zero, or in second-order cones. Out come x and multipliers y in the dual cones. By weak
duality they prove `cost @ x >= -right @ y` for every x, up to what `A'y + cost`, which should
vanish, adds for x of the size of its units.

`answer.py`
    The first solver's answer that passes its check, and proofs that there is none.
`arrays.py`
    A program, its dual, its exact solution next to a rough one (`polish`), and its rows by entries.
`products.py`
    Products whose factors differ in size.
`solvers.py`
    Solvers, their order and options.
`interior_point.py`, `condensed.py`, `step_equations.py`
    An interior point of our own for large cone programs.
`problem.py`, `explained.py`
    cvxpy problems that can be copied, pickled and printed by the names of their parts.
`by_cvxpy.py`
    Problems that cvxpy solves as they stand.
"""

from .solvers import LP_SOLVERS

__all__ = ["LP_SOLVERS"]
