"""Error against run time: questions, their methods, and the methods that no other method beats."""

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import frictopt as fo
from studies.clock import timed

EPSILON = float(np.finfo(float).eps)
"""Smallest error that is reported."""

ROUNDING = 1e-12
"""Errors below this value count as equal, because condensation leaves errors of about 1e-13."""

RIVALS = ("highspy", "clarabel", "osqp", "quantecon", "scipy", "cvxpy")
"""Packages whose bare calls are measured in the same run, if they are installed."""


@dataclass(frozen=True)
class Method:
    """One method to answer a question, with one setting of its accuracy.

    Attributes
    ----------
    name
        Name of the method.
    knob, setting
        The parameter that controls its accuracy, and its value.
    run
        The function that is timed.
    error
        Relative error of the result of `run`.
    rival
        Package that is called directly; empty for frictopt.
    """

    name: str
    knob: str
    setting: str
    run: Callable[[], Any]
    error: Callable[[Any], float]
    rival: str = ""


@dataclass(frozen=True)
class Question:
    """One question that all methods answer: their errors and run times are compared.

    Attributes
    ----------
    computation
        Name of the computation.
    quantity
        Quantity whose error is measured.
    scene
        Name of the scene.
    nodes
        Node pairs of the interface, 0 if the methods use different numbers.
    methods
        The methods.
    """

    computation: str
    quantity: str
    scene: str
    nodes: int
    methods: Sequence[Method]


def relative(exact: float, value: Callable[[Any], float]) -> Callable[[Any], float]:
    """A function that returns the relative error of a number of an answer."""
    return lambda made: abs(value(made) / exact - 1)


@cache
def installed(name: str) -> Any:
    """The package of a name; None if it is not installed."""
    try:
        return importlib.import_module({"quantecon": "quantecon.optimize"}.get(name, name))
    except ImportError:
        return None


def measured(question: Question, repetitions: int) -> list[dict[str, Any]]:
    """One row per method whose package is installed.

    A row has the error, the run time, and whether no other method beats it.
    """
    rows = [
        _row(question, method, repetitions)
        for method in question.methods
        if not method.rival or installed(method.rival)
    ]
    front = not_dominated(
        np.array([row["seconds"] for row in rows]),
        np.array([max(row["error"], ROUNDING) for row in rows]),
    )
    for row, on_front in zip(rows, front, strict=True):
        row["on_front"] = bool(on_front)
        row["ahead"] = bool(on_front and row["rival"])
    return rows


def not_dominated(
    seconds: np.ndarray[Any, Any], error: np.ndarray[Any, Any]
) -> np.ndarray[Any, Any]:
    """(n,) for each answer, whether no other answer beats it.

    An answer beats another one if it is at least as fast and as accurate, and better in one of the
    two. Of equal answers only the first one is kept. A method without an answer (inf) is never
    kept.
    """
    order = np.lexsort((error, seconds))
    front, best = np.zeros(len(order), dtype=bool), np.inf
    for index in order:
        front[index] = error[index] < best
        best = min(best, error[index])
    return front


def _row(question: Question, method: Method, repetitions: int) -> dict[str, Any]:
    """The row of a method: its answer, or its error."""
    named = {
        name: getattr(question, name) for name in ("computation", "quantity", "scene", "nodes")
    }
    named |= {"method": method.name} | {
        name: getattr(method, name) for name in ("rival", "knob", "setting")
    }
    try:
        run = timed(method.run, repetitions)
        error = float(method.error(run.answer))
        if not np.isfinite(error):
            raise ArithmeticError("the answer is not finite")
    except (fo.FrictoptError, ArithmeticError) as failure:
        none = {"error": np.inf, "residual": np.nan, "seconds": np.inf, "repetitions": 0}
        return {**named, "result": f"{type(failure).__name__}: {failure}", **none}
    return {
        **named,
        "result": "answer",
        "error": max(error, EPSILON),
        "residual": getattr(run.answer, "residual", np.nan),
        "seconds": run.seconds,
        "repetitions": run.repetitions,
    }


def absent() -> list[str]:
    """Rivals that are not installed."""
    return [name for name in RIVALS if installed(name) is None]
