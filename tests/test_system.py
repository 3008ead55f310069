import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import mmwrite
from scipy.sparse import csr_matrix

import frictopt as fo
from systems import random_system

ONE = np.eye(2)
GOOD = {"A": ONE, "B": 0 * ONE, "C": ONE, "x": [0.0, 1.0], "bonded": {"P": ([0.0, 0.0], [1.0, 1.0])}}
BAD = {
    "A: value nan at index (0, 0)": {"A": np.diag([np.nan, 1.0])},
    "C: value inf": {"C": np.diag([1.0, np.inf])},
    "B: complex numbers": {"B": 1j * ONE},
    "A: shape (2, 3), expected (2, 2)": {"A": np.ones((2, 3))},
    "A: rows of different lengths": {"A": [[1.0], [1.0, 2.0]]},
    "A: list of dtype <U1 is not numeric": {"A": [["a", "b"], ["c", "d"]]},
    "A: not symmetric, A[0, 1] = 0.5": {"A": ONE + [[0, 0.5], [0, 0]]},
    "C: not symmetric": {"C": ONE + [[0, 0.5], [0, 0]]},
    "negative eigenvalue -1": {"A": -ONE},
    "A, B, C: S": {"B": 2 * ONE},
    "x: x[1] = 0 does not exceed x[0] = 1": {"x": [1.0, 0.0]},
    "x: no nodes": {"x": []},
    "x: shape": {"x": [[0.0, 1.0]]},
    "gap: -0.1 at node 1": {"gap": [0.0, -0.1]},
    "gap: shape (3,)": {"gap": [0.0, 0.0, 0.0]},
    "bonded: no load case": {"bonded": {}},
    "bonded: a list": {"bonded": [1]},
    "bonded['P']: not a pair": {"bonded": {"P": 3.0}},
    "bonded['P'] p: shape (1,)": {"bonded": {"P": ([0.0, 0.0], [1.0])}},
    "bonded['P'] q: value nan": {"bonded": {"P": ([np.nan, 0.0], [1.0, 1.0])}},
    "A: a masked array": {"A": np.ma.masked_array(ONE, mask=ONE > 2)},
    "A: a sparse csr_matrix; give a dense array": {"A": csr_matrix(ONE)},
    "A: value 1e+200 at index (0, 0)": {"A": 1e200 * ONE},
    "load case name 'a\\x00b'": {"bonded": {"a\0b": ([0.0, 0.0], [1.0, 1.0])}},
    "load case name 3": {"bonded": {3: ([0.0, 0.0], [1.0, 1.0])}},
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_refused_by_name_and_value(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.ContactSystem(**{**GOOD, **BAD[message]})


def test_rounding_asymmetry_is_removed_and_arrays_are_read_only():
    system = fo.ContactSystem(**{**GOOD, "A": [[2.0, 1.0 + 1e-13], [1.0, 2.0]]})
    assert np.array_equal(system.A, system.A.T)
    with pytest.raises(ValueError, match="read-only"):
        system.A[0, 0] = 1.0
    with pytest.raises(TypeError):
        system.bonded["Q"] = 1
    with pytest.raises(AttributeError):
        system.A = ONE


def test_the_caller_keeps_his_arrays():
    A = np.eye(2)
    system = fo.ContactSystem(**{**GOOD, "A": A})
    A[0, 0] = 7.0
    assert system.A[0, 0] == 1.0


def test_a_free_punch_is_accepted_in_any_units():
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    for scale in (1e-15, 1.0, 1e15):
        assert fo.ContactSystem(**{**GOOD, "A": scale * A, "C": scale * ONE}).nodes == 2


@settings(max_examples=30, deadline=None)
@given(nodes=st.integers(1, 6), seed=st.integers(0, 10**6), scale=st.sampled_from([1e-12, 1.0, 1e12]), with_gap=st.booleans())
def test_saved_systems_come_back_bit_by_bit(tmp_path_factory, nodes, seed, scale, with_gap):
    rng = np.random.default_rng(seed)
    system = random_system(rng, nodes)
    system = fo.ContactSystem(
        scale * system.A, scale * system.B, scale * system.C, system.x, dict(system.bonded), rng.random(nodes) if with_gap else None
    )
    path = tmp_path_factory.mktemp("npz") / "a system"
    system.save(path)
    again = fo.ContactSystem.load(path)
    for name in ("A", "B", "C", "x", "gap"):
        assert np.array_equal(getattr(system, name), getattr(again, name))
    assert {k: [list(a) for a in v] for k, v in system.bonded.items()} == {k: [list(a) for a in v] for k, v in again.bonded.items()}


def test_matrix_market_folder_dense_sparse_and_symmetric(tmp_path):
    system = random_system(np.random.default_rng(1), 3)
    mmwrite(tmp_path / "A.mtx", system.A, symmetry="symmetric")
    mmwrite(tmp_path / "B.mtx", csr_matrix(system.B))
    mmwrite(tmp_path / "C.mtx", system.C)
    mmwrite(tmp_path / "x.mtx", system.x[:, None])
    mmwrite(tmp_path / "gap.mtx", np.full((3, 1), 0.5))
    for name, pair in system.bonded.items():
        mmwrite(tmp_path / f"bonded.{name}.mtx", np.column_stack(pair))
    again = fo.ContactSystem.load(tmp_path)
    assert np.allclose(again.S, system.S, rtol=1e-14, atol=0)
    assert np.allclose(again.gap, 0.5) and set(again.bonded) == {"mean", "cyclic"}


def test_files_that_cannot_be_written_or_named_are_refused(tmp_path):
    system = random_system(np.random.default_rng(1), 2)
    for path in (tmp_path / "no folder" / "a.npz", tmp_path, "a\0b", None, 3):
        with pytest.raises(fo.ModelError, match="path"):
            system.save(path)
        with pytest.raises(fo.ModelError, match="path"):
            fo.ContactSystem.load(path)


def test_matrix_market_files_that_mean_nothing_are_refused(tmp_path):
    for name in ("A", "B", "C", "x", "bonded.P", "bonded_Q"):
        mmwrite(tmp_path / f"{name}.mtx", np.eye(2))
    with pytest.raises(fo.ModelError, match=r"holds bonded_Q, which mean nothing here; load cases are called bonded\.NAME"):
        fo.ContactSystem.load(tmp_path)


def test_foreign_files_are_refused(tmp_path):
    text, foreign, pickled, folder = tmp_path / "a.npz", tmp_path / "b.npz", tmp_path / "c.npz", tmp_path / "folder"
    text.write_text("not an archive")
    np.savez(foreign, A=np.eye(2))
    np.savez(pickled, A=np.array([{}], dtype=object))
    folder.mkdir()
    for path, message in {
        text: "not a contact system",
        foreign: "not a contact system",
        pickled: "not a contact system",
        folder: "has no A, B, C, x",
        tmp_path / "none": "does not exist",
    }.items():
        with pytest.raises(fo.ModelError, match=message):
            fo.ContactSystem.load(path)
    (folder / "A.mtx").write_text("rubbish")
    with pytest.raises(fo.ModelError, match="not a Matrix Market file"):
        fo.ContactSystem.load(folder)


def test_a_truncated_archive_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    fo.ContactSystem(**GOOD).save(path)
    whole = path.read_bytes()
    for length in (0, 10, len(whole) // 2, len(whole) - 30):
        path.write_bytes(whole[:length])
        with pytest.raises(fo.ModelError, match="not a contact system"):
            fo.ContactSystem.load(path)


def test_reactions_are_linear_in_the_loads_and_unknown_cases_are_refused():
    system = random_system(np.random.default_rng(2), 4)
    (qa, pa), (qb, pb) = system.bonded["mean"], system.bonded["cyclic"]
    q, p = system.reaction({"mean": 2.0, "cyclic": -3.0})
    assert np.allclose(q, 2 * qa - 3 * qb) and np.allclose(p, 2 * pa - 3 * pb)
    for loads in (None, {"mean": np.nan}, {"mean": 1j}, {"mean": 10**400}):
        with pytest.raises(fo.ModelError, match="loads"):
            system.reaction(loads)
    with pytest.raises(fo.ModelError, match=r"load case 'sigma': unknown; this system has \['cyclic', 'mean'\]"):
        system.reaction({"sigma": 1.0})


def test_closing_the_gap_pushes_back():
    system = random_system(np.random.default_rng(3), 4)
    gap = np.array([0.0, 0.1, 0.2, 0.0])
    q, p = system.with_gap(gap).closed_reaction({"mean": 1.0})
    r = np.r_[system.bonded["mean"]] + system.S @ np.r_[np.zeros(4), -gap]
    assert np.allclose(np.r_[q, p], r)


def test_the_contact_modulus_is_kept_copied_saved_and_checked(tmp_path):
    contact = random_system(np.random.default_rng(0), 2)
    assert contact.E_star is None
    known = replace(contact, E_star=3)
    assert known.with_gap([0, 0.1]).E_star == 3.0
    known.save(tmp_path / "known.npz")
    assert fo.ContactSystem.load(tmp_path / "known.npz").E_star == 3.0
    assert pickle.loads(pickle.dumps(known)).E_star == 3.0
    with pytest.raises(fo.ModelError, match="E_star: 0"):
        replace(contact, E_star=0)


def test_a_condensed_scene_knows_its_contact_modulus():
    bodies = fo.Material(E=210.0, nu=0.3), fo.Material(E=70.0, nu=0.33)
    scene = fo.PunchOnHalfPlane(elements=4, punch_material=bodies[0], block_material=bodies[1])
    assert scene.condense().E_star == pytest.approx(fo.reference.contact_modulus(210.0, 0.3, 70.0, 0.33), rel=1e-14)


@pytest.mark.parametrize("modulus", [np.array("x"), np.array("12"), np.array(1j), np.array(True), np.zeros(1, dtype=[("a", float)])])
def test_a_contact_modulus_in_a_file_that_is_no_number_is_refused_by_name(tmp_path, modulus):
    contact = fo.ContactSystem([[1.0]], [[0.0]], [[1.0]], [0], {"P": ([0.0], [1.0])})
    contact.save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as archive:
        np.savez(tmp_path / "b.npz", **archive, E_star=modulus)
    with pytest.raises(fo.ModelError, match=r"path: E_star of .*b\.npz"):
        fo.ContactSystem.load(tmp_path / "b.npz")


def test_a_matrix_market_file_too_large_for_memory_is_refused_by_name(tmp_path):
    (tmp_path / "A.mtx").write_text("%%MatrixMarket matrix coordinate real general\n1000000000 1000000000 1\n1 1 1.0\n")
    with pytest.raises(fo.ModelError, match=r"A\.mtx.* is not a Matrix Market file that fits in memory"):
        fo.ContactSystem.load(tmp_path)
