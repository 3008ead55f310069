"""Work and slip of events within increments, which the states at their ends do not show.

An increment has only the states at its two ends. Between them the load on each node is assumed to
change linearly. The increment is exact if the node keeps sliding, or if its friction bound stays
constant. These functions estimate the missed work and slip if the node sticks for a part of the
increment, slips to and fro, opens or lands. So they detect events that are so close to a corner
that no number of increments separates them from it.
"""

from typing import NamedTuple

import numpy as np

from ..base import Array
from ..contact import ContactSystem, most_shear


class Doubts(NamedTuple):
    """Works and slips in doubt, see `doubts`, and the mean friction bound; (T - 1, N) each."""

    lacking: Array
    change: Array
    missed: Array
    late: Array
    bound: Array


def doubts(system: ContactSystem, friction: Array, u: Array, r: Array) -> Doubts:
    """Works and slips in doubt within the increments between T states (T, M).

    `lacking` is the work of friction, the mean bound times the path of slip, minus the work that
    the reactions do against the slip. It is positive if a node is below its bound for a part of the
    increment. `change` is the change of the bound times the path of slip.

    `missed` is the work of friction of a node before it opens within an increment. `late` is the
    distance between the point where a node lands and the point where the increment makes it stick.
    Increments include neither. Both are computed for each node by itself, under a load that changes
    linearly from the closed end to the open end. In the plane this is exact for a node that is not
    coupled to other nodes.
    """
    n = len(friction)
    gap = u[:, -n:] + system.gap
    slip_step = np.diff(u[:, :-n], axis=0).reshape(len(u) - 1, -1, n)
    forces = r.reshape(len(r), -1, n)
    closed = (forces != 0).any(axis=1)
    shear = forces[:, :-1]
    bound = most_shear(system, friction, forces[:, -1])

    path = np.linalg.norm(slip_step * closed[1:, None], axis=1)
    mean_bound = (bound[1:] + bound[:-1]) / 2
    mean_shear = (shear[1:] + shear[:-1]) / 2
    lacking = mean_bound * path + (mean_shear * slip_step * closed[1:, None]).sum(axis=1)
    change = np.abs(np.diff(bound, axis=0)) * path

    opens = closed[:-1] & ~closed[1:]
    lands = ~closed[:-1] & closed[1:] & (path == 0)
    row, node = np.nonzero(opens | lands)
    # The closed end of the increment of a node that lands is its last state.
    crossing = _Crossing(
        stiffness=system.S.reshape(-1, n, len(system.S) // n, n)[:, node, :, node],
        forces=forces[row + lands[row, node], :, node],
        slip_step=slip_step[row, :, node],
        gap=gap[row + opens[row, node], node],
    )
    slip = _slip_in_contact(crossing)
    distance = np.linalg.norm(slip, axis=1)
    pressure = _pressure_at_first_slip(crossing, friction[node], slip)
    missed = np.zeros_like(path)
    missed[row, node] = friction[node] * pressure / 2 * distance * opens[row, node]
    late = np.zeros_like(path)
    late[row, node] = distance * lands[row, node]
    return Doubts(np.maximum(lacking, 0.0), change, missed, late, mean_bound)


class _Crossing(NamedTuple):
    """E nodes that open or land within an increment, each by itself.

    `stiffness` (E, t + 1, t + 1) has the diagonal blocks of the nodes in the stiffness matrix.
    `forces` (E, t + 1) are their reactions `[q, p]` at the closed end, `slip_step` (E, t) their
    slips in the increment, and `gap` (E,) their gaps at the open end.
    """

    stiffness: Array
    forces: Array
    slip_step: Array
    gap: Array


def _slip_in_contact(crossing: _Crossing) -> Array:
    """(E, t) slip between the closed end and the point where the pressure vanishes.

    It lies between two slips without shear force: one releases the shear at the closed end, the
    other is the whole slip minus the part due to the gap. The pressure decreases linearly from the
    first to the second.
    """
    q, p = crossing.forces[:, :-1], crossing.forces[:, -1]
    coupling = crossing.stiffness[:, :-1, -1]
    shear_flexibility = np.linalg.pinv(crossing.stiffness[:, :-1, :-1], hermitian=True)
    slips = shear_flexibility @ np.stack([q, coupling], axis=2)
    # Slip that releases the shear, with opposite sign, and slip due to a unit closure of the gap.
    freed, per_gap = np.moveaxis(slips, 2, 0)

    pressure_left = np.maximum(p - (coupling * freed).sum(axis=1), 0.0)
    normal_stiffness = crossing.stiffness[:, -1, -1] - (coupling * per_gap).sum(axis=1)
    pull_of_gap = np.maximum(normal_stiffness, 0.0) * crossing.gap
    whole = np.where(pressure_left > 0, pressure_left + pull_of_gap, 1.0)
    share = (pressure_left / whole)[:, None]
    slip_without_gap = crossing.slip_step + per_gap * crossing.gap[:, None]
    slip: Array = share * slip_without_gap - (1 - share) * freed
    return slip


def _pressure_at_first_slip(crossing: _Crossing, friction: Array, slip: Array) -> Array:
    """(E,) pressure at which a slip (E, t) reaches its friction bound and begins."""
    size = np.linalg.norm(slip, axis=1)
    direction = slip / np.where(size > 0, size, 1.0)[:, None]
    motion = np.column_stack([crossing.slip_step, crossing.gap])
    # Change of the load from the closed end to the open one, where the node has no reactions.
    load_change = -crossing.forces - (crossing.stiffness @ motion[..., None])[..., 0]

    def slack(forces: Array) -> Array:
        value: Array = friction * forces[:, -1] + (forces[:, :-1] * direction).sum(axis=1)
        return value

    p = crossing.forces[:, -1]
    fall = slack(-load_change)
    share = slack(crossing.forces) / np.where(fall > 0, fall, 1.0)
    begins_at = np.where(fall > 0, p + load_change[:, -1] * share, p)
    return np.asarray(begins_at.clip(0.0, p))
