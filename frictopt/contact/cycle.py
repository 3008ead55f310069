"""Load cycles: a static load, the corners of a cyclic load, and a cyclic part that no load factor multiplies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from functools import cached_property
from numbers import Real
from typing import Self

import numpy as np

from ..base import (
    ROUNDING,
    Array,
    Plotted,
    Table,
    checked_loads,
    finite_number,
    kept,
    listed,
    shown,
    warns_of_odd_values,
)
from ..errors import ModelError
from .components import parted
from .history import harmonic_corners, history_corners, independent_corners
from .system import ContactSystem, checked_system, reactions

_SECOND = np.timedelta64(1, "s")
_SHOWN = 4  # corners in the text of a load cycle: those of two independent loads


@kept
@warns_of_odd_values
@dataclass(frozen=True)
class LoadCycle(Plotted):
    """A mean load and the corners of a closed cycle around it; between corners the load is linear in time.

    At load factor `lam` corner k carries the loads `mean + fixed[k] + lam * corners[k]`. Theory,
    eq. (5).

    Parameters
    ----------
    mean
        Static load, load case name -> amplitude (in the unit of the load case).
    corners
        The K corners in the order in which they are visited, each load case name -> amplitude at
        load factor 1.
    fixed
        The K parts of the cycle, one for each corner, that the load factor leaves as they are, load
        case name -> amplitude. None: none. With the same load at all corners the load factor is
        that of a static load: how large may it grow while the fixed part comes and goes? Transients
        begin at the mean load, so let it be one inside the fixed part.
    times
        The K times of the corners, numbers or dates, and maybe one more, when the load is back at
        the first corner; `timedelta` are kept in seconds. Pictures and names alone use them:
        friction knows no time. None: not known.

    Raises
    ------
    ModelError
        No corner, fixed parts or times of another number, a name that is not a text, amplitudes
        that are not finite, times that are neither numbers nor dates; and, when used, a load case
        that the system lacks.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
    LoadCycle(mean={'P': 1.0}, corners=[{'sigma': -1.0}, {'sigma': 1.0}])

    A shear force that grows while the pressure comes and goes:

    >>> rocking = fo.LoadCycle(
    ...     mean={"P": 1.0}, corners=[{"Q": 1.0}, {"Q": 1.0}], fixed=[{"P": -0.5}, {"P": 0.5}]
    ... )
    >>> rocking.at(0.1)
    ({'P': 0.5, 'Q': 0.1}, {'P': 1.5, 'Q': 0.1})
    """

    mean: Mapping[str, float]
    corners: Sequence[Mapping[str, float]]
    fixed: Sequence[Mapping[str, float]] | None = None
    times: Sequence[object] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        mean, corners = checked_loads("mean", self.mean), _checked("corners", self.corners)
        if not corners:
            raise ModelError("corners: empty; a load cycle visits at least one corner")
        fixed = None if self.fixed is None else _checked("fixed", self.fixed)
        if fixed is not None and len(fixed) != len(corners):
            raise ModelError(
                f"fixed: {len(fixed)} loads for {len(corners)} corners; give one for each, {{}} "
                "where there is none"
            )
        times = None if self.times is None else _times(self.times, len(corners))
        vars(self).update(
            mean=mean, corners=corners, fixed=fixed if fixed and any(fixed) else None, times=times
        )

    def __hash__(self) -> int:
        loads = self.mean, *self.corners, *(self.fixed or ())
        return hash(tuple(frozenset(load.items()) for load in loads))

    def __repr__(self) -> str:
        fixed = "" if self.fixed is None else f", fixed={_text(self.fixed)}"
        return f"LoadCycle(mean={dict(self.mean)}, corners={_text(self.corners)}{fixed})"

    @cached_property
    def corner_names(self) -> tuple[str, ...]:
        """Names of the corners: time, if known, and loads at load factor 1 without the mean load, "t = 2.5: sigma = +1, Q = +0.5"."""
        fixed = [{}] * len(self.corners) if self.fixed is None else self.fixed
        names = [
            ", ".join([*_told(corner, ""), *_told(part, " fixed")]) or "mean load"
            for corner, part in zip(self.corners, fixed, strict=True)
        ]
        if self.times is not None:
            clock = [f"{time:g}" if isinstance(time, Real) else str(time) for time in self.times]
            names = [f"t = {time}: {name}" for time, name in zip(clock, names, strict=False)]
        times = Counter(names)
        return tuple(
            f"{name} (corner {k})" if times[name] > 1 else name for k, name in enumerate(names)
        )

    @property
    def unscaled(self) -> tuple[Mapping[str, float], ...]:
        """What the load factor leaves as it is: the loads `mean + fixed[k]` at the K corners; the mean load alone, once, where nothing is fixed."""
        return (
            (self.mean,)
            if self.fixed is None
            else tuple(_sum(self.mean, part) for part in self.fixed)
        )

    def at(self, load_factor: float) -> tuple[Mapping[str, float], ...]:
        """The loads at the K corners at a load factor, load case name -> amplitude."""
        unscaled = self.unscaled if self.fixed else (self.mean,) * len(self.corners)
        return tuple(
            _sum(loads, corner, load_factor)
            for loads, corner in zip(unscaled, self.corners, strict=True)
        )

    @classmethod
    def from_history(
        cls,
        history: Table,
        *,
        mean: Mapping[str, float] | None = None,
        time: str | None = None,
        tolerance: float = 0.0,
    ) -> Self:
        """The load cycle of a measured history, which is repeated again and again; at load factor 1 it is the history itself.

        Points on the straight segment between their neighbours are left out, because friction knows
        no time, and so is a last row that equals the first: no answer changes by that.

        Parameters
        ----------
        history
            pandas DataFrame, a row for each point in time and a column for each load case, with its
            whole amplitude (static part included).
        mean
            Static part of the loads, load case name -> amplitude, which the load factor leaves as
            it is: a corner is the row less the mean. Load cases that are not columns are constant.
            None: the middle between the least and the largest amplitude of each column.
        time
            Name of the column with the time, by which the rows are sorted. None: the column "time",
            else an index of dates, of times passed or of that name, if there is one. The corners
            keep their times, and so does a last row that equals the first one, as the time of the
            return.
        tolerance
            Against noise, a share of the range of each load case: every measured load lies within
            it of the straight way between two corners kept, in its order. One load case keeps its
            reversals of more than twice as much. 0: all turning points. A load that is constant up
            to noise has no other range than its noise: leave its column out, and give it in `mean`.

        Raises
        ------
        ModelError
            Not a DataFrame, an index of several levels and no column of the time, no rows or load
            cases, amplitudes that are not finite numbers, a time that decreases.

        Examples
        --------
        >>> import pandas as pd
        >>> import frictopt as fo
        >>> history = pd.DataFrame({"time": [0, 1, 2, 3], "P": 5.0, "sigma": [0.0, 1.0, 2.0, 0.5]})
        >>> fo.LoadCycle.from_history(history)
        LoadCycle(mean={'P': 5.0, 'sigma': 1.0}, corners=[{'sigma': -1.0}, {'sigma': 1.0}, {'sigma':
        -0.5}])
        >>> fo.LoadCycle.from_history(
        ...     history, tolerance=0.3
        ... ).times  # the last row is not a reversal of 30 %, but it is the last
        (0, 2, 3)
        """
        static, corners, times = history_corners(history, mean, time, tolerance)
        return cls(static, corners, times=times)

    @classmethod
    def harmonic(
        cls,
        loads: Mapping[str, float | tuple[float, float]],
        *,
        mean: Mapping[str, float],
        points: int = 16,
    ) -> Self:
        """The load cycle of loads that vary as cosines of one frequency around a mean load, with phases between them.

        At the angle t of the cycle a load of amplitude a and phase phi is `a cos(t + phi)`: one of
        90 degrees is ahead of one of 0 by a quarter. Together they run along an ellipse, and the
        corners are points of it, at even angles. A load alone, and loads that are in phase or
        opposed, go to and fro on a straight way: its two ends are the corners then, and the cycle
        is exact, for friction knows no time.

        Of an ellipse the polygon of `points` corners leaves out up to `1 - cos(pi / points)` of the
        amplitude, 1.9 % with 16 points, 0.5 % with 32. While all nodes stay closed, the shakedown
        limit of the ellipse itself is between `cos(pi / points)` times that of the polygon and
        that: the loads that one slip bears are convex, and the ellipse less that share lies within
        the polygon. Steady states, their work and the guaranteed limit have no such bound: ask with
        twice the points to see.

        Parameters
        ----------
        loads
            Load case name -> amplitude at load factor 1, or (amplitude, phase in degrees). A
            negative amplitude is a phase of 180 degrees more.
        mean
            Static load, load case name -> amplitude, which the load factor leaves as it is.
        points
            Number of corners on an ellipse, >= 3.

        Raises
        ------
        ModelError
            No amplitude other than 0, amplitudes and phases that are no finite numbers, fewer than
            three points.

        Examples
        --------
        A preload that vibration shears while spin, a quarter ahead, takes up to a twentieth of it
        off:

        >>> import frictopt as fo
        >>> shaken = fo.LoadCycle.harmonic(
        ...     {"vib": 1.0, "spin": (0.05, 90)}, mean={"preload": 1.0}, points=4
        ... )
        >>> [list(corner.values()) for corner in shaken.corners]
        [[1.0, 0.0], [0.0, -0.05], [-1.0, 0.0], [0.0, 0.05]]
        >>> fo.LoadCycle.harmonic({"vib": 1.0}, mean={"preload": 1.0})
        LoadCycle(mean={'preload': 1.0}, corners=[{'vib': 1.0}, {'vib': -1.0}])
        """
        return cls(mean, harmonic_corners(loads, points))

    @classmethod
    @warns_of_odd_values
    def vertices(
        cls,
        mean: Mapping[str, float],
        *loads: Mapping[str, Sequence[float]] | Sequence[Mapping[str, float]],
    ) -> Self:
        """The vertices of a domain in which several loads vary independently of each other, around a mean load.

        A slip that is safe at all vertices is safe for every load in the domain, as the safe loads
        of a slip are a convex set: the shakedown limit of the vertices is that of all load
        histories in the domain (Bjorkman & Klarbring 1987).

        Of transients the vertices say less. One that comes to rest, with all nodes closed, stays at
        rest whatever history in the domain follows. One that slips for ever shows that some
        histories never come to rest; others, and other starts, may dissipate more than this order
        of the vertices, and may slip for ever even where this one comes to rest.

        Parameters
        ----------
        mean
            Static load, load case name -> amplitude.
        loads
            Each either a box, load case name -> (least, most) where each load case varies by
            itself, or the corners of one load that moves within their hull, a list of load case
            name -> amplitude (a force that rotates, for example). No load case is in two of them.

        Raises
        ------
        ModelError
            No load, a load case in two loads, a range that is no pair or whose least exceeds its
            most, more than 100,000 vertices.

        Examples
        --------
        >>> import frictopt as fo
        >>> [
        ...     dict(corner)
        ...     for corner in fo.LoadCycle.vertices(
        ...         {"P": 1.0}, {"sigma": (-1.0, 1.0), "Q": (0.0, 0.5)}
        ...     ).corners[:2]
        ... ]
        [{'sigma': -1.0, 'Q': 0.0}, {'sigma': -1.0, 'Q': 0.5}]
        """
        return cls(mean, independent_corners(loads))

    def mean_reaction(self, system: ContactSystem) -> tuple[Array, Array]:
        """(N,) reactions `q0, p0` of the closed, unslipped contact under the mean load."""
        return checked_system(system).closed_reaction(self.mean)

    def unscaled_reactions(self, system: ContactSystem) -> tuple[Array, Array]:
        """(K, N) reactions `q0, p0` of the closed, unslipped contact at the corners at load factor 0; (1, N) where nothing is fixed."""
        return parted(
            reactions(system, self.unscaled) - system.S[:, -system.nodes :] @ system.gap,
            system.tangents + 1,
        )

    def corner_reactions(self, system: ContactSystem) -> tuple[Array, Array]:
        """(K, N) bonded reactions `q1, p1` of the corners at load factor 1, without the mean and what is fixed."""
        return parted(reactions(system, self.corners), system.tangents + 1)


def _checked(name: str, loads: object) -> tuple[Mapping[str, float], ...]:
    if isinstance(loads, Mapping | str) or not isinstance(loads, Sequence):
        made = " (its to_dict('records') makes one)" if hasattr(loads, "to_dict") else ""
        raise ModelError(
            f"{name}: a {type(loads).__name__}; give a list{made} of load corners, each load case "
            "name -> amplitude"
        )
    return tuple(checked_loads(f"{name}[{k}]", load) for k, load in enumerate(loads))


def _times(given: object, corners: int) -> tuple[object, ...]:
    """Check the times of the corners, numbers or dates; times passed become seconds."""
    times = tuple(
        float(time / _SECOND) if isinstance(time, timedelta | np.timedelta64) else time
        for time in listed("times", given)
    )
    if len(times) - corners not in (0, 1):
        raise ModelError(
            f"times: {len(times)} for {corners} corners; give one for each, and one more for the "
            "return to the first"
        )
    for time in times:
        if isinstance(time, Real):
            finite_number("times", time)
        elif (
            not hasattr(time, "isoformat") or time != time
        ):  # a date that is missing differs from itself
            raise ModelError(
                f"times: {shown(time)} is neither a number nor a date; give one of these, of texts "
                "by pandas.to_datetime"
            )
    return times


def _sum(
    one: Mapping[str, float], other: Mapping[str, float], factor: float = 1.0
) -> dict[str, float]:
    """One load plus a multiple of another."""
    return {
        **one,
        **{name: one.get(name, 0.0) + factor * amplitude for name, amplitude in other.items()},
    }


def _told(loads: Mapping[str, float], of: str) -> list[str]:
    """Loads in words, without those that are zero up to rounding."""
    most = max(map(abs, loads.values()), default=0.0)
    return [
        f"{case} = {amplitude:+.4g}{of}"
        for case, amplitude in loads.items()
        if abs(amplitude) > ROUNDING * most
    ]


def _text(loads: Sequence[Mapping[str, float]]) -> str:
    shown = ", ".join(str(dict(load)) for load in loads[:_SHOWN])
    return f"[{shown}, ... {len(loads)} in all]" if len(loads) > _SHOWN else f"[{shown}]"


def checked_cycle(cycle: object, name: str = "cycle") -> LoadCycle:
    """Check that `cycle` is a load cycle; error messages call it `name`."""
    if not isinstance(cycle, LoadCycle):
        raise ModelError(
            f"{name}: a {type(cycle).__name__}; give a LoadCycle(mean=..., corners=[...])"
        )
    return cycle
