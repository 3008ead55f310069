"""The study of limits at quick size: facts of the scene that do not depend on the stored numbers, and the origin of its tables."""

from dataclasses import asdict
from importlib.metadata import version

import numpy as np
import pytest

import frictopt as fo
from studies import limits

pytestmark = pytest.mark.slow

STUDY = limits.STUDY


def test_limiting_nodes_sit_on_their_bound(tables):
    for _, rows in tables["limits_reactions"].groupby("friction"):
        assert rows["share"].sum() == pytest.approx(1, abs=1e-6)
        assert rows.loc[rows["share"] > 1e-6, "ratio"].abs().to_numpy() == pytest.approx(1, abs=1e-7)
        assert rows["ratio"].abs().min() < 0.9  # not all do


def test_reactions_are_those_of_the_slip_and_the_loads(tables):
    scene = fo.scenes.PunchOnHalfPlane(elements=limits.QUICK.reaction_elements)
    system = scene.condense()
    (q0, p0), (q1, p1) = system.bonded["P"], system.bonded["sigma"]
    for (_, sigma), rows in tables["limits_reactions"].groupby(["friction", "sigma"]):
        amplitude = sigma * rows["load_factor"].iloc[0]
        v = rows["slip"].to_numpy() * 2 * (1 - 0.3**2)  # 1/E* of two bodies with E = 1
        assert np.allclose(rows["q"], q0 + amplitude * q1 + system.A @ v, rtol=0, atol=1e-12)
        assert np.allclose(rows["p"], p0 + amplitude * p1 + system.B @ v, rtol=0, atol=1e-12)
        assert rows["p"].sum() == pytest.approx(2, rel=1e-9)  # the punch carries P, all forces are over P / 2


def test_tables_say_where_they_come_from(tables):
    for name, table in tables.items():
        origin = table.attrs
        assert origin["table"] == name
        assert set(origin["versions"]) >= {"frictopt", "numpy", "scipy", "cvxpy", "highspy", "clarabel", "scikit-fem"}
        assert origin["versions"]["frictopt"].startswith(f"{fo.__version__}+") and origin["versions"]["cvxpy"] == version("cvxpy")
        assert set(origin["parameters"]) == set(asdict(limits.QUICK))
        assert tuple(origin["parameters"]["frictions"]) == limits.QUICK.frictions
        assert list(origin["columns"]) == list(table.columns)
        assert origin["seconds"] > 0


def test_contact_stiffness_makes_the_limit_settle(tables):
    """The limit of the hard contact falls with the corner element; that of soft surfaces changes ever less."""
    limits = tables["limits_surface"].pivot(index="corner_size", columns="surface", values="load_factor").sort_index(ascending=False)
    hard, soft = -np.diff(limits[0.0]), np.diff(limits[0.1])
    assert (hard > 0.02).all() and (soft > 0).all() and soft[1] < 0.5 * soft[0]


def test_limit_goes_with_the_power_of_the_corner_element_that_theory_gives(tables):
    law = limits.corner_law(tables["limits_corner"])
    assert law["friction"].unique().tolist() == [0.2, 0.4] and len(law) == 6  # friction above the traction ratio of the bonded corner has no such law
    finest = law.groupby("friction").last()
    assert finest["exponent"].to_numpy() == pytest.approx(finest["expected"].to_numpy(), rel=0.2)
