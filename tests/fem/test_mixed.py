"""Wedges, and bodies of several shapes: uniform stress, normals, scikit-fem's own wedges."""

import numpy as np
import pytest
from skfem import MeshHex, MeshWedge1

import frictopt as fo
from helpers.mixed import box, deck

LINES = [[0.0, 1.0, 2.5, 3.0, 4.0], [0.0, 0.5, 1.5], [0.0, 1.0, 1.5]]
COLUMNS = ["hexahedron", "wedge", "pyramid", "tetra"]
NAMES = {"low": 0.0, "high": 1.5}


def mesh_of(folder, points, elements):
    (folder / "a.inp").write_text(deck(points, elements))
    return fo.readers.read_mesh(folder / "a.inp")


@pytest.fixture
def mixed(tmp_path):
    mesh = mesh_of(tmp_path, *box(COLUMNS, LINES))
    named = {name: lambda x, z=z: x[2] == z for name, z in NAMES.items()}
    return mesh.with_boundaries(
        named | {"left": lambda x: x[0] == 0.0, "right": lambda x: x[0] == 4}
    )


def test_all_shapes_share_one_outline(mixed):
    assert mixed.nelements == 2 * 2 * (1 + 2 + 6 + 8)
    corners = mixed.p.T[mixed.facets[:, mixed.boundary_facets()].T]
    arms = corners - corners[:, :1]
    areas = np.linalg.norm(np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1), axis=1) / 2
    assert areas.sum() == pytest.approx(2 * (4 * 1.5 + 4 * 1.5 + 1.5 * 1.5))
    # two triangles on each end of each column of wedges and of tetrahedra
    triangles = np.count_nonzero(
        [len(set(row)) == 3 for row in mixed.facets[:, mixed.boundary_facets()].T.tolist()]
    )
    assert triangles == 2 * 2 * 2 * 2


def test_a_body_of_all_shapes_carries_uniform_stress(mixed):
    """A bar of nu = 0.3 under tension along x: u = x t / E, v = -nu y t / E, w likewise."""
    steel = fo.fem.Material(E=2.0, nu=0.3)
    block = MeshHex.init_tensor(
        *(np.linspace(low, high, 3) for low, high in ((4, 5), (0, 1.5), (0, 1.5)))
    )
    block = block.with_boundaries({"left": lambda x: x[0] == 4, "right": lambda x: x[0] == 5})
    for names in (("a", "b", "right", "left"), ("b", "a", "left", "right")):
        model = fo.fem.ContactModel(
            {"a": fo.fem.Body(mixed, steel), "b": fo.fem.Body(block, steel)},
            [
                fo.fem.Support("a", "left", "x"),
                fo.fem.Support("a", (0.0, 0.0, 0.0), "yz"),
                fo.fem.Support("a", (0.0, 1.5, 0.0), "z"),
            ],
            {"t": [fo.fem.Traction("b", "right", x=0.7)]},
            [fo.fem.Contact(*names)],
        )
        p = np.asarray(model.condense().bonded["t"][1])
        assert -p.sum() == pytest.approx(0.7 * 1.5 * 1.5, rel=1e-12)
        fields = model.recover({"t": 1.0}, slip=np.zeros((len(p), 2)))
        x = mixed.p
        assert np.allclose(
            fields.displacement["a"], np.array([x[0], -0.3 * x[1], -0.3 * x[2]]) * 0.35, atol=1e-12
        )
        assert np.allclose(fields.stress["a"][0], 0.7, atol=1e-9)
        assert np.allclose(fields.stress["a"][1:], 0.0, atol=1e-9)


def test_faces_of_triangles_and_quadrilaterals_pass_pressure_on(mixed):
    """A stack of two such boxes turned against each other: each node carries its area."""
    turned = mixed.p * np.array([[-1.0], [-1.0], [1.0]]) + np.array([[4.0], [1.5], [1.5]])
    upper = type(mixed)(turned, mixed.t, mixed.boundaries)
    rubber = fo.fem.Material(E=1.0, nu=0.0)
    system = fo.fem.ContactModel(
        {"upper": fo.fem.Body(upper, rubber), "lower": fo.fem.Body(mixed, rubber)},
        [fo.fem.Support("lower", "low")],
        {"P": [fo.fem.Pressure("upper", "high", 2.0)]},
        [fo.fem.Contact("upper", "lower", "low", "high")],
    ).condense()
    q, p = system.bonded["P"]
    assert p.sum() == pytest.approx(2.0 * 4.0 * 1.5, rel=1e-12)
    assert np.allclose(p / system.width, 2.0, rtol=1e-9)
    assert np.allclose(q, 0.0, atol=1e-9)


def on_spheres(x):
    """A box of 4 by 1.5 by 1.5 whose face z = 0 becomes a part of a sphere of radius 5."""
    arm = np.array([x[0] - 2.0, x[1] - 0.75, -5.0])
    return (5.0 + x[2]) * arm / np.linalg.norm(arm)


def test_normals_of_triangles_beside_quadrilaterals_are_radial_within_a_part_of_a_sphere(tmp_path):
    """Weighted normals are exact on spheres (Max 1999) at nodes that facets surround."""
    points, elements = box(["wedge", "hexahedron", "pyramid", "tetra"], LINES, bent=on_spheres)
    cup = mesh_of(tmp_path, points, elements)
    ball = MeshHex.init_tensor(np.array(LINES[0]), np.array(LINES[1]), np.linspace(-1.0, 0.0, 3))
    ball = MeshHex(np.array([on_spheres(x) for x in ball.p.T]).T, ball.t)

    def radius(x):
        return np.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2)

    # The middles of facets lie within the sphere.
    cup = cup.with_boundaries(
        {"face": lambda x: radius(x) < 5.01, "back": lambda x: radius(x) > 6.3}
    )
    ball = ball.with_boundaries(
        {"face": lambda x: radius(x) > 4.85, "back": lambda x: radius(x) < 4.01}
    )
    system = fo.fem.ContactModel(
        {"cup": fo.fem.Body(cup), "ball": fo.fem.Body(ball)},
        [fo.fem.Support("cup", "back"), fo.fem.Support("ball", "back")],
        {"g": [fo.fem.BodyForce("cup", z=1.0)]},
        [fo.fem.Contact("cup", "ball", "face", "face", gap="measured")],
    ).condense()
    assert system.nodes == len(LINES[0]) * len(LINES[1])
    on_rim = [
        on_spheres((x, y, 0.0)) for x in LINES[0] for y in LINES[1] if x in (0, 4) or y in (0, 1.5)
    ]
    inside = np.array([np.abs(on_rim - point).max(axis=1).min() > 1e-6 for point in system.points])
    assert inside.sum() == 3
    cosines = np.abs(np.sum(system.normals * system.points, axis=1)) / 5.0
    assert cosines[inside] == pytest.approx(1.0, abs=1e-12)


def test_wedges_of_scikit_fem_are_bodies():
    """A prism of E = 1, nu = 0 pressed by 1 at one end: its contact carries 1 per area."""
    wedges = MeshWedge1()
    above = wedges.with_boundaries({"contact": lambda x: x[2] == 0, "top": lambda x: x[2] == 1})
    below = MeshHex.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 1, 3), np.array([-1.0, 0.0]))
    below = below.with_boundaries({"contact": lambda x: x[2] == 0, "bottom": lambda x: x[2] == -1})
    rubber = fo.fem.Material(nu=0.0)
    model = fo.fem.ContactModel(
        {"above": fo.fem.Body(above, rubber), "below": fo.fem.Body(below, rubber)},
        [fo.fem.Support("below", "bottom")],
        {"P": [fo.fem.Pressure("above", "top", 1.0)]},
    )
    system = model.condense()
    assert np.allclose(system.bonded["P"][1], system.width)
    assert sorted(system.width.round(9).tolist()) == [
        round(v, 9) for v in (1 / 6, 1 / 6, 1 / 3, 1 / 3)
    ]
    assert np.allclose(
        model.recover({"P": 1.0}, slip=np.zeros((4, 2))).displacement["above"][2], -above.p[2] - 1.0
    )
    parts = fo.fem.split_bodies(
        wedges.with_subdomains({"a": [0], "b": [1]}), dict.fromkeys("ab", rubber)
    )
    assert sorted(parts["a"].mesh.boundaries) == ["b"]


def test_grids_have_the_volumes_of_all_shapes(mixed):
    block = MeshHex.init_tensor(np.array([4.0, 5.0]), *[np.array([0.0, 1.5])] * 2)
    block = block.with_boundaries({"left": lambda x: x[0] == 4, "right": lambda x: x[0] == 5})
    model = fo.fem.ContactModel(
        {"a": fo.fem.Body(mixed), "b": fo.fem.Body(block)},
        [fo.fem.Support("a", "left")],
        {"t": [fo.fem.Traction("b", "right", x=0.7)]},
        [fo.fem.Contact("a", "b", "right", "left")],
    )
    fields = model.recover({"t": 1.0}, np.zeros(model.condense().slip_shape))
    for grids in (model.grids(), model.grids(fields)):
        volumes = grids["a"].compute_cell_sizes()["Volume"]
        assert volumes.min() > 0 and volumes.sum() == pytest.approx(4 * 1.5 * 1.5)


def test_bad_wedges_are_refused():
    flat = MeshWedge1().p.copy()
    flat[2] = 0.0
    with pytest.raises(fo.ModelError, match="not convex or have no volume: 2, the first is 0"):
        fo.fem.Body(MeshWedge1(flat, MeshWedge1().t))
    crossed = MeshWedge1().t.copy()
    crossed[[3, 4], 0] = crossed[[4, 3], 0]
    with pytest.raises(fo.ModelError, match="not convex"):
        fo.fem.Body(MeshWedge1(MeshWedge1().p, crossed))
    with pytest.raises(fo.ModelError, match="element: 'quadratic', but the mesh has wedges"):
        fo.fem.Body(MeshWedge1(), element="quadratic")
