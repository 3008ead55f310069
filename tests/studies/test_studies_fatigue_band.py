"""The study of the fatigue band at quick size: transients stay in it, and it depends on the mesh as
theory says."""

import numpy as np
import pytest

from studies import fatigue_band


def test_transients_of_all_starts_stay_in_the_band_below_the_guaranteed_limit(tables):
    rows = tables["fatigue_band_along"]
    assert (rows["load_factor"] < rows["guaranteed"]).all()
    for _, part in rows.groupby("depth"):
        rounding = 1e-5 * part["most"].max()
        for column in ("best", "assembled", "seen_least", "seen_most"):
            assert (part[column] >= part["least"] - rounding).all()
            assert (part[column] <= part["most"] + rounding).all()
        assert part["best"].max() <= part["assembled"].max() + rounding
        assert (part["seen_most"] > part["seen_least"]).any()
        # The punch and its loads are symmetric.
        assert part["most"].to_numpy() == pytest.approx(part["most"].to_numpy()[::-1], rel=1e-4)


def test_the_largest_value_grows_on_the_face_as_a_half_plane_says_and_converges_below(tables):
    rows = tables["fatigue_band_mesh"]
    for depth, part in rows.groupby("depth"):
        change = np.diff(part["most"]).item()
        if depth == 0:
            refined = -np.diff(np.log(part["size"])).item()
            assert change == pytest.approx(part["growth"].mean() * refined, rel=0.05)
        else:
            assert abs(change) < 0.05 * part["most"].max()
    at_one_mesh = rows[rows["elements"] == max(fatigue_band.QUICK.meshes)]
    assert at_one_mesh.sort_values("depth")["most"].is_monotonic_decreasing
