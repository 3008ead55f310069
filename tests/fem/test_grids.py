"""Grids of PyVista are compared with the model, its loads, and each body with the other."""

import sys

import numpy as np
import pytest
import pyvista
from skfem import Basis, MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.meshes import box, turned

CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])


@pytest.fixture(scope="module")
def punch():
    model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    return model, fo.steady_state(model.condense(), CYCLE, friction=0.5, load_factor=2.0)


def at(block, points):
    """Displacements of a body at some of its nodes."""
    return np.array(
        [
            block["displacement"][
                np.flatnonzero(np.abs(block.points - point).max(axis=1) < 1e-9)[0]
            ]
            for point in points
        ]
    )


def facing(block, what="normal"):
    """Normals of the cells of its surface as they are counted, or their centres."""
    surface = block.extract_surface(algorithm="dataset_surface")
    surface = surface.compute_normals(
        consistent_normals=False, auto_orient_normals=False, split_vertices=False
    )
    return surface.cell_data["Normals"] if what == "normal" else surface.cell_centers().points


def check_state(blocks, one, two):
    """Check the face and the motions of a state.

    The face is at the place of body 1, and slip and gap are the motion of body 1 relative to body
    2.
    """
    face = blocks["contact"]
    moved = at(blocks[one], face.points)
    assert np.allclose(face["displacement"], moved, rtol=0, atol=1e-12)
    apart = moved - at(blocks[two], face.points)
    assert np.allclose(
        face["slip"] + face["gap"][:, None] * face["normal"],
        apart,
        rtol=0,
        atol=1e-9 * np.abs(moved).max(),
    )
    for name in (one, two):
        s = blocks[name]["stress"]
        xx, yy, zz, xy, yz, xz = s.T
        tensors = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)
        a, b, c = np.linalg.eigvalsh(tensors).T
        assert np.allclose(
            blocks[name]["von_mises"], np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) / 2)
        )
    return face


def test_a_cycle_of_the_plane(tmp_path, punch):
    """A steady state has its last corner and the work of its cycle, in a file of VTK, too."""
    model, steady = punch
    grids = model.grids(steady)
    assert grids.keys() == ["punch", "block", "contact"]
    face = check_state(grids, "punch", "block")
    total = face.integrate_data()
    # The mean pressure over 2, and nothing along x.
    assert np.allclose(total["pressure"], 2.0)
    assert np.allclose(total["shear"], 0.0, atol=1e-9)
    assert face.n_cells == 8
    work = face["work_density"] @ model.condense().width
    assert work == pytest.approx(steady.dissipation)
    mesh = model.bodies["punch"].mesh
    assert np.allclose(grids["punch"].points[:, :2].T, mesh.p)
    assert grids["punch"]["stress"].shape == (mesh.p.shape[1], 6)
    grids.save(tmp_path / "punch.vtm")
    read = pyvista.read(tmp_path / "punch.vtm")
    assert np.array_equal(read["contact"]["gap"], face["gap"])
    bare = model.grids()
    assert bare.keys() == grids.keys() and bare["block"].n_cells == grids["block"].n_cells


@pytest.mark.parametrize("kind", [MeshHex, MeshTet])
def test_a_state_in_space(kind):
    """The grids of a state in space have the resultants of the loads.

    A column on a block is under pressure and shear. The traction of the loads on the body above is
    opposite to the traction on the face.
    """
    x = np.linspace(0, 1, 4)
    above, below = (
        box(kind, x, x, z) for z in (np.array([0.0, 0.5, 1.0]), np.array([-1.0, -0.5, 0.0]))
    )
    model = fo.fem.ContactModel(
        {"upper part": fo.fem.Body(above), "lower": fo.fem.Body(below)},
        [fo.fem.Support("lower", "z-")],
        {
            "P": [fo.fem.Traction("upper part", "z+", z=-3.0)],
            "Q": [fo.fem.Traction("upper part", "z+", x=0.5, y=-0.25)],
        },
    )
    rng = np.random.default_rng(1)
    slip, gap = 1e-3 * rng.normal(size=(16, 2)), np.zeros(16)
    blocks = model.grids(model.recover({"P": 1.0, "Q": 1.0}, slip, gap))
    face = check_state(blocks, "upper part", "lower")
    stress = blocks["upper part"].integrate_data()["stress"][0]
    # Over its height of 1 the stress is the traction, in the mean.
    assert np.allclose(stress[[5, 4, 2]], [0.5, -0.25, -3.0], atol=0.01)
    corners, areas = face.cells.reshape(face.n_cells, -1)[:, 1:], face.compute_cell_sizes()["Area"]
    # The share of each node in the area; the cells are equal.
    share = np.bincount(corners.ravel(), np.repeat(areas / corners.shape[1], corners.shape[1]))
    assert np.isclose(share.sum(), 1.0) and face.n_cells == (9 if kind is MeshHex else 18)
    assert np.allclose(share @ face["pressure"], 3.0)
    assert np.allclose(share @ face["shear"], [-0.5, 0.25, 0.0])
    assert "status" not in face.point_data


@pytest.mark.parametrize("mirror", [1.0, -1.0])
@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kind", [MeshTri, MeshQuad, MeshTet, MeshHex])
def test_cells_are_right_handed_however_the_mesh_counts(kind, element, mirror):
    """Otherwise VTK takes their volumes for negative, and integrals and fluxes are wrong.
    Tetrahedra of scikit-fem are of either hand."""
    d, x = kind().dim(), np.linspace(0, 1, 3)
    across = np.diag([mirror, *[1.0] * (d - 1)])
    bodies = {
        name: fo.fem.Body(turned(box(kind, *[x] * (d - 1), x + low), across), element=element)
        for name, low in (("a", 0.0), ("b", -1.0))
    }
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("b", f"{'xyz'[d - 1]}-")],
        {"P": [fo.fem.Pressure("a", f"{'xyz'[d - 1]}+")]},
    )
    fields = model.recover({"P": 1.0}, np.zeros(model.condense().slip_shape))
    blocks = model.grids(fields)
    for name, body in bodies.items():
        block, mesh = blocks[name], body.mesh
        assert block.compute_cell_sizes()["Volume" if d == 3 else "Area"].min() > 0
        # One place in each element.
        whole = Basis(
            mesh, mesh.elem(), quadrature=(np.array([[0.2], [0.3], [0.1]])[:d], np.ones(1))
        )
        inside = np.asarray(whole.global_coordinates())[..., 0].T
        found = pyvista.PolyData(np.pad(inside, ((0, 0), (0, 3 - d)))).sample(block)[
            "displacement"
        ][:, :d]
        expected = np.column_stack(
            [np.asarray(whole.interpolate(u))[:, 0] for u in fields.displacement[name]]
        )
        assert np.allclose(found, expected, rtol=0, atol=1e-3 * abs(expected).max())
        out = facing(block)
        assert (
            np.allclose(out, [0, 0, 1])
            if d == 2
            else (np.sum(out * (facing(block, "centre") - block.center), axis=1) > 0).all()
        )
    face = blocks["contact"]
    assert d == 2 or np.allclose(facing(face), face["normal"][0])


def test_what_has_no_grids_is_refused(punch, monkeypatch):
    model, steady = punch
    other = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.5).model()
    with pytest.raises(fo.ModelError, match="result: 3; give fields"):
        model.grids(3)
    message = "model: its reactions differ from those of the steady state by"
    with pytest.raises(fo.ModelError, match=message):
        other.grids(steady)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(fo.ModelError, match=r"pyvista: not installed; .*frictopt\[view\]"):
        model.grids()
