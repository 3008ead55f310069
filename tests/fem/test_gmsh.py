"""Meshes that gmsh makes, in every kind of file that it writes.

They are the bodies that were drawn, and errors name omitted parts.
"""

import runpy
from pathlib import Path

import meshio
import numpy as np
import pytest
from skfem import MeshHex, MeshHex2, MeshQuad, MeshQuad2, MeshTet, MeshTet2, MeshTri, MeshTri2

import frictopt as fo
from helpers.gmsh_files import gmsh_with


def disc(files, solid, quads, **options):
    """A disc of radius 1 with quadratic elements of gmsh, in the plane or 1 thick.

    Its rim, or its upper side, has a name.
    """
    with gmsh_with(
        **{"Mesh.MeshSizeMax": 0.6, "Mesh.ElementOrder": 2, "Mesh.RecombineAll": quads, **options}
    ) as gmsh:
        flat = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
        lids = (
            gmsh.model.occ.extrude([(2, flat)], 0, 0, 1, [1], recombine=bool(quads))
            if solid
            else []
        )
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(2 + solid, [lids[1][1] if solid else flat], name="BODY")
        gmsh.model.addPhysicalGroup(
            1 + solid,
            [lids[0][1]] if solid else [tag for _, tag in gmsh.model.getEntities(1)],
            name="EDGE",
        )
        gmsh.model.mesh.generate(2 + solid)
        for file in files:
            gmsh.write(str(file))


@pytest.mark.parametrize("ending", ["msh", "inp", "vtu"])
@pytest.mark.parametrize(
    ("kind", "linear_kind", "solid", "quads"),
    [
        (MeshTri2, MeshTri, 0, 0),
        (MeshQuad2, MeshQuad, 0, 1),
        (MeshTet2, MeshTet, 1, 0),
        (MeshHex2, MeshHex, 1, 1),
    ],
)
def test_curved_meshes_are_read_with_the_nodes_amid_their_sides(
    tmp_path, kind, linear_kind, solid, quads, ending
):
    """The area of a disc with some 23 edges around is 2e-5 off with curved sides, and 1e-2 off
    through the corners. Faces of 8 nodes are completed."""
    path, made = tmp_path / f"a.{ending}", tmp_path / "made.msh"
    for incomplete in (1,) if ending == "inp" else (0, 1):
        disc(
            [made if ending == "vtu" else path],
            solid,
            quads,
            **{"Mesh.SecondOrderIncomplete": incomplete},
        )
        if ending == "vtu":
            whole = meshio.read(made)
            solids = [block for block in whole.cells if block.dim == 2 + solid]
            meshio.Mesh(whole.points, solids).write(path)
        mesh = fo.readers.read_mesh(path)
        body = fo.fem.Body(mesh, fo.fem.Material())
        assert type(mesh) is kind and body.element == "quadratic"
        corners = linear_kind(mesh.p[:, : mesh.nvertices], mesh.t, sort_t=False)
        volume, through_corners = (
            fo.fem.BodyForce("a", x=1.0)
            ._forces(part, "space" if solid else "plane_strain")[0]
            .sum()
            for part in (body, fo.fem.Body(corners))
        )
        assert volume == pytest.approx(np.pi, rel=1e-4) and through_corners < 0.99 * np.pi
        if ending != "vtu":
            size = (
                fo.fem.Traction("a", "EDGE", x=1.0)
                ._forces(body, "space" if solid else "plane_strain")[0]
                .sum()
            )
            assert size == pytest.approx(np.pi if solid else 2 * np.pi, rel=1e-3)
            assert sorted(mesh.subdomains)[0] == "BODY"


@pytest.mark.parametrize("ending", ["msh", "old.msh", "inp", "vtu"])
def test_quadratic_wedges_of_gmsh_keep_their_volume(tmp_path, ending):
    """Curved quadratic wedges have the volume and the faces that were drawn.

    A cube is extruded in wedges and then bent by x + 0.3 z^2 and y + 0.2 x^2, which keeps volumes,
    and which quadratic elements follow exactly. A wedge with middle nodes of other edges has
    another volume.
    """
    made = tmp_path / ("a.msh" if ending == "vtu" else f"a.{ending}")
    options = {"Mesh.MeshSizeMax": 0.6, "Mesh.SecondOrderIncomplete": 1}
    with gmsh_with(**options, **{"Mesh.MshFileVersion": 2.2 if "old" in ending else 4.1}) as gmsh:
        flat = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        sides = gmsh.model.occ.extrude([(2, flat)], 0, 0, 1, [2], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [sides[1][1]], name="BODY")
        gmsh.model.addPhysicalGroup(2, [flat], name="BOTTOM")
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, places, _ = gmsh.model.mesh.getNodes()
        for tag, (x, y, z) in zip(tags, places.reshape(-1, 3), strict=True):
            gmsh.model.mesh.setNode(tag, [x + 0.3 * z**2, y + 0.2 * x**2, z], [])
        gmsh.write(str(made))
    if ending == "vtu":
        whole = fo.readers.read_mesh(made)  # which makes meshio read quadratic wedges
        wedges = meshio.read(made)
        solids = [block for block in wedges.cells if block.type == "wedge15"]
        meshio.Mesh(wedges.points, solids).write(tmp_path / "a.vtu")
        mesh = fo.readers.read_mesh(tmp_path / "a.vtu")
        assert np.array_equal(mesh.p, whole.p) and np.array_equal(mesh.t, whole.t)
        return
    mesh = fo.readers.read_mesh(made)
    body = fo.fem.Body(mesh, fo.fem.Material())
    assert fo.fem.BodyForce("a", z=1.0)._forces(body, "space").sum() == pytest.approx(1.0)
    assert fo.fem.Traction("a", "BOTTOM", z=1.0)._forces(body, "space").sum() == pytest.approx(1.0)
    assert len(mesh.subdomains["BODY"]) == mesh.nelements


def cubes(
    kind,
    formats,
    *,
    bodies=("upper", "lower"),
    faces=("top", "middle", "bottom"),
    groups=(),
    options=(),
):
    """Two cubes that share their nodes, one above the other, meshed by gmsh."""
    with gmsh_with(**{"Mesh.MeshSizeMax": 0.5, **dict(options)}) as gmsh:
        boxes = {
            name: gmsh.model.occ.addBox(0, 0, z, 1, 1, 1)
            for name, z in (("upper", 0), ("lower", -1))
        }
        gmsh.model.occ.fragment([(3, boxes["upper"])], [(3, boxes["lower"])])
        gmsh.model.occ.synchronize()
        for name in bodies:
            gmsh.model.addPhysicalGroup(3, [boxes[name]], name=name)
        for name, z in (("top", 1), ("middle", 0), ("bottom", -1), ("nowhere", 5)):
            found = gmsh.model.getEntitiesInBoundingBox(
                -0.1, -0.1, z - 0.1, 1.1, 1.1, z + 0.1, dim=2
            )
            if name in (*faces, *groups):
                gmsh.model.addPhysicalGroup(2, [tag for _, tag in found], name=name)
        if kind is MeshHex:
            gmsh.model.mesh.setTransfiniteAutomatic()
        gmsh.model.mesh.generate(3)
        for path in formats:
            gmsh.write(str(path))


@pytest.mark.parametrize("kind", [MeshTet, MeshHex])
def test_cubes_of_gmsh_are_bodies_whatever_the_file(tmp_path, kind, caplog):
    files = [tmp_path / name for name in ("a.msh", "a.inp", "sets.inp", "old.msh", "binary.msh")]
    for file, options in zip(
        files,
        ({}, {}, {"Mesh.SaveGroupsOfNodes": 1}, {"Mesh.MshFileVersion": 2.2}, {"Mesh.Binary": 1}),
        strict=True,
    ):
        cubes(kind, [file], options=options)
    systems = []
    for file in files:
        mesh = fo.readers.read_mesh(file)
        assert type(mesh) is type(kind())
        up = str.upper if file.suffix == ".inp" else str
        levels = {up(name): z for name, z in (("top", 1.0), ("middle", 0.0), ("bottom", -1.0))}
        for name, z in levels.items():
            corners = mesh.p[:, mesh.facets[:, mesh.boundaries[name]]]
            sides = [corners[:, i] - corners[:, 0] for i in (1, 2)]
            area = np.linalg.norm(np.cross(*sides, axis=0), axis=0).sum() / (
                2 if kind is MeshTet else 1
            )
            assert np.all(corners[2] == z) and area == pytest.approx(1.0)
        bodies = fo.fem.split_bodies(
            mesh, {up("upper"): fo.fem.Material(), up("lower"): fo.fem.Material()}
        )
        assert sorted(set(bodies[up("upper")].mesh.boundaries) & {*levels, up("lower")}) == sorted(
            [up("top"), up("middle"), up("lower")]
        )
        model = fo.fem.ContactModel(
            bodies,
            supports=[fo.fem.Support(up("lower"), up("bottom"))],
            loads={"P": [fo.fem.Traction(up("upper"), up("top"), x=1.0, z=-2.0)]},
            contacts=[fo.fem.Contact(up("upper"), up("lower"), up("lower"), up("upper"))],
        )
        systems.append(model.condense())
        assert np.allclose(
            [*systems[-1].bonded["P"][0].sum(axis=0), systems[-1].bonded["P"][1].sum()],
            [-1.0, 0.0, 2.0],
            atol=1e-9,
        )
        assert np.allclose(systems[-1].S, systems[0].S, atol=1e-9) and not caplog.records


LEFT_OUT = [
    (
        {"bodies": ()},
        "a.msh: z varies by 2, and there are no solids; .* gmsh physical groups of the volumes",
    ),
    ({"groups": ("nowhere",)}, "a.msh: boundary 'nowhere': it names no faces"),
]


@pytest.mark.parametrize(("made", "message"), LEFT_OUT)
def test_what_gmsh_leaves_out_is_named(tmp_path, made, message):
    cubes(MeshTet, [tmp_path / "a.msh"], **made)
    with pytest.raises(fo.ModelError, match=message):
        fo.readers.read_mesh(tmp_path / "a.msh")


def test_the_faces_of_a_body_that_gmsh_leaves_out_are_warned_of(tmp_path):
    cubes(MeshTet, [tmp_path / "a.msh"], bodies=("upper",))
    with pytest.warns(
        fo.ModelWarning,
        match=r"a\.msh: .* left out: [0-9]+ of type triangle \(in 'bottom'\); if they are faces of",
    ):
        mesh = fo.readers.read_mesh(tmp_path / "a.msh")
    assert sorted(mesh.boundaries) == ["middle", "top"]
    assert sorted(mesh.subdomains) == ["upper"]


def test_bodies_that_share_nodes_are_told_to_split(tmp_path):
    cubes(MeshTet, [tmp_path / "a.msh"])
    both = fo.fem.Body(fo.readers.read_mesh(tmp_path / "a.msh"))
    with pytest.raises(
        fo.ModelError,
        match=r"facets inside the body; name facets of its outline .`split_bodies` gives",
    ):
        fo.fem.ContactModel(
            {"upper": both, "lower": both},
            [],
            {"P": [fo.fem.BodyForce("upper", z=-1)]},
            [fo.fem.Contact("upper", "lower", "middle", "middle")],
        )
    with pytest.raises(
        fo.ModelError, match=r"pair 1 is node 0 at \(0, 0\) twice, so both bodies share it"
    ):
        fo.condense(
            np.eye(4),
            {"P": [0, -1, 0, -1]},
            [[1, 0], [0, 0]],
            [0, 1],
            [[0, 1], [2, 3]],
            [[0, 0], [1, 0]],
        )


TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"


@pytest.mark.parametrize("name", ["blade", "flange", "lap"])
def test_a_script_has_the_bodies_and_boundaries_of_the_file(name, tmp_path, monkeypatch, capfd):
    """The nodes on both cuts of the quarter of the flange match, as those of the file do."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(TUTORIAL / f"{name}.py"))
    mesh, kept = fo.readers.read_mesh(f"{name}.msh"), fo.readers.read_mesh(TUTORIAL / f"{name}.msh")
    assert sorted(mesh.subdomains) == sorted(kept.subdomains)
    assert sorted(mesh.boundaries) == sorted(kept.boundaries)
    assert np.allclose(
        [mesh.p.min(axis=1), mesh.p.max(axis=1)], [kept.p.min(axis=1), kept.p.max(axis=1)]
    )
    for each in (mesh, kept) if name == "flange" else ():
        bodies = fo.fem.split_bodies(each, dict.fromkeys(each.subdomains, fo.fem.Material()))
        low, high = (bodies["lower"].boundary_nodes(side, "cut") for side in ("low", "high"))
        points = bodies["lower"].mesh.p
        turned = points[:, low][[1, 0, 2]] * [[-1], [1], [1]]
        apart = np.linalg.norm(turned[:, :, None] - points[:, None, high], axis=0)
        assert len(low) == len(high) > 20 and apart.min(axis=0).max() < 1e-8
