"""Studies of joints at quick size: their reports, damping, designs and wear, against theory, other
starts, statics and a formula of beams."""

import numpy as np
import pytest

from studies import damping, joint, wear


def test_the_report_sums_up_the_nodes(tables):
    nodes = tables["joint_fretting"].groupby("joint", sort=False)
    report = tables["joint_report"].set_index("joint")
    assert (
        np.allclose(nodes["work"].sum(), report["dissipation"])
        and (report["dissipation"] > 0).all()
    )
    for name in ("slip_range", "F1", "F2", "SWT"):
        assert np.allclose(nodes[name].max(), report[f"largest_{name}"])
    assert (report["corners"] == joint.QUICK.turns).all() and (
        report["samples"] > 9 * report["corners"] - 10
    ).all()
    assert (report["residual"] < 1e-9).all()


@pytest.mark.parametrize("name", ["damping_backbone", "damping_friction"])
def test_the_range_holds_the_curve_and_the_limits_hold_the_range(tables, name):
    rows = tables[name]
    for quantity in ("damping", "frequency"):
        assert (rows[f"least_{quantity}"] <= rows[quantity]).all() and (
            rows[quantity] <= rows[f"most_{quantity}"]
        ).all()
    below, above = rows["load_ratio"] < rows["guaranteed_ratio"], rows["load_ratio"] > 1
    assert below.any() == (name == "damping_backbone")
    assert (rows.loc[below, "most_damping"] == 0).all() and np.allclose(
        rows.loc[below, "least_frequency"], 1.0, rtol=1e-12
    )
    assert (rows.loc[~above, "least_damping"] == 0).all() and (rows.loc[above, "damping"] > 0).all()
    assert (
        rows.loc[above & (rows["joint"] != "dovetail"), "least_damping"] > 0
    ).all()  # the flanks of the dovetail lift off
    assert (
        (rows["guaranteed_ratio"] <= 1).all()
        and (rows["most_frequency"] <= 1 + 1e-12).all()
        and (rows["residual"] < 1e-9).all()
    )


def test_the_glued_lap_joint_is_a_beam_of_three_parts():
    """Length, thickness and eccentricity of the pull, from its end on; that end is held across and
    free to turn."""
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


def test_more_depth_and_more_shapes_never_lower_a_limit_and_gain_less_and_less(tables):
    for _, rows in tables["design_limits"].groupby("face"):
        gains = np.diff(rows["load_factor"]) / np.diff(rows["depth"])
        assert (gains > 0).all() and (
            np.diff(gains) < 0
        ).all()  # the largest value of a convex program is concave in its bounds
        assert (rows["guaranteed"] <= rows["load_factor"] * (1 + 1e-9)).all()
    free, shapes = (
        tables["design_limits"].query(f"face == '{face}'")["load_factor"].to_numpy()
        for face in ("free", "three shapes")
    )
    assert free[0] == pytest.approx(shapes[0]) and (free[1:] > 1.01 * shapes[1:]).all()


def test_the_lap_joint_loses_its_damping_and_can_bear_its_load_in_the_end(tables):
    life = tables["wear_life"]
    assert (
        life["cycles"].iloc[0] == 0
        and life["damping"].iloc[-1] < 0.1 * life["damping"].iloc[0]
        and (np.diff(life["frequency"]) < 0).all()
    )
    assert (
        life["limit"].iloc[0] == pytest.approx(1 / 1.6)
        and (life["guaranteed"] <= life["limit"] * (1 + 1e-9)).all()
    )
    worn = wear.LIFE.frame(wear.Parameters(lap_elements=8, lives=(1e6,)))
    assert (
        worn["limit"].iloc[-1] == pytest.approx(1.0, abs=0.02)
        and worn["damping"].iloc[-1] < 1e-4 * worn["damping"].iloc[0]
    )
