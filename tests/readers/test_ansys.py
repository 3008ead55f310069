"""The stiffness of Ansys.

The files come with its reader: matrix and mesh, written by Ansys, of a clamped bar of 1 x 1 x 5.
"""

import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from ansys.mapdl.reader import examples

import frictopt as fo

FULL, DECK = examples.fullfile, examples.hexarchivefile


@pytest.fixture(scope="module")
def bar():
    return fo.readers.read_ansys(FULL, deck=DECK)


def forces(job, u):
    """Nodal forces (nodes, 3) that displacements (nodes, 3) need."""
    v = np.zeros(len(job.labels))
    found = np.zeros(u.shape)
    free = job.unknowns >= 0
    v[job.unknowns[free]] = u[free]
    found[free] = (job.K @ v)[job.unknowns[free]]
    return found


def test_rigid_motions_and_uniform_tension_need_no_forces_inside(bar):
    """Elements that pass the patch test behave so. With E = 16.9e6 and nu = 0.31 only the end
    carries a force, E times strain."""
    x, y, z = bar.points.T
    off, end, size = z > 0.51, z == 5, abs(bar.K).max()  # a row of elements away from the clamp
    for u in (
        np.eye(3)[[0] * 321],
        np.column_stack([y, -x, 0 * z]),
        np.column_stack([0 * x, z, -y]),
    ):
        assert np.abs(forces(bar, u)[off]).max() < 1e-12 * size
    pulled = forces(bar, np.column_stack([-0.31 * x, -0.31 * y, z]))
    assert np.abs(pulled[off & ~end]).max() < 1e-12 * size
    assert np.allclose(pulled[end].sum(axis=0), [0, 0, 16.9e6], rtol=1e-9, atol=1.0)


def test_the_bar_on_rigid_ground_against_dense_algebra(bar):
    """Corners of the elements at the free end stand on the ground."""
    face = np.flatnonzero(
        (bar.points[:, 2] == 5) & np.isin(bar.points[:, :2], [0, 0.5, 1]).all(axis=1)
    )[::-1]
    pairs = np.column_stack([face, len(bar.points) + np.arange(len(face))])
    points = np.vstack([bar.points, bar.points[face]])
    unknowns = np.vstack([bar.unknowns, np.full((len(face), 3), -1)])
    load = np.random.default_rng(0).normal(size=len(bar.labels))
    system = fo.condense(bar.K, {"a": load}, pairs, [0, 0, -1], unknowns, points)
    K = bar.K.toarray()
    kept = np.concatenate([bar.unknowns[face, 0], bar.unknowns[face, 1], bar.unknowns[face, 2]])
    rest = np.setdiff1d(np.arange(len(K)), kept)
    # Normal -z: the tangents are x and -y.
    turn = np.kron(np.diag([1.0, -1.0, -1.0]), np.eye(len(face)))
    S = (
        turn
        @ (
            K[np.ix_(kept, kept)]
            - K[np.ix_(kept, rest)] @ np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, kept)])
        )
        @ turn
    )
    assert np.abs(system.S - S).max() < 1e-11 * np.abs(S).max()


def edited(path, place, value):
    """The matrix file with another number at a place of its header.

    The header begins at the 105th integer.
    """
    content = np.fromfile(FULL, dtype=np.int32)
    content[105 + place] = value
    content.tofile(path)


def test_other_files_are_refused(tmp_path, bar):
    (tmp_path / "bad.full").write_bytes(b"nothing")
    edited(tmp_path / "tied.full", 20, 5)
    edited(tmp_path / "warm.full", 7, 4)
    edited(tmp_path / "skew.full", 13, 1)
    (tmp_path / "part.cdb").write_text("nothing\n")
    text = Path(DECK).read_text()
    line = "        2        0        0 1.0000000000000E+000\n"
    assert line in text
    (tmp_path / "turned.cdb").write_text(
        text.replace(
            line, line[:-1] + "".join(f"{angle:21.13E}" for angle in (0, 0, 0, 0, 30)) + "\n"
        )
    )
    bad = [
        ((tmp_path / "gone.full",), r"stiffness: there is no file '.*gone\.full'"),
        ((tmp_path / "bad.full",), r"stiffness: ansys-mapdl-reader cannot read '.*bad\.full'"),
        (
            (tmp_path / "skew.full",),
            r"stiffness: ansys-mapdl-reader cannot read '.*skew\.full'.*unsymmetric",
        ),
        (
            (tmp_path / "tied.full",),
            r"tied\.full has 5 constraint equations; give a model .* without CE and CP",
        ),
        ((tmp_path / "warm.full",), r"warm\.full has 4 unknowns at a node"),
        ((examples.rstfile,), r"file\.rst is no \.full file but a"),
        ((DECK,), r"cannot read .*HexBeam\.cdb"),
        ((FULL, tmp_path / "gone.cdb"), r"deck: there is no file '.*gone\.cdb'"),
        ((FULL, tmp_path / "part.cdb"), r"deck part\.cdb: no nodes or no elements"),
        ((FULL, tmp_path / "turned.cdb"), r"deck turned\.cdb: node 2 has directions of its own"),
    ]
    for (path, *deck), message in bad:
        with pytest.raises(fo.ModelError, match=message):
            fo.readers.read_ansys(path, deck=deck[0] if deck else None)


def test_without_the_reader_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ansys.mapdl.reader", None)
    with pytest.raises(
        fo.ModelError,
        match=r"ansys-mapdl-reader: not installed; python -m pip install 'frictopt\[ansys\]'",
    ):
        fo.readers.read_ansys(FULL)


def deck_of(folder, change):
    """The archive of the bar after a change of its text."""
    text = Path(DECK).read_text()
    (folder / "b.cdb").write_text(change(text))
    return fo.readers.read_ansys(FULL, deck=folder / "b.cdb")


def test_elements_in_two_blocks_are_refused(tmp_path):
    """The library keeps the elements of one block, so that half of the bar had no faces."""

    def cut(text):
        head, rest = text.split("EBLOCK,19,SOLID,        40,        40\n(19i10)\n")
        lines = rest.splitlines(keepends=True)
        block = "EBLOCK,19,SOLID,        40,        20\n(19i10)\n"
        return head + block + "".join(lines[:40]) + "        -1\n" + block + "".join(lines[40:])

    with pytest.raises(
        fo.ModelError, match=r"deck b\.cdb: 2 EBLOCK, of which one is read; give the archive"
    ):
        deck_of(tmp_path, cut)


@pytest.mark.parametrize("command", ["NROTAT,ALL", "nrot,all", "NMODIF,5,9.,9.,9.", "NDELE,5"])
def test_commands_that_change_nodes_after_their_block_are_refused(tmp_path, command):
    with pytest.raises(fo.ModelError, match=f"the command {command.split(',')[0].upper()}, after"):
        deck_of(tmp_path, lambda text: text.replace("EBLOCK,", f"{command}\nEBLOCK,"))


def test_a_cut_block_of_elements_is_refused(tmp_path):
    def cut(text):
        head, rest = text.split("(19i10)\n")
        return head + "(19i10)\n" + "".join(rest.splitlines(keepends=True)[:40]) + "        -1\n"

    with pytest.raises(fo.ModelError, match=r"deck b\.cdb: its EBLOCK is damaged, or names a type"):
        deck_of(tmp_path, cut)
    with pytest.raises(fo.ModelError, match=r"deck b\.cdb: its EBLOCK is damaged, or names a type"):
        deck_of(tmp_path, lambda text: text.replace("ET,        1,186", "ET,        2,186"))


def test_reading_from_threads_leaves_the_warnings_of_the_process_as_they_are():
    before = list(warnings.filters)
    with ThreadPoolExecutor(8) as pool:
        jobs = list(pool.map(fo.readers.read_ansys, [FULL] * 24))
    assert warnings.filters == before
    assert len({abs(job.K).sum() for job in jobs}) == 1
