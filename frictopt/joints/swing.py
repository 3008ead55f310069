"""The loop of a load whose displacement swings like a cosine, and its harmonics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Array, Integers

# The numbers of the harmonics of a loop.

# Distance by which a displacement may turn back between two corners, relative to its range. It
# is rounding of the path.
_TURNING = 1e-9
# Distance between two states, relative to half the range, up to which the mean sine between
# them is that at their middle. The quotient of two small differences would be rounding there.
_STEP = 1e-8
# Number of times in a cycle at which harmonics are sampled, and number of harmonics.
_TIMES = 512
_HARMONICS = 12


@dataclass(frozen=True)
class Swing:
    """A load cycle to and fro at its states, with a displacement `mean + a cos t`.

    Attributes
    ----------
    legs
        Numbers of the states from the low end to the high end, one row for each way between the
        ends: up, and down in reverse order.
    place
        (T,) displacement of the states, -1 at the low end and 1 at the high end.
    """

    legs: tuple[Integers, Integers]
    place: Array

    def first_harmonic(self, force: Array) -> float:
        """(1 / pi) times the integral of a force (T,) times cos t over a cycle.

        Integration by parts turns it into the integral of the sine over the force. Between two
        states the force is linear in the displacement, so the mean of the sine is known in closed
        form.
        """
        total = 0.0
        for leg in self.legs:
            place = np.maximum.accumulate(self.place[leg])
            sine = np.sqrt(1 - place**2)
            area = (place * sine + np.arcsin(place)) / 2
            step = np.diff(place)
            middle = (place[1:] + place[:-1]) / 2
            mean_sine = np.sqrt(1 - middle**2)
            np.divide(np.diff(area), step, out=mean_sine, where=step > _STEP)
            total += float(np.diff(force[leg]) @ mean_sine)
        return total / np.pi

    def harmonics(self, values: Array) -> Array:
        """(1 + harmonics, m) complex amplitudes of values (T, m). Row 0 is their mean."""
        half = _TIMES // 2
        place = np.cos(np.pi * np.arange(half) / half)
        up, down = self.legs
        series = np.empty((_TIMES, values.shape[1]))
        for number, column in enumerate(values.T):
            series[:half, number] = np.interp(place, self.place[down], column[down])
            series[half:, number] = np.interp(-place, self.place[up], column[up])
        transformed = 2 * np.fft.rfft(series, axis=0) / _TIMES
        transformed[0] /= 2
        return np.asarray(transformed[: 1 + _HARMONICS])


def swing_of(level: Array, displacement: Array) -> Swing | None:
    """The swing of a load whose level rises from one corner to the other, and falls back.

    None if the displacement stands still or turns back between the corners: a cosine then has no
    loop.
    """
    length = np.ptp(displacement)
    if not length > 0:
        return None
    place = (2 * displacement - displacement.max() - displacement.min()) / length
    top = int(np.argmax(level))
    legs = np.arange(top + 1), np.arange(top, len(level))[::-1]
    for leg in legs:
        rises = (np.diff(place[leg]) >= -_TURNING).all()
        ends = np.abs(place[leg[[0, -1]]] - [-1, 1]).max() <= _TURNING
        if not (rises and ends):
            return None
    return Swing(legs, np.clip(place, -1.0, 1.0))
