"""The printed problem of the load factor at which contact forces balance a corner."""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from ..base import Array
from ..contact import contact_law
from ..solve.problem import set_no_optimum, set_optimal
from . import models
from .corner_statics import CornerQuestion


def corner_problem(asked: CornerQuestion, load_factor: float, forces: Array) -> cp.Problem:
    """The problem of a corner, with its load factor and the forces (M,) that balance it."""
    question = asked.question
    system = question.system
    name = f"r0[{asked.corner}]" if question.fixed else "r0"
    load = {name: asked.r0, f"r1[{asked.corner}]": asked.r1}
    f = models.friction(question.friction)
    law = contact_law(system, question.friction)
    goal = cp.Maximize if asked.sense > 0 else cp.Minimize
    problem = models.gross_slip(asked.N, load, f, law, system.slip_shape, goal)
    if not np.isfinite(forces).all():
        set_no_optimum(problem, cp.INFEASIBLE if np.isnan(load_factor) else cp.UNBOUNDED)
        return problem
    n = system.nodes
    values = {
        "load_factor": np.array(load_factor),
        "q": forces[:-n].reshape(system.slip_shape, order="F"),
        "p": forces[-n:],
    }
    for variable in problem.variables():
        variable.save_value(values[variable.name()])
    set_optimal(problem)
    return problem
