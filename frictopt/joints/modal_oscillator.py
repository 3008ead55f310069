"""A mode with the stiffness and the friction of its joint, and its response to a harmonic force.

A mode of unit modal mass with the amplitude a under the modal force `f cos(omega t)` obeys
`a |k + i (g + 2 zeta omega_0 omega) - omega^2| = f`. Here k is the stiffness of the first harmonic
of the loop, `g = W / (pi a^2)` the loss of friction, which does not depend on the frequency, and
zeta the damping ratio of material and air.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from ..base import Array, Kept, choice
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from ..transients import SteadyState
from .curve_question import loop_of, moves_as_glued, opposed_direction, swing_of

# The numbers of the search for amplitudes and frequencies.

# Ratio of neighbouring amplitudes in the search for roots. Two roots that are closer together are
# missed, but measured amplitudes scatter more than this.
_RATIO = 1.001
# Share of the static amplitude at which the search begins. There is no root below it.
_BEGIN = 0.5
# Halvings of a range of frequencies: 2^-60 of it is rounding.
_HALVINGS = 60
# Tolerance of the roots, relative.
_ROOT = 1e-14


@dataclass(frozen=True, eq=False, repr=False)
class ModalOscillator(Kept):
    """A mode at K rising amplitudes, with interpolation between them.

    Below the first amplitude the stiffness stays the same, and the loss falls in proportion to the
    amplitude, as if the work grew with the cube of the amplitude.

    Attributes
    ----------
    amplitude, stiffness, loss
        (K,) modal amplitude a, stiffness k of the first harmonic, and loss `W / (pi a^2)`.
    natural
        Angular frequency of the glued mode.
    damping
        Damping ratio of material and air.
    """

    amplitude: Array
    stiffness: Array
    loss: Array
    natural: float
    damping: float

    _shown_names = ("largest", "natural", "damping")

    @property
    def largest(self) -> float:
        """The largest amplitude that is known."""
        return float(self.amplitude[-1])

    @property
    def viscous(self) -> float:
        """Loss of material and air per angular frequency, `2 zeta omega_0`."""
        return 2 * self.damping * self.natural

    @cached_property
    def _stiffness(self) -> PchipInterpolator:
        values = np.r_[self.stiffness[0], self.stiffness]
        return PchipInterpolator(np.r_[0.0, self.amplitude], values)

    @cached_property
    def _loss(self) -> PchipInterpolator:
        return PchipInterpolator(np.r_[0.0, self.amplitude], np.r_[0.0, self.loss])

    def balance(self, a: Array | float, omega: Array | float) -> Array:
        """Real and imaginary part of `k + i (g + 2 zeta omega_0 omega) - omega^2`, as complex."""
        return np.asarray(
            self._stiffness(a) - omega**2 + 1j * (self._loss(a) + self.viscous * omega)
        )

    def force(self, a: Array | float, omega: Array | float) -> Array:
        """Modal force that holds an amplitude at an angular frequency."""
        return np.asarray(a * np.abs(self.balance(a, omega)))

    def resonance(self, a: Array | float) -> Array:
        """Angular frequency at which an amplitude needs the smallest force.

        It is the largest root of `u^3 + p u + q`, computed by trigonometric functions, or 0 if no
        root is above 0. Without damping of the material it is the square root of the stiffness.
        """
        p = self.viscous**2 / 2 - self._stiffness(a)
        q = self.viscous * self._loss(a) / 2
        size = 2 * np.sqrt(np.maximum(-p, 0.0) / 3)
        cosine = np.divide(3 * q, p * size, out=np.full(np.shape(p), -2.0), where=size > 0)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3
        return np.where(cosine >= -1, size * np.cos(angle), 0.0)

    def needed(self, a: Array | float) -> Array:
        """Modal force that holds an amplitude at its resonance."""
        return self.force(a, self.resonance(a))

    def slope(self, a: Array, omega: Array) -> Array:
        """Derivative d ln f / d ln a at a fixed frequency.

        If it is below 0, the motion is unstable.
        """
        value = self.balance(a, omega)
        change = self._stiffness.derivative()(a) + 1j * self._loss.derivative()(a)
        return np.asarray(1 + a * (value.conjugate() * change).real / np.abs(value) ** 2)

    def peaks(self, force: float) -> list[float]:
        """Amplitudes at which the resonance needs this force, rising.

        The curve from rest ends at the first of them. Between the second and the third amplitude
        lies a detached curve. The list is empty if the peak lies beyond the known amplitudes.
        """
        lowest = _BEGIN * force / (self.stiffness.max() + self.loss.max())
        if lowest >= self.largest:
            return []
        steps = int(np.log(self.largest / lowest) / np.log(_RATIO)) + 2
        grid = np.geomspace(lowest, self.largest, steps)

        def excess(a: Array) -> Array:
            return self.needed(a) - force

        above = excess(grid) > 0
        roots = []
        for first in np.flatnonzero(above[1:] != above[:-1]):
            pair = grid[first], grid[first + 1]
            roots.append(float(brentq(excess, *pair, xtol=1e-300, rtol=_ROOT)))
        return roots

    def frequencies(self, force: float, a: Array, side: int) -> Array:
        """Angular frequencies below (-1) or above (1) the resonance of amplitudes (n,).

        NaN for amplitudes that need less than the force at every frequency on this side. The
        frequencies are found by bisection between the resonance and a frequency that needs more
        than the force.
        """
        resonance = self.resonance(a)
        far = np.zeros(len(a)) if side < 0 else np.sqrt(self._stiffness(a) + force / a)
        near = resonance.copy()
        is_far_enough = self.force(a, far) >= force * (1 - 1e-12)
        is_far = far.copy()
        for _ in range(_HALVINGS):
            middle = (near + is_far) / 2
            needs_more = self.force(a, middle) > force
            is_far = np.where(needs_more, middle, is_far)
            near = np.where(needs_more, near, middle)
        return np.where(is_far_enough, is_far, np.nan)

    def friction_share(self, a: float) -> float:
        """Derivative d ln f / d ln W at an amplitude: the share of friction in the peak's force."""
        balance = complex(self.balance(a, self.resonance(a)))
        return float(self._loss(a)) * balance.imag / abs(balance) ** 2

    def strongest(self, amplitude: float) -> float:
        """The amplitude, up to a given one, that needs the largest force.

        The resonance of this force, swept from rest, stays at or below the given amplitude.
        """
        steps = int(np.log(1e6) / np.log(_RATIO))
        grid = np.geomspace(1e-6 * amplitude, amplitude, steps)
        return float(grid[self.needed(grid).argmax()])


# Forces of a swing that the first harmonic of one mode leaves out.
#
# The force of the loop has a mean and harmonics, which move the mode itself. In a quasi-static
# loop, the other modes move as their stiffness allows. In a vibration, they respond dynamically at
# multiples of the frequency, most of all if a multiple is near a natural frequency.

# The numbers of the interaction.

# Damping ratio of the other modes. It bounds the response of a mode if a multiple of the frequency
# meets the natural frequency of this mode.
_DAMPING = 0.005
# Relative compliance between two loads up to which they count as loads of two modes. This limit
# exceeds rounding, because other codes write modes with few digits.
_ORTHOGONAL = 1e-2


@dataclass(frozen=True)
class OtherModes:
    """The loads of other modes of unit modal mass: their columns in `bonded`, and frequencies."""

    columns: Array
    squares: Array  # of the natural angular frequencies

    def forces(self, dynamic: Array, omega: float) -> float:
        """The largest modal force by which a mode's dynamic and static responses differ.

        `dynamic` (1 + harmonics, m) are the harmonics of the displacements of the loads. Row 0 is
        the mean, which is static.
        """
        harmonic = np.arange(len(dynamic))[:, None]
        ratio = harmonic * omega / np.sqrt(self.squares)
        gain = 1 / (1 - ratio**2 + 2j * _DAMPING * ratio) - 1
        return float((self.squares * np.linalg.norm(gain * dynamic, axis=0)).max())


def checked_modes(system: ContactSystem, cycle: LoadCycle, names: Sequence[str]) -> OtherModes:
    """Check the load cases of other modes: the load of a mode moves no other mode."""
    direction = opposed_direction(system, cycle)
    assert direction is not None and system.compliance is not None
    cases = list(system.bonded)
    columns = [cases.index(choice("other_modes", name, cases)) for name in names]
    # Compliances between all of these modes; the mode of the cycle is the last one.
    directions = np.vstack([np.eye(len(cases))[columns], direction])
    compliance = directions @ system.compliance @ directions.T
    squares = np.diag(compliance)
    for row, name in enumerate(names):
        across = np.delete(np.abs(compliance[row]), row)
        sizes = np.delete(squares, row)
        if not squares[row] > 0:
            raise ModelError(
                f"other_modes: the load case {name!r} does no work on the glued bodies; give the "
                "load of a mode, see `Modes.load`"
            )
        if (across > _ORTHOGONAL * np.sqrt(squares[row] * sizes)).any():
            raise ModelError(
                f"other_modes: the load case {name!r} also moves another of the modes; give loads "
                "of different modes, see `Modes.load`, without the mode of the cycle"
            )
    return OtherModes(np.array(columns, dtype=np.intp), 1 / squares[:-1])


def interaction_at(steady: SteadyState, others: OtherModes | None, omega: float) -> float:
    """Modal force that the first harmonic of the mode leaves out, divided by the load factor.

    `omega` is the angular frequency of the motion. The force is the largest of the forces on the
    mode itself and on the other modes. NaN if the displacement does not swing like a cosine,
    because it stands still or turns back between the corners, or repeats only after two cycles.
    """
    if moves_as_glued(steady):
        return 0.0
    direction = opposed_direction(steady.system, steady.cycle)
    assert direction is not None
    level, displacements = loop_of(steady, direction)
    swing = swing_of(level, displacements @ direction)
    if swing is None or steady.period > 1:
        return np.nan
    largest = _own_force(swing.harmonics(level[:, None])[:, 0])
    if others is not None:
        dynamic = swing.harmonics(displacements[:, others.columns])
        largest = max(largest, others.forces(dynamic, omega))
    return largest / steady.load_factor


def _own_force(force: Array) -> float:
    """Modal force equivalent to the motions of a mode by the mean and harmonics of its force.

    The mean moves the mode by mean / stiffness; the stiffness is about the square of the frequency.
    Harmonic n moves the unit mass by its force / (n^2 times this square).
    """
    divisor = np.maximum(np.arange(len(force)), 1) ** 2
    moves = np.abs(force) / divisor
    # The first harmonic is in balance with the excitation.
    return float(np.linalg.norm(np.delete(moves, 1)))
