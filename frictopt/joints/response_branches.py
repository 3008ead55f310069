"""The curves of amplitude against frequency of a mode under one harmonic force."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ..base import Array
from .modal_oscillator import ModalOscillator

_COLUMNS = ["force", "frequency", "amplitude", "lag", "branch"]
# Rows of each side of a curve. They are dense at the peak, where the frequency turns.
_ROWS = 300


def branches_of(oscillator: ModalOscillator, force: float, a: Array, omega: Array) -> pd.DataFrame:
    """Rows of amplitudes (n,) at angular frequencies (n,), with their lag and branch."""
    balance = oscillator.balance(a, omega)
    branch = np.where(omega < oscillator.resonance(a), "below", "above").astype(object)
    branch[oscillator.slope(a, omega) < 0] = "between"
    lag = np.degrees(np.arctan2(balance.imag, balance.real))
    columns = force, omega / (2 * np.pi), a, lag, branch
    return pd.DataFrame(dict(zip(_COLUMNS, columns, strict=True)), columns=_COLUMNS)


def beyond_row(force: float, frequency: float) -> pd.DataFrame:
    """The row of an amplitude that lies beyond the curve."""
    row = {name: [value] for name, value in zip(_COLUMNS, (force, frequency), strict=False)}
    return pd.DataFrame(row | {"amplitude": [np.inf], "lag": [np.nan], "branch": ["beyond"]})


def response_curves(oscillator: ModalOscillator, force: float) -> pd.DataFrame:
    """All curves of a force: the one from rest, and then the detached ones."""
    peaks = oscillator.peaks(force)
    ends = [0.0, *peaks]
    if len(ends) % 2:
        ends.append(oscillator.largest)
    parts = []
    for least, most in zip(ends[::2], ends[1::2], strict=True):
        a = _amplitudes(oscillator, force, least, most)
        rising = _side(oscillator, force, a, -1)
        falling = _side(oscillator, force, a, 1)[::-1]
        parts.append(pd.concat([rising, falling]).assign(detached=least > 0))
    return pd.concat(parts, ignore_index=True)


def _amplitudes(oscillator: ModalOscillator, force: float, least: float, most: float) -> Array:
    """Amplitudes of a curve, dense at its ends where the frequency turns."""
    if least > 0:
        share = (1 - np.cos(np.linspace(0.0, np.pi, _ROWS))) / 2
    else:
        # Lowest amplitude of a curve, relative to the static one: it lies at twice the natural
        # frequency.
        lowest = 1 / 3
        least = min(lowest * force / float(oscillator.stiffness[0]), most / 2)
        share = np.sin(np.linspace(0.0, np.pi / 2, _ROWS))
    a = np.exp(np.log(least) + share * (np.log(most) - np.log(least)))
    a[[0, -1]] = least, most
    return np.asarray(a)


def _side(oscillator: ModalOscillator, force: float, a: Array, side: int) -> pd.DataFrame:
    """Rows below (-1) or above (1) the resonance; below it the static amplitude comes first."""
    omega = oscillator.frequencies(force, a, side)
    known = np.isfinite(omega)
    return branches_of(oscillator, force, a[known], omega[known])


def folds_of(curves: pd.DataFrame) -> pd.DataFrame:
    """Points of the curves at which a branch that is stable meets the one between."""
    is_between = (curves["branch"] == "between").to_numpy()
    same_curve = (curves["detached"].to_numpy()[1:] == curves["detached"].to_numpy()[:-1]) & (
        curves["force"].to_numpy()[1:] == curves["force"].to_numpy()[:-1]
    )
    turns = np.flatnonzero((is_between[1:] != is_between[:-1]) & same_curve)
    return curves.iloc[turns][["force", "frequency", "amplitude"]].reset_index(drop=True)


def detached_of(oscillator: ModalOscillator, force: float) -> list[dict[str, float]]:
    """Least and most amplitude at resonance of each detached curve; inf beyond the curve."""
    _, *peaks = [*oscillator.peaks(force), np.inf]
    return [
        {"force": force, "least": least, "most": most}
        for least, most in zip(peaks[::2], [*peaks[1::2], np.inf], strict=False)
        if np.isfinite(least)
    ]
