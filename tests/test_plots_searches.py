"""Pictures of required friction, of safe regions, and of what was tried in a search: what they show is what the result says."""

import itertools

import numpy as np
import pytest
from matplotlib.patches import Polygon

import frictopt as fo
from systems import CYCLE, linprog_limit
from test_plots import FIVE, FOUR_CORNERS, JOINT, PAIR, F, circles, joined, labelled, parts

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

FEW = {"two contacts": (JOINT, FOUR_CORNERS), "pair": (PAIR, CYCLE)}
MEAN = {"mean": 1.0}


def at_corners(contact, cycle, factor, slip):
    """(K, N) reactions at the corners under a slip, from the stiffness matrix."""
    loads = [{name: cycle.mean.get(name, 0) + factor * corner.get(name, 0) for name in {*cycle.mean, *corner}} for corner in cycle.corners]
    q, p = np.array([contact.reaction(load) for load in loads]).swapaxes(0, 1)
    return q + contact.A @ slip, p + contact.B @ slip


@pytest.mark.parametrize(("contact", "cycle"), FEW.values(), ids=FEW)
def test_a_required_friction_shows_the_reactions_on_its_bounds_and_circles_the_mechanism(contact, cycle):
    factor = 0.9 * fo.shakedown_limit(contact, cycle, F).load_factor
    required = fo.required_friction(contact, cycle, factor)
    ax = required.plot()
    q, p = at_corners(contact, cycle, factor, required.slip)
    assert np.allclose(required.reactions, (q, p), rtol=1e-12)
    assert required.system is contact and required.load_factor == factor and 0 < required.required < F
    for corner, (shear, pressure) in enumerate(zip(q, p, strict=True)):
        x, ratio = joined(ax, cycle.corner_names[corner], parts(contact))
        pressed = pressure > 1e-8 * np.abs(p).max()
        assert np.array_equal(x, contact.x) and np.allclose(ratio[pressed], (shear / (required.required * pressure))[pressed], rtol=1e-9)
    drawn, motion = circles(ax), required.mechanism
    expected = sorted(zip(motion["x"], -motion["direction"], 400 * motion["share"], strict=True))
    assert np.allclose(sorted(map(tuple, drawn.round(6))), expected, atol=1e-3) and np.isclose(drawn[:, 2].sum(), 400)
    assert ax.get_title() == rf"$\lambda = {factor:.4g}$: required friction $f$ = {required.required:.5g}"
    assert ax.get_ylabel() == "$q / (f p)$" and ax.get_xlabel().endswith("$x$ (length)")


def sides(ax):
    """Label -> line, of the sides of a polygon."""
    return {name: line for name, line in labelled(ax).items() if name.startswith("side ")}


def test_a_safe_region_is_drawn_to_where_another_program_finds_its_border():
    region = fo.safe_region(FIVE, MEAN, ["cyclic", "other"], F)
    ax = region.plot()
    (inside,) = [patch for patch in ax.patches if isinstance(patch, Polygon)]
    corners = [tuple(point) for point in inside.get_xy()]
    drawn = [point for point in dict.fromkeys(corners) if point != (0.0, 0.0)]
    assert (0.0, 0.0) in corners and inside.get_label() == "some residual slip is safe" and len(drawn) > 2
    for first, second in drawn:
        amplitudes = [{"cyclic": one * first, "other": other * second} for one, other in itertools.product((-1, 1), repeat=2)]
        assert linprog_limit(FIVE, fo.LoadCycle(MEAN, amplitudes), F)[1] == pytest.approx(1.0, rel=1e-7)
    assert np.array_equal(np.transpose(labelled(ax)["vertex, proven safe"].get_data()), drawn)
    assert ax.get_xlabel() == "amplitude of cyclic (times its unit load)" and ax.get_ylabel() == "amplitude of other (times its unit load)"
    assert ax.get_xlim()[0] == ax.get_ylim()[0] == 0 and ax.get_xlim()[1] > drawn[0][0] and ax.get_ylim()[1] > drawn[-1][1]
    assert len(sides(ax)) == len(region.sides) == len(drawn) - 1
    for number, (name, line) in enumerate(sides(ax).items()):
        side, motion = region.sides.loc[number], region.mechanisms[number]
        x, y = line.get_data()
        assert np.allclose(side["a"] * x + side["b"] * y, side["bound"], atol=1e-7) and np.hypot(np.ptp(x), np.ptp(y)) > 0
        most = motion.loc[motion["share"].idxmax()]
        word = "opens" if most["direction"] == 0 else "slips"
        assert name == f"side {number}: node {most['node']:.0f}, $x = {most['x']:.4g}$, {word} most"


def rows(ax):
    """Row of the vertical axis -> values with a mark in it."""
    ax.figure.draw_without_rendering()
    names = {int(tick): text.get_text() for tick, text in zip(ax.get_yticks(), ax.get_yticklabels(), strict=True)}
    marks = [line for line in ax.get_lines() if line.get_marker() != "None"]
    assert len(marks) == len(names) and all(len(set(line.get_ydata())) <= 1 for line in marks)
    return {names[number]: np.asarray(line.get_xdata(), float) for number, line in enumerate(marks)}


def at(ax, label):
    """Place of the vertical line of that name."""
    return next(line.get_xdata()[0] for name, line in labelled(ax).items() if name.startswith(label))


def test_a_practical_limit_shows_what_became_of_the_contact_at_each_load_factor():
    start = fo.guaranteed_limit(PAIR, CYCLE, F).slip
    limit = fo.limit_after_protocol(PAIR, CYCLE, F, start=start, scan=10)
    ax = limit.plot()
    drawn = rows(ax)
    assert list(drawn) == ["comes to rest", "keeps slipping"] and all(len(factors) > 3 for factors in drawn.values())
    for name, factors in drawn.items():
        for factor in factors:
            outcome = fo.steady_state(PAIR, CYCLE, F, factor, initial_slip=start).outcome
            assert (outcome is fo.Outcome.SHAKEDOWN) == (name == "comes to rest")
    assert sum(map(len, drawn.values())) == len(limit.tried)
    assert at(ax, "practical limit") == limit.load_factor == drawn["comes to rest"].max() < drawn["keeps slipping"].min()
    assert at(ax, "shakedown limit") == pytest.approx(linprog_limit(PAIR, CYCLE, F)[1], rel=1e-8)
    assert ax.get_title() == rf"comes to rest up to $\lambda$ = {limit.load_factor:.5g}" and ax.get_xlabel() == r"load factor $\lambda$"
    assert ax.get_xlim()[0] == 0


def test_a_cure_shows_the_shares_tried():
    found = fo.least_excursion(PAIR, CYCLE, F, 0.6, excursion={"mean": -0.95}, samples=2)
    ax = found.plot()
    drawn = rows(ax)
    for name, outcome in (("comes to rest", "rest"), ("keeps slipping", "slip")):
        assert drawn[name].tolist() == found.tried.loc[found.tried["outcome"] == outcome, "share"].tolist() and len(drawn[name])
    assert at(ax, "least found") == found.share and ax.get_xlabel() == "share of the largest excursion"
    assert ax.get_title() == f"least excursion found: {found.share:.4g} of the largest, to mean = {1 - 0.95 * found.share:.4g}"
