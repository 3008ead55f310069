"""Decks of wedges and of several shapes: meshes, and matrices beside what CalculiX computes."""

import numpy as np
import pytest
from skfem import Basis, Functional, MeshTet2, MeshTri2

import frictopt as fo
from helpers.calculix import displacements, run
from helpers.mixed import box, deck, node_set

LINES = [[0.0, 1.0, 2.5], [0.0, 0.5, 1.5], [0.0, 1.0]]


def volume(mesh):
    return Functional(lambda w: 1.0 + 0.0 * w.x[0]).assemble(Basis(mesh, mesh.elem()))


@pytest.mark.parametrize("shapes", [["wedge", "wedge"], ["hexahedron", "wedge"], ["tetra"] * 2])
def test_quadratic_elements_become_quadratic_tetrahedra(tmp_path, shapes):
    """Places of the nodes are those of x -> x + 0.1 x^2, whose volume is known."""

    def bent(x):
        return x + [0.1 * x[0] ** 2, 0.0, 0.0]

    order = 1 if "tetra" in shapes else 2
    points, elements = box(shapes, LINES, order, bent)
    sides = node_set("RIGHT", points, lambda x: abs(x[0] - 3.125) < 1e-9)
    sets = "*ELSET, ELSET=FIRST\n1,\n*SURFACE, NAME=S\nFIRST, S1\n"
    (tmp_path / "a.inp").write_text(deck(points, elements) + sides + sets)
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    assert isinstance(mesh, MeshTet2) == (order == 2)
    body = fo.fem.Body(mesh.with_boundaries({}))
    assert body.element == ("quadratic" if order == 2 else "linear")
    if order == 2:
        assert volume(mesh) == pytest.approx(3.125 * 1.5, rel=1e-12)
        assert len(mesh.boundaries["RIGHT"]) == 4
        # Each node lies where the map puts the middle of its straight edge.
        ends = mesh.edges
        x = mesh.p[0, ends].copy()
        straight = (np.sqrt(1 + 0.4 * x) - 1) / 0.2
        middle = straight.mean(axis=0)
        there = mesh.p[0, mesh.nvertices :]
        assert np.allclose(there, middle + 0.1 * middle**2, atol=1e-12)
        assert len(mesh.subdomains["FIRST"]) == (3 if shapes[0] == "wedge" else 6)
        assert len(mesh.boundaries["S"]) == (1 if shapes[0] == "wedge" else 2)


def test_quadratic_plane_elements_become_quadratic_triangles(tmp_path):
    (tmp_path / "a.inp").write_text(
        "*NODE\n" + "".join(f"{i}, {x}, {y}\n" for i, (x, y) in enumerate(PLANE, 1))
        + "*ELEMENT, TYPE=CPE8, ELSET=Q\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=CPE6, ELSET=T\n2, 2, 9, 3, 10, 11, 6\n*NSET, NSET=LOW\n1, 5, 2, 10, 9\n"
    )  # fmt: skip
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    assert isinstance(mesh, MeshTri2)
    assert mesh.nelements == 3
    assert volume(mesh) == pytest.approx(1.5)
    assert len(mesh.boundaries["LOW"]) == 2
    assert mesh.p[:, mesh.t[:3, mesh.subdomains["T"]]].shape == (2, 3, 1)


PLANE = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5), (2, 0), (1.5, 0), (1.5, 0.5)]  # fmt: skip


def test_linear_elements_beside_quadratic_ones_become_quadratic(tmp_path):
    low = box(["hexahedron"] * 2, LINES, 2)
    high = box(["hexahedron"] * 2, [*LINES[:2], [1.0, 2.0]], 1)
    (tmp_path / "a.inp").write_text(deck(*low, "LOW") + deck(*high, "HIGH", 1001))
    mesh = fo.readers.read_mesh(tmp_path / "a.inp")
    bodies = fo.fem.split_bodies(mesh, fo.fem.Material())
    assert {name: body.element for name, body in bodies.items()} == {
        "HIGH": "quadratic",
        "LOW": "quadratic",
    }
    assert volume(mesh) == pytest.approx(2 * 2.5 * 1.5)


@pytest.mark.ccx
@pytest.mark.parametrize("order", [1, 2])
def test_forces_on_triangles_and_quadrilaterals_are_those_of_calculix(tmp_path, order):
    """Under *DLOAD CalculiX moves its model as K and the reader's forces do."""
    points, elements = box(["hexahedron", "wedge"], LINES, order)
    sets = node_set("LOW", points, lambda x: x[2] == 0) + node_set(
        "HIGH", points, lambda x: x[2] == 1
    )
    text = deck(points, elements) + sets + "*NSET, NSET=ALL\nNBODY,\n*SURFACE, NAME=TOP\nBODY, S2\n"
    text += "*MATERIAL, NAME=M\n*ELASTIC\n2.1, 0.3\n*DENSITY\n1.\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n*BOUNDARY\nLOW, 1, 3\n"
    job = fo.readers.read_calculix(run(tmp_path, text)[0])
    theirs = displacements(tmp_path, text, "*DLOAD\nBODY, P2, 0.4\n")
    for where in ("HIGH", "TOP"):
        force = job.force(where, pressure=0.4)
        assert force.sum() == pytest.approx(-0.4 * 2.5 * 1.5, rel=1e-12)
        u = np.linalg.solve(job.K.toarray(), force)
        ours = np.where(job.unknowns >= 0, u[job.unknowns], 0.0)
        for number, row in zip(job.deck.numbers, ours, strict=True):
            assert np.allclose(row, theirs[int(number)], rtol=2e-5, atol=2e-6 * np.abs(ours).max())


def test_elements_of_unknown_kind_disturb_only_their_own_faces(tmp_path):
    points, elements = box(["hexahedron"], [[0.0, 1.0]] * 3)
    text = deck(points, elements) + node_set("LOW", points, lambda x: x[2] == 0)
    text += node_set("HIGH", points, lambda x: x[2] == 1)
    text += "*NODE\n" + "".join(f"{i}, {i}., 5., 5.\n" for i in range(101, 120))
    high = [str(1 + i) for i in np.flatnonzero(points[:, 2] == 1)]
    text += f"*ELEMENT, TYPE=C3D13, ELSET=ODD\n50, {', '.join(high)}, {', '.join(str(i) for i in range(101, 110))}\n"
    text += f"*ELEMENT, TYPE=S4, ELSET=SKIN\n51, {', '.join(map(str, range(1, 5)))}\n"
    (tmp_path / "a.inp").write_text(text)
    labels = [f"{n}.{d}" for n in range(1, 9) for d in (1, 2, 3)]
    (tmp_path / "a.dof").write_text("\n".join(labels) + "\n")
    (tmp_path / "a.sti").write_text("".join(f"{i} {i} 1.0\n" for i in range(1, 25)))
    job = fo.readers.read_calculix(tmp_path / "a")
    assert job.force("LOW", pressure=1.0).sum() == pytest.approx(1.0)
    with pytest.raises(fo.ModelError, match="type C3D13 have node 5 of the face, and their faces"):
        job.force("HIGH", pressure=1.0)
    with pytest.raises(
        fo.ModelError, match=r"elements of type C3D13; give solids.*read the matrix"
    ):
        fo.readers.read_mesh(tmp_path / "a.inp")
