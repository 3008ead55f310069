"""Run times of whole calls."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["Timed", "timed"]

_ENOUGH = 2.0  # seconds that the repetitions may take together; at least one is made


@dataclass(frozen=True)
class Timed:
    """The result of a run, its median time in seconds, and the number of repetitions."""

    answer: Any
    seconds: float
    repetitions: int


def timed(run: Callable[[], Any], repetitions: int) -> Timed:
    """Run once untimed, then so many times, but for at most 2 s; the median of an even number is the faster of the two middle times."""
    start = time.perf_counter()
    answer = run()
    repetitions = min(repetitions, max(1, int(_ENOUGH / (time.perf_counter() - start))))
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return Timed(answer, statistics.median_low(times), repetitions)
