"""Bodies that friction alone cannot hold under the mean load.

Every question says so, in the plane and in space, and says it only of such bodies.
"""

import re
from dataclasses import replace
from itertools import product

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.transients.statics import check_sliding
from helpers.cases import few
from helpers.components import joined
from helpers.systems import rigid

PUNCH = fo.scenes.SquarePunch(elements=2, growth=3.0).condense()
_X, _Y, _ = PUNCH.points.T
_NONE = np.zeros_like(_X)
PUNCH = fo.ContactSystem(
    PUNCH.S,
    PUNCH.points,
    {**PUNCH.bonded, "T": np.r_[-_Y, _X, _NONE], "M": np.r_[_NONE, _NONE, _X]},
    width=PUNCH.width,
)
SHEARED = [{"Qx": 0.1}, {"Qx": -0.1}]


def guided(axes):
    """One node that only a support presses, and its cycle.

    The mean shear is 0.5 at a pressure of 1.
    """
    still = [0.0] * (axes - 2)
    node = fo.ContactSystem(
        np.diag([0.0] * (axes - 1) + [1.0]),
        np.zeros((1, axes)),
        {"m": [0.5, *still, 1.0], "a": [0.01, *still, 0.0]},
        width=[1.0],
    )
    return node, fo.LoadCycle({"m": 1.0}, [{"a": 1.0}, {"a": -1.0}])


def beside(one, other):
    """Two bodies that do not touch each other."""
    n, parts = one.nodes, (slice(one.nodes), slice(one.nodes, None))
    S = np.zeros((3, 2 * n, 3, 2 * n))
    loads = {name + end: np.zeros((3, 2 * n)) for name in ("P", "Qx") for end in "12"}
    for end, body, at in zip("12", (one, other), parts, strict=True):
        S[:, at, :, at] = body.S.reshape(3, n, 3, n)
        for name in ("P", "Qx"):
            q, p = body.bonded[name]
            loads[name + end][:, at] = *q.T, p
    places = np.vstack([one.points, other.points + [5.0, 0.0, 0.0]])
    return fo.ContactSystem(
        S.reshape(6 * n, -1),
        places,
        {name: load.ravel() for name, load in loads.items()},
        width=np.r_[one.width, other.width],
    )


CASES = {  # by hand: a pressure of 1 on 2 x 2, so that f P = 1.2 with f = 0.3
    "node in the plane": (
        *guided(2),
        r"the body slides as a whole: the mean load has the shear force 0\.5 along \(-1, 0\), above f P = 0\.3;",
    ),
    "node in space": (
        *guided(3),
        r"the body slides as a whole: the mean load has the shear force 0\.5 along \(-1, 0, 0\), above f P = 0\.3;",
    ),
    "slides": (
        PUNCH,
        fo.LoadCycle({"P": 1.0, "Qx": 0.3, "Qy": 0.3}, SHEARED),
        r"the body slides as a whole: the mean load has the shear force 1\.697 along \(0\.707107, 0\.707107, 0\), above f P = 1\.2;",
    ),
    "turns": (
        PUNCH,
        fo.LoadCycle({"P": 1.0, "T": 1.0}, SHEARED),
        "the body turns as a whole: the mean load drives it with ",
    ),
    "tips": (
        PUNCH,
        fo.LoadCycle({"P": 1.0, "M": 3.0}, SHEARED),
        "the body lifts off or turns over.*: no pressure .* balances the mean load;",
    ),
    "one of two bodies": (
        beside(PUNCH, PUNCH),
        fo.LoadCycle({"P1": 1.0, "P2": 1.0, "Qx2": 0.4}, [{"Qx1": 0.1}, {"Qx1": -0.1}]),
        r"the body slides as a whole at 9 of 18 nodes: the mean load has the shear force 1\.6 along \(1, 0, 0\), above f P = 1\.2;",
    ),
}
ANSWERS = {
    "shakedown_limit": lambda s, c, f: fo.shakedown_limit(s, c, f),
    "safe_slip": lambda s, c, f: fo.safe_slip(s, c, f, 1.0),
    "guaranteed_limit": lambda s, c, f: fo.guaranteed_limit(s, c, f),
    "onset": lambda s, c, f: fo.onset(s, c, f),
}
ENDS = {
    "march": lambda s, c, f: fo.march(s, c, f, 1.0),
    "steady_state": lambda s, c, f: fo.steady_state(s, c, f, 1.0),
    "backbone_curve": lambda s, c, f: fo.joints.backbone_curve(s, c, f, [1.0]),
    "wear": lambda s, c, f: fo.joints.wear(s, c, f, 1.0, coefficient=1e-3, cycles=10),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("question", ANSWERS)
def test_limits_are_answers_that_name_the_motion(question, case):
    system, cycle, reason = CASES[case]
    found = ANSWERS[question](system, cycle, 0.3)
    assert getattr(found, "kind", fo.LimitKind.NO_SAFE_SLIP) is fo.LimitKind.NO_SAFE_SLIP
    assert not getattr(found, "exists", False)
    assert re.search(reason, found.reason), found.reason


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("question", ENDS)
def test_transients_end_with_the_motion(question, case):
    system, cycle, reason = CASES[case]
    with pytest.raises(fo.NoContinuation, match=reason):
        ENDS[question](system, cycle, 0.3)


@pytest.mark.parametrize("case", CASES)
def test_a_study_has_the_motion_in_its_rows(case):
    system, cycle, reason = CASES[case]
    start = fo.starts.Start("own", "none", np.zeros(system.slip_shape))
    (row,) = fo.dissipation_study(system, cycle, 0.3, [1.0], [start], progress=False).to_dict(
        "records"
    )
    assert re.search(reason, row["error"])


@pytest.mark.parametrize("axes", [2, 3])
def test_the_friction_that_holds_a_guided_node_is_found(axes):
    """At the corner its shear is 0.51; where a moment tips a body, no friction is enough."""
    assert fo.required_friction(*guided(axes), 1.0).required == pytest.approx(0.51, rel=1e-3)
    assert fo.required_friction(*CASES["tips"][:2], 1.0).required == np.inf


def test_a_cycle_slides_a_guided_node_off_where_its_shear_exceeds_friction():
    """The mean shear is 0.1 and the cyclic shear 0.2 lam, of at most 0.3: the node rests up to lam
    = 1."""
    for axes in (2, 3):
        node, _ = guided(axes)
        still = [0.0] * (axes - 2)
        node = fo.ContactSystem(
            node.S, node.points, {"m": [0.1, *still, 1.0], "a": [0.2, *still, 0.0]}
        )
        cycle = fo.LoadCycle({"m": 1.0}, [{"a": 1.0}, {"a": -1.0}])
        assert fo.shakedown_limit(node, cycle, 0.3).load_factor == pytest.approx(1.0)
        assert fo.steady_state(node, cycle, 0.3, 0.999).outcome is fo.Outcome.SHAKEDOWN
        reason = (
            "shear force of 0.3, of at most f p = 0.3"
            if axes == 2
            else re.escape("the load at the corner (a = +1) has the shear force 0.3002")
        )
        with pytest.raises(fo.NoContinuation, match=reason):
            fo.steady_state(node, cycle, 0.3, 1.001)


def without_coupling(rng, axes):
    """A contact whose pressures do not change with slip, and its pressures.

    Nothing resists its slides. The pressures are found by trying all sets of open nodes.
    """
    n, t = 4, axes - 1
    slides = np.linalg.qr(rng.normal(size=(t * n, int(rng.integers(1, t + 1)))))[0]
    if rng.random() < 0.5:
        slides = np.kron(np.eye(t), np.ones((n, 1)))[:, : slides.shape[1]] / 2
    roots = rng.normal(size=(t * n, t * n)), rng.normal(size=(n, n))
    off = np.eye(t * n) - slides @ slides.T
    S = np.zeros((axes * n, axes * n))
    S[: t * n, : t * n] = off @ (roots[0] @ roots[0].T + np.eye(t * n)) @ off
    S[t * n :, t * n :] = roots[1] @ roots[1].T + 0.1 * np.eye(n)
    S, gap = (S + S.T) / 2, rng.uniform(0, 0.3, n) * (rng.random(n) < 0.3)
    load = {"m": np.r_[0.5 * rng.normal(size=t * n), rng.normal(size=n) + 1.2]}
    points = (
        np.c_[np.arange(n), rng.normal(size=(n, t))] * np.r_[1.0, np.zeros(t - 1) + (axes > 2), 0.0]
    )
    contact = fo.ContactSystem(S, points, load, gap=gap)
    p0 = load["m"][t * n :] - S[t * n :, t * n :] @ gap
    for choice in product((False, True), repeat=n):
        opened, w = np.array(choice), np.zeros(n)
        w[opened] = np.linalg.solve(contact.C[np.ix_(opened, opened)], -p0[opened])
        if w.min() >= 0 and (p0 + contact.C @ w).min() > -1e-9:
            return (
                contact,
                slides,
                np.where(opened, 0.0, p0 + contact.C @ w),
                load["m"][: t * n].reshape(t, n),
            )
    raise AssertionError


def holds(slides, q0, p, f, strength):
    """Whether admissible shears have the resultants of the load.

    Shears are at most f p, or at most the strength of the surface.
    """
    q = cp.Variable(q0.shape)
    problem = cp.Problem(
        cp.Minimize(0),
        [
            cp.norm(q, axis=0) <= np.minimum(f * p, strength),
            slides.T @ cp.vec(q - q0, order="C") == 0,
        ],
    )
    return problem.solve(solver="CLARABEL") < np.inf


@pytest.mark.parametrize("axes", [2, 3])
def test_random_contacts_slide_off_where_no_shears_balance_the_load_and_only_there(axes):
    rng, seen = np.random.default_rng(axes), []
    for _ in range(few(40, 26)):
        contact, slides, p, q0 = without_coupling(rng, axes)
        f = float(rng.uniform(0.1, 1.0))
        strength = rng.choice([np.inf, 0.3, 0.8], contact.nodes)
        contact = replace(contact, shear_strength=strength)
        first, second = (holds(slides, q0, p, by * f, by * strength) for by in (0.999, 1.001))
        if first is second and contact.bonded["m"][1].sum() > 0:
            seen.append(first)
            assert (
                "as a whole" in fo.onset(contact, fo.LoadCycle({"m": 1.0}, [{"m": 0.1}]), f).reason
            ) is not first
    assert 5 < sum(seen) < len(seen) - 5


MOTIONS = [[0, 1, 2, 3, 4, 5], [0, 1, 2], [0, 2], [2], [0, 1, 5], [0, 1, 2, 5]]


def contact(rng, motions):
    """A random contact with rough faces, and loads that press and shear it.

    Body 1 has some of the six rigid motions.
    """
    n = int(rng.integers(3, 8))
    points = rng.uniform(-1, 1, (n, 3)) * [1, 1, 0.2]
    normals = rng.uniform(-0.4, 0.4, (n, 3)) + [0, 0, 1]
    of_body, frames = rigid(points, normals)
    free = of_body[:, motions]
    root = rng.normal(size=(3 * n, 3 * n))
    off = np.eye(3 * n) - free @ np.linalg.pinv(free)
    press = np.einsum("nak,k->an", frames, [0, 0, 1.0]).ravel()
    bonded = {"P": press, "Q": rng.normal(size=3 * n) + press * rng.uniform(-1, 1)}
    return fo.ContactSystem(
        off @ (root @ root.T + np.eye(3 * n)) @ off, points, bonded, frames=frames
    ), free


def balance(system, motions, friction, load):
    """Status of the cone program for the smallest contact forces in balance with a load.

    The balance is taken in motions of the body.
    """
    q, p = cp.Variable((system.nodes, 2)), cp.Variable(system.nodes, nonneg=True)
    forces = cp.hstack([q[:, 0], q[:, 1], p])
    problem = cp.Problem(
        cp.Minimize(cp.norm(forces)),
        [cp.norm(q, axis=1) <= cp.multiply(friction, p), motions.T @ forces == motions.T @ load],
    )
    problem.solve(solver=cp.CLARABEL)
    return problem.status


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@pytest.mark.parametrize("seed", few(range(30)))
def test_a_load_is_named_where_no_forces_balance_it_and_only_there(seed):
    rng = np.random.default_rng(seed)
    system, free = contact(rng, MOTIONS[seed % len(MOTIONS)])
    found = system.rigid_motions
    assert np.abs(found - free @ (np.linalg.pinv(free) @ found)).max() < 1e-9
    assert np.abs(found.T @ found - np.eye(free.shape[1])).max() < 1e-9
    friction = rng.uniform(0.1, 0.6, system.nodes)
    for shear in rng.uniform(0, 1, 2):
        load = joined(*system.reaction({"P": 1.0, "Q": shear}))
        if balance(system, free, 1.0005 * friction, load) == "infeasible":
            with pytest.raises(fo.NoContinuation, match="the load"):
                check_sliding(system, friction, {"the load": load})
        elif balance(system, free, friction, load) == "optimal":
            check_sliding(system, friction, {"the load": load})


def test_of_more_free_slides_than_nodes_each_is_found():
    """Two nodes without a guide may slide together along x, and each along y.

    They strain only if they move apart along x. P presses each with 1, and Q shears each with 1, so
    that friction of 0.5 holds a load factor of 0.5.
    """
    apart = np.array([-1.0, 1.0, 0.0, 0.0, 0.3, -0.2])
    S = np.outer(apart, apart) + np.diag([0.0, 0.0, 0.0, 0.0, 1.0, 1.0])
    loads = {"P": [0, 0, 0, 0, 1, 1], "Q": [1, 1, 0, 0, 0, 0]}
    bonded = {case: np.array(load, dtype=float) for case, load in loads.items()}
    system = fo.ContactSystem(S, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), bonded)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    with pytest.raises(fo.NoContinuation, match=r"slides as a whole: .* along \(-1, 0, 0\)"):
        fo.steady_state(system, cycle, 0.5, 0.6)


def test_a_load_that_friction_holds_is_asked_anew_with_less_friction():
    """A proof of balance is kept only for its friction and its load."""
    loads = {"P": ([0, 0, 0], [0, 0, 1.0]), "Q": ([-1.0, 0, 0], [0, 0, 0])}
    block = fo.ContactSystem(
        np.zeros((3, 3)),
        np.zeros((1, 3)),
        {case: sum(map(np.array, parts)) for case, parts in loads.items()},
    )
    held = {"the load": joined(*block.reaction({"P": 1.0, "Q": 0.4}))}
    check_sliding(block, np.array([0.5]), held)
    check_sliding(block, np.array([0.5]), held)
    with pytest.raises(fo.NoContinuation, match="slides"):
        check_sliding(block, np.array([0.3]), held)
    with pytest.raises(fo.NoContinuation, match="slides"):
        check_sliding(
            block, np.array([0.5]), {"the load": joined(*block.reaction({"P": 1.0, "Q": 0.6}))}
        )
