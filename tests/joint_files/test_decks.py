"""Decks as joints: bodies, contacts, bolts, couplings and loads, with values by statics."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from helpers.command import main
from helpers.joint_decks import (
    CAP,
    HELD,
    MATERIAL,
    PAIR,
    PRESS,
    carried,
    deck,
    joint_of,
    mesh,
    of_states,
    steps,
)

DATA = Path(__file__).parents[1] / "data"
STEPS = "STEP 1", ["STEP 2", "STEP 3"]
PUSH = "*CLOAD\nNTOP, 1, 8.\n"


def test_a_plane_deck_goes_to_the_sheet(capsys):
    """10 MPa on 20 x 20, five nodes with 120 N, f = 0.2: 4000, 600 and 800 N; slides at 800 / 600.

    CalculiX 2.20: 4000.1 and 599.9 N.
    """
    words = ["--mean", STEPS[0], "--corners", *STEPS[1], "--units", "N, mm"]
    options = ["--pages", "1", "--title", "Punch 7", "--json"]
    assert main(["report", str(DATA / "block.inp"), *words, *options]) == 0
    told = json.loads(capsys.readouterr().out)
    (row,) = told["tables"]["contacts"]
    assert row["contact"] == "SPUNCH-SBLOCK"
    for name, value in {"P": 4000, "Q": 600, "fP": 800}.items():
        assert [abs(row[f"{name}_{k}"]) for k in (0, 1)] == pytest.approx([value] * 2, rel=1e-6)
    assert told["answer"]["gross-slip_load"] == pytest.approx(4 / 3, rel=1e-6)
    assert told["answer"]["title"] == "Punch 7"
    assert "penalty" in told["answer"]["notes"] and "NLGEOM" in told["answer"]["notes"]


def test_a_bolted_deck_has_its_four_contacts_and_its_tension():
    """8000 N in both friction faces, under the head and under the nut, which are oiled."""
    joint = fo.read_joint(DATA / "bolt.inp")
    assert list(joint.friction.values()) == [0.25, 0.25, 0.0, 0.0]
    assert joint.interactions["OILED"] == ["HEAD-C_HEAD", "NUT-C_NUT"]
    system = joint.system()
    cycle = joint.cycle(*STEPS)
    table = fo.steady_state(system, cycle, joint.friction, 1.0, steps=2).by_contact()
    for k in (0, 1):
        assert table[f"P_{k}"].tolist() == pytest.approx([8000] * 4, rel=0.01)
        assert table[f"Q_{k}"].tolist() == pytest.approx([1200, 1200, 0, 0], abs=0.1)
        assert table[f"fP_{k}"].tolist() == pytest.approx([2000, 2000, 0, 0], rel=0.01)


def test_a_bolt_keeps_its_force_unless_its_length_is_kept(tmp_path):
    """The tongue slides at 2 f F / Q = 2 x 0.25 x 8000 / 2400."""
    text = (DATA / "bolt.inp").read_text()
    joint = joint_of(tmp_path, text.replace("*BOUNDARY, FIXED\n9999, 1, 1\n", ""))
    cycle = joint.cycle(*STEPS)
    assert cycle.mean == {"BOLT SECTION": 1.0} and not joint.system().bolts
    found = fo.gross_slip(joint.system(), cycle, joint.friction)
    assert found.load_factor == pytest.approx(5 / 3, rel=1e-6)
    tightened = text.replace("9999, 1, 8000.", "9999, 1, 8000.\n*BOUNDARY\n9999, 1, 1, .1")
    with pytest.raises(fo.ModelError, match=r"BOUNDARY: tighten a bolt by \*CLOAD"):
        joint_of(tmp_path, tightened)
    # A bolt of a mean load that keeps its length was tightened before, without the pull.
    joint = fo.read_joint(DATA / "bolt.inp")
    means = [joint.cycle(state, ["STEP 3"]).mean for state in ("STEP 1", "STEP 2")]
    assert means[1] == {**means[0], "CLOAD NPULL": 1.0}
    other = text.replace(
        "*STEP\n*STATIC",
        "*STEP\n*STATIC\n1., 1.\n*CLOAD\n9999, 1, 4000.\n*END STEP\n*STEP\n*STATIC",
        1,
    )
    joint = joint_of(tmp_path, other)
    with pytest.raises(fo.ModelError, match="tightens a bolt whose length is kept in"):
        joint.cycle("STEP 2", ["STEP 1"])


def test_what_was_read_is_shown_with_a_next_line_that_runs(capsys, monkeypatch):
    monkeypatch.chdir(DATA)
    assert main(["look", "block.inp"]) == 0
    said = capsys.readouterr().out
    for text in ("BLOCK: E=210000", "SPUNCH-SBLOCK: 9", "STEP 2: DLOAD ETOP P3=1", "NLGEOM"):
        assert text in said
    line = re.search(r"^next: frictopt (report .*)$", said, re.MULTILINE)[1]
    assert main([*shlex.split(line), "--pages", "1"]) == 0


def test_one_step_gives_load_cases_and_a_next_line_that_runs(tmp_path, capsys):
    joint_of(tmp_path, deck(PRESS + PUSH))
    file = str(tmp_path / "joint.inp")
    assert main(["look", file]) == 0
    line = re.search(r"^next: frictopt (report .*)$", capsys.readouterr().out, re.MULTILINE)[1]
    assert main([*shlex.split(line), "--pages", "1"]) == 0
    assert main(["report", file, "--mean", "STEP 1"]) == 2
    said = capsys.readouterr().err
    assert "give both" in said and "['STEP 1']" in said and "'CLOAD NTOP'" in said


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--mean", "CLOAD NTOP=1", "--corners", "STEP 1"],
            "presses no contact; .*'DLOAD ETOP P3'",
        ),
        (["--mean", "STEP 7", "--corners", "STEP 1"], r"state 'STEP 7' is unknown; .*\['STEP 1'\]"),
        (["--mean", "STEP 1@0.3", "--corners", "STEP 1"], "'STEP 1@0.3' .* another time .* CASE=X"),
        (["--mean", "STEP 1", "--corners", "DLOAD ETOP=1"], r"load case .*'DLOAD ETOP P3'"),
        (["--mean", "STEP 1", "--corners", "CLOAD NTOP=x"], "'x' is no number"),
    ],
)
def test_a_load_that_is_unknown_or_does_not_press_is_named(tmp_path, capsys, words, message):
    joint_of(tmp_path, deck(PRESS + PUSH))
    assert main(["gross-slip", str(tmp_path / "joint.inp"), *words]) == 2
    assert re.search(message, capsys.readouterr().err)


def test_friction_of_the_deck_of_interactions_and_of_ranges(tmp_path, capsys):
    """40 N press, 24 N push: 0.5 x 40 / 24 by the deck, and as given."""
    joint_of(tmp_path, deck(PRESS, PUSH))
    file = str(tmp_path / "joint.inp")
    words = [file, "--mean", "STEP 1", "--corners", "STEP 2", "STEP 1", "--json"]
    for given, friction in ([], 0.5), (["dry=.3"], 0.3), (["SLOW-SHIGH=.2"], 0.2), ([".4"], 0.4):
        option = ["--friction", *given] if given else []
        assert main(["gross-slip", *words, *option]) == 0
        found = json.loads(capsys.readouterr().out)["answer"]["load_factor"]
        assert found == pytest.approx(friction * 40 / 24, rel=1e-9)
    assert main(["report", *words, "--friction", "DRY=.3:.4:.5", "--pages", "2"]) == 0
    rows = json.loads(capsys.readouterr().out)["answer"]
    assert rows["scatter"] == "friction of 0.3 to 0.5"
    assert main(["gross-slip", *words, "--friction", "DRY=.1", ".2"]) == 2
    assert main(["gross-slip", *words, "--friction", "WET=.1"]) == 2
    assert "friction of 'WET' is unknown; give one of" in capsys.readouterr().err
    joint_of(tmp_path, deck(PRESS, PUSH, pair=PAIR.replace("*FRICTION\n0.5, 1.E6\n", "")))
    assert main(["gross-slip", *words]) == 2
    assert "--friction: there is none" in capsys.readouterr().err


def test_the_contact_of_a_deck_is_kept(tmp_path, capsys):
    joint = joint_of(tmp_path, deck(PRESS, PUSH))
    words = ["--mean", "STEP 1", "--corners", "STEP 2", "STEP 1", "--keep", str(tmp_path / "a.npz")]
    assert main(["gross-slip", str(tmp_path / "joint.inp"), *words]) == 0
    kept = fo.ContactSystem.load(tmp_path / "a.npz")
    assert np.array_equal(kept.S, joint.system().S)
    assert kept.thickness == 2.0 and not kept.per_depth
    assert kept.width.sum() == pytest.approx(4.0)


def test_weight_is_density_times_gravity_of_whole_bodies(tmp_path):
    """Two elements of 1 x 1 x 2 with density 2."""
    text = "*DLOAD\nSLIDER, GRAV, 9.81, 0., -2., 0.\nBASE, GRAV, 9.81, 0., -1., 0.\n"
    joint = joint_of(tmp_path, deck(text))
    assert list(joint.states["STEP 1"]) == ["GRAV SLIDER", "GRAV BASE"]
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -2 * 4 * 9.81])
    with pytest.raises(fo.ModelError, match=r"GRAV E: 'E' is no set of whole bodies"):
        joint_of(
            tmp_path, deck("*DLOAD\nE, GRAV, 9.81, 0., -1., 0.\n", more="*ELSET, ELSET=E\n3\n")
        )
    with pytest.raises(fo.ModelError, match=r"body 'SLIDER': give \*DENSITY"):
        bare = MATERIAL.replace("*DENSITY\n2.\n", "")
        joint_of(tmp_path, deck(text, material=bare))


def test_a_spinning_slider_is_pulled_outwards(tmp_path):
    """omega^2 = 4, mass 8, the middle at x = 1: 32, along x; in space with half of the depth."""
    spin = "*DLOAD\nSLIDER, CENTRIF, 4., 0., 1.5, 0., 0., 0., 1.\n"
    joint = joint_of(tmp_path, deck(PRESS + spin))
    assert carried(joint, {"CENTRIF SLIDER": 1.0}) == pytest.approx([32, 0], abs=1e-9)
    about_y = "*DLOAD\nSLIDER, CENTRIF, 4., 0., 0., 0.5, 0., 1., 0.\n"
    joint = joint_of(tmp_path, deck(about_y, kind="C3D8"))
    assert carried(joint, {"CENTRIF SLIDER": 1.0}) == pytest.approx([16, 0, 0], abs=1e-9)


def test_rings_carry_totals_of_the_circumference(tmp_path):
    """9000 on nodes stays 9000, and 10 on a ring from 3 to 5 is 10 pi (25 - 9)."""
    text = "*CLOAD\nNTOP, 2, -3000.\n"
    joint = joint_of(tmp_path, deck(text, PRESS, kind="CAX4", shift=3.0))
    assert of_states(joint)["STEP 1"][1] == pytest.approx(-9000)
    force = of_states(joint)["STEP 2"][1]
    assert force == pytest.approx(-9000 - 10 * np.pi * 16, rel=1e-9)


def test_a_heated_slider_between_walls_presses_by_its_expansion(tmp_path):
    """Both bodies are held across, the slider above: strain a T / 2 in each, by one dimension."""
    held = HELD + "*BOUNDARY\nNALL, 1, 1\nNTOP, 2, 2\n"
    more = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 20.\n"
    more += "*NSET, NSET=NHOT\n7, 8, 9, 10, 11, 12\n"
    joint = joint_of(
        tmp_path, deck("*TEMPERATURE\nNHOT, 120.\n", kind="CPE4", held=held, more=more)
    )
    # Confined: sigma = M e - 3 K a T in the slider, M e in the base, and the strains cancel.
    bulk = 1000 / (3 * 0.4)
    stress = 3 * bulk * 1e-4 * 100 / 2
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -stress * 4], rel=1e-9)


def test_a_clearance_below_zero_is_an_overlap_and_above_a_gap(tmp_path):
    """Held above and across, an overlap of .01 gives M .01 / 2."""
    held = HELD + "*BOUNDARY\nNALL, 1, 1\nNTOP, 2, 2\n"
    clearance = "*CLEARANCE, MASTER=SHIGH, SLAVE=SLOW, VALUE={}\n"
    text = deck("", kind="CPE4", held=held, more=clearance.format(-0.01))
    joint = joint_of(tmp_path, text)
    stress = 1000 * 0.7 / (1.3 * 0.4) * 0.01 / 2
    assert joint.states["STEP 1"] == {"FIT": 1.0}
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -stress * 4], rel=1e-9)
    joint = joint_of(tmp_path, deck(PRESS, more=clearance.format(0.25)))
    assert joint.system().gap == pytest.approx(0.25)


@pytest.mark.parametrize("is_told", [True, False], ids=["CLEARANCE", "meshes alone"])
def test_meshes_that_overlap_by_a_fit_are_moved_apart_and_pressed(tmp_path, is_told):
    """The slider overlaps the base by .01 under a lid, without lateral strain: E .01 / h on 2 x 2."""
    hold = HELD + "*BOUNDARY\nNALL, 1, 1\nNTOP, 2, 2\n"
    fit = "*CLEARANCE, MASTER=SHIGH, SLAVE=SLOW, VALUE=-.01\n" if is_told else ""
    pair = adjusted(0) if is_told else PAIR
    material = MATERIAL.replace("0.3", "0.0")
    text = deck("", held=hold, pair=pair, more=fit, material=material, lift=-0.01)
    joint = joint_of(tmp_path, text)
    # The slider is .01 higher after its lower nodes have moved.
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -1000 * 0.01 / 1.99 * 4], rel=1e-9)


# A floor .02 below the base.
FLOOR = """*NODE
31, 0, -1, 0
32, 2, -1, 0
33, 2, -.02, 0
34, 0, -.02, 0
*NSET, NSET=NFLOOR
33, 34
*ELEMENT, TYPE=CPS4, ELSET=FLOOR
5, 31, 32, 33, 34
*SOLID SECTION, ELSET=FLOOR, MATERIAL=STEEL
2.
*SURFACE, NAME=SLAVES
SLIDER, S1
FLOOR, S3
*SURFACE, NAME=MASTERS
BASE, S3
BASE, S1
*BOUNDARY
31, 1, 2
32, 1, 2
"""


def test_a_fit_of_one_body_is_not_that_of_another(tmp_path):
    """The slider overlaps the base by .01, and the floor, whose nodes are adjusted, does not."""
    pair = adjusted("NFLOOR").replace("SLOW, SHIGH", "SLAVES, MASTERS")
    joint = joint_of(
        tmp_path, deck("", pair=pair, more=FLOOR, held="*BOUNDARY\nNALL, 1, 1\n", lift=-0.01)
    )
    (fit,) = joint.model.loads["FIT"]
    assert (fit.contact, fit.amount) == ("SLAVES-MASTERS (SLIDER, BASE)", pytest.approx(0.01))


def adjusted(value):
    return PAIR.replace("SURFACE TO SURFACE", f"SURFACE TO SURFACE, ADJUST={value}")


def test_faces_that_are_apart_keep_their_gap_unless_they_are_adjusted(tmp_path, capsys):
    joint = joint_of(tmp_path, deck(PRESS, lift=0.125))
    assert joint.system().gap == pytest.approx(0.125)
    assert joint.model.notes == ("contact 'SLOW-SHIGH': 3 of 3 nodes apart, by up to 0.125",)
    joint = joint_of(tmp_path, deck(PRESS, pair=adjusted(0.2), lift=0.0625))
    assert not joint.system().gap.any()
    assert "3 nodes moved, by up to 0.0625" in str(joint)
    words = [str(tmp_path / "joint.inp"), "--mean", "STEP 1", "--corners", "DLOAD ETOP P3=.5"]
    assert main(["report", *words, "--pages", "1", "--json"]) == 0
    assert "3 nodes moved" in json.loads(capsys.readouterr().out)["answer"]["notes"]
    joint = joint_of(tmp_path, deck(PRESS, pair=adjusted(0.1), lift=0.125))
    assert joint.system().gap == pytest.approx(0.125)
    with pytest.raises(fo.ModelError, match=r"joint.inp: adjust, body 'SLIDER'.* move by 0.125"):
        joint_of(tmp_path, deck(PRESS, pair=adjusted(0.2), lift=0.125))
    with pytest.raises(fo.ModelError, match=r"line \d+: \*CONTACTPAIR .*: an entry is no number"):
        joint_of(tmp_path, deck(PRESS, pair=adjusted("NOWHERE")))


@pytest.mark.parametrize(
    ("adjust", "gap"), [("0", [0, 0, 1]), ("2.E-3", [0, 0, 0]), ("ENDS", [0, 0, 0])]
)
def test_adjust_moves_overlaps_and_the_nodes_within_it_or_of_its_set(tmp_path, adjust, gap):
    """The slider overlaps by .001 at its left end and is open by as much at its right end.

    A force on its lower nodes, which move, is carried in full.
    """
    more = "*NSET, NSET=ENDS\n7, 9\n*NSET, NSET=NLOW\n7, 8, 9\n"
    text = deck(PRESS + "*CLOAD\nNLOW, 1, 3.\n", pair=adjusted(adjust), more=more)
    text = text.replace("\n7, 0, 1, 0", "\n7, 0, .999, 0").replace(
        "\n9, 2, 1, 0", "\n9, 2, 1.001, 0"
    )
    joint = joint_of(tmp_path, text)
    assert joint.system().gap == pytest.approx(1e-3 * np.array(gap), abs=1e-8)
    assert of_states(joint)["STEP 1"] == pytest.approx([9, -40], abs=1e-9)


def test_contacts_have_the_stiffness_of_the_deck_on_request(tmp_path):
    """A lid moves down by .02 without lateral strain: faces of stiffness K are a layer of E / K.

    N = A u / (h / E + 1 / K); rigid faces carry A u E / h.
    """
    hold = HELD + "*BOUNDARY\nNALL, 1, 1\nNTOP, 2, 2\n"
    material = MATERIAL.replace("0.3", "0.0")
    soft = PAIR.replace("1.E7", "2.E3").replace("1.E6", "1.E5")
    text = deck("*BOUNDARY\nNTOP, 2, 2, -.02\n", held=hold, material=material, pair=soft)
    rough = joint_of(tmp_path, text, stiffness="deck")
    assert of_states(rough)["STEP 1"] == pytest.approx([0, -4 * 0.02 / (2e-3 + 5e-4)], rel=1e-6)
    assert rough.model.contacts[0].tangential_stiffness == 1e5
    assert not any("stiffness" in text or "slope" in text for text in rough.left_out)
    assert of_states(joint_of(tmp_path, text))["STEP 1"] == pytest.approx([0, -40], rel=1e-9)
    other = text.replace("LINEAR", "EXPONENTIAL")
    with pytest.raises(fo.ModelError, match=r'SURFACEBEHAVIOR .*stiffness="deck" needs LINEAR'):
        joint_of(tmp_path, other, stiffness="deck")
    assert len(joint_of(tmp_path, other.replace("EXPONENTIAL", "HARD"), stiffness="deck").states)
    with pytest.raises(fo.ModelError, match="stiffness: 'soft'; give 'rigid' or 'deck'"):
        joint_of(tmp_path, text, stiffness="soft")


def test_tables_and_notes_name_the_nodes_of_the_deck(tmp_path):
    """The contact has nodes 7, 8 and 9 of the slider, which a bolt cuts above; 9 cannot move."""
    text = deck(PRESS, held=HELD + "*BOUNDARY\n6, 1, 2\n9, 1, 2\n")
    joint = joint_of(tmp_path, text)
    assert joint.system().deck_node.tolist() == [7, 8]
    assert any("left out: node 9 of body 'SLIDER'" in note for note in joint.model.notes)
    system = fo.read_joint(DATA / "bolt.inp").system()
    head = system.deck_node[system.contact == "HEAD-C_HEAD"]
    points = [line.split(",") for line in (DATA / "bolt.inp").read_text().splitlines()]
    places = {entry[0]: [float(x) for x in entry[1:]] for entry in points if len(entry) == 4}
    assert len(set(head.tolist())) == 32
    at = [places[str(number)] for number in head.tolist()]
    assert np.abs(at - system.points[system.contact == "HEAD-C_HEAD"]).max() < 1e-9


GLUE = "*SURFACE INTERACTION, NAME=GLUE\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1.E7\n"
TIES = {
    "tie": "*TIE, NAME=T, POSITION TOLERANCE=.02\nSFOOT, STOP\n",
    "tie within 2.5 % of an edge": "*TIE, NAME=T\nSFOOT, STOP\n",
    "tie that moves no nodes": "*TIE, NAME=T, ADJUST=NO\nSFOOT, STOP\n",
    "tied pair": GLUE + "*CONTACT PAIR, INTERACTION=GLUE, ADJUST=.02\nSFOOT, STOP\n",
    "tied pair, ADJUST=0": GLUE + "*CONTACT PAIR, INTERACTION=GLUE, ADJUST=0.\nSFOOT, STOP\n",
}


@pytest.mark.parametrize("tie", TIES.values(), ids=TIES)
def test_a_tied_cap_under_a_lid_presses_by_the_expansion_of_all(tmp_path, tie):
    """Three bodies between walls, without lateral strain: N = E alpha dT A, whatever the height.

    The cap ends .01 above the slider, where its nodes do not match.
    """
    material = MATERIAL.replace("0.3", "0.0")
    hot = "*TEMPERATURE\nNALL, 100.\nNCAP, 100.\n"
    joint = joint_of(tmp_path, deck(hot, material=material, more=CAP + tie))
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -1000 * 1e-4 * 100 * 4], rel=1e-9)
    assert list(joint.friction) == ["SLOW-SHIGH"]
    assert any("moved, by up to 0.01" in note for note in joint.model.notes) == ("=NO" not in tie)

    cycle = joint.cycle("STEP 1", ["TEMPERATURE NALL=0.1", "TEMPERATURE NALL=-0.1"])
    steady = fo.steady_state(joint.system(), cycle, joint.friction, 1.0, progress=False)
    table = steady.by_contact(joint.model)
    assert table["contact"].tolist() == ["SLOW-SHIGH", "tie SFOOT-STOP (CAP, SLIDER)"]
    P = table[["P_0", "P_1"]].to_numpy(dtype=float)
    assert P[0].sum() == pytest.approx(80, rel=1e-9) and P[0, 0] > 42
    assert P[1] == pytest.approx(P[0], rel=1e-9)
    # Walls hold all nodes sideways.
    assert (table.loc[1, ["Q_0", "Q_1", "M_0"]] == 0).all()


def test_ties_that_cannot_be_meant_are_refused(tmp_path):
    far = CAP + "*TIE, POSITION TOLERANCE=.005\nSFOOT, STOP\n"
    with pytest.raises(fo.ModelError, match=r"no node of the face of body 'CAP' lies within 0.005"):
        joint_of(tmp_path, deck(PRESS, more=far))
    with pytest.raises(fo.ModelError, match=r"line \d+: \*TIE: 'NO' has no face of a body"):
        joint_of(tmp_path, deck(PRESS, more=CAP + "*TIE\nSFOOT, NO\n"))
    tied = PAIR.replace("LINEAR", "TIED")
    with pytest.raises(fo.ModelError, match=r"no \*CONTACT PAIR that may slide"):
        joint_of(tmp_path, deck(PRESS, pair=tied))


RING = [
    "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n1.\n*NSET, NSET=NBORE\n1, 2, 3, 4",
    "*ELSET, ELSET=FIRST\n1, 4\n*ELSET, ELSET=LAST\n3, 6\n*ELSET, ELSET=ALL\n1, 2, 3, 4, 5, 6",
    "*SURFACE, NAME=START\nFIRST, S1\n*SURFACE, NAME=END\nLAST, S3",
    "*SURFACE, NAME=SLOW\nRIM, S4\n*SURFACE, NAME=SHIGH\nHUB, S2",
    "*TIE, CYCLIC SYMMETRY, NAME=CUT, POSITION TOLERANCE=1.E-3\nEND, START",
    "*CYCLIC SYMMETRY MODEL, N=4, TIE=CUT\n5., 0., 0., 5., 0., 1.",
    "*BOUNDARY\nNBORE, 1, 2\n",
]


@pytest.mark.parametrize("turned", [False, True])
def test_a_quarter_of_a_ring_passes_its_torque_on(tmp_path, turned):
    """Tangential forces of 5 at two places of radius 3 about (5, 0): 30 in the contact."""
    angles = np.radians([0, 30, 60, 90])
    lines = ["*NODE, NSET=NALL"]
    for radius in (1, 2, 2, 3):
        for j, angle in enumerate(angles):
            # The last cut face is off by less than the tolerance.
            x, y = 5 + radius * np.cos(angle) + 5e-4 * (j == 3), radius * np.sin(angle)
            lines.append(f"{len(lines)}, {x:.12g}, {y:.12g}, 0")
    for body, first in (("HUB", 1), ("RIM", 9)):
        lines.append(f"*ELEMENT, TYPE=CPS4, ELSET={body}")
        for j in range(3):
            n = first + j
            lines.append(f"{j + 1 + 3 * (first > 1)}, {n}, {n + 4}, {n + 5}, {n + 1}")
    turn = ["*CLOAD"]
    for node, angle in ((14, angles[1]), (15, angles[2])):
        turn += [f"{node}, 1, {-5 * np.sin(angle)}", f"{node}, 2, {5 * np.cos(angle)}"]
    if turned:
        lines.append("*TRANSFORM, NSET=NALL, TYPE=C\n5., 0., 0., 5., 0., 1.")
        turn = ["*CLOAD\n14, 2, 5.\n15, 2, 5."]
    text = "\n".join([*lines, *RING]) + MATERIAL + PAIR + steps("\n".join([*turn, ""]))
    joint = joint_of(tmp_path, text)
    system = joint.system()
    assert joint.model._answer()["sector"] == "1 of 4"
    q, p = system.reaction(joint.states["STEP 1"])
    forces = (np.column_stack([q, p])[:, :, None] * system.frames).sum(axis=1)
    arms = system.points - [5, 0]
    torque = (arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]).sum()
    assert abs(torque) == pytest.approx(30, rel=1e-9)
    with pytest.raises(fo.ModelError, match="give the Cyclic a tolerance"):
        joint_of(tmp_path, text.replace(", POSITION TOLERANCE=1.E-3", ""))


def test_forces_and_supports_along_turned_axes(tmp_path):
    """Axes y and -x; axes at 30 degrees; and axes away from and around a line."""
    axes = "*TRANSFORM, NSET=NTOP\n0., 2., 0., -1., 0., 0.\n"
    joint = joint_of(tmp_path, deck("*CLOAD\nNTOP, 1, -1.\nNTOP, 2, -8.\n", more=axes))
    assert of_states(joint)["STEP 1"] == [24, -3]
    axes = "*TRANSFORM, NSET=NTOP, TYPE=R\n1.7320508075688772, 1., 0., 0., 1., 0.\n"
    joint = joint_of(tmp_path, deck(PRESS + "*CLOAD\nNTOP, 1, 2.\n", more=axes))
    assert of_states(joint)["STEP 1"] == pytest.approx([3 * 3**0.5, 3 - 40], abs=1e-9)

    # About the line x = 1, y = -3. The middle of the top is above it, so its second axis is -x.
    around = "*TRANSFORM, NSET=NTOP, TYPE=C\n1., -3., 0., 1., -3., 2.\n"
    loads = "*BOUNDARY\n11, {0}, {0}\n*CLOAD\n10, 1, 8.\n"
    states = []
    for more, axis, x in ((around, 2, 8 / 26**0.5), ("", 1, None)):
        text = loads.format(axis)
        if x is None:
            text = loads.format(1).replace("10, 1, 8.", "10, 1, -{0}\n10, 2, {1}")
            text = text.format(8 / 26**0.5, 40 / 26**0.5)
        states.append(of_states(joint_of(tmp_path, deck(PRESS + text, more=more)))["STEP 1"])
    assert states[0] == pytest.approx(states[1], abs=1e-8)


@pytest.mark.parametrize("kind", ["CPS4", "C3D8"])
def test_nodes_held_along_all_turned_axes_move_along_them(tmp_path, kind):
    """Nodes of the top move by .01 away from the line x = 1, y = -3, or by components of it."""
    last = 2 if kind == "CPS4" else 3
    around = "*TRANSFORM, NSET=NTOP, TYPE=C\n1., -3., 0., 1., -3., 2.\n"
    push = f"*BOUNDARY\nNTOP, 1, {last}, 0.\nNTOP, 1, 1, -.01\n"
    turned = of_states(joint_of(tmp_path, deck(push, kind=kind, more=around)))["STEP 1"]
    text = mesh(kind)
    top = text[text.index("NSET=NTOP") :].splitlines()[1].split(",")
    lines = ["*BOUNDARY"]
    for node in top:
        x = float(re.search(rf"^{int(node)}, ([^,]+)", text, re.MULTILINE)[1]) - 1.0
        length = np.hypot(x, 5.0)
        lines += [f"{node}, 1, 1, {-0.01 * x / length}", f"{node}, 2, 2, {-0.05 / length}"]
        lines += [f"{node}, 3, 3, 0."]
    bare = of_states(joint_of(tmp_path, deck("\n".join([*lines, ""]), kind=kind)))["STEP 1"]
    assert turned == pytest.approx(bare, abs=1e-8) and turned[1] < -1


@pytest.mark.parametrize("kind", ["DISTRIBUTING", "KINEMATIC"])
def test_a_force_and_a_moment_on_a_coupled_point(tmp_path, kind):
    more = "*NODE\n99, 1., 4., .5\n*COUPLING, REF NODE=99, SURFACE=STOP, CONSTRAINT NAME=C\n"
    more += f"*{kind}\n1, 3\n"
    loads = "*CLOAD\n99, 2, -40.\n99, 1, 3.\n99, 6, 5.\n"
    joint = joint_of(tmp_path, deck(loads, kind="C3D8", more=more))
    assert list(joint.states["STEP 1"]) == ["CLOAD 99"]
    assert of_states(joint)["STEP 1"] == pytest.approx([3, -40, 0], abs=1e-9)
    system = joint.system()
    p = system.reaction(joint.states["STEP 1"])[1]
    moment = (p * (system.points[:, 0] - 1)).sum()  # about the middle of the contact, y = 1
    assert moment == pytest.approx(3 * 3 - 5, abs=1e-9)  # on the slider, against the load


def test_a_held_point_holds_the_nodes_of_its_rigid_body(tmp_path):
    more = "*NODE\n99, 1., 0., .5\n*RIGID BODY, NSET=NBASE, REF NODE=99\n*BOUNDARY\n99, 1, 6\n"
    press = PRESS.replace("P3", "P5")
    joint = joint_of(tmp_path, deck(press, kind="C3D8", held="", more=more))
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -20, 0], abs=1e-9)


def test_a_held_rigid_face_is_moved_by_its_point_and_not_turned(tmp_path):
    """The slider is pressed by .01, with its base 2 high, without lateral strain: E .01 / 2 on 2."""
    more = "*NODE\n98, 1., 2., .5\n99, 1., 2., .5\n*BOUNDARY\n99, 1, 3\n98, 1, 3\n"
    more += "*RIGID BODY, NSET=NTOP, REF NODE=99, ROT NODE=98\n"
    options = {"kind": "C3D8", "material": MATERIAL.replace("0.3", "0.0"), "more": more}
    joint = joint_of(tmp_path, deck("*BOUNDARY\n99, 2, 2, -.01\n", **options))
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -10, 0], abs=1e-9)
    for turned in ("98, 3, 3, .01", "99, 6, 6, .01"):
        with pytest.raises(fo.ModelError, match="node 99 is a REF NODE; give the force on it, or"):
            joint_of(tmp_path, deck(f"*BOUNDARY\n{turned}\n", **options))


def test_a_pair_may_be_glued_in_some_steps(tmp_path):
    tied = PAIR.replace("LINEAR", "TIED")
    change = "*CHANGE SURFACE BEHAVIOR, INTERACTION=DRY\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE="
    joint = joint_of(tmp_path, deck(PRESS, f"{change}HARD\n", PUSH, pair=tied))
    assert list(joint.friction) == ["SLOW-SHIGH"]
    assert joint.cycle("STEP 2", ["STEP 3"]).mean == {"DLOAD ETOP P3": 1.0}
    with pytest.raises(fo.ModelError, match="'STEP 1' has other supports, contact pairs"):
        joint.cycle("STEP 1", ["STEP 3"])
    with pytest.raises(fo.ModelError, match="in force at the end"):
        joint_of(tmp_path, deck(PRESS, f"{change}TIED\n"))


def test_supports_of_curved_elements_hold_the_middles_of_faces(tmp_path):
    """A face of eight nodes has a ninth in its middle; a column of one brick on another."""
    corner = [(0, 0), (1, 0), (1, 1), (0, 1)]
    lines, elements = ["*NODE"], []
    for body in (0, 1):
        start = len(lines) - 1
        bottom = [(x, y, body) for x, y in corner]
        top = [(x, y, body + 1) for x, y in corner]
        middles = [
            *(
                ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, z)
                for z in (body, body + 1)
                for a, b in zip(corner, corner[1:] + corner[:1], strict=True)
            ),
            *((x, y, body + 0.5) for x, y in corner),
        ]
        for place in [*bottom, *top, *middles]:
            lines.append(f"{len(lines)}, " + ", ".join(f"{value:g}" for value in place))
        elements.append([start + k + 1 for k in range(20)])
    text = "\n".join(
        [
            *lines,
            *(
                f"*ELEMENT, TYPE=C3D20R, ELSET={name}\n{n}, "
                + ", ".join(map(str, nodes[:10]))
                + ",\n"
                + ", ".join(map(str, nodes[10:]))
                for n, (name, nodes) in enumerate(zip(("BASE", "SLIDER"), elements, strict=True), 1)
            ),
            "*NSET, NSET=NBASE\n1, 2, 3, 4, 9, 10, 11, 12",
            "*SURFACE, NAME=SLOW\nSLIDER, S1\n*SURFACE, NAME=SHIGH\nBASE, S2",
            "*ELSET, ELSET=EALL\nBASE, SLIDER\n*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
            "",
        ]
    )
    text += MATERIAL + PAIR + HELD + "*STEP\n*STATIC\n*DLOAD\nSLIDER, P2, 10.\n*END STEP\n"
    joint = joint_of(tmp_path, text)
    (support,) = joint.model.supports
    base = joint.model.bodies["BASE"].mesh
    held = support.where(*base.p)
    assert held.sum() == 9 and np.abs(base.p[2, held]).max() == 0
    assert of_states(joint)["STEP 1"] == pytest.approx([0, 0, -10], abs=1e-9)
    assert "C3D20R: its elements are integrated in full" in joint.left_out


# What is refused: the message, and the lines of the deck that bring it about.
IN_MODEL = {
    r"line \d+: \*TIE CYCLICSYMMETRY, MULTISTAGE, NAME=T: give all bodies": "*TIE, CYCLIC SYMMETRY, MULTISTAGE, NAME=T\nSLOW, SHIGH\n",
    r"\*CONTACT: .* write \*CONTACT PAIR": "*CONTACT\n",
    r"\*EQUATION: ": "*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n",
    r"line \d+: \*TRANSFORM .*: no axes at node 2; leave it out": "*TRANSFORM, NSET=NALL, TYPE=C\n1., 0., 0., 1., 0., 1.\n",
    r"\*TRANSFORM .*: 4 coordinates; give those of two points": "*TRANSFORM, NSET=NALL\n1., 0., 0., 1.\n",
    r"ORIENTATION=O: directions are global": "*SOLID SECTION, ELSET=BASE, MATERIAL=STEEL, ORIENTATION=O\n2.\n",
    r"\*PLASTIC: .* elastic=True": "*MATERIAL, NAME=S\n*PLASTIC\n1., 0.\n",
    r"TYPE=S4": "*ELEMENT, TYPE=S4, ELSET=E\n9, 1, 2, 3, 4\n",
    r"TYPE=SPRINGA": "*ELEMENT, TYPE=SPRINGA, ELSET=E\n9, 1, 2\n",
    r"\*TIE .*NAME=T: there is no \*CYCLIC SYMMETRY MODEL, TIE=T": "*TIE, CYCLIC SYMMETRY, NAME=T\nSLOW, SHIGH\n",
    r"there is no \*TIE, CYCLIC SYMMETRY, NAME=T": "*CYCLIC SYMMETRY MODEL, N=4, TIE=T\n0., 0., 0., 0., 0., 1.\n",
    r"'SOME' has no face of a body": "*SURFACE, NAME=SOME, TYPE=NODE\n1,\n*CONTACT PAIR, INTERACTION=DRY\nSOME, SHIGH\n",
    r"TIED: write \*TIE": "*CONTACT PAIR, INTERACTION=DRY, TIED\nSLOW, SHIGH\n",
    r"'SLOW' is also the face of body_1": "*CONTACT PAIR, INTERACTION=DRY\nSLOW, slow\n",
    r"NOSEPARATION: contacts open": "*SURFACE INTERACTION, NAME=WET\n*SURFACE BEHAVIOR, NO SEPARATION\n",
    r"TAUMAX=3.: give the coefficient alone": "*SURFACE INTERACTION, NAME=WET\n*FRICTION, TAUMAX=3.\n.5\n",
    r"\*FRICTION: an entry is no number": "*SURFACE INTERACTION, NAME=WET\n*FRICTION\n, 1.E6\n",
    r"\*CLEARANCE .*: no \*CONTACT PAIR has the surfaces": "*CLEARANCE, MASTER=SLOW, SLAVE=SHIGH, VALUE=-.01\n",
    r"VALUE=ABSOLUTE: give multiples": "*AMPLITUDE, NAME=W, VALUE=ABSOLUTE\n0., 1.\n",
    r"SHIFTX=1.: shift the table": "*AMPLITUDE, NAME=W, SHIFTX=1.\n0., 1.\n",
    r"\*AMPLITUDE .*: give a table": "*AMPLITUDE, NAME=W, DEFINITION=EQUALLY SPACED, FIXED INTERVAL=1.\n0., 1.\n",
    r"give a time and a value, and so on; times rise, also at a jump": "*AMPLITUDE, NAME=W\n1., 1., 0., 0.\n",
    r"\*AMPLITUDE NAME=W: give a time": "*AMPLITUDE, NAME=W\n0., 1., 1.\n",
    r"\*KINEMATIC: it leaves displacements free; give 1, 3": "*NODE\n99, 1, 4, 0\n*COUPLING, REF NODE=99, SURFACE=STOP\n*KINEMATIC\n1, 2\n",
    r"\*KINEMATIC: 'REFNODE' is not in this deck": "*KINEMATIC\n1, 3\n",
    r"\*CONTACTPAIR INTERACTION=WET: 'WET' is not in this deck": "*CONTACT PAIR, INTERACTION=WET\nSLOW, SHIGH\n",
}
IN_STEP = {
    r"\*MODELCHANGE": "*MODEL CHANGE, TYPE=CONTACT PAIR, ADD\nA, B\n",
    r"node set 'NOWHERE': unknown": "*CLOAD\nNOWHERE, 1, 1.\n",
    r"line \d+: \*CLOAD: 777 is not in this deck": "*CLOAD\n777, 1, 1.\n",
    r"P3NU is not read": "*DLOAD\nETOP, P3NU, 1.\n",
    r"joint.inp, line \d+: \*CLOAD: an entry is no number": "*CLOAD\nNTOP, 1, ten\n",
    r"CLOAD NTOP: node \d+ has forces .* moments to the REF": "*CLOAD\nNTOP, 6, 1.\n",
    r"FIXED is read for bolts": "*BOUNDARY, FIXED\nNTOP, 1, 1\n",
    r"write it above the first \*STEP": "*CONTACT PAIR, INTERACTION=DRY\nSLOW, SHIGH\n",
    r"VELOCITY: give displacements": "*BOUNDARY, TYPE=VELOCITY\nNTOP, 2, 2, 1.\n",
    r"direction 0; give 1 to 3": "*BOUNDARY\nNTOP, 0, 1\n",
    r"direction 11; give 1 to 3": "*BOUNDARY\nNTOP, 11, 11, 20.\n",
    r"direction 7; give 1 to 3": "*CLOAD\nNTOP, 7, 1.\n",
    r"'W' is not in this deck": "*CLOAD, AMPLITUDE=W\nNTOP, 1, 1.\n",
    r"\*STATIC: period -2.; give": "*END STEP\n*STEP\n*STATIC\n1., -2.\n",
}
IN_BOTH = {
    r"TRANSFORM: node 12 is held along an axis other than x, y and z": (
        "*TRANSFORM, NSET=NALL, TYPE=C\n1., -3., 0., 1., -3., 1.\n",
        "*BOUNDARY\n11, 2, 2\n12, 2, 2\n",
    ),
    r"times rise, also at a jump": (
        "*AMPLITUDE, NAME=W\n0., 0., .5, 1., .5, -1., 1., 0.\n",
        "*CLOAD, AMPLITUDE=W\nNTOP, 1, 8.\n",
    ),
    r"BOUNDARY .*: node 99 is a REF NODE; give the force on it": (
        "*NODE\n99, 1, 4, 0\n*COUPLING, REF NODE=99, SURFACE=STOP\n*KINEMATIC\n1, 3\n",
        "*BOUNDARY\n99, 1, 1, .1\n",
    ),
}
REFUSED = {
    **{message: (lines, "") for message, lines in IN_MODEL.items()},
    **{message: ("", lines) for message, lines in IN_STEP.items()},
    **IN_BOTH,
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_cannot_be_meant_is_refused_by_keyword(tmp_path, message):
    model, step = REFUSED[message]
    with pytest.raises(fo.ModelError, match=message):
        joint_of(tmp_path, deck(PRESS + step, more=model))


def test_faces_apart_or_overlapping_need_the_keyword_that_the_error_names(tmp_path):
    clearance = "*CLEARANCE, MASTER=SHIGH, SLAVE=SLOW, VALUE=.02\n"
    with pytest.raises(
        fo.ModelError, match=r"\(in a deck no \*CLEARANCE\).* \*CONTACT PAIR, ADJUST"
    ):
        joint_of(tmp_path, deck(PRESS, lift=0.01, more=clearance))
    assert joint_of(tmp_path, deck(PRESS, lift=0.01)).system().gap == pytest.approx(0.01)
    node = next(
        line for line in deck(PRESS, lift=-0.01).splitlines() if line.endswith("0, 0.99, 0")
    )
    uneven = deck(PRESS, lift=-0.01).replace(node, node.replace("0.99", "0.98"))
    with pytest.raises(fo.ModelError, match=r"in a deck \*CLEARANCE\).* \*CONTACT PAIR, ADJUST=0"):
        joint_of(tmp_path, uneven)
    assert not joint_of(tmp_path, deck(PRESS, pair=adjusted(0), lift=-0.01)).system().gap.any()


def test_a_clearance_may_stand_before_its_pair(tmp_path):
    clearance = "*CLEARANCE, MASTER=shigh, SLAVE=SLOW, VALUE=.25\n"
    joint = joint_of(tmp_path, deck(PRESS, pair=clearance + PAIR))
    assert joint.system().gap == pytest.approx(0.25)


def test_decks_without_contacts_steps_or_materials_are_refused(tmp_path):
    with pytest.raises(fo.ModelError, match=r"no \*CONTACT PAIR"):
        joint_of(tmp_path, deck(PRESS, pair=""))
    with pytest.raises(fo.ModelError, match=r"no \*STATIC step"):
        joint_of(tmp_path, deck())
    with pytest.raises(fo.ModelError, match=r"no step has a load; .* overlap"):
        joint_of(tmp_path, deck(""))
    with pytest.raises(fo.ModelError, match=r"body 'BASE'.* give all of it one"):
        joint_of(
            tmp_path, deck(PRESS).replace("*SOLID SECTION, ELSET=BASE, MATERIAL=STEEL\n2.\n", "")
        )
    with pytest.raises(fo.ModelError, match=r"give a deck of CalculiX or Abaqus"):
        fo.read_joint(DATA / "joint.bdf")


def test_plasticity_is_left_out_on_request(tmp_path):
    plastic = MATERIAL + "*PLASTIC\n100., 0.\n"
    joint = joint_of(tmp_path, deck(PRESS, material=plastic), elastic=True)
    assert any("PLASTIC" in text for text in joint.left_out)
    assert of_states(joint)["STEP 1"] == [0, -40]


def test_constants_that_are_left_out_are_0(tmp_path):
    joint = joint_of(tmp_path, deck(PRESS, material=MATERIAL.replace("1000., 0.3", "1000.")))
    assert joint.model.bodies["BASE"].material == fo.fem.Material(1000.0, 0.0, 2.0)


def test_constants_of_one_temperature_are_constants(tmp_path):
    """E and nu are followed by the temperature, the density too; 40 N press."""
    at_20 = MATERIAL.replace("1000., 0.3", "1000., 0.3, 20.").replace("2.\n", "2., 20.\n")
    joint = joint_of(tmp_path, deck(PRESS, material=at_20))
    assert joint.model.bodies["BASE"].material == fo.fem.Material(1000.0, 0.3, 2.0)
    assert of_states(joint)["STEP 1"] == [0, -40]


def test_a_keyword_that_nobody_knows_is_named(tmp_path):
    joint = joint_of(tmp_path, deck(PRESS, more="*MAGIC\n1, 2\n*ELEMENTS\n1, 2\n*ROWS\n1\n"))
    assert {"*MAGIC: not read", "*ELEMENTS: not read", "*ROWS: not read"} <= {*joint.left_out}


def test_bodies_that_share_a_node_alone_are_separate_and_that_is_said(tmp_path):
    more = "*NODE\n91, 3., -1., 0.\n92, 3., 0., 0.\n93, 2., -1., 0.\n"
    more += "*ELEMENT, TYPE=CPS4, ELSET=TAIL\n9, 93, 91, 92, 3\n*NSET, NSET=NTAIL\n91, 92\n"
    more += "*SOLID SECTION, ELSET=TAIL, MATERIAL=STEEL\n2.\n*BOUNDARY\nNTAIL, 1, 2\n"
    joint = joint_of(tmp_path, deck(PRESS, more=more))
    assert "1 node that bodies share: only faces join elements" in joint.left_out
    with pytest.raises(fo.ModelError, match=r"node 3 has forces .* is in 2 bodies"):
        joint_of(
            tmp_path,
            deck(PRESS + "*CLOAD\n3, 1, 1.\n", more=more, held="*BOUNDARY\n1, 1, 2\n2, 1, 2\n"),
        )


def test_steps_of_one_name_are_refused(tmp_path):
    text = deck(PRESS, "").replace("*STEP, NLGEOM", "*STEP, NAME=Load")
    with pytest.raises(fo.ModelError, match=r"\*STEP NAME=LOAD: another step has this name"):
        joint_of(tmp_path, text)


def test_a_surface_of_several_bodies_makes_a_contact_with_each(tmp_path):
    """One slave face on two bodies, and a body that is far away is dropped and named."""
    more = "*NODE\n91, 50., 0., 0.\n92, 51., 0., 0.\n93, 51., 1., 0.\n94, 50., 1., 0.\n"
    more += "*ELEMENT, TYPE=CPS4, ELSET=FAR\n9, 91, 92, 93, 94\n"
    more += "*SOLID SECTION, ELSET=FAR, MATERIAL=STEEL\n2.\n*BOUNDARY\nNFAR, 1, 2\n"
    more += "*NSET, NSET=NFAR\n91, 92\n*SURFACE, NAME=BOTH\nBASE, S3\nFAR, S3\n"
    joint = joint_of(tmp_path, deck(PRESS, pair=PAIR.replace("SHIGH", "BOTH"), more=more))
    assert list(joint.friction) == ["SLOW-BOTH"]
    assert "*CONTACTPAIR: SLOW of SLIDER far from BOTH of FAR" in joint.left_out
