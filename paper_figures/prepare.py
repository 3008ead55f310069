"""The tables that figures lack are computed side by side, those of one study in one process."""

import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from frictopt.base import progress_bar
from studies.tables import Table


def prepare(tables: Iterable[Table[Any]], quick: bool, folder: Path, workers: int) -> None:
    """Compute those of the tables that are not stored, in several processes.

    Tables that measure times are left out, since nothing else should run beside them.

    Parameters
    ----------
    tables
        The tables. Those of one study share what they compute, and stay together.
    quick
        Compute the quick size.
    folder
        Where they are stored.
    workers
        Number of processes.
    """
    studies: dict[str, list[Table[Any]]] = {}
    for table in {table.name: table for table in tables if not table.alone}.values():
        if table.stored(table.parameters(quick), folder) is None:
            studies.setdefault(table.compute.__module__, []).append(table)
    if not studies:
        return
    with (
        ProcessPoolExecutor(min(workers, len(studies)), get_context("spawn"), _begin) as pool,
        progress_bar(True, "studies", "study", total=len(studies)) as bar,
    ):
        jobs = [
            pool.submit(_compute, missing, quick, folder) for missing in reversed(studies.values())
        ]  # the longest are among the last
        try:
            for job in as_completed(jobs):
                job.result()
                bar.update()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _begin() -> None:
    """One thread for each process, and no bars of progress but that of the first process."""
    threadpool_limits(1)
    sys.stderr = open(os.devnull, "w", encoding="utf-8")


def _compute(tables: Sequence[Table[Any]], quick: bool, folder: Path) -> None:
    for table in tables:
        table.load(table.parameters(quick), folder)
