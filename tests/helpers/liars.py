"""Solvers with wrong answers, for tests of the checks of answers."""

from contextlib import contextmanager
from dataclasses import replace
from functools import wraps

import cvxpy as cp
import numpy as np
import pytest
from scipy.optimize import nnls

import frictopt as fo
from frictopt.errors import SolverError
from frictopt.limits.printed import last_resort
from frictopt.solve import answer, by_cvxpy
from frictopt.solve.solvers import OPTIMAL

HONEST, TOLD, BY_CVXPY = answer.run, answer._solutions, by_cvxpy._run


def lying(monkeypatch, lie, plain=False):
    """Let every optimum of a program of arrays pass through `lie(program, solver, x, y)`.

    `lie` returns None, other x and multipliers instead, or a status. With `plain`, plain cvxpy may
    answer as the last resort.
    """
    if not plain:
        without_plain_cvxpy(monkeypatch)

    def run(program, name, above):
        status, x, y = HONEST(program, name, above)
        said = lie(program, name, x, y) if status == OPTIMAL else None
        return (
            (said, x, y)
            if isinstance(said, str)
            else (status, *said)
            if said is not None
            else (status, x, y)
        )

    monkeypatch.setattr(answer, "run", run)


@contextmanager
def instead(name, ask, of=fo):
    """Let `ask` answer in the place of a public question."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(of, name, wraps(getattr(of, name))(ask))
        yield


@contextmanager
def told(name, lie, of=fo, where=lambda *_: True):
    """Let each answer of a public question pass through `lie`, where the contact is like that."""
    honest = getattr(of, name)

    def ask(*args, **options):
        answer = honest(*args, **options)
        return lie(answer) if where(*args) else answer

    with instead(name, ask, of):
        yield


def changed(**changes):
    """A lie that changes fields of an answer, each by a function of its value."""
    return lambda answer: replace(
        answer, **{name: change(getattr(answer, name)) for name, change in changes.items()}
    )


def without_plain_cvxpy(monkeypatch):
    """Let plain cvxpy find nothing as the last resort."""

    def nothing(problem, residual):
        raise SolverError("nothing")

    monkeypatch.setattr(last_resort, "solve", nothing)


def misread(monkeypatch, lie):
    """Let every answer pass through `lie(program, x, y)`, which changes it, and no polish repairs it."""
    without_plain_cvxpy(monkeypatch)

    def solutions(form, x, y):
        for outcome, (found, multipliers) in TOLD(form, x, y):
            found, multipliers = found.copy(), multipliers.copy()
            lie(form.arrays, found, multipliers)
            yield outcome, (found, multipliers)

    monkeypatch.setattr(answer, "_solutions", solutions)


def lying_by_cvxpy(monkeypatch, lie):
    """Let every optimum of a cvxpy problem pass through `lie(problem, solver)`.

    `lie` changes its values, or returns a status instead.
    """

    def run(problem, name):
        outcome = BY_CVXPY(problem, name)
        is_optimal = outcome in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)
        return (is_optimal and lie(problem, name)) or outcome

    monkeypatch.setattr(by_cvxpy, "_run", run)


def sloppy(size):
    """A lie that changes each unknown by a random number of this size."""
    return lambda program, name, x, y: (x + size * np.random.default_rng(0).normal(size=len(x)), y)


def is_excess(program):
    """Whether a program minimises only the excess that proves that another program has no optimum."""
    return program.zero == 0 and bool(program.cost[-1] == 1) and not program.cost[:-1].any()


def unpolished(monkeypatch):
    """Leave answers without polish, with multipliers in their cones."""
    for place in (answer, last_resort):
        monkeypatch.setattr(place, "polish", lambda program, x, y: (x, program.admissible(y)))


def persuasive(program, x):
    """Multipliers in their cones with the least imbalance, for an x that is no optimum.

    Their work equals the work of this x. The program is linear.
    """
    matrix, zero, heavy = program.matrix, program.zero, 1e6
    # Multipliers of equations have both signs.
    rows = np.hstack([matrix.T, -matrix[:zero].T])
    work = np.r_[program.right, -program.right[:zero]]
    size = max(abs(work).max(), 1e-300)
    y = nnls(
        np.vstack([rows, heavy * work / size]),
        np.r_[-program.cost, -heavy * (program.cost @ x) / size],
    )[0]
    return np.r_[y[:zero] - y[len(program.right) :], y[zero : len(program.right)]]
