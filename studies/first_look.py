"""A first look at the paper's scene: onset, guaranteed and shakedown limit, and the steady state at two loads, in less than a minute.

Run with `python -m studies first_look [--quick]`; it prints a table and draws one picture beside it. All loads are amplitudes of the bulk stress over
the mean pressure, sigma / (P / 2a).
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS, work_unit
from .tables import Row, Study, Table, markdown


@dataclass(frozen=True)
class Parameters:
    """Mesh, friction and loads."""

    elements: int = 124
    friction: float = 0.7
    load_factors: tuple[float, ...] = (1.5, 1.9)


FULL = Parameters()
QUICK = Parameters(elements=16)


def answers(parameters: Parameters) -> Iterator[Row]:
    """One row per question."""
    for question, ask in _questions(parameters):
        start = time.perf_counter()
        value, meaning, residual = ask()
        yield {"question": question, "value": value, "meaning": meaning, "residual": residual, "seconds": time.perf_counter() - start}


def _questions(parameters: Parameters) -> Iterator[tuple[str, Callable[[], tuple[float, str, float]]]]:
    system, friction = fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense(), parameters.friction

    def onset() -> tuple[float, str, float]:
        first = fo.onset(system, LOADS, friction)
        return first.slip.load_factor, f"the bonded contact slips first at x / a = {system.x[first.slip.node] / system.x[-1]:.3g}", first.residual

    lower = fo.GuaranteedModel(system, LOADS)

    def guaranteed() -> tuple[float, str, float]:
        limit = lower.solve(friction)
        zero = "no load is safe from every start: a large residual slip can take all force off the node at the edge"
        return limit.load_factor, "above it slip goes on for ever from some residual slips" if limit.load_factor else zero, limit.residual

    def after_overload() -> tuple[float, str, float]:
        limit = lower.solve(friction).after_overload()
        return limit.load_factor, "the same from slips no larger than one overload leaves", limit.residual

    def shakedown() -> tuple[float, str, float]:
        limit = fo.shakedown_limit(system, LOADS, friction)
        return limit.load_factor, "above it no residual slip is safe with all nodes closed", limit.residual

    yield "onset of slip", onset
    yield "guaranteed limit, lambda_1", guaranteed
    yield "compiling what follows transients", _compile
    yield "lambda_1 after one overload", after_overload
    yield "shakedown limit, lambda_2", shakedown
    for load_factor in parameters.load_factors:
        yield f"work of friction per cycle at load {load_factor:g}, W E* / P^2", partial(_steady, system, friction, load_factor)


def _compile() -> tuple[float, str, float]:
    """A transient of two nodes, so that the times of the others are their own."""
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=2, EA=1.0, h=1.0))
    fo.steady_state(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 0.1)
    return np.nan, "once on a machine: the machine code is kept", 0.0


def _steady(system: fo.ContactSystem, friction: float, load_factor: float) -> tuple[float, str, float]:
    steady = fo.steady_state(system, LOADS, friction, load_factor)
    return steady.dissipation / work_unit(system), f"without initial slip, {steady.outcome.value}", steady.residual


def _summary(tables: Mapping[str, pd.DataFrame]) -> str:
    rows = [
        [row.question, "" if np.isnan(row.value) else f"{row.value:.4g}", row.meaning, f"{row.seconds:.2g} s"]
        for row in tables[ANSWERS.name].itertuples()
    ]
    head = f"A square punch on a half-plane, f = {tables[ANSWERS.name].attrs['parameters']['friction']:g}; loads are sigma / (P / 2a)."
    more = """Next:
python -m studies                            lists the studies
python -m studies dissipation --quick        between the two limits the start decides
python -m paper_figures                      draws all figures (if interrupted, start it again)"""
    return "\n\n".join([head, markdown(["question", "value", "meaning", "time"], rows), more])


def _picture(parameters: Any, folder: Path) -> Path:
    """The contact at its shakedown limit."""
    limit = fo.shakedown_limit(fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense(), LOADS, parameters.friction)
    path = folder / "first_look.png"
    figure = limit.plot().figure
    figure.savefig(path, dpi=200)
    plt.close(figure)
    return path


_COLUMNS = {
    "value": "load factor, or scaled work of friction",
    "meaning": "the answer in words",
}
ANSWERS = Table("first_look", "one question", _COLUMNS, full=FULL, quick=QUICK, compute=answers)

STUDY = Study("studies.first_look", __doc__, "a coarse mesh", (ANSWERS,), _summary, picture=_picture)
