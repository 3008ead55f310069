"""Runs of a study are followed in this process or by the tasks of an executor, and become rows."""

import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import suppress
from dataclasses import dataclass, field
from math import ceil
from multiprocessing import get_context
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import FrictoptError, ModelError, NoContinuation, SolverError
from ..transients import steady_state
from ..transients.exact.kernel import compiled
from .case import FAILED, SLIDES_OFF, Row, Run, row_of_run, row_of_steady
from .starts import root_mean_square


@dataclass(frozen=True)
class TaskSettings:
    """Numbers that control how an executor gets the runs of a study."""

    # Largest number of tasks at a time. Each task holds the arrays of its contact.
    most_tasks: int = 256
    # Seconds after which a task begins no further run.
    seconds: float = 1.0
    # Seconds for which an interrupt waits for running tasks.
    patience: float = 3.0


SETTINGS = TaskSettings()

Keep = Callable[[list[Row]], None]
"""Receives finished rows."""


def execute(runs: Sequence[Run], executor: Executor | int | None, keep: Keep) -> None:
    """Follow runs in this process or by an executor; `keep` receives their rows in any order.

    If `executor` is a number, it is the number of processes of this machine. An error or an
    interrupt cancels the runs that have not begun. After an interrupt, tasks at work have a moment
    to hand over the rows that they have finished.
    """
    if executor is None:
        for run in runs:
            keep(_follow([run]))
        return
    if any(run.case.system.tangents == 1 for run in runs):
        compiled()  # once, for all processes of this machine
    if not isinstance(executor, int):
        _follow_by_tasks(runs, executor, keep)
    elif runs:
        with Workers(min(executor, len(runs))) as workers:
            _follow_by_tasks(runs, workers, keep)


def _follow_by_tasks(runs: Sequence[Run], executor: Executor, keep: Keep) -> None:
    tasks = _Tasks(executor, deque(runs))
    try:
        while tasks.waiting or tasks.lost or tasks.at_work:
            tasks.submit()
            tasks.collect(keep)
    except KeyboardInterrupt:
        # A terminal sends the interrupt to all processes, so a task may raise it, too.
        tasks.cancel()
        keep(tasks.finished_rows())
        raise
    finally:
        tasks.cancel()


@dataclass
class _Tasks:
    """The tasks of an executor, each with its batch of runs, and the runs that wait.

    If the task of a batch is lost, the batch is halved, until the run that ends its tasks is alone.
    A run that is alone gets a second task. If this task is lost, too, the run has failed.
    """

    executor: Executor
    waiting: deque[Run]
    lost: deque[list[Run]] = field(default_factory=deque)
    lost_alone: set[str] = field(default_factory=set)
    at_work: dict[Future[list[Row]], list[Run]] = field(default_factory=dict)
    ended: SimpleQueue[Future[list[Row]]] = field(default_factory=SimpleQueue)
    begun: bool = False

    def submit(self) -> None:
        """Fill the executor with lost batches, and with equal shares of the waiting runs."""
        while (self.lost or self.waiting) and len(self.at_work) < SETTINGS.most_tasks:
            if self.lost:
                batch = self.lost.popleft()
            else:
                share = ceil(len(self.waiting) / (SETTINGS.most_tasks - len(self.at_work)))
                batch = [self.waiting.popleft() for _ in range(share)]
            future = self._submit_batch(batch)
            self.at_work[future] = batch
            future.add_done_callback(self.ended.put)

    def _submit_batch(self, batch: list[Run]) -> Future[list[Row]]:
        """Submit the task of a batch; it fails if the executor has died after earlier tasks."""
        try:
            future = self.executor.submit(_follow, batch)
        except Exception as error:
            if not self.begun:
                raise ModelError(
                    f"executor: {self.executor!r} takes no runs ({type(error).__name__}: {error}); "
                    "give one that is open, of concurrent.futures or dask"
                ) from error
            future = Future()
            future.set_exception(error)
        self.begun = True
        return future

    def collect(self, keep: Keep) -> None:
        """Wait until a task ends, keep the rows of all ended tasks, put unfinished runs back."""
        # A store may be slower than the tasks, so it gets the rows of all ended tasks at once.
        futures = [self.ended.get()]
        futures += [self.ended.get() for _ in range(self.ended.qsize())]
        rows = list[Row]()
        for future in futures:
            batch = self.at_work[future]
            try:
                finished = future.result()
            except Exception as error:
                finished = self._failed_rows(batch, error)
            else:
                self.waiting.extend(batch[len(finished) :])
            rows += finished
        keep(rows)
        # Tasks are deleted only after their rows are kept, because an interrupt collects the rows
        # of all listed tasks.
        for future in futures:
            del self.at_work[future]

    def _failed_rows(self, batch: list[Run], error: Exception) -> list[Row]:
        """Put a lost batch back in two halves; return a row only for a run that is lost again."""
        half = len(batch) // 2
        if half:
            self.lost += [batch[:half], batch[half:]]
            return []
        (run,) = batch
        if run.key not in self.lost_alone:
            self.lost_alone.add(run.key)
            self.lost.append(batch)
            return []
        remedy = "if its process ended, it may need memory: give fewer processes"
        text = f"its task was lost twice ({error!r}); {remedy}, and start the study again"
        return [_failed_row(run, text)]

    def cancel(self) -> None:
        """Cancel the tasks that have not begun."""
        for future in self.at_work:
            with suppress(NotImplementedError):  # the futures of some libraries
                future.cancel()

    def finished_rows(self) -> list[Row]:
        """The rows that running tasks finish within `patience`, or finished before an interrupt."""
        rows = list[Row]()
        end = time.perf_counter() + SETTINGS.patience
        for future in self.at_work:
            with suppress(CancelledError, TimeoutError):
                error = future.exception(max(0.0, end - time.perf_counter()))
                rows += future.result() if error is None else getattr(error, "rows", [])
        return rows


def _follow(runs: Sequence[Run]) -> list[Row]:
    """Follow the first run, and further runs until the time of a task is over.

    An interrupt takes the finished rows with it in its attribute `rows`, also to another process.
    """
    rows = list[Row]()
    end = time.perf_counter() + SETTINGS.seconds
    try:
        for run in runs:
            rows.append(_row(run))
            if time.perf_counter() >= end:
                break
    except KeyboardInterrupt as interrupt:
        interrupt.rows = rows  # type: ignore[attr-defined]
        raise
    return rows


def _row(run: Run) -> Row:
    """Follow a run to its steady state, and return its row, or the row of its error."""
    began = time.perf_counter()
    case = run.case
    start = run.start
    slip = np.zeros(case.system.slip_shape)
    try:
        start_slip = start.slip_at(
            case.system, case.cycle, case.friction, run.load_factor, case.limit
        )
        if start_slip is not None:
            slip = start_slip
        steady = steady_state(
            case.system,
            case.cycle,
            case.friction,
            run.load_factor,
            initial_slip=slip if start.state is None else None,
            initial_state=start.state,
            overload=start.overload,
            progress=False,
        )
        row = row_of_run(run) | row_of_steady(steady) | {"error": ""}
    except (FrictoptError, MemoryError) as error:
        row = _failed_row(run, f"{type(error).__name__}: {error}")
        if isinstance(error, NoContinuation | SolverError):
            row |= _sliding(run, error)
    row["amplitude"] = root_mean_square(slip)
    row["seconds"] = time.perf_counter() - began
    return row


def _sliding(run: Run, error: FrictoptError) -> Row:
    """Outcome and reasons of a run whose bodies slide off by equilibrium; empty if they do not."""
    try:
        statics = run.case.statics
    except SolverError:
        return {}
    if statics.rests_at(run.load_factor):
        return {}
    return {"outcome": SLIDES_OFF, "error": f"{error}; {statics.reason}"}


def _failed_row(run: Run, error: str) -> Row:
    """The row of a run that has no result."""
    engine = "path" if run.case.system.tangents == 1 else "newton"
    return row_of_run(run) | {"outcome": FAILED, "engine": engine, "error": error}


# Processes of this machine that follow runs, and that a study replaces if they are lost.

# A process that is forked would have the locks of all threads of its parent.
_CONTEXT = get_context("spawn")


class Workers(ThreadPoolExecutor):
    """An executor of processes, in which a process that ends loses only its own task.

    Each thread hands its tasks to its own process, a pool of one. After a lost task, the thread
    makes a new pool for its next task. All processes end with this process, and with the executor.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self._own = threading.local()
        # The process at the other end of a pipe ends when the pipe is closed.
        self._pipes = list[Connection]()
        self._pools = list[ProcessPoolExecutor]()
        begun = [self.submit(int) for _ in range(count)]
        wait(begun)
        error = begun[0].exception()
        if error is not None and all(task.exception() for task in begun):
            self.shutdown()
            raise ModelError(
                f"executor: {count}, but its processes end when they begin ({error!r}); call the "
                "study below `if __name__ == '__main__':` in a script, or give fewer processes"
            ) from error

    def submit(self, task: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand a task to the next process that is free."""
        return super().submit(self._by_process, task, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """End all processes, also those at work."""
        for pipe in self._pipes:
            pipe.close()
        super().shutdown(wait, cancel_futures=cancel_futures)
        # At its end Python wakes the threads of all pools that are left, and a pool that is just
        # closing would print a traceback.
        for pool in self._pools:
            pool.shutdown(wait)

    def _by_process(self, task: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        if not hasattr(self._own, "pool"):
            end, pipe = _CONTEXT.Pipe(duplex=False)
            self._pipes.append(pipe)
            self._own.pool = ProcessPoolExecutor(1, _CONTEXT, _begin, (end,))
            self._pools.append(self._own.pool)
        try:
            return self._own.pool.submit(_followed, task, *args, **kwargs).result()
        except BrokenExecutor:
            del self._own.pool
            raise


def _begin(end: Connection) -> None:
    """Begin a process: it has one BLAS thread, so that processes do not compete.

    A terminal sends Ctrl-C to all processes. Ctrl-C interrupts only tasks, which hand over their
    rows.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threadpool_limits(1)
    threading.Thread(target=_end_with_parent, args=(end,), daemon=True).start()


def _followed(task: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Do a task, which Ctrl-C may interrupt."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return task(*args, **kwargs)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with_parent(end: Connection) -> None:
    """End this process when the parent has closed its end of the pipe, or is gone."""
    end.poll(None)
    os._exit(1)
