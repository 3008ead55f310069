"""Studies of limits in space and of contacts that open, at quick size: what theory says of them,
whatever the stored numbers are."""

import numpy as np
import pytest

import frictopt as fo
from studies import lift_off, spatial
from studies.space import LOADS


def test_the_map_is_that_of_the_limit(tables):
    maps = tables["spatial_maps"]
    assert (
        maps["traction_ratio"].max() <= 1 + 1e-8
        and (maps["first_ratio"].fillna(0.0) <= maps["traction_ratio"]).all()
    )
    for load, rows in maps.groupby("load"):
        system = fo.scenes.SquarePunch(elements=spatial.QUICK.map_elements).condense()
        assert (
            rows["load_factor"].iloc[0]
            == fo.shakedown_limit(system, LOADS[load], spatial.QUICK.map_friction).load_factor
        )
        assert rows["share"].sum() == pytest.approx(1.0)


def test_limits_are_proven_and_the_same_in_all_units(tables):
    proofs = tables["spatial_proofs"]
    assert (proofs["result"] == "answer").all() and proofs["gap"].max() <= 1e-9
    assert len(proofs) == (2 * len(spatial.QUICK.proof_ratios) + 4) * 2 * len(
        spatial.QUICK.proof_frictions
    )
    for _, rows in proofs.groupby(["mesh", "ratio", "load", "friction"]):
        assert np.ptp(rows["load_factor"]) <= 1e-8 * rows["load_factor"].max()
    means = proofs[proofs["ratio"] == 1].groupby("mesh")["load_factor"].mean()
    assert means["even"] != pytest.approx(means["uneven"], rel=1e-3)  # the meshes are two


def test_joints_lift_off_and_what_theory_says_of_it_holds(tables):
    """The best set is no worse than others, nothing rests above gross slip, and the theorem of
    uncoupled contacts holds."""
    joints, free = tables["lift_off_joints"], tables["lift_off_uncoupled"]
    assert not (joints[["all_closed", "settled"]].gt(joints["shakedown"] * (1 + 1e-9), axis=0)).any(
        axis=None
    )
    assert (
        (joints["shakedown"] <= joints["sliding"]).all()
        and (joints["above"] != "SHAKEDOWN").all()
        and (joints["below"] == "SHAKEDOWN").all()
    )
    assert (
        (free["rest_below"] == lift_off.QUICK.starts).all()
        and not free["rest_above"].any()
        and free["growth"].max() < 1e-12
    )


def test_a_limit_at_a_corner_of_many_cones_is_between_those_of_less_and_more_friction():
    """All solvers leave 2e-9 here, and only a step onto the right active cones adds the digits."""
    system = lift_off.flange(12)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}])
    path = fo.march(system, cycle, 0.2, 1e-3, cycles=1, steps=4)
    is_open = path.gap[path.time == 0][-1] > 0
    less, limit, more = (
        fo.shakedown_limit(system, cycle, friction, open_nodes=is_open).load_factor
        for friction in (0.1999, 0.2, 0.2001)
    )
    assert less < limit < more


def test_cyclic_slip_in_space_vanishes_with_the_distance_from_the_guaranteed_limit_and_leaves_no_room(
    tables,
):
    rows = tables["vanishing"].pivot(index="seed", columns="distance", values=["amplitude", "room"])
    for name in ("amplitude", "room"):
        assert (rows[name, 0.004] < 0.6 * rows[name, 0.008]).all()
