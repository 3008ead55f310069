"""One joint through every reader of matrices.

CalculiX, pyNastran and pyyeti wrote some of the files; the test writes others in the format that
Abaqus documents.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pyyeti.nastran import bulk, op4
from scipy.sparse import triu

import frictopt as fo
from helpers import joint
from helpers.calculix import Block, lines, node_set, run
from helpers.refused import refused

DATA = Path(__file__).parents[1] / "data"
K, LABELS = joint.stiffness()


@pytest.fixture(scope="module")
def limit():
    """From the matrix that scikit-fem assembles."""
    return joint.limit(fo.readers.MatrixJob(K, LABELS, joint.POINTS))


def agrees(job, limit):
    """The job has the same matrix by its labels, and the same limit."""
    row = {tuple(label): i for i, label in enumerate(job.labels.tolist())}
    order = [row[tuple(label)] for label in LABELS.tolist()]
    assert len(row) == len(LABELS) + len(job.generalised)
    assert abs(job.K[order][:, order] - K).max() < 1e-9 * K.max()
    assert joint.limit(job) == pytest.approx(limit, rel=1e-9)


@pytest.fixture
def deck(tmp_path):
    (tmp_path / "deck.inp").write_text(joint.DECK)
    return tmp_path / "deck.inp"


@pytest.mark.ccx
def test_the_substructure_of_calculix_is_not_reduced(tmp_path, deck, limit):
    """It has the rows of the whole stiffness. The whole stiffness of the same deck is read and
    reduced, as the error recommends."""
    beside = Block(901, lines((9, 10, 2), (0, 1, 2), (0, 1, 2)), 1.0, 0.0, "BESIDE")
    held = node_set("FOOT", beside.on(2, 0)) + "*BOUNDARY\nFOOT, 1, 3\n"
    step = "*SUBSTRUCTURE GENERATE\n*RETAINED NODAL DOFS, SORTED=NO\nFREE, 1, 3\n*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, FILE NAME=reduced\n"
    run(tmp_path, joint.DECK + beside.deck() + held, step)
    with pytest.raises(
        fo.ModelError,
        match=r"reduced\.mtx is by CalculiX, .*SOLVER=MATRIXSTORAGE, and read it with read_calculix",
    ):
        fo.readers.read_abaqus(tmp_path / "reduced.mtx", deck=deck)
    agrees(fo.readers.read_calculix(run(tmp_path, joint.DECK)[0]), limit)


def element(K, nodes, directions, *, unlike=()):
    """A user element in the format of Abaqus.

    It has four entries a line, and each row of the triangle begins a new line. `directions` holds
    the directions of each node, with a line for the first node and wherever they change.
    """
    lines = [
        "**",
        "** GENERATION OF SUBSTRUCTURE Z1",
        f"*USER ELEMENT, NODES= {len(nodes)}, LINEAR",
        "** ELEMENT NODES",
    ]
    lines += [
        "** " + ", ".join(map(str, nodes[i : i + 10])) + ("," if i + 10 < len(nodes) else "")
        for i in range(0, len(nodes), 10)
    ]
    for i, node_directions in enumerate(directions):
        if not i or node_directions != directions[i - 1]:
            lines.append(
                ", ".join(map(str, node_directions if not i else (i + 1, *node_directions)))
            )
    lines += ["*MATRIX,TYPE=STIFFNESS"]
    for i, row in enumerate(K):
        lines += [
            ", ".join(f"{value:.15e}" for value in row[j : min(j + 4, i + 1)]) + ","
            for j in range(0, i + 1, 4)
        ]
    return "\n".join([*lines, *unlike]) + "\n"


def reduced():
    """Rows of the joint with two modes of its upper body, and a rotation.

    The modes are joined to the first node of the body, and the rotation of node 4 has only its own
    stiffness.
    """
    nodes = list(dict.fromkeys(LABELS[:, 0].tolist()))
    whole = np.zeros((69, 69))
    order = np.r_[0:12, 13:67]  # the rotation comes after node 4, the modes last
    B = np.zeros((66, 2))
    B[:3] = [[0.5, 0.0], [0.0, 2.0], [1.0, 1.0]]
    whole[np.ix_(order, order)] = K + B @ B.T
    whole[np.ix_(order, [67, 68])], whole[np.ix_([67, 68], order)] = B, B.T
    whole[[12, 67, 68], [12, 67, 68]] = [3.0, 1.0, 1.0]
    directions = [(1, 2, 3)] * 3 + [(1, 2, 3, 6)] + [(1, 2, 3)] * (len(nodes) - 4)
    return whole, [*nodes, 9000], [*directions, (1001, 1002)]


def test_a_substructure_of_abaqus_with_a_rotation_and_modes(tmp_path, deck, limit):
    mass = ["*MATRIX,TYPE=MASS", "1.0,", "2.0, 3.0,"]
    (tmp_path / "z1.mtx").write_text(element(*reduced(), unlike=mass))
    job = fo.readers.read_abaqus(tmp_path / "z1.mtx", deck=deck)
    assert job.labels[job.generalised].tolist() == [[4, 6], [9000, 1001], [9000, 1002]]
    assert set(job.bodies) == {-1, 0, 1}
    assert joint.limit(job) == pytest.approx(limit, rel=1e-9)


WHOLE = element(K, list(dict.fromkeys(LABELS[:, 0].tolist())), [(1, 2, 3)] * 22)


@refused(
    (
        "*MATRIX,TYPE=STIFFNESS",
        "*MATRIX,TYPE=MASS",
        r"bad\.mtx has elements: 1, nodes: 22, numbers of a stiffness: 0; write it with \*SUBSTRUCTURE",
    ),
    ("** ELEMENT NODES", "** NODES", "has elements: 1, nodes: 0"),
    ("*USER ELEMENT", "*USER ELEMENT, NODES= 1, LINEAR\n*USER ELEMENT", "has elements: 2"),
    ("1, 2, 3\n*MATRIX", "1, 2\n*MATRIX", r"has 2211 numbers, not 990 for a triangle of 44 rows"),
    (
        "1, 2, 3\n*MATRIX",
        "1, 2, 3\n40, 1\n*MATRIX",
        r"directions of bad\.mtx change at nodes \[40\] of 22",
    ),
    ("** 1, 2, 3,", "** 1, two, 3,", r"bad\.mtx cannot be read .*'two'"),
    ("4.000000000000000e+02,", "4.0x,", r"bad\.mtx cannot be read .*'4\.0X'"),
)
def test_damaged_substructures_are_refused(old, new, tmp_path):
    assert old in WHOLE
    (tmp_path / "bad.mtx").write_text(WHOLE.replace(old, new, 1))
    fo.readers.read_abaqus(tmp_path / "bad.mtx")


@pytest.mark.parametrize(("file", "labels"), [("joint.pch", None), ("joint.op4", LABELS)])
def test_the_files_of_pynastran(file, labels, limit):
    agrees(fo.readers.read_nastran(DATA / file, deck=DATA / "joint.bdf", labels=labels), limit)


def frame(K, labels):
    index = pd.MultiIndex.from_arrays(np.transpose(labels), names=["id", "dof"])
    return pd.DataFrame(K, index=index, columns=index)


def test_the_files_of_pyyeti(tmp_path, limit):
    """The files of pyyeti are read in all their forms.

    They are text and binary files; DMIG with a mass beside it and scalar points for modes; OUTPUT4
    of all grid points.
    """
    whole, nodes, directions = reduced()
    labels = [
        (n, k)
        for n, node_directions in zip(nodes, directions, strict=True)
        for k in node_directions
        if n < 9000
    ] + [(9001, 0), (9002, 0)]
    bulk.wtdmig(
        str(tmp_path / "a.pch"), {"KAAX": frame(whole, labels), "MAAX": frame(np.eye(69), labels)}
    )
    job = fo.readers.read_nastran(tmp_path / "a.pch", name="KAAX", deck=DATA / "joint.bdf")
    assert len(job.generalised) == 3 and joint.limit(job) == pytest.approx(limit, rel=1e-9)
    for binary in (True, False):
        op4.write(str(tmp_path / "a.op4"), ["KAA"], [K], binary=binary)
        agrees(
            fo.readers.read_nastran(tmp_path / "a.op4", deck=DATA / "joint.bdf", labels=LABELS),
            limit,
        )
    place = {number: i for i, number in enumerate(sorted(joint.POINTS))}
    every = np.zeros((6 * len(place), 6 * len(place)))
    rows = [6 * place[n] + k - 1 for n, k in LABELS.tolist()]
    every[np.ix_(rows, rows)] = K
    op4.write(str(tmp_path / "kgg.op4"), ["KGG"], [every])
    job = fo.readers.read_nastran(tmp_path / "kgg.op4", deck=DATA / "joint.bdf")
    held = job.unknowns[job.points[:, 2] == -1].ravel()
    top = {name: np.zeros(len(every)) for name in "PQ"}
    for n in joint.UPPER.on(2, 1):
        top["P"][6 * place[n] + 2], top["Q"][6 * place[n]] = -1.0, 1.0
    pairs = [[place[a], place[b]] for a, b in joint.PAIRS.tolist()]
    system = fo.condense(
        job.K,
        top,
        pairs,
        [0, 0, 1],
        job.unknowns,
        job.points,
        held=held,
        generalised=job.generalised,
    )
    assert fo.shakedown_limit(system, joint.CYCLE, 0.5).load_factor == pytest.approx(
        limit, rel=1e-9
    )


def grooved(K, noise, lean=0.5):
    """The joint on a groove along y, along which its upper block slides.

    Its stiffness along y is the noise of the normals, or an added stiffness.
    """
    job = fo.readers.MatrixJob(K, LABELS, joint.POINTS)
    place = {int(n): i for i, n in enumerate(job.deck.numbers)}
    pairs = np.vectorize(place.get)(joint.PAIRS)
    top = np.isin(job.deck.numbers, joint.UPPER.on(2, 1))
    x = job.points[pairs[:, 0], 0]
    normals = np.column_stack([lean * (1 - x), 0 * x, 1 + 0 * x])
    normals += (
        noise * np.random.default_rng(0).normal(size=(len(x), 3)) if np.isscalar(noise) else noise
    )
    forces = {"P": np.zeros(len(K)), "Q": np.zeros(len(K))}
    forces["P"][job.unknowns[top, 2]], forces["Q"][job.unknowns[top, 0]] = -1.0, 1.0
    return fo.condense(
        job.K, forces, pairs, normals, np.where(job.unknowns == -2, -1, job.unknowns), job.points
    ), normals


@pytest.mark.parametrize("noise", [1e-9, 1e-7, 1e-5])
def test_coordinates_of_some_digits_wedge_no_block_in_its_groove(noise):
    exact, near = (
        fo.shakedown_limit(grooved(K, amount)[0], joint.CYCLE, 0.5) for amount in (0.0, noise)
    )
    assert near.load_factor == pytest.approx(exact.load_factor, rel=10 * noise)


@pytest.mark.parametrize("added", [1e-2, [[0.0, 4e-4, 0.0]] + 5 * [[0.0, 0.0, 0.0]]])
def test_normals_that_wedge_a_block_are_a_shape(added):
    """They are the normals of all pairs or of one pair, which is little in the mean of all."""
    leaning, normals = grooved(K, added)
    assert np.allclose(
        leaning.frames[:, -1], normals / np.linalg.norm(normals, axis=1)[:, None], atol=1e-15
    )


def test_ten_digits_of_a_stiffness_hold_no_body():
    rounded = np.vectorize(lambda entry: float(f"{entry:.9e}"))(np.pi * K)
    soft = np.linalg.eigvalsh(grooved(rounded, 0.0)[0].S)
    assert np.abs(soft[:6]).max() < 1e-14 * soft[-1] and soft[6] > 1e-2 * soft[-1]


def test_bricks_of_twenty_nodes_of_nastran(tmp_path):
    """The cards have the upright edges before the upper edges. Nodal forces of a uniform pressure
    are a third amid edges, and -1/12 at corners."""
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    corners = np.array([(*point, z) for z in (0, 1) for point in ring], dtype=float)
    edges = (
        [(i, (i + 1) % 4) for i in range(4)],
        [(i, i + 4) for i in range(4)],
        [(i + 4, (i + 1) % 4 + 4) for i in range(4)],
    )
    points = np.vstack([corners, *(corners[list(part)].mean(axis=1) for part in edges)])
    grids = "".join(f"GRID,{i},,{x},{y},{z}\n" for i, (x, y, z) in enumerate(points, 1))
    (tmp_path / "a.bdf").write_text(
        f"{grids}CHEXA,1,1,1,2,3,4,5,6,+\n+,7,8,9,10,11,12,13,14,+\n+,15,16,17,18,19,20\n"
    )
    op4.write(str(tmp_path / "a.op4"), ["KGG"], [np.eye(120)])
    job = fo.readers.read_nastran(tmp_path / "a.op4", deck=tmp_path / "a.bdf")
    force = job.force(np.flatnonzero(job.points[:, 2] == 1), pressure=1.0)[job.unknowns]
    expected = np.where(job.points[:, 2] == 1, np.where(np.arange(20) < 8, 1 / 12, -1 / 3), 0.0)
    assert np.allclose(force, expected[:, None] * [0.0, 0.0, 1.0], atol=1e-12)


def test_other_files_of_nastran_are_refused(tmp_path):
    bdf = DATA / "joint.bdf"
    bulk.wtdmig(
        str(tmp_path / "two.pch"),
        {"KAAX": frame(K, LABELS), "MAAX": frame(K, LABELS), "PAX": frame(K, LABELS).iloc[:, :1]},
    )
    (tmp_path / "none.pch").write_text("$ nothing\n")
    (tmp_path / "bad.pch").write_text((DATA / "joint.pch").read_text().replace("D+02", "x", 1))
    (tmp_path / "bad.op4").write_text("hello")
    (tmp_path / "turned.bdf").write_text(
        bdf.read_text().replace("GRID           2        ", "GRID           2       7", 1)
    )
    (tmp_path / "part.bdf").write_text(bdf.read_text().replace("GRID           2 ", "$", 1))
    op4.write(str(tmp_path / "a.op4"), ["KAA"], [K])
    op4.write(str(tmp_path / "skew.op4"), ["KAA"], [np.triu(K)])
    bad = [
        ("two.pch", {}, r"name: None; two\.pch has the matrices KAAX, MAAX, PAX: give one"),
        ("two.pch", {"name": "KGG"}, "name: 'KGG'; two.pch has the matrices"),
        ("none.pch", {}, r"none\.pch has no DMIG cards; write .*DMIGPCH"),
        ("bad.pch", {}, "pyyeti cannot read .*bad.pch.*could not convert"),
        ("bad.op4", {}, "as OUTPUT4, pyyeti cannot read .*bad.op4"),
        ("gone.pch", {}, r"stiffness: there is no file '.*gone\.pch'"),
        ("a.op4", {}, r"labels: none, and a\.op4 has 66 rows, not six for each of 0 grid points"),
        ("a.op4", {"deck": bdf}, "not six for each of 32 grid points"),
        ("a.op4", {"labels": LABELS[:5]}, "of the size of the labels, 5"),
        ("a.op4", {"deck": tmp_path / "a.op4"}, "pyyeti cannot read .*a.op4|no GRID"),
        ("a.op4", {"deck": tmp_path / "two.pch"}, r"deck two\.pch: no GRID"),
        (
            "a.op4",
            {"deck": tmp_path / "turned.bdf"},
            r"deck turned\.bdf: grid point 2 has coordinates or displacements in system 7",
        ),
        ("a.op4", {"deck": tmp_path / "part.bdf"}, r"deck: elements C3D8 names node 2"),
        ("skew.op4", {"labels": LABELS}, "K: not symmetric"),
    ]
    for file, options, message in bad:
        with pytest.raises(fo.ModelError, match=message):
            fo.readers.read_nastran(tmp_path / file, **options)


def test_without_pyyeti_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyyeti.nastran.bulk", None)
    with pytest.raises(
        fo.ModelError, match=r"pyyeti: not installed; python -m pip install 'frictopt\[nastran\]'"
    ):
        fo.readers.read_nastran(DATA / "joint.pch")


def largest(matrix):
    return np.abs(matrix).max()


def abaqus(path, job, entries):
    labels = job.labels
    rows = [
        f"{labels[i, 0]},{labels[i, 1]}, {labels[j, 0]},{labels[j, 1]}, {value:.15e}"
        for i, j, value in entries
    ]
    path.write_text("** Assembled stiffness\n" + "\n".join(rows) + "\n")


@pytest.mark.parametrize("part", ["lower", "upper", "all"])
def test_abaqus_gives_the_same_matrix(flat, tmp_path, part):
    kept = flat.K.tocoo() if part == "all" else triu(flat.K).tocoo()
    ends = (kept.row, kept.col) if part != "lower" else (kept.col, kept.row)
    abaqus(tmp_path / "job_STIF1.mtx", flat, zip(*ends, kept.data, strict=True))
    with (tmp_path / "job_STIF1.mtx").open("a") as file:
        file.writelines(f"{node},1, {node},1, 1.0e36\n" for node in (1, 2))  # held displacements
    job = fo.readers.read_abaqus(tmp_path / "job_STIF1.mtx", deck=DATA / "flat.inp")
    where = job.unknowns[flat.unknowns >= 0]
    order = np.empty(964, dtype=int)
    order[flat.unknowns[flat.unknowns >= 0]] = where
    assert job.K.shape == (964, 964)
    assert largest(job.K[order][:, order] - flat.K) < 1e-14 * largest(flat.K)
    assert np.array_equal(job.labels[order], flat.labels)


@refused(
    ("1 1 2.0\n2 1 -1.0\n", "FORMAT=COORDINATE"),
    ("1, 1, 2.0\n2, 1, -1.0\n", "FORMAT=COORDINATE"),
    ("7,1, 7,1\n", "rows of 4 columns"),
    ("7,4, 8,5, 1.0\n", "labels: no label names a displacement"),
    ("-1,1, -7,1, 1.0\n", "labels: no label names a displacement"),
    ("7,1, 7,1, 1.0\n", "labels: no label names a displacement"),
    ("7,1, 8,1, -1.0\n8,1, 7,1, -2.0\n", "not symmetric"),
    ("", "stiffness: "),
)
def test_other_files_of_abaqus_are_refused(text, tmp_path):
    (tmp_path / "a.mtx").write_text(text)
    fo.readers.read_abaqus(tmp_path / "a.mtx")
