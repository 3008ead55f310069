"""Corners of a load cycle from what engineers have: a history in a table, harmonic loads, or load cases that vary independently."""

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

from ..base import (
    Array,
    Table,
    checked_cases,
    checked_loads,
    choice,
    finite_array,
    finite_number,
    listed,
    shown,
    whole_number,
)
from ..base.checks import check_name
from ..errors import ModelError

_ROUNDING = (
    4 * np.finfo(float).eps
    # distance from the straight segment, over the largest amplitude of the load case, that counts as
    # rounding
)
_MOST_CORNERS = 100_000


def turning_points(loads: Array) -> list[int]:
    """Numbers of the points (K, cases) at which a load path turns, also the first and last, in units of each load case's largest amplitude.

    A point is left out only if it lies on the straight segment between its neighbours in every load
    case. A point where the load turns back stays.
    """
    largest = np.abs(loads).max(axis=0, initial=0.0)
    return reversals(loads / np.where(largest > 0, _ROUNDING * largest, 1.0))


def reversals(points: Array) -> list[int]:
    """Numbers of those points (K, cases) that a load path keeps so that all others lie within 1 of it, in each load case and in their order.

    One can walk along both paths at once, never back, and stay within 1 (the Frechet distance). So
    one load case keeps the reversals of more than 2. A straight way that is too far from its
    points, or would go back, keeps the worst of them.
    """
    kept, ways = {0, len(points) - 1}, [(0, len(points) - 1)]
    while ways:
        first, last = ways.pop()
        if last - first > 1 and (worst := _worst(points[first : last + 1])) is not None:
            kept.add(first + worst)
            ways += [(first, first + worst), (first + worst, last)]
    return sorted(kept)


def _worst(points: Array) -> int | None:
    """Number of the point that is farthest from the straight way from the first to the last one, or goes back most; None: all are within 1."""
    way, part = points[-1] - points[0], points[1:-1] - points[0]
    length = float(way @ way)
    share = np.clip(part @ way / length, 0.0, 1.0) if length > 0 else np.zeros(len(part))
    off = np.abs(part - np.multiply.outer(share, way)).max(axis=1, initial=0.0)
    moves = way != 0
    ends = np.sort(
        (part[:, moves, None] + [-1.0, 1.0]) / way[moves, None], axis=-1
    )  # shares of the way within 1 of each point
    earliest, latest = ends[..., 0].max(axis=1, initial=0.0), ends[..., 1].min(axis=1, initial=1.0)
    back = np.maximum.accumulate(earliest) - latest
    if (back <= 0).all() and (np.abs(part[:, ~moves]) <= 1).all():
        return None
    return len(part) - int(
        np.argmax((off if off.max() > 1 else back)[::-1])
    )  # of equal points the last


def history_corners(
    history: object, mean: object, time: object, tolerance: object
) -> tuple[dict[str, float], list[dict[str, float]], list[object] | None]:
    """Mean load, corners and their times, with that of the return of a closed history, see `LoadCycle.from_history`."""
    table, clock = _timed(history, time)
    cases = [name for name in table.columns if clock is None or name != clock]
    loads = _amplitudes(table, cases)
    middle = {
        name: float(low / 2 + high / 2)
        for name, low, high in zip(cases, loads.min(axis=0), loads.max(axis=0), strict=True)
    }
    static = middle if mean is None else dict(checked_loads("mean", mean))
    varying = loads - np.array([static.get(name, 0.0) for name in cases])
    moves = varying.any(axis=0)
    names, points = (
        [name for name, there in zip(cases, moves, strict=True) if there],
        varying[:, moves],
    )
    if share := finite_number("tolerance", tolerance, least=0.0, below=1.0):
        ranges = np.ptp(points, axis=0)
        numbers = reversals(points / (share * np.where(ranges > 0, ranges, 1.0)))
    else:
        numbers = turning_points(points)
    times = None if clock is None else table[clock].iloc[numbers].tolist()
    if (
        len(numbers) > 1
        and (
            np.abs(points[-1] - points[0]) <= _ROUNDING * np.abs(points).max(axis=0, initial=0.0)
        ).all()
    ):
        numbers.pop()  # the cycle comes back to its first corner by itself
    return (
        static,
        [dict(zip(names, points[number].tolist(), strict=True)) for number in numbers],
        times,
    )


def _timed(history: Any, time: object) -> tuple[Table, str | None]:
    """The history with its time, by which its rows are sorted, in a column; and the name of that column, None without one."""
    import pandas as pd  # here, for only a history needs it

    if not isinstance(history, pd.DataFrame):
        made = " (its to_frame(name) makes one)" if isinstance(history, pd.Series) else ""
        raise ModelError(
            f"history: a {type(history).__name__}; give a pandas DataFrame{made}, a column for "
            "each load case and a row for each time"
        )
    if not history.columns.is_unique:
        raise ModelError(
            f"history: the column {history.columns[history.columns.duplicated()][0]!r} stands "
            "twice; give each load case once"
        )
    if time is not None:
        clock, where = (
            choice("time", time, [name for name in history.columns if isinstance(name, str)]),
            f"history[{time!r}]",
        )
    elif (clock := _clock(history.columns)) is not None:
        where = f"history[{clock!r}]"
    elif history.index.nlevels > 1:
        raise ModelError(
            f"history: an index of {history.index.nlevels} levels; make columns of the time and of "
            "the loads by reset_index()"
        )
    elif history.index.dtype.kind in "mM" or _clock([history.index.name]):
        history, clock, where = history.reset_index(names="time"), "time", "history.index"
    else:
        return history, None
    try:
        ordered = not history[clock].isna().any() and history[clock].is_monotonic_increasing
    except TypeError:  # neither numbers nor dates alone
        ordered = False
    if not ordered:
        raise ModelError(
            f"{where}: the time decreases or is missing somewhere; sort the rows by time"
        )
    return history, str(clock)


def _amplitudes(table: Table, cases: list[str]) -> Array:
    """(K, cases) amplitudes of the load cases."""
    for name in cases:
        check_name("history", name)
        if table[name].dtype.kind in "mMO" and (
            odd := [value for value in table[name] if not isinstance(value, Real)]
        ):
            raise ModelError(
                f"history[{name!r}]: {shown(odd[0])} is no number; give numbers, or say "
                f"time={name!r} if this is the time"
            )
    if not cases or not len(table):
        raise ModelError(
            f"history: {len(table)} rows, {len(cases)} load cases; give at least one of each"
        )
    return np.column_stack(
        [finite_array(f"history[{name!r}]", table[name].to_numpy(), (None,)) for name in cases]
    )


def _clock(names: Iterable[Hashable]) -> str | None:
    """The name among these that says that it is the time."""
    return next((name for name in names if isinstance(name, str) and name.lower() == "time"), None)


def harmonic_corners(loads: object, points: object) -> list[dict[str, float]]:
    """Corners on the ellipse of loads that vary as cosines, the two ends of their way where all are in phase or opposed; see `LoadCycle.harmonic`."""
    cases = checked_cases("loads", loads, "amplitude, or (amplitude, phase in degrees)")
    waves, count = (
        {name: _wave(name, given) for name, given in cases.items()},
        whole_number("points", points, least=3, most=_MOST_CORNERS),
    )
    phases = np.radians([phase for size, phase in waves.values() if size])
    if not len(phases):
        raise ModelError(
            f"loads: {shown(loads)}; give at least one load case an amplitude other than 0"
        )
    to_and_fro = np.abs(np.sin(phases - phases[0])).max() <= _ROUNDING * max(
        1.0, np.abs(phases).max()
    )
    turns = (
        -phases[0] + np.array([0.0, np.pi]) if to_and_fro else 2 * np.pi / count * np.arange(count)
    )
    shares = np.cos(turns[:, None] + np.radians([phase for _, phase in waves.values()]))
    shares = np.where(np.abs(shares) > _ROUNDING, shares, 0.0)
    return [
        {
            name: float(size * part)
            for (name, (size, _)), part in zip(waves.items(), row, strict=True)
        }
        for row in shares
    ]


def _wave(name: str, given: object) -> tuple[float, float]:
    """Amplitude and phase of one load."""
    pair = (
        list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given, 0.0]
    )
    if len(pair) != 2:
        raise ModelError(
            f"loads[{name!r}]: {shown(given)}; give its amplitude, or (amplitude, phase in degrees)"
        )
    return finite_number(f"loads[{name!r}] amplitude", pair[0]), finite_number(
        f"loads[{name!r}] phase", pair[1]
    )


def independent_corners(loads: Sequence[object]) -> list[dict[str, float]]:
    """All sums of one corner of each load, in an order in which one load at a time moves on, see `LoadCycle.vertices`."""
    parts = [part for number, load in enumerate(loads) for part in _parts(f"loads[{number}]", load)]
    if not parts:
        raise ModelError(
            "loads: none; give at least one, a mapping of load case -> (least, most) or a list of "
            "corners"
        )
    counts = Counter(
        name for part in parts for name in {name for corner in part for name in corner}
    )
    if twice := [name for name, count in counts.items() if count > 1]:
        raise ModelError(
            f"loads: load case {min(twice)!r} is in two of them; loads that vary independently "
            "share no load case"
        )
    count = int(np.prod([float(len(part)) for part in parts]))
    if count > _MOST_CORNERS:
        raise ModelError(
            f"loads: their domain has {count:.3g} vertices, the most are {_MOST_CORNERS}; give "
            "fewer loads, or fewer corners of each"
        )
    sums: list[dict[str, float]] = [{}]
    # to and fro through the corners of a load, so that only this load changes where the next one of
    # the others comes
    for part in parts:
        sums = [
            {**one, **corner}
            for number, one in enumerate(sums)
            for corner in (part if number % 2 == 0 else part[::-1])
        ]
    return sums


def _parts(name: str, load: object) -> list[list[Mapping[str, float]]]:
    """The independent parts of one load: each load case of a box by itself, or the corners of a polytope."""
    if isinstance(load, Mapping):
        return [
            _range(f"{name}[{case!r}]", case, ends)
            for case, ends in checked_cases(name, load, "(least, most)").items()
        ]
    if isinstance(load, str):
        raise ModelError(f"{name}: {shown(load)}; give its range, {{{load!r}: (least, most)}}")
    corners = [
        checked_loads(f"{name}[{number}]", corner)
        for number, corner in enumerate(listed(name, load))
    ]
    if not corners:
        raise ModelError(f"{name}: no corners; give at least one")
    return [corners]


def _range(name: str, case: str, ends: object) -> list[Mapping[str, float]]:
    least, most = finite_array(f"{name} (least, most)", ends, (2,)).tolist()
    finite_number(f"{name} most", most, least=least)
    return [{case: least}, {case: most}] if most > least else [{case: least}]
