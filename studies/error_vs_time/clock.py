"""Run times, split into what a user pays for: mesh, assembly, condensation, compilation, solution, verification."""

import functools
import pkgutil
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

__all__ = ["STAGES", "Timed", "mark", "timed"]

STAGES = ("mesh", "assembly", "condensation", "compile", "solve", "verify")
"""What a run time is made of."""

_CONIC, _QP = "cvxpy.reductions.solvers.conic_solvers", "cvxpy.reductions.solvers.qp_solvers"
_MARKED = {  # functions that belong to a stage; the time outside of all of them belongs to the stage that the run names
    "mesh": ("frictopt.fem.punch.PunchOnHalfPlane.model",),
    "condensation": ("frictopt.fem.glue.nested_dissection", "frictopt.fem.glue.schur_complement"),
    "solve": (
        f"{_CONIC}.highs_conif.HIGHS.solve_via_data",
        f"{_CONIC}.clarabel_conif.CLARABEL.solve_via_data",
        f"{_QP}.highs_qpif.HIGHS.solve_via_data",
        "frictopt.increments.exact.settle",
        "frictopt.increments.frozen_bound.settle",
        "frictopt.increments.status_search.settle",
    ),
    "verify": (
        "frictopt.contact.system.ContactSystem.__post_init__",
        "frictopt.fem.model.ContactModel._balanced",
        "frictopt.limits.both_bounds_search.BothBoundsSearch._claimed",
        "frictopt.increments.increment.referee",
        "frictopt.limits.safe_slip.MarginState",
        "frictopt.limits.shakedown.judged",
        "frictopt.path.exact.referee",
        "frictopt.path.cycles.referee",
        "frictopt.campaign.trajectory.referee",
    ),
}
_ENOUGH = 2.0  # seconds that the repetitions may take together; at least one is made


@dataclass(frozen=True)
class Timed:
    """What a run gives, and the stages of its median repetition: stage -> seconds."""

    answer: Any
    stages: dict[str, float]
    repetitions: int

    @property
    def seconds(self) -> float:
        """Run time of the median repetition."""
        return sum(self.stages.values())


class _Watch:
    """Time spent in each stage; an inner stage stops the clock of the outer one."""

    def __init__(self) -> None:
        self._open: list[str] = []
        self._since = 0.0
        self.spent: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        self._turn()
        self._open.append(stage)
        try:
            yield
        finally:
            self._turn()
            self._open.pop()

    def _turn(self) -> None:
        now = time.perf_counter()
        if self._open:
            self.spent[self._open[-1]] = self.spent.get(self._open[-1], 0.0) + now - self._since
        self._since = now


_watch = _Watch()  # the one that runs


@contextmanager
def mark(stage: str) -> Iterator[None]:
    """Count the time within as this stage of the run that is timed."""
    with _watch(stage):
        yield


def timed(run: Callable[[], Any], rest: str, repetitions: int) -> Timed:
    """Run once unmeasured, then repeatedly, and keep the repetition with the median time.

    Parameters
    ----------
    run
        What is timed.
    rest
        Stage of the time that no marked function takes.
    repetitions
        How often at most, within 2 s; of an even number, the faster one of the two in the middle counts.
    """
    start = time.perf_counter()
    answer = run()
    repetitions = min(repetitions, max(1, int(_ENOUGH / (time.perf_counter() - start))))
    with ExitStack() as stack:
        for stage, targets in _MARKED.items():
            for target in targets:
                stack.enter_context(_marked(target, stage))
        runs = [_once(run, rest) for _ in range(repetitions)]
    totals = [sum(stages.values()) for stages in runs]
    return Timed(answer, runs[totals.index(statistics.median_low(totals))], repetitions)


def _once(run: Callable[[], Any], rest: str) -> dict[str, float]:
    _watch.spent = {}
    with _watch(rest):
        run()
    return dict(_watch.spent)


def _marked(target: str, stage: str) -> Any:
    """Context in which a function of that dotted name counts as a stage."""
    original = pkgutil.resolve_name(target)

    @functools.wraps(original)
    def counted(*args: Any, **kwargs: Any) -> Any:
        with _watch(stage):
            return original(*args, **kwargs)

    return patch(target, counted)
