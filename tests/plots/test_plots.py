"""Pictures show the values of their results.

They are of one contact and of several contacts. Errors say where there is nothing to show.
"""

# One file because all pictures are read back by the same few functions.

import subprocess
import sys
from functools import cache, partial

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex
from matplotlib.text import Text

import frictopt as fo
from frictopt.fem.supports import nodes_of
from helpers.answers import QUESTIONS, answer
from helpers.pictures import (
    ALL,
    FIVE,
    FOUR_CORNERS,
    PAIR,
    F,
    check_mechanism,
    check_ratio,
    circles,
    joined,
    labelled,
    parts,
)
from helpers.systems import CYCLE, system

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")
FLAT = system(np.eye(2), np.zeros((2, 2)), 0.0, [1.0, 2.0], 1.0, 0.0)
MANY = fo.LoadCycle(
    {"mean": 1.0}, [{"cyclic": np.cos(t), "other": np.sin(t)} for t in np.linspace(0, 6, 20)]
)
SCENES = {
    "punch": fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0),
    "dovetail": fo.scenes.Dovetail(elements=4, growth=2.0),
    "pin": fo.scenes.PinInPlate(),
    "press fit": fo.scenes.PressFit(elements=4, growth=2.0),
    "rounded": fo.scenes.RoundedPunch(
        punch=fo.scenes.PunchOnHalfPlane(elements=8, grading=1.0, growth=2.0)
    ),
}


@ALL
def test_onset_shows_the_bonded_contact_at_the_first_slip_and_circles_the_node(contact, cycle):
    first = fo.onset(contact, cycle, F)
    ax = first.plot()
    rows = [event for event in first.slips if event.node is not None]
    reactions = [
        contact.reaction(
            {
                **cycle.mean,
                **{n: event.load_factor * a for n, a in cycle.corners[event.corner].items()},
            }
        )
        for event in rows
    ]
    names = [
        rf"{cycle.corner_names[event.corner]}, $\lambda = {event.load_factor:.4g}$"
        for event in rows
    ]
    check_ratio(ax, contact, *zip(*reactions, strict=True), names)
    assert ax.get_xlabel().endswith("$x$ (length)")
    assert first.mean_admissible
    assert np.allclose(
        circles(ax)[:, :2], [(contact.x[event.node], -event.sense) for event in rows], atol=1e-12
    )


@ALL
def test_a_shakedown_limit_shows_the_safe_slip_and_circles_the_mechanism(contact, cycle):
    limit = fo.shakedown_limit(contact, cycle, F)
    ax = limit.plot()
    q, p = limit.reactions
    check_ratio(ax, contact, q, p, cycle.corner_names)
    mean = contact.reaction(cycle.mean)[0]
    swing = contact.reaction(cycle.corners[-1])[0]
    assert np.allclose(q[-1], mean + limit.load_factor * swing + contact.A @ limit.slip)
    check_mechanism(ax, limit.mechanism)
    assert f"{limit.load_factor:.5g}" in ax.get_title()
    assert limit.system is contact
    assert np.allclose(limit.friction, F)


def test_a_guaranteed_limit_circles_the_node_on_both_its_bounds():
    limit = fo.guaranteed_limit(PAIR, CYCLE, F)
    ax = limit.plot()
    check_ratio(ax, PAIR, *limit.reactions, CYCLE.corner_names)
    assert limit.node == 0
    assert sorted(map(tuple, circles(ax)[:, :2].round(9))) == [(0.0, -1.0), (0.0, 1.0)]
    # The circle is on the line of its colour.
    for line in (labelled(ax)[name] for name in CYCLE.corner_names):
        (marks,) = [
            one
            for one in ax.collections
            if to_hex(one.get_edgecolor()[0]) == line.get_color().lower()
        ]
        assert np.allclose(marks.get_offsets(), [(line.get_xdata()[0], line.get_ydata()[0])])
    assert f"{limit.load_factor:.5g}" in ax.get_title()
    assert f"{limit.shakedown.load_factor:.5g}" in ax.get_title()
    alone = fo.guaranteed_limit(system(1.0, 0.0, 0.0, 1.0, 0.5, 0.0), CYCLE, F)
    assert alone.node is None and not len(circles(alone.plot()))


@ALL
@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_safe_slip_shows_its_reactions_and_its_margin(contact, cycle, share):
    lam = share * fo.shakedown_limit(contact, cycle, F).load_factor
    safe = fo.safe_slip(contact, cycle, F, lam)
    upper = safe.plot()
    q, p = safe.reactions
    check_ratio(upper, contact, q, p, cycle.corner_names)
    assert np.isclose(
        (F * p - np.abs(q)).min() / (F * contact.bonded["mean"][1]).mean(), safe.margin, atol=1e-8
    )
    assert upper.get_xlabel().endswith("$x$ (length)")
    assert f"margin of the slip = {safe.margin:.5g}" in upper.get_title()
    assert (safe.margin > 0) is (share < 1)


SLIDING = fo.ContactSystem.from_blocks(
    A=np.zeros((2, 2)),
    B=np.zeros((2, 2)),
    C=[[1, -1], [-1, 1]],
    x=[0, 1],
    bonded={"mean": ([2, 2], [1, 1]), "cyclic": ([1, 1], [0, 0])},
)
PULLED = system(1.0, 0.0, 0.0, 1.0, 0.5, -1.0)
CENTRED = system(1.0, 0.0, 0.5, 1.0, 0.0, 0.1)
NODE = fo.ContactSystem(np.eye(3), [[0.0, 0.0, 0.0]], {"mean": [0.0, 0.0, 1.0]})
PRESSING, UP, DOWN = (
    fo.LoadCycle({"mean": sign}, [{name: 1.0}])
    for sign, name in ((1.0, "mean"), (1.0, "cyclic"), (-1.0, "cyclic"))
)
IDLE = FIVE.with_bonded({"none": np.zeros((2, 5))})
NOTHING = {  # answer, what the title says
    "unbounded": (lambda: fo.shakedown_limit(PAIR, PRESSING, F), "infinite"),
    "unbounded, in space": (lambda: fo.shakedown_limit(NODE, PRESSING, F), "infinite"),
    "unsafe": (lambda: fo.shakedown_limit(SLIDING, DOWN, F), "none"),
    "unsafe, guaranteed": (lambda: fo.guaranteed_limit(SLIDING, DOWN, F), "none"),
    "no friction is enough": (
        lambda: fo.required_friction(PULLED, UP, 2.0),
        "required friction $f$ is infinite",
    ),
    "no friction is needed": (
        lambda: fo.required_friction(CENTRED, UP, 1.0),
        "required friction $f$ = 0",
    ),
    "no amplitudes": (lambda: fo.safe_region(FIVE, {"mean": -1.0}, ["cyclic", "other"], F), ""),
    "all amplitudes": (
        lambda: fo.safe_region(IDLE, {"mean": 1.0}, ["none", [{"mean": 1.0}]], F),
        "",
    ),
}


@pytest.mark.parametrize("name", NOTHING)
def test_an_answer_without_a_border_says_why_in_place_of_lines(name):
    ask, title = NOTHING[name]
    answer = ask()
    ax = answer.plot()
    assert not ax.get_lines() and not ax.collections and not ax.patches and title in ax.get_title()
    assert " ".join(ax.texts[0].get_text().split()) == answer.reason
    assert title or answer.reason.startswith(name)
    reactions = getattr(answer, "reactions", [np.nan])
    assert all(np.isnan(part).all() == (name != "no friction is needed") for part in reactions)


def test_the_picture_of_a_bonded_contact_says_that_the_mean_load_alone_slips():
    first = fo.onset(system(1.0, 0.0, 1.0, 1.0, 0.5, 0.0), CYCLE, F)
    ax = first.plot()
    assert not first.mean_admissible and "the mean load makes it slip" in ax.get_title()
    assert np.allclose(circles(ax)[:, 1], 1 / F)  # at the bonded reactions, outside the bounds


def test_of_many_corners_the_ruling_ones_have_lines_and_all_a_band():
    limit = fo.shakedown_limit(FIVE, MANY, F)
    ax = limit.plot()
    q, p = limit.reactions
    ratio = q / (F * p)
    (band,) = [one for one in ax.collections if not isinstance(one, PathCollection)]
    assert band.get_label() == "all 20 corners"
    ends = band.get_paths()[0].vertices[:, 1]
    assert np.isclose(ends.max(), np.nanmax(ratio)) and np.isclose(ends.min(), np.nanmin(ratio))
    shares = limit.mechanism.groupby("corner")["share"].sum().nlargest(4)
    drawn = {MANY.corner_names.index(name) for name in labelled(ax) if name in MANY.corner_names}
    assert drawn == set(shares.index) and 0 < len(drawn) <= 4
    assert set(map(tuple, circles(ax)[:, :1].round(9))) == {
        (x,) for x in limit.mechanism.loc[limit.mechanism["corner"].isin(drawn), "x"]
    }


@ALL
def test_a_steady_state_shows_slip_range_traction_and_work(contact, cycle):
    steady = fo.steady_state(
        contact, cycle, F, 1.5 * fo.shakedown_limit(contact, cycle, F).load_factor
    )
    slip, force, work = steady.plot()
    width = np.ones(contact.nodes) if contact.width is None else contact.width
    # Another way to the steady cycle.
    path = fo.march(contact, cycle, F, steady.load_factor, initial_slip=None, cycles=200)
    last = path.time >= 199 * len(cycle.corners)
    closed = path.gap[last] <= 0
    most, least = (np.where(closed, path.slip[last], outside).T for outside in (-np.inf, np.inf))
    # A node that stays open does not slip.
    slid = [max(high.max() - low.min(), 0) for high, low in zip(most, least, strict=True)]
    drawn = [
        np.concatenate([line.get_ydata() for line in ax.get_lines() if line.get_marker() == "."])
        for ax in (slip, work)
    ]
    assert np.allclose(drawn[0], slid, atol=1e-7)
    assert (drawn[0].max() > 0.01) == (len(cycle.corners) > 1)
    assert np.array_equal(drawn[1], steady.dissipation_per_node)
    for corner in range(len(cycle.corners)):
        state = np.flatnonzero(path.time <= 199 * len(cycle.corners) + corner + 1)[-1]
        for name, reaction in (("q", path.q[state]), ("p", path.p[state])):
            assert np.allclose(
                joined(force, f"${name}$, {cycle.corner_names[corner]}", parts(contact))[1],
                reaction / width,
                atol=1e-7,
            )
    assert force.get_ylabel().startswith("nodal force" if contact.width is None else "traction")
    assert slip.get_ylabel() == "slip range (length)"
    assert work.get_ylabel().endswith("(force times length per depth)")
    assert work.get_xlabel().endswith("(length)")
    assert (
        slip.get_title()
        == f"{steady.outcome.name.lower().replace('_', ' ')}, $W$ = {steady.dissipation:.4g} "
        "(force times length per depth) per cycle"
    )


@ALL
def test_a_trajectory_shows_the_loops_of_the_nodes_with_the_most_work(contact, cycle):
    path = fo.march(
        contact, cycle, F, 1.5 * fo.shakedown_limit(contact, cycle, F).load_factor, cycles=2
    )
    upper, lower = path.plot()
    most = sorted(range(contact.nodes), key=lambda node: -path.work[-1, node])[:3]
    for number, node in enumerate(most):
        of_several = "" if contact.contact is None else f" ({contact.contact[node]})"
        line = labelled(upper)[f"node {node}{of_several}, $x = {contact.x[node]:.4g}$"]
        assert np.array_equal(line.get_xdata(), path.slip[:, node])
        assert np.array_equal(line.get_ydata(), path.q[:, node])
        assert np.array_equal(lower.get_lines()[number].get_ydata(), path.slip[:, node])
        assert np.array_equal(lower.get_lines()[number].get_xdata(), path.time)
    assert upper.get_xlabel() == lower.get_ylabel() == "slip $v$ (length)"
    assert upper.get_ylabel() == "shear force $q$ (force per depth)"


def study():
    starts = fo.starts.no_slip() + fo.starts.overloads([1.5]) + fo.starts.given_slips([[0.3, -0.2]])
    return fo.dissipation_study(
        PAIR, CYCLE, F, [0.3, 0.6, 1.5], starts, limits=True, progress=False
    )


def test_a_study_has_a_mark_for_each_run():
    table = study()
    ax = fo.plot_study(table)
    slips = table["dissipation"] > 0
    assert slips.any() and not slips.all()
    for family, rows in table.groupby("family"):
        name = {"none": "no slip"}.get(family, family)
        x, y = (np.asarray(data) for data in labelled(ax)[name].get_data())
        assert np.array_equal(x, rows["load_ratio"])
        assert np.array_equal(y, rows["dissipation"])
    assert "force times length per depth" in ax.get_ylabel()
    assert ax.get_ylim()[0] == 0 and not ax.get_title()


def test_a_study_without_a_limit_has_the_load_factor_below_and_failed_runs_are_counted():
    table = study().assign(load_ratio=np.nan)
    table.loc[0, "outcome"] = "FAILED"
    ax = fo.plot_study(table)
    assert ax.get_xlabel() == r"load factor $\lambda$" and ax.get_title() == "1 of 9 runs failed"
    assert sum(len(line.get_xdata()) for line in labelled(ax).values()) == 8
    table.loc[1:2, "outcome"] = "SLIDES_OFF"
    ax = fo.plot_study(table)
    assert ax.get_title() == "2 of 9 runs slide off, 1 of 9 runs failed"
    assert sum(len(line.get_xdata()) for line in labelled(ax).values()) == 6


def test_a_study_of_one_load_factor_has_the_friction_below():
    table = fo.dissipation_study(PAIR, CYCLE, [0.3, F, 0.7], [1.5], progress=False)
    ax = fo.plot_study(table)
    assert ax.get_xlabel() == "friction"
    assert labelled(ax)["no slip"].get_xdata().tolist() == [0.3, F, 0.7]
    assert fo.plot_study(table, x="load_factor").get_xlabel() == r"load factor $\lambda$"


def split_study():
    cycles = {
        "quick": CYCLE,
        "slow": fo.LoadCycle({"mean": 1.0}, [{"cyclic": -0.4}, {"cyclic": 1.0}]),
    }
    return fo.dissipation_study(PAIR, cycles, np.c_[[F, 0.7]], [0.6, 1.5, 2.5], progress=False)


def test_columns_split_a_study_into_colours_and_places():
    table = split_study()
    table["bolts"] = table["cycle"].map({"quick": 2, "slow": 4})
    panels = [
        fo.plot_study(rows, x="cycle", colour="load_factor")
        for _, rows in table.groupby("friction_number")
    ]
    assert panels[-1].get_xlabel() == "load cycle"
    assert [text.get_text() for text in panels[-1].get_xticklabels()] == ["quick", "slow"]
    drawn = [
        [line for line in ax.get_lines() if line.get_marker() == "o" and len(line.get_xdata())]
        for ax in panels
    ]
    for lines, (_, rows) in zip(drawn, table.groupby("friction_number"), strict=True):
        assert len(lines) == 3
        for line, (_, some) in zip(lines, rows.groupby("load_factor", sort=False), strict=True):
            assert line.get_xdata().tolist() == some["cycle"].tolist()
            assert np.array_equal(line.get_ydata(), some["dissipation"])
    colours = [[line.get_color() for line in lines] for lines in drawn]
    assert colours[0] == colours[1] and len(set(colours[0])) == 3
    named = [text.get_text() for text in panels[0].get_legend().get_texts()]
    assert named == ["no slip", "0.6", "1.5", "2.5"]
    assert "load factor" in panels[0].get_legend().get_title().get_text()
    by_bolts = fo.plot_study(table, x="bolts")
    assert by_bolts.get_xlabel() == "bolts"
    assert set(
        np.concatenate(
            [line.get_xdata() for line in by_bolts.get_lines() if line.get_mfc() == "none"]
        )
    ) == {2, 4}
    assert [
        text.get_text()
        for text in fo.plot_study(table[table["friction"] == 0.7]).get_legend().get_texts()
    ] == ["no slip", "quick", "slow"]
    for name in ("x", "colour"):
        with pytest.raises(fo.ModelError, match=f"{name}: 'bolt'; give 'friction'"):
            fo.plot_study(table, **{name: "bolt"})
    with pytest.raises(fo.ModelError, match="give one matplotlib axes"):
        fo.plot_study(table, plt.figure().subplots(2))


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_shows_bodies_contacts_supports_and_loads(name):
    scene = SCENES[name]
    ax = scene.plot()
    model = scene.model()
    named = labelled(ax)
    for body, mesh in ((body, model.bodies[body].mesh) for body in model.bodies):
        outline = np.array(named[body].get_data())
        seen = outline[:, ~np.isnan(outline[0])].T
        assert {tuple(point) for point in seen} == {
            tuple(point) for point in mesh.p[:, np.unique(mesh.facets[:, mesh.boundary_facets()])].T
        }
    face = model.contacts[0]
    several = len(model.contacts) > 1
    contact = np.array(named[f"1: {face.name}" if several else "contact"].get_data())
    mesh = model.bodies[face.body_1].mesh
    assert np.count_nonzero(np.isnan(contact[0])) == len(mesh.boundaries[face.boundary_1])
    held = np.concatenate(
        [
            np.array(line.get_data()).T
            for line in ax.get_lines()
            if line.get_marker() in ("s", ">", "^") and len(line.get_xdata())
        ]
    )
    nodes = [
        model.bodies[support.body]
        .mesh.p[:, nodes_of(model.bodies[support.body], support.body, support.where)]
        .T
        for support in model.supports
    ]
    assert {tuple(point) for point in held} <= {tuple(point) for point in np.concatenate(nodes)}
    assert {label.split()[1] for label in named if label.startswith("load ")} == set(model.loads)
    assert ax.get_aspect() == 1
    assert ax.get_xlabel() == "$x$ (length)"
    assert ax.get_ylabel() == "$y$ (length)"
    numbers = [f"{number}" for number, _ in enumerate(model.contacts, start=1)]
    assert [text.get_text() for text in ax.texts] == (numbers if several else [])
    names = {f"{number}: {contact.name}" for number, contact in enumerate(model.contacts, start=1)}
    assert names <= set(named) or not several


def test_fields_show_the_von_mises_stress_of_all_bodies():
    model = SCENES["punch"].model()
    ax = model.recover({"P": 1.0}, slip=np.zeros(5)).plot()
    fields = model.recover({"P": 1.0}, slip=np.zeros(5))
    drawn = [one for one in ax.collections if one.get_array() is not None]
    assert len(drawn) == 2
    for body, colours in zip(("punch", "block"), drawn, strict=True):
        xx, yy, xy, zz = fields.stress[body]
        deviator = (
            np.array([[xx, xy, 0 * xx], [xy, yy, 0 * xx], [0 * xx, 0 * xx, zz]])
            - np.eye(3)[:, :, None] * (xx + yy + zz) / 3
        )
        assert np.allclose(
            colours.get_array(), np.sqrt(1.5 * (deviator**2).sum(axis=(0, 1))), rtol=1e-12
        )
        corners = model.bodies[body].mesh.p.T[
            np.unique(np.sort(colours._triangulation.triangles, axis=1), axis=0)
        ]
        sides = np.ptp(model.bodies[body].mesh.p, axis=1)
        assert np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 2 == pytest.approx(
            sides.prod()
        ), "triangles fill the body"
    (bar,) = [one for one in ax.figure.axes if one is not ax]
    assert bar.get_ylabel() == "von Mises stress (force per area)"
    assert ax.get_xlabel() == "$x$ (length)"


DRAWN = {
    **{kind: partial(answer, kind) for kind in QUESTIONS},
    "Onset of five": lambda: fo.onset(FIVE, FOUR_CORNERS, F),
    "SteadyState of five": lambda: fo.steady_state(FIVE, FOUR_CORNERS, F, 0.5),
    "ShakedownLimit of five": lambda: fo.shakedown_limit(FIVE, FOUR_CORNERS, F),
    "WornIn": lambda: fo.joints.worn_in(FLAT, CYCLE, F, 0.8),
    "scene": lambda: SCENES["punch"],
    "BodyFields": lambda: SCENES["punch"].model().recover({"P": 1.0}, slip=np.zeros(5)),
}
for kind in (
    "OnsetEvent",
    "LeastSlip",
    "Increment",
    "ContactState",
    "Verdict",
    "ShakedownProbability",
):
    del DRAWN[kind]  # which have no picture


@cache
def drawn(name):
    """The result of this name, made when a test first asks for it."""
    return DRAWN[name]()


@pytest.mark.parametrize("name", DRAWN)
def test_pictures_are_drawn_in_given_axes_and_other_numbers_of_axes_are_refused(name):
    result = drawn(name)
    panels = np.size(result.plot())
    plt.close("all")
    axes = plt.subplots(panels)[1]
    returned = result.plot(axes)
    assert list(np.ravel(returned)) == list(np.ravel(axes))
    assert all(ax.get_xlim() != (0, 1) for ax in np.ravel(axes)[-1:])
    assert len(plt.get_fignums()) == 1
    for wrong in (plt.subplots(panels + 1)[1], 5, [None] * panels, "axes"):
        with pytest.raises(fo.ModelError, match=r"^ax: "):
            result.plot(wrong)


@pytest.mark.parametrize("name", DRAWN)
def test_letters_of_a_new_picture_are_those_of_the_figures_and_large_enough(name):
    figure = np.ravel(drawn(name).plot())[0].figure
    figure.draw_without_rendering()  # outside the context, as a user's savefig
    texts = [text for text in figure.findobj(Text) if text.get_text().strip()]
    assert {text.get_fontfamily()[0] for text in texts} == {"STIXGeneral"}
    assert min(text.get_fontsize() for text in texts) > 9
    assert plt.rcParams["font.size"] == plt.rcParamsDefault["font.size"]
    width, height = figure.get_size_inches() * figure.dpi
    for ax in figure.axes:
        box = ax.get_tightbbox()
        assert box.x0 > -1 and box.y0 > -1 and box.x1 < width + 1 and box.y1 < height + 1, (
            "all letters are in the picture"
        )


def test_without_matplotlib_a_plot_says_how_to_get_it_and_all_else_works():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from frictopt import *\n"
        "import frictopt as fo\n"
        "node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {'P': ([0.0], [1.0]), 'Q': ([1.0], [0.0])})\n"
        "first = fo.onset(node, fo.LoadCycle({'P': 1.0}, [{'Q': 2.0}]), friction=0.5)\n"
        "try:\n    first.plot()\nexcept ImportError as error:\n    print(error)\n"
    )
    output = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout
    assert output == "plots need matplotlib: python -m pip install 'frictopt[figures]'\n"
