"""Forced responses against independent methods.

The methods are the slider in closed form, the linear mode, steady states at exact amplitudes,
folds, units, other modes, and time integrations that shares no code with the package.
"""

from dataclasses import replace
from itertools import pairwise

import matplotlib
import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, minimize_scalar

import frictopt as fo
from studies.validation.jointed_mass import JointedMass
from studies.validation.vibrations import Vibration, rocking, slider, wedges

matplotlib.use("Agg")
pytestmark = pytest.mark.usefixtures("few_starts", "no_figures_stay_open")

# The slider: stiffness with and without its spring, force of friction, and amplitude of first slip.
STIFF, SPRING, LIMIT = 1e4, 6e3, 20.0
START = LIMIT / SPRING


@pytest.fixture(scope="module")
def curve():
    factors = (STIFF + SPRING) * START * np.append(0.5, np.geomspace(1.0, 40.0, 200))
    return slider(STIFF, SPRING, LIMIT).curve(0, factors)


@pytest.fixture(scope="module")
def light():
    return rocking().curve(0, np.geomspace(10, 700, 60))


def stiffness(a):
    """First harmonic of a spring and a slider, over the amplitude."""
    angle = np.arccos(np.clip(1 - 2 * START / a, -1, 1))
    slides = np.where(a > START, angle, np.pi)
    return STIFF + SPRING / np.pi * (slides - np.sin(2 * slides) / 2)


def test_the_resonance_of_a_slider_is_its_first_harmonic(curve):
    a = curve.displacement
    assert (2 * np.pi * curve.resonance) ** 2 == pytest.approx(stiffness(a), rel=1e-9)
    assert curve.resonance[-1] < 0.82 * curve.natural_frequency
    # At first slip the tips of the loop are softer than its first harmonic, in full slip stiffer.
    assert curve.resonance[8] > 1.005 * curve.frequency[8]
    assert curve.resonance[-1] < 0.999 * curve.frequency[-1]
    assert curve.to_frame()["resonance"].tolist() == curve.resonance.tolist()


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
def test_friction_alone_holds_a_slider_up_to_four_over_pi_of_its_force(curve, share):
    bound = 4 * LIMIT / np.pi
    answer = curve.response([share * bound])
    exact = START / (1 - share)
    assert answer.peak[0] == pytest.approx(exact, rel=1e-3)
    assert answer.resonance[0] == pytest.approx(np.sqrt(stiffness(exact)) / 2 / np.pi, rel=1e-3)
    assert answer.lag[0] == pytest.approx(90.0, abs=1e-4)
    # The balance of energy is pi f a = 4 F (a - a_s).
    gain = np.log((1 - 0.95 * share) / (1 - share)) / np.log(1 / 0.95)
    assert answer.sensitivity[0] == pytest.approx(gain, rel=0.03)
    assert curve.largest_force(amplitude=exact) == pytest.approx(share * bound, rel=1e-3)
    assert np.isnan([*answer.least_peak, *answer.most_peak]).all()
    # The force over a cycle, and the motion of the mass by its harmonics.
    x = exact * np.cos(2 * np.pi * np.arange(1024) / 1024)
    falling = np.maximum(LIMIT - SPRING * (exact - x), -LIMIT)
    rising = np.minimum(SPRING * (exact + x) - LIMIT, LIMIT)
    force = STIFF * x + np.where(np.arange(1024) < 512, falling, rising)
    harmonics = np.abs(np.fft.rfft(force)[2:13]) / 512 / np.arange(2, 13) ** 2
    left_out = np.linalg.norm(harmonics) / force.max()
    assert answer.interaction[0] == pytest.approx(gain * left_out, rel=0.03)


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
def test_a_peak_between_distant_load_factors_is_checked(share):
    bound = 4 * LIMIT / np.pi
    gain = share / (1 - share)
    coarse = slider(STIFF, SPRING, LIMIT).curve(0, STIFF * START * np.array([1.0, 40.0, 80.0]))
    answer = coarse.response([share * bound])
    exact = START * (1 + gain)
    # The force balances to 1 %.
    assert answer.peak[0] == pytest.approx(exact, rel=0.01 * max(gain, 1.0))
    assert "not checked" not in answer.note
    assert coarse.largest_force(amplitude=exact) == pytest.approx(share * bound, rel=0.01)


def test_a_peak_without_a_steady_state_is_named():
    """A far load factor joins a curve that slides off before it, so no state can be checked."""
    coarse = slider(STIFF, SPRING, LIMIT).curve(0, STIFF * START * np.array([1.0, 40.0, 80.0]))
    stuck = replace(coarse, friction=np.zeros(len(coarse.friction)))
    answer = stuck.response([0.6 * 4 * LIMIT / np.pi])
    assert "the peak is not checked" in answer.note
    with pytest.raises(fo.SolverError, match=r"amplitude: .* not known to 1 %"):
        stuck.largest_force(amplitude=2 * START)


def test_above_four_over_pi_of_its_force_only_other_damping_holds_a_slider(curve):
    force = 1.05 * 4 * LIMIT / np.pi
    free = curve.response([force, 0.5 * force])
    assert free.beyond.tolist() == [True, False] and free.peak[0] == np.inf
    assert np.isnan([free.resonance[0], free.lag[0], free.sensitivity[0]]).all()
    assert f"force {force:g}: the peak lies beyond the curve" in free.note
    ratio = 0.01

    def excess(a):
        omega = np.sqrt(stiffness(a))
        viscous = 2 * ratio * 2 * np.pi * curve.natural_frequency * omega * a
        return 4 * LIMIT * (1 - START / a) / np.pi + viscous - force

    exact = brentq(excess, 1.01 * START, 40 * START)
    damped = curve.response([force], damping=ratio)
    assert damped.peak[0] == pytest.approx(exact, rel=1e-3)
    # At this frequency the balance of energy is a quadratic equation for the amplitude.
    viscous = 4 * np.pi * ratio * curve.natural_frequency * 2 * np.pi * damped.resonance[0]
    roots = np.roots([np.pi * viscous, 4 * LIMIT - np.pi * force, -4 * LIMIT * START])
    assert damped.peak[0] == pytest.approx(roots.max(), rel=1e-3)


@pytest.mark.parametrize("ratio", [0.001, 0.05, 0.6, 0.9])
def test_without_slip_a_mode_is_linear(ratio):
    still = slider().curve(0, [10.0, 20.0, 30.0, 50.0])
    force = np.array([1e-3, 40.0 * min(1.0, 2 * ratio * np.sqrt(1 - min(ratio, 0.7) ** 2))])
    answer = still.response(force, damping=ratio)
    omega = 2 * np.pi * still.natural_frequency
    if ratio < np.sqrt(0.5):
        peak = force / (2 * ratio * omega**2 * np.sqrt(1 - ratio**2))
        turn = still.natural_frequency * np.sqrt(1 - 2 * ratio**2)
        assert answer.lag == pytest.approx(
            np.degrees(np.arctan2(np.sqrt(1 - 2 * ratio**2), ratio)), rel=1e-9
        )
    else:  # no resonance: the static amplitude is the largest
        peak, turn = force / omega**2, 0.0
    assert answer.peak == pytest.approx(peak, rel=1e-12)
    assert answer.resonance == pytest.approx(turn, rel=1e-12)
    assert answer.sensitivity.tolist() == answer.interaction.tolist() == [0.0, 0.0]
    assert still.largest_force(amplitude=answer.peak[1], damping=ratio) == pytest.approx(force[1])
    rows = answer.branches
    driven = 2 * np.pi * rows["frequency"].to_numpy()
    dynamic = omega**2 - driven**2 + 2j * ratio * omega * driven
    assert rows["amplitude"].to_numpy() == pytest.approx(
        rows["force"].to_numpy() / np.abs(dynamic), rel=1e-9
    )
    assert rows["lag"].to_numpy() == pytest.approx(np.degrees(np.angle(dynamic)), rel=1e-9)
    assert not answer.beyond.any() and answer.folds.empty and answer.detached.empty


def falling_joint(*load_factors):
    """A mass on a node whose pressure varies with the motion, and which lifts off.

    The friction force at the resonance rises, falls and rises again with the amplitude.
    """
    one = np.ones(1)
    joint = JointedMass(np.array([[0.3]]), 0.3 * one, -one, one, one)
    return joint.curve(np.array(load_factors))


def test_a_force_that_falls_with_the_amplitude_has_a_detached_curve():
    """The peaks of a force are where it balances the work of a steady state, pi f a = W."""
    curve = falling_joint(*np.geomspace(0.6, 5.0, 16))

    def state(factor):
        steady = fo.steady_state(curve.system, curve.cycle, curve.friction, factor)
        loop = steady.loop("mode").displacement
        a = (loop.max() - loop.min()) / 2
        return a, steady.dissipation / (np.pi * a)

    top = minimize_scalar(lambda factor: -state(factor)[1], bounds=(0.8, 1.6), method="bounded")
    bottom = minimize_scalar(lambda factor: state(factor)[1], bounds=(top.x, 3.5), method="bounded")
    force = -0.6 * top.fun + 0.4 * bottom.fun
    ends = [0.5 * top.x, top.x, bottom.x, 5.0]
    exact = []
    for low, high in pairwise(ends):
        factor = brentq(lambda factor: state(factor)[1] - force, low, high, xtol=1e-6)
        exact.append(state(factor)[0])
    answer = curve.response([force])
    assert answer.peak == pytest.approx([exact[0]], rel=0.02)
    (row,) = answer.detached.itertuples()
    assert (row.least, row.most) == pytest.approx(tuple(exact[1:]), rel=0.03)
    far = answer.branches[answer.branches["detached"]]
    assert far["amplitude"].agg(["min", "max"]).tolist() == pytest.approx([row.least, row.most])
    assert "a sweep from rest does not reach the detached curve" in answer.note
    assert curve.largest_force(amplitude=exact[2]) == pytest.approx(-top.fun, rel=0.01)
    shorter = falling_joint(*np.geomspace(0.6, bottom.x, 8))
    assert shorter.response([force]).detached["most"].tolist() == [np.inf]


def test_every_row_holds_the_force():
    """`a |k + i (g + 2 zeta w0 w) - w^2| = f` with the stiffness and the loss between the load
    factors by an interpolation of the test. Below the first one W grows with the cube of the
    amplitude."""
    light = rocking().curve(0, np.geomspace(60, 700, 30))
    forces, ratio = [0.83, 1.2, 1.7], 5e-3
    answer = light.response(forces, damping=ratio, scale=2.5)
    assert answer.oscillator.loss[0] > 0
    a = answer.oscillator.amplitude
    # The states at the peaks join those of the curve.
    assert np.isin(light.displacement, a).all() and len(a) > len(light.displacement)
    nodes = np.append(0.0, a)
    k = PchipInterpolator(
        nodes, answer.oscillator.stiffness[np.maximum(np.arange(len(nodes)) - 1, 0)]
    )
    g = PchipInterpolator(nodes, np.append(0.0, answer.oscillator.loss))
    rows = answer.branches
    amplitude, omega = rows["amplitude"].to_numpy() / 2.5, 2 * np.pi * rows["frequency"].to_numpy()
    viscous = 2 * ratio * 2 * np.pi * light.natural_frequency * omega
    value = k(amplitude) - omega**2 + 1j * (g(amplitude) + viscous)
    assert amplitude * np.abs(value) == pytest.approx(rows["force"].to_numpy(), rel=1e-9)
    assert rows["lag"].to_numpy() == pytest.approx(np.degrees(np.angle(value)), abs=1e-9)
    for force, peak, resonance in zip(forces, answer.peak, answer.resonance, strict=True):
        part = rows[rows["force"] == force]
        top = part["amplitude"].argmax()
        assert part["amplitude"].iloc[top] == pytest.approx(peak, rel=1e-12)
        assert part["frequency"].iloc[top] == pytest.approx(resonance, rel=1e-6)
        assert {"below", "above", "between"} == set(part["branch"])
    plain = light.response(forces, damping=ratio)
    assert answer.peak == pytest.approx(2.5 * plain.peak, rel=1e-12)
    assert light.largest_force(amplitude=2.5 * 0.003, scale=2.5, damping=ratio) == pytest.approx(
        light.largest_force(amplitude=0.003, damping=ratio)
    )


def test_a_fold_lies_between_its_two_jumps(light):
    answer = light.response([0.83], damping=5e-3)
    low, high = sorted(answer.folds["frequency"])
    assert 16.5 < low < 16.7 < 18.6 < high < 18.8
    branches = answer.branches.groupby("branch")["frequency"]
    assert branches.min()["between"] == pytest.approx(low, rel=1e-3)
    assert branches.max()["between"] == pytest.approx(high, rel=1e-3)
    assert branches.min()["above"] == pytest.approx(low, rel=1e-3)
    assert branches.max()["below"] == pytest.approx(high, rel=1e-3)
    doubled = light.response([0.83], damping=5e-3, scale=2.0).branches
    assert np.allclose(doubled["amplitude"], 2 * answer.branches["amplitude"], rtol=1e-12)


def test_the_band_over_residual_slips_encloses_the_curve():
    curve = wedges().curve(2, [300.0, 500.0, 700.0, 900.0], with_range=True)
    extremes = curve.extremes
    assert extremes["extreme"].tolist() == ["least", "most"] * 4
    for name in ("least", "most"):
        rows = extremes[extremes["extreme"] == name]
        assert rows["damping"].to_numpy() == pytest.approx(getattr(curve, f"{name}_damping"))
    answer = curve.response([20.0, 25.0, 500.0], damping=1e-3)
    assert (answer.least_peak <= answer.peak).all() and (answer.peak <= answer.most_peak).all()
    assert answer.most_peak[0] > 1.05 * answer.least_peak[0]
    assert answer.least_peak[2] == answer.most_peak[2] == np.inf
    # The states of least damping have displacements of their own, and the largest peak is theirs.
    rows = extremes[extremes["extreme"] == "least"]
    a, damping, resonance = (
        np.append(0.0, rows[name].to_numpy(dtype=float))
        for name in ("displacement", "damping", "resonance")
    )
    resonance[0] = resonance[1]
    loss = 2 * damping * np.append(0.0, curve.load_factor / a[1:])
    stiffness = PchipInterpolator(a, (2 * np.pi * resonance) ** 2)
    of_friction = PchipInterpolator(a, loss)

    def excess(a):
        viscous = 2e-3 * 2 * np.pi * curve.natural_frequency * np.sqrt(stiffness(a))
        return a * (of_friction(a) + viscous) / 20.0 - 1

    assert answer.most_peak[0] == pytest.approx(brentq(excess, a[1] / 10, a[-1]), rel=1e-4)


def state_of_amplitude(curve, mode, wanted):
    """The steady state at the load factor at which the load swings with an amplitude."""

    def steady(factor):
        return fo.steady_state(curve.system, curve.cycle, curve.friction, factor)

    def excess(factor):
        return np.ptp(steady(factor).loop(mode).displacement) / 2 / wanted - 1

    return steady(brentq(excess, curve.load_factor[0] / 10, curve.load_factor[-1], xtol=1e-6))


def modal_series(b, steady, k, times):
    """Modal coordinates of all modes under x = a cos t, and last the force on mode k.

    (times, n + 1). The coordinates follow from the statics of the whole structure, whose springs are moved by the slips and
    gaps.
    """
    path = steady.states()
    _, shapes = b.modes()
    amplitude = path.amplitudes[:, list(path.system.bonded).index(f"mode {k}")]
    loads = np.outer(amplitude, b.mass * shapes[:, k]) + b.static
    loads += b.tangential * path.slip @ b.along - b.normal * path.gap @ b.against
    q = loads @ np.linalg.inv(b.glued) @ (b.mass[:, None] * shapes)
    x = 2 * (q[:, k] - q[:, k].min()) / np.ptp(q[:, k]) - 1
    top = int(np.argmax(amplitude))
    t = 2 * np.pi * np.arange(times) / times
    series = np.empty((times, len(b.mass) + 1))
    values = np.column_stack([q, amplitude])
    for n, cosine in enumerate(np.cos(t)):
        leg = slice(top, None) if t[n] <= np.pi else slice(0, top + 1)
        order = np.argsort(x[leg], kind="stable")
        series[n] = [np.interp(cosine, x[leg][order], one[leg][order]) for one in values.T]
    return series


def test_the_interaction_is_what_other_modes_answer_at_multiples_of_the_frequency():
    b, k = wedges(), 2
    curve = b.curve(k, [300.0, 600.0, 1000.0])
    others = [f"mode {j}" for j in range(6) if j != k]
    omega, _ = b.modes()
    # The weaker force gives the change of the peak with the force.
    answer = curve.response([19.0, 20.0], damping=1e-3, other_modes=others)
    gain = np.log(answer.peak[1] / answer.peak[0]) / np.log(20 / 19)
    steady = state_of_amplitude(curve, f"mode {k}", answer.peak[1])
    *series, force = modal_series(b, steady, k, 512).T
    t = 2 * np.pi * np.arange(512) / 512

    def harmonic(values, n):
        return 2 * np.mean(values * np.exp(-1j * n * t))

    own = [abs(np.mean(force)), *(abs(harmonic(force, n)) / n**2 for n in range(2, 13))]
    largest = np.linalg.norm(own)
    for j in range(6):
        extra = 0.0
        for n in range(1, 13):
            static = harmonic(series[j], n)
            ratio = n * 2 * np.pi * answer.resonance[1] / omega[j]
            dynamic = static / (1 - ratio**2 + 0.01j * ratio)
            extra += abs(omega[j] ** 2 * (dynamic - static)) ** 2
        if j != k:
            largest = max(largest, np.sqrt(extra))
    expected = gain * largest / steady.load_factor
    assert answer.interaction[1] == pytest.approx(expected, rel=0.02)
    assert "without other_modes" not in answer.note and 0.01 < expected < 0.2
    still = b.curve(k, [1.0, 2.0, 3.0])
    assert still.response([1e-3], damping=0.01, other_modes=["mode 0"]).interaction == 0.0


def test_the_largest_force_keeps_each_limit(light):
    ratio = 5e-3
    for name, measured in (
        ("slip_range", lambda steady: steady.by_contact()["slip_range"].max()),
        ("work", lambda steady: steady.dissipation),
        ("slipping", lambda steady: steady.slipping_share),
    ):
        values = getattr(light, name)
        row = int(np.argmax(values > 0)) + 8 if name != "slipping" else int(np.argmax(values > 0))
        limit = float(values[row]) if name != "slipping" else 0.5 * float(values[row])
        force = light.largest_force(damping=ratio, **{name: limit})
        peak = light.response([force * (1 - 1e-6)], damping=ratio).peak[0]
        below, above = (
            measured(state_of_amplitude(light, "mode 0", peak * part)) for part in (0.98, 1.02)
        )
        assert below <= limit <= above


def test_a_curve_ends_where_its_displacement_turns_back():
    """Strong coupling lets the displacement of a load run back between its corners."""
    root = [[-0.3, -0.6, 0.3, -2.0], [0.6, -0.8, 0.4, 0.5], [3.1, -2.7, -0.9, 2.0]]
    root = np.array([*root, [-1.0, -0.2, -0.3, -0.6]])
    loads = {"P": [0.6, 0.0, 0.5, 0.6], "Q": [-0.5, -0.1, -0.2, 1.8]}
    S = root @ root.T + 0.2 * np.eye(4)
    system = fo.ContactSystem(S, [[0, 0], [1, 0]], loads, compliance=0.1 * np.eye(2))
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    steady = fo.steady_state(system, cycle, 0.7, 1.0)
    moved = steady.loop("Q").displacement
    assert steady.period == 1 and (np.diff(moved) > 1e-3).any() and (np.diff(moved) < -1e-3).any()
    rising = np.diff(moved)[: int(np.argmax(moved))]
    falling = np.diff(moved)[int(np.argmax(moved)) :]
    assert (rising < -1e-4).any() or (falling > 1e-4).any()
    curve = fo.joints.backbone_curve(
        system, cycle, 0.7, [0.02, 0.03, 0.04, 1.0], natural_frequency=np.sqrt(10) / 2 / np.pi
    )
    assert np.isfinite(curve.frequency).all()
    assert np.isfinite(curve.resonance[:3]).all() and np.isnan(curve.resonance[3])
    assert "load factor 1: no resonance, because its displacement turns back" in curve.note
    answer = curve.response([1e-4], damping=0.01)
    assert "the curve is used up to the load factor 0.04" in answer.note
    with pytest.raises(fo.ModelError, match=r"load_factors: 2 of 3 .*turns back"):
        fo.joints.backbone_curve(
            system, cycle, 0.7, [0.02, 0.03, 1.0], natural_frequency=np.sqrt(10) / 2 / np.pi
        ).response([1.0])


def test_a_response_is_kept_shown_and_drawn(light, tmp_path):
    answer = light.response([0.33, 0.83, 6.0], damping=5e-3, scale=2.0)
    answer.save(tmp_path / "response.npz")
    again = fo.results.load(tmp_path / "response.npz")
    assert isinstance(again, fo.results.ForcedResponse)
    pd.testing.assert_frame_equal(again.to_frame(), answer.to_frame())
    pd.testing.assert_frame_equal(again.branches, answer.branches)
    table = answer.to_frame()
    assert table.attrs["note"] == answer.note and "an approximation" in answer.note
    assert list(table)[:4] == ["force", "peak", "resonance", "lag"]
    assert f"{answer.peak[0]:.6g}" in repr(answer) and not hasattr(answer, "proven")
    axes = answer.plot()
    assert axes.get_ylabel() == "amplitude at the point (length)" and axes.get_yscale() == "log"
    lines = axes.get_lines()
    assert {"backbone", "force 0.33", "force 0.83", "force 6"} <= {x.get_label() for x in lines}
    drawn = max(np.nanmax(line.get_ydata(), initial=0.0) for line in lines[1:])
    assert drawn == pytest.approx(answer.peak.max()) and axes.get_ylim()[1] > drawn
    low, high = axes.get_xlim()
    assert low < answer.resonance.min() and light.natural_frequency < high
    one = light.response([0.83], damping=5e-3).plot()
    assert one.get_ylabel() == "modal amplitude" and one.get_yscale() == "linear"
    dotted = [line for line in one.get_lines() if line.get_linestyle() == ":"]
    assert any(np.isfinite(line.get_ydata()).any() for line in dotted)


def test_the_bar_of_a_peak_is_its_band():
    answer = (
        wedges().curve(2, [300.0, 500.0, 800.0], with_range=True).response([20.0], damping=1e-3)
    )
    bars = [line for line in answer.plot().get_lines() if line.get_linewidth() == 4.0]
    assert bars[0].get_ydata().tolist() == [answer.least_peak[0], answer.most_peak[0]]


def test_bad_input(curve, light):
    for odd in ([], [0.0], [-1.0], [np.nan], [np.inf], [[1.0]], "1", None):
        with pytest.raises(fo.ModelError, match=r"^forces"):
            curve.response(odd)
    for odd in (-0.1, 1.0, np.nan, "1"):
        with pytest.raises(fo.ModelError, match=r"^damping"):
            curve.response([1.0], damping=odd)
        with pytest.raises(fo.ModelError, match=r"^damping"):
            curve.largest_force(amplitude=START, damping=odd)
    for odd in (0.0, -1.0, np.inf):
        with pytest.raises(fo.ModelError, match=r"^scale"):
            curve.response([1.0], scale=odd)
        with pytest.raises(fo.ModelError, match=r"^scale"):
            curve.largest_force(amplitude=1.0, scale=odd)
        with pytest.raises(fo.ModelError, match=r"^amplitude"):
            curve.largest_force(amplitude=odd)
    with pytest.raises(fo.ModelError, match=r"amplitude, slip_range, .*: none; give one"):
        curve.largest_force()
    with pytest.raises(fo.ModelError, match=r"work=1\.0.*; give one of the four"):
        curve.largest_force(work=1.0, slipping=0.5)
    with pytest.raises(fo.ModelError, match=r"^work: 1e\+09, and the curve reaches"):
        curve.largest_force(work=1e9)
    for odd, message in (
        (["mode 7"], "other_modes: 'mode 7'"),
        (["mode 0"], "'mode 0' also moves another of the modes"),
        (["static"], "'static' also moves another of the modes"),
        ("mode 1", "other_modes: 'mode 1'"),
    ):
        with pytest.raises(fo.ModelError, match=message):
            light.response([1.0], other_modes=odd)
    plain = replace(curve, natural_frequency=np.nan)
    with pytest.raises(fo.ModelError, match="natural_frequency: not known to the curve"):
        plain.response([1.0])
    falling = replace(curve, displacement=curve.displacement[::-1])
    with pytest.raises(fo.ModelError, match=r"displacement: .* does not rise"):
        falling.response([1.0])
    with pytest.raises(
        fo.ModelError, match="load_factors: 2, and all have a resonance; give at least 3"
    ):
        slider().curve(0, [10.0, 20.0]).largest_force(amplitude=1e-3)


def test_a_curve_over_the_amplitude_at_a_point(light):
    panels = light.plot(scale=3.0)
    assert panels[-1].get_xlabel() == "amplitude at the point (length)"
    for panel, name in zip(panels, ("work", "slipping", "frequency", "damping"), strict=True):
        x, y = panel.get_lines()[0].get_data()
        known = np.isfinite(y)
        assert x == pytest.approx(3.0 * light.displacement)
        assert y[known] == pytest.approx(getattr(light, name)[known])
    resonance = next(x for x in panels[2].get_lines() if "first harmonic" in x.get_label())
    assert resonance.get_ydata() == pytest.approx(light.resonance)
    low, high = panels[0].get_xlim()
    assert low > 3.0 * light.displacement[0] / 2 and high < 3.0 * light.displacement[-1] * 2
    bare = replace(light, displacement=np.full(len(light.load_factor), np.nan))
    with pytest.raises(fo.ModelError, match="scale: 2, and the load of this curve"):
        bare.plot(scale=2.0)
    with pytest.raises(fo.ModelError, match=r"^scale"):
        light.plot(scale=0.0)


def test_a_far_limit_does_not_squeeze_a_curve_and_is_named():
    loads = {"P": [0, 1.0], "X": [1.0, 0]}
    free = fo.ContactSystem(np.zeros((2, 2)), [[0, 0]], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    near = fo.joints.backbone_curve(free, cycle, 0.5, [0.1, 0.45]).plot()
    far = fo.joints.backbone_curve(free, cycle, 0.5, [1e-4, 1e-3]).plot()
    for panels, inside in ((near, True), (far, False)):
        (line,) = (x for x in panels[0].get_lines() if "slide off" in x.get_label())
        low, high = panels[0].get_xlim()
        assert ("0.5" in line.get_label()) and (low < line.get_xdata()[0] < high) == inside
    assert far[0].get_xlim()[1] < 2e-3


def test_the_error_of_increments_is_a_column_and_a_band():
    loads = {"P": [0, 0, 0, 0, 1, 3], "X": [1, 0.3, 0, 0.4, 0, 0]}
    S = np.eye(6) + 0.3 * np.ones((6, 6))
    pair = fo.ContactSystem(S, [[0, 0, 0], [1, 0, 0]], loads, compliance=np.eye(2))
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    curve = fo.joints.backbone_curve(pair, cycle, 0.5, [0.3, 1.0, 1.6], steps=2)
    errors = [steady.step_error for steady in curve.steady_states]
    assert curve.step_error.tolist() == errors == curve.to_frame()["step_error"].tolist()
    assert max(errors) > 0
    work = curve.plot()[0]
    (band,) = work.collections
    ends = band.get_paths()[0].vertices[:, 1]
    assert np.nanmax(ends) == pytest.approx(curve.work[-1] * (1 + errors[-1]))


@pytest.mark.parametrize(
    ("structure", "mode", "factors", "ratio", "force", "error", "shift"),
    [
        (wedges(), 2, (100, 2000), 1e-3, 10.0, 0.05, 0.012),
        (wedges(), 2, (100, 2000), 1e-3, 30.0, 0.05, 0.012),
        (rocking(), 0, (10, 300), 5e-3, 0.33, 0.05, 0.012),
        (rocking(), 0, (10, 300), 5e-3, 0.83, 0.1, 0.025),
    ],
    ids=["wedges, 10", "wedges, 30", "block, 0.33", "block, 0.83"],
)
def test_time_integration_from_rest_meets_the_peak(
    structure, mode, factors, ratio, force, error, shift
):
    """The frequency is swept down from above the resonance, in 60 steps of 80 periods."""
    curve = structure.curve(mode, np.geomspace(*factors, 40))
    answer = curve.response([force], damping=ratio)
    frequencies = np.linspace(1.03 * curve.natural_frequency, 0.97 * answer.resonance[0], 60)
    peak, at = Vibration(structure, mode, ratio, 600).sweep(force, frequencies)
    assert answer.peak[0] == pytest.approx(peak, rel=error)
    assert answer.resonance[0] == pytest.approx(at, rel=shift)
