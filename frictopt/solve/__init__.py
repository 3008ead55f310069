"""From a cvxpy problem to its answer and its proof. This room knows no contact.

In comes a cvxpy problem with the units of its unknowns: a linear program, or one with second-order
cones. Compiled it reads `min c'z` over the z with `s = b - A z` in cones K. Out come values z and
multipliers y in the dual cones. By weak duality they prove `c'z >= -b'y` for every z, up to what
`A'y + c`, which should vanish, adds for z of the size of its units.

`chain.py`
    The way of a problem to its answer, and proofs that there is none.
`compiled.py`
    The problem as cvxpy compiles it, what multipliers prove, and changes of variables.
`unresisted.py`
    Null vectors of a stiffness and its inverse, for these changes.
`reduced.py`
    The reduction as a list of steps, each with a way back (`program.py`).
`eliminated.py`, `redundant.py`, `dense.py`, `scaled.py`
    The steps: unknowns that follow from others, redundant rows, dense equations, units.
`arrays.py`
    The reduced program, and its exact solution next to a rough one (`polish`).
`flipped.py`
    The dual, where it is smaller.
`solvers.py`
    Solvers, their order and options.
`interior_point.py`, `condensed.py`, `cones.py`, `step_equations.py`
    An interior point of our own for large cone programs.
`problem.py`
    Problems that can be copied, pickled and printed by the names of their parts.
"""

from .solvers import LP_SOLVERS

__all__ = ["LP_SOLVERS"]
