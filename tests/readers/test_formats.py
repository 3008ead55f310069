"""The page of formats: each row of its tables of decks and cards is tried."""

import re

import numpy as np
import pytest

import frictopt as fo
from frictopt.readers.keywords import KEPT as READ
from frictopt.readers.keywords import REFUSED as NOT_READ
from helpers.formats_page import rows, section

PLACES = [(x, y, z) for z in (0, 1, 1, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
NODES = "*NODE, NSET=NALL\n" + "".join(
    f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(PLACES, 1)
)
BRICKS = "*ELEMENT, TYPE=C3D8, ELSET=LOW\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=C3D8, ELSET=HIGH\n2, 9, 10, 11, 12, 13, 14, 15, 16\n"
QUADS = "*ELEMENT, TYPE=CPE4, ELSET=LOW\n1, 1, 2, 3, 4\n"
FACE = "*SURFACE, NAME=S\nLOW, S1\n"


DECK = {
    name.strip("`"): effect
    for name, effect in rows("Decks of Abaqus and CalculiX")
    if name.startswith("`*")
}
WITHOUT = re.findall(
    r"`(\*[A-Z -]+)`[,.]",
    section("Decks of Abaqus and CalculiX").split("All other keywords")[1].split("In a deck of")[0],
)


def mesh_of(folder, text):
    (folder / "a.inp").write_text(text)
    return fo.readers.read_mesh(folder / "a.inp")


def job_of(folder, text, directions=3):
    """The job of a deck, with a matrix that joins all its unknowns."""
    (folder / "a.inp").write_text(text)
    labels = [
        f"{node}.{direction}"
        for node in range(1, 17 if directions == 3 else 5)
        for direction in range(1, directions + 1)
    ]
    entries = [f"{i} {i} 2.0" for i in range(1, len(labels) + 1)] + [
        f"{i} {i + 1} -1.0" for i in range(1, len(labels))
    ]
    (folder / "a.dof").write_text("\n".join(labels) + "\n")
    (folder / "a.sti").write_text("\n".join(entries) + "\n")
    return fo.readers.read_calculix(folder / "a")


def sides(mesh, name):
    return len(mesh.boundaries[name])


def named(keyword):
    """A constraint of the rules of the code: its name is known."""
    return (
        f"*{keyword}\n1, 2\n",
        lambda _, job: f"*{keyword.replace(' ', '')}" in job.deck.constraints,
    )


KEPT = {  # more of the deck, and what is then true of its mesh and job
    "*INCLUDE": ("*INCLUDE, INPUT=more.inp\n", lambda mesh, _: sides(mesh, "MORE") == 1),
    **dict.fromkeys(
        ("*PART", "*INSTANCE", "*ASSEMBLY"),
        (
            "*PART, NAME=P\n*NODE, NSET=X\n91, 9., 9., 9.\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n1., 2., 3.\n*END INSTANCE\n*END ASSEMBLY\n",
            lambda _, job: job.deck.points[job.deck.nodes("I.X")].tolist() == [[10, 11, 12]],
        ),
    ),
    "*NODE": ("", lambda _, job: job.deck.sets["NALL"].tolist() == list(range(16))),
    "*ELEMENT": ("", lambda mesh, _: mesh.subdomains["HIGH"].tolist() == [1]),
    "*NSET": (
        "*NSET, NSET=FOOT, GENERATE\n-3, 4\n",
        lambda mesh, job: sides(mesh, "FOOT") == 1 and len(job.nodes("FOOT")) == 4,
    ),
    "*ELSET": (
        "*ELSET, ELSET=BOTH, GENERATE\n1, 9\n",
        lambda mesh, _: mesh.subdomains["BOTH"].tolist() == [0, 1],
    ),
    "*SURFACE": ("*SURFACE, NAME=SKIN\nLOW, S1\nHIGH,\n", lambda mesh, _: sides(mesh, "SKIN") == 7),
    "*SURFACE, COMBINE=UNION": (
        f"{FACE}*SURFACE, NAME=T\nHIGH, S2\n*SURFACE, NAME=ENDS, COMBINE=UNION\nS, T\n",
        lambda mesh, _: sides(mesh, "ENDS") == 2,
    ),
    "*SOLID SECTION": (
        "*SOLID SECTION, ELSET=LOW, MATERIAL=M\n3.\n",
        lambda _, job: job.deck.thickness == 1.0,
    ),
    "*BOUNDARY": (
        "*BOUNDARY\n1, 2, 3\n",
        lambda _, job: job.deck.held[0].tolist() == [0, 1, 1, 0, 0, 0],
    ),
    **{
        f"*{name}": named(name)
        for name in (
            "EQUATION",
            "TIE",
            "MPC",
            "DISTRIBUTING",
            "DISTRIBUTING COUPLING",
            "KINEMATIC COUPLING",
            "CYCLIC SYMMETRY MODEL",
        )
    },
    **{f"*{name}": named(name) for name in ("PRE-TENSION SECTION", "EMBEDDED ELEMENT")},
}
# Refused, and the deck that does what the error says.
REFUSED = {
    **{
        f"*SURFACE, {parameter}": (
            f"{FACE}*SURFACE, NAME=BAD, {parameter}\nLOW, S1\n",
            f"{FACE}*SURFACE, NAME=BAD\nLOW, S1\n",
        )
        for parameter in (
            "COMBINE=DIFFERENCE",
            "COMBINE=INTERSECTION",
            "TRIM=YES",
            "CROP",
            "TYPE=CUTTING SURFACE",
            "TYPE=CYLINDER",
        )
    },
    "*SYSTEM": ("*SYSTEM\n1., 0., 0., 1., 1., 0.\n", "*SYSTEM\n"),
    "*NODE, SYSTEM=C": ("*NODE, SYSTEM=C\n99, 1., 90., 0.\n", "*NODE\n99, 0., 1., 0.\n"),
    "*NODE, INPUT=FILE": ("*NODE, INPUT=more.inp\n", "*INCLUDE, INPUT=more.inp\n"),
    "*ELEMENT, INPUT=FILE": ("*ELEMENT, TYPE=C3D8, INPUT=more.inp\n", "*INCLUDE, INPUT=more.inp\n"),
    "*ELEMENT, OFFSET=100": (
        "*ELEMENT, TYPE=MASS, OFFSET=100\n1, 1\n",
        "*ELEMENT, TYPE=MASS\n101, 1\n",
    ),
    "*MODEL CHANGE, TYPE=ELEMENT": (
        "*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nHIGH\n",
        "*MODEL CHANGE, TYPE=CONTACT PAIR\nA, B\n",
    ),
    **{
        f"*{name}": (f"*{name}\n1, 2\n", "")
        for name in ("NGEN", "NFILL", "NCOPY", "NMAP", "IMPERFECTION", "ELGEN", "ELCOPY", "IMPORT")
    },
    **{
        f"*{name}": (f"*{name}\n1, 2\n", "")
        for name in ("SYMMETRIC MODEL GENERATION", "REFINE MESH")
    },
}
OF_JOBS = {  # refused by readers of matrices alone: elements of the deck, and more
    "*NODAL THICKNESS": (
        QUADS,
        "*NODAL THICKNESS\nNALL, 2.\n",
        "*SOLID SECTION, ELSET=LOW, MATERIAL=M\n2.\n",
    ),
    "*TRANSFORM": (BRICKS, "*TRANSFORM, NSET=NALL, TYPE=C\n0., 0., 0., 0., 0., 1.\n", ""),
    "*RIGID BODY": (BRICKS, "*RIGID BODY, ELSET=HIGH, REF NODE=1\n", "*COUPLING\n"),
    "*KINEMATIC": (BRICKS, "*COUPLING\n*KINEMATIC\n1, 2\n", "*COUPLING\n*DISTRIBUTING\n1, 2\n"),
    "*CONTACT PAIR": (
        BRICKS,
        "*CONTACT PAIR, INTERACTION=I\nA, B\n*STEP, PERTURBATION\n",
        "*CONTACT PAIR, INTERACTION=I\nA, B\n*STEP\n",
    ),
}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "more.inp").write_text("*NSET, NSET=MORE\n1, 2, 3, 4\n")
    return tmp_path


def test_the_page_lists_what_the_reader_knows():
    assert {name for name, effect in DECK.items() if effect == "kept"} == KEPT.keys()
    assert {
        name for name, effect in DECK.items() if effect == "refused"
    } == REFUSED.keys() | OF_JOBS.keys()
    listed = {name.split(",")[0].strip("*").replace(" ", "") for name in DECK}
    assert listed == {
        *READ,
        *(name.split(",")[0] for name in NOT_READ),
        "INCLUDE",
        "CONTACTPAIR",
        "PART",
        "INSTANCE",
        "ASSEMBLY",
    }
    assert len(WITHOUT) > 95 and not listed & {name.strip("*").replace(" ", "") for name in WITHOUT}


@pytest.mark.parametrize("name", KEPT)
def test_what_is_kept_is_there(folder, name):
    more, holds = KEPT[name]
    deck = NODES + BRICKS + more
    assert holds(mesh_of(folder, deck), job_of(folder, deck))


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_is_named_and_the_remedy_helps(folder, name):
    bad, good = REFUSED[name]
    keyword = name.split(",")[0].strip("*").replace(" ", "")
    message = rf"\*{keyword}\b"
    if keyword == "SURFACE":
        message += rf" .*: {name.split(', ')[1].removesuffix('=YES')}"
    for read in (mesh_of, job_of):
        with pytest.raises(fo.ModelError, match=message):
            read(folder, NODES + BRICKS + bad)
        read(folder, NODES + BRICKS + good)


@pytest.mark.parametrize("name", OF_JOBS)
def test_what_changes_a_matrix_is_refused_by_its_readers_alone(folder, name):
    elements, bad, good = OF_JOBS[name]
    nodes, directions = (
        (NODES, 3) if elements is BRICKS else ("".join(NODES.splitlines(keepends=True)[:5]), 2)
    )
    said = {"*NODAL THICKNESS": "thickness", "*KINEMATIC": r"\*COUPLING"}.get(name, rf"\{name}")
    with pytest.raises(fo.ModelError, match=said):
        job_of(folder, nodes + elements + bad, directions)
    job_of(folder, nodes + elements + good, directions)
    assert mesh_of(folder, nodes + elements + bad).nelements == len(elements.splitlines()) // 2


@pytest.mark.parametrize("name", [*WITHOUT, "*NO SUCH KEYWORD"])
def test_what_has_no_effect_has_none(folder, name):
    plain = NODES + BRICKS + FACE
    deck = f"{name}\n1, 2.\n{NODES}{name}, NAME=LOW, ELSET=HIGH\n{BRICKS}{FACE}{name}\n"
    one, other = job_of(folder, plain).deck, job_of(folder, deck).deck
    assert np.array_equal(one.points, other.points)
    assert one.sets.keys() == other.sets.keys()
    assert one.surfaces.keys() == other.surfaces.keys()
    assert [[*map(np.ndarray.tolist, block[1:])] for block in one.elements] == [
        [*map(np.ndarray.tolist, block[1:])] for block in other.elements
    ]
    assert one.constraints == other.constraints == ()
    assert not other.held.any()


TYPES = re.findall(
    r"^\| (`[A-Z].*`) \| (kept|refused|without effect) \| (.*) \|",
    section("Decks of Abaqus and CalculiX"),
    re.MULTILINE,
)
MORE = {  # types of elements beside the bricks: their number of nodes
    "C3D13": 13, "S4": 4, "M3D4": 4, "B31": 2, "R3D4": 4, "SPRINGA": 2, "MASS": 1, "DASHPOTA": 2, "T3D2": 2,
}  # fmt: skip


@pytest.mark.parametrize(("names", "effect", "done"), TYPES)
def test_types_of_elements(folder, names, effect, done):
    """Nodes of elements that are refused lie on the face that is asked for."""
    nodes = NODES + "".join(f"{i}, {i}., 9., 9.\n" for i in range(17, 30))
    for kind in re.findall(r"`(\w+)`", names):
        node_count = MORE.get(kind)
        if node_count is None:  # the elements of which all meshes are made: see the tests of meshes
            assert effect == "kept"
            continue
        deck = f"{nodes}{BRICKS}*ELEMENT, TYPE={kind}, ELSET=MORE\n9, {', '.join(map(str, range(5, 5 + node_count)))}\n"
        job = job_of(folder, deck)
        low = [4, 5, 6, 7]
        high = [8, 9, 10, 11]
        if kind == "C3D13":
            with pytest.raises(
                fo.ModelError,
                match=rf"an element {kind}.* mesh this body with C3D4, C3D8, C3D10, C3D20, C3D5",
            ):
                job.pairs(low, high)
        else:
            assert len(job.pairs(low, high)) == 4
        if kind == "C3D13":
            with pytest.raises(fo.ModelError, match=f"elements of type {kind} have node 5 of"):
                job.force(low, pressure=1.0)
        else:
            assert job.force(low, pressure=1.0).sum() == pytest.approx(-1.0)
        if effect == "refused":
            with pytest.raises(fo.ModelError, match=f"elements of type {kind}; give solids"):
                mesh_of(folder, deck)
        elif done.startswith("with a warning"):
            left_out = rf"left out: 1 of type {kind} \(in 'MORE'\); if they are faces of a body"
            with pytest.warns(fo.ModelWarning, match=left_out):
                assert mesh_of(folder, deck).nelements == 2
        else:
            assert mesh_of(folder, deck).nelements == 2
