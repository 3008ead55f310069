"""Groups of mesh files.

No group is lost, whatever the orientation of its entities, and however many groups they are in.
"""

import re
import sys

import meshio
import numpy as np
import pytest

import frictopt as fo
from helpers.formats_page import section
from helpers.gmsh_files import gmsh_with

FORMATS = [(4.1, 0), (4.1, 1), (2.2, 0), (2.2, 1)]  # version, and whether it is binary
PLATE = """
Point(1) = {0, 0, 0, .5}; Point(2) = {4, 0, 0, .5}; Point(3) = {4, 1, 0, .5}; Point(4) = {2, 1, 0, .5}; Point(5) = {0, 1, 0, .5};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {5, 4}; Line(5) = {5, 1};
Curve Loop(1) = {1, 2, 3, -4, 5}; Plane Surface(1) = {1};
"""


def plate(folder, groups, version=4.1, binary=0, save_all=0):
    """A plate of 4 x 1 by gmsh, with these physical groups."""
    (folder / "plate.geo").write_text(f"{PLATE}{groups}\n")
    with gmsh_with(
        **{"Mesh.MshFileVersion": version, "Mesh.Binary": binary, "Mesh.SaveAll": save_all}
    ) as gmsh:
        gmsh.open(str(folder / "plate.geo"))
        gmsh.model.mesh.generate(2)
        gmsh.write(str(folder / "plate.msh"))
    return fo.readers.read_mesh(folder / "plate.msh")


def lengths(mesh):
    """Length of each boundary."""
    ends = {name: mesh.p[:, mesh.facets[:, facets]] for name, facets in mesh.boundaries.items()}
    return {
        name: pytest.approx(float(np.linalg.norm(x[:, 1] - x[:, 0], axis=0).sum()))
        for name, x in ends.items()
    }


def area(mesh):
    """Area of all triangles."""
    a, b, c = mesh.p[:, mesh.t].transpose(1, 2, 0)
    return float(np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum() / 2)


@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_reversed_curves_and_entities_of_two_groups_are_kept(tmp_path, version, binary):
    groups = 'Physical Surface("plate") = {1}; Physical Surface("steel") = {1}; Physical Curve("bottom") = {1};'
    groups += 'Physical Curve("top") = {3, -4}; Physical Curve("turned") = {-4, -5}; Physical Curve(9) = {3}; Physical Point("corner") = {1};'
    mesh = plate(tmp_path, groups, version, binary)
    assert lengths(mesh) == {"top": 4.0, "bottom": 4.0, "turned": 3.0, "9": 2.0}
    assert area(mesh) == pytest.approx(4.0)
    assert {name: len(members) for name, members in mesh.subdomains.items()} == dict.fromkeys(
        ["plate", "steel"], mesh.nelements
    )
    fo.fem.Body(mesh)


@pytest.mark.parametrize("version", [4.1, 2.2])
def test_files_of_windows_have_the_same_groups(tmp_path, version):
    """A line of text may end with two characters; a curve in two groups stays in both."""
    groups = """
    Physical Surface("plate") = {1}; Physical Curve("bottom") = {1};
    Physical Curve("held") = {1, 2, -5};
    """
    plate(tmp_path, groups, version)
    text = (tmp_path / "plate.msh").read_bytes()
    (tmp_path / "windows.msh").write_bytes(text.replace(b"\n", b"\r\n"))
    mesh = fo.readers.read_mesh(tmp_path / "windows.msh")
    assert lengths(mesh) == {"bottom": 4.0, "held": 6.0}
    assert area(mesh) == pytest.approx(4.0)


@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_one_name_in_two_dimensions_is_a_body_and_a_boundary(tmp_path, version, binary):
    mesh = plate(
        tmp_path,
        'Physical Surface("pad", 7) = {1}; Physical Curve("pad", 3) = {2}; Physical Curve("low", 7) = {1};',
        version,
        binary,
    )
    assert lengths(mesh) == {"pad": 1.0, "low": 4.0} and list(mesh.subdomains) == ["pad"]


def test_what_is_in_no_group_needs_another_option_of_gmsh(tmp_path):
    groups = 'Physical Surface("plate") = {1}; Physical Curve("top") = {3, 4};'
    with pytest.raises(
        fo.ModelError,
        match=r"meshio cannot read .*; in gmsh set Mesh.SaveAll = 0, and put each body",
    ):
        plate(tmp_path, groups, save_all=1)
    with pytest.raises(
        fo.ModelError,
        match=r"'top': it names no faces; put the body beside it into a group too, and set Mesh.SaveAll = 0",
    ):
        plate(tmp_path, groups, version=2.2, save_all=1)
    assert lengths(plate(tmp_path, groups)) == {"top": 4.0}


def test_groups_of_curves_in_space_are_without_effect(tmp_path):
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    cells = [
        ("tetra", np.array([[0, 1, 2, 3]])),
        ("triangle", np.array([[0, 1, 3]])),
        ("line", np.array([[0, 1]])),
    ]
    tags = [np.array([4]), np.array([5]), np.array([6])]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    names = {"body": [4, 3], "side": [5, 2], "rim": [6, 1]}
    meshio.Mesh(points, cells, cell_data=data, field_data=names).write(
        tmp_path / "a.msh", file_format="gmsh22", binary=False
    )
    mesh = fo.readers.read_mesh(tmp_path / "a.msh")
    assert list(mesh.boundaries) == ["side"] and list(mesh.subdomains) == ["body"]


def test_other_versions_are_refused_by_number(tmp_path):
    groups = 'Physical Surface("plate") = {1};'
    with pytest.raises(
        fo.ModelError,
        match=r"plate\.msh: it has version 4 of gmsh's format; save it in version 4.1 or 2.2",
    ):
        plate(tmp_path, groups, version=4.0)
    assert list(plate(tmp_path, groups).subdomains) == ["plate"]


def test_numbers_of_groups_with_a_minus_are_those_of_the_groups(tmp_path):
    """In version 2.2, as other codes write it, sides 1 and 2 of a square are in group 7, one of
    them with a minus."""
    rows = ["1 1 2 7 1 1 2", "2 1 2 -7 2 2 3", "3 3 2 1 1 1 2 3 4"]
    text = [
        "$MeshFormat",
        "2.2 0 8",
        "$EndMeshFormat",
        "$Nodes",
        "4",
        "1 0 0 0",
        "2 1 0 0",
        "3 1 1 0",
        "4 0 1 0",
        "$EndNodes",
    ]
    (tmp_path / "a.msh").write_text(
        "\n".join([*text, "$Elements", "3", *rows, "$EndElements"]) + "\n"
    )
    assert lengths(fo.readers.read_mesh(tmp_path / "a.msh")) == {"7": 2.0}


def test_groups_of_salome_are_those_of_the_same_mesh_by_gmsh(tmp_path):
    """They are families of elements and of nodes; one element is in two groups."""
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
    cells = [("tetra", np.array([[0, 1, 2, 3], [0, 2, 1, 4]])), ("triangle", np.array([[0, 1, 3]]))]
    mesh = meshio.Mesh(
        points,
        cells,
        cell_data={"cell_tags": [np.array([-1, -2]), np.array([-3])]},
        point_data={"point_tags": np.array([1, 0, 1, 1, 0])},
    )
    mesh.cell_tags = {-1: ["high", "all"], -2: ["low", "all"], -3: ["side"]}
    mesh.point_tags = {1: ["wall"]}
    meshio.write(tmp_path / "two.med", mesh)
    found = fo.readers.read_mesh(tmp_path / "two.med")
    assert {name: members.tolist() for name, members in found.subdomains.items()} == {
        "high": [0],
        "low": [1],
        "all": [0, 1],
    }
    middles = {
        name: found.p[:, found.facets[:, members]].mean(axis=1).T.tolist()
        for name, members in found.boundaries.items()
    }
    assert middles == {
        "side": [pytest.approx([1 / 3, 0, 1 / 3])],
        "wall": [pytest.approx([0, 1 / 3, 1 / 3])],
    }


def test_a_library_that_a_format_needs_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.med").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(
        fo.ModelError, match=r"meshio needs h5py for .*a\.med'; python -m pip install h5py"
    ):
        fo.readers.read_mesh(tmp_path / "a.med")


@pytest.mark.parametrize(
    ("ending", "title"),
    [("mesh", "medit:ref"), ("avs", "avsucd:material"), ("vtu", "gmsh:physical")],
)
def test_numbers_of_groups_of_other_formats_are_names(tmp_path, ending, title):
    points = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)], dtype=float)
    cells = [("quad", np.array([[0, 1, 4, 5], [1, 2, 3, 4]])), ("line", np.array([[0, 1], [2, 3]]))]
    tags = [np.array([4, 5]), np.array([7, 7])]
    points = points if ending == "mesh" else np.pad(points, ((0, 0), (0, 1)))
    other = {"heat": [np.array([1.0, 2.0]), np.array([3.0, 4.0])]} if ending == "vtu" else {}
    meshio.Mesh(points, cells, cell_data={title: tags, **other}).write(tmp_path / f"a.{ending}")
    mesh = fo.readers.read_mesh(tmp_path / f"a.{ending}")
    assert lengths(mesh) == {"7": 2.0}
    assert {name: members.tolist() for name, members in mesh.subdomains.items()} == {
        "4": [0],
        "5": [1],
    }


@pytest.mark.parametrize("name", ["brick.e", "brick.EX2", "brick.exo", "brick.vtu"])
def test_quadratic_bricks_of_exodus_are_refused(name, tmp_path, monkeypatch):
    """meshio gives them the middle nodes of other edges, so that volumes are wrong."""
    lower = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    upper = lower + [0, 0, 1]
    middles = [(x + np.roll(x, -1, axis=0)) / 2 for x in (lower, upper)]
    points = np.vstack([lower, upper, *middles, (lower + upper) / 2])
    brick = meshio.Mesh(points, [("hexahedron20", np.arange(20)[None])])
    (tmp_path / name).touch()
    monkeypatch.setattr(meshio, "read", lambda file: brick)
    if name.endswith("vtu"):
        assert fo.readers.read_mesh(tmp_path / name).nelements == 1
        return
    with pytest.raises(fo.ModelError, match=f"{name}: hexahedron20: .*; write the mesh in another"):
        fo.readers.read_mesh(tmp_path / name)


CUBE = [(x, y, z) for z in (0, 1) for x, y in ((1, 0), (2, 0), (2, 1), (1, 1))]


def bulk_data(system="", more="", continued="+"):
    """A cube as one CHEXA of property 7, with a face of property 8, its nodes in some system."""

    def card(*fields):
        return "".join(f"{field!s:8}" for field in fields) + "\n"

    rows = [card("GRID", i, system, *map(float, x)) for i, x in enumerate(CUBE, 1)]
    rows += [card("CHEXA", 1, 7, *range(1, 7), continued), card(continued, 7, 8)]
    rows.append(card("CQUAD4", 2, 8, 5, 6, 7, 8))
    return f"SOL 101\nCEND\nBEGIN BULK\n{more}{''.join(rows)}ENDDATA\n"


def test_properties_of_nastran_are_names(tmp_path):
    (tmp_path / "a.bdf").write_text(bulk_data("0", "GRDSET                  \n"))
    mesh = fo.readers.read_mesh(tmp_path / "a.bdf")
    assert list(mesh.subdomains) == ["7"] and list(mesh.boundaries) == ["8"]
    assert np.all(mesh.p[:, mesh.facets[:, mesh.boundaries["8"]]][2] == 1)


@pytest.mark.parametrize(
    ("bulk", "source"),
    [
        (bulk_data("1"), "GRID"),
        (bulk_data(more="GRDSET          1\n"), "GRDSET"),
        (bulk_data(more="GRDSET,,1\n"), "GRDSET"),
    ],
)
def test_nastran_meshes_in_other_systems_are_refused(tmp_path, bulk, source):
    """Radii and angles of a cylindrical system would be taken for x and y."""
    (tmp_path / "a.nas").write_text(bulk)
    with pytest.raises(fo.ModelError, match=rf"a\.nas: .* in system 1, by its {source}; write all"):
        fo.readers.read_mesh(tmp_path / "a.nas")


def large(*fields):
    """A card of large fields, four on a line."""
    name, *entries = fields
    lines = [entries[i : i + 4] for i in range(0, len(entries), 4)]
    return "".join(
        f"{f'{name}*' if i == 0 else '*':8}" + "".join(f"{entry!s:16}" for entry in line) + "\n"
        for i, line in enumerate(lines)
    )


SOLID_AND_FACE = bulk_data().split("CHEXA")[0]
WRITTEN = {
    "second lines that begin with blanks": bulk_data(continued=""),
    "directions of displacements": bulk_data(more="GRDSET,,,,,,5\n"),
    "large fields": SOLID_AND_FACE
    + large("CHEXA", 1, 7, *range(1, 9))
    + large("CQUAD4", 2, 8, 5, 6, 7, 8, 0.0),
    "free fields": SOLID_AND_FACE + "CHEXA,1,7,1,2,3,4,5,6\n,7,8\nCQUADR,2,8,5,6,7,8,0.\n",
    "a file that is included": SOLID_AND_FACE + "INCLUDE 'more.bdf'\n",
    "no BEGIN BULK": bulk_data().split("BEGIN BULK\n")[1],
}  # fmt: skip


@pytest.mark.parametrize("how", WRITTEN)
def test_nastran_meshes_are_the_same_however_their_cards_are_written(tmp_path, how):
    (tmp_path / "a.bdf").write_text(WRITTEN[how])
    (tmp_path / "more.bdf").write_text("CHEXA" + bulk_data().split("CHEXA")[1])
    mesh = fo.readers.read_mesh(tmp_path / "a.bdf")
    assert mesh.p.T.tolist() == [list(map(float, x)) for x in CUBE]
    assert (mesh.nelements, list(mesh.subdomains)) == (1, ["7"])
    ((name, top),) = mesh.boundaries.items()
    assert name == "8"
    assert np.all(mesh.p[2][mesh.facets[:, top]] == 1)


def test_nastran_meshes_in_the_plane_have_lines_as_boundaries(tmp_path):
    grids = "".join(f"GRID,{i},,{x}.,{y}.,0.\n" for i, (x, y, _) in enumerate(CUBE[:4], 1))
    (tmp_path / "a.fem").write_text(f"{grids}CQUAD8,1,3,1,2,3,4\nCBAR,2,4,1,2\nCROD,3,,3,4\n")
    mesh = fo.readers.read_mesh(tmp_path / "a.fem")
    assert list(mesh.subdomains) == ["3"]
    # The property of a card without one has the number of the element: the CROD is named 3.
    assert lengths(mesh) == {"3": 1.0, "4": 1.0}


def test_nastran_elements_whose_nodes_are_in_another_order_are_refused(tmp_path):
    text = bulk_data().replace("ENDDATA", "CTRIAX6,9,1,1,2,3,4,5,6\nENDDATA")
    (tmp_path / "a.bdf").write_text(text)
    with pytest.raises(
        fo.ModelError, match=r"a\.bdf: CTRIAX6 9 is not read; give a mesh of solids"
    ):
        fo.readers.read_mesh(tmp_path / "a.bdf")


EDGES = {  # ends of the edges whose middles follow the corners, in the order of Nastran
    "CTETRA": ("000 100 010 001", "01 12 20 03 13 23"),
    "CHEXA": ("000 100 110 010 001 101 111 011", "01 12 23 30 04 15 26 37 45 56 67 74"),
    "CPENTA": ("000 100 010 001 101 011", "01 12 20 03 14 25 34 45 53"),
}


@pytest.mark.parametrize("name", EDGES)
def test_nastran_elements_need_all_of_their_midside_nodes_or_none(tmp_path, name):
    corners, edges = (words.split() for words in EDGES[name])
    points = [np.array([*map(float, corner)]) for corner in corners]
    points += [(points[int(a)] + points[int(b)]) / 2 for a, b in edges]
    count = len(points)
    grids = "".join(f"GRID,{i},,{x},{y},{z}\n" for i, (x, y, z) in enumerate(points, 1))

    def read(missing, more=()):
        nodes = ["" if i in missing else str(i) for i in range(1, count + 1)]
        fields = ["4", "1", *nodes, *more]
        lines = [",".join(["", *fields[i : i + 8]]) for i in range(0, len(fields), 8)]
        (tmp_path / "a.bdf").write_text(f"{grids}{name}" + "\n".join(lines) + "\n")
        return fo.readers.read_mesh(tmp_path / "a.bdf")

    whole, linear = read(()), read(range(len(corners) + 1, count + 1))
    assert whole.nelements >= 1
    assert linear.nelements == 1
    for place in (len(corners) + 1, count):
        with pytest.raises(
            fo.ModelError,
            match=rf"a\.bdf: {name} 4 has no node at place {place} of {count}, a midside node; give",
        ):
            read([place])
    with pytest.raises(fo.ModelError, match=f"{name} 4 has no node at place 3 of .*, a corner"):
        read([3])
    with pytest.raises(fo.ModelError, match=f"elements of type {name}{count + 1}; give solids"):
        read((), more=["1"])


def stray(folder, name):
    """A file with one solid, one of its faces, a face beside it, and their groups."""
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (4, 0, 0), (4, 1, 0), (4, 0, 1)])
    file = folder / name
    if name.endswith(("bdf", "inp")):
        rows = [",".join(map(str, (i, *map(float, x)))) for i, x in enumerate(points, 1)]
        text = "".join(f"GRID,{row.replace(',', ',,', 1)}\n" for row in rows)
        text += (
            "CTETRA,1,1,1,2,3,4\nCTRIA3,2,2,1,2,3\nCTRIA3,3,2,5,6,7\nCBAR,4,4,1,2\nCBAR,5,4,1,5\n"
        )
        if name.endswith("inp"):
            text = "*NODE\n" + "\n".join(rows) + "\n*ELEMENT, TYPE=C3D4, ELSET=1\n1, 1, 2, 3, 4\n"
            text += "*ELEMENT, TYPE=CPS3, ELSET=2\n2, 1, 2, 3\n3, 5, 6, 7\n"
            text += "*ELEMENT, TYPE=T3D2, ELSET=4\n4, 1, 2\n5, 1, 5\n"
            text += "*ELEMENT, TYPE=S3, ELSET=RIGID\n6, 1, 2, 5\n*ELEMENT, TYPE=R3D3, ELSET=RIGID\n7, 1, 5, 6\n"
        file.write_text(text)
        return file
    cells = [
        ("tetra", [[0, 1, 2, 3]]),
        ("triangle", [[0, 1, 2], [4, 5, 6]]),
        ("line", [[0, 1], [0, 4]]),
    ]
    tags = [np.array([1]), np.array([2, 2]), np.array([4, 4])]
    if name.endswith("med"):
        mesh = meshio.Mesh(points * 1.0, cells, cell_data={"cell_tags": [-tag for tag in tags]})
        mesh.cell_tags = {-1: ["1"], -2: ["2"], -4: ["4"]}
        meshio.med.write(file, mesh)
        return file
    title = "gmsh:physical" if name.endswith("msh") else "tag"
    data = {title: tags} | ({"gmsh:geometrical": tags} if name.endswith("msh") else {})
    mesh = meshio.Mesh(points * 1.0, cells, cell_data=data)
    mesh.write(file, **({"file_format": "gmsh22", "binary": False} if name.endswith("msh") else {}))
    return file


@pytest.mark.parametrize("name", ["a.med", "a.bdf", "a.inp", "a.msh", "a.vtu"])
def test_elements_beside_the_solids_are_left_out_with_one_warning(tmp_path, name):
    """Of two triangles one is a face of the solid, of two lines one is an edge."""
    with pytest.warns(fo.ModelWarning) as warned:
        mesh = fo.readers.read_mesh(stray(tmp_path, name))
    assert mesh.p.shape == (3, 4)
    assert list(mesh.subdomains) == ["1"]
    assert {group: len(facets) for group, facets in mesh.boundaries.items()} == {"2": 1}
    (text,) = [str(one.message) for one in warned]
    assert text.startswith(
        f"mesh {name}: elements that are neither solids nor their faces or edges"
    )
    assert "; if they are faces of a body, save that body in the file" in text
    types, groups = text.split("are left out: ")[1].split("; ")[0].split(" (in ")
    shapes = {"CPS3": "triangle", "T3D2": "line"}
    counts = [(one.split()[-1], one.split()[0]) for one in types.split(", ")]
    counts = {shapes.get(kind, kind): number for kind, number in counts}
    thin = {"S3": "1", "R3D3": "1"} if name == "a.inp" else {}
    assert counts == {"triangle": "1", "line": "1", **thin}
    assert groups == ("'2', '4', 'RIGID')" if thin else "'2', '4')")


WAYS = {
    "a.unv": "open it in gmsh and save it as .msh",
    "a.MAIL": r"in code_aster, .*FORMAT='MED'",
    "a.feb": r"in FEBio Studio, export the geometry as \.vtk",
    "a.frd": r"give the \.inp of the job; or, in cgx, .*rename all.msh, which is a deck, to all.inp",
    "a.xyz": r"convert it to \.inp, \.msh, \.med, \.bdf or \.vtu",
    "a": r"convert it to \.inp, \.msh",
}


@pytest.mark.parametrize("name", WAYS)
def test_formats_that_are_not_read_are_named_with_a_way_that_is(tmp_path, name):
    (tmp_path / name).write_text("    -1\n  2411\n    -1\n")
    with pytest.raises(fo.ModelError, match=rf"^mesh {name}: files .* not read; {WAYS[name]}"):
        fo.readers.read_mesh(tmp_path / name)


def test_partitioned_meshes_are_refused_by_their_name(tmp_path):
    (tmp_path / "plate.geo").write_text(f'{PLATE}Physical Surface("plate") = {{1}};\n')
    with gmsh_with() as gmsh:
        gmsh.open(str(tmp_path / "plate.geo"))
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.partition(2)
        gmsh.write(str(tmp_path / "plate.msh"))
        gmsh.model.mesh.unpartition()
        gmsh.write(str(tmp_path / "whole.msh"))
    with pytest.raises(fo.ModelError, match=r"plate\.msh: it is partitioned; save the mesh before"):
        fo.readers.read_mesh(tmp_path / "plate.msh")
    assert area(fo.readers.read_mesh(tmp_path / "whole.msh")) == pytest.approx(4.0)


TRIED = {  # rows of the page of formats, and the tests that try them
    "gmsh: groups of the bodies and of their faces (in the plane, their curves)": test_reversed_curves_and_entities_of_two_groups_are_kept,
    "gmsh: groups of points, and in space also groups of curves": test_groups_of_curves_in_space_are_without_effect,
    "gmsh: groups without elements": test_what_is_in_no_group_needs_another_option_of_gmsh,
    "gmsh: formats 4.1, 2.2": test_one_name_in_two_dimensions_is_a_body_and_a_boundary,
    "gmsh: format 4.0, 1": test_other_versions_are_refused_by_number,
    "gmsh: partitioned meshes in format 4.1": test_partitioned_meshes_are_refused_by_their_name,
    "gmsh: `Mesh.SaveAll = 1`": test_what_is_in_no_group_needs_another_option_of_gmsh,
    "Salome (`.med`): groups of elements and of nodes": test_groups_of_salome_are_those_of_the_same_mesh_by_gmsh,
    "Exodus: bricks of 20 or 27 nodes": test_quadratic_bricks_of_exodus_are_refused,
    "Nastran (`.bdf`, `.nas`, `.fem`): grid points and [solids](#nastran)": test_properties_of_nastran_are_names,
    "Nastran: `GRID` and `GRDSET` with CP": test_nastran_meshes_in_other_systems_are_refused,
    "Nastran: axisymmetric elements and `CQUAD`": test_nastran_elements_whose_nodes_are_in_another_order_are_refused,
    "Nastran: elements with only some of their midside nodes": test_nastran_elements_need_all_of_their_midside_nodes_or_none,
    "I-deas (`.unv`), code_aster (`.mail`), FEBio (`.feb`), results of CalculiX (`.frd`)": test_formats_that_are_not_read_are_named_with_a_way_that_is,
    "others: sets, and numbers of groups (`ref`, `tag`, `material`)": test_numbers_of_groups_of_other_formats_are_names,
    "others: all other data of nodes and cells": test_numbers_of_groups_of_other_formats_are_names,
}


def test_each_row_of_the_page_is_tried():
    assert re.findall(
        r"^\| (.*?) \| (?:kept|refused|without effect) \|", section("Mesh files"), re.MULTILINE
    ) == list(TRIED)
