"""The page of formats: each keyword of a joint in its table is tried."""

import re
from pathlib import Path

import pytest

import frictopt as fo
from helpers.formats_page import section
from helpers.joint_decks import CAP, MATERIAL, PAIR, PRESS, carried, deck, joint_of

TABLE = re.findall(
    r"^\| `\*([A-Z -]+).*?` (?:in a joint )?\| (kept|refused) \|",
    section("Decks with contacts and steps"),
    re.MULTILINE,
)
DATA = Path(__file__).parents[1] / "data"
LINES = {"PLASTIC": "100., 0."}
POINT = "*NODE\n99, 1., 4., .5\n"


def steel(joint):
    return joint.model.bodies["BASE"].material


def cases(joint):
    return set(joint.states["STEP 1"])


KEPT = {  # what is true of the joint
    "CONTACT PAIR": lambda joint: list(joint.friction) == ["SLOW-SHIGH"],
    "SURFACE INTERACTION": lambda joint: joint.interactions["DRY"] == ["SLOW-SHIGH"],
    "FRICTION": lambda joint: joint.friction["SLOW-SHIGH"] == 0.5,
    "SURFACE BEHAVIOR": lambda joint: any("penalty" in text for text in joint.left_out),
    "CLEARANCE": lambda joint: "FIT" in cases(joint),
    "MATERIAL": lambda joint: steel(joint).E == 1000,
    "ELASTIC": lambda joint: steel(joint).nu == 0.3,
    "DENSITY": lambda joint: steel(joint).density == 2,
    "EXPANSION": lambda joint: "TEMPERATURE NALL" in cases(joint),
    "INITIAL CONDITIONS": lambda joint: "TEMPERATURE NALL" not in cases(joint),
    "TEMPERATURE": lambda joint: "TEMPERATURE NALL" in cases(joint),
    "AMPLITUDE": lambda joint: "CLOAD NTOP" not in cases(joint),
    "MODEL CHANGE": lambda joint: joint.unlike == [],
    "CHANGE FRICTION": lambda joint: joint.friction["SLOW-SHIGH"] == 0.3,
    "STEP": lambda joint: list(joint.states) == ["STEP 1"],
    "CLOAD": lambda joint: "CLOAD NTOP" in cases(joint),
    "DLOAD": lambda joint: "DLOAD ETOP P3" in cases(joint),
    "DSLOAD": lambda joint: "DSLOAD STOP P" in cases(joint),
    "BOUNDARY": lambda joint: joint.model.supports[0].directions == "xy",
    "TRANSFORM": lambda joint: carried(joint, {"CLOAD NTOP": 1.0}).round(9).tolist() == [0, 3],
    "COUPLING": lambda joint: "CLOAD 99" in cases(joint),
    "TIE": lambda joint: joint.model.ties == (fo.fem.Tie("CAP", "SLIDER", "SFOOT", "STOP", 0.02),),
    "RIGID BODY": lambda joint: isinstance(joint.model.supports[-1], fo.fem.RigidCoupling),
}
WRITTEN = {  # lines of the model and of the step, where the deck needs more
    "CLEARANCE": ("*CLEARANCE, MASTER=SHIGH, SLAVE=SLOW, VALUE=-1.E-3\n", ""),
    "EXPANSION": ("", "*TEMPERATURE\nNALL, 10.\n"),
    "INITIAL CONDITIONS": (
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 10.\n",
        "*TEMPERATURE\nNALL, 10.\n",
    ),
    "TEMPERATURE": ("", "*TEMPERATURE\nNALL, 1.\n"),
    "AMPLITUDE": ("*AMPLITUDE, NAME=OFF\n0., 1., 1., 0.\n", "*CLOAD, AMPLITUDE=OFF\nNTOP, 1, 1.\n"),
    "MODEL CHANGE": ("", "*MODEL CHANGE, TYPE=CONTACT PAIR, ADD\nSLOW, SHIGH\n"),
    "CHANGE FRICTION": ("", "*CHANGE FRICTION, INTERACTION=DRY\n*FRICTION\n.3\n"),
    "CLOAD": ("", "*CLOAD\nNTOP, 1, 1.\n"),
    "DSLOAD": ("", "*DSLOAD\nSTOP, P, 1.\n"),
    "TRANSFORM": ("*TRANSFORM, NSET=NTOP\n0., 1., 0., 1., 0., 0.\n", "*CLOAD\nNTOP, 1, 1.\n"),
    "COUPLING": (
        f"{POINT}*COUPLING, REF NODE=99, SURFACE=STOP, CONSTRAINT NAME=C\n*KINEMATIC\n1, 3\n",
        "*CLOAD\n99, 1, 1.\n",
    ),
    "TIE": (f"{CAP}*TIE, POSITION TOLERANCE=.02\nSFOOT, STOP\n", ""),
    "RIGID BODY": (f"{POINT}*RIGID BODY, NSET=NTOP, REF NODE=99\n", "*CLOAD\n99, 1, 1.\n"),
}


def test_the_page_lists_what_is_tried():
    assert {name for name, effect in TABLE if effect == "kept"} == {
        *KEPT,
        "PRE-TENSION SECTION",
        "CYCLIC SYMMETRY MODEL",
    }
    assert len(TABLE) - len(KEPT) > 9


@pytest.mark.parametrize("name", KEPT)
def test_a_kept_keyword_has_its_effect(tmp_path, name):
    more, step = WRITTEN.get(name, ("", ""))
    joint = joint_of(tmp_path, deck(PRESS + step, more=more))
    assert KEPT[name](joint) and f"*{name.replace(' ', '')}: not read" not in joint.left_out


def test_a_bolt_is_a_load_case(tmp_path):
    joint = fo.read_joint(DATA / "bolt.inp")
    (bolt,) = joint.model.loads["BOLT SECTION"]
    assert bolt == fo.fem.BoltPreload("BOLT", "SECTION", 8000.0, locked=True)


@pytest.mark.parametrize("name", [name for name, effect in TABLE if effect == "refused"])
def test_a_refused_keyword_is_named_with_its_line(tmp_path, name):
    block = f"*{name}\n{LINES.get(name, '1, 2')}\n"
    with pytest.raises(fo.ModelError, match=rf"joint.inp, line \d+: \*{name.replace(' ', '')}\b"):
        joint_of(tmp_path, deck(PRESS, more=block))


@pytest.mark.parametrize(
    ("part", "odd", "message"),
    [
        (
            PAIR,
            PAIR.replace("0.5, 1.E6", "0.5, , , 20.\n0.4, , , 90."),
            r"\*FRICTION: give one line",
        ),
        (
            MATERIAL,
            MATERIAL.replace("*ELASTIC", "*ELASTIC, TYPE=ENGINEERING CONSTANTS"),
            "isotropic",
        ),
        (
            MATERIAL,
            MATERIAL.replace("1000., 0.3", "1000., 0.3\n900., 0.3, 90."),
            "ELASTIC: give one line",
        ),
    ],
)
def test_what_a_keyword_cannot_mean_is_refused(tmp_path, part, odd, message):
    with pytest.raises(fo.ModelError, match=message):
        joint_of(tmp_path, deck(PRESS).replace(part, odd))
