"""Sliders in parallel and in series against marches in small increments."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.reference import foundation_rod, masing_dissipation, rod_dissipation, rod_end_displacement, single_node_dissipation
from marching import increment, last_cycle, statuses


def test_masing_dissipation_equals_a_march_and_the_sum_of_single_nodes():
    rng = np.random.default_rng(8)
    k, bound, X, f = rng.uniform(0.5, 3, 3), rng.uniform(0.05, 1, 3), 0.6, 0.3
    work = masing_dissipation(k, bound, X)
    assert work > 0
    system = (np.diag(k), np.zeros((3, 3)), 0, bound / f, -k, 0, f)
    assert last_cycle(system, X, rng.uniform(-1, 1, size=(4, 3)), cycles=3).work == pytest.approx(work, rel=1e-12)
    single = [single_node_dissipation(k[i], 0, 0, bound[i] / f, -k[i], 0, f, load_factor=X) for i in range(3)]
    assert work == pytest.approx(sum(single), rel=1e-12)


def rod_march(F0, EA, tau, h, nodes, starts=None, f=0.3):
    """March of the rod under the pressure `tau / f`, built from the arrays of a contact system."""
    system = fo.ContactSystem.from_blocks(**foundation_rod(nodes, EA, h))
    q0, p0 = system.reaction({"pressure": tau / f})
    q1, p1 = system.reaction({"force": F0})
    march = last_cycle((system.A, system.B, q0, p0, q1, p1, f), 1.0, np.zeros((1, nodes)) if starts is None else starts, 4, cycles=4)
    return march, increment_at_full_load(system, q0 + q1, p0, f, march.slip)


def increment_at_full_load(system, q, p, f, slip):
    """Slip after one more increment, from the end of the cycle to the corner `s = +1`."""
    friction = np.full(system.nodes, f)
    return increment(system.A, system.B, friction, q, p, slip, statuses(system.A, system.B, friction))


@pytest.mark.parametrize("n", [0.7, 1.0, 2.4, 3.0, 3.9])
def test_rod_closed_forms_equal_a_march_for_any_number_of_nodes(n):
    EA, tau, h = 2.0, 0.7, 0.4
    march, pulled = rod_march(n * tau * h, EA, tau, h, 5)
    assert march.work == pytest.approx([rod_dissipation(n * tau * h, EA, tau, h)], rel=1e-12, abs=1e-12)
    assert pulled[0, 0] == pytest.approx(rod_end_displacement(n * tau * h, EA, tau, h), rel=1e-12, abs=1e-12)


def test_rod_dissipates_the_same_from_other_starts():
    starts = np.random.default_rng(9).uniform(-0.4, 0.4, size=(4, 5))
    march, _ = rod_march(2.5, 1, 1, 1, 5, starts)
    assert march.work == pytest.approx(rod_dissipation(2.5, 1, 1, 1), rel=1e-12)


def test_rod_approaches_the_continuum_at_first_and_second_order():
    F0, EA, tau = 1.3, 2.0, 0.7
    n = np.array([8, 64, 512])
    ends = [1 - rod_end_displacement(F0, EA, tau, F0 / (tau * k)) / rod_end_displacement(F0, EA, tau) for k in n]
    works = [1 - rod_dissipation(F0, EA, tau, F0 / (tau * k)) / rod_dissipation(F0, EA, tau) for k in n]
    assert ends == pytest.approx(1 / n, rel=1e-9)
    assert works == pytest.approx(1 / n**2, rel=1e-8)
