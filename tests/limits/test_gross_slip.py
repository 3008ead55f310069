"""The sliding-off load against independent methods; damaged answers are refused.

The methods are closed forms, scipy, the kinematic program, transients and invariances.
"""

import itertools
from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.components import joined
from helpers.liars import is_excess, lying, misread, unpolished
from helpers.systems import TO_AND_FRO, block, body, largest_in_balance, rigid
from studies.validation.fuzz.embedded import embedded

PUNCH = fo.scenes.PunchOnHalfPlane(elements=12).condense()


def proves(found, system, friction, r0, r1):
    """The motion by itself proves the load factor.

    It strains nothing, lifts by f |v|, and its works give the bound.
    """
    *v, w = found.phi
    assert np.abs(system.S @ found.phi.ravel()).max() <= 1e-9 * np.abs(system.S).max()
    assert (w >= friction * np.linalg.norm(v, axis=0) - 1e-8).all()
    assert np.linalg.norm(found.phi, axis=0).max() == pytest.approx(1.0)
    assert found.phi.ravel() @ r1 < 0
    assert -(found.phi.ravel() @ r0) / (found.phi.ravel() @ r1) == pytest.approx(
        found.load_factor, rel=1e-7
    )
    assert found.bound == pytest.approx(found.load_factor, rel=1e-9) and found.residual <= 1e-9


@pytest.mark.parametrize("digits", [16, 12, 11, 10])
@pytest.mark.parametrize("nodes", [3, 12])
def test_a_motion_is_free_with_the_digits_of_any_matrix_job(digits, nodes):
    """A plate below the head of a bolt slides off at 2 f T, however the stiffness was rounded.

    The section of the bolt is in the matrix: the plate is free, and so is the head along the bolt.
    A motion that is free up to rounding holds nothing.
    """
    rng = np.random.default_rng(nodes)
    x = np.r_[np.linspace(-1.0, 1.0, nodes), np.linspace(-2.0, 2.0, nodes)]
    at_head = np.arange(2 * nodes) < nodes
    height = np.where(at_head, 1.0, 0.0)
    # The plate as body 2 of the head, and as body 1 of the joint.
    side = np.where(at_head, -1.0, 1.0)
    still = np.zeros(2 * nodes)
    free = [
        np.r_[side, still],
        np.r_[still, side],
        np.r_[-side * height, side * x],
        np.r_[still, at_head.astype(float)],
    ]
    basis = np.linalg.qr(np.column_stack(free))[0]
    root = rng.normal(size=(4 * nodes, 4 * nodes))
    root -= basis @ (basis.T @ root)
    root = np.vectorize(lambda entry: float(f"{entry:.{digits - 1}e}"))(root @ root.T)
    pressure = np.full(2 * nodes, 1.0 / nodes)
    loads = {"T": np.r_[still, pressure], "pull": np.r_[np.where(at_head, 0.0, pressure), still]}
    system = fo.ContactSystem(
        (root + root.T) / 2,
        np.column_stack([x, height]),
        loads,
        contact=np.where(at_head, "head", "joint"),
    )
    slide = fo.gross_slip(system, fo.LoadCycle({"T": 10.0}, [{"pull": 1.0}, {"pull": -1.0}]), 0.2)
    assert slide.load_factor == pytest.approx(4.0, rel=1e-6)
    assert slide.self_stress is None


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("friction", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("height", [0.5, 1.5, 4.0])
def test_a_block_slides_or_turns_over_its_edge(axes, friction, height):
    """The load is f P, or P times half the width over the height of the push, if that is less."""
    system = block(np.random.default_rng(0), height=height, axes=axes)
    found = fo.gross_slip(system, fo.LoadCycle({"P": 3.0}, [{"Q": 0.25}, {"Q": -2.0}]), friction)
    turns = 1.0 / height < friction
    assert found.load_factor == pytest.approx(3.0 * min(friction, 1.0 / height) / 2.0, rel=1e-9)
    assert (found.corner, found.loads, found.least) == (1, "Q = -2", 0.0)
    proves(
        found,
        system,
        friction,
        *(joined(*system.reaction(load)) for load in ({"P": 3.0}, {"Q": -2.0})),
    )
    (row,) = found.motion.to_dict("records")
    assert ("by a turn about" in found.reason) is turns
    assert ("along (-1, 0" in found.reason) is not turns
    if turns:
        assert row["at_x"] == pytest.approx(-1.0, abs=1e-6)
        assert abs(row["turn"]) == pytest.approx(0.5, rel=1e-6)
        assert row["turn"] > 0 if axes == 2 else row["turn"] * row["y"] < 0
    else:
        assert row["x"] == pytest.approx(-1.0)
        assert row["lift"] == pytest.approx(friction * row["slide"])
        assert row["turn"] == 0


def test_what_has_no_forces_in_balance_is_asked_no_transients():
    """Contacts without forces in balance need no transients, which would have no time here.

    They are flat and gently curved faces, held bodies, and nodes without friction.
    """
    cycle = fo.LoadCycle({"P": 1.0}, TO_AND_FRO)
    ask = {"cycle": cycle, "friction": 0.6, "seconds": 1e-9}
    for axes in (2, 3):
        assert fo.gross_slip(block(np.random.default_rng(0), axes=axes), **ask).self_stress is None
    assert fo.gross_slip(PUNCH, **ask).self_stress is None


@pytest.fixture(scope="module")
def press_fit():
    steel = fo.fem.Material(E=210e3, nu=0.3)
    return fo.scenes.PressFit(
        shaft_radius=10.0,
        collar_radius=25.0,
        collar_length=60.0,
        shaft_length=180.0,
        elements=40,
        grading=4.0,
        shaft_material=steel,
        collar_material=steel,
    ).condense()


@pytest.mark.parametrize("friction", [0.02, 0.05, 0.1])
def test_a_press_fit_slides_off_at_friction_times_the_pressure_of_the_fit(friction, press_fit):
    """The pressure of a long fit is known by Lame; a push of a collar adds some pressure."""
    system, interference = press_fit, 0.01
    cycle = fo.LoadCycle({"fit": interference}, [{"push": 1000.0}, {"push": -1000.0}])
    found = fo.gross_slip(system, cycle, friction)
    pressure = 210e3 * interference / (2 * 10.0) * (1 - 10.0**2 / 25.0**2)
    force = friction * pressure * 2 * np.pi * 10.0 * 60.0
    assert 1000.0 * found.load_factor == pytest.approx(force, rel=0.1)
    assert found.bound == np.inf
    assert "equilibrium does not determine the pressure of the fit" in found.reason
    assert "finds no continuation above" in found.reason
    *q, p = found.self_stress
    assert p.sum() == pytest.approx(1.0) and (np.abs(q) <= friction * p + 1e-6).all()
    below, above = (found.load_factor * (1 + sign * 5e-4) for sign in (-1, 1))
    assert fo.steady_state(system, cycle, friction, below).load_factor == below
    with pytest.raises(fo.NoContinuation):
        fo.steady_state(system, cycle, friction, above)


def test_transients_have_a_limit_in_time_and_the_answer_says_what_they_reached(monkeypatch):
    """Each look at the clock takes a second here. The fit slides off at 1.374."""
    system = fo.scenes.PressFit(elements=20).condense()
    cycle = fo.LoadCycle({"fit": 1.0}, [{"push": 1.0}, {"push": -1.0}])
    statics = fo.gross_slip(system, cycle, 0.3, seconds=0)
    assert statics.load_factor == np.inf and statics.self_stress is not None
    seconds = itertools.count()
    monkeypatch.setattr("time.monotonic", lambda: float(next(seconds)))
    for limit, no_end in [(6, True), (20, False)]:
        found = fo.gross_slip(system, cycle, 0.3, seconds=limit)
        assert 0 < found.load_factor <= 1.375 and found.bound == np.inf
        assert f"were followed for {limit} s" in found.reason
        assert ("but not at" in found.reason) is not no_end
        fo.march(system, cycle, 0.3, load_factor=found.load_factor, cycles=1)
    with pytest.raises(fo.SolverError, match="at most inf, by equilibrium; give more `seconds`"):
        fo.gross_slip(system, cycle, 0.3, seconds=2)
    with pytest.raises(fo.ModelError, match="seconds: -1"):
        fo.gross_slip(system, cycle, 0.3, seconds=-1)


def test_a_loose_collar_has_no_load_and_a_tension_that_drives_no_motion_no_limit():
    system = fo.scenes.PressFit(elements=20).condense()
    pulled = fo.LoadCycle({"fit": 1.0}, [{"tension": 1.0}, {"tension": -1.0}])
    held = fo.gross_slip(system, pulled, 0.3)
    assert held.load_factor == np.inf and held.self_stress is None
    loose = fo.LoadCycle({"fit": -1.0}, [{"push": 1.0}, {"push": -1.0}])
    assert np.isnan(fo.gross_slip(system, loose, 0.3).load_factor)


def test_random_faces_in_the_plane_agree_with_scipy():
    kinds = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 7))
        x = np.sort(rng.uniform(-1, 1, n))
        points, normals = np.column_stack([x, 0.3 * x**2]), np.column_stack([-0.6 * x, np.ones(n)])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        friction = rng.uniform(0.0, 0.8, n)
        motions = rigid(points, normals)[0]
        loads = {
            name: rng.normal(size=2 * n) + press * np.repeat([0.0, 1.0], n)
            for name, press in (("m", 1.5), ("a", 0.2), ("b", 0.0), ("c", 0.0))
        }
        system = body(rng, points, normals, loads, gap=rng.uniform(0, 0.1, n))
        cycle = fo.LoadCycle(
            {"m": 1.0},
            [{"a": 1.0}, {"b": 1.0}],
            fixed=None if seed % 2 else [{"c": 0.2}, {"c": -0.2}],
        )
        found = fo.gross_slip(system, cycle, friction)
        r0 = [joined(*system.reaction(load)) for load in cycle.unscaled] * 2
        r1 = [joined(*system.reaction(load)) for load in cycle.corners]
        most, least = (
            np.array(
                [
                    largest_in_balance(motions, friction, *pair, low)
                    for pair in zip(r0[:2], r1, strict=True)
                ]
            )
            for low in (False, True)
        )
        if np.isnan(most).any() or least.max() > most.min():
            assert np.isnan(found.load_factor)
            assert np.isnan(found.least)
            assert "no load factor has a state of rest" in found.reason
            kinds.append("none" if np.isnan(most).any() else "apart")
            if np.isnan(most).any():
                assert found.phi.ravel() @ r0[found.corner] < 0
                assert found.phi.ravel() @ r1[found.corner] < 1e-9
            continue
        assert found.load_factor == pytest.approx(most.min(), rel=1e-7)
        assert found.least == pytest.approx(least.max(), rel=1e-7, abs=1e-9)
        assert (found.least > 0) is ("; below" in found.reason)
        kinds.append(
            "inf" if found.load_factor == np.inf else "from 0" if found.least == 0 else "interval"
        )
        if np.isfinite(found.load_factor):
            proves(found, system, friction, r0[found.corner], r1[found.corner])
    assert set(kinds) >= {"none", "inf", "from 0", "interval"}, kinds


def test_random_faces_in_space_agree_with_the_program_of_the_motions():
    finite = 0
    for seed in few(range(20)):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(3, 8))
        points = rng.uniform(-1, 1, (n, 3)) * [1, 1, 0.2]
        normals = rng.uniform(-0.4, 0.4, (n, 3)) + [0, 0, 1]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        motions = rigid(points, normals)[0]
        friction = rng.uniform(0.1, 0.6, n)
        press = np.repeat([0.0, 0.0, 1.0], n)
        system = body(rng, points, normals, {"P": 2 * press, "Q": rng.normal(size=3 * n)})
        found = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), friction)
        y = cp.Variable(6)
        (r0, r1) = (joined(*system.bonded[name]) for name in "PQ")
        v1, v2, w = (motions[at * n : (at + 1) * n] @ y for at in range(3))
        rows = [
            cp.norm(cp.vstack([v1, v2]), axis=0) <= cp.multiply(1 / friction, w),
            (motions.T @ r1) @ y == -1,
        ]
        value = cp.Problem(cp.Minimize((motions.T @ r0) @ y), rows).solve(solver="CLARABEL")
        assert found.load_factor == pytest.approx(value, rel=1e-6)
        if np.isfinite(value):
            finite += 1
            proves(found, system, friction, r0, r1)
    assert finite >= 3


@pytest.mark.parametrize("friction", [1e-12, 1e-9, 1e-6, 1e-3, 0.3])
@pytest.mark.parametrize(
    "points",
    [[(-1, 0), (0, 0), (1, 0)], [(1, 0), (-0.5, 0.75), (-0.5, -0.75)]],
    ids=["line", "tripod"],
)
@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_body_on_three_nodes_slides_off_at_f_p_with_any_friction_and_units(
    friction, points, unit
):
    points = np.column_stack([points, np.zeros(3)])
    loads = {
        "P": unit * np.repeat([0.0, 0.0, 1.0], 3),
        "Q": unit * np.repeat([np.cos(0.7), np.sin(0.7), 0.0], 3),
    }
    three = body(np.random.default_rng(0), points, np.eye(3)[[-1] * 3], loads)
    found = fo.gross_slip(three, fo.LoadCycle({"P": 1.0}, TO_AND_FRO), friction)
    assert found.load_factor == pytest.approx(friction, rel=1e-8) and found.record.residual <= 1e-9


def test_held_bodies_never_slide_off():
    system = fo.scenes.PinInPlate(elements=8).condense()
    held = replace(PUNCH, S=PUNCH.S + np.eye(len(PUNCH.S)))
    # The load sigma pulls only the block.
    free = fo.gross_slip(PUNCH, fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}]), 0.5)
    for found in (
        fo.gross_slip(held, fo.LoadCycle({"P": 1.0}, TO_AND_FRO), 0.5),
        fo.gross_slip(system, fo.LoadCycle({}, [{"Fx": 1.0}]), 0.5),
        free,
    ):
        assert found.load_factor == found.bound == np.inf
        assert not found.phi.any()
        assert found.motion.empty
        assert found.corner == -1
    assert (
        "supports hold the bodies"
        in fo.gross_slip(held, fo.LoadCycle({"P": 1.0}, TO_AND_FRO), 0.5).reason
    )
    assert "at all load factors" in free.reason


def test_only_the_rigid_motions_of_a_stiffness_count_and_no_gap_does():
    rng, cycle = np.random.default_rng(3), fo.LoadCycle({"P": 1.0}, TO_AND_FRO)
    values, vectors = np.linalg.eigh(PUNCH.S)
    kept = vectors[:, values > 1e-9 * values[-1]]
    root = rng.normal(size=(kept.shape[1],) * 2)
    other = replace(
        PUNCH,
        S=kept @ (root @ root.T + np.eye(len(root))) @ kept.T,
        gap=rng.uniform(0, 1, PUNCH.nodes),
    )
    for friction in (0.3, 0.5, 0.8):
        one, again = (fo.gross_slip(system, cycle, friction) for system in (PUNCH, other))
        assert one.load_factor == pytest.approx(again.load_factor, rel=1e-9)


def test_a_contact_of_the_plane_in_space_has_the_same_load_factor():
    solid = embedded(PUNCH, np.random.default_rng(5))[0]
    for friction in (0.2, 0.7):
        one, again = (
            fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), friction)
            for system in (PUNCH, solid)
        )
        assert again.load_factor == pytest.approx(one.load_factor, rel=1e-8)


CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}])


def test_damaged_multipliers_are_refused(monkeypatch):
    def lie(compiled, z, multipliers):
        multipliers *= 1 + 1e-6

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.gross_slip(PUNCH, CYCLE, 0.4)


def test_forces_that_do_not_balance_are_refused(monkeypatch):
    """The load factor and its proof from above stay unchanged."""

    def lie(program, x, y):
        x[PUNCH.nodes : 2 * PUNCH.nodes] *= 1 + 1e-6  # the pressures

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.gross_slip(PUNCH, CYCLE, 0.4)


@pytest.mark.parametrize("status", ["infeasible", "unbounded"])
def test_a_solver_that_denies_the_answer_is_not_believed(monkeypatch, status):
    unpolished(monkeypatch)
    lying(monkeypatch, lambda program, name, x, y: None if is_excess(program) else status)
    with pytest.raises(fo.SolverError):
        fo.gross_slip(PUNCH, CYCLE, 0.4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((PUNCH, CYCLE, -0.1), "friction: -0.1"),
        ((PUNCH, {"P": 1.0}, 0.1), "cycle: a dict"),
        ((None, CYCLE, 0.1), "system"),
        ((PUNCH, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}]), 0.1), "load case 'X': unknown"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises(fo.ModelError, match=message):
        fo.gross_slip(*arguments)


@pytest.mark.parametrize("seed", few(range(6)))
def test_no_limit_is_above_the_load_at_which_the_body_slides_off(seed):
    """A flat punch whose load changes no pressure slips as soon as it slides off, so that its limit
    is the limit of all states."""
    rng = np.random.default_rng(seed)
    contact = block(rng, nodes=4, axes=2 + seed % 2)
    cycle = fo.LoadCycle({"P": 1.0}, TO_AND_FRO)
    limit = fo.shakedown_limit(contact, cycle, float(rng.uniform(0.1, 0.6)))
    assert not limit.load_factor > limit.bound_for_all * (1 + 1e-9)
    assert limit.proven == (limit.load_factor >= limit.bound_for_all * (1 - 2e-6))


def test_limits_of_all_states_and_of_some():
    held = fo.scenes.PinInPlate(elements=8).condense()
    limit = fo.shakedown_limit(held, fo.LoadCycle({"fit": 1.0}, [{"Fx": 1.0}, {"Fx": -1.0}]), 0.5)
    assert limit.bound_for_all == np.inf
    assert not limit.proven
    assert "here all nodes closed" in limit.covers
    rigid = fo.ContactSystem.from_blocks(
        np.zeros((2, 2)),
        np.zeros((2, 2)),
        [[1, -1], [-1, 1]],
        [-1.0, 1.0],
        {"P": ([0, 0], [0.5, 0.5]), "Q": ([0.5, 0.5], [0, 0])},
    )
    limit = fo.shakedown_limit(rigid, fo.LoadCycle({"P": 1.0}, TO_AND_FRO), 0.3)
    assert limit.load_factor == pytest.approx(0.3, rel=1e-9) and limit.proven
    pulled = fo.shakedown_limit(rigid, fo.LoadCycle({"P": -1.0}, TO_AND_FRO), 0.3)
    assert np.isnan(pulled.load_factor) and pulled.bound_for_all == 0.0 and not pulled.proven
