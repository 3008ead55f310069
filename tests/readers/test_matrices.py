"""Matrices of CalculiX and Abaqus.

They are compared with scikit-fem's own elements, and files are refused that are wrong in any way.
"""

import gzip
import shutil
from pathlib import Path

import numpy as np
import pytest
from skfem import Basis, ElementVector
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo

DATA = Path(__file__).parents[1] / "data"


@pytest.mark.parametrize(("name", "E"), [("flat", 210_000.0), ("cube", 1.0)])
def test_the_matrix_is_that_of_the_same_mesh_assembled_here(request, name, E):
    job = request.getfixturevalue(name)
    basis = Basis(job.mesh, ElementVector(job.mesh.elem()))
    K = linear_elasticity(*lame_parameters(E, 0.3)).assemble(basis)
    row = np.empty(len(job.labels), dtype=int)
    free = job.unknowns >= 0
    row[job.unknowns[free]] = basis.nodal_dofs.T[free]
    assert job.labels.shape == (len(row), 2)
    assert job.unknowns.shape == job.points.shape
    assert abs(job.K - K[row][:, row]).max() < 1e-11 * abs(K).max()


def test_held_displacements_are_the_ones_of_the_deck(flat, cube):
    held = flat.unknowns < 0
    assert held.all(axis=1).nonzero()[0].tolist() == sorted(flat.nodes("N_BOTTOM"))
    assert held.sum() == 2 * len(flat.nodes("N_BOTTOM"))
    assert np.array_equal((cube.unknowns < 0).any(axis=1), cube.points[:, 2] == -3)


def test_pairs_coincide_and_follow_the_face(flat):
    pairs = flat.pairs("N_CONTACT_PUNCH", "n_contact_block")  # decks do not tell cases apart
    assert np.allclose(flat.points[pairs[:, 0]], flat.points[pairs[:, 1]], rtol=0, atol=1e-10)
    assert set(pairs[:, 0]) == set(flat.nodes("N_CONTACT_PUNCH"))
    assert set(pairs[:, 1]) == set(flat.nodes("N_CONTACT_BLOCK"))
    assert (np.diff(flat.points[pairs[:, 1], 0]) > 0).all()
    assert np.array_equal(flat.normals(pairs[:, 1]), np.tile([0.0, 1.0], (26, 1)))


def test_forces_are_those_of_the_traction(flat):
    top = flat.nodes("N_TOP")
    down, pressure, shear = (
        flat.force("N_TOP", **load)
        for load in ({"traction": [0.0, -1.0]}, {"pressure": 1.0}, {"traction": [1.0, 0.0]})
    )
    assert np.allclose(down, pressure, atol=1e-14)
    assert shear.sum() == pytest.approx(10.0) and down.sum() == pytest.approx(-10.0)
    x = np.sort(flat.points[top, 0])
    lumped = np.convolve(np.diff(x), [0.5, 0.5])
    assert np.allclose(shear[flat.unknowns[top[np.argsort(flat.points[top, 0])], 0]], lumped)
    assert np.allclose(flat.force("N_TOP", total=[7.0, -3.0]), 0.7 * shear + 0.3 * down, atol=1e-14)
    each = np.arange(2.0 * len(top)).reshape(-1, 2)
    assert np.array_equal(flat.force("N_TOP", nodal=each)[flat.unknowns[top]], each)
    one = flat.force(top[:3], nodal=[2.0, 3.0])
    assert one.sum() == 15.0 and (one[flat.unknowns[top[:3]]] == [2.0, 3.0]).all()


def test_forces_on_faces_of_bricks(cube):
    top = cube.points[:, 2] == 1.5
    sides = [cube.points[:, 0] == x for x in (-4.0, 4.0)]
    P = cube.force(np.flatnonzero(top), pressure=1.0)
    assert P[cube.unknowns[top, 2]].sum() == pytest.approx(-4.0) and P.sum() == pytest.approx(-4.0)
    pull = [cube.force(np.flatnonzero(side), pressure=-1.0) for side in sides]
    held = cube.points[:, 2] == -3
    share = np.array([[-f[cube.unknowns[~held & side, 0]].sum() for f in pull] for side in sides])
    assert share[0, 0] == pytest.approx(-share[1, 1])
    assert share[0, 0] > 0
    assert share[0, 1] == share[1, 0] == 0


def test_normals_of_a_round_face_point_outwards(tmp_path):
    """A ring of quadrilaterals: by symmetry each node's normal is radial."""
    n = 12
    angle = 2 * np.pi * np.arange(n) / n
    inner = np.column_stack([np.cos(angle), np.sin(angle)])
    outer = 2 * np.column_stack([np.cos(angle), np.sin(angle)])
    lines = [
        "*Node",
        *(f"{i + 1}, {x:.16f}, {y:.16f}" for i, (x, y) in enumerate([*inner, *outer])),
        "*Element, type=cpe4, elset=ring",
    ]
    lines += [
        f"{i + 1}, {i + 1}, {n + i + 1}, {n + (i + 1) % n + 1}, {(i + 1) % n + 1}" for i in range(n)
    ]
    lines += ["*Nset, nset=hole, generate", f"1, {n}, 1"]
    stiffness(tmp_path, 2 * 2 * n, lines)
    job = fo.readers.read_calculix(tmp_path / "job")
    assert np.allclose(job.normals("hole"), -inner, atol=1e-14)
    assert np.allclose(
        job.force("hole", pressure=1.0)[job.unknowns[:n]],
        inner * 2 * np.sin(np.pi / n) * np.cos(np.pi / n),
        atol=1e-14,
    )


def stiffness(folder, size, deck=(), labels=None):
    """A job of a diagonal matrix."""
    (folder / "job.sti").write_text("".join(f"{i} {i}  1.0\n" for i in range(1, size + 1)))
    (folder / "job.dof").write_text(
        "".join(f"{i // 2 + 1}.{i % 2 + 1}\n" for i in range(size)) if labels is None else labels
    )
    if deck:
        (folder / "job.inp").write_text("\n".join(deck) + "\n")


SQUARES = """\
** two squares, in the ways that decks can be written
*HEADING
text, that is no keyword
*node, nset=Left
10, 0., 0.
20, 0., 1.D0
*INCLUDE, INPUT=more.nod
*ELEMENT, TYPE=CPS4R, ELSET=first
1, 10, 30,
40, 20
*ELEMENT, TYPE=CPS4R, ELSET=second
7, 30, 50, 60, 40
*NSET, NSET=Both
Left, 30
40,
*NSET, NSET=LEFT
30
*ELSET, ELSET=ALL
first, SECOND
"""
MORE = (
    "*NODE\n30, 1., 0.\n40, 1., 1.\n50, 2.\n60, 2., 1.\n*NSET, NSET=RIGHT, GENERATE\n50, 60, 10\n"
)


@pytest.fixture
def squares(tmp_path):
    (tmp_path / "job.inp").write_text(SQUARES)
    (tmp_path / "more.nod").write_text(MORE)
    stiffness(
        tmp_path,
        12,
        labels="".join(
            f"{node}.{direction}\n" for node in (10, 20, 30, 40, 50, 60) for direction in (1, 2)
        ),
    )
    return tmp_path


def test_decks_are_read_as_written(squares):
    deck = fo.readers.read_calculix(squares / "job").deck
    assert deck.numbers.tolist() == [10, 20, 30, 40, 50, 60]
    assert deck.points.tolist() == [
        [0, 0, 0],
        [0, 1, 0],
        [1, 0, 0],
        [1, 1, 0],
        [2, 0, 0],
        [2, 1, 0],
    ]
    sets = {name: deck.numbers[rows].tolist() for name, rows in deck.sets.items()}
    assert sets == {"LEFT": [10, 20, 30], "RIGHT": [50, 60], "BOTH": [10, 20, 30, 40]}
    ((shape, numbers, nodes),) = deck.by_shape()
    assert (shape, numbers.tolist(), deck.numbers[nodes].tolist()) == (
        "quad",
        [1, 7],
        [[10, 30, 40, 20], [30, 50, 60, 40]],
    )
    assert {name: found.tolist() for name, found in deck.element_sets.items()} == {
        "FIRST": [1],
        "SECOND": [7],
        "ALL": [1, 7],
    }


def test_surfaces_name_their_nodes(squares):
    """They are surfaces of faces of elements or of nodes; a set of the same name has precedence."""
    named = "*SURFACE, NAME=Side\nFIRST, S4\n*SURFACE, NAME=Nodes, TYPE=NODE\nRIGHT\n10\n*SURFACE, NAME=Right\n1, S4\n"
    named += "*SURFACE, NAME=Around\nALL, S3\n1, S4\n7, S1\n*ELEMENT, TYPE=MASS, ELSET=HEAVY\n99, 10\n*SURFACE, NAME=Lost\nHEAVY, S1"
    (squares / "job.inp").write_text(SQUARES + named)
    job = fo.readers.read_calculix(squares / "job")
    assert {
        name: job.deck.numbers[job.nodes(name)].tolist() for name in ("side", "NODES", "RIGHT")
    } == {"side": [10, 20], "NODES": [50, 60, 10], "RIGHT": [50, 60]}
    assert np.array_equal(job.force("Side", pressure=1.0), job.force([0, 1], pressure=1.0))
    # The end at x = 2.
    with pytest.raises(fo.ModelError, match="'AROUND': its nodes also span other facets"):
        job.nodes("around")
    with pytest.raises(fo.ModelError, match="'LOST': no solid of the deck has one of its faces"):
        job.nodes("lost")


OTHERWISE = [  # the same, in other ways
    ("20, 0., 1.D0", "20, , 1.D0"),
    ("10, 0., 0.\n", "10,,\n"),
    ("10, 0., 0.\n", "*INCLUDE,\nINPUT=ten.txt\n"),
    ("10, 0., 0.\n", "*INCLUDE, PASSWORD=sesame, INPUT=ten.txt, NOTE=a=b\n"),
    ("10, 0., 0.\n20, 0., 1.D0\n", '*include, input="sub/ten.txt",\n20, 0., 1.D0\n'),
    ("Left, 30\n40,", '"LEFT", 30\n40,'),
    ("Left, 30\n40,", "Left, 30\n*NSET, NSET=BOTH, GENERATE\n40, 40"),
    ("*NSET, NSET=Both\nLeft, 30\n40,", "*NSET, NSET=Both, ELSET=Both\n*ELSET, ELSET=both\nfirst"),
]


@pytest.mark.parametrize(("old", "new"), OTHERWISE)
def test_decks_that_say_the_same_are_the_same(squares, old, new):
    assert old in SQUARES
    (squares / "sub").mkdir()
    for place in (squares, squares / "sub"):
        (place / "ten.txt").write_text("** data of the block before\n10, 0., 0.\n")
    plain = fo.readers.read_calculix(squares / "job").deck
    (squares / "job.inp").write_text(SQUARES.replace(old, new))
    deck = fo.readers.read_calculix(squares / "job").deck
    assert deck.numbers.tolist() == plain.numbers.tolist()
    assert deck.points.tolist() == plain.points.tolist()
    assert {name: sorted(rows) for name, rows in deck.sets.items()} == {
        name: sorted(rows) for name, rows in plain.sets.items()
    }


UNUSED = [
    ("*node", "*part, name=a\n*node"),
    (
        "*NSET, NSET=Both",
        "*contact pair, interaction=i\ns_up, s_low\n*step, nlgeom\n*NSET, NSET=Both",
    ),
    ("*node, nset=Left", "*system\n*node, nset=Left, system=r"),
    # Two lines of nodes.
    (
        "*NSET, NSET=Both",
        "*ELEMENT, TYPE=MASS\n1, 10\n*ELEMENT, TYPE=U1\n9, 10, 20, 30,\n40, 50\n*NSET, NSET=Both",
    ),
]


@pytest.mark.parametrize(("old", "new"), UNUSED)
def test_what_says_nothing_of_the_mesh_is_passed_over(squares, old, new):
    (squares / "job.inp").write_text(SQUARES.replace(old, new))
    assert fo.readers.read_calculix(squares / "job").deck.sets.keys() == {"LEFT", "RIGHT", "BOTH"}


# file, text, what stands in its place (None: of the whole file; no text: at its end; nothing: it is
# missing), message
# Messages, and lines that are added to the deck, texts that are changed in it, and files.
ADDED = {
    "\\*SYSTEM .*in the global directions": "*SYSTEM\n1., 0., 0., 1., 1., 0.\n",
    "\\*TRANSFORM NSET=LEFT .*in the global directions": "*TRANSFORM, NSET=LEFT\n0., 1., 0., -1., 0., 0.\n",
    r"\*ELGEN ELSET=FIRST makes or moves .* not listed": "*ELGEN, ELSET=first\n1, 2, 20\n",
    r"\*NODE INPUT=MORE.NOD makes or moves .* not listed": "*NODE, INPUT=more.nod\n",
    r"\*INSTANCE NAME=I, PART=P has no name, or its part 'P' is not in this deck": "*INSTANCE, NAME=i, PART=p\n1., 0.\n*END INSTANCE\n",
}
CHANGED = {
    r"node 10 is defined twice, at \(0.0, 0.0, 0.0\) and at \(0.0, 1.0, 0.0\), as in .*flat deck": (
        "20, 0., 1.D0",
        "10, 0., 1.",
    ),
    r"\*NODE.*: an entry is no number": ("20, 0., 1.D0", "20, 0., one"),
    "elements CPS4R names node 21": ("40, 20\n", "40, 21\n"),
    "'BOTH' names 'BOTH'": ("Left, 30", "Both, 30"),
    r"element 1 is defined twice.*flat deck.* \(Abaqus/CAE: ": (
        "7, 30, 50, 60, 40",
        "1, 30, 50, 60, 40",
    ),
    r"it goes from 40 to 30 by 10, which does not increase": (
        "*NSET, NSET=Both\nLeft, 30\n40,",
        "*NSET, NSET=Both, GENERATE\n10, 20\n40, 30, 10",
    ),
    r"it goes from 40 to 10 by -10, which does not increase": (
        "*NSET, NSET=Both\nLeft, 30\n40,",
        "*NSET, NSET=Both, GENERATE\n40, 10, -10",
    ),
    "node set 'LEFT' names 'NONE', which is no other set": (
        "*NSET, NSET=LEFT",
        "*NSET, NSET=LEFT, ELSET=NONE",
    ),
    r"\*ELEMENT ELSET=SECOND: 'TYPE' is not in this deck": (
        "TYPE=CPS4R, ELSET=second",
        "ELSET=second",
    ),
}
ABOVE = "*NSET, NSET=Both"
DAMAGED = [
    *(("job.inp", ABOVE, lines + ABOVE, message) for message, lines in ADDED.items()),
    *(("job.inp", *texts, message) for message, texts in CHANGED.items()),
    ("job.inp", None, "*HEADING\n", "no nodes"),
    ("more.nod", None, "*INCLUDE, INPUT=more.nod\n", "includes itself"),
    ("job.sti", None, None, "job.sti"),
    ("job.dof", None, None, "labels: .*job.dof"),
    ("job.dof", None, "10.1\n10.2\n", "job.sti has rows 1 to 12, job.dof has 2 labels"),
    (
        "job.sti",
        "",
        "24 24 2.0\n",
        r"has 12 labels; .* leave that out: it makes the matrix complex",
    ),
    ("job.dof", None, "10.1\n" * 12, "labels are given twice"),
    ("job.sti", None, "1 1 1.0\n1 2 one\n", "entries that are no numbers"),
    ("job.sti", "", "12 12 2.0\n", "entries are given twice"),
    ("job.sti", "", "1 2 inf\n", "entry 13 is not finite"),
    (
        "job.inp",
        "",
        "*CONTACT PAIR, INTERACTION=I\nS_UP, S_LOW\n*step, nlgeom, perturbation\n",
        r"springs of each \*CONTACT PAIR",
    ),
    ("job.sti", "", "1 2 0.5\n2 1 0.4\n", r"not symmetric, K\[\d, \d\] = 0.\d but"),
]


@pytest.mark.parametrize(("name", "old", "new", "message"), DAMAGED)
def test_damaged_files_are_refused(squares, name, old, new, message):
    text = (squares / name).read_text()
    (squares / name).unlink()
    assert old is None or old in text
    if new:
        (squares / name).write_text(
            new if old is None else text.replace(old, new) if old else text + new
        )
    with pytest.raises(fo.ModelError, match=message):
        fo.readers.read_calculix(squares / "job")


LACKS = {
    "node set 'N_CONTACT': unknown, or it has no nodes; this deck names": lambda job: job.force(
        "N_CONTACT", pressure=1.0
    ),
    "3 and 2 nodes": lambda job: job.pairs("LEFT", "RIGHT"),
    "nodes in common": lambda job: job.pairs("LEFT", "LEFT"),
    "node 10 is the nearest one to several": lambda job: job.pairs([0, 1], [2, 4]),
    "no facet of the outline": lambda job: job.force([0, 5], pressure=1.0),
    "node 60 lies on no facet": lambda job: job.normals([0, 1, 5]),
    "this job has none": lambda job: fo.readers.MatrixJob(job.K, job.labels).points,
    r"node 70 .*is not in it": lambda job: (
        fo.readers.MatrixJob(job.K, job.labels + [[10, 0]], job.deck).unknowns
    ),
}


@pytest.mark.parametrize("message", LACKS)
def test_what_the_deck_lacks_is_named(squares, message):
    job = fo.readers.read_calculix(squares / "job")
    with pytest.raises(fo.ModelError, match=message):
        LACKS[message](job)


def test_a_job_without_a_deck_has_its_matrix(squares):
    (squares / "job.inp").rename(squares / "other.inp")
    job = fo.readers.read_calculix(squares / "job")
    assert job.deck is None and job.K.shape == (12, 12)
    assert fo.readers.read_calculix(squares / "job", deck=squares / "other.inp").deck.sets
    with pytest.raises(fo.ModelError, match=r"deck: .*job\.inp"):
        fo.readers.read_calculix(squares / "job", deck=squares / "job.inp")


def test_compressed_or_binary_files_are_refused(tmp_path):
    for name in ("flat.sti", "flat.dof"):
        shutil.copy(DATA / name, tmp_path)
    (tmp_path / "flat.sti").write_bytes(gzip.compress((DATA / "flat.sti").read_bytes()))
    with pytest.raises(fo.ModelError, match="stiffness: "):
        fo.readers.read_calculix(tmp_path / "flat")


def test_the_limit_is_that_of_the_same_mesh_assembled_here(flat):
    """The number is in the README of the data: mean pressure 100 on the punch, shear to and fro, f
    = 0.5."""
    pairs = flat.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    loads = {"P": flat.force("N_TOP", pressure=1.0), "Q": flat.force("N_TOP", traction=[1.0, 0.0])}
    read = fo.condense(flat.K, loads, pairs, flat.normals(pairs[:, 1]), flat.unknowns, flat.points)
    mesh = fo.readers.read_mesh(DATA / "flat.inp")
    material = fo.fem.Material(E=210_000.0, nu=0.3)
    upper = mesh.p[1, mesh.t].mean(axis=0) > 0
    bodies = {
        name: fo.fem.Body(mesh.restrict(np.flatnonzero(part)), material)
        for name, part in (("punch", upper), ("block", ~upper))
    }
    here = fo.fem.ContactModel(
        bodies=bodies,
        contacts=[fo.fem.Contact("punch", "block", "N_CONTACT_PUNCH", "N_CONTACT_BLOCK")],
        supports=[fo.fem.Support("block", "N_BOTTOM")],
        loads={
            "P": [fo.fem.Traction("punch", "N_TOP", y=-1.0)],
            "Q": [fo.fem.Traction("punch", "N_TOP", x=1.0)],
        },
    ).condense()
    assert np.abs(read.S - here.S).max() < 1e-10 * np.abs(here.S).max()
    cycle = fo.LoadCycle({"P": 100.0}, [{"Q": 1.0}, {"Q": -1.0}])
    limits = [fo.shakedown_limit(system, cycle, 0.5).load_factor for system in (read, here)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-10)
    assert limits[0] == pytest.approx(20.0483360471, abs=1e-9)
