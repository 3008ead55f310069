"""A campaign of many transients on a dask cluster of this machine, where one worker is killed.

Run with `python -m studies campaign [--quick]` (extra `distributed`). It prints how many runs of
the campaign are lost, and the share of the workers' time that the transients take. Some runs are
repeated in this process and compared. The contact is the scene of Flicek et al. (2015), with random
residual slips at loads around its shakedown limit.
"""

import os
import signal
import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from studies.paper import LOADS
from studies.tables import Study, Table, markdown, two_digits

_FRICTION = 0.5


@dataclass(frozen=True)
class Parameters:
    """Size of the campaign."""

    # Number of elements along the contact.
    elements: int = 124
    load_factors: int = 20
    starts: int = 500
    workers: int = 2
    # Number of ended tasks after which a worker is killed.
    killed_after: int = 80
    # One start in this many is repeated in this process.
    repeated: int = 50
    seed: int = 0


FULL = Parameters()
QUICK = Parameters(elements=8, load_factors=4, starts=5, killed_after=3, repeated=2)


class Killing(Executor):
    """An executor that calls a function once, after a number of its tasks have ended."""

    def __init__(self, executor: Executor, after: int, kill: Callable[[], None]) -> None:
        self._executor = executor
        self._left = after
        self._kill = kill

    def submit(self, *task: Any, **options: Any) -> Future[Any]:
        """Submit a task to the executor."""
        future = self._executor.submit(*task, **options)
        future.add_done_callback(self._count)
        return future

    def _count(self, _ended: Future[Any]) -> None:
        self._left -= 1
        if self._left == 0:
            self._kill()


def campaign(parameters: Parameters) -> pd.DataFrame:
    """One row: the campaign on a cluster where one worker is killed."""
    # An optional package, which the list of studies does not need.
    from distributed import Client, LocalCluster

    system = fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense()
    limit = fo.shakedown_limit(system, LOADS, _FRICTION)
    load_factors = limit.load_factor * np.linspace(0.5, 1.5, parameters.load_factors)
    starts = fo.starts.given_slips(_slips(limit, parameters))
    asked = system, LOADS, _FRICTION, load_factors

    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(
            n_workers=parameters.workers, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        victim = min(client.run(os.getpid).values())
        executor = Killing(
            client.get_executor(),
            parameters.killed_after,
            lambda: os.kill(victim, signal.SIGKILL),
        )
        began = time.perf_counter()
        table = fo.dissipation_study(
            *asked, starts, executor=executor, store=Path(folder) / "runs.sqlite"
        )
        seconds = time.perf_counter() - began
        killed = victim not in client.run(os.getpid).values()

    repeated = fo.dissipation_study(*asked, starts[:: parameters.repeated])
    return pd.DataFrame(
        {
            "nodes": [system.nodes],
            "runs": len(load_factors) * len(starts),
            "killed": int(killed),
            "lost": len(load_factors) * len(starts) - int((table["error"] == "").sum()),
            "repeated": len(repeated),
            "different": _different(table, repeated),
            "seconds": seconds,
            "busy": table["seconds"].sum() / (seconds * parameters.workers),
            "run_seconds": table["seconds"].mean(),
            "alone_seconds": repeated["seconds"].mean(),
            "residual": table["residual"].max(),
        }
    )


def _slips(limit: fo.results.ShakedownLimit, parameters: Parameters) -> np.ndarray:
    """Random residual slips, from a tenth of the safe slip to ten times the safe slip."""
    rng = np.random.default_rng(parameters.seed)
    sizes = 10 ** rng.uniform(-1, 1, (parameters.starts, 1)) * np.abs(limit.slip).max()
    return np.asarray(sizes * rng.normal(size=(parameters.starts, len(limit.slip))))


def _different(table: pd.DataFrame, repeated: pd.DataFrame) -> int:
    """Number of repeated runs whose results differ in any bit."""
    place = ["load_factor", "start"]
    rows = table.set_index(place).loc[repeated.set_index(place).index].drop(columns="seconds")
    again = repeated.set_index(place).drop(columns="seconds")
    same = (rows == again) | (rows.isna() & again.isna())
    return int((~same.all(axis=1)).sum())


_COLUMNS = {
    "runs": "transients",
    "killed": "workers killed",
    "lost": "transients without a result",
    "repeated": "transients that were repeated in this process",
    "different": "repeated transients with another result",
    "busy": "time of all transients, over the time of the campaign times the workers",
    "run_seconds": "mean time of a transient, s",
    "alone_seconds": "the same in one process, s",
}
CAMPAIGN = Table(
    "campaign",
    "one campaign",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=campaign,
    alone=True,
)


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """The campaign, in Markdown."""
    rows = [
        [
            f"{row.runs:,}",
            str(row.nodes),
            str(row.killed),
            str(row.lost),
            f"{row.different} of {row.repeated}",
            two_digits(row.seconds),
            f"{100 * row.busy:.0f} %",
            two_digits(1e3 * row.run_seconds),
            two_digits(1e3 * row.alone_seconds),
        ]
        for row in tables[CAMPAIGN.name].itertuples()
    ]
    head = [
        "transients",
        "N",
        "workers killed",
        "lost",
        "repeated with another result",
        "seconds",
        "workers busy",
        "ms a transient",
        "in one process",
    ]
    return markdown(head, rows)


STUDY = Study(
    "studies.validation.campaign", __doc__, "few transients, in seconds", (CAMPAIGN,), report
)
