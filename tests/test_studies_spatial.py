"""The study of three dimensions at quick size: facts that do not depend on the stored numbers."""

import numpy as np
import pytest

import frictopt as fo
from studies import spatial
from studies.space import LOADS

pytestmark = pytest.mark.slow

STUDY = spatial.STUDY


def test_the_map_is_that_of_the_limit(tables):
    maps = tables["spatial_maps"]
    assert maps["traction_ratio"].max() <= 1 + 1e-8 and (maps["first_ratio"].fillna(0.0) <= maps["traction_ratio"]).all()
    for load, rows in maps.groupby("load"):
        system = fo.scenes.SquarePunch(elements=spatial.QUICK.map_elements).condense()
        assert rows["load_factor"].iloc[0] == fo.shakedown_limit(system, LOADS[load], spatial.QUICK.map_friction).load_factor
        assert rows["share"].sum() == pytest.approx(1.0)


def test_more_increments_are_closer(tables):
    for _, rows in tables["spatial_steps"].groupby("load"):
        assert rows["error"].iloc[-1] < 0.2 and (rows["dissipation"] > 0).all()


def test_limits_are_proven_and_the_same_in_all_units(tables):
    proofs = tables["spatial_proofs"]
    assert (proofs["result"] == "answer").all() and proofs["gap"].max() <= 1e-9
    assert len(proofs) == (2 * len(spatial.QUICK.proof_ratios) + 4) * 2 * len(spatial.QUICK.proof_frictions)
    for _, rows in proofs.groupby(["mesh", "ratio", "load", "friction"]):
        assert np.ptp(rows["load_factor"]) <= 1e-8 * rows["load_factor"].max()
    means = proofs[proofs["ratio"] == 1].groupby("mesh")["load_factor"].mean()
    assert means["even"] != pytest.approx(means["uneven"], rel=1e-3)  # the meshes are two
