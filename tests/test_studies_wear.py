"""The study of wear at quick size: what theory says of its profiles, works and limits."""

import numpy as np
import pytest

from studies import wear

STUDY = wear.STUDY


def test_profiles_grow_to_the_closed_form(tables):
    profiles = [rows for _, rows in tables["wear_profiles"].groupby("cycles")]
    depths = np.array([rows["depth"] for rows in profiles])
    assert not depths[0].any() and (np.diff(depths, axis=0) >= 0).all()
    assert depths[-1].max() == pytest.approx(profiles[-1]["end"].max(), rel=0.15)


def test_every_contact_wears_in_and_its_limit_rises_to_the_load(tables):
    for _, rows in tables["wear_history"].groupby("contact"):
        assert rows["work_share"].iloc[0] == 1 and rows["work_share"].iloc[-1] <= 1e-3 * rows["work_share"].max()
    limits = tables["wear_limits"]
    assert (limits["before"] < 1).all() and (limits["after"] > 1).all() and np.all(np.diff(limits["after"]) < 0) and limits["residual"].max() < 1e-9


def test_the_lap_joint_loses_its_damping_and_can_bear_its_load_in_the_end(tables):
    life = tables["wear_life"]
    assert life["cycles"].iloc[0] == 0 and life["damping"].iloc[-1] < 0.1 * life["damping"].iloc[0] and (np.diff(life["frequency"]) < 0).all()
    assert life["limit"].iloc[0] == pytest.approx(1 / 1.6) and (life["guaranteed"] <= life["limit"] * (1 + 1e-9)).all()
    worn = wear.LIFE.frame(wear.Parameters(lap_elements=8, lives=(1e6,)))
    assert worn["limit"].iloc[-1] == pytest.approx(1.0, abs=0.02) and worn["damping"].iloc[-1] < 1e-4 * worn["damping"].iloc[0]
