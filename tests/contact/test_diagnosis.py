"""What the mean load does to a contact, in words, against enumeration of all sets of open nodes."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.diagnosis import counted, in_contact, open_nodes, pressing
from frictopt.transients.statics import mean_load_diagnosis
from helpers.systems import system, unit_nodes


def mean(**loads):
    return fo.LoadCycle(loads, [{}])


def pressed(p, q=0.0, B=None, gap=None):
    n = len(p)
    return system(
        np.eye(n), np.zeros((n, n)) if B is None else B, q, np.array(p), 0.0, 0.0, gap=gap
    )


def test_open_nodes_against_all_sets():
    rng = np.random.default_rng(0)
    sizes = set()
    for _ in range(100):
        G, p = rng.normal(size=(5, 5)), rng.normal(size=5) + 0.5
        C = G @ G.T + 0.05 * np.eye(5)
        found = open_nodes(system(np.eye(5), np.zeros((5, 5)), 0.0, p, 0.0, 0.0, C=C), p)
        for choice in product((False, True), repeat=5):
            opened, w = np.array(choice), np.zeros(5)
            w[opened] = np.linalg.solve(C[np.ix_(opened, opened)], -p[opened])
            if w.min() >= 0 and (p + C @ w).min() > -1e-9:
                break
        assert (found == opened).all()
        sizes.add(int(opened.sum()))
    assert len(sizes) >= 4


@pytest.mark.parametrize(
    ("contact", "cycle", "friction", "texts"),
    [
        (pressed([1.0, 1.0]), mean(mean=1.0), 0.5, ["presses all nodes and none slips"]),
        (pressed([1.0, 1.0]), mean(), 0.5, ["the mean load is zero"]),
        (pressed([1.0, 1.0]), mean(mean=0.0), 0.5, ["the mean load is zero"]),
        (pressed([1.0, 1.0]), mean(mean=-1.0), 0.5, ["compression must be positive", "sum to -2"]),
        (pressed([0.0, 0.0], q=1.0), mean(mean=1.0), 0.5, ["nothing presses the bodies together"]),
        (
            pressed([1.0, -0.5, 1.0]),
            mean(mean=1.0),
            0.5,
            ["1 of 3 nodes (x = 1)", "open under the mean load alone", "incomplete"],
        ),
        (pressed([1.0, 0.0, 1.0]), mean(mean=1.0), 0.5, ["1 of 3 nodes (x = 1) carry no pressure"]),
        (
            pressed([1.0, 1.0], gap=[0.0, 5.0]),
            mean(mean=1.0),
            0.5,
            ["1 of 2 nodes (x = 1)", "1 of them with an initial gap"],
        ),
        (
            pressed([1.0, 1.0], q=[0.6, 0.0]),
            mean(mean=1.0),
            0.5,
            ["1 of 2 nodes (x = 0) exceed their friction bound"],
        ),
        (
            pressed([1.0, 1.0], q=0.1),
            mean(mean=1.0),
            [0.0, 0.5],
            ["1 of 2 nodes (x = 0) have no friction"],
        ),
        (
            pressed([-1.0, 9.0, -1.0, -1.0, 9.0]),
            mean(mean=1.0),
            0.5,
            ["3 of 5 nodes (x = 0, 2 .. 3)"],
        ),
    ],
)
def test_each_fault_is_named(contact, cycle, friction, texts):
    diagnosis = mean_load_diagnosis(contact, cycle, friction)
    assert all(text in diagnosis for text in texts), diagnosis


def test_a_punch_that_slides_as_a_whole_is_named_where_nothing_holds_it(punch):
    contact = punch(16)
    P, Q = (float(contact.bonded[name][part].sum()) for name, part in (("P", 1), ("Q", 0)))
    for share, slides in ((1.01, True), (0.99, False)):
        loads = {"P": 1.0, "Q": share * 0.5 * P / abs(Q)}
        assert ("slides as a whole" in mean_load_diagnosis(contact, mean(**loads), 0.5)) == slides
        held = fo.ContactSystem.from_blocks(
            contact.A + np.eye(17), contact.B, contact.C, contact.x, contact.bonded
        )
        assert "slides as a whole" not in mean_load_diagnosis(held, mean(**loads), 0.5)


def test_a_shear_load_alone_does_not_press(punch):
    """Its normal reactions, of both signs, sum to zero but for rounding."""
    assert "does not press the bodies together" in mean_load_diagnosis(punch(16), mean(Q=1.0), 0.5)
    assert "does not press the bodies together" in mean_load_diagnosis(punch(16), mean(Q=-1.0), 0.5)


def test_the_forces_of_a_state_are_those_of_each_contact():
    contact = unit_nodes({"P": (np.zeros(4), np.ones(4))}, contact=["a", "a", "b", "b"])
    text = pressing(
        contact,
        np.full(4, 0.5),
        np.array([0.25, 0.5, 0.0, 1e-14]),
        np.array([1.0, 2.0, 0.0, -1e-15]),
        1.0,
    )
    assert text == (
        "contact 'a' has a normal force of 3 on 2 of 2 nodes and a shear force of 0.75, of at most f p = 1.5, "
        "contact 'b' has a normal force of 0 on 0 of 2 nodes and a shear force of 0, of at most f p = 0"
    )


def test_a_path_that_ends_names_the_forces_at_its_end_and_not_the_mean_load():
    """It does not name the mean load. A free body is pressed by 0.5 + 0.5 and then pulled: at 1 /
    1.1 of the way from 1 to -0.1 nothing presses it."""
    punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).condense()
    cycle = fo.LoadCycle({"P": 0.5}, [{"P": 0.5}, {"P": -0.6}])
    with pytest.raises(
        fo.NoContinuation,
        match=r"corner \(P = -0\.6\): at 0\.909090909 of it .* a normal force of 0 on 0 of 9 nodes",
    ) as ended:
        fo.steady_state(punch, cycle, 0.5, 1.0)
    assert "mean load" not in str(ended.value)
    with pytest.raises(
        fo.NoContinuation, match=r"a normal force of .* the mean load pulls the bodies apart"
    ):
        fo.steady_state(punch, fo.LoadCycle({"P": -0.5}, [{"P": -0.5}]), 0.5, 1.0)


def test_increments_that_end_at_a_slide_name_it_and_its_forces():
    """Only friction holds two nodes along x and y. They are pressed by 1 each, and pulled along
    (0.6, 0.8) by up to 0.75 each with f = 0.5. Where slip may change pressures, statics does not
    know them, and increments go as far as friction holds: up to 1 at both nodes.

    In `wedged`, slip along x changes the sum of the pressures. After the first of four increments
    the shear is 0.25 (-0.4, 1.6), within f p; no slide is proven for the second one."""
    loads = {"P": [0, 0, 0, 0, 1, 1], "Q": [0.6, 0.6, 0.8, 0.8, 0, 0]}
    apart = fo.ContactSystem(np.diag([0, 0, 0, 0, 1.0, 1.0]), [[0, 0, 0], [1, 0, 0]], loads)
    stretch = np.array([1.0, -1.0, 0.0, 0.0, 0.3, -0.3])
    free = fo.ContactSystem(apart.S + np.outer(stretch, stretch), apart.points, loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    slide_message = r"slides as a whole: the load at the corner \(Q = \+1\) has the shear force 1\.5 along \(-0\.6, -0\.8, 0\), above f P = 1;"
    with pytest.raises(fo.NoContinuation, match=slide_message):
        fo.march(apart, cycle, 0.5, 0.75, cycles=1, steps=4)
    increment_message = r"increment 3 of 4: .*slides as a whole: the load there has the shear force 1\.125 along .* above f P = 1;"
    with pytest.raises(fo.NoContinuation, match=increment_message):
        fo.march(free, cycle, 0.5, 0.75, cycles=1, steps=4)
    stretch = np.array([1.0, -1.0, 0.0, 0.0, -0.9, -0.9])
    pulls = {"P": loads["P"], "Q": [-0.4, 1.6, 0, 0, 0, 0]}
    wedged = fo.ContactSystem(apart.S + np.outer(stretch, stretch), apart.points, pulls)
    forces_message = r"increment 2 of 4: .* slide or open as a whole, .*: hold .*less \(there the contact has a normal force of 2 .* of 0\.3, of at most f p = 1"
    with pytest.raises(fo.SolverError, match=forces_message):
        fo.march(wedged, cycle, 0.5, 1.0, cycles=1, steps=4)
    held = fo.ContactSystem(free.S + np.eye(6), free.points, loads)
    assert fo.march(held, cycle, 0.5, 0.75, cycles=1, steps=4).slip.any()


def test_nodes_are_told_with_their_contacts_where_there_are_two():
    """The names are in a reason, in the message of a transient that ends, and in the tables."""
    loads = {"P": ([0.0] * 3, [1.0, 1.0, -1.0]), "Q": ([1.0, 0.0, 0.0], [0.0] * 3)}
    names = ["head", "nut", "nut"]
    joint = unit_nodes(loads, contact=names)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    friction = [0.0, 0.5, 0.5]
    assert counted(joint, np.array([True, False, True])) == "2 of 3 nodes (head 1 of 1, nut 1 of 2)"
    assert in_contact(joint, [2, 1]) == " (nut)"
    assert in_contact(replace(joint, contact=["nut"] * 3), 0) == ""
    reason = fo.shakedown_limit(joint, cycle, friction).reason
    assert reason.startswith("with 1 of 3 nodes open (nut 1 of 2): ")
    assert "node 0 (head) has no friction" in reason
    assert mean_load_diagnosis(joint, cycle, 0.5).startswith(
        "1 of 3 nodes (nut 1 of 2) are open under the mean load alone"
    )
    slider = fo.ContactSystem.from_blocks(
        np.diag([0.0, 1.0]),
        np.zeros((2, 2)),
        np.eye(2),
        [0, 1],
        {"P": ([0, 0], [1, 1]), "Q": ([1, 0], [0, 0])},
    )
    with pytest.raises(fo.NoContinuation, match=r"nodes \[0\] \(head\)"):
        fo.steady_state(
            replace(slider, contact=["head", "nut"]),
            fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]),
            0.5,
            1.0,
        )
    steady = fo.steady_state(joint, cycle, 0.5, 0.1)
    assert steady.to_frame()["contact"].tolist() == names
    assert steady.states().to_frame()["contact"].tolist()[:3] == names
