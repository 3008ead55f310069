"""Execution of the runs of a campaign: in this process, in worker processes, or by an executor of the caller."""

import os
import pickle
import signal
import sys
from collections.abc import Generator, Sequence
from concurrent.futures import Executor, Future, as_completed
from contextlib import suppress
from queue import SimpleQueue
from subprocess import PIPE, Popen
from threading import Event, Thread
from typing import Any

from ..errors import ModelError
from .run import CampaignContact, Run, failed, follow

__all__ = ["Finished", "execute", "serve"]

_BATCH = 16  # runs in one task of an executor: the arrays of the contact are sent once for all of them
_PATIENCE = 3  # workers that may die in the same run before the run counts as failed

Finished = tuple[dict[str, Any], bool]
"""The row of a run, and whether it is a result of the run: not if its worker died."""


def execute(contact: CampaignContact, runs: Sequence[Run], executor: Executor | None, workers: int) -> Generator[Finished]:
    """Follow runs and yield their rows as they finish, in any order; closing the generator cancels the others."""
    if executor is not None:
        yield from _by_executor(contact, runs, executor)
    elif workers > 1:
        yield from _by_processes(contact, runs, workers)
    else:
        for run in runs:
            yield follow(contact, [run])[0], True


def _by_executor(contact: CampaignContact, runs: Sequence[Run], executor: Executor) -> Generator[Finished]:
    futures: dict[Future[list[dict[str, Any]]], Sequence[Run]] = {}
    lost: list[tuple[Run, Exception]] = []
    try:
        for first in range(0, len(runs), _BATCH):
            batch = runs[first : first + _BATCH]
            try:
                future = executor.submit(follow, contact, batch)
                if not isinstance(future, Future):
                    raise TypeError(f"its submit returns a {type(future).__name__}, not a future")
                futures[future] = batch
            except Exception as error:  # an executor of the caller may raise anything
                if not futures:
                    raise ModelError(
                        f"executor: {executor!r} takes no runs ({type(error).__name__}: {error}); give one that is open, of concurrent.futures' "
                        "interface, or of dask by client.get_executor()"
                    ) from error
                lost += [(run, error) for run in batch]
        for future in as_completed(futures):
            yield from _rows(future, futures[future])
        yield from ((failed(run, _died(repr(error))), False) for run, error in lost)
    finally:
        for future in futures:
            future.cancel()


def _rows(future: "Future[list[dict[str, Any]]]", batch: Sequence[Run]) -> list[Finished]:
    """Rows of a batch; rows of failed runs if its future has no result, or the result of other runs."""
    try:
        rows = future.result()
        if [row["key"] for row in rows] != [run.key for run in batch]:
            raise ValueError("its executor returned other runs")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # any error of the caller's executor, also a cancelled future or an exit, concerns these runs only
        return [(failed(run, _died(repr(error))), False) for run in batch]
    return [(row, True) for row in rows]


def _by_processes(contact: CampaignContact, runs: Sequence[Run], workers: int) -> Generator[Finished]:
    team = _Team(contact, runs)
    size = min(workers, len(runs))
    try:
        for _ in range(size):
            Thread(target=team.lead, daemon=True).start()  # a daemon: the interpreter does not wait for it when it exits
        for _ in range(size):
            while (answer := team.answers.get()) is not None:
                if isinstance(answer, Exception):
                    raise answer
                yield answer
        for run in team.waiting:
            yield failed(run, _died("as all others did")), False
    finally:
        team.over.set()  # first: from now on no worker is replaced, even if the next lines are interrupted
        for worker in team.workers:
            worker.kill()


class _Team:
    """The workers, one for each thread, and what the threads share: the waiting runs, and the answers (None: a thread has ended)."""

    def __init__(self, contact: CampaignContact, runs: Sequence[Run]) -> None:
        self.contact, self.waiting, self.over = contact, iter(runs), Event()
        self.answers: SimpleQueue[Finished | Exception | None] = SimpleQueue()
        self.workers: list[_Worker] = []

    def lead(self) -> None:
        """Give runs to a worker, one by one; if the worker dies, a new worker repeats the run."""
        worker: _Worker | None = None
        deaths, run = 0, next(self.waiting, None)
        try:
            while run is not None and not self.over.is_set():
                try:
                    if worker is None:
                        worker = self._started()
                        worker.send(self.contact)
                    worker.send(run)
                    self.answers.put(worker.answer())
                except (OSError, EOFError, pickle.UnpicklingError) as error:
                    deaths += 1
                    if worker is not None:
                        worker.end()
                        worker = None
                    if deaths < _PATIENCE:
                        continue
                    self.answers.put((failed(run, _died(repr(error))), False))
                    break
                deaths, run = 0, next(self.waiting, None)
        except Exception as error:
            self.answers.put(error)
        finally:
            if worker is not None:
                worker.end()
            self.answers.put(None)

    def _started(self) -> "_Worker":
        code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        worker = _Worker([sys.executable, "-c", code], stdin=PIPE, stdout=PIPE, start_new_session=True)
        self.workers.append(worker)
        if self.over.is_set():  # it may have been started after the others were killed
            worker.kill()
        return worker


class _Worker(Popen[bytes]):
    """A process that follows runs.

    It does not import the caller's script, so no `__main__` guard is needed. Its own session protects it from Ctrl-C. It ends when its input ends,
    which happens at the latest when its parent ends.
    """

    def send(self, thing: CampaignContact | Run) -> None:
        """Send the contact (once, first) or the next run."""
        assert self.stdin
        pickle.dump(thing, self.stdin)
        self.stdin.flush()

    def answer(self) -> Any:
        """Wait for the result of the run."""
        assert self.stdout
        return pickle.load(self.stdout)

    def end(self) -> None:
        """Kill the process."""
        with suppress(OSError), self:  # input that it has not read
            self.kill()


def serve() -> None:
    """Main function of a worker process: follow the runs that arrive on stdin."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # for systems without sessions
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # replies use their own descriptor, so that output of libraries does not mix with them
    asked: SimpleQueue[Any] = SimpleQueue()
    Thread(target=_receive, args=(asked,), daemon=True).start()
    contact = asked.get()
    while True:
        reply: Finished | Exception
        try:
            reply = follow(contact, [asked.get()])[0], True
        except Exception as error:
            reply = error
        pickle.dump(reply, replies)
        replies.flush()


def _receive(asked: "SimpleQueue[Any]") -> None:
    try:
        while True:
            asked.put(pickle.load(sys.stdin.buffer))
    finally:
        os._exit(0)  # at once, also during a run


def _died(reason: str) -> str:
    return f"not followed, its worker died ({reason}); start again, with fewer workers if memory is short"
