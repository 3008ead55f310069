"""Friction that differs along the two tangents.

It is compared with its ellipse in unscaled lengths, with cone programs, and with the same contact
whose tangents change places.
"""

from functools import partial

import cvxpy as cp
import numpy as np
import pytest
from matplotlib.quiver import Quiver

import frictopt as fo
from helpers.components import joined, parted
from helpers.refused import refused
from helpers.spatial import random_contact
from helpers.systems import TO_AND_FRO, uncoupled

CYCLE = fo.LoadCycle({"mean": 1.0}, [{"a": 0.3, "b": 0.2}, {"a": -0.3, "b": -0.2}])
F = 0.4


def turned(system):
    """The same contact with its tangents by a quarter turn: the second tangent is the first."""
    n = system.nodes
    Q = np.zeros((3 * n, 3 * n))
    each = np.arange(n)
    Q[each, n + each], Q[n + each, each], Q[2 * n + each, 2 * n + each] = 1.0, -1.0, 1.0
    frames = np.einsum("ab,nbc->nac", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], system.frames)
    bonded = {name: Q @ joined(*pair) for name, pair in system.bonded.items()}
    return fo.ContactSystem(
        Q @ system.S @ Q.T, system.points, bonded, frames=frames, gap=system.gap, width=system.width
    )


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.0, np.pi / 2])
def test_one_node_slips_where_its_shear_reaches_the_ellipse(angle):
    """`(x / f1)^2 + (y / f2)^2 = (p / Q)^2`, by onset, limit, sliding-off load and the work of a
    transient along an axis."""
    x, y, ratio, P = np.cos(angle), np.sin(angle), 0.3, 2.0
    node = fo.ContactSystem(
        np.diag([1.0, 1.0, 2.0]), [[0, 0, 0]], {"P": [0, 0, 1.0], "Q": [x, y, 0.0]}
    ).with_orthotropic_friction(ratio)
    cycle = fo.LoadCycle({"P": P}, TO_AND_FRO)
    most = P / np.hypot(x / F, y / (F * ratio))
    direction = -np.array(
        [x / F**2, y / (F * ratio) ** 2]
    )  # normal to the ellipse, against the load
    first = fo.onset(node, cycle, F).slip
    assert first.load_factor == pytest.approx(most, rel=1e-9)
    assert np.abs(first.sense - direction / np.linalg.norm(direction)).max() < 1e-12
    assert fo.shakedown_limit(node, cycle, F).load_factor == pytest.approx(most, rel=1e-9)
    assert fo.guaranteed_limit(node, cycle, F).load_factor == pytest.approx(most, rel=1e-7)
    free = fo.ContactSystem(
        np.zeros((3, 3)), [[0, 0, 0]], {"P": [0, 0, 1.0], "Q": [x, y, 0.0]}
    ).with_orthotropic_friction(ratio)
    slide = fo.gross_slip(free, cycle, F)
    assert slide.load_factor == pytest.approx(most, rel=1e-8)
    found = slide.motion[["x", "y"]].to_numpy()[0]
    assert np.abs(found - direction / np.linalg.norm(direction)).max() < 1e-6
    if x * y < 1e-9:
        steady = fo.steady_state(node, cycle, F, 1.5 * most, steps=4)
        assert steady.dissipation == pytest.approx(4 * most * 0.5 * most, rel=1e-9)


def test_increments_obey_the_ellipse_and_its_normal_in_lengths_as_they_are():
    """Random coupled contacts with gaps are in equilibrium with their own stiffness, and slip is
    normal to the ellipse, against the force."""
    rng, slid = np.random.default_rng(0), 0
    for _ in range(25):
        n = 4
        bare = random_contact(rng, n).with_gap(0.3 * rng.random(n) * rng.integers(2, size=n))
        ratio = rng.uniform(0.3, 3.0, n)
        load = np.r_[rng.normal(size=2 * n), rng.normal(size=n) + 1.0]
        system = bare.with_bonded({"load": load}).with_orthotropic_friction(ratio)
        start = 0.2 * rng.normal(size=(n, 2))
        found = fo.increments.NewtonIncrement(system, F).solve(
            start * system.stretch, system.reaction({"load": 1.0})
        )
        v, q, p, w = found.slip / system.stretch, found.q * system.stretch, found.p, found.gap
        assert np.abs(joined(q, p) - load - bare.S @ joined(v, w - bare.gap)).max() < 1e-9
        assert (np.minimum(p, w) < 1e-9).all() and min(p.min(), w.min()) > -1e-9
        axes = F * np.column_stack([np.ones(n), ratio])
        size = np.linalg.norm(q / axes, axis=1)
        assert (size <= p + 1e-9).all()
        moved, normal = v - start, -q / axes**2
        slips = (np.linalg.norm(moved, axis=1) > 1e-9) & (p > 1e-6)
        slid += int(slips.sum())
        assert np.abs(size - p)[slips].max(initial=0.0) < 1e-9
        cross = moved[:, 0] * normal[:, 1] - moved[:, 1] * normal[:, 0]
        along = (moved * normal).sum(axis=1)
        assert np.abs(cross[slips] / along[slips]).max(initial=0.0) < 1e-8
        assert (along[slips] > 0).all()
    assert slid > 20


def test_the_limit_is_that_of_the_cone_program_in_lengths_as_they_are():
    rng = np.random.default_rng(1)
    for n in (1, 3):
        bare, ratio = random_contact(rng, n), rng.uniform(0.3, 3.0, n)
        limit = fo.shakedown_limit(
            bare.with_orthotropic_friction(ratio), CYCLE, F, open_nodes=np.zeros(n, dtype=bool)
        )
        v = cp.Variable(2 * n)
        lam = cp.Variable(nonneg=True)
        rows = []
        (q0, p0) = bare.closed_reaction(CYCLE.mean)
        (q1, p1) = CYCLE.corner_reactions(bare)
        for q, p in zip(q1, p1, strict=True):
            shear = joined(q0, p0)[: 2 * n] + lam * joined(q, p)[: 2 * n] + bare.A @ v
            scaled = cp.vstack([shear[:n] / F, cp.multiply(shear[n:], 1 / (F * ratio))])
            rows.append(cp.norm(scaled, 2, axis=0) <= p0 + lam * p + bare.B @ v)
        cp.Problem(cp.Maximize(lam), rows).solve(solver="CLARABEL")
        assert limit.load_factor == pytest.approx(float(lam.value), rel=1e-6)
        assert limit.residual < 1e-9
        shear, _ = limit.reactions
        assert np.abs(shear).max() > 0


def test_tangents_that_change_places_change_no_answer():
    """Friction f and r f along t1 and t2 is r f and f along t2 and -t1, ratio 1 / r. Limits, loads
    that slide off, works, tables and texts agree."""
    bare = random_contact(np.random.default_rng(2), 4)
    bare = fo.ContactSystem(bare.S, bare.points, dict(bare.bonded), width=[0.5, 1.0, 1.5, 2.0])
    ratio = np.array([0.5, 2.0, 0.8, 1.4])
    one, f = bare.with_orthotropic_friction(ratio), np.full(4, F)
    other = turned(bare).with_orthotropic_friction(1 / ratio)
    g = F * ratio
    limits = [fo.shakedown_limit(system, CYCLE, c) for system, c in ((one, f), (other, g))]
    assert limits[0].load_factor == pytest.approx(limits[1].load_factor, rel=1e-8)
    assert fo.guaranteed_limit(one, CYCLE, f).load_factor == pytest.approx(
        fo.guaranteed_limit(other, CYCLE, g).load_factor, rel=1e-6
    )
    lam = 1.5 * limits[0].load_factor
    steady = [
        fo.steady_state(system, CYCLE, c, lam, steps=4) for system, c in ((one, f), (other, g))
    ]
    assert steady[0].dissipation > 0
    assert np.allclose(
        steady[0].dissipation_per_node, steady[1].dissipation_per_node, rtol=1e-7, atol=1e-12
    )
    columns = ["slip_range", "tau_amplitude", "work", "F1"]
    tables = [each.fretting_table() for each in steady]
    assert np.allclose(tables[0][columns], tables[1][columns], rtol=1e-6, atol=1e-12)
    assert np.allclose(tables[0]["tau_mean1"], -tables[1]["tau_mean2"], atol=1e-9)
    assert np.allclose(tables[0]["tau_mean2"], tables[1]["tau_mean1"], atol=1e-9)
    contacts = [
        each.by_contact()[["work", "slip_range", "P_0", "Q_0", "Q_1"]].to_numpy(dtype=float)
        for each in steady
    ]
    assert np.allclose(*contacts, rtol=1e-6)
    slips = [each.slip / each.system.stretch for each in steady]
    assert np.allclose(slips[0], np.column_stack([-slips[1][:, 1], slips[1][:, 0]]), atol=1e-8)


def test_searches_and_regions_see_the_same_ellipse():
    """They are required friction, a region of two loads and a design, with tangents that change
    places."""
    bare = random_contact(np.random.default_rng(7), 3)
    one = bare.with_orthotropic_friction(0.5)
    other = turned(bare).with_orthotropic_friction(2.0)
    lam = fo.shakedown_limit(one, CYCLE, F).load_factor
    required = [fo.required_friction(system, CYCLE, 0.8 * lam).required for system in (one, other)]
    assert 0.5 * required[0] == pytest.approx(required[1], rel=1e-6)
    regions = [
        fo.safe_region(system, {"mean": 1.0}, ["a", "b"], f, tolerance=0.05)
        for system, f in ((one, F), (other, F / 2))
    ]
    assert np.allclose(*(region.to_frame()[["a", "b"]].to_numpy() for region in regions), rtol=1e-5)
    best = []
    for system, f in ((one, F), (other, F / 2)):
        model = fo.DesignModel(system, CYCLE, preloads=["mean"])
        best.append(model.solve(f, [model.preload >= -0.5, model.preload <= 0.5]).load_factor)
    assert best[0] == pytest.approx(best[1], rel=1e-6) and best[0] > lam


def test_the_shear_through_a_contact_is_that_of_the_loads():
    """A block cannot turn under its load. The sum of its shear forces is the push along the second
    tangent, in a table."""
    points = np.array([[x, y, 0.0] for x in (-4.0, 0.0, 4.0) for y in (-1.0, 1.0)])
    n = len(points)
    push = {
        "P": np.r_[np.zeros(2 * n), np.full(n, 1 / n)],
        "Y": np.r_[np.zeros(n), np.full(n, 1 / n), np.zeros(n)],
    }
    slides = np.kron(np.eye(2), np.full((n, n), 1 / n))
    S = np.zeros((3 * n, 3 * n))
    S[: 2 * n, : 2 * n], S[2 * n :, 2 * n :] = np.eye(2 * n) - slides, np.eye(n)
    body = fo.ContactSystem(S, points, push).with_orthotropic_friction(0.5)
    cycle = fo.LoadCycle({"P": 6.0}, [{"Y": 1.0}, {"Y": -1.0}])
    steady = fo.steady_state(body, cycle, F, 1.0, steps=2)
    table = steady.by_contact()
    assert table["Q_0"].item() == pytest.approx(1.0, rel=1e-9)
    assert table["fP_0"].item() == pytest.approx(6 * F)
    with pytest.raises(
        fo.NoContinuation, match=r"shear force 1.3 along \(0, .?1, 0\), above f P = 1.2"
    ):
        fo.steady_state(body, cycle, F, 1.3, steps=2)
    assert fo.shakedown_limit(body, cycle, F).load_factor == pytest.approx(1.2, rel=1e-8)


def test_a_strength_is_an_ellipse_too():
    """Where nothing changes a pressure, the strength lowers friction, with the same ratio."""
    bare, p = uncoupled(np.random.default_rng(3), 4, 2)
    system = bare.with_orthotropic_friction(0.6)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}])
    c = np.array([0.2, 0.3, 0.1, 0.4])
    strong = fo.ContactSystem(
        system.S, system.points, dict(system.bonded), shear_strength=c, stretch=system.stretch
    )
    limits = [
        fo.shakedown_limit(each, cycle, f).load_factor
        for each, f in ((strong, F), (system, np.minimum(F, c / p)))
    ]
    assert limits[0] == pytest.approx(limits[1], rel=1e-8)


def test_bodies_are_recovered_with_slips_as_they_are():
    model = fo.scenes.SquarePunch(elements=2, growth=3.0).model()
    rolled = model.condense().with_orthotropic_friction(0.4)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Qx": 0.05, "Qy": 0.15}, {"Qx": -0.05, "Qy": -0.15}])
    steady = fo.steady_state(rolled, cycle, 0.5, 1.0, steps=4)
    assert steady.dissipation > 0
    fields = model.recover(steady)
    again = model.recover(cycle.at(1.0)[-1], steady.slip / rolled.stretch, steady.gap)
    q, p = parted(
        joined(*rolled.reaction(cycle.at(1.0)[-1]))
        + rolled.S @ joined(steady.slip, steady.gap - rolled.gap),
        3,
    )
    assert np.abs(fields.q - q * rolled.stretch).max() < 1e-9 and np.abs(fields.p - p).max() < 1e-9
    shear = fields.q.sum(axis=0)
    assert np.array_equal(fields.q, again.q) and shear[1] / shear[0] == pytest.approx(3.0, rel=1e-8)


def test_a_ratio_of_one_is_the_same_contact_and_files_keep_another(tmp_path):
    bare = random_contact(np.random.default_rng(4), 3)
    assert not bare.with_orthotropic_friction(1.0).orthotropic
    assert np.array_equal(bare.with_orthotropic_friction(1.0).S, bare.S)
    system = bare.with_orthotropic_friction([0.5, 1.0, 2.0])
    system.save(tmp_path / "block.npz")
    again = fo.ContactSystem.load(tmp_path / "block.npz")
    assert np.array_equal(again.stretch, [[1, 0.5], [1, 1], [1, 2]])
    assert np.array_equal(again.S, system.S)
    assert "orthotropic=True" in repr(again)
    assert np.array_equal(system.with_gap([0.1] * 3).stretch, system.stretch)


@pytest.mark.usefixtures("no_figures_stay_open")
def test_arrows_of_a_picture_are_slips_as_they_are():
    limit = fo.shakedown_limit(
        random_contact(np.random.default_rng(5), 4).with_orthotropic_friction(0.5), CYCLE, F
    )
    (arrows,) = [one for one in limit.plot().collections if isinstance(one, Quiver)]
    drawn, slips = np.column_stack([arrows.U, arrows.V]), limit.slip / [1.0, 0.5]
    assert drawn / np.abs(drawn).max() == pytest.approx(slips / np.abs(slips).max())


ROUND = partial(random_contact, nodes=3)
STRETCHED = ROUND(np.random.default_rng(6)).with_orthotropic_friction(0.5)


@refused(
    (lambda: STRETCHED.with_orthotropic_friction(2.0), "orthotropic.*give one ratio to the system that it was made of"),
    (lambda: STRETCHED.with_bonded({"more": np.zeros(9)}), "orthotropic.*load cases"),
    (lambda: STRETCHED.with_contact_stiffness(tangential=1.0), "orthotropic.*springs"),
    (lambda: fo.joints.wear(STRETCHED, CYCLE, F, 1.0, coefficient=1e-6), "orthotropic.*true sliding distances"),
    (lambda: fo.joints.worn_in(STRETCHED, CYCLE, F, 1.0), "orthotropic.*true sliding distances"),
    (lambda: ROUND(np.random.default_rng(6)).with_orthotropic_friction(0.0), "ratio: 0.*give a ratio above 0"),
    (lambda: ROUND(np.random.default_rng(6)).with_orthotropic_friction(np.inf), "ratio"),
    (lambda: ROUND(np.random.default_rng(6)).with_orthotropic_friction([1.0, 2.0]), "ratio: shape"),
    (lambda: fo.scenes.PunchOnHalfPlane(elements=4).condense().with_orthotropic_friction(2.0), "in the plane has one tangent"),
)  # fmt: skip
def test_what_needs_lengths_as_they_are_refuses_it(ask):
    ask()
