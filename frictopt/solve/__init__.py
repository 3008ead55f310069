"""Optimisation programs as arrays: their optima, and proofs that there is no optimum.

Nothing here knows what a contact is. A program is `min cost @ x` over all x whose slacks
`right - sparse @ [x, block @ x]` are zero, at least zero, or in second-order cones. An answer is x
with multipliers y in the dual cones. A is the matrix with `A x = sparse @ [x, block @ x]`. If
`A'y + cost` vanishes, the multipliers prove `cost @ x >= -right @ y` for every x (weak duality).
Rounding leaves a remainder of `A'y + cost`. The error of the bound is what this remainder adds for
x of the size of its units.

`answer.py`
    The answer of the first solver that passes the checks, and proofs that there is no optimum.
`arrays.py`
    A program, its dual, its exact solution near a rough one (`polish`), and rows made of entries.
`products.py`
    Cones that are products of two factors, scaled so that both have the same size.
`solvers.py`
    Solvers, their order and options.
`interior_point.py`, `condensed.py`, `step_equations.py`
    The interior-point method of frictopt, for large cone programs.
`problem.py`, `explained.py`
    cvxpy problems that can be copied, pickled and printed with the names of their parts.
`by_cvxpy.py`
    Problems that cvxpy itself compiles and solves.
"""

from .solvers import LP_SOLVERS

__all__ = ["LP_SOLVERS"]
