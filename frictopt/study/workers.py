"""Processes of this machine that follow runs, and that a study replaces if they are lost."""

import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from threadpoolctl import threadpool_limits

from ..errors import ModelError

# A process that is forked would have the locks of all threads of its parent.
_CONTEXT = get_context("spawn")


class Workers(ThreadPoolExecutor):
    """An executor of processes, in which a process that ends loses only its own task.

    Each thread hands its tasks to a process of its own, which is a pool of one process. After a
    lost task, the thread makes a new pool for its next task. All processes end with this process,
    and with the executor.
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
        # At its end Python wakes the threads of all pools that are left, and one that is just
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

    A terminal sends Ctrl-C to all processes. It interrupts only tasks, which hand over their rows.
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
