"""The lower bound of the guaranteed limit by periodic sequences of increments.

It is compared with an enumeration of all statuses of the nodes.
"""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from helpers.cases import few
from helpers.systems import CYCLE, random_system
from studies.validation import oracles
from studies.validation.lower_bound import lower_bound, periodic_bounds

STICK, FORWARD, BACKWARD, OPEN = 0, 1, -1, 2


def returning(status):
    """Whether some node slips in one increment and comes back in another one.

    Rows are increments, columns are nodes. A node comes back by slip or while it is open.
    """
    slides = np.abs(status) == 1
    goes, comes = (status == FORWARD) | (status == OPEN), (status == BACKWARD) | (status == OPEN)
    return bool((slides.any(axis=0) & goes.any(axis=0) & comes.any(axis=0)).any())


def least_by_enumeration(contact, cycle, friction):
    """Least load factor of a periodic sequence of increments in which some node returns.

    One linear program is solved for each status of all corners.
    """
    n, corners = contact.nodes, len(cycle.corners)
    f = np.broadcast_to(friction, n)
    mean = np.concatenate(cycle.mean_reaction(contact))
    cyclic = np.hstack(cycle.corner_reactions(contact))
    width = 2 * n * corners + 1
    reaction = np.zeros((corners, 2 * n, width))
    motion = np.zeros((corners, 2 * n, width))
    for k in range(corners):
        here, before = 2 * n * k, 2 * n * ((k - 1) % corners)
        reaction[k, :, here : here + 2 * n], reaction[k, :, -1] = contact.S, cyclic[k]
        motion[k, :, here : here + 2 * n] = np.eye(2 * n)
        motion[k, :n, before : before + n] -= np.eye(n)
    least = np.inf
    for choice in product((STICK, FORWARD, BACKWARD, OPEN), repeat=n * corners):
        status = np.array(choice).reshape(corners, n)
        if not returning(status):
            continue
        zero, high = [], []  # rows and their right sides
        for k in range(corners):
            for i in range(n):
                q, p, moved, w = reaction[k, i], reaction[k, n + i], motion[k, i], motion[k, n + i]
                q0, p0, s = mean[i], mean[n + i], int(status[k, i])
                if s == OPEN:
                    zero += [(q, -q0), (p, -p0)]
                    high += [(-w, 0.0)]
                    continue
                zero += [
                    (w, 0.0),
                    (moved, 0.0) if s == STICK else (q + s * f[i] * p, -q0 - s * f[i] * p0),
                ]
                high += [
                    (-p, p0),
                    (q - f[i] * p, f[i] * p0 - q0),
                    (-q - f[i] * p, f[i] * p0 + q0),
                    *[(-s * moved, 0.0)] * (s != STICK),
                ]
        bounds = [(None, None)] * (width - 1) + [(0, None)]
        answer = linprog(
            np.eye(width)[-1],
            *(np.array(part) for rows in (high, zero) for part in zip(*rows, strict=True)),
            bounds,
        )
        if answer.status == 0:
            least = min(least, answer.x[-1])
    return least


@pytest.mark.parametrize("seed", few(range(3)))
def test_the_mixed_integer_program_against_enumeration(seed):
    """The mixed-integer program agrees with the enumeration, with separation of nodes.

    The range of loads reaches far above the limit, so that the program alone decides.
    """
    contact = random_system(np.random.default_rng(seed), 2)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.4)
    found = lower_bound(contact, CYCLE, 0.4, 3 * limit.shakedown.load_factor, witnessed=True)
    expected = least_by_enumeration(contact, CYCLE, 0.4)
    assert found.load_factor == pytest.approx(expected, rel=1e-6)
    assert found.found == pytest.approx(expected, rel=1e-6)
    assert limit.load_factor == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("least_friction", [0.05, 1e-3])
def test_every_state_lies_within_the_derived_bounds(least_friction):
    """With hardly any friction the slips follow the loads, so that they leave bounds around any
    other slip."""
    rng = np.random.default_rng(3)
    tight = np.inf
    for _ in range(12):
        contact = random_system(rng, 3)
        friction = rng.uniform(least_friction, 12 * least_friction)
        bounds = periodic_bounds(contact, CYCLE, friction, 5.0)
        (force, length) = oracles.units(contact, CYCLE)
        for load_factor in (0.0, 2.5, 5.0):
            path = fo.march(
                contact,
                CYCLE,
                friction,
                load_factor,
                initial_slip=rng.normal(size=3) * 10 ** rng.uniform(-1, 2),
                cycles=3,
            )
            corner = path.time == np.round(path.time)
            slip = path.slip[corner] / length
            gap = path.gap[corner] / length
            p = path.p[corner] / force
            assert (slip >= bounds.slip_low).all() and (slip <= bounds.slip_high).all()
            assert (gap <= bounds.gap_high).all() and (p <= bounds.pressure_high).all()
            tight = min(tight, float((bounds.pressure_high / p.max(axis=0)).min()))
    assert tight < 2  # a bound that is far from every state would prove nothing
