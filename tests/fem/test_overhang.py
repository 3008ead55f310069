"""Faces of body 1 that reach beyond body 2.

The tests cover the part that lies opposite, the nodes that carry the load, the free share,
exchanged bodies, and both ways into the condensation.
"""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import block_diag
from skfem import MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.calculix import Block, lines, node_set
from helpers.meshes import box, rotation, turned

KINDS = [(MeshQuad, MeshQuad), (MeshTri, MeshQuad), (MeshHex, MeshHex), (MeshTet, MeshHex)]


def narrow_below(kinds, edge, cells=(8, 5)):
    """A block from 0 to 4 on one from -1 to `edge`, in space both 1 deep; and a mean load."""
    d = 2 if kinds[0] in (MeshQuad, MeshTri) else 3
    across = [np.linspace(0.0, 1.0, 3)] * (d - 2)
    upper = box(kinds[0], np.linspace(0.0, 4.0, cells[0] + 1), *across, [0.0, 0.5, 1.0])
    lower = box(kinds[1], np.linspace(-1.0, edge, cells[1] + 1), *across, [-1.0, -0.5, 0.0])
    return {"upper": fo.fem.Body(upper), "lower": fo.fem.Body(lower, fo.fem.Material(2.0))}


def model(bodies, *contact, loads=None):
    up = "y" if bodies["upper"].mesh.dim() == 2 else "z"
    loads = loads or {
        "P": [fo.fem.Traction("upper", f"{up}+", **{up: -1.0})],
        "Q": [fo.fem.Traction("upper", f"{up}+", x=1.0, **{up: lambda x, *_: x})],
    }
    supports = [fo.fem.Support("lower", f"{up}-")]
    return fo.fem.ContactModel(bodies, supports, loads, [fo.fem.Contact(*contact)])


@pytest.mark.parametrize("kinds", KINDS)
def test_up_to_an_edge_between_facets_it_is_the_contact_of_the_part(kinds):
    """The edge of body 2, at x = 2.5, is one between two facets of body 1."""
    bodies = narrow_below(kinds, 2.5, (8, 4))
    part = bodies["upper"].mesh.with_boundaries(
        {"part": lambda x: (abs(x[-1]) < 1e-9) & (x[0] < 2.5 + 1e-9)}
    )
    bodies["upper"] = fo.fem.Body(part)
    with pytest.warns(fo.ModelWarning, match=r"1\.5 \(37\.5%\) has no opposite part of body"):
        whole = model(bodies, "upper", "lower").condense()
    named = model(bodies, "upper", "lower", "part", "contact").condense()
    assert np.allclose(whole.points, named.points) and np.allclose(whole.width, named.width)
    assert np.allclose(whole.S, named.S, rtol=0, atol=1e-12 * abs(named.S).max())
    for case, forces in named.bonded.items():
        for mine, right in zip(whole.bonded[case], forces, strict=True):
            assert np.allclose(mine, right, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kinds", KINDS)
@pytest.mark.parametrize("edge", [2.55, 2.7, 2.8, 2.99])
def test_the_contact_carries_the_load_and_has_the_size_of_what_lies_opposite(kinds, edge):
    bodies = narrow_below(kinds, edge)
    size = "length" if bodies["upper"].mesh.dim() == 2 else "area"
    beyond = f"the {size} {4 - edge:.3g} ({(4 - edge) / 4:.1%}) has no opposite part"
    with pytest.warns(fo.ModelWarning, match=re.escape(beyond)):
        system = model(bodies, "upper", "lower").condense()
    assert system.width.sum() == pytest.approx(edge) and system.width.min() > 0
    q, p = system.bonded["P"]
    assert p.sum() == pytest.approx(4.0) and np.abs(q.sum(axis=0)).max() < 1e-10
    q, p = system.bonded["Q"]
    assert q.sum(axis=0) == pytest.approx(-4.0 if q.ndim == 1 else [-4.0, 0.0], abs=1e-9)
    assert p.sum() == pytest.approx(-8.0)
    # Half a facet, 0.25, of a quadrilateral reaches this far beyond the edge; half the area of a
    # triangle lies within 1 - sqrt(1/2) of its height.
    furthest = 0.5 * np.sqrt(0.5) if kinds[0] is MeshTet else 0.25
    assert system.points[:, 0].max() < edge + furthest + 1e-9


@pytest.mark.parametrize("kinds", KINDS[:1] + KINDS[2:3])
@pytest.mark.parametrize("edge", [2.6, 2.9])
def test_pressure_and_moments_are_those_of_the_exchanged_bodies(kinds, edge):
    """Pressure and moments agree with those of the exchanged bodies.

    With exchanged bodies, the narrow body has the nodes, and all its facets lie opposite. The
    compliance of the glued bodies converges to the same number.
    """
    compliances = []
    for cells in (16, 32):
        bodies = narrow_below(kinds, edge, (cells, cells))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            one = model(bodies, "upper", "lower").condense()
            other = model(bodies, "lower", "upper").condense()
        compliances.append(one.compliance / other.compliance - 1)
        places = [s.points[:, 0] @ s.bonded["P"][1] / s.bonded["P"][1].sum() for s in (one, other)]
    # Of a mesh of 32 facets, 0.125 long, on the upper body.
    assert abs(places[0] - places[1]) < 0.03
    assert np.abs(compliances[-1]).max() < 0.02
    assert np.abs(compliances[-1]).max() < np.abs(compliances[0]).max() + 1e-3


def test_mirrored_and_turned_bodies_have_the_same_contact():
    bodies = narrow_below((MeshQuad, MeshQuad), 2.63)
    before = model(bodies, "upper", "lower").condense()
    angle = 0.7
    loads = {
        "P": [fo.fem.Traction("upper", "y+", *(rotation(angle) @ [0.0, -1.0]))],
        "Q": [fo.fem.Traction("upper", "y+", *(rotation(angle) @ [1.0, 0.0]))],
    }
    after = model(
        {
            name: fo.fem.Body(turned(body.mesh, angle), body.material)
            for name, body in bodies.items()
        },
        "upper",
        "lower",
        loads=loads,
    ).condense()
    assert np.allclose(before.S, after.S, rtol=0, atol=1e-11 * abs(before.S).max())
    assert np.allclose(before.bonded["P"], after.bonded["P"], atol=1e-11)

    mirror = np.diag([-1.0, 1.0])
    flipped = {
        name: fo.fem.Body(
            MeshQuad(mirror @ body.mesh.p, body.mesh.t).with_boundaries(body.mesh.boundaries),
            body.material,
        )
        for name, body in bodies.items()
    }
    mirrored = model(flipped, "upper", "lower").condense()
    assert np.allclose(mirrored.width[::-1], before.width)
    assert np.allclose(mirrored.bonded["P"][1][::-1], before.bonded["P"][1], atol=1e-11)
    assert np.allclose(mirrored.bonded["P"][0][::-1], -before.bonded["P"][0], atol=1e-11)


@pytest.mark.parametrize("at", [2.0, 2.45, 2.85, 3.2])
def test_a_block_on_an_edge_tips_over_where_its_weight_lies_beyond(at):
    """A block on an edge tips over if its weight is beyond the edge.

    The load acts on the facet of the top around `at`. The edge of the ground is at 2.6, and
    pressure acts up to half a facet, 0.1, beyond the edge or short of it.
    """
    upper = box(MeshQuad, np.linspace(0.0, 4.0, 21), [0.0, 0.5, 1.0])
    upper = upper.with_boundaries({"load": lambda x: (x[1] == 1.0) & (abs(x[0] - at) < 0.11)})
    bodies = {"upper": fo.fem.Body(upper), "lower": narrow_below(KINDS[0], 2.6)["lower"]}
    loads = {
        "P": [fo.fem.Traction("upper", "load", y=-1.0)],
        "Q": [fo.fem.Traction("upper", "load", x=1e-3)],
    }
    system = model(bodies, "upper", "lower", loads=loads).condense()
    slide = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5)
    assert (slide.load_factor > 0) is (at < 2.6), slide.reason


def test_what_has_no_node_opposite_is_refused():
    bodies = narrow_below((MeshQuad, MeshQuad), 2.7, (1, 5))
    bodies["lower"] = fo.fem.Body(box(MeshQuad, np.linspace(1.0, 2.0, 5), [-1.0, 0.0]))
    with pytest.raises(
        fo.ModelError, match="or less than half of each facet has one; name the part"
    ):
        model(bodies, "upper", "lower")

    # A ground up to x = 2, and a narrow tower from 3.2 to 3.4 below the last facet.
    pieces = box(MeshQuad, [-1.0, 2.0, 3.2, 3.4, 3.9], [-1.0, -0.5, 0.0])
    x, y = pieces.p[:, pieces.t].mean(axis=1)
    kept = (y < -0.5) | (x < 2.0) | ((x > 3.2) & (x < 3.4))
    pieces = pieces.remove_elements(np.flatnonzero(~kept)).with_boundaries(
        {"contact": lambda x: x[1] == 0, "y-": lambda x: x[1] == -1}
    )
    bodies = {
        "upper": fo.fem.Body(box(MeshQuad, np.arange(5.0), [0.0, 1.0])),
        "lower": fo.fem.Body(pieces),
    }
    with pytest.raises(
        fo.ModelError, match=r"around \(3\.5, 0\) has facets too large for the part of body 'lower'"
    ):
        model(bodies, "upper", "lower")


def jobs(folder, edge, d):
    """The blocks of `narrow_below` as a matrix with its deck, and the model of the same meshes."""
    depth = lines((0, 1, 2)) if d == 3 else []
    upper = Block(1, [*lines((0, 4, 8)), *depth, *lines((0, 1, 2))], 1.0, 0.3, "UP")
    lower = Block(1001, [*lines((-1, edge, 5)), *depth, *lines((-1, 0, 2))], 2.0, 0.3, "LOW")
    sets = {
        "CU": upper.on(d - 1, 0.0),
        "CL": lower.on(d - 1, 0.0),
        "TOP": upper.on(d - 1, 1.0),
        "BOT": lower.on(d - 1, -1.0),
    }
    numbers = np.concatenate([upper.numbers, lower.numbers])
    labels = np.array([(n, k) for n in numbers for k in range(1, d + 1)])
    free = ~np.isin(labels[:, 0], sets["BOT"])
    K = block_diag([part.stiffness() for part in (upper, lower)], format="csr")[free][:, free]
    entries = K.tocoo()
    rows = np.column_stack([labels[free][entries.row], labels[free][entries.col]])
    text = "".join(
        f"{n}, {k}, {m}, {a}, {float(value)!r}\n"
        for (n, k, m, a), value in zip(rows.tolist(), entries.data, strict=True)
    )
    (folder / "job_STIF1.mtx").write_text(text)
    deck = upper.deck() + lower.deck() + "".join(node_set(*pair) for pair in sets.items())
    (folder / "job.inp").write_text(f"{deck}*BOUNDARY\nBOT, 1, {d}\n")
    job = fo.readers.read_abaqus(folder / "job_STIF1.mtx", deck=folder / "job.inp")
    kinds = (MeshQuad, MeshQuad) if d == 2 else (MeshHex, MeshHex)
    bodies = narrow_below(kinds, edge)
    materials = {"upper": fo.fem.Material(1.0, 0.3), "lower": fo.fem.Material(2.0, 0.3)}
    return job, {name: fo.fem.Body(body.mesh, materials[name]) for name, body in bodies.items()}


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("edge", [2.5, 2.6, 2.9, 4.5])
def test_matrices_of_a_deck_have_the_contact_of_the_model(tmp_path, d, edge):
    job, bodies = jobs(tmp_path, edge, d)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        faces = job.mortar("CU", "CL")
    assert bool(caught) is (edge < 4)
    assert all(
        f"of the first face, the {['length', 'area'][d - 2]}" in str(w.message) for w in caught
    )
    loads = {
        "P": job.force("TOP", traction=-np.eye(d)[-1]),
        "Q": job.force("TOP", traction=np.eye(d)[0]),
    }
    system = fo.condense(job.K, loads, **faces, unknowns=job.unknowns, points=job.points)
    up = "xyz"[d - 1]
    right = model(
        bodies,
        "upper",
        "lower",
        loads={
            "P": [fo.fem.Traction("upper", f"{up}+", **{up: -1.0})],
            "Q": [fo.fem.Traction("upper", f"{up}+", x=1.0)],
        },
    ).condense()
    mine = np.lexsort(system.points.round(9).T)
    theirs = np.lexsort(right.points.round(9).T)
    assert np.allclose(system.points[mine], right.points[theirs])
    assert np.allclose(system.width[mine], right.width[theirs])
    for case in loads:
        for one, other in zip(system.bonded[case], right.bonded[case], strict=True):
            assert np.allclose(one[mine], other[theirs], rtol=0, atol=1e-9)
    assert np.allclose(system.compliance, right.compliance, rtol=1e-9)

    # The nodal forces of the contact balance the load on body 1, with their moments, and body 2
    # gets the opposite ones.
    q, p = system.bonded["P"]
    shear = q[:, None] if d == 2 else q
    force = np.einsum("nt,nta->na", shear, system.frames[:, :-1]) + p[:, None] * system.normals
    relative = -faces["projection"].toarray()
    relative[np.arange(system.nodes), faces["pairs"]] += 1.0
    nodal = relative.T @ force
    is_upper = job.deck.numbers < 1000
    for side, sign in ((is_upper, 1.0), (~is_upper, -1.0)):
        assert np.allclose(nodal[side].sum(axis=0), sign * 4 * np.eye(d)[-1])
        assert job.points[side, 0] @ nodal[side, -1] == pytest.approx(sign * 4 * 2.0)


@pytest.mark.parametrize("edge", [2.55, 2.7, 4.2])
def test_the_projection_is_that_of_integrals_by_brute_force(tmp_path, edge):
    """The projection agrees with integrals by brute force.

    Biorthogonal functions on the part of each facet that lies opposite are summed over many points.
    Beyond the edge the nearest node has the mean motion of both.
    """
    job, _ = jobs(tmp_path, edge, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fo.ModelWarning)
        faces = job.mortar("CU", "CL")
    nodes = job.nodes("CU")[np.argsort(job.points[job.nodes("CU"), 0])]
    others = job.nodes("CL")[np.argsort(job.points[job.nodes("CL"), 0])]
    x, y = job.points[nodes, 0], job.points[others, 0]
    D, M = np.zeros(len(x)), np.zeros((len(x), len(y)))
    for a in range(len(x) - 1):
        end = min(x[a + 1], y[-1])
        if end <= x[a]:
            continue
        at = x[a] + (np.arange(20_000) + 0.5) / 20_000 * (end - x[a])
        weight = (end - x[a]) / 20_000
        phi = np.array([x[a + 1] - at, at - x[a]]) / (x[a + 1] - x[a])
        psi = np.diag(weight * phi.sum(axis=1)) @ np.linalg.inv(weight * phi @ phi.T) @ phi
        chi = np.array([np.interp(at, y, unit) for unit in np.eye(len(y))])
        D[[a, a + 1]] += weight * phi.sum(axis=1)
        M[[a, a + 1]] += weight * psi @ chi.T
    inside = np.array(
        [
            any(min(x[i + 1], y[-1]) - x[i] >= 0.25 for i in (a - 1, a) if 0 <= i < len(x) - 1)
            for a in range(len(x))
        ]
    )
    last = int(np.flatnonzero(inside)[-1])
    relative = np.zeros((len(x), len(job.points)))
    relative[np.arange(len(x)), nodes] = D
    relative[:, others] -= M
    if last + 1 < len(x):
        relative[last] += relative[last + 1]
        D[last] += D[last + 1]
    expected = relative[: last + 1] / D[: last + 1, None]
    order = np.argsort(job.points[faces["pairs"], 0])
    mine = -faces["projection"].toarray()
    mine[np.arange(len(mine)), faces["pairs"]] += 1.0
    assert len(mine) == last + 1 and np.allclose(faces["width"][order], D[: last + 1], atol=1e-6)
    assert np.allclose(mine[order], expected, rtol=0, atol=1e-5)


def test_gaps_of_a_deck_are_measured_and_bad_faces_refused(tmp_path):
    job, _ = jobs(tmp_path, 4.5, 2)
    moved = job.deck.points + np.array([0.0, 0.125, 0.0]) * (job.deck.numbers < 1000)[:, None]
    apart = replace(job, deck=replace(job.deck, points=moved))
    assert np.allclose(apart.mortar("CU", "CL", gap="measured")["gap"], 0.125)
    with pytest.raises(fo.ModelError, match=r"'CU' and 'CL', at .* they are 0\.125 apart"):
        apart.mortar("CU", "CL")
    with pytest.raises(fo.ModelError, match="gap: 'wide'; give 'measured'"):
        job.mortar("CU", "CL", gap="wide")
    with pytest.raises(
        fo.ModelError, match=r"the first face around .* has no opposite part of the second"
    ):
        job.mortar("CU", np.flatnonzero((job.points[:, 0] == 0) & (job.deck.numbers < 1000)))
    into = job.deck.points - np.array([0.0, 0.125, 0.0]) * (job.deck.numbers < 1000)[:, None]
    with pytest.raises(fo.ModelError, match=r"the bodies overlap by 0\.125"):
        replace(job, deck=replace(job.deck, points=into)).mortar("CU", "CL")
