"""What happens at the edge: extreme friction, stiffness, Poisson's ratio, meshes, units, loads and sizes, each against an answer from elsewhere.

Run with `python -m studies extremes [--quick]`; it prints a short table in Markdown. Only the
column of seconds depends on the machine.
"""

import time
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.progress import each
from studies.tables import Study, Table, markdown
from validation.extremes.cases import probes
from validation.extremes.probes import Answer, Probe, Sizes

FULL = Sizes()
QUICK = Sizes(
    elements=8,
    unit_elements=4,
    most_nodes=(2, 4, 8),
    gradings=(1.0, 1e6, 1e9),
    corners=100,
    cycles=1000,
    every=2,
)


def at_the_edge(sizes: Sizes) -> pd.DataFrame:
    """One row per question."""
    with threadpool_limits(1):
        fo.steady_state(
            fo.scenes.PunchOnHalfPlane(elements=2).condense(),
            fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}]),
            0.5,
            1.0,
        )  # compiles the path
        rows = [judged(probe) for probe in each(asked(sizes), "extremes")]
    return pd.DataFrame(rows)


def asked(sizes: Sizes) -> list[Probe]:
    """The questions of the study: of each extreme those about every so many values, and about the last one."""
    found, values = list(probes(sizes)), dict[str, dict[str, None]]()
    for probe in found:
        values.setdefault(probe.extreme, {})[probe.value] = None  # each once, in their order
    kept = {extreme: {*[*each][:: sizes.every], [*each][-1]} for extreme, each in values.items()}
    return [probe for probe in found if probe.value in kept[probe.extreme]]


def judged(probe: Probe) -> dict[str, Any]:
    """Ask one question: its row of the table."""
    row = {"extreme": probe.extreme, "value": probe.value, "question": probe.question}
    start = time.perf_counter()
    try:
        answer = probe.ask()
    except fo.FrictoptError as error:
        seconds = time.perf_counter() - start
        nothing = asdict(Answer(np.nan, np.nan, "")) | {
            "error": np.nan,
            "reference": "",
            "seconds": seconds,
        }
        return row | {
            "verdict": "refused",
            **nothing,
            "message": f"{type(error).__name__}: {error}",
        }
    seconds = time.perf_counter() - start
    off = _error(answer.number, probe)
    known = {
        "error": off,
        "reference": "" if np.isnan(off) else probe.reference,
        "seconds": seconds,
        "message": "",
    }
    verdict = (
        "unchecked"
        if np.isnan(off)
        else "mesh"
        if np.isinf(probe.tolerance)
        else "right"
        if off <= probe.tolerance
        else "wrong"
    )
    return row | {"verdict": verdict} | asdict(answer) | known


def _error(found: float, probe: Probe) -> float:
    """Relative error of an answer; NaN where nothing is known of it."""
    try:
        expected = None if probe.expected is None else probe.expected()
    except fo.FrictoptError:  # the reference refuses
        expected = None
    if expected is None:
        return float("nan")
    if not (np.isfinite(found) and np.isfinite(expected)):
        return (
            0.0 if found == expected or (np.isnan(found) and np.isnan(expected)) else float("inf")
        )
    return abs(found - expected) / max(abs(expected), probe.floor)


def short(table: pd.DataFrame) -> str:
    """Short form of the table in Markdown: one line for each extreme."""
    verdicts = ("right", "mesh", "unchecked", "refused", "wrong")
    lines = []
    for extreme, rows in table.groupby("extreme", sort=False):
        answered = rows[rows["verdict"] != "refused"]
        values = list(dict.fromkeys(rows["value"]))
        counts = [str(int((rows["verdict"] == verdict).sum())) for verdict in verdicts]
        worst = [
            f"{answered['residual'].max():.0e}",
            f"{answered['error'].max():.0e}",
            f"{rows['seconds'].max():.2g} s",
        ]
        lines.append(
            [extreme, " to ".join(dict.fromkeys([values[0], values[-1]])), *counts, *worst]
        )
    return markdown(
        ["extreme", "range", *verdicts, "worst residual", "worst error", "slowest"], lines
    )


_COLUMNS = {
    "extreme": "the extreme quantity",
    "value": "its value",
    "verdict": "'right': agrees with the reference; 'mesh': agrees within the error of the mesh, which is shown; 'unchecked': no reference; "
    "'refused': an error of frictopt, with its message; 'wrong': must not occur",
    "number": "the answer: a load factor, work of friction per cycle (force times length), 1 or 0 for yes or no, a force over the mean one",
    "solver": "solver of the answer",
    "error": "relative difference from the reference",
    "reference": "source of the reference",
    "message": "message of the error",
}

EXTREMES = Table(
    "extremes", "one question at one extreme", _COLUMNS, full=FULL, quick=QUICK, compute=at_the_edge
)

STUDY = Study(
    "validation.extremes",
    __doc__,
    "coarse meshes, in seconds",
    (EXTREMES,),
    summary=lambda tables: short(tables[EXTREMES.name]),
)
