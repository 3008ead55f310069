"""The study of designs at quick size: what convexity, bounds and statics say of its limits, profiles and bolts."""

import numpy as np
import pytest

from studies import design

STUDY = design.STUDY


def test_more_depth_and_more_shapes_never_lower_a_limit_and_gain_less_and_less(tables):
    for _, rows in tables["design_limits"].groupby("face"):
        gains = np.diff(rows["load_factor"]) / np.diff(rows["depth"])
        assert (gains > 0).all() and (np.diff(gains) < 0).all()  # the largest value of a convex program is concave in its bounds
        assert (rows["guaranteed"] <= rows["load_factor"] * (1 + 1e-9)).all()
    free, shapes = (tables["design_limits"].query(f"face == '{face}'")["load_factor"].to_numpy() for face in ("free", "three shapes"))
    assert free[0] == pytest.approx(shapes[0]) and (free[1:] > 1.01 * shapes[1:]).all()


def test_the_worn_profile_digs_where_the_best_one_stays(tables):
    faces = {face: rows for face, rows in tables["design_profiles"].groupby("face")}
    depth = faces["worn"]["profile"].max()
    for face in ("free", "three shapes"):
        assert faces[face]["profile"].max() == pytest.approx(depth) and faces[face]["load_factor"].iloc[0] > faces["flat"]["load_factor"].iloc[0]
    ends = [0, -1]
    assert faces["worn"]["profile"].to_numpy()[ends] == pytest.approx(depth, rel=1e-3)
    assert (faces["free"]["profile"].to_numpy()[ends] < 0.1 * depth).all()
    assert (tables["design_relief"].groupby("friction")["load_factor"].diff().dropna() > 0).all()


def test_the_least_forces_carry_more_than_equal_ones_and_are_convex_in_the_load(tables):
    bolts = tables["design_bolts"]
    assert (bolts["even"] <= bolts["load_factor"] * (1 + 1e-8)).all() and (bolts[["bolt 0", "bolt 1", "bolt 2"]] >= -1e-9).all().all()
    assert bolts["total"].is_monotonic_increasing
    (first, last), (low, high) = bolts["total"], bolts["load_factor"]
    rise = (last - first) / (high - low)
    assert bolts["price"].iloc[0] <= rise * (1 + 1e-6) and rise <= bolts["price"].iloc[1] * (1 + 1e-6)  # prices are slopes of a convex function
