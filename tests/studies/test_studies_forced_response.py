"""The study of forced responses: its sentences count what its tables show. The time integration
itself is compared with closed forms, and with the package, in tests/joints/test_forced_response.py."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from studies.validation import forced_response
from studies.validation.vibrations import Vibration, slider


def test_a_mass_without_slip_swings_by_force_over_damping():
    """Below its friction the slider is a spring: the peak is f / (2 zeta w0^2), and half of the
    range is the first harmonic."""
    structure, ratio = replace(slider(), mass=np.array([4.0, 0.2])), 0.02
    omega, _ = structure.modes()
    vibration = Vibration(structure, 0, ratio, 600)
    answer = vibration.shaken(1.0, omega[0] / (2 * np.pi), 300)
    assert answer.harmonic == pytest.approx(1.0 / (2 * ratio * omega[0] ** 2), rel=2e-3)
    assert answer.half_range == pytest.approx(answer.harmonic, rel=2e-3)
    pushed = Vibration(structure, 0, ratio, 600, point=0)
    again = pushed.shaken(1.0, omega[0] / (2 * np.pi), 300)
    assert again.harmonic == pytest.approx(answer.harmonic, rel=2e-2)


def test_a_slider_swings_as_far_as_its_friction_lets_it():
    """`pi f a = 4 F (a - a_s) + 2 pi zeta w0 w a^2` at the frequency of the stiffness at a."""
    structure, ratio, limit, spring = slider(), 1e-4, 20.0, 6e3
    start, force = limit / spring, 0.5 * 4 * limit / np.pi
    a = 2 * start
    angle = np.arccos(1 - 2 * start / a)
    stiffness = 1e4 + spring / np.pi * (angle - np.sin(2 * angle) / 2)
    vibration = Vibration(structure, 0, ratio, 600)
    answer = vibration.shaken(force, np.sqrt(stiffness) / (2 * np.pi), 300)
    assert answer.harmonic == pytest.approx(a, rel=0.02)


def test_friction_removes_the_part_of_a_residual_slip_that_it_does_not_hold():
    structure = slider()
    at_rest = Vibration(structure, 0, 0.02, 600)
    for slip in (1e-4, 1.0):
        moved = Vibration(structure, 0, 0.02, 600, residual_slip=np.array([slip]))
        gained = float(moved.s[0] - at_rest.s[0])
        shear = structure.tangential * (structure.along @ moved.u - moved.s)
        pressed = structure.normal * (structure.against @ moved.u)
        assert np.abs(shear) <= structure.friction * pressed * (1 + 1e-9)
        assert (gained == slip) == (slip == 1e-4)


def test_the_summary_counts_the_rows():
    rows = [
        ("block, lift-off", 1.1, 1.0, 0.5, 0.01, 0.5, 1.0),
        ("block, lift-off", 2.0, 1.0, 1.0, 0.5, 0.8, 1.0),
        ("oscillator", 0.97, 1.0, 0.5, 0.02, 1.0, 1.01),
        ("oscillator", np.inf, 1.0, np.nan, np.nan, 1.0, 1.0),
    ]
    names = ["structure", "peak", "seen_peak", "sensitivity", "interaction", "up", "down"]
    table = pd.DataFrame(rows, columns=names)
    table = table.assign(damping=1e-3, force=2.0, resonance=9.9, seen_resonance=10.0)
    masses = pd.DataFrame(
        {
            "number": [0, 0, 0, 1],
            "peak": [1.01, 1.02, 1.2, np.inf],
            "seen_peak": [1.0, 1.0, 1.0, np.nan],
            "interaction": [0.01, 0.02, 0.07, np.nan],
            "unchecked": [False, False, False, True],
        }
    )
    few = pd.DataFrame(
        {"load_factors": [8, 8, 20], "peak_error": [-0.02, 0.01, 0.001], "resonance_error": 1e-3}
    )
    band = pd.DataFrame(
        {
            "force": 6.0,
            "start": [0, 1],
            "least_peak": 1e-3,
            "most_peak": 3e-3,
            "seen_peak": [1.2e-3, 1.4e-3],
        }
    )
    said = forced_response.STUDY.summary(
        {
            "forced_response": table,
            "forced_response_masses": masses,
            "forced_response_factors": few,
            "forced_response_band": band,
        }
    )
    lines = said.splitlines()
    assert "| block, lift-off | 0.1 % | 2 | +10.0 % | -1.0 % | 0.5 | 0.01 |" in lines
    assert "| oscillator | 0.1 % | 2 | no peak on the curve |  |  |  |" in lines
    assert "at most 0.05 for 2 of 3 peaks, with errors of 3.0 to 10.0 %" in said
    assert "above 0.05 for 1 of 3 peaks, with errors of 100.0 to 100.0 %" in said
    assert "2 random joints, each with three forces: 1 of 4 peaks lie beyond the curve" in said
    assert "1 joints have a peak that is not checked. The median error is 2.0 %. The inter" in said
    assert "at most 0.05 for 2 of 3 peaks, with errors of 1.0 to 2.0 %" in said
    assert "0.50 to 0.80 of it for the blocks" in said and "0.99 to 1.00 of it for the osc" in said
    assert "| 8 | 2 % | 0.1 % |" in lines and "| 20 | 0.1 % | 0.1 % |" in lines
    assert "| 6 | 1.000 to 3.000 | 1.200 to 1.400 | 2 |" in lines


def test_all_structures_have_rows(quick):
    tables = quick(forced_response.STUDY.tables)
    peaks = tables["forced_response"]
    assert len(peaks) == len(forced_response.CASES) and (peaks["residual"] < 1e-9).all()
    assert (peaks[["down", "up"]].max(axis=1) == peaks["seen_peak"]).all()
    masses = tables["forced_response_masses"]
    assert masses["number"].tolist() == [0, 0, 0] and masses["seen_peak"].notna().any()
    band = tables["forced_response_band"]
    assert band["start"].tolist() == [0, 1] and (band["least_peak"] <= band["most_peak"]).all()
