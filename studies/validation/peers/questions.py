"""Quantities of a contact, and the ways in which frictopt, its solvers and peers compute them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import frictopt as fo
from studies.clock import timed
from studies.validation.error_vs_time.methods import EPSILON, ROUNDING, Method, installed
from studies.validation.peers.programs import NoAnswer, Peer, Pythons

OURS = "frictopt"
# Ratio up to which two errors count as equal.
_EQUAL = 1.01


@dataclass(frozen=True)
class Asked:
    """One way of a peer to answer.

    Attributes
    ----------
    peer
        The code.
    method
        Its method.
    setting
        The discretisation and the tolerance.
    question
        What its program reads.
    error
        Relative error of the answer of its program.
    """

    peer: Peer
    method: str
    setting: str
    question: Mapping[str, Any]
    error: Callable[[Mapping[str, Any]], float]


@dataclass(frozen=True)
class Contact:
    """One contact and quantity, with all ways to compute the quantity.

    Attributes
    ----------
    name, quantity
        The contact, and the quantity whose error is measured.
    reference
        Source of the right value.
    ours
        Answers in this process, by frictopt and by packages that the methods name.
    peers
        Answers of other codes.
    """

    name: str
    quantity: str
    reference: str
    ours: Sequence[Method]
    peers: Sequence[Asked] = ()


def answered(
    contact: Contact, pythons: Pythons, repetitions: int, seconds: float
) -> list[dict[str, Any]]:
    """One row for each way: its error, its time, and the time of frictopt for the same accuracy."""
    named = {"contact": contact.name, "quantity": contact.quantity, "reference": contact.reference}
    rows = [
        named | _in_this_process(method, repetitions)
        for method in contact.ours
        if not method.rival or installed(method.rival)
    ]
    rows += [named | _by_peer(asked, pythons, seconds) for asked in contact.peers]
    ours = [row for row in rows if row["code"] == OURS]
    for row in rows:
        row["ours"] = np.nan if row["code"] == OURS else seconds_of_ours(ours, row["error"])
        row["residual"] = 0.0
    return rows


def seconds_of_ours(ours: Sequence[Mapping[str, Any]], error: float) -> float:
    """Time of the fastest answer of frictopt whose error is no larger; inf if there is none.

    Errors below `ROUNDING` count as equal. So do errors that differ by less than 1 %, because both
    codes then have the same discretisation.
    """
    enough = [row["seconds"] for row in ours if row["error"] <= max(_EQUAL * error, ROUNDING)]
    return float(min(enough, default=np.inf))


def _in_this_process(method: Method, repetitions: int) -> dict[str, Any]:
    """The result of a method in this process."""
    setting = method.setting if method.knob == "none" else f"{method.knob} {method.setting}"
    row = {
        "code": method.rival or OURS,
        "method": method.name.removeprefix("frictopt").lstrip(", "),
        "setting": setting,
    }
    try:
        run = timed(method.run, repetitions)
        error = float(method.error(run.answer))
    except (fo.FrictoptError, ArithmeticError) as failure:
        return row | _failed(str(failure))
    return row | {"result": "answer", "error": max(error, EPSILON), "seconds": run.seconds}


def _by_peer(asked: Asked, pythons: Pythons, seconds: float) -> dict[str, Any]:
    """The result of a way of a peer."""
    row = {"code": asked.peer.name, "method": asked.method, "setting": asked.setting}
    try:
        answer = pythons.answer(asked.peer, asked.question, seconds)
    except NoAnswer as reason:
        return row | _failed(str(reason))
    error = max(float(asked.error(answer)), EPSILON)
    return row | {"result": "answer", "error": error, "seconds": answer["seconds"]}


def _failed(reason: str) -> dict[str, Any]:
    """The result of a way without an answer."""
    return {"result": reason, "error": np.inf, "seconds": np.nan}
