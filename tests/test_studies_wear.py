"""The study of wear at quick size: what theory says of its profiles, works and limits."""

import numpy as np
import pytest

from studies import wear


@pytest.fixture(scope="module")
def tables(quick):
    return quick(wear.STUDY.tables)


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
