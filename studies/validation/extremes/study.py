"""Extreme friction, stiffness, Poisson's ratio, meshes, units, loads and sizes.

Each answer is compared with an independent answer. Run with `python -m studies extremes [--quick]`;
it prints a short table in Markdown. Only the column of seconds depends on the machine.
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
from studies.validation.extremes.cases import probes
from studies.validation.extremes.probes import Answer, Probe, Sizes

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
    punch = fo.scenes.PunchOnHalfPlane(elements=2).condense()
    with threadpool_limits(1):
        # This call compiles the exact path, so that no question is charged for it.
        fo.steady_state(punch, fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}]), 0.5, 1.0)
        rows = [compared(probe) for probe in each(selected(sizes), "extremes")]
    return pd.DataFrame(rows)


def selected(sizes: Sizes) -> list[Probe]:
    """The questions of the study.

    For each extreme they have every n-th value, n being `Sizes.every`, and the last value.
    """
    all_probes = list(probes(sizes))
    values = dict[str, list[str]]()
    for probe in all_probes:
        values_of_extreme = values.setdefault(probe.extreme, [])
        if probe.value not in values_of_extreme:
            values_of_extreme.append(probe.value)
    kept = {extreme: {*names[:: sizes.every], names[-1]} for extreme, names in values.items()}
    return [probe for probe in all_probes if probe.value in kept[probe.extreme]]


def compared(probe: Probe) -> dict[str, Any]:
    """The row of a question: its answer, compared with the reference."""
    row = {"extreme": probe.extreme, "value": probe.value, "question": probe.question}
    start = time.perf_counter()
    try:
        answer = probe.ask()
    except fo.FrictoptError as failure:
        seconds = time.perf_counter() - start
        return (
            row
            | {"verdict": "refused"}
            | asdict(Answer(np.nan, np.nan, ""))
            | {
                "error": np.nan,
                "reference": "",
                "seconds": seconds,
                "message": f"{type(failure).__name__}: {failure}",
            }
        )
    seconds = time.perf_counter() - start
    error = _error(answer.number, probe)
    return (
        row
        | {"verdict": _verdict(error, probe)}
        | asdict(answer)
        | {
            "error": error,
            "reference": "" if np.isnan(error) else probe.reference,
            "seconds": seconds,
            "message": "",
        }
    )


def _verdict(error: float, probe: Probe) -> str:
    """The verdict on an answer with a relative error."""
    if np.isnan(error):
        return "unchecked"
    if np.isinf(probe.tolerance):
        return "mesh"
    return "right" if error <= probe.tolerance else "wrong"


def _error(number: float, probe: Probe) -> float:
    """Relative error of an answer; NaN if the reference has no answer."""
    try:
        expected = None if probe.expected is None else probe.expected()
    except fo.FrictoptError:
        # The reference refuses.
        expected = None
    if expected is None:
        return float("nan")
    if np.isfinite(number) and np.isfinite(expected):
        return abs(number - expected) / max(abs(expected), probe.floor)
    equal = number == expected or (np.isnan(number) and np.isnan(expected))
    return 0.0 if equal else float("inf")


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
    "studies.validation.extremes",
    __doc__,
    "coarse meshes, in seconds",
    (EXTREMES,),
    summary=lambda tables: short(tables[EXTREMES.name]),
)
