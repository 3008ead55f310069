"""Contacts that end at a clamp of both bodies: pairs that cannot move are left out."""

import re

import numpy as np
import pytest
from skfem import Basis, ElementHex1, ElementQuad1, ElementVector, MeshHex, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo

STEEL = fo.fem.Material(E=200.0, nu=0.3)
ELEMENTS = {MeshQuad: ElementQuad1(), MeshHex: ElementHex1()}


def column(kind, size=3):
    """Two blocks on each other that are clamped on the left; the upper one is pressed down.

    The nodes of the upper block on the contact are listed with their partners.
    """
    d = 2 if kind is MeshQuad else 3
    across = [np.linspace(0.0, 1.0, size + 1), *[np.linspace(0.0, 0.4, 2)] * (d - 2)]
    meshes = {}
    for name, heights in (("upper", [0.0, 0.3, 1.0]), ("lower", [-1.0, -0.4, 0.0])):
        meshes[name] = kind.init_tensor(*across, np.array(heights)).with_boundaries(
            {
                "contact": lambda x: x[-1] == 0,
                "left": lambda x: x[0] == 0,
                "top": lambda x: x[-1] == 1,
                "bottom": lambda x: x[-1] == -1,
            }
        )
    supports = [
        fo.fem.Support("upper", "left"),
        fo.fem.Support("lower", "left"),
        fo.fem.Support("lower", "bottom"),
    ]
    return {
        "bodies": {name: fo.fem.Body(mesh, STEEL) for name, mesh in meshes.items()},
        "supports": supports,
        "loads": {"P": [fo.fem.Pressure("upper", "top", 2.0)]},
        "contacts": [fo.fem.Contact("upper", "lower", name="joint")],
    }


@pytest.mark.parametrize("kind", ELEMENTS)
def test_pairs_that_move_have_the_stiffness_of_the_bodies_and_the_clamp_carries_the_rest(kind):
    """Stiffness and reactions by dense elimination of matrices that scikit-fem assembled."""
    parts = column(kind)
    model = fo.fem.ContactModel(**parts)
    system = model.condense(progress=False)
    d = 2 if kind is MeshQuad else 3

    K = []
    points = []
    for body in parts["bodies"].values():
        basis = Basis(body.mesh, ElementVector(ELEMENTS[kind]), intorder=4)
        matrix = linear_elasticity(*lame_parameters(STEEL.E, STEEL.nu)).assemble(basis).toarray()
        order = basis.nodal_dofs.T.ravel()
        K.append(matrix[np.ix_(order, order)])
        points.append(body.mesh.p.T)
    upper = len(points[0])
    x = np.concatenate(points)
    whole = np.zeros((d * len(x),) * 2)
    whole[: d * upper, : d * upper], whole[d * upper :, d * upper :] = K
    fixed = (x[:, 0] == 0) | (x[:, -1] == -1)
    nodes = [int(np.flatnonzero((x[:upper] == point).all(axis=1))[0]) for point in system.points]
    partners = [
        upper + int(np.flatnonzero((x[upper:] == point).all(axis=1))[0]) for point in system.points
    ]
    assert len(nodes) == ((x[:upper, -1] == 0) & ~fixed[:upper]).sum()

    # Displacements by those of all free nodes but the upper ones of the pairs, and the openings.
    unit = np.eye(len(x))
    follows = unit.copy()
    follows[nodes] = unit[partners]
    free = np.setdiff1d(np.flatnonzero(~fixed), nodes)
    by_free = np.kron(follows[:, free], np.eye(d))
    # With the normal along the last axis, the tangents are the other axes.
    by_openings = np.hstack([np.kron(unit[:, nodes], np.eye(d)[:, [a]]) for a in range(d)])
    inner = by_free.T @ whole @ by_free
    mixed = by_openings.T @ whole @ by_free
    S = by_openings.T @ whole @ by_openings - mixed @ np.linalg.solve(inner, mixed.T)
    np.testing.assert_allclose(system.S, S, atol=1e-10 * np.abs(S).max())

    top = np.flatnonzero(x[:, -1] == 1)
    share = 2.0 * np.where((x[top, 0] == 0) | (x[top, 0] == 1), 0.5, 1.0) / 3
    force = np.zeros((len(x), d))
    force[top, -1] = -share if d == 2 else -share * 0.2
    u = by_free @ np.linalg.solve(inner, by_free.T @ force.ravel())
    on_bodies = (whole @ u - force.ravel()).reshape(-1, d)
    pressures = system.bonded["P"][1]
    np.testing.assert_allclose(pressures, on_bodies[nodes, -1], atol=1e-10)
    clamp = on_bodies[:upper][x[:upper, 0] == 0, -1].sum()
    assert pressures.sum() + clamp == pytest.approx(-force.sum(), rel=1e-9)
    # The width of the pairs that are left out belongs to nobody.
    assert system.width.sum() == pytest.approx((1 - 1 / 6) * (1.0 if d == 2 else 0.4), rel=1e-12)

    held = np.flatnonzero((x[:upper, -1] == 0) & fixed[:upper])
    (note,) = model.notes
    count = "1 pair" if d == 2 else "2 pairs"
    assert note.startswith(f"contact 'joint': {count} that cannot move left out: node")
    assert all(f"node {node} of body 'upper'" in note for node in held)
    assert note in repr(model)


def test_a_contact_that_cannot_move_at_all_is_refused():
    parts = column(MeshQuad)
    everything = [fo.fem.Support(name, "contact") for name in parts["bodies"]]
    with pytest.raises(fo.ModelError, match="no pair of 'joint' can move"):
        fo.fem.ContactModel(**{**parts, "supports": everything})


def test_pairs_whose_normals_alone_are_held_are_refused():
    parts = column(MeshQuad)
    supports = [fo.fem.Support("lower", "bottom"), fo.fem.Support("upper", "left", "y")]
    supports.append(fo.fem.Support("lower", "left", "y"))
    with pytest.raises(fo.ModelError, match="follows from other pairs or from supports"):
        fo.fem.ContactModel(**{**parts, "supports": supports}).condense(progress=False)


def test_held_nodes_may_move_together_only():
    parts = column(MeshQuad)
    both = [fo.fem.Displacement(name, "left", x=0.1) for name in parts["bodies"]]
    parts["supports"] = [fo.fem.Support(name, "left") for name in parts["bodies"]]
    for moves in (both[:1], [both[0], fo.fem.Displacement("lower", "left", x=0.2)]):
        message = "moves both bodies at (0, 0), in different ways"
        with pytest.raises(fo.ModelError, match=re.escape(message)):
            fo.fem.ContactModel(**{**parts, "loads": {"Q": moves}})
    # Both bodies move without strain, so nothing presses or pulls.
    system = fo.fem.ContactModel(**{**parts, "loads": {"Q": both}}).condense(progress=False)
    assert np.abs(system.bonded["Q"]).max() < 1e-9
