"""Modes of models.

They are compared with closed forms of bars, dense matrices with merged nodes, and loads of modes.
"""

from dataclasses import replace

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.linalg import block_diag, eigh
from skfem import BilinearForm, MeshHex, MeshQuad, MeshTet, MeshTri
from skfem.helpers import dot

import frictopt as fo
from helpers.multipliers import Assembled
from helpers.quadratic import dimensions

matplotlib.use("Agg")
E, RHO = 3.0, 2.0
SPEED = np.sqrt(E / RHO)
LENGTH, HIGH = 10.0, 1.0


def bars(kind, cells, across=2, height=HIGH, nu=0.0, low=0.0, **options):
    """A bar of two bodies of the same length that meet in its middle.

    It lies along x, from 0 to 10, and is `height` high and thick.
    """
    x = np.linspace(0.0, LENGTH, cells + 1)
    sides = [np.linspace(0.0, height, across + 1) + low] * (dimensions(kind) - 1)
    steel, middle, bodies = fo.fem.Material(E, nu, RHO), x[cells // 2], {}
    for name, part, end in (("right", x[cells // 2 :], LENGTH), ("left", x[: cells // 2 + 1], 0.0)):
        mesh = kind.init_tensor(part, *sides)
        named = {"contact": lambda p: p[0] == middle, "end": lambda p, end=end: p[0] == end}
        named |= {
            f"side {axis}": lambda p, k=k: (p[k] == p[k].min()) | (p[k] == p[k].max())
            for k, axis in ((1, "y"), (2, "z"))[: len(sides)]
        }
        bodies[name] = fo.fem.Body(mesh.with_boundaries(named), steel, options.get("element"))
    supports = options.get("supports", [])
    return fo.fem.ContactModel(
        bodies,
        supports,
        {"P": [fo.fem.Pressure("right", "end")]},
        kinematics=options.get("kinematics"),
    )


def straight(kind):
    """Supports that leave a bar nothing but its motion along x."""
    axes = "yz"[: dimensions(kind) - 1]
    return [
        fo.fem.Support(body, f"side {axis}", axis) for body in ("right", "left") for axis in axes
    ]


def of_elements(waves, h):
    """Frequencies of waves along a bar of linear elements with consistent mass.

    They are exact for the wave number k = waves.
    """
    return (
        np.sqrt(6 / h**2 * (1 - np.cos(waves * h)) / (2 + np.cos(waves * h))) * SPEED / (2 * np.pi)
    )


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_an_axisymmetric_bar_is_a_shaft_of_its_whole_circumference(nu):
    """With Poisson's ratio it breathes, too, and no such motion is a translation."""
    y, steel = np.linspace(0.0, LENGTH, 21), fo.fem.Material(E, nu, RHO)
    named = {
        "contact": lambda p: p[1] == y[10],
        "end": lambda p: abs(p[1] - LENGTH / 2) == LENGTH / 2,
    }
    parts = {"up": y[10:], "low": y[:11]}
    bodies = {
        name: fo.fem.Body(MeshQuad.init_tensor([0.0, 0.5, 1.0], part).with_boundaries(named), steel)
        for name, part in parts.items()
    }
    modes = fo.fem.ContactModel(
        bodies, [], {"P": [fo.fem.Pressure("up", "end")]}, kinematics="axisymmetric"
    ).modes(3)
    assert modes.frequency == pytest.approx(
        of_elements(np.arange(3) * np.pi / LENGTH, LENGTH / 20), rel=1e-9 if nu == 0 else 2e-2
    )
    assert modes.mass == pytest.approx(RHO * np.pi * LENGTH)
    assert modes.effective_mass[0] == pytest.approx([0.0, modes.mass])
    assert not modes.participation[:, 0].any()
    assert (np.abs(modes.shapes["up"][:, 0]).max(axis=1) > 1e-3).tolist() == [False, *[nu > 0] * 2]


def test_a_free_body_has_its_rigid_motions_and_pairs_of_bending_modes():
    modes = bars(MeshHex, 12, 2, nu=0.3).modes(10)
    assert not modes.frequency[:6].any() and modes.frequency[6] > 0.1 * SPEED * HIGH / LENGTH**2
    # A square section.
    assert modes.frequency[[6, 8]] == pytest.approx(modes.frequency[[7, 9]], rel=1e-9)
    assert modes.effective_mass.sum(axis=0) == pytest.approx([modes.mass] * 3)
    assert modes.mass == pytest.approx(RHO * LENGTH)


def dense(bodies, joined, held):
    """Squares of angular frequencies, modes (unknowns, n), mass, and directions of the unknowns.

    Nodes in pairs are merged. The unknowns are ordered node by node, body after body, without the
    unknowns of held nodes.
    """
    whole = Assembled(bodies)
    order, masses = [], []
    for name, basis in whole.bases.items():
        mass = BilinearForm(lambda u, v, w: dot(u, v)).assemble(basis).toarray()
        masses.append(bodies[name].material.density * mass)
        order.append(whole.first[name] + basis.nodal_dofs.T.ravel())
    order = np.concatenate(order)
    K, M = (part[np.ix_(order, order)] for part in (whole.K, block_diag(*masses)))
    d = basis.mesh.dim()
    number = np.arange(len(order) // d)
    number[joined[:, 1]] = number[joined[:, 0]]
    kept = np.setdiff1d(np.unique(number), held)
    merge = np.kron(number[:, None] == kept, np.eye(d))
    squares, y = eigh(merge.T @ K @ merge, merge.T @ M @ merge)
    return squares, merge @ y, M, np.tile(np.eye(d), (len(number), 1))


@pytest.mark.parametrize("kind", [MeshQuad, MeshTri, MeshHex, MeshTet])
@pytest.mark.parametrize("opened", [0, 2])
def test_modes_are_those_of_dense_matrices_with_the_closed_nodes_merged(kind, opened):
    """Some nodes are open, or none. Shapes are compared by their products with the mass, masses and
    participation by sums."""
    model = bars(kind, 4, 2, height=3.0, nu=0.3, supports=[fo.fem.Support("left", "end")])
    system = model.condense()
    open_nodes = np.arange(system.nodes) < opened
    first = model.bodies["right"].mesh.p.shape[1]
    points = np.hstack([body.mesh.p for body in model.bodies.values()]).T
    pairs = np.array(
        [np.flatnonzero((points == point).all(axis=1)) for point in system.points[~open_nodes]]
    )
    assert (pairs[:, 0] < first).all() and (pairs[:, 1] >= first).all()
    squares, shapes, M, along = dense(model.bodies, pairs, np.flatnonzero(points[:, 0] == 0))
    modes = model.modes(5, open_nodes=open_nodes)
    assert modes.frequency**2 == pytest.approx(squares[:5] / (2 * np.pi) ** 2, rel=1e-9, abs=1e-13)
    modal_shapes = np.concatenate(
        [shape.swapaxes(1, 2).reshape(5, -1) for shape in modes.shapes.values()], axis=1
    )
    assert np.allclose(modal_shapes @ M @ modal_shapes.T, np.eye(5), atol=1e-9)
    distinct = np.diff(squares[:6]) > 1e-6 * squares[0]
    single = np.r_[True, distinct[:-1]] & distinct
    assert single.any()
    assert np.allclose(
        np.abs(np.einsum("ki,ik->k", modal_shapes @ M, shapes[:, :5]))[single],
        1.0,
        rtol=0,
        atol=1e-9,
    )
    assert np.allclose(modes.participation, modal_shapes @ M @ along, atol=1e-9)
    assert np.allclose(modes.effective_mass, modes.participation**2)
    table = modes.to_frame()
    assert table["effective_mass_y"].tolist() == modes.effective_mass[:, 1].tolist()
    assert len(table) == 5
    assert (modes.open == open_nodes).all()


def test_surfaces_that_give_are_springs_between_heavy_ends():
    """Two bodies of mass m on soft springs of stiffness k have rigid motions, then sqrt(2 k / m),
    along the normal and across it."""
    stiff = replace(
        bars(MeshQuad, 4, 1),
        contacts=[fo.fem.Contact("right", "left", normal_stiffness=1e-6)],
        supports=straight(MeshQuad),
    )
    modes, m = stiff.modes(2), RHO * LENGTH / 2
    assert modes.frequency == pytest.approx([0.0, np.sqrt(2e-6 / m) / (2 * np.pi)], rel=1e-4)
    held = [fo.fem.Support(body, "end", "x") for body in ("right", "left")]
    pull = {"P": [fo.fem.Traction("right", "end", y=1.0)]}
    shear = replace(
        stiff,
        contacts=[fo.fem.Contact("right", "left", tangential_stiffness=1e-8)],
        supports=held,
        loads=pull,
    ).modes(2)
    assert shear.frequency[1] == pytest.approx(np.sqrt(2e-8 / m) / (2 * np.pi), rel=1e-4)


@pytest.mark.parametrize("kind", [MeshQuad, MeshTet])
@pytest.mark.parametrize("give", [np.inf, 0.7])
def test_the_load_of_a_mode_moves_it_alone(kind, give):
    """Its compliance is 1 / omega^2, other modes do no work in it, and its fields are its shape."""
    model = bars(kind, 8, 2, nu=0.3, supports=[fo.fem.Support("left", "end")], element="quadratic")
    model = replace(
        model,
        contacts=[
            fo.fem.Contact("right", "left", tangential_stiffness=give, normal_stiffness=2 * give)
        ],
    )
    modes = model.modes(3)
    shaken = model.with_loads({f"mode {k}": modes.load(k) for k in range(3)})
    system = shaken.condense()
    omega = 2 * np.pi * modes.frequency
    assert np.allclose(
        system.compliance[1:, 1:] * np.outer(omega, omega), np.eye(3), rtol=0, atol=1e-7
    )
    assert next(iter(system.bonded)) == "P"
    fields = shaken.recover(
        {"mode 1": omega[1] ** 2}, np.zeros((system.nodes, 2)[: dimensions(kind) - 1])
    )
    for name, shape in modes.shapes.items():
        assert np.allclose(
            fields.displacement[name], shape[1], rtol=0, atol=1e-9 * np.abs(shape).max()
        )
    assert np.allclose(
        [
            sum((part.forces * modes.shapes[part.body][k]).sum() for part in modes.load(k))
            for k in range(3)
        ],
        1.0,
    )


@pytest.mark.parametrize("kind", [MeshQuad, MeshTri, MeshHex])
def test_the_modal_force_of_loads_is_their_work_in_the_mode(kind):
    """In the condensed system the displacement of a load under the unit load of a mode is its modal
    force over the square of the angular frequency."""
    d = dimensions(kind)
    base = bars(kind, 8, supports=[fo.fem.Support("left", "end")])
    modes = base.modes(3)
    push = dict(zip("xyz", [0.4, -0.3, 0.2][:d], strict=False))
    loads = {
        "faces": [fo.fem.Pressure("right", "end", 0.7), fo.fem.Traction("right", "end", **push)],
        "volume": [
            fo.fem.BodyForce("left", y=lambda x, *_: 0.1 * x),
            fo.fem.BodyForce("right", x=0.5),
        ],
        "mode 1": modes.load(1),
    }
    model = base.with_loads({f"of mode {k}": modes.load(k) for k in range(3)} | loads)
    system = model.condense()
    cases = list(system.bonded)
    for name, parts in loads.items():
        for k in range(3):
            moved = system.compliance[cases.index(name), cases.index(f"of mode {k}")]
            force = moved * (2 * np.pi * modes.frequency[k]) ** 2
            assert modes.force(k, parts) == pytest.approx(force, rel=1e-6, abs=1e-9)
    assert modes.force(1, modes.load(1)) == pytest.approx(1.0, rel=1e-9)
    # A base shaken by b is the inertia of all bodies, forces per volume of density times b.
    shake = np.array([0.3, -1.2, 0.7])[:d]
    weight = dict(zip("xyz", RHO * shake, strict=False))
    inertia = [fo.fem.BodyForce(name, **weight) for name in ("left", "right")]
    for k in range(3):
        alone = modes.force(k, acceleration=shake)
        assert alone == pytest.approx(modes.force(k, inertia), rel=1e-9, abs=1e-9)
        both = modes.force(k, loads["faces"], acceleration=shake)
        assert both == pytest.approx(alone + modes.force(k, loads["faces"]), abs=1e-9)
    with pytest.raises(fo.ModelError, match="loads, acceleration: neither is given"):
        modes.force(0)
    with pytest.raises(fo.ModelError, match=r"loads: .*give a list of Traction or Pressure"):
        modes.force(0, [fo.fem.Displacement("left", "end", x=1.0)])
    with pytest.raises(fo.ModelError, match="loads: body: 'middle'"):
        modes.force(0, [fo.fem.Pressure("middle", "end")])
    with pytest.raises(fo.ModelError, match="acceleration: shape"):
        modes.force(0, acceleration=[1.0])
    with pytest.raises(fo.ModelError, match=r"^k: 3"):
        modes.force(3, loads["faces"])


def test_bad_input_is_named():
    model = bars(MeshQuad, 4, 1, supports=[fo.fem.Support("left", "end")])
    for odd in (0.0, -1.0, np.nan, "7.85e-9"):
        with pytest.raises(fo.ModelError, match="density"):
            fo.fem.Material(1.0, 0.3, odd)
    light = replace(
        model,
        bodies={**model.bodies, "left": replace(model.bodies["left"], material=fo.fem.Material())},
    )
    with pytest.raises(
        fo.ModelError,
        match=r"material: body 'left' has no density, .* give Material\(..., density=\)",
    ):
        light.modes(1)
    for odd in (0, 16, 2.0, True):
        with pytest.raises(fo.ModelError, match=r"n: .* whole number of at least 1 and at most 15"):
            model.modes(odd)
    for odd in ([True], [0, 1], "both"):
        with pytest.raises(
            fo.ModelError, match=r"open_nodes: .*; give (True or False for each of 2 nodes|a list)"
        ):
            model.modes(1, open_nodes=odd)
    modes = model.modes(2)
    with pytest.raises(fo.ModelError, match=r"k: 2; .* at most 1"):
        modes.load(2)
    with pytest.raises(fo.ModelError, match=r"loads: .* give a mapping"):
        model.with_loads(modes.load(0))
    finer = bars(MeshQuad, 8, 1, supports=model.supports)
    with pytest.raises(
        fo.ModelError, match=r"forces: shape .* body '(left|right)' has \(d, nodes\)"
    ):
        finer.with_loads({"mode": modes.load(0)})


@pytest.mark.parametrize("kind", [MeshQuad, MeshTet])
def test_a_mode_is_drawn_with_its_number_and_frequency(kind):
    model = bars(kind, 4, 1, supports=[fo.fem.Support("left", "end")])
    modes = model.modes(3)
    axes = modes.plot(2)
    assert axes.get_title() == f"mode 2: {modes.frequency[2]:.5g} (cycles per time)"
    if kind is MeshQuad:
        shape, mesh = modes.shapes["left"][2], model.bodies["left"].mesh
        moved = mesh.p + shape * 0.15 * LENGTH / max(
            np.linalg.norm(shapes[2], axis=0).max() for shapes in modes.shapes.values()
        )
        drawn = np.concatenate([line.get_xydata() for line in axes.lines])
        assert all((np.abs(drawn - point).max(axis=1) < 1e-9).any() for point in moved.T)
    legend = model.with_loads({"mode": modes.load(0)}).plot().figure.legends[0]
    assert "load mode (2 x nodal forces)" in [text.get_text() for text in legend.get_texts()]
    with pytest.raises(fo.ModelError, match="k: 3; "):
        modes.plot(3)
    panels = modes.plot()
    assert [panel.get_title().split(":")[0] for panel in panels] == ["mode 0", "mode 1", "mode 2"]
    assert panels[2].get_title() == axes.get_title()
    (legend,) = panels[0].figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["as it was", *model.bodies]
    plt.close("all")
