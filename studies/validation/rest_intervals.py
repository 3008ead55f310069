"""Random uncoupled contacts whose normal loads are scaled, compared with transients.

`contact` makes the contact of a seed. `compared` compares the intervals of safe load factors with
the outcomes of transients from several starts. Transients must shake down just inside each
interval, and slip just outside. `python -m studies.validation.rest_intervals FIRST COUNT` prints a table,
and each contact that disagrees.
"""

import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np

import frictopt as fo

from .moving_areas import Case, agrees, ends

KINDS = ("around an area", "there and back", "to and fro")
# Relative distance of the transients from an end of an interval.
_APART = 0.01
# Transients are followed up to this load factor.
_LARGEST = 6.0


def contact(seed: int, tangents: int = 1) -> Case:
    """The contact of a seed: 1 to 5 nodes, 2 to 6 corners; the load factor scales all loads."""
    rng = np.random.default_rng([75, 9, tangents, seed])
    nodes = int(rng.integers(1, 6))
    corners = int(rng.integers(2, 7))
    kind = KINDS[seed % len(KINDS)]
    entries = tangents * nodes
    S = np.zeros((entries + nodes, entries + nodes))
    for block in (slice(0, entries), slice(entries, None)):
        size = len(S[block])
        factor = rng.normal(size=(size, size))
        S[block, block] = factor @ factor.T / size + 0.4 * np.eye(size)

    scaled = rng.normal(size=(corners, entries + nodes))
    if kind == "there and back" and corners > 2:
        half = (corners + 2) // 2
        scaled = scaled[[*range(half), *range(half - 2, 0, -1)]]
    if kind == "to and fro":
        scaled = np.stack([scaled[0], -rng.uniform(0.2, 1.0) * scaled[0]])
    held = 0.1 * rng.normal(size=entries) * (seed % 2)
    gap = 0.3 * rng.random(nodes) * (rng.random(nodes) < 0.3) * (seed % 2)
    loads = {"mean": np.r_[held, rng.uniform(0.3, 1.5, nodes)]}
    loads |= {f"corner {k}": load for k, load in enumerate(scaled)}
    points = np.zeros((nodes, tangents + 1))
    points[:, 0] = np.arange(nodes)
    cycle = fo.LoadCycle({"mean": 1.0}, [{f"corner {k}": 1.0} for k in range(len(scaled))])
    system = fo.ContactSystem(S, points, loads, gap=gap)
    return Case(system, cycle, rng.uniform(0.2, 0.9, nodes), kind)


def _expected(intervals: np.ndarray) -> Iterator[tuple[float, bool]]:
    """Load factors near the ends of the intervals, and whether the contact shakes down there."""
    before = 0.0
    for number, (least, largest) in enumerate(intervals.tolist()):
        following = intervals[number + 1, 0] if number + 1 < len(intervals) else np.inf
        inside = min(largest, _LARGEST)
        if least - before > 1e-3:
            yield least - min(_APART * least, 0.5 * (least - before)), False
        if inside - least > 1e-4:
            apart = min(_APART * inside, 0.5 * (inside - least))
            yield inside - apart, True
            yield min(max(least * (1 + _APART), 1e-4), inside - apart), True
        if largest < _LARGEST:
            yield largest + min(max(_APART * largest, 1e-2), 0.5 * (following - largest)), False
        before = largest


def compared(seed: int, tangents: int = 1, starts: int = 4) -> tuple[str, int, str, str]:
    """Kind, number of intervals, kind of limit, and the transients that disagree."""
    case = contact(seed, tangents)
    limit = fo.shakedown_limit(case.system, case.cycle, case.friction, progress=False)
    intervals = limit.intervals
    wrong = []
    if len(intervals) and not np.isclose(limit.load_factor, intervals[0, 1], rtol=1e-8, atol=1e-9):
        wrong.append(f"limit {limit.load_factor:.9g}, intervals {intervals.tolist()}")
    for load_factor, at_rest in _expected(intervals):
        outcomes = ends(case.arguments, load_factor, starts, seed)
        if not agrees(outcomes, at_rest):
            wrong.append(f"{load_factor:.6g}: {dict(outcomes)}, {intervals.round(6).tolist()}")
    return case.kind, len(intervals), limit.kind.name, "; ".join(wrong)


def main(first: int, count: int, tangents: int = 1) -> None:
    """Print a table of contacts, and each contact that disagrees."""
    table = Counter[tuple[object, ...]]()
    for seed in range(first, first + count):
        kind, number, limit, wrong = compared(seed, tangents)
        table[kind, f"{number} intervals", limit, "disagrees" if wrong else "agrees"] += 1
        if wrong:
            print(seed, kind, wrong, flush=True)
    for row, number in sorted(table.items()):
        print(*row, number, sep=" | ")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
