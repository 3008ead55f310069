"""Springs in series with the nodes of a contact.

They are compared with flexibilities, closed forms and a published limit case, in the plane and in
space.
"""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.components import joined
from helpers.meshes import wedge
from helpers.springs import punch
from helpers.systems import PULL, linprog_limit


def held(tangents, nodes=4, seed=0):
    """A random contact of bodies that are held, so that S has an inverse, with its widths."""
    rng = np.random.default_rng(seed)
    M = (tangents + 1) * nodes
    root = rng.normal(size=(M, M))
    points = np.column_stack([np.arange(nodes), *np.zeros((tangents, nodes))])
    return fo.ContactSystem(
        root @ root.T + np.eye(M),
        points,
        {"P": rng.normal(size=M), "Q": rng.normal(size=M)},
        width=rng.uniform(0.5, 2, nodes),
    )


@pytest.mark.parametrize("tangents", [1, 2])
def test_flexibilities_add(tangents):
    system, rng = held(tangents), np.random.default_rng(1)
    k, K = rng.uniform(0.1, 10, (2, 4))
    soft = system.with_contact_stiffness(tangential=k, normal=K)
    give = 1 / np.concatenate([*[k * system.width] * tangents, K * system.width])
    flexibility = np.linalg.inv(system.S) + np.diag(give)
    assert np.abs(soft.S @ flexibility - np.eye(len(give))).max() < 1e-12
    for name, pair in system.bonded.items():  # what moves without contact is the same
        free = np.linalg.solve(system.S, joined(*pair))
        assert (
            np.abs(flexibility @ joined(*soft.bonded[name]) - free).max()
            < 1e-12 * np.abs(free).max()
        )


@pytest.mark.parametrize("least", [1.0, 1e-8, 1e-11, 0.0])
def test_springs_add_what_they_give_to_the_compliance_however_soft_a_motion_of_the_bodies_is(least):
    """`R^T (G^-1 + S)^-1 R`, with a bolted joint in mind: it hardly resists one motion."""
    rng = np.random.default_rng(2)
    V = np.linalg.qr(rng.normal(size=(8, 8)))[0]
    S = V * np.r_[least, rng.uniform(1, 3, 7)] @ V.T
    R = rng.normal(size=(8, 2))
    width = rng.uniform(0.5, 2, 4)
    points = np.column_stack([np.arange(4.0), np.zeros(4)])
    system = fo.ContactSystem(
        (S + S.T) / 2, points, dict(zip("PQ", R.T, strict=True)), width=width, compliance=np.eye(2)
    )
    soft = system.with_contact_stiffness(tangential=5.0, normal=7.0)
    springs = np.diag(np.r_[5.0 * width, 7.0 * width])
    added = R.T @ np.linalg.solve(springs + system.S, R)
    assert np.abs(soft.compliance - np.eye(2) - added).max() < 1e-13 * np.abs(added).max()
    reactions = springs @ np.linalg.solve(springs + system.S, R)
    assert (
        np.abs(np.column_stack([joined(*pair) for pair in soft.bonded.values()]) - reactions).max()
        < 1e-13 * np.abs(R).max()
    )


@pytest.mark.parametrize(
    ("cells", "give", "limit", "onset"),
    [
        (80, 0.02, 0.20060, -0.239),
        (160, 0.02, 0.20055, -0.242),
        (80, 0.1, 0.21964, -0.152),
        (160, 0.1, 0.21962, -0.152),
    ],
)
def test_the_rigid_punch_settles_with_the_mesh(cells, give, limit, onset):
    hard, soft = punch(cells), punch(cells, give)
    sprung = hard.with_contact_stiffness(tangential=1 / give, normal=1 / give)
    assert np.abs(sprung.S - soft.S).max() < 1e-11 * np.abs(soft.S).max()
    found = fo.shakedown_limit(sprung, PULL, 0.3).load_factor
    (q0, p0), (q1, p1) = soft.bonded["P"], soft.bonded["sigma"]
    first = min(((0.3 * p0 - s * q0) / np.abs(s * q1 - 0.3 * p1)).min() for s in (1, -1))
    assert found == pytest.approx(linprog_limit(soft, PULL, 0.3)[1], rel=1e-7)
    assert (round(found, 5), round(first, 3)) == (limit, onset)


def test_a_contact_of_a_model_has_its_own_stiffness():
    model = wedge()
    hard = model.condense()
    contacts = [
        replace(one, tangential_stiffness=k)
        for one, k in zip(model.contacts, (3.0, np.inf), strict=True)
    ]
    soft = replace(model, contacts=contacts)
    on_first = np.where(hard.contact == model.contacts[0].name, 3.0, np.inf)
    assert np.array_equal(soft.condense().S, hard.with_contact_stiffness(tangential=on_first).S)
    slip, loads = np.linspace(0, 1e-3, hard.nodes), dict.fromkeys(model.loads, 1.0)
    q, p = soft.condense().reaction(loads)
    fields = soft.recover(loads, slip)
    system = soft.condense()
    assert fields.q == pytest.approx(q + system.A @ slip, abs=1e-9 * np.abs(p).max())
    assert fields.p == pytest.approx(p + system.B @ slip, abs=1e-9 * np.abs(p).max())


@pytest.mark.parametrize(
    "bad", [0.0, -1.0, np.nan, 1e-200, [1.0, 2.0], "soft", None, [1.0, 1.0, 0.0, 1.0], 1j]
)
@pytest.mark.parametrize("direction", ["tangential", "normal"])
def test_odd_stiffnesses(bad, direction):
    with pytest.raises(fo.ModelError, match=direction):
        held(1).with_contact_stiffness(**{direction: bad})
    with pytest.raises(fo.ModelError, match=f"{direction}_stiffness"):
        fo.fem.Contact("a", "b", **{f"{direction}_stiffness": bad})


def test_springs_need_widths():
    system = fo.ContactSystem(np.eye(2), [[0.0, 0.0]], {"P": [0.0, 1.0]})
    with pytest.raises(fo.ModelError, match="width: not known"):
        system.with_contact_stiffness(normal=1.0)


def test_springs_far_softer_than_the_bodies_in_one_direction_are_refused():
    with pytest.raises(fo.ModelError, match=r"tangential: .* times softer than the bodies"):
        held(1).with_contact_stiffness(tangential=1e-40)
