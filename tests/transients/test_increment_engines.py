"""Increments with a closed form, their invariances, and what the engines refuse.

Increments of one to three nodes are compared with the enumeration of all statuses.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictopt as fo
from frictopt.transients.increments import by_newton
from frictopt.transients.increments.newton import State
from frictopt.transients.increments.sweeps import increment
from helpers.cases import few
from helpers.components import joined, parted
from helpers.enumeration import admissible_states, distance, random_increment
from helpers.spatial import random_contact
from helpers.systems import SEEDS, random_system


def random_problem(seed, nodes, in_space, friction, unlike=0.0):
    """A dimensionless contact with gaps at some nodes, its law, and a random draw of loads.

    With `unlike` some motions of the contact are soft.
    """
    rng = np.random.default_rng(seed)
    contact = (random_contact if in_space else random_system)(rng, nodes, coupling=0.4)
    units = np.exp(unlike * rng.normal(size=len(contact.S)))
    bonded = {name: joined(*pair) for name, pair in contact.bonded.items()}
    gap = 0.3 * rng.uniform(size=nodes) * (rng.uniform(size=nodes) < 0.4)
    contact = fo.ContactSystem(contact.S * np.outer(units, units), contact.points, bonded, gap=gap)
    pressed = joined(*contact.reaction({next(iter(contact.bonded)): 1.0}))
    return fo.increments.NewtonIncrement(
        contact, friction
    ), lambda: pressed + rng.uniform(0.2, 1.0) * rng.normal(size=len(contact.S))


@settings(max_examples=few(40))
@given(
    seed=SEEDS,
    nodes=st.integers(1, 8),
    in_space=st.booleans(),
    friction=st.sampled_from([0.0, 0.2, 0.5, 2.0]),
    unlike=st.sampled_from([0.0, 1.0]),
)
# Friction does not oppose the slip, in the plane and in space.
@example(seed=228, nodes=3, in_space=False, friction=0.5, unlike=1.0)
@example(seed=1175, nodes=3, in_space=True, friction=2.0, unlike=1.0)
def test_sweeps_claim_no_state_that_the_referee_refuses(seed, nodes, in_space, friction, unlike):
    """This also holds where the sweeps end far from any state, because they swing with such a small
    tangential stiffness."""
    engine, drawn = random_problem(seed, nodes, in_space, friction, unlike)
    law, contact = engine.law, engine.system
    for share in (1.0, 0.6, 0.3):
        u, r = np.zeros(len(law.S)), drawn()
        load = r.copy()
        forces = np.empty_like(r)
        status = np.empty(nodes, dtype=np.int8)
        residual = increment(
            law.S,
            law.slopes,
            law.constants,
            law.augmentation,
            share * law.augmentation,
            u,
            r,
            forces,
            status,
        )
        if not np.abs(u).max() < 1e6:
            assert residual > 1e-9
            continue
        axes, scale = contact.tangents + 1, contact.stiffness_scale
        (v, w), (q, p), bonded = parted(u / scale, axes), parted(forces, axes), parted(load, axes)
        shut = contact.with_gap(np.zeros(nodes))
        verdict = fo.reference.check_contact_law(
            shut, bonded, friction, v=v, w=w, q=q, p=p, previous_slip=0 * v, force_scale=1.0
        )
        assert residual > 1e-12 or verdict.residual <= 1e-11


@settings(max_examples=few(30))
@given(
    seed=SEEDS,
    nodes=st.integers(1, 8),
    in_space=st.booleans(),
    friction=st.sampled_from([0.0, 0.2, 0.8]),
    hard=st.booleans(),
)
def test_increments_in_turn_are_those_one_by_one(seed, nodes, in_space, friction, hard):
    """Increments in succession agree with increments that are solved one by one.

    In succession, open nodes start from their gap, and reactions from the reactions before. One by
    one, each increment begins closed, from its own reactions.
    """
    engine, drawn = random_problem(seed, nodes, in_space, friction)
    contact = engine.system
    loads = [drawn() for _ in range(6)]
    swept = engine._swept

    def failing(u, r, law):
        return replace(swept(u, r, law), error=np.inf)

    one_by_one = fo.increments.NewtonIncrement(contact, friction)
    if hard:
        engine._swept = failing
    slip = np.zeros(contact.slip_shape)
    u = joined(np.zeros(contact.slip_shape), -contact.gap)
    for _ in range(2):
        for load, (found, r, status) in zip(loads, engine.along(u, loads), strict=True):
            (v, w), (q, p) = parted(found, contact.tangents + 1), parted(r, contact.tangents + 1)
            state = {"v": v, "w": w + contact.gap, "q": q, "p": p}
            assert (
                fo.reference.check_contact_law(
                    contact,
                    parted(load, contact.tangents + 1),
                    friction,
                    **state,
                    previous_slip=slip,
                ).residual
                < 1e-9
            )
            one = one_by_one.solve(slip, parted(load, contact.tangents + 1))
            if friction < 0.5:  # far below the critical one there is one state
                assert np.allclose(one.slip, v, atol=1e-9)
                assert np.allclose(one.gap, w + contact.gap, atol=1e-9)
                assert (one.status == status).all()
            slip, u = v, found


def test_newtons_method_goes_on_from_gaps_and_ends_at_rounding():
    """Gaps of ten thousand times the slip have rounding far above the least error it asks for."""
    rng, steps = np.random.default_rng(1), []
    contact = random_contact(rng, 20).with_gap(np.where(np.arange(20) < 5, 0.0, 1e4))
    engine = fo.increments.NewtonIncrement(contact, 0.4)
    by_newton = engine._by_newton
    load = joined(0.3 * rng.normal(size=(20, 2)), 1 + rng.random(20))
    engine._swept = lambda u, r, law: State(u, r, np.zeros(20, np.int8), 0, np.inf)
    engine._by_newton = lambda *start: steps.append(by_newton(*start)) or steps[-1]
    engine._without_open = lambda *state: None
    (begin, _, _), (u, r, _) = list(engine.along(np.zeros(60), [load, 1.01 * load]))
    (v, w), (q, p) = parted(u, 3), parted(r, 3)
    state = {"v": v, "w": w + contact.gap, "q": q, "p": p}
    assert (
        fo.reference.check_contact_law(
            contact, parted(1.01 * load, 3), 0.4, **state, previous_slip=parted(begin, 3)[0]
        ).residual
        < 1e-9
    )
    assert steps[0].steps < 9 and steps[1].steps < 5


@pytest.mark.parametrize("free", ["no motion", "an oblique motion", "a node"])
@pytest.mark.parametrize("in_space", [True, False])
def test_where_sweeps_fail_open_nodes_are_eliminated(in_space, free):
    """A node that closes is found, and the other open nodes stay eliminated, unless nothing holds
    one of them, which leaves a singular matrix. Increments that are solved one by one eliminate no
    node."""
    rng, n = np.random.default_rng(1), 12
    contact = (random_contact if in_space else random_system)(rng, n, coupling=0.2)
    axes, far = contact.tangents + 1, np.arange(n) > 4
    last = np.tile(np.arange(n) == n - 1, axes)
    oblique = np.linalg.qr(np.where(last, rng.normal(size=len(last)), 0.0)[:, None])[0]
    held = {
        "no motion": np.eye(len(last)),
        "an oblique motion": np.eye(len(last)) - oblique @ oblique.T,
        "a node": np.diag(1.0 - last),
    }[free]
    contact = fo.ContactSystem(
        held @ contact.S @ held,
        contact.points,
        {"P": np.ones(len(last))},
        gap=np.where(far, 0.3, 0.0),
    )
    engine = fo.increments.NewtonIncrement(contact, 0.3)
    newton = fo.increments.NewtonIncrement._by_newton
    newton_calls = []
    long = []
    engine._swept = lambda u, r, law: State(u, r, np.zeros(n, np.int8), 0, np.inf)
    engine._by_newton = lambda *start: newton_calls.append(1) or newton(engine, *start)
    shear = np.tile(rng.normal(size=n), contact.tangents)
    press = np.where(far, 0.0, 1.0)
    slip = np.zeros(contact.slip_shape)
    lower = press + np.where(np.arange(n) == 5, 3.0, 0.0)  # presses a far node down
    loads = [
        held @ np.append(scale * shear, p)
        for scale, p in ((0.1, press), (0.4, press), (-0.4, press), (0.2, lower), (0.3, lower))
    ]
    for load, (u, r, status) in zip(loads, engine.along(np.zeros(len(last)), loads), strict=True):
        one = fo.increments.NewtonIncrement(contact, 0.3).solve(slip, parted(load, axes))
        off = joined(one.slip, one.gap) - u - joined(0 * slip, contact.gap)
        assert np.abs(np.where(last & (free != "no motion"), 0.0, off)).max() < 1e-12
        assert (one.status == status).all()
        assert np.abs(joined(one.q, one.p) - r).max() < 1e-12
        slip = parted(u, axes)[0]
        long.append(len(newton_calls))
        newton_calls.clear()
    assert (status == 2).sum() == 6
    assert long == ([1, 0, 0, 0, 0] if free == "no motion" else [1] * 5)


def test_a_punch_that_tips_onto_open_nodes_has_states_of_its_law():
    """Without the nodes that were open nothing holds the punch."""
    punch = fo.scenes.SquarePunch(elements=4).condense()
    around = fo.LoadCycle(
        {"P": 1.0}, [{name: sense} for sense in (1.0, -1.0) for name in ("Qx", "Qy")]
    )
    problem = punch, around, 0.8, 2.0 * fo.shakedown_limit(punch, around, 0.8).load_factor
    path = fo.march(*problem, cycles=1, steps=3)
    verdict = fo.reference.check_contact_law(
        punch,
        (path.bonded_q[1:], path.bonded_p[1:]),
        0.8,
        v=path.slip[1:],
        w=path.gap[1:],
        q=path.q[1:],
        p=path.p[1:],
        previous_slip=path.slip[:-1],
    )
    assert verdict.residual < 1e-9 and (path.gap > 0).any()


def test_nodes_that_close_again_are_not_eliminated_again(monkeypatch):
    """A punch rocks to and fro and keeps lifting off at other nodes. Each node is eliminated once
    at most."""
    punch = fo.scenes.SquarePunch(elements=5).condense()
    made = []
    honest = by_newton._Rest.__init__
    monkeypatch.setattr(
        by_newton._Rest,
        "__init__",
        lambda rest, *arguments: made.append(arguments) or honest(rest, *arguments),
    )
    monkeypatch.setattr(
        fo.increments.NewtonIncrement,
        "_swept",
        lambda engine, u, r, law: State(u, r, np.zeros(36, np.int8), 0, np.inf),
    )
    around = fo.LoadCycle(
        {"P": 1.0}, [{name: sense} for sense in (1.0, -1.0) for name in ("Qx", "Qy")]
    )
    load_factor = 1.5 * fo.shakedown_limit(punch, around, 0.5).load_factor
    path = fo.march(punch, around, 0.5, load_factor, cycles=6, steps=4, progress=False)
    assert 0 < len(made) <= punch.nodes < 2 * (path.gap > 0).any(axis=0).sum()


@pytest.mark.parametrize("in_space", [False, True])
def test_programs_with_the_bound_of_a_state_have_it_as_their_optimum(in_space):
    for seed in range(12):
        engine, drawn = random_problem(seed, 1 + seed, in_space, 0.3)
        contact, rng = engine.system, np.random.default_rng(seed)
        slip = 0.3 * rng.normal(size=contact.slip_shape)
        load = parted(drawn(), contact.tangents + 1)
        one = engine.solve(slip, load, form="qp")
        one.problem.solve(
            solver="CLARABEL", **dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-10)
        )
        u = one.problem.var_dict["u"].value
        assert np.abs(u - joined(one.slip - slip, one.gap)).max() < 1e-4
        assert np.abs(one.problem.constraints[0].dual_value - one.p).max() < 1e-4


def test_a_wedged_node_stays_and_its_other_state_is_found():
    """A = 1, B = 0.5, and friction 3 is above the critical value 2. Without load both slip 1 and no
    slip are states (validation: wedging)."""
    contact = fo.ContactSystem.from_blocks(
        [[1.0]], [[0.5]], [[1.0]], [0.0], {"load": ([0.0], [1.0])}
    )
    engine = fo.increments.NewtonIncrement(contact, 3.0)
    found = engine.solve([1.0], ([0.0], [0.0]))
    assert found.slip.tolist() == [1.0]
    assert found.q == pytest.approx([1.0])
    assert found.p == pytest.approx([0.5])
    assert found.residual < 1e-9 and found.status.tolist() == [0]
    unloaded = engine.solve([0.0], ([0.0], [0.0]))
    assert unloaded.slip.tolist() == [0.0] and not unloaded.q.any() and not unloaded.p.any()


def test_below_onset_nothing_moves():
    rng = np.random.default_rng(0)
    for nodes in (1, 2, 5):
        contact = random_system(rng, nodes)
        slip = 0.01 * rng.normal(size=nodes)
        q, p = -contact.A @ slip + 0.1 * rng.normal(size=nodes), 1.0 - contact.B @ slip
        found = fo.increments.NewtonIncrement(contact, 0.9).solve(slip, (q, p))
        assert found.slip.tobytes() == slip.tobytes()
        assert not found.gap.any()
        assert not found.status.any()


@pytest.mark.parametrize("elements", [16, 40])
def test_increments_of_the_paper_s_scene_are_those_of_plain_cvxpy(punch, elements):
    """Nodes that stick keep their slip to the last bit, and on open ones nothing acts."""
    contact = punch(elements)
    engine = fo.increments.NewtonIncrement(contact, 0.7)
    slip = np.zeros(contact.nodes)
    for sigma, shear in ((2.5, 0.0), (-2.5, 0.0), (4.0, 0.0), (-4.0, 0.1), (0.0, 0.35)):
        load = contact.reaction({"P": 1.0, "sigma": sigma, "Q": shear})
        one = engine.solve(slip, load, form="qp")
        assert one.residual < 1e-12
        assert np.array_equal(one.slip[one.status == 0], slip[one.status == 0])
        assert not (np.abs(one.q) + one.p)[one.status == 2].any()
        assert (one.status == 2).any() == (abs(shear) > 0.2)
        one.problem.solve(solver="CLARABEL")
        step, gap = np.split(one.problem.var_dict["u"].value, 2)
        assert step == pytest.approx(one.slip - slip, abs=1e-4 * np.abs(one.slip).max())
        assert gap == pytest.approx(one.gap, abs=1e-4 * np.abs(one.slip).max())
        verdict = fo.reference.check_contact_law(
            contact, load, 0.7, v=one.slip, w=one.gap, q=one.q, p=one.p, previous_slip=slip
        )
        assert verdict.residual == pytest.approx(one.residual, abs=1e-14)
        slip = one.slip


def test_a_body_that_slides_away_has_no_state(punch):
    contact = punch(16)
    for loads in ({"P": 1.0, "Q": 0.5}, {"P": -1.0}):  # friction 0.4 holds 0.4 of the pressure
        load = contact.reaction(loads)
        with pytest.raises(
            fo.NoContinuation,
            match=r"^the body (lifts off or turns over|slides as a whole): .*the load",
        ):
            fo.increments.NewtonIncrement(contact, 0.4).solve(np.zeros(17), load)


SLIDING = {n: np.r_[np.ones(n), np.zeros(n)][:, None] for n in (2, 3)}
LIFTING = {n: np.r_[np.zeros(n), np.ones(n)][:, None] for n in (2, 3)}
FREE = {
    n: np.hstack([SLIDING[n], LIFTING[n], np.r_[np.zeros(n), np.arange(n)][:, None]])
    for n in (2, 3)
}


def cases(seed, count, most_friction, rigid=None, loads=1):
    rng = np.random.default_rng(seed)
    for case in range(count):
        nodes = 1 + case % 3 if rigid is None else 2 + case % 2
        contact, friction, _, _ = random_increment(
            rng, nodes, most_friction, rigid=None if rigid is None else rigid[nodes]
        )
        for _ in range(loads):
            _, _, slip, load = random_increment(rng, nodes, most_friction)
            yield contact, friction, slip, load


def test_exactly_one_state_is_found_below_the_critical_friction():
    """The reference is an enumeration on 120 coupled increments, with gaps, separation and closing."""
    opened = slipped = 0
    for contact, friction, slip, load in cases(0, 30, 0.6, loads=4):
        states = admissible_states(contact, friction, slip, load)
        assert len(states) == 1
        found = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        assert distance(states, found) < 1e-9 and found.residual < 1e-9
        opened = opened + (found.gap > 0).any()
        slipped = slipped + (np.abs(found.status) == 1).any()
    assert opened > 15 and slipped > 30


def test_one_of_several_states_is_found():
    several = one = 0
    for contact, friction, slip, load in cases(3, 60, 8.0):
        states = admissible_states(contact, friction, slip, load)
        found = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        assert distance(states, found) < 1e-9
        several, one = several + (len(states) > 1), one + (len(states) == 1)
    assert several >= 3 and one >= 30


@pytest.mark.parametrize(("rigid", "count"), [(LIFTING, 40), (FREE, 40)], ids=["lifting", "free"])
def test_bodies_that_only_their_load_holds(rigid, count):
    """Where there is a state, it is found; where there is none, none is found."""
    found = none = 0
    for contact, friction, slip, load in cases(4, count, 1.0, rigid):
        states = admissible_states(contact, friction, slip, load)
        try:
            state = fo.increments.NewtonIncrement(contact, friction).solve(slip, load)
        except (fo.NoContinuation, fo.SolverError):
            assert len(states) == 0
            none += 1
        else:
            assert distance(states, state) < 1e-9
            found += 1
    assert found > 7 and none > 1
