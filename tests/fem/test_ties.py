"""Ties: faces of two bodies that are glued for good, also if their nodes do not match."""

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from helpers.meshes import box, ring

STEEL = fo.fem.Material(E=200.0, nu=0.3)


def layer(kind, count, low, high, material=STEEL, **more):
    """A box 1 wide between two heights, with a number of elements along each edge."""
    across = [np.linspace(0.0, 1.0, count + 1)] * (1 if kind is MeshQuad else 2)
    mesh = kind.init_tensor(*across, np.linspace(low, high, 3))
    places = {
        "low": lambda x: x[-1] == low,
        "high": lambda x: x[-1] == high,
        **{f"{'xyz'[a]}=0": lambda x, a=a: x[a] == 0 for a in range(len(across))},
    }
    return fo.fem.Body(mesh.with_boundaries(places), material, **more)


def stack(kind, counts, ties=None, shift=0.0, held=(), **more):
    """Three layers: the middle one is tied to the lowest, and touches the highest."""
    bodies = {
        name: layer(kind, count, low, low + 1.0, **more)
        for name, count, low in zip(
            ("bottom", "middle", "top"), counts, (-1.0 - shift, 0.0, 1.0), strict=True
        )
    }
    axes = "x" if kind is MeshQuad else "xy"
    supports = [fo.fem.Support(body, f"{axis}=0", axis) for body in bodies for axis in axes]
    return fo.fem.ContactModel(
        bodies,
        contacts=[fo.fem.Contact("top", "middle", "low", "high")],
        supports=[*supports, *held, fo.fem.Support("bottom", "low", "xyz"[len(axes)])],
        loads={"P": [fo.fem.Pressure("top", "high", 1.0)]},
        ties=[fo.fem.Tie("middle", "bottom", "low", "high")] if ties is None else ties,
    )


@pytest.mark.parametrize("shift", [0.0, 0.1], ids=["together", "too far to move"])
@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_a_uniform_stress_passes_through_meshes_that_do_not_match(kind, element, shift):
    tie = fo.fem.Tie("middle", "bottom", "low", "high", tolerance=0.2)
    model = stack(kind, (3, 4, 4), [tie], shift, element=element)
    count = 5 if kind is MeshQuad else 25
    told = f"tie of 'middle' and 'bottom': {count} nodes glued at a distance, of up to 0.1"
    assert model.notes == ((told,) if shift else ())
    system = model.condense(progress=False)
    flat = np.zeros(system.slip_shape)
    fields = model.recover({"P": 1.0}, flat, progress=False)
    for stress in fields.stress.values():
        uniform = np.zeros_like(stress)
        uniform[1 if kind is MeshQuad else 3] = -1.0
        if kind is MeshQuad:
            uniform[3] = -STEEL.nu  # plane strain
        np.testing.assert_allclose(stress, uniform, atol=1e-10)


def rings(faces=("rim", "bore"), **tie):
    """A disc that is tied to a ring and sits on a shaft; two forces twist the ring."""
    bodies = {
        "ring": fo.fem.Body(ring([1.5, 2.0], 20, "bore", "rim"), STEEL),
        "disc": fo.fem.Body(ring([1.0, 1.2, 1.5], 28, "bore", "rim"), STEEL),
        "shaft": fo.fem.Body(ring([0.5, 1.0], 28, "bore", "rim"), STEEL),
    }
    return fo.fem.ContactModel(
        bodies,
        contacts=[fo.fem.Contact("disc", "shaft", "bore", "rim")],
        supports=[fo.fem.Support("shaft", "bore")],
        loads={
            "T": [
                fo.fem.PointForce("ring", (2.0, 0.0), y=1.0),
                fo.fem.PointForce("ring", (-2.0, 0.0), y=-1.0),
            ]
        },
        ties=[fo.fem.Tie("disc", "ring", *faces, **tie)],
    )


def test_a_round_tie_passes_the_whole_torque():
    model = rings()
    system = model.condense(progress=False)
    q, p = system.bonded["T"]
    forces = np.einsum("na,nak->nk", np.column_stack([q, p]), system.frames)
    x, y = system.points.T
    # The shaft holds the disc against the twist of 4.
    assert (x * forces[:, 1] - y * forces[:, 0]).sum() == pytest.approx(-4.0, rel=1e-9)
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-9)
    assert [note.split(":")[0] for note in model.notes] == ["adjust, body 'disc'"]


def side_by_side(tied, joint=False):
    """Two blocks side by side on a floor, tied or merged; with a joint they touch instead."""
    x = np.linspace(0.0, 1.0, 3)
    y = np.linspace(0.0, 1.0, 5)
    mesh = box(MeshQuad, x, y).with_boundaries({"upper": lambda x: (x[0] == 1) & (x[1] > 0.5)})
    mesh = mesh.with_boundaries({"lower": lambda x: (x[0] == 1) & (x[1] < 0.5)})
    right = box(MeshQuad, x + 1, y).with_boundaries({"x-": lambda x: x[0] == 1})
    both = box(MeshQuad, np.linspace(0.0, 2.0, 5), y)
    floor = MeshQuad.init_tensor(np.linspace(0.0, 2.0, 5), y - 1).with_boundaries(
        {"contact": lambda x: x[1] == 0, "low": lambda x: x[1] == -1}
    )
    left_part = {"left": lambda x: (x[1] == 0) & (x[0] < 1)}
    right_part = {"right": lambda x: (x[1] == 0) & (x[0] > 1)}
    bodies = {"floor": fo.fem.Body(floor, STEEL)}
    supports = [fo.fem.Support("floor", "low")]
    if not tied:
        bodies["both"] = fo.fem.Body(both.with_boundaries({**left_part, **right_part}), STEEL)
        contacts = [fo.fem.Contact("both", "floor", side, "contact") for side in ("left", "right")]
        loads = {"P": [fo.fem.Pressure("both", "y+", 1.0)]}
        return fo.fem.ContactModel(bodies, supports, loads, contacts)
    bodies["one"] = fo.fem.Body(mesh.with_boundaries(left_part), STEEL)
    bodies["two"] = fo.fem.Body(right.with_boundaries(right_part), STEEL)
    contacts = [
        fo.fem.Contact("one", "floor", "left", "contact"),
        fo.fem.Contact("two", "floor", "right", "contact"),
    ]
    face = "x+"
    if joint:
        contacts.append(fo.fem.Contact("one", "two", "lower", "x-", name="crack"))
        face = "upper"
    loads = {"P": [fo.fem.Pressure(body, "y+", 1.0) for body in ("one", "two")]}
    ties = [fo.fem.Tie("one", "two", face, "x-")]
    return fo.fem.ContactModel(bodies, supports, loads, contacts, ties=ties)


def test_a_contact_may_reach_a_tie():
    tied, merged = (side_by_side(tied).condense(progress=False) for tied in (True, False))
    assert tied.nodes == merged.nodes
    np.testing.assert_allclose(tied.points, merged.points)
    np.testing.assert_allclose(tied.S, merged.S, atol=1e-9 * np.abs(merged.S).max())
    np.testing.assert_allclose(tied.width, merged.width)

    model = side_by_side(True, joint=True)
    (note,) = model.notes
    assert note.startswith("contact 'crack': 1 pair that cannot move left out: node")
    assert (model.condense(progress=False).contact == "crack").sum() == 1


def test_ties_that_cannot_be_meant_are_refused():
    apart = r"no node of the face of body 'middle' lies within 0.\d+ of the other face"
    with pytest.raises(fo.ModelError, match=apart):
        stack(MeshQuad, (3, 4, 4), shift=0.1)
    wide = fo.fem.Tie("middle", "bottom", "low", "high", tolerance=0.2)
    assert stack(MeshQuad, (4, 4, 4), [wide], shift=0.02).notes
    circle = [
        fo.fem.Tie("middle", "bottom", "low", "high"),
        fo.fem.Tie("bottom", "middle", "high", "low"),
    ]
    with pytest.raises(fo.ModelError, match="in a circle"):
        stack(MeshQuad, (3, 3, 3), circle)
    held = [fo.fem.Support("middle", "low"), fo.fem.Support("bottom", "low")]
    with pytest.raises(fo.ModelError, match="is held where face 2 is not"):
        stack(MeshQuad, (3, 3, 3), held=held)
    for wrong, message in (
        ({"tolerance": 0.0}, "tolerance"),
        ({"adjust": 1}, "adjust"),
        ({"body_1": 3}, "body_1"),
    ):
        with pytest.raises(fo.ModelError, match=message):
            fo.fem.Tie(
                **{"body_1": "a", "body_2": "b", "boundary_1": "c", "boundary_2": "d", **wrong}
            )


def test_nodes_beyond_the_tolerance_are_free_and_counted():
    """The tied half of the face carries all of the load."""
    bottom = layer(MeshQuad, 4, -1.0, 0.0)
    mesh = layer(MeshQuad, 4, 0.0, 1.0).mesh
    raised = mesh.p + 0.1 * (mesh.p[1] == 0) * (mesh.p[0] > 0.5) * np.array([[0.0], [1.0]])
    middle = fo.fem.Body(MeshQuad(raised, mesh.t).with_boundaries(mesh.boundaries), STEEL)
    bodies = {"bottom": bottom, "middle": middle, "top": layer(MeshQuad, 4, 1.0, 2.0)}
    message = "tie of 'middle' and 'bottom': 2 nodes of the face of body 'middle' farther than"
    with pytest.warns(fo.ModelWarning, match=message):
        model = fo.fem.ContactModel(
            bodies,
            contacts=[fo.fem.Contact("top", "middle", "low", "high")],
            supports=[fo.fem.Support("bottom", "low")],
            loads={"P": [fo.fem.Pressure("top", "high", 1.0)]},
            ties=[fo.fem.Tie("middle", "bottom", "low", "high")],
        )
    assert model.condense(progress=False).bonded["P"][1].sum() == pytest.approx(1.0, rel=1e-9)


def rectangle(x, y, count):
    mesh = MeshQuad.init_tensor(np.linspace(*x, count + 1), np.linspace(*y, count + 1))
    places = {
        "left": lambda z: z[0] == x[0],
        "right": lambda z: z[0] == x[1],
        "low": lambda z: z[1] == y[0],
        "high": lambda z: z[1] == y[1],
    }
    return fo.fem.Body(mesh.with_boundaries(places), STEEL)


@pytest.mark.parametrize("order", [1, -1])
def test_a_node_may_follow_a_node_that_follows(order):
    """The side follows the middle, which follows the bottom; all are under one pressure."""
    bodies = {
        "bottom": rectangle((0.0, 1.0), (-1.0, 0.0), 2),
        "middle": rectangle((0.0, 1.0), (0.0, 1.0), 3),
        "side": rectangle((-1.0, 0.0), (0.0, 1.0), 4),
        "top": rectangle((0.0, 1.0), (1.0, 2.0), 3),
    }
    pressed = {
        "bottom": ("left", "right"),
        "middle": ("right",),
        "side": ("left", "low", "high"),
        "top": ("left", "right", "high"),
    }
    ties = [
        fo.fem.Tie("middle", "bottom", "low", "high"),
        fo.fem.Tie("side", "middle", "right", "left"),
    ]
    model = fo.fem.ContactModel(
        bodies,
        contacts=[fo.fem.Contact("top", "middle", "low", "high")],
        supports=[fo.fem.Support("bottom", "low", "y"), fo.fem.Support("bottom", (0.0, -1.0), "x")],
        loads={
            "P": [fo.fem.Pressure(body, face, 1.0) for body in pressed for face in pressed[body]]
        },
        ties=ties[::order],
    )
    nodes = model.condense(progress=False).nodes
    for stress in model.recover({"P": 1.0}, np.zeros(nodes), progress=False).stress.values():
        expected = [[-1.0], [-1.0], [0.0], [-2 * STEEL.nu]]
        np.testing.assert_allclose(stress, np.tile(expected, stress.shape[1]), atol=1e-10)


def test_a_node_of_two_ties_follows_the_first():
    """Two names of one face, which overlap: as if one of them alone were given."""
    mesh = layer(MeshQuad, 4, 0.0, 1.0).mesh
    bodies = {
        "bottom": layer(MeshQuad, 4, -1.0, 0.0),
        "middle": fo.fem.Body(
            mesh.with_boundaries({"left": lambda x: (x[1] == 0) & (x[0] < 0.7)}), STEEL
        ),
        "top": layer(MeshQuad, 4, 1.0, 2.0),
    }
    parts = {
        "contacts": [fo.fem.Contact("top", "middle", "low", "high")],
        "supports": [fo.fem.Support("bottom", "low")],
        "loads": {"P": [fo.fem.Pressure("top", "high", 1.0)]},
    }
    whole = fo.fem.Tie("middle", "bottom", "low", "high")
    left = fo.fem.Tie("middle", "bottom", "left", "high")
    one = fo.fem.ContactModel(bodies, **parts, ties=[whole]).condense(progress=False)
    for ties in ([whole, left], [left, whole]):
        both = fo.fem.ContactModel(bodies, **parts, ties=ties).condense(progress=False)
        np.testing.assert_allclose(both.S, one.S, atol=1e-9 * np.abs(one.S).max())
