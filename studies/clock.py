"""Run times of whole calls: processor times, so that what else runs on the machine counts little."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

_ENOUGH = 2.0  # seconds that the repetitions may take together; at least one is made


@dataclass(frozen=True)
class Timed:
    """The result of a run, its median time in seconds, and the number of repetitions."""

    answer: Any
    seconds: float
    repetitions: int


def timed(run: Callable[[], Any], repetitions: int) -> Timed:
    """Run once untimed, then so many times, for at most 2 s; a run that takes longer is its own time, and so is one without repetitions.

    The median of an even number is the faster of the two middle times.
    """
    start = time.process_time()
    answer = run()
    first = time.process_time() - start
    times = [first] if first > _ENOUGH or not repetitions else []
    while len(times) < min(repetitions, max(1, int(_ENOUGH / first))):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return Timed(answer, statistics.median_low(times), len(times))
