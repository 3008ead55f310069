"""Surfaces that shear off at a strength.

They are compared with enumeration, scipy, closed forms, and a lower friction where pressures never
change.
"""

import re
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pytest

import frictopt as fo
from helpers.components import joined, parted
from helpers.refused import refused
from helpers.spatial import random_contact
from helpers.systems import (
    CYCLE,
    TO_AND_FRO,
    at_corners,
    block,
    largest_in_balance,
    linprog_limit,
    of_mode,
    random_system,
    uncoupled,
    unit_nodes,
)

STICK, FORWARD, BACKWARD, OPEN, OFF_FORWARD, OFF_BACKWARD = range(6)
SENSES = {FORWARD: 1.0, OFF_FORWARD: 1.0, BACKWARD: -1.0, OFF_BACKWARD: -1.0}
ROD = fo.ContactSystem.from_blocks(
    **fo.reference.foundation_rod(nodes=6, EA=1.0, h=1.0), width=[2.0] * 6
)
PUSHES = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])


def strong(system, *strength):
    """A system with a largest shear force at each node, force."""
    return replace(system, shear_strength=np.broadcast_to(strength, system.nodes))


def enumerated(system, f, slip, load):
    """All states of an increment in the plane, by trying the six statuses of each node."""
    n, S, c = system.nodes, system.S, system.shear_strength
    trial = load + S @ np.r_[slip, -system.gap]
    found = []
    unit = np.eye(2 * n)
    for status in product(range(6), repeat=n):
        rows, right = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        for i, kind in enumerate(status):
            sense = SENSES.get(kind, 0.0)
            law = {STICK: (0 * S[0], 0.0), OPEN: (S[i], trial[i])}.get(
                kind, (S[i] + sense * f * S[n + i], trial[i] + sense * f * trial[n + i])
            )
            law = (S[i], trial[i] + sense * c[i]) if kind in (OFF_FORWARD, OFF_BACKWARD) else law
            rows[i], right[i] = (unit[i], 0.0) if kind == STICK else (law[0], -law[1])
            rows[n + i], right[n + i] = (
                (S[n + i], -trial[n + i]) if kind == OPEN else (unit[n + i], 0.0)
            )
        u = np.linalg.solve(rows, right)
        r = trial + S @ u
        dv, w, q, p = np.r_[u, r].reshape(4, n)
        away = [-SENSES.get(kind, 0.0) * step for kind, step in zip(status, dv, strict=True)]
        if max((np.abs(q) - np.minimum(f * p, c)).max(), -p.min(), -w.min(), *away) < 1e-9:
            found.append(np.r_[slip + dv, w, q, p])
    return found


def test_increments_are_those_that_trying_all_statuses_finds():
    """Increments agree with a trial of all statuses.

    The random coupled contacts have one to three nodes, some without a strength, some with gaps.
    """
    rng, kinds = np.random.default_rng(0), []
    for case in range(60):
        n = 1 + case % 3
        system = random_system(rng, n).with_gap(0.3 * rng.random(n) * rng.integers(2, size=n))
        system = strong(system, *np.where(rng.random(n) < 0.2, np.inf, rng.uniform(0.05, 0.6, n)))
        slip = 0.3 * rng.normal(size=n)
        load = np.r_[rng.normal(size=n), rng.normal(size=n) + 1.0]
        states = enumerated(system, 0.4, slip, load)
        found = fo.increments.NewtonIncrement(system, 0.4).solve(slip, parted(load, 2))
        state = np.r_[found.slip, found.gap, found.q, found.p]
        assert min(np.abs(state - other).max() for other in states) < 1e-8 and found.residual < 1e-9
        kinds += [
            *zip(np.abs(found.status) == 1, np.abs(found.q) > 0.4 * found.p - 1e-9, strict=True)
        ]
    slid = [at_friction for slides, at_friction in kinds if slides]
    assert sum(slid) > 8 and len(slid) - sum(slid) > 20, "nodes slide at either bound"


def test_the_limit_is_that_of_raw_rows_by_scipy():
    """Pressures change with slip and load. Corners, mechanism and bound belong to the same contact."""
    rng, ruled = np.random.default_rng(2), 0
    for case in range(12):
        n = 1 + case % 5
        bare = random_system(rng, n)
        c = np.where(rng.random(n) < 0.3, np.inf, rng.uniform(0.05, 0.5, n))
        limit = fo.shakedown_limit(strong(bare, *c), CYCLE, 0.6, open_nodes=np.zeros(n, dtype=bool))
        q0, q1 = bare.closed_reaction(CYCLE.mean)[0], CYCLE.corner_reactions(bare)[0]
        strengths = [
            (sign * bare.A[i], sign * q[i], c[i] - sign * q0[i])
            for q in q1
            for sign in (1, -1)
            for i in np.flatnonzero(c < np.inf)
        ]
        status, largest = linprog_limit(bare, CYCLE, 0.6, upper=strengths)
        assert (status == 0) == (limit.kind is fo.LimitKind.FINITE)
        if status == 0:
            assert limit.load_factor == pytest.approx(largest, rel=1e-8)
            assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
            q, _ = at_corners(bare, CYCLE, limit.load_factor, limit.slip)
            assert (np.abs(q) <= c + 1e-9).all()
            assert np.nanmax(limit.traction_ratios) == pytest.approx(1.0, abs=1e-7)
            rates = limit.multipliers[limit.multipliers["row"].str.startswith("strength")]
            ruled += bool(rates["multiplier"].abs().max() > 1e-6)
            assert set(rates["node"]) == set(np.flatnonzero(c < np.inf))
    assert ruled > 5


def test_rates_of_the_limit_are_its_differences():
    rng, h = np.random.default_rng(3), 1e-6
    system, c = random_system(rng, 4), np.array([0.1, 0.15, np.inf, 0.2])
    ask = partial(fo.shakedown_limit, open_nodes=np.zeros(4, dtype=bool))
    limit = ask(strong(system, *c), CYCLE, 0.6)
    for node in range(4):
        f = np.where(np.arange(4) == node, 0.6 + h, 0.6)
        assert limit.friction_rate[node] == pytest.approx(
            (ask(strong(system, *c), CYCLE, f).load_factor - limit.load_factor) / h, abs=1e-4
        )
    rows = (
        limit.multipliers[limit.multipliers["row"].str.startswith("strength")]
        .groupby("node")["multiplier"]
        .sum()
    )
    assert rows.max() > 1e-3
    for node, rate in rows.items():
        more = c + h * (np.arange(4) == node)
        assert rate == pytest.approx(
            (ask(strong(system, *more), CYCLE, 0.6).load_factor - limit.load_factor) / h, abs=1e-4
        )
    table = limit.load_rates.query("part == 'mean' and load == 'mean'")["rate"].item()
    pressed = fo.LoadCycle({"mean": 1.0 + h}, CYCLE.corners)
    assert table == pytest.approx(
        (ask(strong(system, *c), pressed, 0.6).load_factor - limit.load_factor) / h, abs=1e-4
    )


@pytest.mark.parametrize("tangents", [1, 2])
def test_where_pressures_never_change_it_is_friction_that_is_lowered(tangents):
    """Where pressures never change, a strength lowers friction to `f' = min(f, c / p)`.

    Coulomb's law with this friction gives the same limits, onset, bounds of slip and transients;
    the transients in the plane follow the exact path.
    """
    rng = np.random.default_rng(4)
    bare, p = uncoupled(rng, 5, tangents)
    c = np.array([0.2, np.inf, 0.3, 0.1, 5.0])
    capped, lowered = strong(bare, *c), np.minimum(0.4, c / p)
    limit, same = (
        fo.shakedown_limit(system, CYCLE, f) for system, f in ((capped, 0.4), (bare, lowered))
    )
    assert limit.load_factor == pytest.approx(same.load_factor, rel=1e-8)
    # Of all states of rest only Coulomb's law has a theorem.
    assert same.proven and not limit.proven
    one = limit.least_slip(1.5 * limit.load_factor)
    other = same.least_slip(1.5 * limit.load_factor)
    assert one.total == pytest.approx(other.total, rel=1e-6)
    first, again = (fo.onset(system, CYCLE, f) for system, f in ((capped, 0.4), (bare, lowered)))
    assert [event.node for event in first.slips] == [event.node for event in again.slips]
    assert first.slip.node != 1
    assert [event.load_factor for event in first.slips] == pytest.approx(
        [event.load_factor for event in again.slips], rel=1e-12
    )
    assert first.residual < 1e-12
    load_factor = 1.7 * limit.load_factor
    steady = fo.steady_state(capped, CYCLE, 0.4, load_factor, steps=4)
    known = fo.steady_state(bare, CYCLE, lowered, load_factor, steps=None if tangents == 1 else 4)
    assert steady.dissipation > 0 and steady.outcome is known.outcome
    assert np.allclose(
        steady.dissipation_per_node,
        known.dissipation_per_node,
        rtol=1e-7,
        atol=1e-9 * known.dissipation,
    )
    assert np.allclose(steady.by_contact()["fP_0"], (lowered * p).sum())
    rests = fo.steady_state(
        capped, CYCLE, 0.4, 0.99 * limit.load_factor, initial_slip=limit.slip, steps=4
    )
    assert rests.outcome is fo.Outcome.SHAKEDOWN
    path = fo.march(capped, CYCLE, 0.4, load_factor, cycles=1, steps=4)
    assert path.residual < 1e-9 and (path.q <= np.inf).all()
    if tangents == 1:
        exact = fo.march(bare, CYCLE, lowered, load_factor, cycles=1)
        assert np.abs(path.slip[-1] - exact.slip[-1]).max() < 1e-9 * np.abs(exact.slip).max()


def test_the_capped_rod_in_closed_form():
    """A rod on a foundation with a strength has its work in closed form.

    The rod is pulled to and fro. Its work is proportional to the cube of the force over the shear,
    and the shear is the strength times the width.
    """
    rod = fo.ContactSystem.from_blocks(
        **fo.reference.foundation_rod(nodes=100, EA=1.0, h=1.0), width=[1.0] * 100
    )
    shears = rod.reaction({"pressure": 1.0})[1]
    steady = fo.steady_state(replace(rod, shear_strength=0.5 * shears), PUSHES, 0.9, 15.0, steps=2)
    assert steady.dissipation == pytest.approx(
        fo.reference.rod_dissipation(F0=15.0, EA=1.0, tau=0.5, h=1.0), rel=0.05
    )


def test_a_block_slides_off_at_what_pressure_and_strength_hold():
    """The reference is a program of all forces by scipy: pressure may act anywhere in balance with
    the moment."""
    rng, n = np.random.default_rng(5), 5
    system, cycle = block(rng, width=8.0), fo.LoadCycle({"P": 4.0}, TO_AND_FRO)
    N = np.linalg.svd(system.S)[2][-3:].T
    r0, r1 = (joined(*system.reaction(load)) for load in ({"P": 4.0}, {"Q": 1.0}))
    for c in (rng.uniform(0.05, 0.3, n), np.array([0.1, 0.2, np.inf, 0.1, 0.3]), np.full(n, 0.01)):
        slide = fo.gross_slip(strong(system, *c), cycle, 0.5)
        found = [
            largest_in_balance(N, np.full(n, 0.5), r0, sign * r1, strength=c) for sign in (1, -1)
        ]
        assert slide.load_factor == pytest.approx(min(found), rel=1e-8)
        assert slide.bound == pytest.approx(slide.load_factor, rel=1e-7)
        assert slide.load_factor < 0.99 * fo.gross_slip(system, cycle, 0.5).load_factor
        assert "strength: " in str(slide.problem) and slide.residual < 1e-9


def test_a_coupled_node_in_space_in_closed_form():
    """Its load also presses it at one corner and relieves it at the other: `2 lam = min(f (p0 + lam
    p1), c) + min(f (p0 - lam p1), c)`."""
    node = fo.ContactSystem(
        np.eye(3) * [1.0, 1.0, 2.0], [[0, 0, 0]], {"P": [0, 0, 1.0], "Q": [0.6, 0.8, 0.3]}
    )
    cycle = fo.LoadCycle({"P": 2.0}, [{"Q": 1.0}, {"Q": -1.0}])
    for c in (0.4, 0.9, 1.1, 2.0):
        limit = fo.shakedown_limit(strong(node, c), cycle, 0.5)
        assert limit.load_factor == pytest.approx(min(1.0, c, (1 + c) / 2.15), rel=1e-8)
        assert limit.residual < 1e-9


def test_a_body_that_its_surface_does_not_hold_has_no_state():
    """The strengths hold at most .5 in all."""
    body = strong(block(np.random.default_rng(6)), 0.1)
    cycle = fo.LoadCycle({"P": 4.0}, TO_AND_FRO)
    with pytest.raises(
        fo.NoContinuation,
        match=r"\(Q = \+1\) has the shear force 0\.6 along \(1, 0\), above the 0\.5 of friction and strength;",
    ):
        fo.march(body, cycle, 0.5, 0.6, cycles=1, steps=2)
    assert fo.march(body, cycle, 0.5, 0.4, cycles=1, steps=2).residual < 1e-9


@pytest.mark.parametrize("axes", [2, 3])
def test_a_mean_load_slides_and_turns_bodies_off_from_the_sliding_off_load_on(axes):
    """Motions against forces: the one from `gross_slip`, the other as transients tell it."""
    rng, reasons = np.random.default_rng(axes), []
    for _ in range(4):
        body = block(rng, width=8.0, axes=axes)
        n, f = body.nodes, rng.uniform(0.2, 0.9)
        any_load = np.r_[rng.normal(size=(axes - 1) * n), 0.3 * rng.normal(size=n)]
        strength = np.where(rng.random(n) < 0.3, np.inf, rng.uniform(0.02, 0.5, n))
        body = replace(strong(body, *strength), bonded={**body.bonded, "any": any_load})
        most = fo.gross_slip(body, fo.LoadCycle({"P": 4.0}, [{"any": 1.0}]), f).load_factor
        for share in (0.999, 1.001):
            mean = fo.LoadCycle({"P": 4.0, "any": share * most}, [{"Q": 0.1}])
            reasons.append(fo.onset(body, mean, f).reason)
            assert bool(re.search("as a whole|turns over", reasons[-1])) is (share > 1), reasons[-1]
    assert sum("of friction and strength" in each for each in reasons) > 1


def test_the_referee_sees_shear_beyond_the_strength():
    node = strong(
        unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}),
        0.3,
    )
    bonded = node.reaction({"P": 2.0, "Q": 0.8})
    ask = partial(
        fo.reference.check_contact_law, node, bonded, 0.5, w=[0.0], p=[2.0], previous_slip=[0.0]
    )
    assert ask(v=[-0.5], q=[0.3]).residual < 1e-15
    assert ask(v=[0.0], q=[0.8]).bound == pytest.approx(0.25)
    assert ask(v=[-0.4], q=[0.4]).bound == pytest.approx(0.05)
    assert ask(v=[-0.6], q=[0.2]).direction > 0.04, "it slides below its strength"


def test_a_strength_is_given_per_area_kept_in_files_and_carried_by_copies(tmp_path):
    soft = ROD.with_shear_strength(0.1)
    assert np.array_equal(soft.shear_strength, [0.2] * 6)
    assert soft.capped
    assert "shear_strength=True" in repr(soft)
    assert not ROD.with_shear_strength(np.inf).capped
    assert not ROD.capped
    assert "shear" not in repr(ROD)
    soft.save(tmp_path / "rod.npz")
    assert np.array_equal(
        fo.ContactSystem.load(tmp_path / "rod.npz").shear_strength, soft.shear_strength
    )
    copies = (
        soft.with_gap(0.1 * np.ones(6)),
        soft.with_contact_stiffness(tangential=1.0),
        soft.with_interference({"fit": 0.1}),
    )
    assert all(np.array_equal(each.shear_strength, soft.shear_strength) for each in copies)


def test_a_study_does_not_take_runs_of_another_strength(tmp_path):
    ask = partial(
        fo.dissipation_study,
        cycle=PUSHES,
        friction=0.5,
        load_factors=[1.0],
        starts=fo.starts.no_slip(),
        store=tmp_path / "runs.db",
        progress=False,
    )
    without = ask(ROD)["dissipation"].item()
    # The store is new to a contact with strengths, and says so.
    with pytest.warns(fo.results.OtherRows, match="other contacts"):
        strong = ask(ROD.with_shear_strength(0.1))["dissipation"].item()
    with pytest.warns(fo.results.OtherRows, match="other contacts"):
        weak = ask(ROD.with_shear_strength(0.05))["dissipation"].item()
    assert len({without, strong, weak}) == 3
    assert ask(ROD)["dissipation"].item() == without


def test_a_report_leaves_out_what_does_not_know_it():
    soft = ROD.with_shear_strength(0.1)
    joint = fo.report(soft, PUSHES, 0.5, load_factors=[0.5], steps=2)
    assert {
        "guaranteed limit",
        "required friction",
        "friction as assembled",
    } == joint.missing.keys()
    assert joint.limit.load_factor < fo.shakedown_limit(ROD, PUSHES, 0.5).load_factor


@refused(
    (lambda s: fo.guaranteed_limit(s, PUSHES, 0.5), "shear strength.*does not know.*ask shakedown_limit"),
    (lambda s: fo.required_friction(s, PUSHES, 1.0), "does not know"),
    (lambda s: fo.safe_slip(s, PUSHES, 0.5, 0.1), "does not know"),
    (lambda s: fo.safe_region(s, {"pressure": 1.0}, ["force", "pressure"], 0.5), "does not know"),
    (lambda s: fo.DesignModel(s, PUSHES), "does not know"),
    (lambda s: fo.GuaranteedModel(s, PUSHES), "does not know"),
    (lambda s: fo.dissipation_range(s, PUSHES, 0.5, 1.0), "does not know"),
    (lambda s: fo.joints.backbone_curve(of_mode(s, PUSHES, 0.1), PUSHES, 0.5, [1.0], with_range=True), "does not know"),
    (lambda s: fo.limit_after_protocol(fo.shakedown_limit(s, PUSHES, 0.5), start="worst"), "does not know"),
    (lambda s: fo.joints.worn_in(s, PUSHES, 0.5, 1.0), "shear strength"),
    (lambda s: fo.march(s, PUSHES, 0.5, 1.0, cycles=1).increment(1, "milp"), "form 'milp' does not know"),
    (lambda s: fo.march(s, PUSHES, 0.5, 1.0, cycles=1).increment(1, "complementarity"), "does not know"),
    (lambda s: fo.shakedown_limit(s, PUSHES, 0.5, events=True), "shear strength; pass events=False"),
    (lambda s: replace(s, width=None).with_shear_strength(1.0), "width: not known"),
    (lambda s: s.with_shear_strength(0.0), "strength: 0.*> 0"),
    (lambda s: s.with_shear_strength([1.0, np.nan, 1, 1, 1, 1]), "strength: nan at node 1"),
    (lambda s: s.with_shear_strength([1.0, 2.0]), "strength: shape"),
)  # fmt: skip
def test_what_does_not_know_a_strength_refuses_it(ask):
    ask(ROD.with_shear_strength(0.1))


@pytest.mark.usefixtures("no_figures_stay_open")
def test_a_picture_of_a_limit_is_over_the_strength():
    limit = fo.shakedown_limit(ROD.with_shear_strength(0.1), PUSHES, 0.5)
    axes = limit.plot()
    assert axes.get_ylabel() == r"$q / \min(f p, c)$"
    assert max(
        np.abs(line.get_ydata()).max() for line in axes.get_lines() if len(line.get_xdata()) == 6
    ) == pytest.approx(1.0, abs=1e-6)


def test_open_nodes_in_space_are_eliminated_with_their_strengths():
    """A transient in which sweeps fail and nodes are open gives the same result from the reduced
    contact."""
    rng = np.random.default_rng(7)
    system = strong(
        random_contact(rng, 6).with_gap([0.0] * 4 + [5.0] * 2), 0.1, 0.2, np.inf, 0.15, 0.1, 0.1
    )
    engine = fo.increments.NewtonIncrement(system, 0.4)
    loads = [joined(*system.reaction({"mean": 1.0, "a": share})) for share in (0.2, 0.5, -0.5, 0.1)]
    plain = list(
        fo.increments.NewtonIncrement(system, 0.4).along(np.r_[np.zeros(12), -system.gap], loads)
    )
    swept, eliminated, left = engine._swept, engine._without_open, []
    engine._swept = lambda u, r, law: replace(swept(u, r, law), error=np.inf)
    engine._without_open = lambda *arguments: left.append(eliminated(*arguments)) or left[-1]
    for (u, r, status), (v, q, kind) in zip(
        plain, engine.along(np.r_[np.zeros(12), -system.gap], loads), strict=True
    ):
        assert np.abs(u - v).max() < 1e-9 and np.abs(r - q).max() < 1e-9 and (status == kind).all()
    assert (
        len(left) == 3 and all(left) and all(np.abs(status).sum() > 4 for _, _, status in left)
    ), "two open nodes, and others that slip"
