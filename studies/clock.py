"""Run times of whole calls: processor times, which other work on the machine disturbs little."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# Seconds that all repetitions may take together. At least one repetition is made.
_ENOUGH = 2.0


@dataclass(frozen=True)
class Timed:
    """The result of a run, its median time in seconds, and the number of repetitions."""

    answer: Any
    seconds: float
    repetitions: int


def timed(run: Callable[[], Any], repetitions: int) -> Timed:
    """Run once without timing, then repeat with timing, for at most 2 s.

    If the first run takes longer, or no repetition is requested, the time of the first run counts.
    For an even number of repetitions, the median is the faster of the two middle times.
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
