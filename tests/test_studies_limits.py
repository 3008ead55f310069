"""The study of limits at quick size: facts of the scene that do not depend on the stored numbers, and the origin of its tables."""

from dataclasses import asdict
from importlib.metadata import version

import numpy as np
import pytest

import frictopt as fo
from studies import limits

pytestmark = pytest.mark.slow

TABLES = {"friction": limits.FRICTION, "corner": limits.CORNER, "reactions": limits.REACTIONS}


@pytest.fixture(scope="module")
def tables(quick):
    read = quick(limits.STUDY.tables)
    assert sorted(read) == sorted(table.name for table in TABLES.values())
    return {name: read[table.name] for name, table in TABLES.items()}


@pytest.mark.parametrize("name", ["friction", "corner"])
def test_limit_does_not_fall_with_friction(tables, name):
    for _, rows in tables[name].groupby(["elements", "grading"]):
        assert len(rows) >= 5 and np.all(np.diff(rows["friction"]) > 0)
        assert np.all(np.diff(rows["load_factor"]) > 0)


def test_every_row_was_checked(tables):
    for name, table in tables.items():
        assert table["residual"].between(0, 1e-9, inclusive="left").all(), name
        assert table["solver"].str.len().gt(0).all(), name
    assert tables["friction"]["margin_residual"].lt(1e-9).all()


def test_friction_rate_is_the_slope_of_the_limit(tables):
    """Where the rate is the same to 30 % at both ends of a step, the mean slope lies between the two or close by."""
    for _, rows in tables["friction"].groupby("elements"):
        slope = np.diff(rows["load_factor"]) / np.diff(rows["friction"])
        rates = np.array([rows["friction_rate"].to_numpy()[:-1], rows["friction_rate"].to_numpy()[1:]])
        smooth = rates.max(axis=0) < 1.3 * rates.min(axis=0)
        assert smooth.sum() > 5
        assert np.all(slope[smooth] > 0.95 * rates.min(axis=0)[smooth]) and np.all(slope[smooth] < 1.05 * rates.max(axis=0)[smooth])


@pytest.mark.parametrize(("friction", "sign"), [(0.2, 1), (0.4, 1), (0.65, -1), (0.7, -1)])
def test_refined_corner_lowers_the_limit_below_the_bonded_ratio_and_raises_it_above(tables, friction, sign):
    rows = tables["corner"][tables["corner"]["friction"] == friction]
    for _, part in rows.groupby(rows["grading"] == "sine"):
        ordered = part.sort_values("corner_size")
        assert len(ordered) >= 3
        assert np.all(sign * np.diff(ordered["load_factor"]) > 0)


def test_limit_at_the_bonded_ratio_hardly_depends_on_the_corner(tables):
    spread = tables["corner"].groupby("friction")["load_factor"].agg(lambda values: values.max() / values.min())
    assert spread[0.543] < 1.06 < 1.4 < spread[0.2]


def test_limiting_nodes_sit_on_their_bound(tables):
    for _, rows in tables["reactions"].groupby("friction"):
        assert rows["share"].sum() == pytest.approx(1, abs=1e-6)
        assert rows.loc[rows["share"] > 1e-6, "ratio"].abs().to_numpy() == pytest.approx(1, abs=1e-7)
        assert rows["ratio"].abs().min() < 0.9  # not all do


def test_reactions_are_those_of_the_slip_and_the_loads(tables):
    scene = fo.scenes.PunchOnHalfPlane(elements=limits.QUICK.reaction_elements)
    system = scene.condense()
    (q0, p0), (q1, p1) = system.bonded["P"], system.bonded["sigma"]
    for (_, sigma), rows in tables["reactions"].groupby(["friction", "sigma"]):
        amplitude = sigma * rows["load_factor"].iloc[0]
        v = rows["slip"].to_numpy() * 2 * (1 - 0.3**2)  # 1/E* of two bodies with E = 1
        assert np.allclose(rows["q"], q0 + amplitude * q1 + system.A @ v, rtol=0, atol=1e-12)
        assert np.allclose(rows["p"], p0 + amplitude * p1 + system.B @ v, rtol=0, atol=1e-12)
        assert rows["p"].sum() == pytest.approx(2, rel=1e-9)  # the punch carries P, all forces are over P / 2


def test_tables_say_where_they_come_from(tables):
    for name, table in tables.items():
        origin = table.attrs
        assert origin["table"] == TABLES[name].name
        assert set(origin["versions"]) >= {"frictopt", "numpy", "scipy", "cvxpy", "highspy", "clarabel", "scikit-fem"}
        assert origin["versions"]["frictopt"].startswith(f"{fo.__version__}+") and origin["versions"]["cvxpy"] == version("cvxpy")
        assert set(origin["parameters"]) == set(asdict(limits.QUICK))
        assert tuple(origin["parameters"]["frictions"]) == limits.QUICK.frictions
        assert list(origin["columns"]) == list(table.columns)
        assert origin["seconds"] > 0
