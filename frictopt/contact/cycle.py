"""Load cycles: a static load, the corners of a cyclic load, and a cyclic part of fixed size."""

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
    Loads,
    Table,
    checked_loads,
    finite_number,
    kept,
    listed,
    number_of,
    shown,
    warns_of_odd_values,
)
from ..errors import ModelError
from .components import parted
from .history import harmonic_corners, history_corners, independent_corners
from .system import ContactSystem, checked_system, reactions


@kept
@warns_of_odd_values
@dataclass(frozen=True)
class LoadCycle:
    """A mean load and the corners of a closed cycle around it.

    Between corners the load is linear in time. At load factor `lam` corner k carries the loads
    `mean + fixed[k] + lam * corners[k]`. Theory, eq. (5).

    Parameters
    ----------
    mean
        Static load, load case name -> amplitude (in the unit of the load case).
    corners
        The K corners in the order in which they are visited, each load case name -> amplitude at
        load factor 1.
    fixed
        The K parts of the cycle that the load factor does not scale, one for each corner: load case
        name -> amplitude. None: no fixed part. If all `corners` are equal, the load factor scales a
        static load, and only the fixed part varies. Transients begin at the mean load, which should
        lie within the range of the fixed loads.
    times
        The K times of the corners, numbers or dates. A further time may follow: the time at which
        the load returns to the first corner. A `timedelta` becomes a number of seconds. The times
        only name the corners, because friction does not depend on time. None: they are unknown.

    Raises
    ------
    ModelError
        No corner, a number of fixed parts or times that does not match, a name that is not a text,
        amplitudes that are not finite, times that are neither numbers nor dates. A function that
        uses the cycle also refuses load cases that its system does not have.

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

    mean: Loads
    corners: Sequence[Loads]
    fixed: Sequence[Loads] | None = None
    times: Sequence[object] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        mean = checked_loads("mean", self.mean)
        corners = _checked_corners("corners", self.corners)
        if not corners:
            raise ModelError("corners: empty; a load cycle visits at least one corner")
        fixed = None
        if self.fixed is not None:
            fixed = _checked_corners("fixed", self.fixed)
            if len(fixed) != len(corners):
                raise ModelError(
                    f"fixed: {number_of(len(fixed), 'load')} for "
                    f"{number_of(len(corners), 'corner')}; give one for each corner, {{}} for a "
                    "corner without one"
                )
            if not any(fixed):
                fixed = None
        times = None if self.times is None else _checked_times(self.times, len(corners))
        vars(self).update(mean=mean, corners=corners, fixed=fixed, times=times)

    def __hash__(self) -> int:
        loads = self.mean, *self.corners, *(self.fixed or ())
        return hash(tuple(frozenset(load.items()) for load in loads))

    def __repr__(self) -> str:
        fixed = "" if self.fixed is None else f", fixed={_printed(self.fixed)}"
        return f"LoadCycle(mean={dict(self.mean)}, corners={_printed(self.corners)}{fixed})"

    @cached_property
    def corner_names(self) -> tuple[str, ...]:
        """Names of the corners, such as "t = 2.5: sigma = +1, Q = +0.5".

        A name has the time of the corner, if it is known, and the loads at load factor 1 without
        the mean load. If there are more than six loads, it has the first five, and the number of
        the corner.
        """
        names = []
        for k, corner in enumerate(self.corners):
            loads = _amplitude_texts(corner)
            if self.fixed is not None:
                loads += [f"{text} fixed" for text in _amplitude_texts(self.fixed[k])]
            name = ", ".join(loads) or "mean load"
            if len(loads) > 6:
                name = f"{', '.join(loads[:5])} and {len(loads) - 5} more loads (corner {k})"
            if self.times is not None:
                time = self.times[k]
                name = f"t = {f'{time:g}' if isinstance(time, Real) else time}: {name}"
            names.append(name)
        counts = Counter(names)
        for k, name in enumerate(names):
            if counts[name] > 1:
                names[k] = f"{name} (corner {k})"
        return tuple(names)

    @property
    def unscaled(self) -> tuple[Loads, ...]:
        """The loads that the load factor does not scale: `mean + fixed[k]` at the K corners.

        Without a fixed part it is the mean load, once.
        """
        if self.fixed is None:
            return (self.mean,)
        return tuple(_sum(self.mean, part) for part in self.fixed)

    def at(self, load_factor: float) -> tuple[Loads, ...]:
        """The loads at the K corners at a load factor, load case name -> amplitude."""
        unscaled = self.unscaled
        if self.fixed is None:
            unscaled = unscaled * len(self.corners)
        return tuple(
            _sum(loads, corner, load_factor)
            for loads, corner in zip(unscaled, self.corners, strict=True)
        )

    @classmethod
    def from_history(
        cls,
        history: Table,
        *,
        mean: Loads | None = None,
        time: str | None = None,
        tolerance: float = 0.0,
    ) -> Self:
        """The load cycle that repeats a measured history; at load factor 1 it is the history.

        Points on the straight segment between their neighbours are left out, because friction does
        not depend on time. A last row that equals the first is left out too. This changes no
        answer.

        Parameters
        ----------
        history
            pandas DataFrame with a row for each point in time and a column for each load case: its
            whole amplitude, static part included.
        mean
            Static part of the loads, which the load factor does not scale: load case name ->
            amplitude. A corner is its row minus this mean. A load case without a column is
            constant. None: for each column the mean of its smallest and its largest amplitude.
        time
            Name of the column with the time; the rows must be sorted by it. None: the column
            "time", or the index if it holds dates or time differences or has the name "time". The
            corners have their times, and the time of a last row that equals the first one is the
            time of the return.
        tolerance
            Tolerance that removes noise, as a share of the range of each load case. The corners
            keep the order of the history. Every measured load lies within this share of a straight
            segment between two corners. A single load case keeps its reversals of more than twice
            this share. With 0, all turning points remain. If a load is constant up to noise, its
            range is the noise: leave its column out and give it in `mean`.

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

        With a tolerance of 30 % of the range, the last row stays although it is no reversal:

        >>> fo.LoadCycle.from_history(history, tolerance=0.3).times
        (0, 2, 3)
        """
        static, corners, times = history_corners(history, mean, time, tolerance)
        return cls(static, corners, times=times)

    @classmethod
    def harmonic(
        cls,
        loads: Mapping[str, float | tuple[float, float]],
        *,
        mean: Loads,
        points: int = 16,
    ) -> Self:
        """The load cycle of loads that vary as cosines of one frequency around a mean load.

        At the angle t of the cycle a load of amplitude a and phase phi is `a cos(t + phi)`: a load
        with a phase of 90 degrees leads a load of phase 0 by a quarter of the cycle. Together the
        loads run along an ellipse, and the corners are points of the ellipse, at equal steps of t.
        If there is one load, or all are in phase or opposed, they run along a straight line. Then
        the corners are its two ends, and the cycle is exact, because friction does not depend on
        time.

        The polygon of `points` corners leaves out up to `1 - cos(pi / points)` of the amplitude of
        an ellipse: 1.9 % with 16 points, 0.5 % with 32. While all nodes stay closed, the shakedown
        limit of the ellipse is at most the limit of the polygon, and at least `cos(pi / points)`
        times this limit. The reason is that the loads at which a given slip is safe are a convex
        set, and the polygon contains the ellipse scaled by this factor. Steady states, their work
        and the guaranteed limit have no such bound: repeat them with twice the points.

        Parameters
        ----------
        loads
            Load case name -> amplitude at load factor 1, or (amplitude, phase in degrees). A
            negative amplitude adds 180 degrees to the phase.
        mean
            Static load, which the load factor does not scale: load case name -> amplitude.
        points
            Number of corners on an ellipse, >= 3.

        Raises
        ------
        ModelError
            No amplitude other than 0, amplitudes and phases that are no finite numbers, fewer than
            three points.

        Examples
        --------
        Vibration shears a contact, while spin, a quarter of the cycle ahead, takes up to a
        twentieth of the preload off:

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
        mean: Loads,
        *loads: Mapping[str, Sequence[float]] | Sequence[Loads],
    ) -> Self:
        """The vertices of a domain in which several loads vary independently, around a mean load.

        The safe loads of a slip are a convex set, so a slip that is safe at all vertices is safe
        for every load in the domain. The shakedown limit of the vertices therefore holds for all
        load histories in the domain (Bjorkman & Klarbring 1987).

        The vertices say less about transients. A transient that comes to rest with all nodes closed
        stays at rest for every later history in the domain. A transient that slips for ever shows
        that some histories never come to rest. Under other histories, or from other starts, the
        contact may dissipate more than under the vertices in the given order, and may even slip for
        ever although it comes to rest under the vertices.

        Parameters
        ----------
        mean
            Static load, load case name -> amplitude.
        loads
            Each load is either a box or a polytope. A box, load case name -> (least, most), has
            load cases that vary independently. A polytope is one load that moves within the hull of
            its corners, such as a rotating force; it is given as the list of these corners, each
            load case name -> amplitude. No load case belongs to two loads.

        Raises
        ------
        ModelError
            No load is given, a load case belongs to two loads, a range is not a pair in rising
            order, or there are more than 100,000 vertices.

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
        """(K, N) reactions `q0, p0` of the closed, unslipped contact at load factor 0.

        Row k belongs to corner k. Without a fixed part there is one row (1, N) for all corners.
        """
        closed = reactions(system, self.unscaled) - system.pressing_shut(system.gap)
        return parted(closed, system.tangents + 1)

    def corner_reactions(self, system: ContactSystem) -> tuple[Array, Array]:
        """(K, N) bonded reactions `q1, p1` of the corners at load factor 1.

        The mean load and the fixed part are not included.
        """
        return parted(reactions(system, self.corners), system.tangents + 1)


def _checked_corners(name: str, loads: object) -> tuple[Loads, ...]:
    """Check a list of load corners, each load case name -> amplitude."""
    if isinstance(loads, Mapping | str) or not isinstance(loads, Sequence):
        hint = ""
        if hasattr(loads, "to_dict"):
            hint = " (its to_dict('records') converts it)"
        raise ModelError(
            f"{name}: a {type(loads).__name__}; give a list{hint} of load corners, each load case "
            "name -> amplitude"
        )
    return tuple(checked_loads(f"{name}[{k}]", load) for k, load in enumerate(loads))


def _checked_times(times: object, corners: int) -> tuple[object, ...]:
    """Check the times of the corners, numbers or dates; time differences become seconds."""
    checked = []
    second = np.timedelta64(1, "s")
    for time in listed("times", times):
        if isinstance(time, timedelta | np.timedelta64):
            time = float(time / second)
        checked.append(time)
    if len(checked) - corners not in (0, 1):
        raise ModelError(
            f"times: {len(checked)} for {number_of(corners, 'corner')}; give one for each corner, "
            "and one more for the return to the first corner"
        )
    for time in checked:
        if isinstance(time, Real):
            finite_number("times", time)
            continue
        # A missing date (NaT) is not equal to itself.
        is_date = hasattr(time, "isoformat") and time == time
        if not is_date:
            raise ModelError(
                f"times: {shown(time)} is neither a number nor a date; give numbers or dates "
                "(pandas.to_datetime converts texts)"
            )
    return tuple(checked)


def _sum(load: Loads, added: Loads, factor: float = 1.0) -> dict[str, float]:
    """A load plus a multiple of another one."""
    total = dict(load)
    for name, amplitude in added.items():
        total[name] = load.get(name, 0.0) + factor * amplitude
    return total


def _amplitude_texts(loads: Loads) -> list[str]:
    """Texts such as "Q = +0.5" of the loads that are not zero up to rounding."""
    largest = max(map(abs, loads.values()), default=0.0)
    return [
        f"{case} = {amplitude:+.4g}"
        for case, amplitude in loads.items()
        if abs(amplitude) > ROUNDING * largest
    ]


def _printed(loads: Sequence[Loads]) -> str:
    """A list of loads as a text; a long list is cut, and its length follows."""
    # The number of loads that are printed: two independent loads have four corners.
    printed = 4
    text = ", ".join(str(dict(load)) for load in loads[:printed])
    if len(loads) > printed:
        return f"[{text}, ... {len(loads)} in all]"
    return f"[{text}]"


def checked_cycle(cycle: object, name: str = "cycle") -> LoadCycle:
    """Check that `cycle` is a load cycle; error messages call it `name`."""
    if not isinstance(cycle, LoadCycle):
        raise ModelError(
            f"{name}: a {type(cycle).__name__}; give a LoadCycle(mean=..., corners=[...])"
        )
    return cycle
