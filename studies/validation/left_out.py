"""Time that `simplify=True` saves in each computation; the answers are the same.

Run with `python -m studies left_out [--quick]`; it prints the times in Markdown. Each time is the
processor time of one call as a user makes it. The call builds and compiles its model; condensation
is not included. Times depend on the machine.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.clock import timed
from studies.paper import LOADS
from studies.progress import each
from studies.tables import Study, Table, markdown, two_digits


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study.

    Attributes
    ----------
    elements, fine
        Numbers of elements of the paper's scene, and of the other scenes.
    underload
        Load factor of the safe slip, relative to the limit.
    corners
        Number of corners of the scenes with many corners.
    repetitions
        Largest number of repetitions of each timing.
    """

    elements: tuple[int, ...] = (40, 124)
    fine: int = 124
    friction: float = 0.7
    underload: float = 0.9
    corners: int = 64
    repetitions: int = 7


FULL = Parameters()
QUICK = Parameters(elements=(8,), fine=60, corners=16, repetitions=0)


@dataclass(frozen=True)
class _Scene:
    """One contact under one load cycle."""

    name: str
    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: Any


def _scenes(parameters: Parameters) -> list[_Scene]:
    """The contacts of the study."""
    mean, f = LOADS.mean, parameters.friction
    systems = {
        elements: fo.scenes.PunchOnHalfPlane(elements=elements).condense()
        for elements in {*parameters.elements, parameters.fine}
    }
    fine = systems[parameters.fine]
    phase = 2 * np.pi * np.arange(parameters.corners) / parameters.corners
    triangle = np.abs(4 * np.arange(parameters.corners) / parameters.corners - 2) - 1
    ellipse = [{"sigma": float(np.cos(angle)), "Q": float(0.05 * np.sin(angle))} for angle in phase]
    slippery = np.where(np.abs(fine.x) < 0.2 * fine.x[-1], 1e-3, f)
    with_shear = replace(LOADS, corners=[{"sigma": -1.0}, {"sigma": 1.0, "Q": 0.05}])
    uncoupled = fo.ContactSystem.from_blocks(fine.A, 0 * fine.B, fine.C, fine.x, fine.bonded)
    sampled = fo.LoadCycle(mean, [{"sigma": float(value)} for value in triangle])
    return [
        *(_Scene("paper", systems[elements], LOADS, f) for elements in parameters.elements),
        _Scene("with shear", fine, with_shear, f),
        _Scene("uncoupled", uncoupled, LOADS, f),
        _Scene("sampled", fine, sampled, f),
        _Scene("ellipse", fine, fo.LoadCycle(mean, ellipse), f),
        _Scene("slippery middle", fine, LOADS, slippery),
    ]


# Computation -> the number of its answer that is compared.
_COMPUTATIONS = {"shakedown limit": "load_factor", "safe slip": "margin"}


def saved(parameters: Parameters) -> pd.DataFrame:
    """One row per scene and computation."""
    runs = [(scene, name) for scene in _scenes(parameters) for name in _COMPUTATIONS]
    with threadpool_limits(1):
        return pd.DataFrame(
            [_row(scene, name, parameters) for scene, name in each(runs, "left out")]
        )


def _row(scene: _Scene, name: str, parameters: Parameters) -> dict[str, Any]:
    """Times and answers of one computation with and without simplification."""
    arguments = scene.system, scene.cycle, scene.friction
    question: Any = partial(fo.shakedown_limit, *arguments)
    if name == "safe slip":
        load_factor = parameters.underload * question().load_factor
        question = partial(fo.safe_slip, *arguments, load_factor)
    lean = timed(partial(question, simplify=True), parameters.repetitions)
    full = timed(partial(question, simplify=False), parameters.repetitions)
    value = float(getattr(lean.answer, _COMPUTATIONS[name]))
    full_value = float(getattr(full.answer, _COMPUTATIONS[name]))
    return {
        "scene": scene.name,
        "nodes": scene.system.nodes,
        "corners": len(scene.cycle.corners),
        "computation": name,
        "seconds_all": full.seconds,
        "seconds": lean.seconds,
        "saved": full.seconds / lean.seconds,
        "difference": abs(value - full_value) / (abs(full_value) or 1.0),
        "residual": max(lean.answer.residual, full.answer.residual),
        "left_out": "; ".join(lean.answer.record.left_out),
    }


def _report(table: pd.DataFrame) -> str:
    """One line for each scene, in Markdown."""
    computations = list(dict.fromkeys(table["computation"]))
    rows = []
    for (scene, nodes), part in table.groupby(["scene", "nodes"], sort=False):
        cells = {row.computation: _milliseconds(row) for row in part.itertuples()}
        rows.append([f"{scene}, N = {nodes}", *(cells.get(name, "") for name in computations)])
    worst = table["difference"].max()
    head = ["processor time in ms: everything kept → left out", *computations]
    return f"\n{markdown(head, rows)}\n\nlargest difference of an answer: {worst:.0e}"


def _milliseconds(row: Any) -> str:
    """Both times of a row as text."""
    if not row.left_out:
        return "nothing left out"
    return f"{two_digits(1e3 * row.seconds_all)} → {two_digits(1e3 * row.seconds)}"


_SAVED = {
    "scene": "'paper': square punch, alternating bulk stress; 'with shear': a shear load in addition, not symmetric; 'uncoupled': B = 0; 'sampled': "
    "the paper's cycle, sampled at many corners; 'ellipse': bulk stress and shear out of phase; "
    "'slippery middle': f = 0.001 on a fifth of it",
    "corners": "corners of the load cycle",
    "computation": "shakedown limit, or safe slip below it",
    "seconds_all": "processor time of one call with simplify=False, one thread, median of the repetitions that 2 s allow, at least one",
    "seconds": "the same with simplify=True",
    "saved": "ratio of the two",
    "difference": "relative difference of the load factor or of the margin",
    "left_out": "what was left out",
}
SAVED = Table(
    "left_out", "one computation on one scene", _SAVED, full=FULL, quick=QUICK, compute=saved
)

STUDY = Study(
    "studies.validation.left_out",
    __doc__,
    "small contacts, each timed once, in seconds",
    (SAVED,),
    lambda tables: _report(tables[SAVED.name]),
)
