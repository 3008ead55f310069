"""Runs of a study: their input, their rows of results, and where they are followed."""

import hashlib
import time
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import Executor, Future
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from math import ceil
from queue import SimpleQueue
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from ..contact import Array, ContactSystem, LoadCycle
from ..errors import FrictoptError, ModelError
from ..limits import ShakedownLimit
from ..transients import steady_state
from ..transients.exact.kernel import compiled
from .starts import Start, root_mean_square
from .store import FAILED

_libraries = cache(ThreadpoolController)  # of BLAS, found once
_TASKS = 256  # that an executor has at a time; each holds the arrays of its contact
_SECONDS = 1.0  # after which a task begins no other run

Row = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Case:
    """The input that all runs of a study at one friction share.

    Attributes
    ----------
    system, cycle, friction
        The contact, its load cycle, and (N,) coefficients of friction.
    limit
        Its shakedown limit; None if no solver proves one.
    number
        Its place in the list of frictions.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    limit: ShakedownLimit | None
    number: int = 0

    @cached_property
    def digest(self) -> bytes:
        """Digest of the content."""
        reactions = *self.cycle.mean_reaction(self.system), *self.cycle.corner_reactions(self.system)
        fixed = () if self.cycle.fixed is None else self.cycle.unscaled_reactions(self.system)
        return _digest(self.system.S, self.system.gap, self.friction, *reactions, *fixed)


@dataclass(frozen=True, eq=False)
class Run:
    """One transient: its case, its load factor and its start."""

    case: Case
    load_factor: float
    start: Start

    @cached_property
    def key(self) -> str:
        """A digest of the content; a safe slip enters by its definition, because solvers may find different ones."""
        state, start = self.start.state, self.start
        arrays = () if state is None else (state.slip, state.gap, state.bonded_q, state.bonded_p, state.next_corner)
        content = _digest(*arrays, self.load_factor, start.slip, start.safe_multiple, start.overload)
        return hashlib.sha256(self.case.digest + content).hexdigest()[:40]


def _digest(*values: ArrayLike | None) -> bytes:
    parts = (b"-" if value is None else np.ascontiguousarray(value, dtype=np.float64).tobytes() for value in values)
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()


def execute(runs: Sequence[Run], executor: Executor | None) -> Generator[tuple[list[Row], bool]]:
    """Follow runs, here or by an executor, and yield their rows as they finish, in any order; closing the iterator cancels the others.

    Rows come with whether they are results of their runs: they are not where the executor lost the runs.
    """
    if executor is None:
        yield from ((_follow([run]), True) for run in runs)
        return
    if any(run.case.system.tangents == 1 for run in runs):
        compiled()  # once for all processes here
    waiting, tasks = deque(runs), dict[Future[list[Row]], list[Run]]()
    done = SimpleQueue[Future[list[Row]]]()
    taken = False
    try:
        while waiting or tasks:
            while waiting and len(tasks) < _TASKS:
                batch = [waiting.popleft() for _ in range(ceil(len(waiting) / (_TASKS - len(tasks))))]
                try:
                    future = executor.submit(_follow, batch)
                except Exception as error:  # also in the middle, from a pool whose processes have died
                    if not taken:
                        what = f"executor: {executor!r} takes no runs ({type(error).__name__}: {error})"
                        raise ModelError(f"{what}; give one that is open, of concurrent.futures or dask") from error
                    yield _lost(batch, error), False
                else:
                    taken, tasks[future] = True, batch
                    future.add_done_callback(done.put)
            if tasks:
                rows: list[Row] = []
                for future in [done.get(), *(done.get() for _ in range(done.qsize()))]:  # all at once, because a store may be slower than tasks
                    batch = tasks.pop(future)
                    try:
                        rows += (found := future.result())
                    except Exception as error:
                        yield _lost(batch, error), False
                    else:
                        waiting.extend(batch[len(found) :])
                yield rows, True
    finally:
        for future in tasks:
            with suppress(NotImplementedError):  # Parsl's futures
                future.cancel()


def _lost(runs: Sequence[Run], error: Exception) -> list[Row]:
    return [_failed(run, f"not followed, its executor lost it ({error!r}); start the study again") for run in runs]


def _follow(runs: Sequence[Run]) -> list[Row]:
    """Follow the first run, and more until the time of a task is over; one BLAS thread: no row depends on the machine, except for its seconds."""
    rows, end = [], time.perf_counter() + _SECONDS
    with _libraries().limit(limits=1):
        for run in runs:
            rows.append(_row(run))
            if time.perf_counter() >= end:
                break
    return rows


def _row(run: Run) -> Row:
    began, case, start, slip = time.perf_counter(), run.case, run.start, np.zeros(run.case.system.slip_shape)
    try:
        given = start.slip_at(case.system, case.cycle, case.friction, run.load_factor, case.limit)
        slip = slip if given is None else given
        asked, begin = (case.system, case.cycle, case.friction, run.load_factor), slip if start.state is None else None
        steady = steady_state(*asked, initial_slip=begin, initial_state=start.state, overload=start.overload, progress=False)  # the study has a bar
    except FrictoptError as error:
        return _failed(run, f"{type(error).__name__}: {error}", time.perf_counter() - began) | {"amplitude": root_mean_square(slip)}
    work = steady.dissipation_per_node
    return _input(run) | {
        "amplitude": root_mean_square(slip),
        "outcome": steady.outcome.name,
        "dissipation": steady.dissipation,
        "first_cycle": steady.first_cycle,
        "largest_share": float(work.max() / steady.dissipation) if steady.dissipation > 0 else 0.0,
        "cycles": steady.cycles,
        "slipping": int(np.count_nonzero(steady.slipping)),
        "open": int(np.count_nonzero(steady.open)),
        "residual": steady.residual,
        "engine": steady.engine,
        "seconds": time.perf_counter() - began,
        "error": "",
    }


def _failed(run: Run, error: str, seconds: float = np.nan) -> Row:
    """The row of a run that has no result."""
    return _input(run) | {"outcome": FAILED, "engine": "path" if run.case.system.tangents == 1 else "newton", "seconds": seconds, "error": error}


def _input(run: Run) -> Row:
    f = run.case.friction
    mean, spread = (f.mean(), f.std()) if np.ptp(f) > 0 else (f[0], 0.0)  # without rounding
    numbers = {"friction": float(mean), "friction_std": float(spread), "load_factor": run.load_factor}
    return {"key": run.key, "start": run.start.name} | numbers
