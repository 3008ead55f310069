"""Forces through ties, by the balance of their bodies, and by contacts that stick in their place."""

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from helpers.cases import few

STEEL = fo.fem.Material(E=200.0, nu=0.3)
CYCLE = fo.LoadCycle({"press": 1.0, "any": 1.0, "hot": 1.0}, [{"push": 1.0}, {"push": -1.0}])


def block(*lines, **more):
    """A block along the lines of its mesh, with the sides x-, x+, y- and so on."""
    mesh = (MeshQuad if len(lines) == 2 else MeshHex).init_tensor(*lines)
    sides = {
        f"{'xyz'[k]}{sign}": lambda x, k=k, end=line[end]: x[k] == end
        for k, line in enumerate(lines)
        for sign, end in (("-", 0), ("+", -1))
    }
    return fo.fem.Body(mesh.with_boundaries(sides), STEEL, **more)


def layer(kind, count, low, **more):
    """A block 1 wide and 1 high with a number of elements along each edge of its foot."""
    across = [np.linspace(0.0, 1.0, count + 1)] * (1 if kind is MeshQuad else 2)
    return block(*across, np.linspace(low, low + 1.0, 3), **more)


def column(kind, seed, contact="hard", tie=True, **more):
    """A head that is tied to a foot and rubs under a lid, with random forces; and its forces.

    The foot and the lid are held. A heated head presses against both, which statics alone does not
    determine. The tie is in the place of a contact with the same faces.
    """
    random = np.random.default_rng(seed)
    up = "y" if kind is MeshQuad else "z"
    axes = "xy" if kind is MeshQuad else "xyz"
    bodies = {
        "foot": layer(kind, 2, -1.0, **more),
        "head": layer(kind, 3, 0.0, **more),
        "lid": layer(kind, 2, 1.0),
    }
    corners = [[*place, 1.0] for place in np.ndindex(*[2] * (len(axes) - 1))]
    points = np.array(corners, dtype=float)
    forces = random.uniform(-0.01, 0.01, size=points.shape)
    stiff = {"tangential_stiffness": 300.0} if contact == "rough" else {}
    faces = ("head", "foot", f"{up}-", f"{up}+")
    contacts = [fo.fem.Contact("head", "lid", f"{up}+", f"{up}-", "lid", **stiff)]
    if not tie:
        contacts.append(fo.fem.Contact(*faces, "weld"))
    loads = {
        "press": [fo.fem.Displacement("lid", f"{up}+", **{up: -0.02})],
        "any": [
            fo.fem.PointForce("head", tuple(point), **dict(zip(axes, force, strict=True)))
            for point, force in zip(points.tolist(), forces.tolist(), strict=True)
        ],
        "hot": [fo.fem.Expansion("head", 0.002)],
        "push": [fo.fem.Traction("head", "x-", x=0.6)],
    }
    if contact == "fit":
        loads["hot"] = [fo.fem.Interference("lid", 0.002)]
    held = [fo.fem.Support("foot", f"{up}-"), fo.fem.Support("lid", f"{up}+")]
    ties = [fo.fem.Tie(*faces)] if tie else []
    model = fo.fem.ContactModel(bodies, held, loads, contacts, ties=ties)
    return model, points, forces


def push_on(points):
    """Places and forces of the push, whose resultant is in the middle of the side."""
    d = points.shape[1]
    middle = np.full(d, 0.5)
    middle[0] = 0.0
    return middle[None], np.array([[0.6, *[0.0] * (d - 1)]])


def moment(points, forces, about):
    """The moment of forces, a vector in space."""
    d = points.shape[1]
    wide = ((0, 0), (0, 3 - d))
    return np.cross(np.pad(points - about, wide), np.pad(forces, wide)).sum(axis=0)


@pytest.mark.parametrize("seed", few(range(4), least=1, share=4))
@pytest.mark.parametrize("contact", ["hard", "rough", "fit"])
@pytest.mark.parametrize("element", ["linear", "quadratic"])
@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_a_tie_carries_what_the_loads_and_the_slipping_contact_leave(kind, element, contact, seed):
    """The forces on the head balance, also in its moments, while its other face slips."""
    model, points, forces = column(kind, seed, contact, element=element)
    system = model.condense(progress=False)
    friction = np.full(system.nodes, 0.2)
    steady = fo.steady_state(system, CYCLE, friction, 1.0, steps=2, progress=False)
    assert np.abs(steady.slip).max() > 1e-4
    table = steady.by_contact(model)
    assert table["contact"].tolist() == ["lid", model.ties[0].name]
    assert table["nodes"].tolist() == [system.nodes, 0]
    assert table[["sticking", "slipping", "open", "work"]].iloc[1].tolist() == [1, 0, 0, 0]

    states = steady.states()
    d = points.shape[1]
    middle = np.full(d, 0.5)
    middle[-1] = 0.0
    for corner, sign in enumerate((1.0, -1.0)):
        row = np.flatnonzero(np.isclose(states.time, states.time[-1] - 1 + corner))[-1]
        shear = states.q[row].reshape(system.nodes, -1)
        reactions = np.column_stack([shear, states.p[row]])
        of_lid = np.einsum("na,nad->nd", reactions, system.frames)
        push_at, push = push_on(points)
        places = np.vstack([points, push_at, system.points])
        acting = np.vstack([forces, sign * push, of_lid])
        total = -acting.sum(axis=0)
        turn = -moment(places, acting, middle)
        expected = [total[-1], np.linalg.norm(total[:-1]), np.linalg.norm(turn)]
        found = [table[f"{part}_{corner}"].iloc[1] for part in "PQM"]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(of_lid).max())


@pytest.mark.parametrize("seed", few(range(4), least=1, share=4))
@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_a_contact_that_sticks_carries_the_same(kind, seed):
    """The tie between the faces, or a contact whose friction holds everything."""
    rows = []
    for tie in (True, False):
        model, _, _ = column(kind, seed, tie=tie)
        system = model.condense(progress=False)
        friction = {"lid": 0.2} if tie else {"lid": 0.2, "weld": 50.0}
        steady = fo.steady_state(system, CYCLE, friction, 1.0, steps=2, progress=False)
        table = steady.by_contact(model)
        rows.append(table[["P_0", "Q_0", "P_1", "Q_1"]].abs().to_numpy(dtype=float))
    np.testing.assert_allclose(rows[0], rows[1], rtol=3e-5)


@pytest.mark.parametrize("hangs", [True, False])
def test_a_contact_that_reaches_a_tie_keeps_its_own_forces(hangs):
    """A block on a floor, and one that is tied to its side: a corner is in the contact and tied.

    The tied block hangs beside the floor and is pulled, or the block that stands is tied to it.
    """
    lines = np.linspace(0.0, 1.0, 3), np.linspace(0.0, 1.0, 5)
    bodies = {
        "floor": block(np.linspace(0.0, 1.0, 4), np.linspace(-1.0, 0.0, 3)),
        "one": block(*lines),
        "two": block(lines[0] + 1.0, lines[1]),
    }
    tie = fo.fem.Tie("two", "one", "x-", "x+") if hangs else fo.fem.Tie("one", "two", "x+", "x-")
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("floor", "y-")],
        {
            "P": [fo.fem.Pressure("one", "y+", 1.0), fo.fem.Pressure("two", "y+", 0.2)],
            "Q": [fo.fem.Traction("two", "x+", x=0.05)],
        },
        [fo.fem.Contact("one", "floor", "y-", "y+")],
        ties=[tie],
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    steady = fo.steady_state(model.condense(progress=False), cycle, 0.1, 1.0, progress=False)
    row = steady.by_contact(model).iloc[1]
    # The pull and the weight of 0.2 act in the middle of the outer side and of the top.
    found = row[["P_0", "Q_0", "M_0", "P_1", "Q_1", "M_1"]].tolist()
    assert found == pytest.approx([-0.05, 0.2, 0.1, 0.05, 0.2, 0.1], abs=1e-9)


def test_a_sheet_has_the_forces_and_another_model_is_refused(tmp_path):
    model, _, _ = column(MeshQuad, 0)
    system = model.condense(progress=False)
    steady = fo.steady_state(system, CYCLE, 0.2, 1.0, progress=False)
    fo.report(system, CYCLE, 0.2, pages=1, model=model).save(tmp_path / "sheet.html")
    text = (tmp_path / "sheet.html").read_text()
    assert "Forces through ties" in text and "tie y--y+ (head, foot)" in text
    other, _, _ = column(MeshQuad, 1)
    for wrong, message in (
        (other, "its reactions differ from those of the steady state by .* condensed from"),
        (column(MeshHex, 0)[0], "another one; give the ContactModel that the system was"),
        (system, "give the ContactModel that was condensed"),
    ):
        with pytest.raises(fo.ModelError, match=message):
            steady.by_contact(wrong)
    assert "M_0" not in steady.by_contact()
