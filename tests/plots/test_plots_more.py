"""Pictures of results that follow limits, and of searches.

They show open nodes, ranges, damping, designs, required friction, and safe regions.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.patches import Polygon

import frictopt as fo
from helpers.pictures import FIVE, PAIR, F, joined, labelled
from helpers.systems import CYCLE, PULL, at_corners, linprog_limit

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

PUNCH = fo.scenes.PunchOnHalfPlane(elements=4).condense()
ROUNDED = PUNCH.with_gap(2.0 * PUNCH.x**4)
MEAN = {"mean": 1.0}


def marks(ax, label):
    """(M, 2) places of the marks of a name."""
    places = [
        np.asarray(one.get_offsets(), float)
        for one in ax.collections
        if isinstance(one, PathCollection) and one.get_label() == label
    ]
    return np.concatenate([np.empty((0, 2)), *places])


def test_a_limit_with_open_nodes_shows_the_corners_of_the_path_from_its_state_and_marks_them():
    limit = fo.shakedown_limit(ROUNDED, PULL, F)
    ax = limit.plot()
    # What the state does.
    path = fo.march(ROUNDED, PULL, F, limit.load_factor, initial_state=limit.state, cycles=1)
    rows = [np.flatnonzero(path.time == corner)[-1] for corner in (1, 2)]
    q, p = path.q[rows], path.p[rows]
    for corner, closed in enumerate(path.gap[rows] <= 0):
        x, ratio = joined(ax, PULL.corner_names[corner])
        assert np.array_equal(x, ROUNDED.x) and np.isnan(ratio[~closed]).all()
        assert np.allclose(ratio[closed], q[corner, closed] / (F * p[corner, closed]), atol=1e-9)
    assert ax.get_ylabel() == "$q / (f p)$"
    shear, pressure = limit.reactions
    assert np.allclose(shear, q, atol=1e-9)
    assert np.allclose(pressure, p, atol=1e-9)
    assert not pressure[:, limit.open].any()
    always = (path.gap[rows] > 0).all(axis=0)
    assert always.any() and marks(ax, "open").tolist() == [[x, 0.0] for x in ROUNDED.x[always]]
    assert ax.get_title() == rf"shakedown limit $\lambda_2$ = {limit.load_factor:.5g}"
    assert limit.system is ROUNDED and np.array_equal(limit.friction, np.full(5, F))


def test_a_loop_is_drawn_with_its_area_and_where_nodes_begin_to_slip():
    steady = fo.steady_state(PUNCH, PULL, F, 3 * fo.shakedown_limit(PUNCH, PULL, F).load_factor)
    # The displacement is a work per stress, and a length only after division by the force.
    size = PUNCH.load_size["sigma"]
    loop = replace(steady.loop("sigma"), load_size=np.nan)
    of_known_size = steady.loop("sigma")
    for shown, scale in ((loop, 1.0), (of_known_size, size)):
        ax = shown.plot()
        line, events = ax.get_lines()
        x, y = line.get_xdata(), line.get_ydata()
        assert np.allclose(x * scale, loop.displacement, rtol=1e-12)
        assert (y[1:] + y[:-1]) / 2 @ np.diff(x) == pytest.approx(loop.area, rel=1e-9)
        turns = np.flatnonzero(np.diff(loop.slipping)) + 1
        assert set(x[turns]) == set(events.get_xdata()) and len(turns) >= 2
        assert f"area {loop.area:.4g} (force times length per depth)" == line.get_label()
    assert "(force per length per depth)" in ax.get_title()
    assert ax.get_xlabel() == "mean motion of the load (length)"
    assert f"{loop.stiffness * size**2:.4g}" in ax.get_title()
    assert "(1 / force)" in loop.plot().get_title()
    named = replace(loop, units="N, mm", per_depth=False)
    assert "(1 / N mm)" in named.plot().get_title() and "(N mm)" in named.plot().get_xlabel()
    assert "(N / mm)" in replace(named, load_size=size).plot().get_title()


def test_a_thin_loop_is_drawn_without_the_share_of_its_secant_stiffness():
    """A loop of little damping would be a line."""
    amplitude = np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    for width in (0.01, 0.8):
        displacement = amplitude + width * np.array([-0.5, 0.0, 0.5, 0.0, -0.5])
        loop = fo.results.LoadLoop("push", amplitude, displacement, np.zeros(5, dtype=int))
        ax = loop.plot()
        y = ax.get_lines()[0].get_ydata()
        x = ax.get_lines()[0].get_xdata()
        area = (y[1:] + y[:-1]) / 2 @ np.diff(x)
        assert area == pytest.approx(width, rel=1e-9)
        assert area > 0.19 * np.ptp(x) * np.ptp(y)
        assert ("beyond the secant stiffness" in ax.get_ylabel()) == (width < 0.1)


def test_the_area_of_a_loop_that_does_no_work_is_zero():
    amplitude = np.cos(np.linspace(0.0, 2 * np.pi, 20))
    displacement = 0.3 * amplitude + 1e-16 * np.random.default_rng(5).normal(size=20)
    assert fo.results.LoadLoop("push", amplitude, displacement, np.zeros(20, dtype=int)).area == 0.0


def test_a_backbone_curve_of_two_contacts_has_a_line_for_each_and_ends_where_they_slide_off():
    loads = {"P": [0, 0, 0, 0, 1, 3], "X": [1, 1, 0, 0, 0, 0]}
    free = fo.ContactSystem(
        np.zeros((6, 6)), [[0, 0, 0], [1, 0, 0]], loads, contact=["head", "nut"]
    )
    curve = fo.joints.backbone_curve(
        free, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), [0.5, 0.4], [0.2, 0.4], steps=1
    )
    work, share = curve.plot()
    named = {line.get_label(): line for line in share.get_lines()}
    assert {"head", "nut", "all"} <= set(named) and len(named["nut"].get_xdata()) == 2
    assert (
        [line.get_xdata()[0] for line in work.get_lines() if "slide off" in line.get_label()]
        == [curve.gross_slip]
        == pytest.approx([0.5])
    )


def test_a_design_is_drawn_with_its_profile_and_its_shear_over_the_friction_bound():
    model = fo.DesignModel(PUNCH, PULL, preloads=["Q"], profile=True)
    design = model.solve(F, [model.profile == 0.01 * PUNCH.x**2, model.preload == 0.1])
    ratio, profile = design.plot()
    (drawn,) = [line for line in profile.get_lines() if len(line.get_xdata()) == 5]
    assert np.array_equal(drawn.get_xdata(), PUNCH.x)
    assert np.allclose(drawn.get_ydata(), 0.01 * PUNCH.x**2)
    assert f"{design.load_factor:.5g}" in ratio.get_title() and "Q +0.1" in ratio.get_title()
    q, p = at_corners(design.system, design.cycle, design.load_factor, design.slip)
    assert np.allclose(joined(ratio, PULL.corner_names[1])[1], q[1] / (F * p[1]), atol=1e-8)
    bolts = fo.DesignModel(PUNCH, PULL, preloads=["Q", "P"])
    assert bolts.solve(F, [bolts.preload == 0.1]).plot().get_ylabel() == "$q / (f p)$"
    pad = fo.ContactSystem(
        np.eye(6), [[0, 0, 0], [1, 0, 0]], {"P": [0, 0, 0, 0, 1, 1], "X": [1, 1, 0, 0, 0, 0]}
    )
    solid = fo.DesignModel(pad, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]), preloads=["P"])
    assert "P +0.1" in solid.solve(F, [solid.preload == 0.1]).plot().get_title()


def sides(ax):
    """Label -> line, of the sides of a polygon."""
    return {name: line for name, line in labelled(ax).items() if name.startswith("side ")}


def test_a_safe_region_is_drawn_to_where_another_program_finds_its_border():
    region = fo.safe_region(FIVE, MEAN, ["cyclic", "other"], F)
    ax = region.plot()
    (inside,) = [patch for patch in ax.patches if isinstance(patch, Polygon)]
    corners = [tuple(point) for point in inside.get_xy()]
    drawn = [point for point in dict.fromkeys(corners) if point != (0.0, 0.0)]
    assert (0.0, 0.0) in corners
    assert inside.get_label() == "some residual slip is safe, proven at the vertices"
    assert len(drawn) > 2
    for first, second in drawn:
        amplitudes = [
            {"cyclic": one * first, "other": other * second}
            for one, other in itertools.product((-1, 1), repeat=2)
        ]
        assert linprog_limit(FIVE, fo.LoadCycle(MEAN, amplitudes), F)[1] == pytest.approx(
            1.0, rel=1e-7
        )
    assert ax.get_xlabel() == "amplitude of cyclic (times its unit load)"
    assert ax.get_ylabel() == "amplitude of other (times its unit load)"
    assert ax.get_xlim()[0] == ax.get_ylim()[0] == 0
    assert ax.get_xlim()[1] > drawn[0][0]
    assert ax.get_ylim()[1] > drawn[-1][1]
    assert len(sides(ax)) == len(region.sides) == len(drawn) - 1
    for number, (name, line) in enumerate(sides(ax).items()):
        side, motion = region.sides.loc[number], region.mechanisms[number]
        x, y = line.get_data()
        assert np.allclose(side["a"] * x + side["b"] * y, side["bound"], atol=1e-7)
        assert np.hypot(np.ptp(x), np.ptp(y)) > 0
        most = motion.loc[motion["share"].idxmax()]
        assert name == f"side {number}: node {most['node']:.0f} moves most"


def rows(ax):
    """Row of the vertical axis -> values with a mark in it."""
    ax.figure.draw_without_rendering()
    names = {
        int(tick): text.get_text()
        for tick, text in zip(ax.get_yticks(), ax.get_yticklabels(), strict=True)
    }
    marks = [line for line in ax.get_lines() if line.get_marker() != "None"]
    assert all(len(set(line.get_ydata())) == 1 for line in marks)
    return {names[line.get_ydata()[0]]: np.asarray(line.get_xdata(), float) for line in marks}


def at(ax, label):
    """Place of the vertical line of that name."""
    return next(
        line.get_xdata()[0] for name, line in labelled(ax).items() if name.startswith(label)
    )


def test_a_limit_after_a_protocol_shows_what_became_of_the_contact_at_each_load_factor():
    start = fo.guaranteed_limit(PAIR, CYCLE, F).slip
    limit = fo.limit_after_protocol(fo.shakedown_limit(PAIR, CYCLE, F), start=start, scan=10)
    ax = limit.plot()
    drawn = rows(ax)
    assert set(drawn) == {"comes to rest", "keeps slipping"}
    assert all(len(factors) > 3 for factors in drawn.values())
    for name, factors in drawn.items():
        for factor in factors:
            outcome = fo.steady_state(PAIR, CYCLE, F, factor, initial_slip=start).outcome
            assert (outcome is fo.Outcome.SHAKEDOWN) == (name == "comes to rest")
    assert sum(map(len, drawn.values())) == len(limit.tried)
    assert (
        at(ax, "limit after the protocol")
        == limit.load_factor
        == drawn["comes to rest"].max()
        < drawn["keeps slipping"].min()
    )
    assert at(ax, "shakedown limit") == pytest.approx(linprog_limit(PAIR, CYCLE, F)[1], rel=1e-8)
    assert not ax.get_title()
    assert ax.get_xlabel() == r"load factor $\lambda$"
    assert ax.get_xlim()[0] == 0
