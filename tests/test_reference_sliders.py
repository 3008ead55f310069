"""Sliders in parallel and in series against the exact path."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.reference import foundation_rod, masing_dissipation, rod_dissipation
from systems import CYCLE, system

F = 0.3


def test_masing_dissipation_is_that_of_the_exact_path():
    rng = np.random.default_rng(8)
    k, bound, X = rng.uniform(0.5, 3, 3), rng.uniform(0.05, 1, 3), 0.6
    sliders = system(np.diag(k), np.zeros((3, 3)), 0, bound / F, -k, 0)
    for start in rng.uniform(-1, 1, size=(4, 3)):
        steady = fo.steady_state(sliders, CYCLE, F, X, initial_slip=start)
        assert steady.dissipation == pytest.approx(masing_dissipation(k, bound, X), rel=1e-12) and steady.dissipation > 0


@pytest.mark.parametrize("n", [0.7, 1.0, 2.4, 3.0, 3.9])
def test_rod_closed_forms_equal_the_exact_path_for_any_number_of_nodes(n):
    EA, tau, h = 2.0, 0.7, 0.4
    rod, cycle = fo.ContactSystem.from_blocks(**foundation_rod(5, EA, h)), fo.LoadCycle({"pressure": tau / F}, [{"force": -1.0}, {"force": 1.0}])
    F0 = n * tau * h
    for start in (np.zeros(5), *np.random.default_rng(9).uniform(-0.4, 0.4, size=(2, 5))):
        path = fo.march(rod, cycle, F, F0, initial_slip=start, cycles=6)
        assert path.cycle_work[-1].sum() == pytest.approx(rod_dissipation(F0, EA, tau, h), rel=1e-12, abs=1e-12)
        if not start.any():
            forces = F0 - tau * h * np.arange(1, int(n) + 1)  # in the rod beside each node that slips
            assert path.slip[-1, 0] == pytest.approx(h / EA * forces.sum(), rel=1e-12, abs=1e-12)


def test_rod_approaches_the_continuum_at_second_order():
    F0, EA, tau = 1.3, 2.0, 0.7
    n = np.array([8, 64, 512])
    works = [1 - rod_dissipation(F0, EA, tau, F0 / (tau * k)) / rod_dissipation(F0, EA, tau) for k in n]
    assert works == pytest.approx(1 / n**2, rel=1e-8)
