"""The study of both limits in space at quick size: what theory says of them."""

import numpy as np
import pytest

from studies import space

STUDY = space.STUDY


def test_no_limit_is_out_of_order(tables):
    for name in ("space_friction", "space_mesh"):
        rows = tables[name]
        assert (rows["guaranteed"] <= rows["shakedown"] * (1 + 1e-9)).all() and (rows["onset"] <= rows["shakedown"] * (1 + 1e-9)).all()
    limits = tables["space_friction"].pivot(index="friction", columns="load", values="shakedown")
    assert (np.diff(limits, axis=0) > 0).all()
    assert (limits["to and fro"] >= limits["turning, 4 corners"]).all() and (limits["turning, 4 corners"] >= limits["turning, 16 corners"]).all()


def test_the_sphere_is_uncoupled_and_its_limit_belongs_to_the_mesh(tables):
    sphere = tables["space_mesh"].query("scene == 'sphere'")
    assert sphere["guaranteed"].to_numpy() == pytest.approx(sphere["shakedown"].to_numpy(), rel=1e-9)
    coarse, fine = (rows["shakedown"].max() for _, rows in sphere.groupby("nodes"))
    assert fine < 0.7 * coarse


def test_work_begins_between_the_limits(tables):
    work = tables["space_work"]
    assert (work["least"] <= work["work"]).all() and (work["work"] <= work["most"]).all()
    assert (work.query("ratio > 1")["least"] > 0).all() and not work.query("ratio < guaranteed")["most"].any()
    assert work.query("guaranteed < ratio < 1")["most"].any()
