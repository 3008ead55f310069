"""The sheet of a joint: pages, safety factors, verdicts, names of motions, and files.

They are compared with closed forms, and do not change with units.
"""

import json
import re
import sys
from dataclasses import replace
from datetime import UTC, datetime
from hashlib import sha256

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.stats import lognorm, norm, uniform

import frictopt as fo
from frictopt.joints import report_pages, safety
from frictopt.joints import scatter as scattering
from helpers.cases import few
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import flat_body, random_contact
from helpers.systems import BLOCK as BARE_BLOCK
from helpers.systems import CYCLE, FREE, FREE_PAIR, PUSHED_AND_PULLED, random_system, unit_nodes
from studies.validation.moving_events import FRICTION, ROLLS, cylinder

STIFFNESS = 3.0
BLOCK = replace(BARE_BLOCK, width=[2.0])


def jenkins(friction_force, load=1.0):
    """Slip range and work of Jenkins' element."""
    slip = 2 * max(load - friction_force, 0.0) / STIFFNESS
    return slip, 2 * friction_force * slip


def row(table, column, name):
    return table.set_index(column).loc[name]


# Safety factors


def test_against_gross_slip_the_least_friction_and_a_corner_of_the_preloads_are_the_worst():
    """A free block slides off at f P - |side|, a concave function of P and side."""
    cycle = fo.LoadCycle({"P": 1.0, "side": 0.1}, [{"Q": 1.0}, {"Q": -1.0}])
    ranges = {"P": (0.8, 1.1), "side": (-0.15, 0.2)}
    joint = fo.report(FREE, cycle, (0.4, 0.5, 0.6), preload=ranges, pages=2)
    factor = row(joint.safety, "against", "gross slip")
    assert factor["nominal"] == pytest.approx(0.5 * 1.0 - 0.1)
    assert factor["worst"] == pytest.approx(0.4 * 0.8 - 0.2)
    assert factor["at"] == "least friction 0.4, P 0.8, side 0.2"
    assert "by a theorem" in factor["by"]
    assert "friction of 0.4 to 0.6, P of 0.8 to 1.1, side of -0.15 to 0.2" in str(joint).replace(
        "\n", " "
    )


@pytest.mark.parametrize("seed", few(range(6)))
def test_no_input_in_the_ranges_is_worse_against_gross_slip(seed):
    """Random free bodies have three nodes, and random inputs are in the ranges."""
    rng = np.random.default_rng(seed)
    stiff = np.eye(3) - 1 / 3  # rigid along the face
    loads = {name: (rng.normal(size=3) / 3, rng.uniform(0.5, 1.5, 3)) for name in ("P", "B")}
    loads["Q"] = (rng.normal(size=3), 0.2 * rng.normal(size=3))
    body = fo.ContactSystem.from_blocks(stiff, np.zeros((3, 3)), np.zeros((3, 3)), range(3), loads)
    cycle = fo.LoadCycle({"P": 1.0, "B": 0.5}, [{"Q": 1.0}, {"Q": -0.7}])
    ranges = {"P": (0.7, 1.2), "B": (0.2, 0.6)}
    joint = fo.report(body, cycle, (0.3, 0.4, 0.6), [0.01], preload=ranges, pages=2)
    worst = joint.safety["worst"][0]
    assert worst > 0
    for _ in range(8):
        mean = {case: rng.uniform(*ends) for case, ends in ranges.items()}
        inside = fo.gross_slip(body, replace(cycle, mean=mean), rng.uniform(0.3, 0.6))
        assert inside.load_factor >= worst * (1 - 1e-9)


def test_against_slip_the_corners_are_followed():
    """Jenkins' element slips from f N on, by 2 (load - f N) / stiffness."""
    limits = {"slip range": 0.6, "slipping share": 0.5, "work": 1.0}
    joint = fo.report(
        BLOCK, PUSHED_AND_PULLED, (0.4, 0.5, 0.6), preload={"N": (0.9, 1.1)}, limits=limits, pages=2
    )
    beyond = 0.6 * STIFFNESS / 2
    for name, force in (("slip range of 0.6", beyond), ("slipping share of 0.5", 0.0)):
        factor = row(joint.safety, "against", name)
        assert factor["nominal"] == pytest.approx(0.5 + force, rel=1e-4)
        assert factor["worst"] == pytest.approx(0.4 * 0.9 + force, rel=1e-4)
        assert factor["worst"] <= 0.4 * 0.9 + force  # on the safe side
        assert factor["at"] == "least friction 0.4, N 0.9" and "corners" in factor["by"]
    assert joint.safety["nominal"][0] == np.inf and len(joint.safety) == 3


def test_each_corner_has_a_mean_state_of_its_own():
    """The mean load alone makes this contact slip, by a length that depends on friction."""
    contact = random_contact(np.random.default_rng(1), 4)
    cycle = replace(spatial_cycle(), mean={**spatial_cycle().mean, **spatial_cycle().corners[0]})
    scatter = scattering.checked_scatter(contact, cycle, (0.1, 0.3, 0.5), None)
    states = safety.SteadyStates(contact, scatter, 2)
    slips = [states.mean_state(corner).slip for corner in states.all_corners()]
    assert all(np.abs(slips[a] - slips[b]).max() > 1e-6 for a, b in ((0, 1), (0, 2), (1, 2)))


def test_below_the_least_load_factor_nothing_is_safe():
    """The mean load slides the block off, unless Q holds it: 3 - 0.9 load <= f P = 0.5."""
    cycle = fo.LoadCycle({"P": 1.0, "Q": 3.0}, [{"Q": -1.0}, {"Q": -0.9}])
    joint = fo.report(FREE, cycle, 0.5, limits={"gross slip": 1.0}, pages=1)
    assert joint.gross_slip.least == pytest.approx(2.5 / 0.9)
    assert joint.safety["nominal"].tolist() == [0.0] and not joint.verdicts["passed"].any()


def test_a_threshold_that_no_load_reaches_has_an_infinite_factor():
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, limits={"slip range": 20.0}, pages=2)
    assert joint.safety["worst"].tolist() == [np.inf, np.inf]


def test_near_sliding_off_the_search_stops():
    """The block rests, glued, up to f P = 0.5: 95 % of it are tried."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    joint = fo.report(FREE, cycle, 0.5, limits={"slip range": 0.1}, pages=2)
    assert joint.safety["nominal"].tolist() == pytest.approx([0.5, 0.95 * 0.5])


# Verdicts


@pytest.mark.parametrize("above", [True, False])
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("slip range", jenkins(0.5)[0]),
        ("work", jenkins(0.5)[1]),
        ("work density", jenkins(0.5)[1] / 2.0),
        ("Ruiz", 0.5 / 2.0 * jenkins(0.5)[0]),
        ("slipping share", 1.0),
    ],
)
def test_a_verdict_turns_at_the_value(name, value, above):
    threshold = value * (1 + (1e-6 if above else -1e-6))
    if name == "slipping share":
        threshold = min(threshold, 1.0)
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, limits={name: threshold}, pages=1)
    verdict = row(joint.verdicts, "quantity", name)
    assert verdict["value"] == pytest.approx(value) and verdict["passed"] == above
    assert verdict["margin"] == pytest.approx(threshold / value)
    assert ("All of your thresholds are kept." if above else f"Not passed: {name}.") in joint.advice
    assert "node 0 at (0, 0)" in verdict["where"] or name in ("work", "slipping share")


def test_with_scatter_a_verdict_is_the_worst_of_all_corners():
    """Work has its largest value inside the range of friction, where the nominal input is."""
    ranges = {"N": (0.9, 1.1)}
    joint = fo.report(
        BLOCK,
        PUSHED_AND_PULLED,
        (0.4, 0.5, 0.6),
        preload=ranges,
        limits={"work": 1, "slip range": 1},
    )
    forces = [0.5, *(f * N for f in (0.4, 0.6) for N in (0.9, 1.1))]
    slips, works = np.transpose([jenkins(force) for force in forces])
    slip, work = (row(joint.verdicts, "quantity", name) for name in ("slip range", "work"))
    assert slip["value"] == pytest.approx(slips.max()) and slip["at"] == "least friction 0.4, N 0.9"
    assert work["value"] == pytest.approx(works.max()) and work["at"] == "the nominal input"
    assert joint.friction == pytest.approx(0.5) and joint.steady.dissipation == works[0]
    first = fo.report(BLOCK, PUSHED_AND_PULLED, (0.4, 0.5, 0.6), limits={"work": 1}, pages=1)
    assert first.verdicts.empty and "page 2" in first.missing["safety factors and verdicts"]


def test_without_a_steady_state_no_threshold_is_kept():
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    limits = {"slip range": 1.0, "gross slip": 1.0}
    joint = fo.report(FREE, cycle, 0.5, limits=limits, pages=1)
    assert not joint.verdicts["passed"].any() and joint.steady is None
    assert row(joint.verdicts, "quantity", "gross slip")["margin"] == pytest.approx(0.5)
    assert "no steady state" in row(joint.verdicts, "quantity", "slip range")["where"]
    assert next(iter(joint.missing)) == "steady state at load factor 1"


def test_increments_count_against_a_work():
    """A work of 1 with an error of 10 % does not keep a threshold of 1.05."""
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, pages=1)
    states = safety.SteadyStates(BLOCK, _scatter(), None)
    coarse = replace(joint.steady, steps=2, step_error=0.1)
    states.known[safety.NOMINAL, 1.0] = coarse
    work = joint.steady.dissipation
    for factor, passed in ((1.05, False), (1.15, True)):
        limits = {"work": factor * work}
        verdicts = safety.verdict_table(states, joint.safety, limits, {"work": "N mm"})
        assert verdicts["passed"].tolist() == [passed]
        assert verdicts["margin"][0] == pytest.approx(factor / 1.1)


def _scatter():
    return scattering.checked_scatter(BLOCK, PUSHED_AND_PULLED, 0.5)


# Input


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"limits": {"slip": 1.0}}, "'slip' is not a quantity"),
        ({"limits": {"slip range": np.nan}}, "slip range.*nan"),
        ({"limits": {"work": -1.0}}, "work.*at least 0"),
        ({"limits": {"slipping share": 1.5}}, "at most 1"),
        ({"limits": [1.0]}, "limits: a list"),
        ({"friction": (0.6, 0.5, 0.4)}, "must not fall"),
        ({"friction": (0.1, 0.2, np.nan)}, "friction"),
        ({"preload": {"B": (0.9, 1.1)}}, "no such load case"),
        ({"preload": {"N": (1.1, 1.2)}}, "around 1"),
        ({"preload": {"N": (0.9, np.inf)}}, "finite"),
        ({"preload": {"N": 0.9}}, "alpha_A: 0.9.*above 1"),
        ({"preload": {"N": 20e3}}, "alpha_A: 20000.*below 10"),
        ({"preload": {"N": "all"}}, "give a list"),
        ({"load": (1.1, 1.2)}, "load: .*around 1"),
        ({"load": 1.2}, "load: "),
        ({"correlation_length": 1.0}, "correlation_length: 1.0.*no distribution"),
        ({"friction": {"lap": norm(0.3, 0.03)}}, "friction: "),
        ({"preload": dict.fromkeys("abcde", (0.9, 1.1))}, "at most 4"),
        ({"title": 7}, "title: 7"),
        ({"life": 1e6}, "life: 1000000.0; give the table of `FatigueBand.life`"),
        ({"pages": 0}, "pages"),
        ({"pages": 4}, "pages"),
        ({"show": "page"}, "show"),
        ({"mesh_limits": 1.5}, "mesh_limits"),
    ],
)
def test_bad_input_is_refused_by_name(options, message):
    with pytest.raises(fo.ModelError, match=message):
        fo.report(BLOCK, PUSHED_AND_PULLED, **{"friction": 0.5, **options})


def test_tractions_need_a_width():
    bare = replace(BLOCK, width=None)
    with pytest.raises(fo.ModelError, match=r"Ruiz.*width"):
        fo.report(bare, PUSHED_AND_PULLED, 0.5, limits={"Ruiz": 1.0})


# Pages


def test_each_page_is_shown_before_the_next_is_asked():
    """The first page follows one steady state, and the curve does not follow it again."""
    shown, known = [], []
    for page in (1, 2):

        def show(text, page=page):
            if f"Page {page} of 3" in text:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt) as interrupt:
            fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, [0.4, 1.0], show=show)
        known.append(interrupt.value.report)
    assert known[0].curve is known[0].limit is known[1].limit is None
    assert known[1].curve.steady_states[1] is known[1].steady
    fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, [0.4, 1.0], show=shown.append)
    assert [f"Page {page} of 3" in text for page, text in enumerate(shown, 1)] == [True] * 3
    assert "Numbers" in shown[0] and "What grows" in shown[1] and "shakedown limit" in shown[2]


def test_limits_that_belong_to_the_mesh_are_given_if_they_are_asked():
    system = random_system(np.random.default_rng(1), 4).with_gap([10.0, 0.0, 0.0, 0.0])
    joint = fo.report(system, CYCLE, 0.4, [0.5])
    assert joint.mean_state.open.any() and joint.limit is None
    assert "mesh_limits=True" in joint.missing["shakedown limit"]
    assert str(joint).count("mesh_limits=True") == 1  # once for all three
    with_mesh_limits = fo.report(system, CYCLE, 0.4, [0.5], mesh_limits=True)
    assert with_mesh_limits.limit.load_factor == fo.shakedown_limit(system, CYCLE, 0.4).load_factor


def test_a_rolling_contact_has_limits_for_all_openings_and_closings():
    """They do not depend on the nodes that the mean load leaves open."""
    system = cylinder(8, 1.8)
    joint = fo.report(system, ROLLS, FRICTION, [0.1])
    assert joint.mean_state.open.any()
    assert joint.limit.covers == "all states of rest, for all openings and closings"
    assert joint.guaranteed.load_factor == joint.limit.load_factor > 0
    words = " ".join(str(joint).split())
    assert "normal loads alone open and close nodes in each cycle" in words
    assert "change with the mesh" not in words and "mesh_limits" not in words


def test_on_the_first_page_statics_does_not_know_a_press_fit():
    system = fo.scenes.PressFit(elements=6).condense()
    cycle = fo.LoadCycle({"fit": 1.0}, [{"push": 1.0}, {"push": -1.0}])
    joint = fo.report(system, cycle, 0.3, limits={"gross slip": 1.2}, pages=1)
    assert joint.gross_slip.self_stress is not None and joint.gross_slip.load_factor == np.inf
    assert not joint.verdicts["passed"].any() and joint.safety.empty
    assert "balance themselves" in " ".join(str(joint).split())
    assert "Equilibrium alone has no load" in str(joint)
    assert "do not slide off" not in str(joint)


# Motions


SQUARE = flat_body(np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]))


@pytest.mark.parametrize(
    ("load", "motion", "factor"),
    [("push", "slides", 0.4), ("torque", "turns", 0.4 * 2**0.5 / 2), ("moment", "pries", 1.0)],
)
def test_the_motion_has_its_name(load, motion, factor):
    """A force slides at f P, a torque of r^2 = 2 turns at f P r / 2, a moment of x^2 = 1 tips at P."""
    cycle = fo.LoadCycle({"P": 1.0}, [{load: 1.0}, {load: -1.0}])
    joint = fo.report(SQUARE, cycle, 0.4, pages=1)
    assert joint.gross_slip.load_factor == pytest.approx(factor, rel=1e-6)
    assert f"body 1 {motion} at the contact" in " ".join(str(joint).split())


def test_a_body_in_the_plane_pries_where_it_tips():
    """Two nodes under P / 2 each lift off one after the other at the moment 1."""
    body = fo.ContactSystem.from_blocks(
        [[1, -1], [-1, 1]],
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        [0, 1],
        {"P": ([0, 0], [1, 1]), "M": ([0, 0], [1, -1])},
    )
    for load, words in (
        (1.6, "no state of rest exists, bodies pry open"),
        (0.8, "at which bodies pry open"),
    ):
        cycle = fo.LoadCycle({"P": 1.0}, [{"M": load}, {"M": -load}])
        joint = fo.report(body, cycle, 0.3, pages=1)
        assert joint.gross_slip.load_factor == pytest.approx(1 / load)
        advice = " ".join(joint.advice)
        assert words in advice and "raise friction" not in advice


def test_a_ratcheting_contact_tells_its_drift():
    """The drift is the difference of slips of a transient, a cycle apart."""
    pair = replace(FREE_PAIR, units="N, mm")
    cycle = fo.LoadCycle({"P": 1.0, "Q": 0.2}, [{"R": 0.8}, {"R": -0.8}])
    path = fo.march(pair, cycle, 0.3, 1.0, cycles=12)
    ends = [path.slip[np.searchsorted(path.time, 2 * k + 1e-9) - 1] for k in (11, 12)]
    drift = np.abs(ends[1] - ends[0]).max()
    joint = fo.report(pair, cycle, 0.3, limits={"drift": 0.9 * drift}, pages=1)
    assert drift > 0 and joint.steady.drift == pytest.approx(drift)
    assert "drift" in repr(joint.steady) and not joint.verdicts["passed"][0]
    assert any(f"by up to {drift:.3g} mm" in sentence for sentence in joint.advice)
    assert row(joint.numbers, "number", "drift per cycle")["value"] == joint.steady.drift
    assert fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, pages=1).steady.drift == 0


# Words


def test_friction_that_no_surface_has_is_no_advice():
    """A force of 1.48 on a pressure of 1 needs friction of 1.48."""
    for force, text in (
        (0.9, "With friction of 0.9 or more"),
        (1.48, "No practical friction keeps it stuck"),
    ):
        cycle = fo.LoadCycle({"N": 1.0}, [{"F": force}, {"F": -force}])
        joint = fo.report(BLOCK, cycle, 0.5, [1.0])
        assert any(text in sentence for sentence in joint.advice)


@pytest.mark.parametrize("force", [0.39232, 0.87654, 0.0123449])
def test_the_friction_of_the_advice_suffices(force):
    """A force on a pressure of 1 needs this friction; two of the three are above their three digits."""
    cycle = fo.LoadCycle({"N": 1.0}, [{"F": force}, {"F": -force}])
    joint = fo.report(BLOCK, cycle, 0.9 * force, [1.0])
    advice = " ".join(joint.advice)
    advised = float(re.search(r"With friction of ([\d.]+) or more", advice)[1])
    assert force <= advised < 1.01 * force
    assert fo.shakedown_limit(BLOCK, cycle, advised).load_factor >= 1


def test_a_share_has_a_unit_and_an_unknown_error_is_no_percentage():
    cycle = fo.LoadCycle({"N": 1.0}, [{"F": 0.9}, {"F": -0.9}])
    joint = fo.report(BLOCK, cycle, 0.5, [1.0], limits={"slipping share": 0.5}, pages=1)
    share = row(joint.numbers, "number", "share that slips")
    assert share["unit"] == joint.verdicts["unit"].item() == "of the area"
    bare = replace(joint, system=replace(BLOCK, width=None))
    assert row(bare.numbers, "number", "share that slips")["unit"] == "of the nodes"
    for error, text in ((0.26, "may change it by 26 %"), (np.inf, "may have another answer")):
        steady = replace(joint.steady, steps=2, step_error=error)
        meaning = row(replace(joint, steady=steady).numbers, "number", "work per cycle")["meaning"]
        assert text in meaning and "inf" not in meaning


def test_nothing_converges_before_its_increments_are_fine():
    system = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.3}, {"Q": -0.3}])
    joint = fo.report(system, cycle, 0.5, steps=2, pages=1)
    for error, converges in ((0.01, "yes"), (0.1, "with finer increments")):
        coarse = replace(joint, steady=replace(joint.steady, step_error=error))
        assert row(coarse.numbers, "number", "motion of the load")["converges"] == converges
        assert any("repeat with steps=4" in s for s in coarse.advice) == (error > 0.05)


def test_a_reason_has_no_list_of_61_nodes():
    reason = f"at load factor 1 nodes {list(range(61))} (lap) are at their bounds; nodes [1, 2] not"
    assert report_pages.without_lists(reason) == (
        "at load factor 1 61 nodes (lap) are at their bounds; nodes [1, 2] not"
    )
    assert (
        report_pages.without_lists(f"statuses {[0] * 9} or [1, -1]") == "statuses [...] or [1, -1]"
    )


def test_the_text_fits_on_paper():
    """The text fits on paper with names of 40 characters, many corners, notes, and all tables.

    It keeps the advice and the verdicts, and names what the pages have in addition.
    """
    name = "a contact with a name that is 40 wide"
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(6, EA=1.0, h=1.0))
    rod = replace(rod, contact=[f"{name} 1"] * 3 + [f"{name} 2"] * 3, units="kN, mm")
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    limits = {"slip range": 1.0, "slipping share": 0.5, "work": 1.0, "gross slip": 1.2}
    options = {"limits": limits, "notes": "a part that is left out, " * 40, "title": "T " * 99}
    pages = []
    joint = fo.report(rod, cycle, (0.4, 0.5, 0.6), **options, show=pages.append)
    lines = str(joint).splitlines()
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 68 and not any(line.endswith("\\") for line in lines)
    assert all(sentence in " ".join(lines) for sentence in joint.advice)
    rows = [re.findall(rf"^{name} +\d", str(joint), re.MULTILINE) for name in limits]
    assert [len(row) for row in rows] == [1] * len(limits)
    _, _, left = " ".join(lines).partition("On the pages of `save` also: ")
    page_lines = "\n".join(pages).splitlines()
    assert max(map(len, page_lines)) <= 68
    heads = re.findall(r"^([A-Z][a-z ]+):$", "\n".join(pages), re.MULTILINE)
    assert left and all((head.lower() in left) != (f"{head}:" in lines) for head in heads)


# Files


def sheet():
    limits = {"slip range": 0.3, "gross slip": 1.2}
    return fo.report(BLOCK, PUSHED_AND_PULLED, (0.4, 0.5, 0.6), [0.4, 1.0], limits=limits)


def test_json_is_strict(tmp_path):
    def refuse(constant):
        raise AssertionError(constant)

    joint, file = sheet(), tmp_path / "joint.json"
    joint.save(file)
    content = json.loads(file.read_text(encoding="utf-8"), parse_constant=refuse)
    assert content["safety"][0]["nominal"] == "inf" and content["outcome"] == "CYCLIC_SLIP"
    assert [verdict["passed"] for verdict in content["verdicts"]] == [False, True]
    assert content["verdicts"][0]["value"] == joint.verdicts["value"][0]
    assert content["numbers"][1]["value"] == joint.steady.dissipation
    assert len(content["curve"]) == 2 and content["advice"] == joint.advice


def test_a_spreadsheet_has_a_sheet_for_each_table(tmp_path, monkeypatch):
    joint, file = sheet(), tmp_path / "joint.xlsx"
    joint.save(file)
    sheets = pd.read_excel(file, sheet_name=None)
    assert list(sheets) == ["joint", "verdicts", "safety", "numbers", "contacts", "curve"]
    assert sheets["verdicts"]["value"].tolist() == pytest.approx(joint.verdicts["value"].tolist())
    assert "work (N mm per depth)" in sheets["curve"].columns
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(ImportError, match=r"frictopt\[xlsx\]"):
        joint.save(file)


def test_a_page_to_sign_comes_first(tmp_path):
    joint, file = sheet(), tmp_path / "joint.html"
    joint.save(file)
    first, details = file.read_text(encoding="utf-8").split('<div class="details">')
    for text in ("Prepared, date", "Verdicts", "Safety factors", "least friction 0.4", "NO"):
        assert text in first
    assert "<img" not in first and details.count("<img") == 3


def test_a_sheet_names_its_joint_its_version_its_day_and_its_input(tmp_path):
    file = tmp_path / "joint.html"
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, title="Lap 12-345 <B>", pages=1)
    joint.save(file)
    sheet = file.read_text(encoding="utf-8").split('<div class="details">')[0]
    today = datetime.now(UTC).date().isoformat()
    for text in ("Lap 12-345 &lt;B&gt;", fo.__version__, today, joint.origin):
        assert text in sheet
    assert str(joint).startswith("Lap 12-345 <B>: Joint of 1 contact node, friction 0.5")
    assert joint.origin in " ".join(str(joint).split())


def test_a_sheet_of_a_model_has_its_bodies_its_file_and_its_picture(tmp_path):
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    file, deck, archive = (tmp_path / name for name in ("joint.html", "punch.inp", "joint.npz"))
    deck.write_text("*HEADING", encoding="utf-8")
    question = model.condense(), fo.LoadCycle({"P": 1.0}, [{"sigma": 0.1}, {"sigma": -0.1}]), 0.5
    joint = fo.report(*question, model=model, file=deck, pages=1)
    joint.save(file)
    sheet = file.read_text(encoding="utf-8").split('<div class="details">')[0]
    assert sheet.count('<img alt="joint"') == 1 and "largest_element (length)" in sheet
    assert f"File punch.inp, SHA-256 {sha256(b'*HEADING').hexdigest()[:12]}." in sheet
    bodies = joint.bodies.set_index("body")
    assert set(bodies.index) == model.bodies.keys()
    for name, body in model.bodies.items():
        assert bodies.loc[name, "E"] == body.material.E
        assert bodies.loc[name, "nodes"] == body.mesh.p.shape[1]
        assert f"<td>{name}</td>" in sheet
    pushed = fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}])
    pries = fo.report(question[0], pushed, 0.5, model=model, pages=1)
    assert "body punch pries at contact" in " ".join(str(pries).split())
    joint.save(archive)
    again = fo.results.load(archive)
    assert again.model is None and again.bodies.equals(joint.bodies)
    for odd in ({"model": fo.scenes.PunchOnHalfPlane(elements=8).model()}, {"model": "punch"}):
        with pytest.raises(fo.ModelError, match=r"model: .*that made this system"):
            fo.report(*question, **odd)
    with pytest.raises(fo.ModelError, match=r"file: .*cannot be read"):
        fo.report(*question, file=tmp_path / "none.inp")


def test_another_input_has_another_checksum():
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, pages=1)
    assert joint.origin == fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, pages=1).origin
    larger = fo.LoadCycle(PUSHED_AND_PULLED.mean, [{"F": 1.1}, {"F": -1.0}])
    stiffer = replace(BLOCK, S=2 * BLOCK.S)
    for other in ((BLOCK, PUSHED_AND_PULLED, 0.4), (BLOCK, larger, 0.5), (stiffer, larger, 0.5)):
        assert fo.report(*other, pages=1).origin != joint.origin


def test_a_saved_report_is_read_again(tmp_path):
    joint, file = sheet(), tmp_path / "joint.npz"
    joint.save(file)
    again = fo.results.load(file)
    assert str(again) == str(joint) and again.steady.drift == 0.0
    with pytest.raises(fo.ModelError, match="folder"):
        joint.save(tmp_path / "none" / "joint.json")


# Fatigue


# Probability


def test_a_sheet_has_the_shortest_lives_and_more_cycles_are_better():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    steady = fo.steady_state(model.condense(), cycle, 0.7, 1.0)
    band = fo.fatigue_band(model.stress_map(depth=0.3, side=2), cycle, 0.7, 1.0, "Crossland")
    lives = [band.life(k_1, 1e6, 0.3, slip=steady.slip) for k_1 in (5.0, 4.0)]
    one, other = (fo.report(steady.system, cycle, 0.7, life=life, pages=1) for life in lives)
    worst, assembled, best = (
        1e6 * (0.3 / value) ** 5 for value in (band.most, band.at(steady.slip).max(), band.least)
    )
    values = one.numbers.set_index("number")["value"].filter(like="cycles to failure")
    assert values.to_list() == pytest.approx([best, assembled, worst], rel=1e-9)
    assert worst < assembled < best < 1e6
    table = fo.compare({"5": one, "4": other}).table.set_index("number")
    assert table.loc["cycles to failure, worst", "best"] == "4"


def test_the_probability_of_a_block_is_that_of_its_friction(tmp_path):
    """A force of 1 on a pressure of 1 needs friction of 1, from any start."""
    friction = lognorm(0.1, scale=0.97)
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, friction, [1.0], limits={"gross slip": 1.0})
    assert joint.friction == pytest.approx([0.97])
    rows = joint.numbers.set_index("number")
    for name in ("probability for some start", "probability as assembled"):
        assert rows.loc[name, "value"] == pytest.approx(friction.sf(1.0), rel=0.1)
    assert "exact" in rows.loc["probability for some start", "meaning"]
    least, most = friction.ppf([0.025, 0.975])
    assert f"friction of {least:g} to {most:g} in 95 % of all joints (lognorm" in joint.scatter
    assert any(
        "slip stops as assembled with the probability 0.3" in sentence for sentence in joint.advice
    )
    joint.save(tmp_path / "joint.html")
    sheet = (tmp_path / "joint.html").read_text(encoding="utf-8").split('<div class="details">')[0]
    assert "The probability for some start is found: exact" in sheet
    assert fo.report(BLOCK, PUSHED_AND_PULLED, 0.97).probability.empty


# VDI 2230: alpha_A is the most over the least preload, of which the sheet says 95 %.
ALPHA_A = 1.2


@pytest.mark.parametrize("given", [norm(1.0, 0.05), ALPHA_A])
def test_random_preload_and_friction_have_a_probability_by_two_methods(given):
    """A force of 1 is held if friction times pressure is at least 1."""
    friction, preload = lognorm(0.1, scale=1.05), given
    if given is ALPHA_A:
        preload = norm(1.0, (2 * ALPHA_A / (1 + ALPHA_A) - 1) / norm.ppf(0.975))
    exact = quad(lambda p: friction.sf(1 / p) * preload.pdf(p), 0.7, 1.3)[0]
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, friction, [1.0], preload={"N": given})
    for name, value, error, method in joint.probability.itertuples(index=False):
        assert value == pytest.approx(exact, abs=0.03) and "FORM" in method
        assert ("steady states from no slip" in method) == (name == "probability as assembled")
        assert f"standard error {error:.2g}" in method
    assert f"the probability {value:.3g} (standard error" in " ".join(joint.advice)
    least, most = preload.ppf([0.025, 0.975])
    assert f"N of {least:g} to {most:g} in 95 % of all joints (norm, mean 1" in joint.scatter
    assert ("alpha_A = 1.2 of VDI 2230" in joint.scatter) == (given is ALPHA_A)


def two_faces(*names):
    """Two nodes on springs of their own; a face holds the load factor if `f` is at least 0.2 of it.

    The mean load presses them with 2, and the load shears them by 0.4.
    """
    loads = {"P": (np.zeros(2), np.ones(2)), "Q": (np.ones(2), np.zeros(2))}
    system = unit_nodes(loads, contact=names)
    return system, fo.LoadCycle({"P": 2.0}, [{"Q": 0.4}, {"Q": -0.4}])


def test_the_name_of_the_only_contact_has_the_exact_probability():
    law = lognorm(0.2, scale=0.22)
    joint = fo.report(*two_faces("lap", "lap"), {"lap": law}, [1.0])
    assert joint.probability["value"].to_list() == pytest.approx([law.sf(0.2)] * 2, rel=0.05)
    assert joint.probability["error"].to_list() == [0.0, 0.0]


def test_scatter_from_node_to_node_is_that_of_independent_nodes():
    system, cycle = two_faces("head", "lap")
    law = lognorm(0.2, scale=0.22)
    joint = fo.report(system, cycle, law, [1.0], correlation_length=0.0)
    (_, value, _, _), _ = joint.probability.itertuples(index=False)
    exact = law.sf(0.2) ** 2
    assert abs(value - exact) <= 3 * (exact * (1 - exact) / 200) ** 0.5
    assert "correlation length of friction 0" in joint.scatter


def test_the_largest_load_is_the_worst():
    """A load of 1.2 leaves factors that are smaller by 1.2, and the slip of Jenkins' element."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.4}, {"Q": -0.4}])
    factor = fo.report(FREE, cycle, 0.5, load=(0.9, 1.2), pages=2).safety.loc[0]
    assert factor["worst"] == pytest.approx(0.5 / 0.4 / 1.2) and factor["at"] == "load factor 1.2"
    limits = {"slip range": 1.0}
    joint = fo.report(BLOCK, PUSHED_AND_PULLED, 0.5, load=(0.9, 1.2), limits=limits, pages=2)
    slip = row(joint.verdicts, "quantity", "slip range")
    assert slip["value"] == pytest.approx(jenkins(0.5, 1.2)[0]) and slip["at"] == "load factor 1.2"


def test_in_space_a_sample_of_transients_is_left_to_the_user():
    friction, load = uniform(0.5, 0.4), uniform(0.9, 0.2)
    contact = random_contact(np.random.default_rng(1), 3)
    joint = fo.report(contact, spatial_cycle(), friction, [1.0], load=load)
    assert "assembled=True" in joint.missing["probability as assembled"]
    assert joint.probability["number"].to_list() == ["probability for some start"]


def test_a_probability_without_a_limit_is_missing_with_its_reason():
    """The mean load leaves a node open, so limits change with the mesh."""
    system = random_system(np.random.default_rng(1), 4).with_gap([10.0, 0.0, 0.0, 0.0])
    joint = fo.report(system, CYCLE, uniform(0.3, 0.2), [0.5])
    assert "mesh_limits=True" in joint.missing["probability"] and joint.probability.empty
    first = fo.report(BLOCK, PUSHED_AND_PULLED, uniform(0.3, 0.2), pages=1)
    assert "page 3" in first.missing["probability"]
