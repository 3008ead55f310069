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
    return fo.read_mesh(folder / "plate.msh")


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
    fo.Body(mesh)


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
    mesh = fo.read_mesh(tmp_path / "windows.msh")
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


@pytest.mark.parametrize(("version", "binary"), FORMATS)
def test_a_body_whose_name_is_the_number_of_a_curve(tmp_path, version, binary):
    mesh = plate(
        tmp_path, 'Physical Surface("3", 1) = {1}; Physical Curve(3) = {1};', version, binary
    )
    assert lengths(mesh) == {"3": 4.0} and list(mesh.subdomains) == ["3"]


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
    mesh = fo.read_mesh(tmp_path / "a.msh")
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
    """A group number with a minus is the number of the group.

    In version 2.2, as other codes write it, sides 1 and 2 of a square are in group 7, one of them
    with a minus.
    """
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
    assert lengths(fo.read_mesh(tmp_path / "a.msh")) == {"7": 2.0}


def test_groups_of_salome_are_those_of_the_same_mesh_by_gmsh(tmp_path):
    """Groups of Salome equal the groups of the same mesh by gmsh.

    They are families of elements and of nodes; one element is in two groups.
    """
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
    found = fo.read_mesh(tmp_path / "two.med")
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
        fo.read_mesh(tmp_path / "a.med")


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
    mesh = fo.read_mesh(tmp_path / f"a.{ending}")
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
        assert fo.read_mesh(tmp_path / name).nelements == 1
        return
    with pytest.raises(fo.ModelError, match=f"{name}: hexahedron20: .*; write the mesh in another"):
        fo.read_mesh(tmp_path / name)


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
    mesh = fo.read_mesh(tmp_path / "a.bdf")
    assert list(mesh.subdomains) == ["7"] and list(mesh.boundaries) == ["8"]
    assert np.all(mesh.p[:, mesh.facets[:, mesh.boundaries["8"]]][2] == 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (bulk_data("1"), r"a\.nas: GRID cards with coordinates in a system of their own"),
        (bulk_data(more="GRDSET          1\n"), "GRDSET with a system of coordinates"),
        (bulk_data(more="GRDSET,,1\n"), "GRDSET with a system of coordinates"),
        (bulk_data(more="INCLUDE 'other.bdf'\n"), "INCLUDE, which meshio passes over"),
        (bulk_data(continued="").replace(" \n", "\n"), "hexahedron with 6 nodes"),
    ],
)
def test_cards_of_nastran_that_meshio_passes_over_are_refused(tmp_path, text, message):
    """Radii and angles of a cylindrical system would be taken for x and y."""
    (tmp_path / "a.nas").write_text(text)
    with pytest.raises(fo.ModelError, match=message):
        fo.read_mesh(tmp_path / "a.nas")


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
        fo.read_mesh(tmp_path / "plate.msh")
    assert area(fo.read_mesh(tmp_path / "whole.msh")) == pytest.approx(4.0)


def test_other_files_are_read_after_gmsh_has_saved_them(tmp_path):
    """The remedies for files that meshio cannot read lead to the same groups.

    A file of I-deas (`.unv`), one of Salome, and one with parameters of nodes are opened in gmsh
    and saved as `.msh`. gmsh writes Nastran without BEGIN BULK.
    """
    groups = 'Physical Surface("plate") = {1}; Physical Curve("bottom") = {1};'
    plate(tmp_path, groups)
    with gmsh_with(**{"Mesh.SaveParametric": 1}) as gmsh:
        gmsh.open(str(tmp_path / "plate.geo"))
        gmsh.model.mesh.generate(2)
        for name in ("a.unv", "a.bdf", "a.med", "a.msh"):
            gmsh.write(str(tmp_path / name))
    remedies = {"a.unv": "open it in gmsh", "a.bdf": "BEGIN BULK", "a.msh": "SaveParametric = 0"}
    for name, remedy in remedies.items():
        with pytest.raises(fo.ModelError, match=rf"cannot read .*{name}'.*{remedy}"):
            fo.read_mesh(tmp_path / name)
    for name in ("a.unv", "a.med"):
        with gmsh_with() as gmsh:
            gmsh.open(str(tmp_path / name))
            gmsh.write(str(tmp_path / "b.msh"))
        mesh = fo.read_mesh(tmp_path / "b.msh")
        assert list(mesh.subdomains) == ["plate"] and lengths(mesh) == {"bottom": 4.0}
    text = (tmp_path / "a.bdf").read_text()
    (tmp_path / "b.bdf").write_text(f"BEGIN BULK\n{text}")
    assert area(fo.read_mesh(tmp_path / "b.bdf")) == pytest.approx(4.0, rel=1e-5)


TRIED = {  # rows of the page of formats, and the tests that try them
    "gmsh: groups of the bodies and of their faces (in the plane of curves)": test_reversed_curves_and_entities_of_two_groups_are_kept,
    "gmsh: groups of points, and in space of curves": test_groups_of_curves_in_space_are_without_effect,
    "gmsh: groups without elements": test_what_is_in_no_group_needs_another_option_of_gmsh,
    "gmsh: formats 4.1, 2.2": test_one_name_in_two_dimensions_is_a_body_and_a_boundary,
    "gmsh: format 4.0, 1": test_other_versions_are_refused_by_number,
    "gmsh: partitioned meshes in format 4.1": test_partitioned_meshes_are_refused_by_their_name,
    "gmsh: `Mesh.SaveAll = 1`": test_what_is_in_no_group_needs_another_option_of_gmsh,
    "Salome (`.med`): groups of elements and of nodes": test_groups_of_salome_are_those_of_the_same_mesh_by_gmsh,
    "Exodus: bricks of 20 or 27 nodes": test_quadratic_bricks_of_exodus_are_refused,
    "Nastran (`.bdf`, `.nas`, `.fem`): nodes and elements": test_properties_of_nastran_are_names,
    "Nastran: `GRID` and `GRDSET` with CP, `INCLUDE`, second lines that begin with blanks": test_cards_of_nastran_that_meshio_passes_over_are_refused,
    "others: sets, and numbers of groups (`ref`, `tag`, `material`)": test_numbers_of_groups_of_other_formats_are_names,
    "others: all other data of nodes and cells": test_numbers_of_groups_of_other_formats_are_names,
}


def test_each_row_of_the_page_is_tried():
    assert re.findall(
        r"^\| (.*?) \| (?:kept|refused|without effect) \|", section("Mesh files"), re.MULTILINE
    ) == list(TRIED)
