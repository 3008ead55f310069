"""The study of damping at quick size: what theory says of limits and ranges, other starts and loops, and the lap joint by a formula of beams."""

import numpy as np
import pytest

import frictopt as fo
from studies import damping

STUDY = damping.STUDY


@pytest.mark.parametrize("name", ["damping_backbone", "damping_friction"])
def test_the_range_holds_the_curve_and_the_limits_hold_the_range(tables, name):
    rows = tables[name]
    for quantity in ("damping", "frequency"):
        assert (rows[f"least_{quantity}"] <= rows[quantity]).all() and (rows[quantity] <= rows[f"most_{quantity}"]).all()
    below, above = rows["load_ratio"] < rows["guaranteed_ratio"], rows["load_ratio"] > 1
    assert below.any() == (name == "damping_backbone")
    assert (rows.loc[below, "most_damping"] == 0).all() and np.allclose(rows.loc[below, "least_frequency"], 1.0, rtol=1e-12)
    assert (rows.loc[~above, "least_damping"] == 0).all() and (rows.loc[above, "damping"] > 0).all()
    assert (rows.loc[above & (rows["joint"] != "dovetail"), "least_damping"] > 0).all()  # the flanks of the dovetail lift off
    assert (rows["guaranteed_ratio"] <= 1).all() and (rows["most_frequency"] <= 1 + 1e-12).all() and (rows["residual"] < 1e-9).all()


def test_other_starts_lie_in_the_range(tables):
    """Starts at random, measured by the loop of the load."""
    system, cycle = damping.joints(damping.QUICK)["lap joint"]
    rows = tables["damping_backbone"].query("joint == 'lap joint'")
    rng = np.random.default_rng(3)
    for row in rows[rows["load_ratio"] > 1].itertuples():
        for size in (0.1, 1.0, 3.0):
            slip = size * row.load_factor * float(system.compliance[1, 1]) * rng.normal(size=system.nodes)
            loop = fo.steady_state(system, cycle, row.friction, row.load_factor, initial_slip=slip).loop("pull")
            ratio = loop.area * loop.stiffness / (2 * np.pi * row.load_factor**2)
            assert row.least_damping * (1 - 1e-6) <= ratio <= row.most_damping * (1 + 1e-6)


def test_the_glued_lap_joint_is_a_beam_of_three_parts():
    """Length, thickness and eccentricity of the pull, from its end on; that end is held across and free to turn."""
    model = damping.lap(24)
    E, nu = model.bodies["upper"].material.E, model.bodies["upper"].material.nu
    parts = ((3.0, 0.5, 0.0), (2.0, 1.0, 0.25), (3.0, 0.5, 0.5))
    s = np.cumsum([0.0, *(length for length, _, _ in parts)])
    length, h, e = np.array(parts).T
    force, EA = 0.5, E / (1 - nu**2) * h
    EI = EA * h**2 / 12
    turned, held = np.sum(e * np.diff(s**2) / 2 / EI), np.sum(np.diff(s**3) / 3 / EI)
    exact = force**2 * (np.sum(length / EA) + np.sum(e**2 * length / EI) - turned**2 / held)
    assert float(model.condense().compliance[1, 1]) == pytest.approx(exact, rel=0.1)
