"""Where the runs of a campaign are followed: in this process, in processes of our own, or by an executor of the caller's."""

import os
import signal
import threading
from collections.abc import Generator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context, parent_process
from typing import Any

from .run import Contact, Run, failed, follow

__all__ = ["Finished", "execute"]

_BATCH = 16  # runs that share one sending of the arrays to an executor of the caller's
_PATIENCE = 3  # times in a row that all workers may die without finishing a run

Finished = tuple[dict[str, Any], bool]
"""The row of a run, and whether it answers for the run: a worker that died does not."""


def execute(contact: Contact, runs: Sequence[Run], executor: Executor | None, workers: int) -> Generator[Finished]:
    """Follow runs and return their rows as they finish, in any order; closing the generator drops those that have not begun."""
    if executor is not None:
        yield from _by_executor(contact, runs, executor)
    elif workers > 1:
        yield from _by_processes(contact, runs, workers)
    else:
        for run in runs:
            yield follow(contact, [run])[0], True


def _by_executor(contact: Contact, runs: Sequence[Run], executor: Executor) -> Generator[Finished]:
    futures: dict[Future[list[dict[str, Any]]], Sequence[Run]] = {}
    try:
        for first in range(0, len(runs), _BATCH):
            batch = runs[first : first + _BATCH]
            futures[executor.submit(follow, contact, batch)] = batch
        for future in as_completed(futures):
            try:
                yield from ((row, True) for row in future.result())
            except Exception as error:  # whatever a foreign executor raises is about these runs alone
                yield from ((failed(run, _died(error)), False) for run in futures[future])
    finally:
        for future in futures:
            future.cancel()


def _by_processes(contact: Contact, runs: Sequence[Run], workers: int) -> Generator[Finished]:
    waiting = {run.key: run for run in runs}
    fruitless, error = 0, ""
    while waiting and fruitless < _PATIENCE:
        before = len(waiting)
        pool = ProcessPoolExecutor(min(workers, before), get_context("spawn"), _set_up, (contact,))
        try:
            futures = {}
            try:
                for run in waiting.values():
                    futures[pool.submit(_follow_here, run)] = run.key
            except BrokenExecutor:
                pass  # those handed out say so too
            for future in as_completed(futures):
                try:
                    row = future.result()
                except BrokenExecutor as broken:
                    error = _died(broken)
                    continue
                del waiting[futures[future]]
                yield row, True
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
        fruitless = fruitless + 1 if len(waiting) == before else 0
    for run in waiting.values():
        yield failed(run, error), False


def _died(error: Exception) -> str:
    return f"not followed, its worker died ({type(error).__name__}: {error}); start again, with fewer workers if memory is short"


_contact: Contact


def _set_up(contact: Contact) -> None:
    """Make a worker ready: it keeps the arrays, leaves Ctrl-C to its parent, and ends with it, however that ends."""
    global _contact
    _contact = contact
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _follow_here(run: Run) -> dict[str, Any]:
    return follow(_contact, [run])[0]
