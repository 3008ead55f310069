"""A random tenth of the dissipation study, repeated in increments: this engine shares only the contact law with the exact path.

Run with `python -m studies stepped [--quick] [--workers 2]`. Increments err at first order in their number. Overloads are not repeated.
"""

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

import frictopt as fo

from . import dissipation
from .paper import LOADS, work_unit
from .tables import Study, Table, at_least_one

__all__ = ["FULL", "QUICK", "RERUNS", "STUDY", "Parameters"]


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    runs: dissipation.Parameters = dissipation.FULL
    share: float = 0.1  # of the runs
    seed: int = 1
    steps: tuple[int, ...] = (5, 10, 20)  # increments from corner to corner
    cycles: int = 2


FULL = Parameters()
QUICK = Parameters(runs=dissipation.QUICK)


def reruns(parameters: Parameters, workers: int = 1) -> pd.DataFrame:
    """One row for each chosen run and number of increments."""
    runs = dissipation.runs_of(parameters.runs, workers=workers)
    runs = runs[(runs["family"] != "overload") & (runs["outcome"] != "FAILED")]
    chosen = runs.sample(frac=parameters.share, random_state=parameters.seed).sort_index()
    cases = {case.friction: case for case in dissipation.cases_of(parameters.runs)}
    tasks = [_task(parameters.runs, cases[row["friction"]], row) for row in chosen.to_dict("records")]
    compared = partial(_compared, next(iter(cases.values())).system, parameters.steps, parameters.cycles)
    with ExitStack() as stack:
        done: Iterable[pd.DataFrame]
        if workers == 1:
            stack.enter_context(threadpool_limits(1))
            done = map(compared, tasks)
        else:
            pool = stack.enter_context(ProcessPoolExecutor(workers, get_context("spawn"), threadpool_limits, (1,)))
            done = pool.map(compared, tasks, chunksize=4)
        return pd.concat(tqdm(done, total=len(tasks), desc="runs in increments", disable=None))[list(_RERUN)]


def _task(runs: dissipation.Parameters, case: dissipation.Case, row: dict[str, Any]) -> tuple[dict[str, Any], Any]:
    """A run with its residual slip."""
    start = next(start for start in dissipation.starts_of(runs, case, row["load_factor"]) if start.name == row["start"])
    return row, start.slip_at(case.system, LOADS, case.friction, row["load_factor"])


def _compared(system: fo.ContactSystem, steps: tuple[int, ...], cycles: int, task: tuple[dict[str, Any], Any]) -> pd.DataFrame:
    """One run by the exact path and in increments."""
    row, slip = task
    march = partial(fo.march, system, LOADS, row["friction"], row["load_factor"], initial_slip=slip, cycles=cycles)
    exact = march().cycle_work.sum(axis=1) / work_unit(system)
    same = {name: row[name] for name in ("friction", "load_ratio", "start", "dissipation_scaled")}
    parts = []
    for number in steps:
        stepped = march(engine="qp", steps=number)
        work = stepped.cycle_work.sum(axis=1) / work_unit(system)
        columns = {"steps": number, "cycle": np.arange(1, cycles + 1), "work": exact, "stepped": work, "error": np.abs(work - exact)}
        parts.append(pd.DataFrame(columns).assign(residual=stepped.residual, **same))
    return pd.concat(parts)


def _convergence(tables: Any) -> str:
    """Errors against the number of increments."""
    table = tables[RERUNS.name]
    errors = table.pivot_table(index=["friction", "load_ratio", "start", "cycle"], columns="steps", values="error")
    work = table.groupby(["friction", "load_ratio", "start", "cycle"])["work"].first()
    slid = work > 1e-12  # cycles without slip have nothing to compare
    shown = errors[slid].div(work[slid], axis=0).quantile([0.5, 0.9, 1.0]).rename_axis("error / work, quantile")
    return (
        f"{int(slid.sum())} cycles with slip\n{shown.to_string(float_format='{:.2e}'.format)}\nlargest error without: {errors[~slid].max().max():.1e}"
    )


_RERUN = {name: dissipation.RUNS.columns[name] for name in ("friction", "load_ratio", "start", "dissipation_scaled")} | {
    "cycle": "number of the cycle, from 1",
    "work": "work of friction in that cycle by the exact path, over P^2 / E*",
    "steps": "increments from corner to corner",
    "stepped": "the same work in increments",
    "error": "their distance",
    "residual": "worst violation of the contact law over all increments",
}

RERUNS = Table(
    "dissipation_stepped",
    "one cycle of one run in increments",
    _RERUN,
    full=FULL,
    quick=QUICK,
    compute=reruns,
    options={"workers": {"type": at_least_one, "default": 1, "metavar": "N", "help": "processes; by default this one alone"}},
)

STUDY = Study("studies.stepped", __doc__, "few runs on a coarse mesh", (RERUNS,), summary=_convergence)
