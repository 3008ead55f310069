"""Time and memory of condensation, limits and steady states over the number of contact nodes.

Run with `python -m studies size [--quick]`. Each size runs in a new process with one thread. The
memory is the largest memory of this process so far. The plane scene is the scene of the paper; the
scene in space is a square punch. Both scenes are without symmetry and under bulk stress.

Each question is put to a new copy of the contact. So no question uses results of an earlier one, or
computes anything for later ones. The first call of a short question is not timed.
"""

import copy
import resource
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo

from .clock import timed
from .paper import LOADS
from .progress import each
from .tables import Study, Table, markdown, two_digits

_FRICTION = 0.5
_QUESTIONS = (
    "condense",
    "shakedown limit",
    "limit, nothing left out",
    "safe slip",
    "guaranteed limit",
    "steady state below",
    "steady state above",
)
_REPETITIONS = 3  # of questions that take less than two seconds together
# A gigabyte in the units in which the system reports memory.
_IN_MEMORY = 1e9 if sys.platform == "darwin" else 1e6


@dataclass(frozen=True)
class Parameters:
    """Numbers of elements along the contact of the scenes.

    The guaranteed limit and steady states are computed only up to smaller numbers of elements,
    because they take longer.
    """

    plane: tuple[int, ...] = (64, 124, 250, 500, 1000)
    space: tuple[int, ...] = (9, 14, 19, 29, 39, 49)
    plane_guaranteed: int = 1000
    space_guaranteed: int = 29
    plane_transients: int = 250
    space_transients: int = 39


FULL = Parameters()
QUICK = Parameters(
    (8,), (2, 3), plane_guaranteed=8, space_guaranteed=2, plane_transients=8, space_transients=2
)


def times_by_size(parameters: Parameters) -> pd.DataFrame:
    """One row per scene, size and question, each size in a new process."""
    sizes = [("plane", elements) for elements in parameters.plane] + [
        ("space", elements) for elements in parameters.space
    ]
    rows = []
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for scene, elements in each(sizes, "times by size"):
            guaranteed = elements <= getattr(parameters, f"{scene}_guaranteed")
            transients = elements <= getattr(parameters, f"{scene}_transients")
            rows += pool.submit(_answered, scene, elements, guaranteed, transients).result()
    return pd.DataFrame(rows)


def _answered(
    scene: str, elements: int, guaranteed: bool, transients: bool
) -> list[dict[str, Any]]:
    """The rows of one size; a small contact first compiles everything."""
    with threadpool_limits(1):
        _rows(scene, 2, guaranteed, transients)
        return _rows(scene, elements, guaranteed, transients)


def _rows(scene: str, elements: int, guaranteed: bool, transients: bool) -> list[dict[str, Any]]:
    punch = (fo.scenes.PunchOnHalfPlane if scene == "plane" else fo.scenes.SquarePunch)(
        elements=elements
    )
    named = {
        "scene": scene,
        "elements": elements,
        "unknowns": sum(body.mesh.p.size for body in punch.model().bodies.values()),
    }
    rows = list[dict[str, Any]]()

    def asked(question: str, ask: Callable[[], Any]) -> Any:
        run = timed(ask, _REPETITIONS)
        answer = run.answer
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _IN_MEMORY
        cost = {
            "question": question,
            "seconds": run.seconds,
            "memory": memory,
            "residual": getattr(answer, "residual", np.nan),
        }
        rows.append(named | {"nodes": system.nodes if rows else answer.nodes} | cost)
        return answer

    def asked_anew(question: str, ask: Callable[..., Any], *more: float, **options: bool) -> Any:
        """The answer of a contact that has answered nothing before."""
        return asked(question, lambda: ask(copy.copy(system), LOADS, _FRICTION, *more, **options))

    system = asked("condense", punch.condense)
    limit = asked_anew("shakedown limit", fo.shakedown_limit)
    asked_anew("limit, nothing left out", fo.shakedown_limit, simplify=False)
    asked_anew("safe slip", fo.safe_slip, 0.9 * limit.load_factor)
    if guaranteed:
        asked_anew("guaranteed limit", fo.guaranteed_limit)
    if transients:
        for where, ratio in (("below", 0.9), ("above", 1.05)):
            asked_anew(f"steady state {where}", fo.steady_state, ratio * limit.load_factor)
    return rows


_COLUMNS = {
    "scene": '"plane" or "space"',
    "unknowns": "displacements of the bodies",
    "question": f"one of {'; '.join(_QUESTIONS)}: a safe slip at 0.9, steady states at 0.9 and 1.05 times the shakedown limit, without initial slip",
    "memory": "largest memory of the process so far, gigabytes",
}

SIZES = Table(
    "sizes",
    "one question to a contact of one size",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=times_by_size,
    alone=True,
)


def _cell(rows: pd.DataFrame) -> str:
    return (
        f"{two_digits(rows['seconds'].iloc[0])} s, {two_digits(rows['memory'].iloc[0])} GB"
        if len(rows)
        else ""
    )


def _report(tables: Mapping[str, pd.DataFrame]) -> str:
    """One table for the plane and one for space; the last row has the exponents of the times."""
    parts = []
    for scene, rows in tables[SIZES.name].groupby("scene"):
        questions = [question for question in _QUESTIONS if question in set(rows["question"])]
        lines = [
            [
                str(nodes),
                f"{own['unknowns'].iloc[0]:,}",
                *(_cell(own[own["question"] == question]) for question in questions),
            ]
            for nodes, own in rows.groupby("nodes")
        ]
        powers = [_exponent(rows[rows["question"] == question]) for question in questions]
        parts.append(
            markdown(
                [f"N, {scene}", "unknowns", *questions], [*lines, ["exponent of N", "", *powers]]
            )
        )
    return "\n\n".join(parts)


def _exponent(rows: pd.DataFrame) -> str:
    """Exponent of the time in the number of nodes, fitted from a quarter of the largest number on.

    Steady states have no exponent, because the number of their cycles varies.
    """
    nodes, seconds = (rows[name].to_numpy() for name in ("nodes", "seconds"))
    upper = nodes >= nodes.max() / 4
    if upper.sum() < 2 or rows["question"].iloc[0].startswith("steady"):
        return ""
    return two_digits(np.polyfit(np.log(nodes[upper]), np.log(seconds[upper]), 1)[0])


STUDY = Study("studies.size", __doc__, "coarse meshes, in half a minute", (SIZES,), _report)
