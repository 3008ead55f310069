"""The lower bound of the guaranteed limit: periodic sequences of increments, against enumeration of all statuses."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from frictopt.models.cyclic_increments import cyclic_bound
from frictopt.models.periodic_bounds import periodic_bounds
from frictopt.models.task import Task, cycle_loads
from systems import CYCLE, FIRST_PAIR, SECOND_PAIR, random_system, system

STICK, FORWARD, BACKWARD, OPEN = 0, 1, -1, 2
FIRST, SECOND = (FIRST_PAIR, 0.6, 0.391864153760), (SECOND_PAIR, 0.4, 0.532623169108)


def returning(status):
    """Whether some node (column) slips in one increment (row) and comes back, by slip or while open, in another one."""
    slides = np.abs(status) == 1
    goes, comes = (status == FORWARD) | (status == OPEN), (status == BACKWARD) | (status == OPEN)
    return bool((slides.any(axis=0) & goes.any(axis=0) & comes.any(axis=0)).any())


def least_by_enumeration(contact, cycle, friction):
    """Least load factor of a periodic sequence of increments in which some node returns, by one linear program for each status of all corners."""
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
        zero, high, zero_at, high_at = [], [], [], []
        for k in range(corners):
            for i in range(n):
                q, p, moved, w = reaction[k, i], reaction[k, n + i], motion[k, i], motion[k, n + i]
                q0, p0, s = mean[i], mean[n + i], int(status[k, i])
                if s == OPEN:
                    zero += [q, p]
                    zero_at += [-q0, -p0]
                    high += [-w]
                    high_at += [0.0]
                    continue
                zero += [w] + [moved] * (s == STICK) + [q + s * f[i] * p] * (s != STICK)
                zero_at += [0.0] + [0.0] * (s == STICK) + [-q0 - s * f[i] * p0] * (s != STICK)
                high += [-p, q - f[i] * p, -q - f[i] * p] + [-s * moved] * (s != STICK)
                high_at += [p0, f[i] * p0 - q0, f[i] * p0 + q0] + [0.0] * (s != STICK)
        bounds = [(None, None)] * (width - 1) + [(0, None)]
        answer = linprog(np.eye(width)[-1], np.array(high), high_at, np.array(zero), zero_at, bounds)
        if answer.status == 0:
            least = min(least, answer.x[-1])
    return least


@pytest.mark.parametrize(("data", "friction", "expected"), [FIRST, SECOND, ((2.0, 0.5, 0.1, 1.0, 1.0, 0.2), 0.4, 0.393145161290)])
def test_published_instances_are_exact(data, friction, expected):
    limit = fo.guaranteed_limit(system(*data), CYCLE, friction, lower=True)
    assert limit.exact and limit.lower <= limit.upper and limit.lower == pytest.approx(expected, rel=1e-6)
    assert limit.increments.status == "optimal" and limit.increments.found == pytest.approx(expected, rel=1e-6)
    assert limit.increments.slips.shape == (2, len(limit.slip))


@pytest.mark.parametrize("seed", range(3))
def test_the_mixed_integer_program_against_enumeration(seed):
    """With separation and with a load range that reaches far above the limit, so that the program alone decides."""
    contact = random_system(np.random.default_rng(seed), 2)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.4)
    task = Task(contact, CYCLE, cycle_loads(contact, CYCLE), 0.4, False, False)
    found = cyclic_bound(task, 3 * limit.shakedown.load_factor, None, 60.0)
    expected = least_by_enumeration(contact, CYCLE, 0.4)
    assert found.load_factor == pytest.approx(expected, rel=1e-6) and found.found == pytest.approx(expected, rel=1e-6)
    assert limit.upper == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("nodes", "corners"), [(2, 3), (3, 2), (3, 4)])
def test_both_bounds_meet_on_random_systems(nodes, corners):
    rng = np.random.default_rng(10 * nodes + corners)
    for _ in range(4):
        contact = random_system(rng, nodes, loads=("mean", "a", "b"))
        cycle = fo.LoadCycle({"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(corners, 2))])
        limit = fo.guaranteed_limit(contact, cycle, rng.uniform(0.1, 0.6), lower=True)
        assert limit.exact and limit.lower <= limit.upper <= limit.shakedown.load_factor


def test_every_state_lies_within_the_derived_bounds():
    rng = np.random.default_rng(3)
    tight = np.inf
    for _ in range(12):
        contact = random_system(rng, 3)
        friction = rng.uniform(0.05, 0.6)
        task = Task(contact, CYCLE, cycle_loads(contact, CYCLE), friction, False, False)
        bounds = periodic_bounds(task, 5.0)
        for load_factor in (0.0, 2.5, 5.0):
            path = fo.march(contact, CYCLE, friction, load_factor, initial_slip=rng.normal(size=3) * 10 ** rng.uniform(-1, 2), cycles=3)
            corner = (path.time >= 0) & (path.time == np.round(path.time))
            slip, gap, p = path.slip[corner] / bounds.length, path.gap[corner] / bounds.length, path.p[corner] / task.force
            assert (slip >= bounds.slip_low).all() and (slip <= bounds.slip_high).all()
            assert (gap <= bounds.gap_high).all() and (p <= bounds.pressure_high).all()
            tight = min(tight, float((bounds.pressure_high / p.max(axis=0)).min()))
    assert tight < 2  # a bound that is far from every state would prove nothing


def test_where_no_bound_can_be_derived_the_answer_says_so(punch, paper_cycle):
    limit = fo.guaranteed_limit(punch(16), paper_cycle, 0.5, lower=True)
    assert limit.lower == 0 and not limit.exact and "S is singular" in limit.increments.status and limit.increments.problem is None
    sticky = fo.guaranteed_limit(random_system(np.random.default_rng(0), 2, coupling=1.0), CYCLE, 20.0, lower=True)
    assert sticky.increments is None or sticky.lower == 0


def test_a_bound_found_in_too_little_time_is_one():
    contact = random_system(np.random.default_rng(5), 5)
    limit = fo.guaranteed_limit(contact, CYCLE, 0.4, lower=True, time_limit=1e-3)
    assert 0 <= limit.lower < limit.upper and not limit.exact and "user_limit" in limit.increments.status


def test_none_is_sought_unless_asked_for():
    limit = fo.guaranteed_limit(system(*FIRST_PAIR), CYCLE, 0.6)
    assert limit.increments is None and limit.lower == 0 and not limit.exact


def test_slips_of_the_sequence_found_keep_within_the_slip_bound():
    contact = system(*FIRST_PAIR)
    free = fo.guaranteed_limit(contact, CYCLE, 0.6, lower=True)
    most = 0.8 * np.abs(free.slip).max()
    limit = fo.guaranteed_limit(contact, CYCLE, 0.6, slip_bound=most, lower=True)
    assert limit.upper > free.upper * 1.01 and limit.exact
    assert np.abs(limit.increments.slips).max() <= most * (1 + 1e-6)
