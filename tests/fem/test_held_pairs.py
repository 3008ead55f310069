"""Contacts that end at a clamp of both bodies: pairs that cannot move are left out."""

import re

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from helpers.components import joined
from helpers.meshes import box
from helpers.multipliers import Assembled, by_multipliers

STEEL = fo.fem.Material(E=200.0, nu=0.3)


def column(kind, size=3):
    """Two blocks on each other that are clamped on the left; the upper one is pressed down.

    The nodes of the upper block on the contact are listed with their partners.
    """
    d = 2 if kind is MeshQuad else 3
    across = [np.linspace(0.0, 1.0, size + 1), *[np.linspace(0.0, 0.4, 2)] * (d - 2)]
    up = "xyz"[d - 1]
    heights = {"upper": [0.0, 0.3, 1.0], "lower": [-1.0, -0.4, 0.0]}
    supports = [
        fo.fem.Support("upper", "x-"),
        fo.fem.Support("lower", "x-"),
        fo.fem.Support("lower", f"{up}-"),
    ]
    return {
        "bodies": {
            name: fo.fem.Body(box(kind, *across, lines), STEEL) for name, lines in heights.items()
        },
        "supports": supports,
        "loads": {"P": [fo.fem.Pressure("upper", f"{up}+", 2.0)]},
        "contacts": [fo.fem.Contact("upper", "lower", name="joint")],
    }


@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_pairs_that_move_have_the_stiffness_of_the_bodies_and_the_clamp_carries_the_rest(kind):
    """Stiffness and reactions by multipliers, from matrices that scikit-fem assembled."""
    model = fo.fem.ContactModel(**column(kind))
    system = model.condense(progress=False)
    d, whole = system.tangents + 1, Assembled(model.bodies)
    fixed = [whole.on("upper", 0, 0.0), whole.on("lower", 0, 0.0), whole.on("lower", d - 1, -1.0)]
    pairs = [[("upper", point, 1.0), ("lower", point, -1.0)] for point in system.points]
    x = model.bodies["upper"].mesh.p.T
    force = np.zeros((len(whole.K), 1))
    for point in x[x[:, -1] == 1]:
        share = 2.0 / 3 * (0.5 if point[0] in (0, 1) else 1.0) * (1.0 if d == 2 else 0.2)
        force[whole.rows("upper", point)[-1]] = -share
    S, reactions = by_multipliers(
        whole.K, force, whole.motions(system.frames, pairs), np.concatenate(fixed)
    )
    np.testing.assert_allclose(system.S, S, atol=1e-10 * np.abs(S).max())
    np.testing.assert_allclose(joined(*system.bonded["P"]), reactions[:, 0], atol=1e-10)
    # The width of the pairs that are left out belongs to nobody.
    assert system.width.sum() == pytest.approx((1 - 1 / 6) * (1.0 if d == 2 else 0.4), rel=1e-12)

    held = np.flatnonzero((x[:, -1] == 0) & (x[:, 0] == 0))
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
    supports = [fo.fem.Support("lower", "y-"), fo.fem.Support("upper", "x-", "y")]
    supports.append(fo.fem.Support("lower", "x-", "y"))
    with pytest.raises(fo.ModelError, match="follows from other pairs or from supports"):
        fo.fem.ContactModel(**{**parts, "supports": supports}).condense(progress=False)


def test_held_nodes_may_move_together_only():
    parts = column(MeshQuad)
    both = [fo.fem.Displacement(name, "x-", x=0.1) for name in parts["bodies"]]
    parts["supports"] = [fo.fem.Support(name, "x-") for name in parts["bodies"]]
    for moves in (both[:1], [both[0], fo.fem.Displacement("lower", "x-", x=0.2)]):
        message = "moves both bodies at (0, 0), in different ways"
        with pytest.raises(fo.ModelError, match=re.escape(message)):
            fo.fem.ContactModel(**{**parts, "loads": {"Q": moves}})
    # Both bodies move without strain, so nothing presses or pulls.
    system = fo.fem.ContactModel(**{**parts, "loads": {"Q": both}}).condense(progress=False)
    assert np.abs(system.bonded["Q"]).max() < 1e-9
