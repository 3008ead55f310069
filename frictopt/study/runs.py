"""Runs of a study: their input, their rows of results, and where they are followed."""

import hashlib
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import CancelledError, Executor, Future
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from math import ceil
from queue import SimpleQueue

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from ..base import Array
from ..contact import ContactSystem, LoadCycle
from ..errors import FrictoptError, ModelError
from ..limits import ShakedownLimit
from ..transients import steady_state
from ..transients.exact.kernel import compiled
from .starts import Start, root_mean_square
from .store import FAILED, Row

_libraries = cache(ThreadpoolController)  # of BLAS, found once
_TASKS = 256  # that an executor has at a time; each holds the arrays of its contact
_SECONDS = 1.0  # after which a task begins no other run
_MOMENT = 3.0  # seconds that an interrupt waits for the tasks at work


@dataclass(frozen=True, eq=False)
class Case:
    """The input that all runs of a study at one friction and load cycle share.

    A limit of None is one that no solver proves; `number` is the place of the friction in its list,
    `label` that of the load cycle, if it has one.
    """

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    limit: ShakedownLimit | None
    number: int = 0
    label: str = ""

    @cached_property
    def force(self) -> float:
        """Sum of the normal reactions under the mean load."""
        return float(self.cycle.mean_reaction(self.system)[1].sum())

    @cached_property
    def loads(self) -> str:
        """Digest of the loads of the cycle, whatever the contact."""
        parts = self.cycle.mean, *self.cycle.corners, None, *(self.cycle.fixed or ())
        return hashlib.sha256(
            repr([part and sorted(part.items()) for part in parts]).encode()
        ).hexdigest()[:40]

    @cached_property
    def digest(self) -> bytes:
        """Digest of the content."""
        reactions = (
            *self.cycle.mean_reaction(self.system),
            *self.cycle.corner_reactions(self.system),
        )
        fixed = () if self.cycle.fixed is None else self.cycle.unscaled_reactions(self.system)
        strength = (self.system.shear_strength,) if self.system.capped else ()
        return _digest(self.system.S, self.system.gap, self.friction, *reactions, *fixed, *strength)


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
        arrays = (
            ()
            if state is None
            else (state.slip, state.gap, state.bonded_q, state.bonded_p, state.next_corner)
        )
        content = _digest(
            *arrays, self.load_factor, start.slip, start.safe_multiple, start.overload
        )
        return hashlib.sha256(self.case.digest + content).hexdigest()[:40]


def _digest(*values: ArrayLike | None) -> bytes:
    parts = (
        b"-" if value is None else np.ascontiguousarray(value, dtype=np.float64).tobytes()
        for value in values
    )
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()


def execute(
    runs: Sequence[Run], executor: Executor | None, keep: Callable[[list[Row], bool], None]
) -> None:
    """Follow runs, here or by an executor; `keep` gets their rows as they finish, in any order. Whatever ends it early cancels the others.

    Rows come with whether they are results of their runs: they are not where the executor lost the
    runs. After an interrupt, tasks at work have a moment to hand over the rows that they have
    finished.
    """
    if executor is None:
        for run in runs:
            keep(_follow([run]), True)
        return
    if any(run.case.system.tangents == 1 for run in runs):
        compiled()  # once for all processes here
    waiting, tasks, done = (
        deque(runs),
        dict[Future[list[Row]], list[Run]](),
        SimpleQueue[Future[list[Row]]](),
    )
    try:
        while waiting or tasks:
            while waiting and len(tasks) < _TASKS:
                batch = [
                    waiting.popleft() for _ in range(ceil(len(waiting) / (_TASKS - len(tasks))))
                ]
                try:
                    future = executor.submit(_follow, batch)
                except (
                    Exception
                ) as error:  # also in the middle, from a pool whose processes have died
                    if len(batch) + len(waiting) == len(runs):
                        what = f"executor: {executor!r} takes no runs ({type(error).__name__}: {error})"
                        raise ModelError(
                            f"{what}; give one that is open, of concurrent.futures or dask"
                        ) from error
                    future = Future()
                    future.set_exception(error)
                tasks[future] = batch
                future.add_done_callback(done.put)
            rows, ended = (
                list[Row](),
                [done.get(), *(done.get() for _ in range(done.qsize()))],
            )  # all at once: a store may be slower than tasks
            for future in ended:
                try:
                    rows += (found := future.result())
                    waiting.extend(tasks[future][len(found) :])
                except Exception as error:
                    keep(
                        [
                            _failed(
                                run,
                                f"not followed, its executor lost it ({error!r}); start the study again",
                            )
                            for run in tasks[future]
                        ],
                        False,
                    )
            keep(rows, True)
            for future in ended:
                del tasks[future]
    except KeyboardInterrupt:  # of this process, or of one at work, for a terminal sends it to all
        _cancel(tasks)
        end = time.perf_counter() + _MOMENT
        keep([row for future in tasks for row in _finished(future, end)], True)
        raise
    finally:
        _cancel(tasks)


def _cancel(tasks: Iterable[Future[list[Row]]]) -> None:
    for future in tasks:
        with suppress(NotImplementedError):  # Parsl's futures
            future.cancel()


def _finished(future: Future[list[Row]], end: float) -> list[Row]:
    """The rows that a task has by a time, also where an interrupt has ended it."""
    try:
        error = future.exception(max(0.0, end - time.perf_counter()))
    except (CancelledError, TimeoutError):
        return []
    return future.result() if error is None else getattr(error, "rows", [])


def _follow(runs: Sequence[Run]) -> list[Row]:
    """Follow the first run, and more until the time of a task is over; one BLAS thread: no row depends on the machine, except for its seconds."""
    rows, end = list[Row](), time.perf_counter() + _SECONDS
    try:
        with _libraries().limit(limits=1):
            for run in runs:
                rows.append(_row(run))
                if time.perf_counter() >= end:
                    break
    except KeyboardInterrupt as interrupt:
        interrupt.rows = rows  # type: ignore[attr-defined]  # which come with it from another process
        raise
    return rows


def _row(run: Run) -> Row:
    began, case, start, slip = (
        time.perf_counter(),
        run.case,
        run.start,
        np.zeros(run.case.system.slip_shape),
    )
    try:
        given = start.slip_at(case.system, case.cycle, case.friction, run.load_factor, case.limit)
        slip = slip if given is None else given
        asked, begin = (
            (case.system, case.cycle, case.friction, run.load_factor),
            slip if start.state is None else None,
        )
        steady = steady_state(
            *asked,
            initial_slip=begin,
            initial_state=start.state,
            overload=start.overload,
            progress=False,
        )  # the study has a bar
    except FrictoptError as error:
        return _failed(run, f"{type(error).__name__}: {error}", time.perf_counter() - began) | {
            "amplitude": root_mean_square(slip)
        }
    share = (
        float(steady.dissipation_per_node.max() / steady.dissipation)
        if steady.dissipation > 0
        else 0.0
    )
    counts = {name: int(np.count_nonzero(getattr(steady, name))) for name in ("slipping", "open")}
    found = {
        name: getattr(steady, name)
        for name in ("dissipation", "first_cycle", "cycles", "residual", "engine")
    }
    told = {
        "amplitude": root_mean_square(slip),
        "outcome": steady.outcome.name,
        "largest_share": share,
        "error": "",
    }
    return _input(run) | found | counts | told | {"seconds": time.perf_counter() - began}


def _failed(run: Run, error: str, seconds: float = np.nan) -> Row:
    """The row of a run that has no result."""
    return _input(run) | {
        "outcome": FAILED,
        "engine": "path" if run.case.system.tangents == 1 else "newton",
        "seconds": seconds,
        "error": error,
    }


def _input(run: Run) -> Row:
    f = run.case.friction
    mean, spread = (f.mean(), f.std()) if np.ptp(f) > 0 else (f[0], 0.0)  # without rounding
    numbers = {
        "friction": float(mean),
        "friction_std": float(spread),
        "load_factor": run.load_factor,
    }
    return {
        "key": run.key,
        "start": run.start.name,
        "cycle": run.case.label,
        "loads": run.case.loads,
    } | numbers
