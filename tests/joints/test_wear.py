"""Wear in jumps of cycles.

It is compared with Archard's law step by step, closed forms, and the same joint under changes that
must not matter.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.interrupts import interrupted
from helpers.refused import refused
from helpers.systems import PULL
from helpers.worn import F, cylinder, plain_rate

COARSE = cylinder(32)
SWAY = fo.LoadCycle({"pull": 1.0}, [{"pull": 0.3, "sway": 0.1}, {"pull": -0.3, "sway": -0.1}])


@pytest.fixture(scope="module")
def coarse():
    return fo.joints.wear(*COARSE, coefficient=1e-3)


def test_small_steps_by_archards_law_give_the_same(coarse):
    """Explicit steps, each from no slip, which in an uncoupled contact makes no difference."""
    contact, *question = COARSE
    count, cycles = 150, 6e3
    for _ in range(count):
        contact = contact.with_gap(
            contact.gap + cycles / count * plain_rate(fo.steady_state(contact, *question), 1e-3)
        )
    plain = contact.gap - COARSE[0].gap
    history = fo.joints.wear(*COARSE, coefficient=1e-3, cycles=cycles)
    assert history.cycles[-1] == cycles
    assert history.reason == "6000 cycles are over"
    assert not history.worn_in
    assert np.abs(history.depth[-1] - plain).max() < 0.01 * plain.max()
    assert plain.max() > 0.3 * coarse.depth[-1].max()


def test_wear_that_takes_off_no_pressure_is_coefficient_times_work_over_friction():
    """A rod on a foundation has its own coefficient and friction at each node."""
    arrays = {**fo.reference.foundation_rod(nodes=5, EA=1.0, h=1.0), "C": np.zeros((5, 5))}
    rod = fo.ContactSystem.from_blocks(**arrays, width=np.linspace(0.5, 1.5, 5))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.7}, {"force": -1.7}])
    f, k = np.linspace(0.4, 0.6, 5), np.linspace(1e-4, 2e-4, 5)
    steady = fo.steady_state(rod, cycle, f, 1.0)
    history = fo.joints.wear(rod, cycle, f, 1.0, coefficient=k, cycles=1e4)
    assert history.volume == pytest.approx(1e4 * (k / f) @ steady.dissipation_per_node, rel=1e-9)
    assert steady.slipping.sum() > 2
    assert np.allclose(history.depth[-1], 1e4 * plain_rate(steady, k), rtol=1e-9)
    assert history.to_frame()["volume"].iloc[-1] == history.volume
    endless = fo.joints.wear(rod, cycle, f, 1.0, coefficient=k)
    assert len(endless.depth) == 1
    assert "constant rates, which do not change any pressure" in endless.reason
    assert not endless.worn_in


@pytest.mark.usefixtures("no_figures_stay_open")
def test_the_table_says_what_the_arrays_say(coarse):
    table, width = coarse.to_frame(), COARSE[0].width
    assert len(table) == len(coarse.depth) == len(coarse.cycles) == len(coarse.pressure)
    assert np.allclose(table["largest_depth"], coarse.depth.max(axis=1))
    assert np.allclose(table["volume"], coarse.depth @ width)
    assert np.allclose(coarse.pressure @ width, 1.0, atol=1e-12)
    assert (coarse.pressure >= -1e-12).all()
    assert np.allclose(coarse.system.gap, COARSE[0].gap + coarse.depth[-1], rtol=1e-14)
    first = fo.steady_state(*COARSE)
    assert table["work"][0] == first.dissipation
    assert table["slipping"][0] == first.slipping.sum()
    assert table["outcome"][0] == "CYCLIC_SLIP"
    stuck = np.abs(COARSE[0].x) < 0.7
    assert np.allclose(table["stick_width"], width[stuck].sum()), (
        "the stick zone of a contact under constant force stays"
    )
    (depth, pressure), x = coarse.plot(), COARSE[0].x
    for ax, values in (depth, coarse.depth), (pressure, coarse.pressure):
        drawn = {
            line.get_label(): line.get_xydata()
            for line in ax.get_lines()
            if len(line.get_xdata()) == len(x)
        }
        rows = [
            row
            for row, cycles in enumerate(table["cycles"])
            if f"after {cycles:.4g} cycles" in drawn
        ]
        assert {0, len(table) - 1} <= set(rows) and len(rows) == len(drawn)
        assert all(
            np.array_equal(
                drawn[f"after {table['cycles'][row]:.4g} cycles"], np.column_stack([x, values[row]])
            )
            for row in rows
        )
    assert coarse.worn_in
    assert table["work"].iloc[-1] <= 1e-3 * table["work"].max()
    assert coarse.residual <= 1e-9


def test_a_history_goes_on_from_its_state():
    whole = fo.joints.wear(*COARSE, coefficient=1e-3, cycles=6e3, tolerance=2e-3)
    first = fo.joints.wear(*COARSE, coefficient=1e-3, cycles=3e3, tolerance=2e-3)
    rest = fo.joints.wear(
        first.system,
        *COARSE[1:],
        coefficient=1e-3,
        cycles=3e3,
        initial_state=first.state,
        tolerance=2e-3,
    )
    assert (
        np.abs(first.depth[-1] + rest.depth[-1] - whole.depth[-1]).max()
        < 2e-3 * whole.depth[-1].max()
    )


@pytest.mark.parametrize(
    ("scene", "cycle", "load_factor"),
    [
        (fo.scenes.RoundedPunch(punch=fo.scenes.PunchOnHalfPlane(elements=24)), PULL, 1.2),
        (fo.scenes.PunchOnHalfPlane(elements=24), PULL, 1.9),
        (fo.scenes.Dovetail(elements=8, edge_radius=5.0), SWAY, 0.7),
    ],
    ids=["rounded punch", "flat punch", "dovetail"],
)
def test_a_coupled_contact_wears_until_it_rests(scene, cycle, load_factor):
    history = fo.joints.wear(scene.condense(), cycle, 0.5, load_factor, coefficient=1e-3)
    assert history.worn_in
    assert history.reason.startswith("worn in")
    assert history.residual < 1e-9
    assert history.volume > 0
    again = fo.steady_state(history.system, cycle, 0.5, load_factor, initial_state=history.state)
    assert again.dissipation == pytest.approx(history.steady.dissipation, rel=1e-6, abs=1e-12)


def test_where_nothing_slips_nothing_wears():
    contact = fo.ContactSystem.from_blocks(
        [[2.0]], [[0.3]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.1])}, width=[1.0]
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    history = fo.joints.wear(contact, cycle, 0.5, 0.2, coefficient=1.0, cycles=10)
    assert history.reason == "the contact does not slip, and does not wear"
    assert history.worn_in
    assert history.volume == 0 == history.cycles[-1]
    none = fo.joints.wear(*COARSE, coefficient=0.0)
    assert none.reason.startswith("no node that slips") and none.volume == 0 and not none.worn_in


def test_a_node_without_wear_keeps_its_profile():
    k = np.where(COARSE[0].x < 0, 0.0, 1e-3)
    history = fo.joints.wear(*COARSE, coefficient=k, cycles=3e3)
    assert not history.depth[-1][:16].any() and history.depth[-1][16:].max() > 0


@pytest.mark.parametrize("error", [KeyboardInterrupt, fo.NoContinuation, fo.SolverError])
def test_what_stops_wear_keeps_what_is_done(error):
    with interrupted("wear", 6, error) as caught:
        fo.joints.wear(*COARSE, coefficient=1e-3)
    history = caught.value.history
    assert len(history.depth) == 7
    assert 0 < history.cycles[-1]
    assert history.reason == f"{error.__name__}: stop"
    assert not history.worn_in
    assert history.residual <= 1e-9
    assert "`history`" in caught.value.__notes__[0]
    assert (
        fo.joints.wear(
            history.system, *COARSE[1:], coefficient=1e-3, initial_state=history.state, cycles=1e3
        ).volume
        > 0
    )


@refused(
    ({"coefficient": -1e-3}, "coefficient: -0.001; give a coefficient of wear >= 0"),
    (
        {"coefficient": np.r_[np.ones(31), -1e-3]},
        "coefficient: -0.001 at node 31; give a coefficient of wear >= 0",
    ),
    ({"coefficient": [1e-3, 1e-3]}, r"coefficient: shape \(2,\)"),
    ({"coefficient": 1e-3, "cycles": 0.5}, "cycles: 0.5"),
    ({"coefficient": 1e-3, "cycles": np.inf}, "cycles: inf"),
    ({"coefficient": 1e-3, "tolerance": 0.0}, "tolerance: 0.0"),
    ({"coefficient": 1e-3, "steps": 0}, "steps: 0"),
)
def test_bad_input_is_refused_by_name(options):
    fo.joints.wear(*COARSE, **options)


def test_a_contact_without_width_or_friction_is_refused():
    bare = fo.ContactSystem.from_blocks(**fo.reference.half_plane_contact(4, 1.0, 1.0))
    with pytest.raises(fo.ModelError, match="width: not known"):
        fo.joints.wear(bare, *COARSE[1:], coefficient=1e-3)
    f = np.where(np.arange(32) == 3, 0.0, F)
    with pytest.raises(fo.ModelError, match="friction: 0 at node 3"):
        fo.joints.wear(*COARSE[:2], f, COARSE[3], coefficient=1e-3)
    assert (
        fo.joints.wear(*COARSE[:2], f, COARSE[3], coefficient=1e-3 * f, cycles=100).depth[-1][3]
        == 0
    )
