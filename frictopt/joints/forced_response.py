"""The forced response of a joint near a resonance, from its backbone curve.

The response is approximated by a single mode, whose stiffness and loss come from quasi-static
steady cycles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Booleans,
    Kept,
    Plotted,
    check_entries,
    finite_array,
    frame,
)
from ..errors import ModelError
from .modal_oscillator import ModalOscillator

_COLUMNS = (
    "force",
    "peak",
    "resonance",
    "lag",
    "least_peak",
    "most_peak",
    "sensitivity",
    "interaction",
    "beyond",
)


@dataclass(frozen=True, eq=False, repr=False)
class ForcedResponse(Kept, Plotted):
    """The response of a mode with friction to harmonic forces near its resonance.

    It is an approximation, not a bound: it has one mode with its first harmonic, and the
    quasi-static work of friction. The page Validity, "The forced response", lists its errors.

    Attributes
    ----------
    force
        (F,) amplitudes of the modal force, in units of force / square root of mass.
    peak
        (F,) largest amplitude of a sweep from rest; inf if it lies beyond the curve. An amplitude
        is a modal amplitude or, with a `scale`, the amplitude at a point.
    resonance, lag
        (F,) frequency of the excitation at the peak, and the phase lag of the motion there, in
        degrees, near 90. NaN beyond the curve.
    least_peak, most_peak
        (F,) the smallest and the largest peak over the residual slips in the range of the curve, if
        the vibration may start at any amplitude. A sweep shakes out most residual slip, so it sees
        only a part of this band. NaN without a range; inf beyond the curve.
    sensitivity
        (F,) -d ln peak / d ln work: if the work of friction is larger by a small share, the peak is
        smaller by about this number times the share. The number is computed from the peaks of this
        force and of a force that is 5 % smaller. 0 without friction. NaN beyond the curve.
    interaction
        (F,) relative change of the peak that two effects outside the approximation may cause:
        harmonics of the frequency move the mode itself, and `other_modes` respond to harmonics
        dynamically, not statically. Use it to compare peaks: it does not estimate their error. NaN
        beyond the curve.
    beyond
        (F,) whether the peak lies above the largest amplitude of the curve.
    branches
        DataFrame of the response curves: columns force, frequency, amplitude, lag, branch, detached
        (whether the row belongs to a detached curve). Branches are "below" and "above" the
        resonance, and "between" for the unstable part of a fold.
    folds
        DataFrame of the points at which a sweep jumps: columns force, frequency, amplitude.
    detached
        DataFrame of curves that a sweep from rest does not reach: columns force, least and most
        (both are amplitudes at resonance); most is inf beyond the curve.
    damping
        Damping ratio of material and air for the glued mode.
    scale
        Motion of the point whose amplitudes are listed, for a modal amplitude of 1.
    oscillator
        Stiffness and loss of the mode at the amplitudes of the curve.
    note
        Effects that the numbers do not include, in words.
    units
        Names of the units; None: not known.

    Examples
    --------
    A mass on a spring and on a slider, which begins to slip at the amplitude 2. Without other
    damping the balance of energy with friction bounds the peak.

    >>> import numpy as np
    >>> import frictopt as fo
    >>> loads = {"N": ([0.0], [1.0]), "mode": ([-1.0], [0.0])}
    >>> blocks = [[1.0]], [[0.0]], [[1.0]], [0.0], loads
    >>> slider = fo.ContactSystem.from_blocks(*blocks, compliance=[[0, 0], [0, 1]])
    >>> cycle = fo.LoadCycle({"N": 2.0}, [{"mode": 1.0}, {"mode": -1.0}])
    >>> factors = np.geomspace(1.0, 8.0, 40)
    >>> curve = fo.joints.backbone_curve(slider, cycle, 1.0, factors, natural_frequency=0.5 / np.pi)
    >>> answer = curve.response([0.6])
    >>> exact = 2 / (1 - np.pi * 0.6 / 4)
    >>> answer.peak.round(2).tolist(), round(exact, 2), answer.beyond.tolist()
    ([3.78], 3.78, [False])
    """

    _shown_names = ("force", "peak", "resonance", "sensitivity", "interaction", "damping", "note")
    force: Array
    peak: Array
    resonance: Array
    lag: Array
    least_peak: Array
    most_peak: Array
    sensitivity: Array
    interaction: Array
    beyond: Booleans
    branches: pd.DataFrame
    folds: pd.DataFrame
    detached: pd.DataFrame
    damping: float
    scale: float
    oscillator: ModalOscillator
    note: str
    units: str | None

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame with a row for each force; `attrs["note"]` is the note.

        The columns are force, peak, resonance, lag, least_peak, most_peak, sensitivity,
        interaction, beyond.
        """
        table = frame({name: getattr(self, name) for name in _COLUMNS}, units=self.units)
        table.attrs["note"] = self.note
        return table


def positive_numbers(name: str, values: ArrayLike) -> Array:
    """Check one finite number above 0, or a list of them; returns (n,)."""
    numbers = np.atleast_1d(finite_array(name, values))
    if numbers.ndim > 1 or not len(numbers):
        raise ModelError(f"{name}: shape {numbers.shape}; give a list of numbers")
    check_entries(name, numbers, numbers > 0, "give numbers above 0", "index")
    return numbers


# The curves of amplitude against frequency of a mode under one harmonic force.

# Rows of each side of a curve. The rows are dense at the peak, where the frequency turns.
_ROWS = 300


def response_curves(oscillator: ModalOscillator, force: float) -> pd.DataFrame:
    """All curves of a force: first the curve from rest, then the detached curves."""
    parts = []
    for least, most in _ends_of_curves(oscillator, force):
        a = _amplitudes(oscillator, force, least, min(most, oscillator.largest))
        rising = _side(oscillator, force, a, -1)
        falling = _side(oscillator, force, a, 1)[::-1]
        parts.append(pd.concat([rising, falling]).assign(detached=least > 0))
    return pd.concat(parts, ignore_index=True)


def _ends_of_curves(oscillator: ModalOscillator, force: float) -> list[tuple[float, float]]:
    """Least and most amplitude of each curve of a force; inf beyond the known amplitudes."""
    ends = [0.0, *oscillator.peaks(force)]
    if len(ends) % 2:
        ends.append(np.inf)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _amplitudes(oscillator: ModalOscillator, force: float, least: float, most: float) -> Array:
    """Amplitudes of a curve, dense at its ends where the frequency turns."""
    if least > 0:
        share = (1 - np.cos(np.linspace(0.0, np.pi, _ROWS))) / 2
    else:
        # Lowest amplitude of a curve, relative to the static amplitude. The curve reaches it at
        # twice the natural frequency.
        lowest = 1 / 3
        least = min(lowest * force / float(oscillator.stiffness[0]), most / 2)
        share = np.sin(np.linspace(0.0, np.pi / 2, _ROWS))
    a = np.exp(np.log(least) + share * (np.log(most) - np.log(least)))
    a[[0, -1]] = least, most
    return np.asarray(a)


def _side(oscillator: ModalOscillator, force: float, a: Array, side: int) -> pd.DataFrame:
    """Rows below (-1) or above (1) the resonance, see `ForcedResponse.branches`.

    Rows below the resonance begin at the static amplitude.
    """
    omega = oscillator.frequencies(force, a, side)
    known = np.isfinite(omega)
    a, omega = a[known], omega[known]
    balance = oscillator.balance(a, omega)
    branch = np.where(omega < oscillator.resonance(a), "below", "above").astype(object)
    branch[oscillator.slope(a, omega) < 0] = "between"
    return pd.DataFrame(
        {
            "force": force,
            "frequency": omega / (2 * np.pi),
            "amplitude": a,
            "lag": np.angle(balance, deg=True),
            "branch": branch,
        }
    )


def folds_of(curves: pd.DataFrame) -> pd.DataFrame:
    """Points of the curves at which a stable branch meets the branch "between"."""
    is_between = (curves["branch"] == "between").astype(float)
    change = is_between.groupby([curves["force"], curves["detached"]]).diff(-1)
    turns = change.fillna(0.0) != 0
    return curves.loc[turns, ["force", "frequency", "amplitude"]].reset_index(drop=True)


def detached_of(oscillator: ModalOscillator, force: float) -> list[dict[str, float]]:
    """Least and most amplitude at resonance of each detached curve; inf beyond the curve."""
    _, *detached = _ends_of_curves(oscillator, force)
    return [{"force": force, "least": least, "most": most} for least, most in detached]
