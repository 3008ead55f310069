"""Compute the tables that figures lack in parallel; the tables of one study share a process."""

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
    """Compute the tables that are not stored, in several processes.

    Tables that measure times are left out, since nothing else should run beside them.

    Parameters
    ----------
    tables
        The tables. The tables of one study share computations, and stay together.
    quick
        Compute the quick size.
    folder
        Folder of the stored tables.
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
        # The longest computations are among the last studies, so these begin first.
        jobs = [
            pool.submit(_compute, missing, quick, folder) for missing in reversed(studies.values())
        ]
        try:
            for job in as_completed(jobs):
                job.result()
                bar.update()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _begin() -> None:
    """Set one thread for each process, and show only the progress of the first process."""
    threadpool_limits(1)
    sys.stderr = open(os.devnull, "w", encoding="utf-8")


def _compute(tables: Sequence[Table[Any]], quick: bool, folder: Path) -> None:
    for table in tables:
        table.load(table.parameters(quick), folder)
