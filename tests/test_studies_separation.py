"""The study of contacts that open, at quick size: what theory says of its limits."""

import numpy as np
import pytest

from studies import separation

pytestmark = pytest.mark.slow
STUDY = separation.STUDY


def test_every_row_rests_and_no_bound_or_shakedown_limit_is_passed(tables):
    for table in tables.values():
        assert table["residual"].between(0, 1e-9).all() and table["separated"].gt(0).all()
        assert (table["bound"] >= table["separated"]).all() and not (table["separated"] < table["shakedown"] * (1 - 1e-9)).any()


def test_the_limit_of_the_cylinder_falls_with_its_cells(tables):
    table = tables["separation_cylinder"]
    assert separation.exponent(table["size"], table["separated"]) == pytest.approx(1.0, abs=0.05)
    assert (
        (table["separated"] < 1 - (1 - table["size"]) ** 2).all() and (table["shakedown"] <= table["separated"]).all() and (table["open"] > 0).all()
    )


def test_opening_adds_to_the_pin(tables):
    pin = tables["separation_closed"].query("scene == 'pin' and friction == 0.5")
    assert np.all(pin["rests"] > 1.15 * pin["shakedown"]) and np.all(pin["open"] == 0)
