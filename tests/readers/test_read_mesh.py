"""Mesh files.

Names in the files are kept, and contents that would be read wrongly are refused.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from skfem import MeshQuad, MeshTri

import frictopt as fo

DATA = Path(__file__).parents[1] / "data"
POINTS = np.array(
    [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [0, 1, 0], [9, 9, 0]], dtype=float
)
QUADS = ("quad", [[0, 1, 4, 5], [1, 2, 3, 4]])


def middles(mesh):
    """Middles of the facets of each boundary."""
    return {
        name: [
            mesh.p[:, list(dict.fromkeys(nodes))].mean(axis=1).tolist()
            for nodes in mesh.facets[:, facets].T.tolist()
        ]
        for name, facets in mesh.boundaries.items()
    }


def elements(mesh):
    """Elements of each subdomain."""
    return {name: members.tolist() for name, members in mesh.subdomains.items()}


def test_a_file_of_gmsh_names_only_the_groups_of_its_author_and_is_read_in_silence(capfd):
    mesh = fo.readers.read_mesh("docs/tutorial/foot.msh")
    assert sorted(mesh.subdomains) == ["block", "foot"]
    assert sorted(mesh.boundaries) == ["bottom", "left", "right", "top"]
    assert capfd.readouterr() == ("", "")


def test_sets_of_a_deck_become_boundaries_and_subdomains(tmp_path):
    nodes = "".join(f"{i + 1}, {x}, {y}\n" for i, (x, y, _) in enumerate(POINTS))
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE=CPE3, ELSET=A\n1, 1, 2, 5\n2, 1, 5, 6\n*ELEMENT, TYPE=CPE3, ELSET=B\n3, 2, 3, 4\n4, 2, 4, 5\n"
    (tmp_path / "a.inp").write_text(
        deck + "*NSET, NSET=Bottom\n1, 2, 3\n*NSET, NSET=ONE\n4\n*ELSET, ELSET=UPPER\n2, 4\n"
    )
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    assert isinstance(mesh, MeshTri)
    assert mesh.p.shape == (2, 6)
    assert list(mesh.boundaries) == ["BOTTOM"]
    assert mesh.p[1, mesh.facets[:, mesh.boundaries["BOTTOM"]]].tolist() == [[0, 0], [0, 0]]
    assert elements(mesh) == {"A": [0, 1], "B": [2, 3], "UPPER": [1, 3]}


def test_a_node_that_a_deck_lists_twice_at_one_place_is_one_node(tmp_path):
    """Some codes list the reference node of a rigid part again. Blank coordinates are zero."""
    nodes = "*NODE\n1, 0, 0\n2, 1., 0\n3, 0, 1, 0\n9, .5, .5\n"
    again = "*NODE, NSET=LOW\n1, 0., , 0.\n2, 1\n*NODE\n9, 5e-1, 0.5\n"
    (tmp_path / "a.inp").write_text(
        f"{nodes}{again}*ELEMENT, TYPE=CPE3, ELSET=A\n1, 1, 2, 3\n{again}"
    )
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    assert mesh.p.T.tolist() == [[0, 0], [1, 0], [0, 1]]
    assert mesh.t.tolist() == [[0], [1], [2]]
    assert middles(mesh) == {"LOW": [[0.5, 0]]}


RING = np.array(
    [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
        [0.5, 0, 0],
        [0.5, 0.5, 0],
        [0, 0.5, 0],
        [1, 1, 0],
        [0.5, 1, 0],
        [1, 0.5, 0],
        [0.5, 0.5, 0],
    ]
)
SOLID = np.array(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1], [0, 1, 1], [1, 0, 1]],
    dtype=float,
)
CURVED = "*ELEMENT,TYPE=CPE6\n1,1,2,3,4,5,6\n"
REFUSED = [  # file, points, cells or text of a deck after its nodes, message
    (
        "a.vtk",
        RING,
        [("triangle6", [[0, 1, 2, 3, 4, 5]]), ("triangle", [[1, 6, 2]])],
        r"the edge at \(0.5, 0.5\) belongs to linear and to quadratic elements",
    ),
    (
        "a.inp",
        RING,
        CURVED + "*ELEMENT,TYPE=CPE3\n2,2,7,3\n",
        r"the edge at \(0.5, 0.5\) belongs to linear and to quadratic elements",
    ),
    (
        "a.inp",
        RING,
        CURVED + "2,2,7,3,9,8,10\n",
        r"midside node at \(0.5, 0.5, 0\) is on an edge that has another one; merge",
    ),
    ("a.vtk", SOLID, [("triangle", [[0, 1, 3]])], "z varies by 1"),
    ("a.vtk", SOLID, [("line", [[0, 1]])], "no elements"),
]


@pytest.mark.parametrize(("name", "points", "cells", "message"), REFUSED)
def test_meshes_that_are_mixed_or_none_are_refused(tmp_path, name, points, cells, message):
    if name.endswith("inp"):
        (tmp_path / name).write_text(
            "*NODE\n" + "".join(f"{i + 1},{x},{y}\n" for i, (x, y, _) in enumerate(points)) + cells
        )
    else:
        meshio.Mesh(points, cells).write(tmp_path / name)
    with pytest.raises(fo.ModelError, match=message):
        fo.readers.read_mesh(tmp_path / name)


# nodes of one element, and the middles of its faces S1, S2, ... as the manuals of CalculiX and
# Abaqus number them
UNIT = {
    "C3D8": (
        "000 100 110 010 001 101 111 011",
        [(0.5, 0.5, 0), (0.5, 0.5, 1), (0.5, 0, 0.5), (1, 0.5, 0.5), (0.5, 1, 0.5), (0, 0.5, 0.5)],
    ),
    "C3D4": (
        "000 100 010 001",
        [(1 / 3, 1 / 3, 0), (1 / 3, 0, 1 / 3), (1 / 3, 1 / 3, 1 / 3), (0, 1 / 3, 1 / 3)],
    ),
    "C3D6": (
        "000 100 010 001 101 011",
        [(1 / 3, 1 / 3, 0), (1 / 3, 1 / 3, 1), (0.5, 0, 0.5), (0.5, 0.5, 0.5), (0, 0.5, 0.5)],
    ),
    "C3D5": (
        "000 100 110 010 001",
        [
            (0.5, 0.5, 0),
            (1 / 3, 0, 1 / 3),
            (2 / 3, 1 / 3, 1 / 3),
            (1 / 3, 2 / 3, 1 / 3),
            (0, 1 / 3, 1 / 3),
        ],
    ),
    "CPE4": ("000 100 110 010", [(0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]),
    "CPS3": ("000 100 010", [(0.5, 0), (0.5, 0.5), (0, 0.5)]),
}


@pytest.mark.parametrize("kind", UNIT)
def test_surfaces_of_a_deck_are_faces_of_its_elements(tmp_path, kind):
    corners, places = UNIT[kind]
    nodes = "".join(
        f"{i}, {', '.join(corner)}\n" for i, corner in enumerate(corners.split(), start=1)
    )
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE={kind}, ELSET=ALL\n7, {', '.join(map(str, range(1, 1 + len(corners.split()))))}\n"
    deck += "".join(
        f"*SURFACE, NAME=Face{i}\n{'ALL, S' if i % 2 else '7, s'}{i}\n"
        for i in range(1, 1 + len(places))
    )
    (tmp_path / "a.inp").write_text(
        deck
        + "*SURFACE, TYPE=ELEMENT, NAME=BOTH\nALL, S1\nALL, S2\n*SURFACE, NAME=SKIN\nALL, S1\nALL,\n"
    )
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    found = middles(mesh)
    assert sorted(found) == sorted(
        ["BOTH", "SKIN", *(f"FACE{i}" for i in range(1, 1 + len(places)))]
    )
    for i, middle in enumerate(places, start=1):
        assert np.allclose(found[f"FACE{i}"], [middle])
    assert sorted(found["BOTH"]) == sorted([*found["FACE1"], *found["FACE2"]])
    assert sorted(found["SKIN"]) == sorted(
        middle for i in range(1, 1 + len(places)) for middle in found[f"FACE{i}"]
    )
    bad = {
        "9, S1": "names element 9, which is not defined",
        "ALL, S1\nALL, SPOS": "SPOS is no face",
        ", S1": "without an element set",
    }
    (tmp_path / "b.inp").write_text(deck + "*SURFACE, NAME=NONE\n*SURFACE, NAME=SKIN\nALL,\n")
    with pytest.warns(fo.ModelWarning, match="surfaces without lines are left out: NONE; to use"):
        assert "NONE" not in fo.readers.read_mesh(tmp_path / "b.inp").boundaries
    for odd, message in bad.items():  # no part of a surface that cannot be read
        (tmp_path / "b.inp").write_text(deck + f"*SURFACE, NAME=BAD\n{odd}\n")
        with pytest.raises(fo.ModelError, match=f"(?i)surface (name=)?BAD.*{message}"):
            fo.readers.read_mesh(tmp_path / "b.inp")
    (tmp_path / "b.inp").write_text(
        deck
        + "*SURFACE, NAME=BAD\n"
        + (f"ALL, S{len(places) + 1}\n" if len(places) < 6 else "NONE, S1\n")
    )
    with pytest.raises(fo.ModelError, match=r"surface BAD: face S|a surface names 'NONE'"):
        fo.readers.read_mesh(tmp_path / "b.inp")


@pytest.mark.parametrize("name", ["none.msh", "none.inp", "none.xyz"])
def test_missing_files_are_named(tmp_path, name, capsys):
    with pytest.raises(fo.ModelError, match=name):
        fo.readers.read_mesh(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [("a.msh", "$MeshFormat\nnonsense\n"), ("a.vtk", "nonsense\n"), ("a.xdmf", "<Xdmf/>")],
)
def test_damaged_files_do_not_end_the_process(tmp_path, name, text, capsys):
    (tmp_path / name).write_text(text)
    with pytest.raises(fo.ModelError, match=rf"meshio cannot read .*{name}"):
        fo.readers.read_mesh(tmp_path / name)


def test_without_meshio_all_but_mesh_files_works():
    """The first command of the README installs no meshio."""
    code = (
        "import sys; sys.modules['meshio'] = None\n"
        "import frictopt as fo, studies.__main__\n"
        "print(fo.scenes.PunchOnHalfPlane(elements=2, growth=3.0).condense().nodes)\n"
        "try:\n    fo.readers.read_mesh('tests/data/pin.msh')\nexcept fo.ModelError as error:\n    print(error)"
    )
    output = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
    ).stdout
    assert output.split("\n")[0] == "3"
    assert "meshio: not installed; python -m pip install 'frictopt[mesh]'" in output


OF_GMSH = "*Heading\n a.inp\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 2, 0\n6, 1, 2, 0\n******* E L E M E N T S *************\n"
OF_GMSH += "*ELEMENT, type=T3D2, ELSET=Line1\n1, 1, 2\n*ELEMENT, type=T3D2, ELSET=Line2\n2, 3, 4\n"
OF_GMSH += "*ELEMENT, type=CPS4, ELSET=Surface1\n3, 1, 2, 3, 4\n*ELEMENT, type=CPS4, ELSET=Surface2\n4, 4, 3, 6, 5\n"
OF_GMSH += "*ELSET,ELSET=bottom\n1,\n*ELSET,ELSET=between\n2,\n*ELSET,ELSET=upper\n4,\n*NSET,NSET=bottom\n1, 2,\n*NSET,NSET=top\n5, 6,\n"


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_named_curves_of_a_deck_of_gmsh_are_boundaries_within_the_mesh_too(tmp_path, mark):
    (tmp_path / "a.inp").write_text(mark + OF_GMSH, encoding="utf-8")
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    assert middles(mesh) == {
        "BOTTOM": [[0.5, 0]],
        "BETWEEN": [[0.5, 1]],
        "TOP": [[0.5, 2]],
        "LINE1": [[0.5, 0]],
        "LINE2": [[0.5, 1]],
    }
    assert elements(mesh) == {"SURFACE1": [0], "SURFACE2": [1], "UPPER": [1]}


@pytest.mark.parametrize("version", ["gmsh22", "gmsh"])
def test_curves_within_the_mesh_keep_their_names_in_each_version(tmp_path, version):
    """gmsh counts the groups of each dimension by themselves: group 1 is a curve and a surface."""
    cells = [QUADS, ("line", [[0, 1], [1, 4]])]
    if version == "gmsh22":
        tags = [np.array([1, 2]), np.array([1, 2])]
        groups = {
            "first": np.array([1, 2]),
            "second": np.array([2, 2]),
            "bottom": np.array([1, 1]),
            "between": np.array([2, 1]),
        }
        mesh = meshio.Mesh(
            POINTS,
            cells,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data=groups,
        )
        mesh.write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
        mesh.write(tmp_path / "a.vtu")  # which has no names
        numbered = fo.readers.read_mesh(tmp_path / "a.vtu")
        assert middles(numbered) == {"1": [[0.5, 0]], "2": [[1, 0.5]]}
        assert elements(numbered) == {"1": [0], "2": [1]}
    else:
        shutil.copy(DATA / "curves.msh", tmp_path / "a.msh")
    mesh = fo.readers.read_mesh(tmp_path / "a.msh")
    # The node of no element is left out.
    assert isinstance(mesh, MeshQuad)
    assert mesh.p.shape == (2, 6)
    assert middles(mesh) == {"bottom": [[0.5, 0]], "between": [[1, 0.5]]}
    assert elements(mesh) == {"first": [0], "second": [1]}
