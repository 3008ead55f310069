"""Solvers that lie, for the tests of what is believed of them."""

import cvxpy as cp
import numpy as np

from frictopt.solve import solvers as policy

HONEST = policy._run


def lying(monkeypatch, lie):
    """Let every optimum pass through `lie(problem, solver)`, which changes values of the problem, or returns what is said in its place."""

    def run(problem, name, *above):
        outcome = HONEST(problem, name, *above)
        return (outcome == cp.OPTIMAL and lie(problem, name)) or outcome

    monkeypatch.setattr(policy, "_run", run)


def sloppy(size):
    """Each variable is off by random numbers of this size."""

    def lie(problem, name):
        rng = np.random.default_rng(0)
        for variable in problem.variables():
            variable.save_value(variable.value + size * rng.normal(size=variable.shape))

    return lie
