"""The report on a joint.

Its numbers are compared with closed forms and with the calls that it summarises; other tests check
what it leaves out, and the file that it writes.
"""

import io
import re
from contextlib import redirect_stderr
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.screens import soon, until
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import random_contact
from helpers.systems import (
    BLOCK,
    CYCLE,
    FREE,
    FREE_PAIR,
    PUSHED_AND_PULLED,
    random_system,
    unit_nodes,
)


def value(report, number):
    return report.numbers.set_index("number").loc[number, "value"]


def test_a_block_on_a_spring():
    """A block on a spring is Jenkins' element.

    The load factor shears a spring of 3 that slides at f N = .5.
    """
    report = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, [0.4, 1.0])
    assert value(report, "gross-slip load") == np.inf
    assert "supports hold the bodies" in report.gross_slip.reason
    assert (
        value(report, "shakedown limit") == pytest.approx(0.5) == value(report, "guaranteed limit")
    )
    assert value(report, "required friction") == pytest.approx(1.0, rel=1e-5)
    assert value(report, "work per cycle") == pytest.approx(4 * 0.5 * (1.0 - 0.5) / 3)
    assert value(report, "largest slip range") == pytest.approx(2 * (1.0 - 0.5) / 3)
    assert value(report, "share that slips") == 1.0
    assert report.curve.work == pytest.approx([0.0, 1 / 3]) and not report.missing
    assert "All nodes are closed under the mean load, and in each cycle" in report.kind
    assert any("With friction of 1 or more" in sentence for sentence in report.advice)
    assert re.search("work per cycle +0.3333 +N mm per depth\n", str(report))
    assert "if more nodes slip; here 1 slip" in report.numbers["converges"].tolist()
    assert repr(report).startswith("Report(nodes=1, ")
    assert len(str(report).splitlines()) <= 40


def test_a_free_block_slides_off_and_the_curve_ends_before():
    report = fo.report(FREE, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5)
    assert value(report, "gross-slip load") == pytest.approx(0.5)
    assert report.steady is None
    assert report.contacts["slides_at"].tolist() == pytest.approx([0.5])
    assert "no state of rest exists" in report.gross_slip.reason
    assert "no state of rest exists" in report.advice[0]
    assert report.curve.load_factor[-1] == pytest.approx(0.95 * 0.5) and not report.curve.work.any()


@pytest.mark.parametrize("seed", few(range(6)))
def test_the_limit_as_assembled_lies_between_rest_and_slip(seed):
    """Steady states from no slip confirm both ends of its interval, in at most eight transients."""
    contact = random_system(np.random.default_rng(seed), 4)
    report = fo.report(contact, CYCLE, 0.4, [1.0])
    assembled = report.assembled
    assert assembled.transients <= 8 and assembled.load_factor <= report.limit.load_factor
    assert assembled.load_factor >= report.guaranteed.load_factor * (1 - 1e-9)
    rests = fo.steady_state(contact, CYCLE, 0.4, 0.999 * assembled.load_factor)
    assert rests.outcome is fo.Outcome.SHAKEDOWN
    if np.isfinite(assembled.upper):
        width = assembled.upper - assembled.load_factor
        assert width <= report.limit.load_factor / 64 * (1 + 1e-9)
        slips = fo.steady_state(contact, CYCLE, 0.4, 1.001 * assembled.upper)
        assert slips.outcome is not fo.Outcome.SHAKEDOWN
    assert value(report, "limit as assembled") == assembled.load_factor
    assert f"it stops up to load factor {assembled.load_factor:.3g}" in " ".join(report.advice)
    friction = report.required_assembled
    assert friction.transients <= 8 and value(report, "friction as assembled") == friction.required
    for coefficient in (friction.required, friction.lower):
        ends = fo.steady_state(contact, CYCLE, coefficient, 1.0).outcome
        assert (ends is fo.Outcome.SHAKEDOWN) == (coefficient == friction.required)


def test_where_nodes_are_open_in_space_no_search_is_made_and_limits_belong_to_the_mesh():
    rng = np.random.default_rng(3)
    contact = random_contact(rng, 5).with_gap(np.r_[10.0, 0, 0, 0, 0])
    report = fo.report(contact, spatial_cycle(), 0.4, [0.5], mesh_limits=True)
    assert report.mean_state.open.tolist() == [True, *[False] * 4]
    assert report.required is None
    assert report.guaranteed is None
    assert (
        value(report, "shakedown limit with these nodes open")
        == fo.shakedown_limit(
            contact, spatial_cycle(), 0.4, open_nodes=report.mean_state.open
        ).load_factor
    )
    assert "leaves 1 of 5 nodes open" in report.kind
    assert "change with the mesh" in report.kind
    assert "1 of 5 nodes open" in report.limit.reason
    assert (
        report.numbers.set_index("number").loc["shakedown limit with these nodes open", "converges"]
        == "no"
    )
    missing = {"guaranteed limit", "required friction", "friction as assembled"}
    assert missing == set(report.missing)
    assert "Quote" in report.advice[-1]


def test_an_interrupt_keeps_what_is_known():
    def stop(text):
        if page in text:
            raise KeyboardInterrupt

    page = "Page 1"
    with pytest.raises(KeyboardInterrupt) as interrupt:
        fo.report(BLOCK, PUSHED_AND_PULLED, (0.4, 0.5, 0.6), [0.4], show=stop)
    first = interrupt.value.report
    assert first.missing["safety factors and verdicts"] == "interrupted"
    assert "Safety factors:" not in str(first)
    page = "Page 2"
    with pytest.raises(KeyboardInterrupt) as interrupt:
        fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, [0.4], show=stop)
    assert interrupt.value.report.steady.dissipation == pytest.approx(1 / 3)
    assert interrupt.value.report.limit is None
    assert interrupt.value.report.missing["shakedown limit"] == "interrupted"
    assert "`report`" in interrupt.value.__notes__[0]
    assert "interrupted" in str(interrupt.value.report)


def test_loads_have_the_amplitude_that_they_make_at_a_named_point():
    """The glued body moves a point by 0.5 for each F, and slip moves it as the block.

    The unit load of the point is a force of 2.
    """
    loads = {"N": ([0.0], [1.0]), "F": ([-1.0], [0.0]), "tip": ([-2.0], [0.0])}
    compliance = [[0, 0, 0], [0, 1, 1], [0, 1, 4]]
    blocks = [[3.0]], [[0.0]], [[1.0]], [0.0], loads
    block = fo.ContactSystem.from_blocks(*blocks, compliance=compliance)
    block = replace(block, load_size={"tip": 2.0})
    cycle = replace(PUSHED_AND_PULLED, mean={"N": 1.0, "tip": 0.0})
    report = fo.report(block, cycle, 0.5, pages=1)
    motion = value(report, "motion of tip")
    assert motion == pytest.approx(0.5 + (1 - 0.5) / 3)
    text = " ".join(str(report).split())
    assert f"F = -1. They move tip by +-{motion:.4g} length." in text and "tip = 0" not in text
    assert "motion of tip" not in str(fo.report(block, PUSHED_AND_PULLED, 0.5, pages=1))


@pytest.mark.parametrize("limits", [{"work": 1.0}, {"slip range": 0.3}])
def test_progress_counts_the_steady_states_that_a_report_needs(limits):
    """The curve has two load factors, and four corners of the scatter are judged at the second.

    A safety factor needs a search besides.
    """
    log, known = io.StringIO(), []
    last = {"work": "6 of 6", "slip range": r"(\d+) of \1"}[next(iter(limits))]

    def wait(text):
        line = rf"{last} steady states\n"
        if "Page 1" in text:
            line = "1 of 6 steady states" + (" or more" if "slip range" in limits else "") + "\n"
        if "Page 3" not in text:
            known.append(until(log, line))

    ranges = {"friction": (0.4, 0.5, 0.6), "preload": {"N": (0.9, 1.1)}, "limits": limits}
    with soon(), redirect_stderr(log):
        joint = fo.report(BLOCK, PUSHED_AND_PULLED, load_factors=[0.4, 1.0], show=wait, **ranges)
    assert known[1].startswith(f"{len(joint.states)} of {len(joint.states)} ")
    assert (len(joint.states) > 6) == ("slip range" in limits)


def test_the_same_call_goes_on_from_its_store(tmp_path):
    """States and limits that are marked in the store stand in the report of the next call."""
    store = tmp_path / "joint.npz"
    question = {"friction": (0.4, 0.5, 0.6), "load_factors": [0.4, 1.0], "limits": {"work": 1.0}}

    def stop(text):
        if "Page 2" in text:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fo.report(BLOCK, PUSHED_AND_PULLED, **question, store=store, show=stop)
    kept = fo.results.load(store)
    assert len(kept.states) == 4 and kept.limit is None
    marked = {key: replace(state, cycles=99) for key, state in kept.states.items()}
    replace(kept, states=marked).save(store)
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, **question, store=store)
    assert joint.steady.cycles == 99 and len(joint.states) == 4
    assert str(joint.numbers) == str(fo.report(BLOCK, PUSHED_AND_PULLED, **question).numbers)
    # So does the reason why there is no state, which is long to find out, too.
    reasons = {key: "marked" for key in joint.states if key[1] == 1.0}
    replace(joint, states=reasons, required=replace(joint.required, reason="kept")).save(store)
    again = fo.report(BLOCK, PUSHED_AND_PULLED, **question, store=store)
    assert again.required.reason == "kept" and again.assembled is not None
    assert again.missing["steady state at load factor 1"] == "marked"
    assert again.verdicts["where"].to_list() == ["no steady state: marked"]
    for odd in ({"friction": (0.4, 0.5, 0.7)}, {"load": (0.9, 1.1)}, {"steps": 2}):
        with pytest.raises(fo.ModelError, match=r"store: .*no report on this input"):
            fo.report(BLOCK, PUSHED_AND_PULLED, **{**question, **odd}, store=store)
    joint.limit.save(store)
    with pytest.raises(fo.ModelError, match=r"store: .*no report on this input"):
        fo.report(BLOCK, PUSHED_AND_PULLED, **question, store=store)


@pytest.mark.parametrize("factors", [[0.0, 1.0], [1.0, 0.5], [], [np.nan]])
def test_load_factors_that_do_not_rise_are_refused(factors):
    with pytest.raises(fo.ModelError, match="load_factors"):
        fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, factors)


@pytest.mark.parametrize(
    ("mean", "corners", "friction", "sentence"),
    [
        ({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}], 0.0, "no state of rest exists, bodies slide off"),
        ({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}], 0.6, "no state of rest exists, bodies slide off"),
        ({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}], 1.0, "Your load is 100.0%"),
        (
            {"P": 1.0, "Q": 3.0},
            [{"Q": -1.0}, {"Q": -0.9}],
            0.5,
            "below load factor 2.778 the mean load slides",
        ),
        ({"P": 1.0, "Q": 0.2}, [{"R": 0.8}, {"R": -0.8}], 0.3, "It ratchets"),
        ({"P": -1.0}, [{"Q": 1.0}, {"Q": -1.0}], 0.3, "no state of rest exists, bodies lift off"),
    ],
)
def test_advice_where_bodies_are_free(mean, corners, friction, sentence):
    """Two nodes of a body that slides off at load factor friction * P / Q, by hand."""
    report = fo.report(FREE_PAIR, fo.LoadCycle(mean, corners), friction)
    assert sentence in " ".join(report.advice), report.advice
    assert (report.steady is not None) == (friction in (1.0, 0.3) and mean["P"] > 0)


def test_without_friction_nodes_slide_and_no_start_is_warned_of():
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    report = fo.report(node, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.0)
    assert report.advice == [
        "At your load friction does no work; nodes without friction slide to and fro."
    ]


def test_a_mean_load_that_opens_all_nodes_in_space_leaves_a_report():
    one = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1.0], "X": [1, 0, 0]})
    report = fo.report(
        one, fo.LoadCycle({"P": -1.0}, [{"X": 1.0}, {"X": -1.0}]), 0.3, mesh_limits=True
    )
    assert report.limit is None
    assert "closed nodes" in report.missing["shakedown limit"]
    assert report.kind == "The mean load opens all nodes."


def test_all_numbers_of_a_report_have_units():
    """The names are given by the user or not. A displacement that is no length is not called a
    length."""
    system = replace(fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense(), units="N, mm")
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.3}, {"Q": -0.3}])
    shown = []
    joint = fo.report(system, cycle, 0.5, load_factors=[0.5, 1.0], show=shown.append)
    assert (joint.numbers["unit"] != "").all()
    units = {
        "work": "N mm per depth",
        "slip_range": "mm",
        "motion": "mm",
        "slides_at": "load factor",
    }
    lines = "\n".join(shown).splitlines()
    for column, unit in units.items():  # the unit ends below the name
        head = next(
            k
            for k, line in enumerate(lines)
            if line.startswith(("load_factor", "contact ")) and column in line.split()
        )
        end = f"{lines[head]} ".index(f" {column} ") + len(column) + 1
        assert lines[head + 1][:end].endswith(f" {unit}")
    assert not any("displacement" in line for line in lines)
    row = joint.curve.to_frame().iloc[0]
    assert value(joint, "motion of the load") == pytest.approx(joint.curve.motion[-1])
    assert row.motion * system.load_size["Q"] * 0.3 == pytest.approx(row.displacement)
    bare = replace(system, units=None, load_size={})
    assert "motion of the load" not in str(fo.report(bare, cycle, friction=0.5, pages=1))
