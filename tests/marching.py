"""Friction marched in small increments whose status is found by trying all: slow, and without any method that it could share with the package."""

from itertools import product
from typing import NamedTuple

import numpy as np


class Cycle(NamedTuple):
    """The last cycle of a march, one entry for each start."""

    slip: np.ndarray  # (starts, N), at its end
    work: np.ndarray  # of friction, with the mean of the pressures at the two ends of each increment
    least_pressure: np.ndarray


def statuses(A, B, f):
    """All ways to move and the inverses that go with them: node by node stick (0), forward (q + f p = 0) or backward (f p - q = 0)."""
    ways = []
    for status in product((0, 1, -1), repeat=len(A)):
        sense = np.array(status)
        rows = np.where((sense != 0)[:, None], A + (sense * f)[:, None] * B, np.eye(len(A)))
        if np.linalg.cond(rows) < 1e10:  # a body that no node holds has no slip of its own
            ways.append((sense, np.linalg.inv(rows)))
    return ways


def increment(A, B, f, q, p, v, ways):
    """Slips (starts, N) after a load (q, p) has come on, in full contact."""
    result = np.full_like(v, np.nan)
    for sense, inverse in ways:
        moving = sense != 0
        trial = np.where(moving, -(q + sense * f * p), v) @ inverse.T
        trial = np.where(moving, trial, v)  # sticking nodes keep their slip to the last bit
        forces, bound = q + trial @ A.T, f * (p + trial @ B.T)
        legal = np.where(moving, sense * (trial - v) >= 0, np.abs(forces) <= bound + 1e-12).all(axis=1)
        result = np.where((legal & np.isnan(result[:, 0]))[:, None], trial, result)
        if not np.isnan(result).any():
            return result
    raise AssertionError("no status is admissible")


def last_cycle(system, load_factor, starts, increments=6, cycles=80):
    """March `(A, B, q0, p0, q1, p1, f)` from each start, `s = -1 .. 1 .. -1` again and again, in full contact; where slip dies out does
    not depend on the increments, of which there are as many from corner to corner.
    """
    A, B = (np.atleast_2d(np.array(matrix, dtype=float)) for matrix in system[:2])
    q0, p0, q1, p1, f = (np.broadcast_to(np.asarray(value, dtype=float), len(A)) for value in system[2:])
    half = np.linspace(-1, 1, increments + 1)
    ways = statuses(A, B, f)
    v = increment(A, B, f, q0 - load_factor * q1, p0 - load_factor * p1, np.array(starts, dtype=float), ways)
    for _ in range(cycles):
        pressure = p0 - load_factor * p1 + v @ B.T
        work, least = np.zeros(len(v)), pressure.min(axis=1)
        for s in np.r_[half[1:], half[-2::-1]]:
            new = increment(A, B, f, q0 + s * load_factor * q1, p0 + s * load_factor * p1, v, ways)
            before, pressure = pressure, p0 + s * load_factor * p1 + new @ B.T
            work += (f * (before + pressure) / 2 * np.abs(new - v)).sum(axis=1)
            least = np.minimum(least, pressure.min(axis=1))
            v = new
    return Cycle(v, work, least)
