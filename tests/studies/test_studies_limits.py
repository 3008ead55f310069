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


def test_the_plane_shows_the_limits_of_the_pair(tables):
    table, contact = tables["guaranteed_plane"], guaranteed.pair()
    lower, upper = two_node_limits(
        contact.A, contact.B, *contact.bonded["mean"], *contact.bonded["cyclic"], 0.6
    )
    by_name = table.groupby("limit")["load_factor"].first()
    assert by_name["guaranteed limit"] == pytest.approx(lower, rel=1e-9)
    assert by_name["shakedown limit"] == pytest.approx(upper, rel=1e-9)
    assert table["load_factor"].nunique() == 4


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
