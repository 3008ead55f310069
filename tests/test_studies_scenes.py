"""The study of the scenes at quick size."""

import numpy as np
import pytest

from studies import scenes

pytestmark = pytest.mark.slow
STUDY = scenes.STUDY


@pytest.fixture
def table(tables):
    return tables["scenes_limits"]


def test_limits_do_not_fall_with_friction(table):
    groups = table.groupby(["scene", "case", "parameter"], dropna=False)
    assert len(groups) == 2 * 3 + 3 + 2
    for _, rows in groups:
        with np.errstate(invalid="ignore"):  # inf - inf
            assert not np.any(np.diff(rows["load_factor"]) < 0)
        assert (rows["guaranteed"] <= rows["load_factor"]).all() and (rows["residual"] < 1e-7).all()


def test_flanks_lock_beyond_the_cotangent_alone(table):
    rows = table[table["scene"] == "dovetail"]
    locks = rows["friction"] * np.tan(np.radians(rows["parameter"])) > 1
    assert locks.sum() == 6 and np.isinf(rows["load_factor"][locks]).all() and np.isfinite(rows["load_factor"][~locks]).all()


def test_a_rotating_force_is_the_worse_one(table):
    limits = table[table["scene"] == "pin"].pivot(index="friction", columns="case", values="load_factor")
    assert (limits["rotating"] < limits["to and fro"]).all()


def test_first_slip_of_the_pulled_plate(table):
    rows = table[table["case"] == "plate"]
    assert np.allclose(rows["onset"], 2 * rows["friction"] / (rows["friction"] + np.hypot(1, rows["friction"])), rtol=0.05)


def test_rounder_edges_lower_the_limit(table):
    limits = table[table["scene"] == "punch"].pivot(index="friction", columns="parameter", values="load_factor")
    assert (limits[0.5] < limits[np.inf]).all()
