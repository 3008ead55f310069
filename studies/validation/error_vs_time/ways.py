"""What is compared: questions, the ways to answer each, and which of these no other one beats."""

import importlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import frictopt as fo

from .clock import timed

__all__ = ["EPSILON", "RIVALS", "ROUNDING", "Question", "Way", "absent", "installed", "measured", "not_dominated"]

EPSILON = float(np.finfo(float).eps)
"""Least error that is reported."""

ROUNDING = 1e-12
"""Errors below it count as equal: condensation leaves some 1e-13 in the stiffness, so that of two smaller ones neither is better."""

RIVALS = ("highspy", "clarabel", "osqp", "daqp", "quantecon", "scipy")
"""Packages whose bare calls are measured in the same run, where they are installed."""


@dataclass(frozen=True)
class Way:
    """One way to answer a question, at one setting of its own accuracy.

    Attributes
    ----------
    method
        What answers.
    knob, setting
        What decides on its accuracy, and how that is set.
    run
        What is timed.
    error
        Relative error of what `run` gives.
    residual
        What the package itself says of its answer; None of what nobody judges.
    rival
        Package whose bare call it is; empty for frictopt.
    """

    method: str
    knob: str
    setting: str
    run: Callable[[], Any]
    error: Callable[[Any], float]
    residual: Callable[[Any], float] | None = None
    rival: str = ""


@dataclass(frozen=True)
class Question:
    """The same work for all ways: their errors and run times are compared.

    Attributes
    ----------
    computation
        Which of the package's computations.
    quantity
        Whose error counts.
    scene
        On what.
    nodes
        Node pairs of the interface, 0 where the ways differ in it.
    reference
        What the errors are measured against.
    ways
        The ways to answer.
    """

    computation: str
    quantity: str
    scene: str
    nodes: int
    reference: str
    ways: Sequence[Way]


@cache
def installed(name: str) -> Any:
    """The package of that name, None if it is not installed."""
    try:
        return importlib.import_module({"quantecon": "quantecon.optimize"}.get(name, name))
    except ImportError:
        return None


def measured(question: Question, repetitions: int) -> list[dict[str, Any]]:
    """One row per way whose package is installed: its error, its run time, and whether no other way beats it."""
    rows = []
    for way in question.ways:
        if way.rival and installed(way.rival) is None:
            continue
        rows.append(_row(question, way, repetitions))
    front = not_dominated(np.array([row["seconds"] for row in rows]), np.array([max(row["error"], ROUNDING) for row in rows]))
    for row, on_front in zip(rows, front, strict=True):
        row["on_front"] = bool(on_front)
        row["ahead"] = bool(on_front and row["rival"])
    return rows


def not_dominated(seconds: np.ndarray[Any, Any], error: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """(n,) which answers no other one beats: none is as fast and as accurate and better in one of the two.

    Of equals the first one counts; what gives no answer (inf) is never one of them.
    """
    order = np.lexsort((error, seconds))
    front, best = np.zeros(len(order), dtype=bool), np.inf
    for index in order:
        front[index] = error[index] < best
        best = min(best, error[index])
    return front


def _row(question: Question, way: Way, repetitions: int) -> dict[str, Any]:
    named = {
        "computation": question.computation,
        "quantity": question.quantity,
        "scene": question.scene,
        "nodes": question.nodes,
        "reference": question.reference,
        "method": way.method,
        "rival": way.rival,
        "knob": way.knob,
        "setting": way.setting,
    }
    try:
        run = timed(way.run, repetitions)
        error = float(way.error(run.answer))
        if not np.isfinite(error):
            raise ArithmeticError("the answer is not finite")
    except (fo.FrictoptError, ArithmeticError) as failure:
        none = {"error": np.inf, "residual": np.nan, "seconds": np.inf, "repetitions": 0}
        return {**named, "outcome": f"{type(failure).__name__}: {failure}", **none}
    return {
        **named,
        "outcome": "answer",
        "error": max(error, EPSILON),
        "residual": way.residual(run.answer) if way.residual else np.nan,
        "seconds": run.seconds,
        "repetitions": run.repetitions,
    }


def absent(names: Iterable[str] = RIVALS) -> Iterator[str]:
    """Rivals that are not installed."""
    yield from (name for name in names if installed(name) is None)
