"""Loads of the steps of a deck: what is in force at the end of each, by statics."""

from pathlib import Path

import pytest

import frictopt as fo
from helpers.joint_decks import HELD, MATERIAL, PRESS, deck, joint_of, of_states

PUSH = "*CLOAD\nNTOP, 1, 8.\n"  # three nodes


def test_loads_persist_and_a_load_replaces_that_of_its_place(tmp_path):
    """Ten on 2 x 2 is 40. A face and a node get another load; a block without lines changes none."""
    joint = joint_of(
        tmp_path,
        deck(
            PRESS,
            PUSH,
            "*DLOAD\n3, P3, 5.\n",
            "*CLOAD\n10, 1, 2.\n10, 2, -1.\n",
            "*CLOAD\n*DLOAD\n",
        ),
    )
    assert of_states(joint) == {
        "STEP 1": [0, -40],
        "STEP 2": [24, -40],
        "STEP 3": [24, -30],
        "STEP 4": [18, -31],
        "STEP 5": [18, -31],
    }
    assert joint.states["STEP 2"] == {"DLOAD ETOP P3": 1.0, "CLOAD NTOP": 1.0}


def test_a_multiple_is_the_same_load_case_and_anything_else_another_one(tmp_path):
    joint = joint_of(
        tmp_path,
        deck(
            PRESS + PUSH, "*CLOAD\nntop, 1, -2.\n", "*CLOAD\nNTOP, 2, -1.\n", "*CLOAD\n10, 1, 1.\n"
        ),
    )
    names = [{name for name in loads if "CLOAD" in name} for loads in joint.states.values()]
    assert names == [
        {"CLOAD NTOP"},
        {"CLOAD NTOP"},
        {"CLOAD NTOP (STEP 3)"},
        {"CLOAD NTOP (STEP 4)", "CLOAD (STEP 4)"},
    ]
    assert joint.states["STEP 2"]["CLOAD NTOP"] == -0.25
    assert list(of_states(joint).values()) == [[24, -40], [-6, -40], [-6, -43], [-3, -43]]


def test_loads_of_one_step_at_one_place_add_up(tmp_path):
    """As CalculiX 2.20 does: 8 and 3 on a node, 10 and 5 on a face."""
    text = PRESS + PUSH + "10, 1, 3.\n*DLOAD\n3, P3, 5.\n"
    joint = joint_of(tmp_path, deck(text, "*CLOAD\n10, 1, 1.\n*DLOAD\n3, P3, 1.\n"))
    assert of_states(joint) == {"STEP 1": [27, -50], "STEP 2": [17, -22]}


def test_supports_carry_the_forces_on_them(tmp_path):
    more = "*BOUNDARY\nNTOP, 1, 1\n"
    joint = joint_of(tmp_path, deck(PRESS + PUSH + "*CLOAD\nNTOP, 2, -1.\n", more=more))
    bare = joint_of(tmp_path, deck(PRESS + "*CLOAD\nNTOP, 2, -1.\n", more=more))
    assert of_states(joint) == of_states(bare)


@pytest.mark.parametrize(
    ("step", "force"),
    [
        ("*CLOAD, OP=NEW\n", [0, -40]),
        ("*DLOAD, OP=NEW\n", [24, 0]),
        ("*CLOAD\nNTOP, 2, -1.\n*CLOAD, OP=NEW\n", [24, -43]),
        ("*CLOAD, OP=NEW\n10, 1, 1.\n*CLOAD, OP=NEW\n", [1, -40]),
    ],
)
def test_new_removes_the_loads_of_its_keyword_if_it_comes_first(tmp_path, step, force):
    joint = joint_of(tmp_path, deck(PRESS + PUSH, step))
    assert of_states(joint)["STEP 2"] == force


def test_an_amplitude_counts_at_the_end_of_its_step_and_its_load_stays(tmp_path):
    table = "*AMPLITUDE, NAME=RAMP\n0., 0., 2., 1.\n*AMPLITUDE, NAME=ALL, TIME=TOTAL TIME\n0., 0., 2., 1.\n"
    joint = joint_of(
        tmp_path,
        deck(
            PRESS,
            "*CLOAD, AMPLITUDE=RAMP\nNTOP, 1, 8.\n",
            "",
            "*CLOAD, AMPLITUDE=ALL\nNTOP, 1, 8.\n",
            more=table,
        ),
    )
    assert [force[0] for force in of_states(joint).values()] == [0, 12, 12, 24]


@pytest.mark.parametrize("time", ["STEP TIME", "TOTAL TIME"])
def test_a_delay_shifts_the_times_of_an_amplitude(tmp_path, time):
    """As CalculiX 2.20: the table gives 1 at 0.5, so a load with a delay of 0.25 has 1 at 0.75."""
    table = f"*AMPLITUDE, NAME=W, TIME={time}\n0., 0., .5, 1., 1., 0.\n"
    late = "*CLOAD, AMPLITUDE=W, TIME DELAY=.25\nNTOP, 1, 8.\n"
    forces = of_states(joint_of(tmp_path, deck(late, more=table)))
    assert forces == {"STEP 1@0.25": [0, 0], "STEP 1@0.75": [24, 0], "STEP 1": [12, 0]}
    late = late.replace(".25", "1.25")
    forces = of_states(joint_of(tmp_path, deck(PRESS, late, more=table)))
    first = {"STEP 1": [0, -40]}
    if time == "STEP TIME":
        assert forces == {**first, "STEP 2": [0, -40]}
    else:
        # 1.25 to 2.25 in total time: 1 at 1.75.
        later = {"STEP 2@0.25": [0, -40], "STEP 2@0.75": [24, -40], "STEP 2": [12, -40]}
        assert forces == {**first, **later}


def test_a_state_at_each_time_at_which_an_amplitude_has_a_value(tmp_path):
    """Loads without an amplitude grow, and fade, in proportion to the time of the step.

    A force of 8 on each of three nodes follows its table; a pressure goes from 10 to 5 on one of
    two elements, and from 5 on this one to 0 in the next step; a support moves back and forth.
    """
    table = "*AMPLITUDE, NAME=WAVE\n0., 0., .25, 1., .75, -1., 1., 0., 2., 0.\n"
    table += "*AMPLITUDE, NAME=ALL, TIME=TOTAL TIME\n0., 0., 1., 0., 1.5, 1., 2., 0.\n"
    joint = joint_of(
        tmp_path,
        deck(
            PRESS + "*CLOAD, AMPLITUDE=WAVE\nNTOP, 1, 8.\n",
            "*CLOAD, AMPLITUDE=ALL\nNTOP, 1, 8.\n*DLOAD\n3, P3, 5.\n",
            "*DLOAD, OP=NEW\n*CLOAD, AMPLITUDE=WAVE\nNTOP, 1, 8.\n",
            more=table,
        ),
    )
    assert of_states(joint) == {
        "STEP 1@0.25": [24, -10],
        "STEP 1@0.75": [-24, -30],
        "STEP 1": [0, -40],
        "STEP 2@0.5": [24, -35],
        "STEP 2": [0, -30],
        "STEP 3@0.25": [24, -22.5],
        "STEP 3@0.75": [-24, -7.5],
        "STEP 3": [0, 0],
    }
    cycle = joint.cycle("STEP 1", ["STEP 2@0.5,DLOAD ETOP P3=1"])
    assert set(cycle.corners[0]) >= {"CLOAD NTOP"}


def test_a_load_may_jump_at_the_beginning_of_its_step(tmp_path):
    table = "*AMPLITUDE, NAME=WAVE\n0., 0., .25, 1., 1., 0.\n"
    text = deck(PRESS + "*CLOAD, AMPLITUDE=WAVE\nNTOP, 1, 8.\n", more=table)
    joint = joint_of(tmp_path, text.replace("NLGEOM", "NLGEOM, AMPLITUDE=STEP"))
    assert of_states(joint)["STEP 1@0.25"] == [24, -40]


@pytest.mark.parametrize(
    ("line", "force"), [("0., 0.", 24), (",", 24), ("", 24), (", 2.", 48), (".5, 2.", 48)]
)
def test_a_step_lasts_1_unless_its_period_is_above_0(tmp_path, line, force):
    """As CalculiX 2.20: a force of 8 on three nodes, times its table, which grows in time."""
    more = "*AMPLITUDE, NAME=RAMP\n0., 0., 4., 4.\n"
    text = deck("*CLOAD, AMPLITUDE=RAMP\nNTOP, 1, 8.\n", more=more)
    joint = joint_of(tmp_path, text.replace("1., 1.\n*CLOAD", f"{line}\n*CLOAD"))
    assert of_states(joint) == {"STEP 1": [force, 0]}


def test_temperatures_and_displacements_within_a_step(tmp_path):
    """N = E alpha dT A and E u / h A between walls, without lateral strain; half of each."""
    table = "*AMPLITUDE, NAME=WAVE\n0., 0., .5, .5, 1., 1.\n"
    more = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 20.\n*BOUNDARY\nNTOP, 1, 2\n" + table
    more += "*INITIAL CONDITIONS, TYPE=VELOCITY\nNALL, 1, 5.\n"
    material = MATERIAL.replace("0.3", "0.0")
    for step, half, whole in (
        ("*TEMPERATURE\nNALL, 120.\n*BOUNDARY, AMPLITUDE=WAVE\nNTOP, 2, 2, 0.\n", -20, -40),
        ("*TEMPERATURE, AMPLITUDE=WAVE\nNALL, 120.\n", -16, -40),
        ("*BOUNDARY, AMPLITUDE=WAVE\nNTOP, 2, 2, -.02\n", -20, -40),
    ):
        joint = joint_of(tmp_path, deck(step, more=more, material=material))
        forces = of_states(joint)
        assert forces["STEP 1@0.5"] == pytest.approx([0, half], abs=1e-9)
        assert forces["STEP 1"] == pytest.approx([0, whole], abs=1e-9)


def test_measured_amplitudes_are_no_corners(tmp_path):
    table = ", ".join(f"{k / 200}, {k % 2}" for k in range(201))
    more = f"*AMPLITUDE, NAME=WAVE\n{table}\n"
    joint = joint_of(tmp_path, deck(PRESS + "*CLOAD, AMPLITUDE=WAVE\nNTOP, 1, 8.\n", more=more))
    assert list(joint.states) == ["STEP 1"]
    assert "STEP 1: states at 199 times of its amplitudes" in joint.left_out


def test_pairs_that_come_and_go(tmp_path):
    """The model has the pairs and the friction of the last step, and so have its states."""
    off = "*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nSLOW, SHIGH\n"
    on = "*MODEL CHANGE, TYPE=CONTACT PAIR, ADD\nSLOW, SHIGH\n"
    joint = joint_of(tmp_path, deck(off + PRESS, on, PUSH))
    assert joint.unlike == ["STEP 1"]
    assert of_states(joint)["STEP 3"] == [24, -40]
    with pytest.raises(fo.ModelError, match="'STEP 1' has other supports, contact pairs or fri"):
        joint.cycle("STEP 1", ["STEP 3"])
    assert len(joint.cycle("STEP 2", ["STEP 3"]).corners) == 1
    with pytest.raises(fo.ModelError, match=r"MODELCHANGE .*no \*CONTACT PAIR has the surfaces"):
        joint_of(tmp_path, deck(PRESS + off.replace("SLOW", "STOP")))
    with pytest.raises(fo.ModelError, match=r"MODELCHANGE TYPE=ELEMENT"):
        joint_of(tmp_path, deck(PRESS + "*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nBASE\n"))
    with pytest.raises(
        fo.ModelError, match=r"no \*CONTACT PAIR that may slide is in force at the end"
    ):
        joint_of(tmp_path, deck(PRESS + off))


def test_friction_that_changes_is_that_of_the_last_step(tmp_path):
    change = "*CHANGE FRICTION, INTERACTION=DRY\n*FRICTION\n.25, 1.E6\n"
    joint = joint_of(tmp_path, deck(PRESS, change, PUSH))
    assert joint.friction == {"SLOW-SHIGH": 0.25} and joint.unlike == ["STEP 1"]
    cycle = joint.cycle("STEP 2", ["STEP 3"])
    found = fo.gross_slip(joint.system(), cycle, joint.friction)
    assert found.load_factor == pytest.approx(0.25 * 40 / 24, rel=1e-6)
    with pytest.raises(fo.ModelError, match=r"CHANGEFRICTION INTERACTION=WET: 'WET' is not in"):
        joint_of(tmp_path, deck(PRESS, change.replace("DRY", "WET")))


def test_supports_that_live_in_steps(tmp_path):
    """PrePoMax writes empty blocks with OP=NEW in each step, and repeats all."""
    new = "*BOUNDARY, OP=NEW\n*BOUNDARY\nNbase, 1, 3, 0\n*CLOAD, OP=NEW\n*DLOAD, OP=NEW\n"
    joint = joint_of(tmp_path, deck(new + PRESS, new + PRESS + PUSH, held=""))
    assert of_states(joint) == {"STEP 1": [0, -40], "STEP 2": [24, -40]}
    cycle = joint.cycle("STEP 1", ["STEP 2", "step 2,CLOAD NTOP=-2", "CLOAD NTOP=-1"])
    assert cycle.corners == ({"CLOAD NTOP": 1.0}, {"CLOAD NTOP": -1.0}, {"CLOAD NTOP": -1.0})


def test_bare_nodes_of_a_block_are_one_load_case(tmp_path):
    """FreeCAD writes each node."""
    joint = joint_of(tmp_path, deck(PRESS + "*CLOAD\n10,1,1.5\n11,1,3.0\n12,1,1.5\n"))
    assert list(joint.states["STEP 1"]) == ["DLOAD ETOP P3", "CLOAD (STEP 1)"]
    assert of_states(joint)["STEP 1"] == [6, -40]


def test_a_step_may_have_a_name_and_one_that_is_not_static_is_left_out(tmp_path):
    text = deck(PRESS).replace("*STEP, NLGEOM", "*STEP, NAME=Tighten")
    text += "*STEP\n*FREQUENCY\n3\n*END STEP\n*STEP, PERTURBATION\n*STATIC\n*END STEP\n"
    joint = joint_of(tmp_path, text)
    assert list(joint.states) == ["TIGHTEN"]
    assert [text for text in joint.left_out if "STEP" in text] == [
        "STEP 2: no *STATIC, or a PERTURBATION",
        "STEP 3: no *STATIC, or a PERTURBATION",
    ]
    assert joint.cycle("Tighten", ["DLOAD ETOP P3=0.5"]).mean == {"DLOAD ETOP P3": 1.0}


def test_states_with_other_supports_are_not_in_one_cycle(tmp_path):
    more = "*BOUNDARY\nNTOP, 1, 1\n"
    joint = joint_of(tmp_path, deck(PRESS, more + "*CLOAD\nNTOP, 2, -1.\n"))
    with pytest.raises(
        Exception, match="state 'STEP 1' has other supports, contact pairs or friction"
    ):
        joint.cycle("STEP 1", ["STEP 2"])


def test_a_displacement_moves_its_nodes_as_supports(tmp_path):
    """The slider is pushed down by .01 on its whole top: stress of a confined block, by hand.

    With nodes held across, strain is one: sigma = E (1 - nu) / ((1 + nu) (1 - 2 nu)) .01 / 2.
    """
    hold = HELD + "*BOUNDARY\nNALL, 1, 1\n"
    joint = joint_of(tmp_path, deck("*BOUNDARY\nNTOP, 2, 2, -0.01\n", kind="CPE4", held=hold))
    stress = 1000 * 0.7 / (1.3 * 0.4) * 0.01 / 2
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -stress * 4], abs=1e-9)
    # CalculiX 2.20 also moves nodes by a block before the first step.
    more = "*BOUNDARY\nNTOP, 2, 2, -0.01\n"
    joint = joint_of(tmp_path, deck("", kind="CPE4", held=hold, more=more))
    assert of_states(joint)["STEP 1"] == pytest.approx([0, -stress * 4], abs=1e-9)


def test_a_locked_bolt_keeps_its_tension_when_all_forces_are_given_anew():
    """PrePoMax removes all conditions in each step, and then holds the length of the bolt."""
    joint = fo.read_joint(Path(__file__).parents[2] / "docs" / "tutorial" / "clamp.inp")
    assert joint.states == {
        "STEP 1": {"BOLT SECTION": 1.0},
        "STEP 2": {"BOLT SECTION": 1.0, "CLOAD LOADED": 1.0},
        "STEP 3": {"BOLT SECTION": 1.0, "CLOAD LOADED": -1.0},
    }
    assert joint.locked == ["STEP 2", "STEP 3"]
    (bolt,) = joint.model.loads["BOLT SECTION"]
    assert bolt.force == 20e3 and bolt.locked
