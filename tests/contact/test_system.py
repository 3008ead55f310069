import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.components import joined, parted
from helpers.spatial import random_contact
from helpers.systems import random_system

ONE = np.eye(2)
GOOD = {
    "A": ONE,
    "B": 0 * ONE,
    "C": ONE,
    "x": [0.0, 1.0],
    "bonded": {"P": ([0.0, 0.0], [1.0, 1.0])},
}
BAD = {
    "A: not symmetric, A[0, 1] = 0.5": {"A": ONE + [[0, 0.5], [0, 0]]},
    "float32 has 7": {"A": -ONE},
    "negative eigenvalue -1": {"A": -ONE},
    "S has the negative eigenvalue": {"B": 2 * ONE},
    "x: x[1] = 0 does not exceed x[0] = 1": {"x": [1.0, 0.0]},
    "x: no nodes": {"x": []},
    "gap: -0.1 at node 1": {"gap": [0.0, -0.1]},
    "bonded: no load case": {"bonded": {}},
    "bonded['P'] p: shape (1,)": {"bonded": {"P": ([0.0, 0.0], [1.0])}},
    "load case name 'a\\x00b'": {"bonded": {"a\0b": ([0.0, 0.0], [1.0, 1.0])}},
    "load case name 3": {"bonded": {3: ([0.0, 0.0], [1.0, 1.0])}},
    "contact: 1 name for 2 nodes": {"contact": ["one"]},
    "contact of node 1: 3; give a printable text": {"contact": ["one", 3]},
    "width: -1 at node 1; give the length or area that the node collects, > 0": {
        "width": [1.0, -1.0]
    },
}
PLACED = {
    "points": [[0, 0], [0, 1]],
    "frames": [[[0, -1], [1, 0]], [[0.8, -0.6], [0.6, 0.8]]],
    "contact": ["left", "right"],
    "width": [1.0, 2.0],
}
PLACES = ["point_x", "point_y", "normal_x", "normal_y"]
STATED = {"S": np.eye(4), "points": [[0.0, 0.0], [1.0, 0.0]], "bonded": {"P": [0.0, 0.0, 1.0, 1.0]}}
BAD_STATED = {
    "points: shape (2,), expected": {"points": [0.0, 1.0]},
    "points: shape (2, 4); give (N, 2) in the plane or (N, 3) in space": {
        "points": np.zeros((2, 4))
    },
    "points: no nodes": {"points": np.zeros((0, 2))},
    "S: shape (4, 4), expected (6, 6)": {"points": np.zeros((2, 3))},
    "S: not symmetric, S[0, 1] = 1": {"S": np.eye(4) + np.eye(4, k=1)},
    "frames: the directions of node 1 are not orthonormal": {"frames": [np.eye(2), 2 * np.eye(2)]},
    "bonded['P']: shape (3,), expected (4,)": {"bonded": {"P": [0.0, 0.0, 1.0]}},
    "x: x[1] = 0 does not exceed x[0] = 1": {"points": [[1.0, 0.0], [0.0, 0.0]]},
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_refused_by_name_and_value(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.ContactSystem.from_blocks(**{**GOOD, **BAD[message]})


@pytest.mark.parametrize("message", BAD_STATED)
def test_bad_matrices_points_and_frames_are_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.ContactSystem(**{**STATED, **BAD_STATED[message]})


@pytest.mark.parametrize(("nodes", "mixed"), [(130, True), (300, True), (300, False)])
def test_a_stiffness_of_many_nodes_is_refused_by_its_lowest_eigenvalue(nodes, mixed):
    """The eigenvalues are 1, but for two far nodes, which have 1 + c and 1 - c. A reflection turns
    the matrix: it fills it and keeps its eigenvalues."""
    normal = np.ones(2 * nodes) / np.sqrt(2 * nodes)
    turn = np.eye(2 * nodes) - 2 * np.outer(normal, normal) * mixed
    points = np.column_stack([np.arange(nodes), np.zeros(nodes)])
    for coupling, lawful in ((1.0 - 1e-9, True), (1.0, True), (1.0 + 1e-6, False)):
        S = np.eye(2 * nodes)
        S[[1, -2], [-2, 1]] = coupling
        if lawful:
            fo.ContactSystem(turn @ S @ turn, points, {"P": np.ones(2 * nodes)})
        else:
            with pytest.raises(fo.ModelError, match=r"S has the negative eigenvalue -1e-06"):
                fo.ContactSystem(turn @ S @ turn, points, {"P": np.ones(2 * nodes)})


def test_reactions_may_be_given_as_a_pair_or_in_the_order_of_the_stiffness():
    for points, shape in (([[0, 0], [1, 0]], (2,)), ([[0, 0, 0], [1, 0, 0]], (2, 2))):
        size = 2 * len(points[0])
        r = np.arange(1.0, size + 1)
        q = r[:-2] if shape == (2,) else np.column_stack([r[:2], r[2:4]])
        one, other = (
            fo.ContactSystem(np.eye(size), points, {"P": reactions})
            for reactions in (r, (q, r[-2:]))
        )
        for system in (one, other):
            assert np.array_equal(system.bonded["P"][0], q)
            assert np.array_equal(joined(*system.bonded["P"]), r)
            assert system.slip_shape == shape and np.array_equal(parted(r, len(points[0]))[0], q)


def test_the_blocks_of_a_stiffness_are_its_parts_in_plane_and_space():
    for axes in (2, 3):
        G = np.random.default_rng(axes).normal(size=(3 * axes, 3 * axes))
        points = np.column_stack([np.arange(3.0), np.zeros((3, axes - 1))])
        system = fo.ContactSystem(S := G @ G.T, points, {"P": np.ones(3 * axes)})
        assert np.allclose(np.block([[system.A, system.B.T], [system.B, system.C]]), S)
        assert system.C.shape == (3, 3)


def test_a_contact_in_space_has_no_arc_length():
    with pytest.raises(fo.ModelError, match="no arc length"):
        _ = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1]}).x


def test_rounding_asymmetry_is_removed_and_arrays_are_read_only():
    A = np.array([[2.0, 1.0 + 1e-13], [1.0, 2.0]])
    system = fo.ContactSystem.from_blocks(**{**GOOD, "A": A})
    A[0, 0] = 7.0  # the caller keeps his
    assert np.array_equal(system.A, system.A.T) and system.A[0, 0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        system.A[0, 0] = 1.0
    with pytest.raises(TypeError):
        system.bonded["Q"] = 1
    with pytest.raises(AttributeError):
        system.A = ONE


@pytest.mark.parametrize("make", [random_system, random_contact])
def test_reactions_are_linear_in_the_loads_and_closing_the_gap_pushes_back(make):
    system = make(np.random.default_rng(2), 4)
    one, other, *_ = system.bonded
    r = 2 * joined(*system.bonded[one]) - 3 * joined(*system.bonded[other])
    assert np.allclose(joined(*system.reaction({one: 2.0, other: -3.0})), r)
    gap = np.array([0.0, 0.1, 0.2, 0.0])
    closed = joined(*system.with_gap(gap).closed_reaction({one: 2.0, other: -3.0}))
    assert np.allclose(closed, r - system.S[:, -4:] @ gap, atol=1e-14)
    with pytest.raises(fo.ModelError, match=r"load case 'sigma': unknown; this system has \['"):
        system.reaction({"sigma": 1.0})


def test_load_cases_are_added_and_replaced():
    again = fo.ContactSystem.from_blocks(**GOOD).with_bonded(
        {"P": ([1, 2], [3, 4]), "Q": ([5, 6], [7, 8])}
    )
    assert again.bonded["P"][1].tolist() == [3, 4] and again.bonded["Q"][0].tolist() == [5, 6]


def test_the_contact_modulus_is_kept_copied_and_checked():
    contact = random_system(np.random.default_rng(0), 2)
    assert contact.E_star is None
    known = replace(contact, E_star=3)
    assert known.with_gap([0, 0.1]).E_star == 3.0
    assert pickle.loads(pickle.dumps(known)).E_star == 3.0
    with pytest.raises(fo.ModelError, match="E_star: 0"):
        replace(contact, E_star=0)


def test_a_condensed_scene_knows_its_contact_modulus():
    bodies = fo.fem.Material(E=210.0, nu=0.3), fo.fem.Material(E=70.0, nu=0.33)
    scene = fo.scenes.PunchOnHalfPlane(
        elements=4, punch_material=bodies[0], block_material=bodies[1]
    )
    exact = 1 / ((1 - 0.3**2) / 210.0 + (1 - 0.33**2) / 70.0)
    assert scene.condense().E_star == pytest.approx(exact, rel=1e-14)


def test_points_normals_names_and_widths_are_kept_shown_and_read_only():
    plain = fo.ContactSystem.from_blocks(**GOOD)
    placed = replace(plain, **PLACED)
    for name, values in PLACED.items():
        assert getattr(placed, name).tolist() == values
        assert getattr(placed.with_gap([0, 0.1]), name).tolist() == values
        assert getattr(pickle.loads(pickle.dumps(placed)), name).tolist() == values
        with pytest.raises(ValueError, match="read-only"):
            getattr(placed, name)[0] = getattr(placed, name)[1]
    assert (
        repr(placed)
        == "ContactSystem(nodes=2, x=0 .. 1, contacts=['left', 'right'], loads=['P'], gap=False)"
    )
    assert repr(plain) == "ContactSystem(nodes=2, x=0 .. 1, loads=['P'], gap=False)"
    assert plain.contact is None
    assert plain.width is None
    assert list(plain.to_frame()) == ["node", "x", "gap", *PLACES]
    table = placed.to_frame()
    assert list(table) == ["node", "x", "gap", "contact", *PLACES, "width"]
    assert table["normal_y"].tolist() == [0.0, 0.8]
    assert table["contact"].tolist() == ["left", "right"]
    with pytest.raises(fo.ModelError, match="contact: 'a' begins again at node 2"):
        replace(random_system(np.random.default_rng(0), 3), contact=["a", "b", "a"])
