"""Steady states at the amplitudes that a response needs. They join the points of its curve.

Between the load factors of a curve, stiffness and loss are interpolated. A steady state at the
amplitude of a peak shows the force that the peak needs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from ..errors import NoContinuation, SolverError
from .modal_oscillator import ModalOscillator

# The mode at some points, and the wanted amplitudes, each with the name of what wants it.
WantedOf: TypeAlias = Callable[[pd.DataFrame], tuple[ModalOscillator, Iterable[tuple[str, float]]]]


# The numbers of the check.

# Relative difference in amplitude, and in the force that it needs, up to which a state is at a
# wanted amplitude.
_SAME = 0.01
# Most steady states for one name. 300 forces on random joints of one mass needed at most 10.
_MOST = 20
# Each third state halves an interval of load factors, because interpolation fails where a small
# rise of the load moves the joint far.
_HALVED = 3


def checked_points(
    points: pd.DataFrame, wanted_of: WantedOf, follow: Callable[[float], dict[str, Any]]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Follow the joint at wanted amplitudes until a state of the curve is at each of them.

    Parameters
    ----------
    points
        The points of the curve, with the columns load_factor, displacement, resonance, steady and
        those that `wanted_of` needs; the first two rise.
    wanted_of, follow
        See `WantedOf`; the row of a point at a load factor, with its steady state.

    Returns
    -------
    DataFrame
        The points with the states that have joined.
    dict
        Name -> reason why no state is at its amplitude.
    """
    unchecked = dict[str, str]()
    followed = Counter[str]()
    while True:
        oscillator, wanted = wanted_of(points)
        far = (
            (name, a)
            for name, a in wanted
            if name not in unchecked and not _has_state_at(oscillator, a)
        )
        name, a = next(far, ("", np.nan))
        if np.isnan(a):
            return points, unchecked
        if followed[name] == _MOST:
            unchecked[name] = f"{_MOST} steady states near it are not enough"
            continue
        followed[name] += 1
        factor = _load_factor(points, a, followed[name] % _HALVED == 0)
        try:
            row = pd.DataFrame([follow(factor)], columns=points.columns)
        except (NoContinuation, SolverError) as error:
            unchecked[name] = f"no steady state at the load factor {factor:g}: {error}"
            continue
        joined = pd.concat([points, row], ignore_index=True).sort_values("load_factor")
        if row["resonance"].isna().all():
            unchecked[name] = f"no resonance at the load factor {factor:g}"
        elif not (np.diff(joined["displacement"]) > 0).all():
            unchecked[name] = f"the amplitude does not rise at the load factor {factor:g}"
        else:
            points = joined.reset_index(drop=True)


def _has_state_at(oscillator: ModalOscillator, a: float) -> bool:
    """Whether a state is at an amplitude, and needs the same force."""
    nearest = oscillator.amplitude[np.abs(oscillator.amplitude - a).argmin()]
    needed, wanted = oscillator.needed(np.array([nearest, a]))
    return bool(abs(nearest - a) <= _SAME * a and abs(needed - wanted) <= _SAME * wanted)


def _load_factor(points: pd.DataFrame, a: float, is_halved: bool) -> float:
    """Load factor of an amplitude by interpolation, or halfway between its two neighbours."""
    amplitudes = np.append(0.0, points["displacement"])
    factors = np.append(0.0, points["load_factor"])
    if is_halved:
        above = int(np.searchsorted(amplitudes, a))
        return float(factors[above - 1 : above + 1].mean())
    return float(PchipInterpolator(amplitudes, factors)(a))
