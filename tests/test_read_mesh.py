"""Mesh files: what they name is kept, and what would be read wrongly is refused."""

import shutil
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from skfem import MeshHex, MeshHex2, MeshQuad, MeshQuad2, MeshTet, MeshTet2, MeshTri, MeshTri2

import frictopt as fo

DATA = Path(__file__).parent / "data"
POINTS = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [0, 1, 0], [9, 9, 0]], dtype=float)
QUADS = ("quad", [[0, 1, 4, 5], [1, 2, 3, 4]])


def write(path, cells, points=POINTS, sets=None, **options):
    meshio.Mesh(points, cells, cell_sets=sets or {}).write(path, **options)
    return path


def test_groups_of_gmsh_become_boundaries_and_subdomains(tmp_path):
    lines = ("line", [[0, 1], [1, 2], [3, 4]])
    tags = {"gmsh:physical": [np.array([1, 2]), np.array([3, 3, 4])], "gmsh:geometrical": [np.array([1, 2]), np.array([1, 1, 2])]}
    groups = {"first": np.array([1, 2]), "second": np.array([2, 2]), "bottom": np.array([3, 1]), "top": np.array([4, 1])}
    meshio.Mesh(POINTS, [QUADS, lines], cell_data=tags, field_data=groups).write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
    mesh = fo.read_mesh(tmp_path / "a.msh")
    assert isinstance(mesh, MeshQuad) and mesh.p.shape == (2, 6)  # the node of no element is left out
    named = {name: sorted(map(tuple, mesh.p[:, mesh.facets[:, facets]].mean(axis=1).T)) for name, facets in mesh.boundaries.items()}
    assert named == {"bottom": [(0.5, 0.0), (1.5, 0.0)], "top": [(1.5, 1.0)]}
    assert {name: elements.tolist() for name, elements in mesh.subdomains.items()} == {"first": [0], "second": [1]}


def test_a_file_of_gmsh_names_only_the_groups_of_its_author_and_is_read_in_silence(capfd):
    mesh = fo.read_mesh("docs/tutorial/foot.msh")
    assert sorted(mesh.subdomains) == ["block", "foot"] and sorted(mesh.boundaries) == ["bottom", "left", "right", "top"]
    assert capfd.readouterr() == ("", "")


def test_sets_of_a_deck_become_boundaries_and_subdomains(tmp_path):
    nodes = "".join(f"{i + 1}, {x}, {y}\n" for i, (x, y, _) in enumerate(POINTS))
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE=CPE3, ELSET=A\n1, 1, 2, 5\n2, 1, 5, 6\n*ELEMENT, TYPE=CPE3, ELSET=B\n3, 2, 3, 4\n4, 2, 4, 5\n"
    (tmp_path / "a.inp").write_text(deck + "*NSET, NSET=Bottom\n1, 2, 3\n*NSET, NSET=ONE\n4\n*ELSET, ELSET=UPPER\n2, 4\n")
    mesh = fo.read_mesh(tmp_path / "a.inp")
    assert isinstance(mesh, MeshTri) and mesh.p.shape == (2, 6) and list(mesh.boundaries) == ["BOTTOM"]
    assert mesh.p[1, mesh.facets[:, mesh.boundaries["BOTTOM"]]].tolist() == [[0, 0], [0, 0]]
    assert {name: elements.tolist() for name, elements in mesh.subdomains.items()} == {"A": [0, 1], "B": [2, 3], "UPPER": [1, 3]}


@pytest.mark.parametrize("name", ["a.msh", "a.vtk", "a.inp"])
def test_a_mixed_mesh_is_not_cut(tmp_path, name):
    if name == "a.inp":
        (tmp_path / name).write_text("*NODE\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,2,0\n*ELEMENT,TYPE=CPS4\n1,1,2,3,4\n*ELEMENT,TYPE=CPS3\n2,2,5,3\n")
    else:
        write(tmp_path / name, [("quad", [[0, 1, 4, 5]]), ("triangle", [[1, 2, 4]])])
    with pytest.raises(fo.ModelError, match="quad, triangle"):
        fo.read_mesh(tmp_path / name)


def disc(files, solid, quads, **options):
    """A disc of radius 1, in the plane or 1 thick, with quadratic elements of gmsh; its rim, or its upper side, has a name."""
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    gmsh.initialize(interruptible=False)
    try:
        for name, value in {"General.Terminal": 0, "Mesh.MeshSizeMax": 0.6, "Mesh.ElementOrder": 2, "Mesh.RecombineAll": quads, **options}.items():
            gmsh.option.setNumber(name, value)
        flat = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
        lids = gmsh.model.occ.extrude([(2, flat)], 0, 0, 1, [1], recombine=bool(quads)) if solid else []
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2 + solid, [lids[1][1] if solid else flat], name="BODY")
        gmsh.model.addPhysicalGroup(1 + solid, [lids[0][1]] if solid else [tag for _, tag in gmsh.model.getEntities(1)], name="EDGE")
        gmsh.model.mesh.generate(2 + solid)
        for file in files:
            gmsh.write(str(file))
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("ending", ["msh", "inp", "vtu"])
@pytest.mark.parametrize(("kind", "solid", "quads"), [(MeshTri2, 0, 0), (MeshQuad2, 0, 1), (MeshTet2, 1, 0), (MeshHex2, 1, 1)])
def test_curved_meshes_are_read_with_the_nodes_amid_their_sides(tmp_path, kind, solid, quads, ending):
    """The area of a disc, some 23 edges around, is 2e-5 off with curved sides, 1e-2 through the corners; 8-node faces are completed."""
    path, made = tmp_path / f"a.{ending}", tmp_path / "made.msh"
    for incomplete in (1,) if ending == "inp" else (0, 1):
        disc([made if ending == "vtu" else path], solid, quads, **{"Mesh.SecondOrderIncomplete": incomplete})
        if ending == "vtu":
            whole = meshio.read(made)
            solids = [block for block in whole.cells if block.dim == 2 + solid]
            meshio.Mesh(whole.points, solids).write(path)
        mesh = fo.read_mesh(path)
        body = fo.Body(mesh, fo.Material())
        assert type(mesh) is kind and body.element == "quadratic"
        volume, through_corners = (
            fo.BodyForce("a", x=1.0)._forces(part, "space" if solid else "plane_strain")[0].sum() for part in (body, body.through_corners)
        )
        assert volume == pytest.approx(np.pi, rel=1e-4) and through_corners < 0.99 * np.pi
        if ending != "vtu":
            size = fo.Traction("a", "EDGE", x=1.0)._forces(body, "space" if solid else "plane_strain")[0].sum()
            assert size == pytest.approx(np.pi if solid else 2 * np.pi, rel=1e-3) and sorted(mesh.subdomains)[0] == "BODY"


def test_mixed_meshes_are_refused_quadratic_ones_too(tmp_path):
    ring = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0], [1, 1, 0], [0.5, 1, 0], [1, 0.5, 0], [0.5, 0.5, 0]])
    write(tmp_path / "a.vtk", [("triangle6", [[0, 1, 2, 3, 4, 5]]), ("triangle", [[1, 6, 2]])], ring)
    with pytest.raises(fo.ModelError, match="elements triangle, triangle6; give elements of one shape, linear or quadratic"):
        fo.read_mesh(tmp_path / "a.vtk")
    nodes = "*NODE\n" + "".join(f"{i + 1},{x},{y}\n" for i, (x, y, _) in enumerate(ring))
    (tmp_path / "a.inp").write_text(nodes + "*ELEMENT,TYPE=CPE6\n1,1,2,3,4,5,6\n*ELEMENT,TYPE=CPE3\n2,2,7,3\n")
    with pytest.raises(fo.ModelError, match=r"mesh a.inp: deck: elements of several shapes, triangle, triangle6"):
        fo.read_mesh(tmp_path / "a.inp")
    (tmp_path / "b.inp").write_text(nodes + "*ELEMENT,TYPE=CPE6\n1,1,2,3,4,5,6\n2,2,7,3,9,8,10\n")
    with pytest.raises(fo.ModelError, match=r"the midside node at \(0.5, 0.5, 0\) is on an edge that has another one; merge nodes that coincide"):
        fo.read_mesh(tmp_path / "b.inp")
    solid = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 1, 1], [0, 1, 1], [1, 0, 1]], dtype=float)
    write(tmp_path / "b.vtk", [("tetra", [[0, 1, 2, 3]]), ("hexahedron", [[0, 1, 4, 2, 3, 7, 5, 6]])], solid)
    with pytest.raises(fo.ModelError, match="elements hexahedron, tetra"):
        fo.read_mesh(tmp_path / "b.vtk")
    write(tmp_path / "c.vtk", [("triangle", [[0, 1, 3]])], solid)
    with pytest.raises(fo.ModelError, match="z varies by 1"):
        fo.read_mesh(tmp_path / "c.vtk")
    write(tmp_path / "d.vtk", [("line", [[0, 1]])], solid)
    with pytest.raises(fo.ModelError, match="no elements"):
        fo.read_mesh(tmp_path / "d.vtk")


@pytest.mark.parametrize(("cells", "faces", "kind"), [("tetra", "triangle", MeshTet), ("hexahedron", "quad", MeshHex)])
def test_groups_of_gmsh_in_space(tmp_path, cells, faces, kind):
    """Two cubes one above the other, with names for the lowest face and for each cube."""
    made = kind.init_tensor([0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 2.0])
    low = np.flatnonzero(made.p[2, made.facets].max(axis=0) == 0)
    upper = (made.p[2, made.t].mean(axis=0) > 1).astype(int)
    order = [0, 3, 6, 2, 1, 5, 7, 4] if kind is MeshHex else slice(None)  # of gmsh, in that of scikit-fem
    blocks = [(cells, made.t[order].T), (faces, made.facets[:, low].T)]
    tags = {"gmsh:physical": [1 + upper, np.full(len(low), 3)], "gmsh:geometrical": [1 + upper, np.full(len(low), 1)]}
    groups = {"first": np.array([1, 3]), "second": np.array([2, 3]), "bottom": np.array([3, 2])}
    whole = meshio.Mesh(made.p.T, blocks, cell_data=tags, field_data=groups)
    whole.write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
    whole.write(tmp_path / "a.vtu")  # which has no names
    numbered = fo.read_mesh(tmp_path / "a.vtu")
    mesh = fo.read_mesh(tmp_path / "a.msh")
    assert {name: own.tolist() for name, own in numbered.boundaries.items()} == {"3": mesh.boundaries["bottom"].tolist()}
    assert {name: own.tolist() for name, own in numbered.subdomains.items()} == {
        k: mesh.subdomains[n].tolist() for k, n in (("1", "first"), ("2", "second"))
    }
    assert type(mesh) is type(made) and mesh.p.shape == made.p.shape and list(mesh.boundaries) == ["bottom"]
    assert len(mesh.boundaries["bottom"]) == len(low) and not mesh.p[2, mesh.facets[:, mesh.boundaries["bottom"]]].any()
    bodies = fo.split_bodies(mesh, {"first": fo.Material(), "second": fo.Material()})
    load = {"W": [fo.BodyForce("second", z=-3.0)]}
    system = fo.ContactModel(bodies, [fo.Support("first", "bottom")], load, [fo.Contact("second", "first", "first", "second")]).condense()
    assert system.nodes == 4 and system.bonded["W"][1].sum() == pytest.approx(3.0)


def test_a_deck_of_solids(tmp_path):
    nodes = "".join(f"{i + 1}, {x}, {y}, {z}\n" for i, (z, y, x) in enumerate(np.ndindex(2, 2, 2)))
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=A\n1, 1, 2, 4, 3, 5, 6, 8, 7\n*NSET, NSET=TOP\n5, 6, 7, 8\n"
    (tmp_path / "a.inp").write_text(deck)
    mesh = fo.read_mesh(tmp_path / "a.inp")
    assert isinstance(mesh, MeshHex) and np.all(mesh.p[2, mesh.facets[:, mesh.boundaries["TOP"]]] == 1) and mesh.subdomains["A"].tolist() == [0]
    assert fo.BodyForce("a", x=2.0)._forces(fo.Body(mesh), "space").sum() == pytest.approx(2.0)


def cubes(kind, formats, *, bodies=("upper", "lower"), faces=("top", "middle", "bottom"), groups=(), options=()):
    """Two cubes that share their nodes, one above the other, meshed by gmsh."""
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    gmsh.initialize(interruptible=False)
    try:
        for name, value in {"General.Terminal": 0, "Mesh.MeshSizeMax": 0.5, **dict(options)}.items():
            gmsh.option.setNumber(name, value)
        boxes = {name: gmsh.model.occ.addBox(0, 0, z, 1, 1, 1) for name, z in (("upper", 0), ("lower", -1))}
        gmsh.model.occ.fragment([(3, boxes["upper"])], [(3, boxes["lower"])])
        gmsh.model.occ.synchronize()
        for name in bodies:
            gmsh.model.addPhysicalGroup(3, [boxes[name]], name=name)
        for name, z in (("top", 1), ("middle", 0), ("bottom", -1), ("nowhere", 5)):
            found = gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, z - 0.1, 1.1, 1.1, z + 0.1, dim=2)
            if name in (*faces, *groups):
                gmsh.model.addPhysicalGroup(2, [tag for _, tag in found], name=name)
        if kind is MeshHex:
            gmsh.model.mesh.setTransfiniteAutomatic()
        gmsh.model.mesh.generate(3)
        for path in formats:
            gmsh.write(str(path))
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("kind", [MeshTet, MeshHex])
def test_cubes_of_gmsh_are_bodies_whatever_the_file(tmp_path, kind, caplog):
    files = [tmp_path / name for name in ("a.msh", "a.inp", "sets.inp", "old.msh", "binary.msh")]
    for file, options in zip(files, ({}, {}, {"Mesh.SaveGroupsOfNodes": 1}, {"Mesh.MshFileVersion": 2.2}, {"Mesh.Binary": 1}), strict=True):
        cubes(kind, [file], options=options)
    systems = []
    for file in files:
        mesh = fo.read_mesh(file)
        assert type(mesh) is type(kind())
        up = str.upper if file.suffix == ".inp" else str
        levels = {up(name): z for name, z in (("top", 1.0), ("middle", 0.0), ("bottom", -1.0))}
        for name, z in levels.items():
            corners = mesh.p[:, mesh.facets[:, mesh.boundaries[name]]]
            sides = [corners[:, i] - corners[:, 0] for i in (1, 2)]
            area = np.linalg.norm(np.cross(*sides, axis=0), axis=0).sum() / (2 if kind is MeshTet else 1)
            assert np.all(corners[2] == z) and area == pytest.approx(1.0)
        bodies = fo.split_bodies(mesh, {up("upper"): fo.Material(), up("lower"): fo.Material()})
        assert sorted(set(bodies[up("upper")].mesh.boundaries) & {*levels, up("lower")}) == sorted([up("top"), up("middle"), up("lower")])
        model = fo.ContactModel(
            bodies,
            supports=[fo.Support(up("lower"), up("bottom"))],
            loads={"P": [fo.Traction(up("upper"), up("top"), x=1.0, z=-2.0)]},
            contacts=[fo.Contact(up("upper"), up("lower"), up("lower"), up("upper"))],
        )
        systems.append(model.condense())
        assert np.allclose([*systems[-1].bonded["P"][0].sum(axis=0), systems[-1].bonded["P"][1].sum()], [-1.0, 0.0, 2.0], atol=1e-9)
        assert np.allclose(systems[-1].S, systems[0].S, atol=1e-9) and not caplog.records


LEFT_OUT = [
    ({"bodies": ()}, "a.msh: z varies by 2, and there are no solids; .* put the volumes of the bodies into groups"),
    ({"bodies": ("upper",)}, "a.msh: boundary 'bottom': [0-9]+ of its [0-9]+ faces belong to no element; put the body beside it into a group"),
    ({"groups": ("nowhere",)}, "a.msh: boundary 'nowhere': it names no faces"),
]


@pytest.mark.parametrize(("made", "message"), LEFT_OUT)
def test_what_gmsh_leaves_out_is_named(tmp_path, made, message):
    cubes(MeshTet, [tmp_path / "a.msh"], **made)
    with pytest.raises(fo.ModelError, match=message):
        fo.read_mesh(tmp_path / "a.msh")


def test_a_mesh_without_names_has_no_bodies(tmp_path):
    cubes(MeshTet, [tmp_path / "a.msh"], bodies=(), faces=())
    with pytest.raises(fo.ModelError, match=r"'upper' is unknown; this mesh names \[\]; name each body .* physical group of its volumes"):
        fo.split_bodies(fo.read_mesh(tmp_path / "a.msh"), {"upper": fo.Material()})


def test_bodies_that_share_nodes_are_told_to_split(tmp_path):
    cubes(MeshTet, [tmp_path / "a.msh"])
    both = fo.Body(fo.read_mesh(tmp_path / "a.msh"))
    with pytest.raises(fo.ModelError, match=r"facets inside the body; .* if two bodies share the nodes there, let `split_bodies` give each its own"):
        fo.ContactModel({"upper": both, "lower": both}, [], {"P": [fo.BodyForce("upper", z=-1)]}, [fo.Contact("upper", "lower", "middle", "middle")])
    with pytest.raises(fo.ModelError, match=r"pair 1 is node 0 at \(0, 0\) twice, so both bodies share it"):
        fo.condense(np.eye(4), {"P": [0, -1, 0, -1]}, [[1, 0], [0, 0]], [0, 1], [[0, 1], [2, 3]], [[0, 0], [1, 0]])


UNIT = {  # nodes of one element, and the middles of its faces S1, S2, ... as the manuals of CalculiX and Abaqus number them
    "C3D8": ("000 100 110 010 001 101 111 011", [(0.5, 0.5, 0), (0.5, 0.5, 1), (0.5, 0, 0.5), (1, 0.5, 0.5), (0.5, 1, 0.5), (0, 0.5, 0.5)]),
    "C3D4": ("000 100 010 001", [(1 / 3, 1 / 3, 0), (1 / 3, 0, 1 / 3), (1 / 3, 1 / 3, 1 / 3), (0, 1 / 3, 1 / 3)]),
    "CPE4": ("000 100 110 010", [(0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]),
    "CPS3": ("000 100 010", [(0.5, 0), (0.5, 0.5), (0, 0.5)]),
}


@pytest.mark.parametrize("kind", UNIT)
def test_surfaces_of_a_deck_are_faces_of_its_elements(tmp_path, kind):
    corners, middles = UNIT[kind]
    nodes = "".join(f"{i}, {', '.join(corner)}\n" for i, corner in enumerate(corners.split(), start=1))
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE={kind}, ELSET=ALL\n7, {', '.join(map(str, range(1, 1 + len(corners.split()))))}\n"
    deck += "".join(f"*SURFACE, NAME=Face{i}\n{'ALL' if i % 2 else 7}, S{i}\n" for i in range(1, 1 + len(middles)))
    (tmp_path / "a.inp").write_text(deck + "*SURFACE, TYPE=ELEMENT, NAME=BOTH\nALL, S1\nALL, S2\n*SURFACE, NAME=SHELL\nALL, SPOS\n")
    mesh = fo.read_mesh(tmp_path / "a.inp")
    found = {name: mesh.p[:, mesh.facets[:, facets]].mean(axis=1).T for name, facets in mesh.boundaries.items()}
    assert sorted(found) == sorted(["BOTH", *(f"FACE{i}" for i in range(1, 1 + len(middles)))])
    for i, middle in enumerate(middles, start=1):
        assert np.allclose(found[f"FACE{i}"], [middle])
    assert sorted(found["BOTH"].tolist()) == sorted([*found["FACE1"].tolist(), *found["FACE2"].tolist()])
    for line, message in (
        (f"ALL, S{len(middles) + 1}\n" if len(middles) < 6 else "NONE, S1\n", "surface BAD: face S|a surface names 'NONE'"),
        ("9, S1\n", None),
    ):
        (tmp_path / "b.inp").write_text(deck + "*SURFACE, NAME=BAD\n" + line)
        if message is None:
            assert "BAD" not in fo.read_mesh(tmp_path / "b.inp").boundaries
            continue
        with pytest.raises(fo.ModelError, match=message):
            fo.read_mesh(tmp_path / "b.inp")


@pytest.mark.parametrize("name", ["none.msh", "none.inp", "none.xyz"])
def test_missing_files_are_named(tmp_path, name, capsys):
    with pytest.raises(fo.ModelError, match=name):
        fo.read_mesh(tmp_path / name)


@pytest.mark.parametrize(("name", "text"), [("a.msh", "$MeshFormat\nnonsense\n"), ("a.vtk", "nonsense\n"), ("a.xdmf", "<Xdmf/>")])
def test_damaged_files_do_not_end_the_process(tmp_path, name, text, capsys):
    (tmp_path / name).write_text(text)
    with pytest.raises(fo.ModelError, match=rf"{name}.*meshio cannot read it"):
        fo.read_mesh(tmp_path / name)


def test_one_mesh_of_pin_and_plate_is_the_scene():
    """The file has the nodes of the scene below, those of the ring once, and both bodies as physical groups."""
    mesh = fo.read_mesh(DATA / "pin.msh")
    material = fo.Material()
    read = fo.ContactModel(
        bodies=fo.split_bodies(mesh, {"pin": material, "plate": material}),
        contacts=[fo.Contact("pin", "plate", "plate", "pin", name="ring")],
        supports=[fo.Support("plate", (-6, -6)), fo.Support("plate", (6, -6), "y")],
        loads={"fit": [fo.Interference("ring")], "sigma": [fo.Traction("plate", "right", x=1.0), fo.Traction("plate", "left", x=-1.0)]},
    ).condense()
    scene = fo.scenes.PinInPlate(elements=24, plate_half_width=6.0, growth=1.5).condense()
    assert np.abs(read.S - scene.S).max() < 1e-10 * np.abs(scene.S).max() and np.allclose(read.normals, scene.normals, atol=1e-12)
    for name in ("fit", "sigma"):
        assert np.allclose(read.bonded[name], scene.bonded[name], atol=1e-10)


def test_without_meshio_all_but_mesh_files_works():
    """The first command of the README installs no meshio."""
    code = (
        "import sys; sys.modules['meshio'] = None\n"
        "import frictopt as fo, studies.__main__\n"
        "print(fo.scenes.PunchOnHalfPlane(elements=2, growth=3.0).condense().nodes)\n"
        "try:\n    fo.read_mesh('tests/data/pin.msh')\nexcept fo.ModelError as error:\n    print(error)"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=Path(__file__).parents[1]).stdout
    assert said.split("\n")[0] == "3" and "install frictopt with its extra `mesh`" in said


OF_GMSH = "*Heading\n a.inp\n*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 2, 0\n6, 1, 2, 0\n******* E L E M E N T S *************\n"
OF_GMSH += "*ELEMENT, type=T3D2, ELSET=Line1\n1, 1, 2\n*ELEMENT, type=T3D2, ELSET=Line2\n2, 3, 4\n"
OF_GMSH += "*ELEMENT, type=CPS4, ELSET=Surface1\n3, 1, 2, 3, 4\n*ELEMENT, type=CPS4, ELSET=Surface2\n4, 4, 3, 6, 5\n"
OF_GMSH += "*ELSET,ELSET=bottom\n1,\n*ELSET,ELSET=between\n2,\n*ELSET,ELSET=upper\n4,\n*NSET,NSET=bottom\n1, 2,\n*NSET,NSET=top\n5, 6,\n"


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_named_curves_of_a_deck_of_gmsh_are_boundaries_within_the_mesh_too(tmp_path, mark):
    (tmp_path / "a.inp").write_text(mark + OF_GMSH, encoding="utf-8")
    mesh = fo.read_mesh(tmp_path / "a.inp")
    middles = {name: mesh.p[:, mesh.facets[:, facets]].mean(axis=1).T.tolist() for name, facets in mesh.boundaries.items()}
    assert middles == {"BOTTOM": [[0.5, 0]], "BETWEEN": [[0.5, 1]], "TOP": [[0.5, 2]], "LINE1": [[0.5, 0]], "LINE2": [[0.5, 1]]}
    assert {name: elements.tolist() for name, elements in mesh.subdomains.items()} == {"SURFACE1": [0], "SURFACE2": [1], "UPPER": [1]}


@pytest.mark.parametrize("version", ["gmsh22", "gmsh"])
def test_curves_within_the_mesh_keep_their_names_in_each_version(tmp_path, version):
    """gmsh counts the groups of each dimension by themselves: group 1 is a curve and a surface."""
    cells = [("quad", [[0, 1, 4, 5], [1, 2, 3, 4]]), ("line", [[0, 1], [1, 4]])]
    if version == "gmsh22":
        tags = [np.array([1, 2]), np.array([1, 2])]
        groups = {"first": np.array([1, 2]), "second": np.array([2, 2]), "bottom": np.array([1, 1]), "between": np.array([2, 1])}
        mesh = meshio.Mesh(POINTS, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags}, field_data=groups)
        mesh.write(tmp_path / "a.msh", file_format="gmsh22", binary=False)
    else:
        shutil.copy(DATA / "curves.msh", tmp_path / "a.msh")
    mesh = fo.read_mesh(tmp_path / "a.msh")
    middles = {name: mesh.p[:, mesh.facets[:, facets]].mean(axis=1).T.tolist() for name, facets in mesh.boundaries.items()}
    assert middles == {"bottom": [[0.5, 0]], "between": [[1, 0.5]]}
    assert {name: elements.tolist() for name, elements in mesh.subdomains.items()} == {"first": [0], "second": [1]}
