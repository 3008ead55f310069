"""Forces of a swing that the first harmonic of one mode leaves out.

The force of the loop has a mean and harmonics, which move the mode itself. A quasi-static loop
moves the other modes as their stiffness says. At multiples of the frequency they respond
dynamically, most of all if a multiple is near a natural frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import Array, Outcome, choice
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from ..transients import SteadyState
from .curve_load import opposed_direction
from .swing import swing_of

# The numbers of the interaction.

# Damping ratio of the other modes, which bounds their answer at a multiple of the frequency.
_DAMPING = 0.005
# Relative compliance between two loads up to which they are of two modes. Other codes write
# modes with few digits.
_ORTHOGONAL = 1e-2


@dataclass(frozen=True)
class OtherModes:
    """The loads of other modes of unit modal mass: their columns in `bonded`, and frequencies."""

    columns: Array
    squares: Array  # of the natural angular frequencies

    def forces(self, dynamic: Array, omega: float) -> float:
        """The largest modal force by which a mode's dynamic answer differs from the static one.

        `dynamic` (1 + harmonics, m) are the harmonics of the displacements of the loads, from the
        mean on, which is static.
        """
        harmonic = np.arange(len(dynamic))[:, None]
        ratio = harmonic * omega / np.sqrt(self.squares)
        gain = 1 / (1 - ratio**2 + 2j * _DAMPING * ratio) - 1
        return float((self.squares * np.linalg.norm(gain * dynamic, axis=0)).max())


def checked_modes(system: ContactSystem, cycle: LoadCycle, names: Sequence[str]) -> OtherModes:
    """Check the load cases of other modes: no load of two modes moves the other one."""
    direction = opposed_direction(system, cycle)
    assert direction is not None and system.compliance is not None
    columns = []
    for name in names:
        choice("other_modes", name, system.bonded)
        columns.append(list(system.bonded).index(name))
    L = system.compliance
    of_others = L[np.ix_(columns, columns)]
    own = float(direction @ L @ direction)
    for row, name in enumerate(names):
        square = of_others[row, row]
        across = np.abs(np.append(np.delete(of_others[row], row), L[columns[row]] @ direction))
        sizes = np.append(np.delete(np.diag(of_others), row), own)
        if not square > 0:
            raise ModelError(
                f"other_modes: the load case {name!r} does no work on the glued bodies; give the "
                "load of a mode, see `Modes.load`"
            )
        if (across > _ORTHOGONAL * np.sqrt(square * sizes)).any():
            raise ModelError(
                f"other_modes: the load case {name!r} also moves another of the modes; give loads "
                "of different modes, see `Modes.load`, without the mode of the cycle"
            )
    return OtherModes(np.array(columns, dtype=np.intp), 1 / np.diag(of_others))


def interaction_at(steady: SteadyState, others: OtherModes | None, omega: float) -> float:
    """Modal force that the first harmonic of the mode leaves out, over the load factor.

    The state swings with an angular frequency. The force is the largest one of the mode itself and
    of the other modes. NaN if no cosine has this loop.
    """
    rests = steady.outcome is Outcome.SHAKEDOWN
    if rests and steady.friction.all() and not steady.open.any():
        return 0.0
    path = steady.states()
    system = path.system
    direction = opposed_direction(system, steady.cycle)
    assert direction is not None
    moved = system.displacements(path.amplitudes, path.slip, path.gap)
    level = path.amplitudes @ direction / (direction @ direction)
    swing = swing_of(level, moved @ direction)
    if swing is None or steady.period > 1:
        return np.nan
    largest = _own_force(swing.harmonics(level[:, None])[:, 0])
    if others is not None:
        dynamic = swing.harmonics(moved[:, others.columns])
        largest = max(largest, others.forces(dynamic, omega))
    return largest / steady.load_factor


def _own_force(force: Array) -> float:
    """Modal force due to the motion of the mode by the mean and the harmonics of its force.

    The mean moves the mode as its stiffness says, and the harmonic n moves its unit mass, both by
    about the force, divided by the square of the frequency and by n^2.
    """
    divisor = np.maximum(np.arange(len(force)), 1) ** 2
    moves = np.abs(force) / divisor
    # The first harmonic is in balance with the excitation.
    return float(np.linalg.norm(np.delete(moves, 1)))
