"""Frequency and damping as functions of the amplitude.

They are compared with Jenkins' element, a published oscillator, closed forms of rods, cylinders and
spheres, and Masing's rule.
"""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshQuad

import frictopt as fo
from helpers.interrupts import interrupted
from helpers.paths import WALKING
from helpers.systems import BLOCK, PUSHED_AND_PULLED, linprog_limit
from studies.validation.vibrations import wedges

pytestmark = pytest.mark.usefixtures("few_starts")


def opposed(case, mean):
    return fo.LoadCycle(mean, [{case: 1.0}, {case: -1.0}])


def test_the_element_of_jenkins():
    """The curve agrees with Jenkins' element.

    A mass is on a spring k0, and on a spring k_t that slides at mu N.
    """
    k0, kt, mu, N, m = 3.0, 5.0, 0.4, 2.0, 0.7
    # The mode is 1 / sqrt(m), its load m times that.
    one = {"N": ([0.0], [1.0]), "mode": ([-np.sqrt(m)], [0.0])}
    hard = fo.ContactSystem.from_blocks(
        [[k0]], [[0.0]], [[1.0]], [0.0], one, width=[1.0], compliance=np.zeros((2, 2))
    )
    system = hard.with_contact_stiffness(tangential=kt)
    force = np.array([0.1, 0.15, 0.5, 1.0, 4.0, 30.0]) * mu * N * (k0 + kt) / kt
    natural = np.sqrt((k0 + kt) / m) / (2 * np.pi)
    curve = fo.joints.backbone_curve(
        system,
        opposed("mode", {"N": N}),
        mu,
        force / np.sqrt(m),
        natural_frequency=1.005 * natural,
        with_range=True,
    )
    slides = force > mu * N * (k0 + kt) / kt
    X = np.where(slides, (force - mu * N) / k0, force / (k0 + kt))
    work = np.where(slides, 4 * mu * N * (X - mu * N / kt), 0.0)
    assert slides.sum() == 2
    assert curve.displacement == pytest.approx(X * np.sqrt(m), rel=1e-12)
    assert curve.work == pytest.approx(work, rel=1e-12, abs=1e-12)
    assert (2 * np.pi * curve.frequency) ** 2 == pytest.approx(
        np.where(slides, k0 + mu * N / X, k0 + kt) / m, rel=1e-12
    )
    assert curve.damping == pytest.approx(work / (2 * np.pi * force * X), rel=1e-12, abs=1e-13)
    assert curve.natural_frequency == pytest.approx(natural)
    assert (
        curve.shakedown_limit
        == pytest.approx(mu * N * (k0 + kt) / kt / np.sqrt(m))
        == curve.guaranteed_limit
    )
    assert np.isnan(curve.exponent).tolist() == [True] * 5 + [False]  # of load factors without work
    # The square of this load factor is 0 by underflow.
    least = fo.joints.backbone_curve(
        system, opposed("mode", {"N": N}), mu, [1e-200], natural_frequency=natural
    )
    assert least.damping == 0 and least.frequency == pytest.approx(curve.natural_frequency)
    assert np.array_equal(curve.least_damping, curve.damping)
    assert np.array_equal(curve.most_frequency, curve.frequency)


def with_a_gap(pressed):
    """Two coupled nodes, of which the mean load leaves node 1 open, and Q presses it."""
    loads = {"P": ([0.2, -0.2], [1.2, 0.1]), "Q": ([-0.5, 1.3], [0.7, pressed])}
    A, B, C = [[2.3, -0.4], [-0.4, 1.4]], [[-0.2, 0.8], [0.5, -0.2]], [[4.3, 0.0], [0.0, 2.6]]
    return fo.ContactSystem.from_blocks(
        A, B, C, [0.0, 1.0], loads, gap=[0.0, 0.1], compliance=2 * np.eye(2)
    )


def test_damping_below_the_guaranteed_limit_where_a_node_opens_and_closes():
    """The closed contact rests there from every start, but a node that is open under the mean load
    closes in each cycle. Random starts show this."""
    pair = with_a_gap(0.2)
    cycle = opposed("Q", {"P": 1.0})
    friction = [0.5, 0.4]
    starts = 3.0 * np.random.default_rng(1).normal(size=(20, 2))
    curve = fo.joints.backbone_curve(pair, cycle, friction, [0.7], with_range=True)
    seen = [
        fo.steady_state(pair, cycle, friction, 0.7, initial_slip=start).loop("Q")
        for start in starts
    ]
    damping = [loop.area / (np.pi * 0.7 * np.ptp(loop.displacement)) for loop in seen]
    rest = fo.steady_state(pair, cycle, friction, 0.05)
    found = fo.joints.backbone_curve(pair, cycle, friction, [0.05]).displacement[0]
    # Softer than the glued one.
    assert rest.outcome is fo.Outcome.SHAKEDOWN
    assert rest.open.any()
    assert abs(found / (2 * 0.05) - 1) > 1e-3
    assert found == pytest.approx(np.ptp(rest.loop("Q").displacement) / 2)
    assert 0.7 < 0.9 * curve.guaranteed_limit and curve.damping[0] < 0.5 * max(damping)
    assert curve.least_damping[0] <= min(damping) + 1e-12
    assert curve.most_damping[0] >= max(damping) * (1 - 1e-9)


def test_the_frequency_of_a_mode_may_be_that_with_open_nodes():
    """The reference is the vibration of the state with the open node under a load so small that
    nothing slips and nothing closes."""
    question = with_a_gap(0.9), opposed("Q", {"P": 1.0}), [0.5, 0.4]
    rest = fo.joints.backbone_curve(*question, [1e-3])
    # Softer than the glued contact.
    assert rest.outcome == ("SHAKEDOWN",)
    assert rest.displacement[0] > 1.05 * 2 * 1e-3
    softer, glued = (1 / (2 * np.pi * np.sqrt(soft)) for soft in (rest.displacement[0] / 1e-3, 2.0))
    assert fo.joints.backbone_curve(
        *question, [1e-3], natural_frequency=softer
    ).frequency == pytest.approx(softer, rel=1e-9)
    for right in (softer, glued):
        assert fo.joints.backbone_curve(
            *question, [1e-3], natural_frequency=right
        ).natural_frequency == pytest.approx(right, rel=1e-9)
    with pytest.raises(fo.ModelError, match="natural_frequency"):
        fo.joints.backbone_curve(*question, [1e-3], natural_frequency=0.9 * softer)


def test_a_published_oscillator():
    """The curve agrees with the curves of a published oscillator.

    The published values are samples of 25 residual tractions, by a code with 100 steps a quarter
    cycle and 1 % error in damping. The range holds them.
    """
    structure = wedges()
    stuck = structure.modes()[0][2] / (2 * np.pi)
    assert stuck == pytest.approx(49.42140619, rel=1e-9)
    curve = structure.curve(2, [200.0, 800.0, 1200.0], with_range=True)
    system, cycle = curve.system, curve.cycle
    assert curve.natural_frequency == pytest.approx(stuck, rel=1e-12)
    assert curve.shakedown_limit == pytest.approx(linprog_limit(system, cycle, 0.9)[1], rel=1e-9)
    for factor, least, most in (
        (200.0, 0.0, 0.0436),
        (800.0, 0.0286, 0.0381),
        (1200.0, 0.0210, 0.0274),
    ):
        (row,) = np.flatnonzero(curve.load_factor == factor)
        assert curve.least_damping[row] <= 1.01 * least and curve.most_damping[row] >= 0.99 * most
        assert curve.least_damping[row] <= curve.damping[row] <= curve.most_damping[row]
    assert curve.least_frequency[0] <= 1.001 * 47.01
    assert curve.most_frequency[0] == pytest.approx(49.42, abs=0.01)
    assert curve.least_frequency[2] <= 1.001 * 42.93 and curve.most_frequency[2] >= 0.999 * 43.24
    same = fo.joints.backbone_curve(system, cycle, 0.9, [800.0], natural_frequency=stuck)
    unsaid = fo.joints.backbone_curve(system, cycle, 0.9, [800.0], with_range=True)
    assert all(
        np.isnan(np.r_[getattr(unsaid, name), unsaid.natural_frequency]).all()
        for name in ("frequency", "least_frequency", "most_frequency")
    )
    assert unsaid.stiffness == pytest.approx((2 * np.pi * curve.frequency[1:2]) ** 2)
    assert "least_frequency" not in repr(unsaid)
    assert "no frequency: it needs the load of a mode" in unsaid.note
    assert unsaid.most_damping == pytest.approx(curve.most_damping[1:2])
    assert same.frequency == pytest.approx(curve.frequency[1:2])
    assert np.isnan(same.most_damping).all()
    twice = fo.LoadCycle({"static": 1.0}, [{"mode 2": 2.0}, {"mode 2": -2.0}])
    assert fo.joints.backbone_curve(
        system, twice, 0.9, [400.0], natural_frequency=stuck / 2
    ).displacement == pytest.approx(2 * same.displacement)
    with pytest.raises(fo.ModelError, match="natural_frequency: 48"):
        fo.joints.backbone_curve(system, cycle, 0.9, [800.0], natural_frequency=48.0)


def test_the_cylinder_of_cattaneo_and_mindlin():
    arrays = fo.reference.half_plane_contact(nodes=160, half_length=1.2, E_star=1.0, R=1.0)
    system = fo.ContactSystem.from_blocks(**arrays)
    P, f = np.pi / 4, 0.4
    x = np.array([0.35, 0.5, 0.7, 0.9])
    curve = fo.joints.backbone_curve(system, opposed("Q", {"P": P}), f, x * f * P)
    exact = 4 * f**2 * P**2 / np.pi * (x - x**2 / 2 + (1 - x) * np.log(1 - x))
    assert curve.work == pytest.approx(exact, rel=0.02)
    assert curve.exponent == pytest.approx(np.gradient(np.log(exact), np.log(x)), rel=0.02)
    assert 3 < curve.exponent[0] < 3.6  # 3 at small amplitude


@pytest.mark.usefixtures("no_figures_stay_open")
def test_a_load_that_is_no_mode_has_no_frequency():
    """Its frequency would be the root of a stiffness per load factor, which has not the unit of a
    frequency."""
    punch = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    cycle = opposed("sigma", {"P": 1.0})
    curve = fo.joints.backbone_curve(punch, cycle, 0.5, [1.5], with_range=True)
    assert np.isnan(
        [curve.natural_frequency, *curve.frequency, *curve.least_frequency, *curve.most_frequency]
    ).all()
    assert np.isfinite([*curve.stiffness, *curve.most_damping]).all()
    assert curve.to_frame()["frequency"].isna().all()
    _, _, above, _ = curve.plot()
    assert "stiffness" in above.get_ylabel()
    # The load factor times the size of the load is a force, over the motion of the loaded surface.
    force = 1.5 * punch.load_size["sigma"]
    assert above.get_lines()[0].get_ydata() == pytest.approx(force / curve.motion)


@pytest.mark.usefixtures("no_figures_stay_open")
def test_load_factors_without_work_are_marked_at_the_lower_end():
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    curve = fo.joints.backbone_curve(rod, cycle, 0.5, [0.1, 0.2, 1.0])
    assert (curve.work == 0).tolist() == [True, True, False]
    work = curve.plot()[0]
    (marks,) = [line for line in work.get_lines() if line.get_label() == "no work"]
    assert marks.get_xdata().tolist() == [0.1, 0.2]
    places = marks.get_transform().transform(marks.get_xydata())
    assert places[:, 1] == pytest.approx(work.bbox.y0)
    assert "no work" in [text.get_text() for text in work.get_legend().get_texts()]


def test_the_load_with_a_little_work_is_above_the_load_that_first_slips():
    """A block on a spring of 3 slips by (load - 0.5) / 3, twice in a cycle, against 0.5.

    So its work is `2 (load - 0.5) / 3`, and a straight line from the load factor without work would
    say too small a load for all work below a third.
    """
    curve = fo.joints.backbone_curve(BLOCK, PUSHED_AND_PULLED, 0.5, [4e-4, 0.4, 1.0])
    for work in (1e-3, 0.01, 0.1, 0.3):
        steady = curve.load_at(work=work)
        assert steady.load_factor == pytest.approx(0.5 + 1.5 * work, rel=2e-4)
        assert steady.dissipation >= work
    # The search also ends at small load factors.
    curve = fo.joints.backbone_curve(BLOCK, PUSHED_AND_PULLED, 5e-4, [1e-4, 4e-4, 1e-3])
    small = curve.load_at(work=1e-7)
    assert small.load_factor == pytest.approx(5e-4 + 1.5e-4, rel=2e-4)


# Two nodes in space, pressed by 1 and 3, of areas 1 and 3, each on springs of 1: a node slips by
# the load less f p, twice in a cycle, and back.
NAMES, FORCES = ["a", "b"], np.array([1.0, 3.0])
TWO = fo.ContactSystem(
    np.eye(6),
    [[0, 0, 0], [1, 0, 0]],
    {"P": [0, 0, 0, 0, *FORCES], "X": [1, 1, 0, 0, 0, 0]},
    contact=NAMES,
    width=FORCES,
    compliance=np.eye(2),
)


def by_hand(load, f):
    """Slip ranges, and work of friction per cycle, of both nodes."""
    slip_length = 2 * (load - f * FORCES).clip(0.0)
    return slip_length, 2 * f * FORCES * slip_length


def test_two_sliders_in_space_contact_by_contact():
    loads, f = [0.4, 0.75, 1.4, 2.0], 0.5
    curve = fo.joints.backbone_curve(TWO, opposed("X", {"P": 1.0}), f, loads, steps=1)
    slip_range, work = (
        np.array(values) for values in zip(*(by_hand(load, f) for load in loads), strict=True)
    )
    assert curve.outcome == ("SHAKEDOWN", *["CYCLIC_SLIP"] * 3)
    assert curve.slipping.tolist() == [0.0, 0.25, 0.25, 1.0]
    assert curve.work == pytest.approx(work.sum(axis=1))
    assert curve.slip_range == pytest.approx(slip_range.max(axis=1))
    table = curve.by_contact
    assert table["contact"].tolist() == NAMES * 4
    assert np.array(table["load_factor"]) == pytest.approx(np.repeat(loads, 2))
    assert np.array(table["work"]) == pytest.approx(work.ravel())
    assert np.array(table["slip_range"]) == pytest.approx(slip_range.ravel())
    assert np.array(table["slipping"]) == pytest.approx((slip_range > 0).ravel().astype(float))
    assert curve.displacement == pytest.approx(np.array(loads) + (slip_range / 2).sum(axis=1))
    assert curve.gross_slip == np.inf
    assert np.isnan(
        [*curve.frequency, *curve.most_damping, curve.shakedown_limit, curve.guaranteed_limit]
    ).all()
    # The work of the first slider alone is 2 at a load factor of 1.5, where the second one begins.
    two = curve.load_at(work=2.0, progress=False)
    assert 1.5 <= two.load_factor < 1.5 * 1.01
    assert two.dissipation == pytest.approx(by_hand(two.load_factor, f)[1].sum())
    assert two.dissipation >= 2.0
    assert 0.75 * 0.99 < curve.load_at(work=curve.work[1]).load_factor <= 0.75
    third = curve.load_at(slipping=1 / 3)
    assert 1.5 < third.load_factor < 1.5 * 1.01
    assert third.slipping_share == 1.0  # from a quarter on, no share is less
    turning = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {}])  # around a mean of a half
    other = fo.joints.backbone_curve(TWO, turning, f, 2 * np.array(loads), steps=1)
    assert other.work == pytest.approx(curve.work)
    assert np.isnan([other.displacement, other.stiffness, other.damping]).all()
    assert "two opposed corners" in other.note
    assert "two opposed corners" in repr(other)
    assert other.to_frame().attrs["note"] == other.note


def test_the_curve_of_a_rod_and_the_load_of_half_its_length():
    """The curve of a rod is known in closed form.

    Slip comes as far as the end force over the friction of a length. The closed form of the work
    holds for whole numbers of nodes.
    """
    # Free to lift off.
    rod = fo.ContactSystem.from_blocks(
        **fo.reference.foundation_rod(nodes=20, EA=2.0, h=0.1) | {"C": np.zeros((20, 20))}
    )
    cycle = fo.LoadCycle({"pressure": 2.0}, [{"force": 1.0}, {"force": -1.0}])
    reach = np.array([2, 4, 8, 16])
    curve = fo.joints.backbone_curve(rod, cycle, 0.5, 0.1 * reach)
    exact = [fo.reference.rod_dissipation(force, 2.0, 1.0, 0.1) for force in 0.1 * reach]
    # The last node rests.
    assert curve.work == pytest.approx(exact, rel=1e-9)
    assert curve.slipping == pytest.approx((reach - 1) / 20)
    assert curve.gross_slip == pytest.approx(2.0)
    assert "no compliance" in curve.note
    assert "of the nodes" in curve.note
    default = fo.joints.backbone_curve(rod, cycle, 0.5)
    assert default.load_factor[[0, -1]] == pytest.approx([0.1, 1.9])
    half, work = curve.load_at(slipping=0.5), curve.load_at(work=0.1)
    assert 1.0 < half.load_factor < 1.0002  # the tenth node begins to slip at 1
    assert half.slipping_share == 0.5
    assert work.dissipation == pytest.approx(
        fo.reference.rod_dissipation(work.load_factor, 2.0, 1.0, 0.1)
    )
    assert 0.1 <= work.dissipation < 0.1 * 1.001
    for name, value, message in (
        ("slipping", 0.9, r"0\.05 to 0\.75 at the load factors 0\.2 to 1\.6"),
        ("work", 1e-9, "work: 1e-09"),
        ("work", -1, "work: -1"),
    ):
        with pytest.raises(fo.ModelError, match=message):
            curve.load_at(**{name: value})
    for target in ({}, {"slipping": 0.5, "work": 0.1}):
        with pytest.raises(fo.ModelError, match=r"slipping, work: .*; give one of the two"):
            curve.load_at(**target)


def test_a_number_with_which_the_curve_begins_has_a_load():
    """A slider of stiffness 3 slips from the force 0.5 on, and its work grows with the rest."""
    curve = fo.joints.backbone_curve(BLOCK, PUSHED_AND_PULLED, 0.5, [0.6, 0.8])
    first_work = 4 * 0.5 * (0.6 - 0.5) / 3
    assert curve.work[0] == pytest.approx(first_work)
    assert curve.load_at(work=curve.work[0]).load_factor == 0.6
    assert curve.load_at(slipping=1.0).load_factor == pytest.approx(0.5, rel=2e-4)


def test_beyond_the_load_that_slides_the_body_off_there_is_no_number():
    block = fo.ContactSystem.from_blocks(
        [[0.0]],
        [[0.0]],
        [[0.0]],
        [0.0],
        {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])},
        compliance=np.eye(2),
    )
    curve = fo.joints.backbone_curve(block, opposed("Q", {"P": 4.0}), 0.5, [1.0, 1.9, 2.1])
    assert curve.gross_slip == pytest.approx(2.0)
    assert curve.outcome == ("SHAKEDOWN", "SHAKEDOWN", "SLIDES_OFF")
    assert curve.work.tolist()[:2] == [0.0, 0.0]
    assert np.isnan(
        [getattr(curve, name)[2] for name in ("work", "slipping", "displacement")]
    ).all()
    assert "load factors 2.1: above it no state of rest exists" in curve.note
    assert set(curve.by_contact["load_factor"]) == {1.0, 1.9}
    with pytest.raises(fo.NoContinuation, match="the body may slide or open as a whole"):
        fo.joints.backbone_curve(block, opposed("Q", {"P": 4.0}), 0.5, [2.1, 3.0])


def test_a_contact_that_ratchets_has_work_and_no_displacement():
    system, cycle, f, factor = WALKING
    curve = fo.joints.backbone_curve(replace(system, compliance=np.eye(3)), cycle, f, [0.1, factor])
    assert curve.outcome == ("SHAKEDOWN", "RATCHETING")
    assert curve.work[1] == fo.steady_state(*WALKING).dissipation > 0
    assert np.isfinite(curve.displacement[0])
    assert np.isnan(curve.displacement[1])
    assert np.isnan(curve.damping[1])
    assert f"load factor {factor:g}: the contact ratchets" in curve.note


def test_what_is_finished_is_kept_when_a_curve_is_interrupted():
    with interrupted("backbone curve", 2) as stopped:
        fo.joints.backbone_curve(TWO, opposed("X", {"P": 1.0}), 0.5, [0.4, 0.75, 1.4], steps=1)
    assert stopped.value.curve.load_factor.tolist() == [0.4, 0.75]
    assert "2 of 3 load factors" in stopped.value.__notes__[0]


def test_bad_input():
    punch = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense()
    cycle = opposed("sigma", {"P": 1.0})
    for corners in (
        [{"sigma": 1.0}],
        [{"sigma": 1.0}, {"sigma": -0.5}],
        [{"sigma": 1.0}, {}, {"sigma": -1.0}],
        [{}, {}],
    ):
        for options in ({"natural_frequency": 1.0}, {"with_range": True}):
            with pytest.raises(
                fo.ModelError, match=r"(natural_frequency|with_range): .*two opposed corners"
            ):
                fo.joints.backbone_curve(
                    punch, fo.LoadCycle({"P": 1.0}, corners), 0.5, [1.0], **options
                )
    with pytest.raises(fo.ModelError, match=r"natural_frequency: .*no fixed part"):
        fo.joints.backbone_curve(
            punch,
            fo.LoadCycle({"P": 1.0}, cycle.corners, fixed=[{"Q": 0.1}, {}]),
            0.5,
            [1.0],
            natural_frequency=1.0,
        )
    for factors in ([], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [-1.0], "1", [np.nan]):
        with pytest.raises(fo.ModelError, match="load_factors"):
            fo.joints.backbone_curve(punch, cycle, 0.5, factors)
    with pytest.raises(
        fo.ModelError, match="load_factors: None, and the load that slides the bodies off is inf"
    ):
        fo.joints.backbone_curve(punch, cycle, 0.5)
    bare = fo.ContactSystem(punch.S, punch.points, dict(punch.bonded))
    with pytest.raises(fo.ModelError, match=r"with_range: True, .* no compliance"):
        fo.joints.backbone_curve(bare, cycle, 0.5, [1.0], with_range=True)
    for odd in (0.0, -1.0, np.inf, "1"):
        with pytest.raises(fo.ModelError, match="natural_frequency"):
            fo.joints.backbone_curve(punch, cycle, 0.5, [1.0], natural_frequency=odd)
    for overlap in (1.0, 0.3, 0.7, 0.11):  # the work of each is rounding, of either sign
        with pytest.raises(fo.ModelError, match="the load does no work"):
            fo.joints.backbone_curve(
                punch.with_interference({"fit": overlap}),
                opposed("fit", {"P": 1.0}),
                0.5,
                [1e-3],
                natural_frequency=1.0,
            )
    for odd, cyclic in ({"X": 1.0}, cycle.corners), (cycle.mean, [{"X": 1.0}, {"X": -1.0}]):
        with pytest.raises(fo.ModelError, match="load case 'X': unknown"):
            fo.joints.backbone_curve(punch, fo.LoadCycle(odd, cyclic), 0.5, [1.0])
    with pytest.raises(fo.ModelError, match="with_range: 'yes'"):
        fo.joints.backbone_curve(punch, cycle, 0.5, [1.0], with_range="yes")


@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kinematics", ["plane_strain", "plane_stress"])
def test_the_motion_of_a_load_is_a_length(kinematics, element, tmp_path):
    """Friction glues a pad to a pad of the same steel. The sheared face of the pad moves by the
    mean of its displacements, which `recover` finds."""
    x, steel = np.linspace(0.0, 20.0, 9), fo.fem.Material(E=210e3, nu=0.3)
    sides = {"low": lambda x: x[1] == x[1].min(), "high": lambda x: x[1] == x[1].max()}
    pad, base = (
        fo.fem.Body(
            MeshQuad.init_tensor(x, np.linspace(y, y + 10.0, 5)).with_boundaries(sides),
            steel,
            element,
        )
        for y in (0.0, -10.0)
    )
    loads = {
        "P": [fo.fem.Pressure("pad", "high", 100.0)],
        "Q": [fo.fem.Traction("pad", "high", x=3.0, y=4.0)],
    }
    contacts, supports = (
        [fo.fem.Contact("pad", "base", "low", "high")],
        [fo.fem.Support("base", "low")],
    )
    model = fo.fem.ContactModel(
        {"pad": pad, "base": base}, supports, loads, contacts, kinematics=kinematics, units="N, mm"
    )
    system = model.condense()
    system.save(tmp_path / "pads.npz")
    assert fo.ContactSystem.load(tmp_path / "pads.npz").load_size == system.load_size
    # 5 MPa on 20 mm.
    assert system.load_size == {"P": pytest.approx(2000.0), "Q": pytest.approx(100.0)}
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"Q": -2.0}])
    curve = fo.joints.backbone_curve(system, cycle, 0.9, load_factors=[0.5, 1.0])
    assert curve.outcome == ("SHAKEDOWN", "SHAKEDOWN")
    fields = model.recover({"Q": 2.0}, np.zeros(system.nodes), np.zeros(system.nodes))
    mesh, u = fields.bodies["pad"].mesh, fields.displacement["pad"]
    nodes = np.flatnonzero(mesh.p[1] == 10.0)
    nodes = nodes[mesh.p[0, nodes].argsort()]
    if element == "linear":
        mean = np.trapezoid(u[:, nodes], mesh.p[0, nodes]) / 20.0
    else:  # by Simpson's rule over each edge
        weights = np.ones(len(nodes)) * 2.0
        weights[1::2], weights[[0, -1]] = 4.0, 1.0
        mean = u[:, nodes] @ weights / weights.sum()
    along = mean @ [0.6, 0.8]
    assert curve.motion == pytest.approx([0.5 * along, along], rel=1e-9)
    assert curve.to_frame()["motion"].tolist() == curve.motion.tolist()
    bare = replace(system, load_size={})
    assert np.isnan(fo.joints.backbone_curve(bare, cycle, 0.9, load_factors=[1.0]).motion).all()
    assert "P" not in system.with_interference({"P": 0.1}).load_size
    assert "Q" not in system.with_bonded({"Q": system.bonded["Q"]}).load_size


def test_a_steady_cycle_beyond_friction_moves_its_load_further():
    """One node has the stiffness k and the force F. Half of its range is F / k and the slip that
    friction leaves, for a load of any size."""
    block = replace(BLOCK, load_size={"F": 4.0})
    curve = fo.joints.backbone_curve(block, PUSHED_AND_PULLED, 0.5, load_factors=[0.4, 1.0])
    assert curve.motion == pytest.approx([0.1, (1.0 + 0.5 / 3.0) / 4.0])
