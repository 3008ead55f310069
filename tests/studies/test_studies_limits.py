"""Studies of limits at quick size: of the punch, its guaranteed limits, Poisson's ratio and other
scenes; the origin of tables."""

from dataclasses import asdict
from importlib.metadata import version

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from helpers.two_nodes import two_node_limits
from studies import guaranteed, limits, validity


def test_reactions_are_those_of_the_slip_and_the_loads(tables):
    scene = fo.scenes.PunchOnHalfPlane(elements=limits.QUICK.reaction_elements)
    system = scene.condense()
    (q0, p0), (q1, p1) = system.bonded["P"], system.bonded["sigma"]
    for (_, sigma), rows in tables["limits_reactions"].groupby(["friction", "sigma"]):
        amplitude = sigma * rows["load_factor"].iloc[0]
        v = rows["slip"].to_numpy() * 2 * (1 - 0.3**2)  # 1/E* of two bodies with E = 1
        assert np.allclose(rows["q"], q0 + amplitude * q1 + system.A @ v, rtol=0, atol=1e-12)
        assert np.allclose(rows["p"], p0 + amplitude * p1 + system.B @ v, rtol=0, atol=1e-12)
        assert rows["p"].sum() == pytest.approx(
            2, rel=1e-9
        )  # the punch carries P, all forces are over P / 2


def test_tables_say_where_they_come_from(quick):
    for name, table in quick(limits.STUDY.tables).items():
        origin = table.attrs
        assert origin["table"] == name
        assert set(origin["versions"]) >= {
            "frictopt",
            "numpy",
            "scipy",
            "cvxpy",
            "highspy",
            "clarabel",
            "scikit-fem",
        }
        assert origin["versions"]["frictopt"].startswith(f"{fo.__version__}+") and origin[
            "versions"
        ]["cvxpy"] == version("cvxpy")
        assert set(origin["parameters"]) == set(asdict(limits.QUICK))
        assert tuple(origin["parameters"]["frictions"]) == limits.QUICK.frictions
        assert list(origin["columns"]) == list(table.columns)
        assert origin["seconds"] > 0


def test_contact_stiffness_makes_the_limit_settle(tables):
    """The limit of the hard contact falls with the corner element; that of soft surfaces changes
    ever less."""
    limits = (
        tables["limits_surface"]
        .pivot(index="corner_size", columns="surface", values="load_factor")
        .sort_index(ascending=False)
    )
    hard, soft = -np.diff(limits[0.0]), np.diff(limits[0.1])
    assert (hard > 0.02).all() and (soft > 0).all() and soft[1] < 0.5 * soft[0]


def test_limit_goes_with_the_power_of_the_corner_element_that_theory_gives(tables):
    law = limits.corner_law(tables["limits_corner"])
    assert (
        law["friction"].unique().tolist() == [0.2, 0.4] and len(law) == 6
    )  # friction above the traction ratio of the bonded corner has no such law
    finest = law.groupby("friction").last()
    assert finest["exponent"].to_numpy() == pytest.approx(finest["expected"].to_numpy(), rel=0.2)


@pytest.mark.parametrize("name", ["guaranteed_friction", "guaranteed_corner", "guaranteed_bound"])
def test_the_guaranteed_limit_is_not_above_the_shakedown_limit(tables, name):
    table = tables[name]
    assert (table["guaranteed"] <= table["shakedown"]).all() and (
        table["guaranteed"] < 0.9 * table["shakedown"]
    ).any()
    assert (table["x"].isna() == (table["guaranteed"] == table["shakedown"])).all()
    assert table.loc[table["friction"] < 0.9, "x"].abs().dropna().eq(1).all(), (
        "the corner node is the first"
    )


def slacks(contact, factor, slip):
    """(corners, senses, nodes) slack of each friction bound."""
    (q0, p0), (q1, p1) = contact.bonded["mean"], contact.bonded["cyclic"]
    q, p = (
        mean + factor * np.array([[-1.0], [1.0]]) * rate
        for mean, rate in ((q0 + contact.A @ slip, q1), (p0 + contact.B @ slip, p1))
    )
    return np.stack([0.6 * p + q, 0.6 * p - q], axis=1)


def test_the_plane_shows_the_limits_of_the_pair(tables):
    table, contact = tables["guaranteed_plane"], guaranteed.pair()
    lower, upper = two_node_limits(
        contact.A, contact.B, *contact.bonded["mean"], *contact.bonded["cyclic"], 0.6
    )
    by_name = table.groupby("limit")["load_factor"].first()
    assert by_name["guaranteed limit"] == pytest.approx(lower, rel=1e-9)
    assert by_name["shakedown limit"] == pytest.approx(upper, rel=1e-9)
    assert table["load_factor"].nunique() == 4


def test_lines_are_where_a_bound_is_met_and_vertices_of_the_safe_slips_on_two_of_them(tables):
    table, contact = tables["guaranteed_plane"], guaranteed.pair()
    for (what, factor, node, sense), rows in table[
        table["what"].isin(["line", "mean line"])
    ].groupby(["what", "load_factor", "node", "sense"]):
        assert len(rows) == 2
        for slip in rows[["v1", "v2"]].to_numpy():
            here = slacks(contact, factor if what == "line" else 0.0, slip)[
                :, 0 if sense == "forward" else 1, node
            ]
            assert here.min() == pytest.approx(0, abs=1e-9)
    for factor, rows in table[table["what"] == "safe"].groupby("load_factor"):
        for slip in rows[["v1", "v2"]].to_numpy():
            here = slacks(contact, factor, slip)
            assert here.min() > -1e-8 and (here.min(axis=0) < 1e-8).sum() >= 2


def mesh(*limits):
    return pd.DataFrame(
        {"friction": [0.1 * k for k in range(len(limits))], "guaranteed": limits}
    ).sample(frac=1, random_state=1)


def test_the_jump_is_the_rise_above_all_before():
    assert validity.jump(mesh(0.4, 0.5, 0.1, 0.0, 2.0, 2.2)) == pytest.approx((0.3, 0.4))
    assert validity.jump(mesh(0.0, 0.0, 0.2)) == pytest.approx((0.1, 0.2))
    assert (
        validity.jump(mesh(0.4, 0.5, 0.1, 0.5, 0.7)) is None
    )  # rises most from 0.1 to 0.5, and not above what was there before


@pytest.fixture
def of_scenes(tables):
    return tables["scenes_limits"]


def test_flanks_lock_beyond_the_cotangent_alone(of_scenes):
    rows = of_scenes[of_scenes["scene"] == "dovetail"]
    locks = rows["friction"] * np.tan(np.radians(rows["parameter"])) > 1
    assert (
        locks.sum() == 6
        and np.isinf(rows["load_factor"][locks]).all()
        and np.isfinite(rows["load_factor"][~locks]).all()
    )


def test_a_rotating_force_is_the_worse_one(of_scenes):
    limits = of_scenes[of_scenes["scene"] == "pin"].pivot(
        index="friction", columns="case", values="load_factor"
    )
    assert (limits["rotating"] < limits["to and fro"]).all()
