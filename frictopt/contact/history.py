"""Corners of a load cycle from a history, from harmonic loads, or from independent loads."""

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

from ..base import (
    Array,
    Booleans,
    Loads,
    Table,
    checked_cases,
    checked_loads,
    choice,
    finite_array,
    finite_number,
    listed,
    number_of,
    shown,
    whole_number,
)
from ..base.checks import check_name
from ..errors import ModelError

# A distance from a straight segment up to this share of the largest amplitude is rounding.
_ROUNDING = 4 * np.finfo(float).eps
# A cycle with more corners takes hours, so a larger number is probably a mistake.
_LARGEST_NUMBER_OF_CORNERS = 100_000


def turning_points(loads: Array) -> list[int]:
    """Indices of the points (K, cases) at which a load path turns, and of its first and last point.

    A point is left out only if it lies on the straight segment between its neighbours in every load
    case. A point where the load turns back stays.
    """
    largest = np.abs(loads).max(axis=0, initial=0.0)
    return reversals(loads / np.where(largest > 0, _ROUNDING * largest, 1.0))


def reversals(points: Array) -> list[int]:
    """Indices of some points (K, cases) that form a simpler load path, within 1 of all points.

    The distance is the Frechet distance in each load case: one point can move along each of the two
    paths, never back, so that both stay within 1 of each other. So a single load case keeps all
    reversals of more than 2. A segment is split at its worst point if a point is farther than 1
    from it, or if the order of the points would be reversed on it.
    """
    chosen = {0, len(points) - 1}
    segments = [(0, len(points) - 1)]
    while segments:
        first, last = segments.pop()
        if last - first < 2:
            continue
        worst = _worst_point(points[first : last + 1])
        if worst is not None:
            chosen.add(first + worst)
            segments += [(first, first + worst), (first + worst, last)]
    return sorted(chosen)


def _worst_point(points: Array) -> int | None:
    """Index of the point that the straight segment from the first to the last one fits worst.

    The result is None if the segment passes within 1 of all points, in their order. If a point is
    farther than 1, the worst point is the farthest one; otherwise it is the point that goes back
    most.
    """
    segment = points[-1] - points[0]
    inner = points[1:-1] - points[0]
    square = float(segment @ segment)
    share = np.zeros(len(inner))
    if square > 0:
        share = np.clip(inner @ segment / square, 0.0, 1.0)
    distance = np.abs(inner - np.multiply.outer(share, segment)).max(axis=1, initial=0.0)

    # For each point, the part of the segment within 1 of the point, from one share of the length to
    # another. Only the load cases that vary along the segment count.
    moves = segment != 0
    ends = (inner[:, moves, None] + [-1.0, 1.0]) / segment[moves, None]
    ends = np.sort(ends, axis=-1)
    earliest = ends[..., 0].max(axis=1, initial=0.0)
    latest = ends[..., 1].min(axis=1, initial=1.0)
    back = np.maximum.accumulate(earliest) - latest
    in_order = (back <= 0).all()
    resting_cases_fit = (np.abs(inner[:, ~moves]) <= 1).all()
    if in_order and resting_cases_fit:
        return None

    badness = distance if distance.max() > 1 else back
    # If several points are equally bad, the last of them is taken.
    return len(inner) - int(np.argmax(badness[::-1]))


def history_corners(
    history: object, mean: object, time: object, tolerance: object
) -> tuple[dict[str, float], list[dict[str, float]], list[object] | None]:
    """Mean load, corners and their times of a measured history, see `LoadCycle.from_history`.

    The times of a closed history have one more entry, the time of the return.
    """
    table, clock = _with_time(history, time)
    cases = [name for name in table.columns if clock is None or name != clock]
    loads = _amplitudes(table, cases)
    middle = loads.min(axis=0) / 2 + loads.max(axis=0) / 2
    static = dict(zip(cases, middle.tolist(), strict=True))
    if mean is not None:
        static = dict(checked_loads("mean", mean))

    varying = loads - np.array([static.get(name, 0.0) for name in cases])
    moves = varying.any(axis=0)
    names = [name for name, is_moving in zip(cases, moves, strict=True) if is_moving]
    points = varying[:, moves]
    numbers = _corner_numbers(points, finite_number("tolerance", tolerance, least=0.0, below=1.0))
    times = None if clock is None else table[clock].iloc[numbers].tolist()

    if len(numbers) > 1 and _closed(points).all():
        # The cycle returns to its first corner by itself.
        numbers.pop()
    corners = [dict(zip(names, points[number].tolist(), strict=True)) for number in numbers]
    return static, corners, times


def _corner_numbers(points: Array, tolerance: float) -> list[int]:
    """Indices of the corners: all turning points, or the reversals above a share of each range."""
    if tolerance == 0:
        return turning_points(points)
    ranges = np.ptp(points, axis=0)
    return reversals(points / (tolerance * np.where(ranges > 0, ranges, 1.0)))


def _closed(points: Array) -> Booleans:
    """(cases,) which loads return to their first amplitude, up to rounding."""
    largest = np.abs(points).max(axis=0, initial=0.0)
    return np.asarray(np.abs(points[-1] - points[0]) <= _ROUNDING * largest)


def _with_time(history: Any, time: object) -> tuple[Table, str | None]:
    """The history with its time in a column, and the name of this column, None without a time."""
    import pandas as pd  # imported here, because only a history needs it

    if not isinstance(history, pd.DataFrame):
        hint = ""
        if isinstance(history, pd.Series):
            hint = " (its to_frame(name) makes one)"
        raise ModelError(
            f"history: a {type(history).__name__}; give a pandas DataFrame{hint}, a column for "
            "each load case and a row for each time"
        )
    if not history.columns.is_unique:
        twice = history.columns[history.columns.duplicated()][0]
        raise ModelError(f"history: the column {twice!r} occurs twice; give each load case once")
    if time is not None:
        columns = [name for name in history.columns if isinstance(name, str)]
        clock = str(choice("time", time, columns))
        _check_time(history[clock], f"history[{time!r}]")
        return history, clock
    time_column = _time_name(history.columns)
    if time_column is not None:
        _check_time(history[time_column], f"history[{time_column!r}]")
        return history, time_column
    if history.index.nlevels > 1:
        raise ModelError(
            f"history: an index of {history.index.nlevels} levels; make columns of the time and of "
            "the loads by reset_index()"
        )
    has_dates = history.index.dtype.kind in "mM"
    if has_dates or _time_name([history.index.name]):
        table = history.reset_index(names="time")
        _check_time(table["time"], "history.index")
        return table, "time"
    return history, None


def _time_name(names: Iterable[Hashable]) -> str | None:
    """The name "time", in lower or upper case, among the names; None without it."""
    for name in names:
        if isinstance(name, str) and name.lower() == "time":
            return name
    return None


def _check_time(times: Any, place: str) -> None:
    """Check that times never decrease; error messages name their place."""
    try:
        ordered = not times.isna().any() and times.is_monotonic_increasing
    except TypeError:  # numbers and dates in one column
        ordered = False
    if not ordered:
        texts = [value for value in times if isinstance(value, str)]
        if texts:
            raise ModelError(
                f"{place}: the text {shown(texts[0])} is among the times; leave out rows without "
                "numbers, such as a row of units"
            )
        raise ModelError(
            f"{place}: the time decreases or is missing somewhere; sort the rows by time"
        )


def _amplitudes(table: Table, cases: list[str]) -> Array:
    """(K, cases) amplitudes of the load cases."""
    for name in cases:
        check_name("history", name)
        if table[name].dtype.kind not in "mMO":
            continue
        for value in table[name]:
            if not isinstance(value, Real):
                raise ModelError(
                    f"history[{name!r}]: {shown(value)} is no number; give numbers, or say "
                    f"time={name!r} if this is the time"
                )
    if not cases or not len(table):
        raise ModelError(
            f"history: {number_of(len(table), 'row')}, {number_of(len(cases), 'load case')}; "
            "give at least one of each"
        )
    columns = [
        finite_array(f"history[{name!r}]", table[name].to_numpy(), (None,)) for name in cases
    ]
    return np.column_stack(columns)


def harmonic_corners(loads: object, points: object) -> list[dict[str, float]]:
    """Corners of loads that vary as cosines, see `LoadCycle.harmonic`.

    The corners are points of an ellipse. If all loads are in phase or opposed, they are the two
    ends of a straight line.
    """
    meaning = "amplitude, or (amplitude, phase in degrees)"
    waves = {
        name: _amplitude_and_phase(name, wave)
        for name, wave in checked_cases("loads", loads, meaning).items()
    }
    count = whole_number("points", points, least=3, most=_LARGEST_NUMBER_OF_CORNERS)
    amplitudes, degrees = np.reshape([*waves.values()], (-1, 2)).T
    phases = np.radians(degrees)
    acting = phases[amplitudes != 0]
    if not len(acting):
        raise ModelError(
            f"loads: {shown(loads)}; give at least one load case an amplitude other than 0"
        )

    angle_rounding = _ROUNDING * max(1.0, np.abs(acting).max())
    on_a_line = np.abs(np.sin(acting - acting[0])).max() <= angle_rounding
    if on_a_line:
        angles = -acting[0] + np.array([0.0, np.pi])
    else:
        angles = 2 * np.pi / count * np.arange(count)
    shares = np.cos(angles[:, None] + phases)
    shares = np.where(np.abs(shares) > _ROUNDING, shares, 0.0)
    return [dict(zip(waves, row, strict=True)) for row in (amplitudes * shares).tolist()]


def _amplitude_and_phase(name: str, wave: object) -> tuple[float, float]:
    """Amplitude, and phase in degrees, of one harmonic load."""
    pair = [wave, 0.0]
    if isinstance(wave, Sequence) and not isinstance(wave, str):
        pair = list(wave)
    if len(pair) != 2:
        raise ModelError(
            f"loads[{name!r}]: {shown(wave)}; give its amplitude, or (amplitude, phase in degrees)"
        )
    amplitude = finite_number(f"loads[{name!r}] amplitude", pair[0])
    phase = finite_number(f"loads[{name!r}] phase", pair[1])
    return amplitude, phase


def independent_corners(loads: Sequence[object]) -> list[dict[str, float]]:
    """All sums of one corner of each load, in an order in which only one load changes at a time.

    See `LoadCycle.vertices`.
    """
    parts = []
    for number, load in enumerate(loads):
        parts += _independent_parts(f"loads[{number}]", load)
    if not parts:
        raise ModelError(
            "loads: none; give at least one, a mapping of load case -> (least, most) or a list of "
            "corners"
        )
    _check_independent(parts)
    count = int(np.prod([float(len(part)) for part in parts]))
    if count > _LARGEST_NUMBER_OF_CORNERS:
        raise ModelError(
            f"loads: their domain has {count:.3g} vertices, at most "
            f"{_LARGEST_NUMBER_OF_CORNERS} are allowed; give fewer loads, or fewer corners of each"
        )

    sums: list[dict[str, float]] = [{}]
    for part in parts:
        longer = []
        for number, start in enumerate(sums):
            # The corners of this load are visited to and fro, so that this load does not change
            # when the sum of the earlier loads does.
            for corner in part if number % 2 == 0 else part[::-1]:
                longer.append({**start, **corner})
        sums = longer
    return sums


def _check_independent(parts: list[list[Loads]]) -> None:
    """Check that no load case belongs to two of the parts."""
    counts = Counter[str]()
    for part in parts:
        counts.update({name for corner in part for name in corner})
    twice = [name for name, count in counts.items() if count > 1]
    if twice:
        raise ModelError(
            f"loads: load case {min(twice)!r} is in two loads; loads that vary independently have "
            "no load case in common"
        )


def _independent_parts(name: str, load: object) -> list[list[Loads]]:
    """The independent parts of one load: each load case of a box, or the corners of a polytope."""
    if isinstance(load, Mapping):
        box = checked_cases(name, load, "(least, most)")
        return [_ends_of_range(f"{name}[{case!r}]", case, ends) for case, ends in box.items()]
    if isinstance(load, str):
        raise ModelError(f"{name}: {shown(load)}; give its range, {{{load!r}: (least, most)}}")
    corners = []
    for number, corner in enumerate(listed(name, load)):
        corners.append(checked_loads(f"{name}[{number}]", corner))
    if not corners:
        raise ModelError(f"{name}: no corners; give at least one")
    return [corners]


def _ends_of_range(name: str, case: str, ends: object) -> list[Loads]:
    """The two ends of the range of a load case, or one if they are equal."""
    low, high = finite_array(f"{name} (least, most)", ends, (2,)).tolist()
    finite_number(f"{name} most", high, least=low)
    if high > low:
        return [{case: low}, {case: high}]
    return [{case: low}]
