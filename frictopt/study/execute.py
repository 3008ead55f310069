"""Where the runs of a campaign are followed: in this process, in processes of our own, or by an executor of the caller's."""

import os
import signal
import sys
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import FrameType
from typing import Any

from ..errors import ModelError
from .run import Contact, Run, failed, follow

__all__ = ["Finished", "execute"]

_BATCH = 16  # runs that share one sending of the arrays to an executor of the caller's
_PATIENCE = 3  # times in a row that all workers may die without finishing a run
_UNGUARDED = 77  # exit status of a worker that comes upon the call that started it

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
    lost: list[tuple[Run, Exception]] = []
    try:
        for first in range(0, len(runs), _BATCH):
            batch = runs[first : first + _BATCH]
            try:
                futures[_submitted(executor, contact, batch)] = batch
            except Exception as error:  # whatever a foreign executor raises
                if not futures:
                    raise ModelError(
                        f"executor: {executor!r} takes no runs ({type(error).__name__}: {error}); give one that is open, of concurrent.futures' "
                        "interface, or of dask by client.get_executor()"
                    ) from error
                lost += [(run, error) for run in batch]
        for future in as_completed(futures):
            yield from _rows(future, futures[future])
        yield from ((failed(run, _died(error)), False) for run, error in lost)
    finally:
        for future in futures:
            future.cancel()


def _submitted(executor: Executor, contact: Contact, batch: Sequence[Run]) -> "Future[list[dict[str, Any]]]":
    future = executor.submit(follow, contact, batch)
    if not isinstance(future, Future):
        raise TypeError(f"its submit returns a {type(future).__name__}, not a future")
    return future


def _rows(future: "Future[list[dict[str, Any]]]", batch: Sequence[Run]) -> list[Finished]:
    """Rows of a batch, of failed runs where its future has no result or another one."""
    try:
        rows = future.result()
        if [row["key"] for row in rows] != [run.key for run in batch]:
            raise ValueError("its executor returned other runs")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever a foreign executor raises, cancelled futures and exits too, is about these runs alone
        return [(failed(run, _died(error)), False) for run in batch]
    return [(row, True) for row in rows]


def _by_processes(contact: Contact, runs: Sequence[Run], workers: int) -> Generator[Finished]:
    if _in_a_script_run_again():
        sys.exit(_UNGUARDED)
    waiting = {run.key: run for run in runs}
    fruitless, error = 0, ""
    while waiting and fruitless < _PATIENCE:
        before = len(waiting)
        theirs, ours = get_context("spawn").Pipe(duplex=False)
        pool = ProcessPoolExecutor(min(workers, before), get_context("spawn"), _set_up, (contact, theirs))
        try:
            futures = {}
            try:
                with _without_interrupt():
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
            ours.close()  # first of all: however this ends, no worker is left over, for which the interpreter would wait at its end
            pool.shutdown(wait=False, cancel_futures=True)
            theirs.close()
        fruitless = fruitless + 1 if len(waiting) == before else 0
        if fruitless == 1:
            _check_guard(workers)
    for run in waiting.values():
        yield failed(run, error), False


def _in_a_script_run_again() -> bool:
    """Whether a new process is running the caller's script, as it does before anything else, and not what it was started for."""
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        if frame.f_code.co_name == "<module>" and frame.f_globals.get("__name__") == "__mp_main__":
            return True
        frame = frame.f_back
    return False


def _check_guard(workers: int) -> None:
    """Check, after workers died before their first run, that a new process can run the caller's script without coming upon the study again."""
    probe = get_context("spawn").Process(target=_nothing)
    probe.start()
    probe.join()
    if probe.exitcode == _UNGUARDED:
        raise ModelError(
            f"workers: {workers} processes, and each of them runs this script and comes upon this study again; "
            'put the call under `if __name__ == "__main__":`, or give workers=1'
        )


def _nothing() -> None:
    """What a process does that is only to begin."""


@contextmanager
def _without_interrupt() -> Iterator[None]:
    """Context that Ctrl-C waits for: processes that begin in it never hear it, not even while they import, before `_set_up`."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows has no such mask
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _died(error: BaseException) -> str:
    return f"not followed, its worker died ({type(error).__name__}: {error}); start again, with fewer workers if memory is short"


_contact: Contact


def _set_up(contact: Contact, campaign: "Connection[Any, Any]") -> None:
    """Make a worker ready: it keeps the arrays, leaves Ctrl-C to its parent, and ends with the campaign or the parent, however that ends."""
    global _contact
    _contact = contact
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(campaign,), daemon=True).start()


def _end_with(campaign: "Connection[Any, Any]") -> None:
    with suppress(OSError):
        campaign.poll(None)  # until the other end is closed: nothing is ever sent
    os._exit(1)


def _follow_here(run: Run) -> dict[str, Any]:
    return follow(_contact, [run])[0]
