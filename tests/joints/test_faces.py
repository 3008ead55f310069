"""The faces of a joint: the load at which each one slides in full, by hand and by plain cvxpy."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.spatial import flat_body

CYCLE = fo.LoadCycle({"preload": 20.0}, [{"pull": 1.0}, {"pull": -1.0}])


def bolted_lap(share=0.0):
    """Two plates and a bolt, kN: the lap carries the pull, the bolt a share of it while it sticks.

    Slips of lap, head and nut are those of two rigid bodies, but for the stiffness of the bolt.
    """
    slips = np.array([1.0, 1.0, -1.0])
    loads = {
        "preload": ([0.01, 0.01, -0.01], [1.0, 1.0, 1.0]),
        "pull": ([-1.0 + share, share, -share], [0.0, 0.0, 0.0]),
    }
    none = np.zeros((3, 3))
    names = ["lap", "head", "nut"]
    return fo.ContactSystem.from_blocks(
        np.outer(slips, slips), none, none, range(3), loads, contact=names, units="kN, mm"
    )


def test_a_lap_and_its_joint_by_hand():
    """One bolt of 20 kN and friction of .15: the lap holds 3 kN, and lap and head 6 kN."""
    joint = fo.report(bolted_lap(), CYCLE, 0.15, pages=1)
    assert joint.gross_slip.load_factor == pytest.approx(6.0)
    faces = joint.contacts.set_index("contact")
    for name in ("slides_at", "slides_at_steady"):
        # Besides the lap, either the head slides or the nut.
        lap, head, nut = faces[name]
        assert (lap, min(head, nut)) == pytest.approx((3.0, 6.0), rel=1e-5)
    assert faces["carries"]["lap"] == pytest.approx(0.5)
    assert faces["carries"]["head"] + faces["carries"]["nut"] == pytest.approx(0.5)
    assert faces["utilisation"]["lap"] == pytest.approx(
        abs(joint.steady.states().q[:, 0]).max() / 3
    )
    assert "slides at lap" in str(joint) and "lap 50%" in str(joint)


def test_a_bolt_relieves_the_lap():
    faces = fo.report(bolted_lap(share=0.2), CYCLE, 0.15, pages=1).contacts
    lap, head, nut = faces["slides_at"]
    assert (lap, *sorted([head, nut])) == pytest.approx((3.0 / 0.8, 6.0, 3.0 / 0.2), rel=1e-5)


def test_a_face_without_friction_slides_at_no_load():
    """The head has none; the lap and the nut have some."""
    dry = {"lap": 0.15, "head": 0.0, "nut": 0.15}
    faces = fo.report(bolted_lap(share=0.2), CYCLE, dry, pages=1).contacts.set_index("contact")
    for name in ("slides_at", "slides_at_steady"):
        assert faces[name]["head"] == 0.0


@pytest.mark.parametrize(("growth", "factor"), [(-0.5, 2.0 / 1.25), (0.0, 2.0), (0.5, 2.0 / 0.75)])
def test_the_normal_force_changes_with_the_load(growth, factor):
    """q = load factor, p = 4 + growth * load factor: it slides at q = p / 2."""
    loads = {"N": ([0.0], [1.0]), "F": ([1.0], [growth])}
    node = fo.ContactSystem.from_blocks([[3.0]], [[0.0]], [[3.0]], [0.0], loads)
    cycle = fo.LoadCycle({"N": 4.0}, [{"F": 1.0}, {"F": 0.0}])
    faces = fo.report(node, cycle, 0.5, pages=1).contacts
    for name in ("slides_at", "slides_at_steady"):
        assert faces[name].item() == pytest.approx(factor, rel=1e-5)


def test_a_face_that_the_loads_do_not_shear_never_slides():
    node = fo.ContactSystem.from_blocks(
        [[3.0]], [[0.0]], [[3.0]], [0.0], {"N": ([0.0], [1.0]), "F": ([0.0], [0.5])}
    )
    cycle = fo.LoadCycle({"N": 4.0}, [{"F": 1.0}, {"F": 0.0}])
    assert fo.report(node, cycle, 0.5, pages=1).contacts["slides_at"].item() == np.inf


def test_a_strain_beside_a_face_sends_no_force_through_it():
    """The shear forces balance each other but for rounding."""
    punch = fo.scenes.PunchOnHalfPlane(elements=16, growth=1.3).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    face = fo.report(punch, cycle, 0.4, pages=1).contacts.loc[0]
    assert (face["slides_at"], face["utilisation"]) == (np.inf, 0.0)


@pytest.mark.parametrize("seed", few(range(6)))
def test_force_and_moment_of_a_flat_face_by_plain_cvxpy(seed):
    """The pressure of the mean load is the bonded one, because slip changes no pressure."""
    rng = np.random.default_rng(seed)
    body = flat_body(rng.normal(size=(6, 2)))
    corners = [{name: float(rng.normal()) for name in ("push", "torque")} for _ in range(3)]
    cycle = fo.LoadCycle({"P": 1.0}, [{k: 0.01 * v for k, v in c.items()} for c in corners])
    x, y = body.points[:, 0], body.points[:, 1]
    p = body.reaction({"P": 1.0})[1]
    factors = []
    for corner in cycle.corners:
        load = body.reaction(corner)[0]
        q, factor = cp.Variable((6, 2)), cp.Variable()
        balance = [
            cp.sum(q, axis=0) == factor * load.sum(axis=0),
            x @ q[:, 1] - y @ q[:, 0] == factor * (x @ load[:, 1] - y @ load[:, 0]),
        ]
        problem = cp.Problem(cp.Maximize(factor), [*balance, cp.norm(q, axis=1) <= 0.4 * p])
        factors.append(problem.solve(solver="CLARABEL"))
    faces = fo.report(body, cycle, 0.4, pages=1).contacts
    assert faces["slides_at"].item() <= min(factors) * (1 + 1e-5)
    gross = fo.gross_slip(body, cycle, 0.4).load_factor
    assert faces["slides_at"].item() == pytest.approx(min(*factors, gross), rel=1e-5)


def test_a_joint_that_holds_by_its_heads_fails_by_its_lap():
    """The lap holds .1 x 16 kN at worst, lap and head twice as much, against a limit of 2."""
    joint = fo.report(
        bolted_lap(),
        CYCLE,
        (0.1, 0.15, 0.2),
        preload={"preload": (16.0, 20.0)},
        limits={"gross slip": 2.0, "face slip": 2.0},
        load_factors=[1.0],
        pages=2,
    )
    verdicts = joint.verdicts.set_index("quantity")
    assert verdicts["passed"].to_dict() == {"gross slip": True, "face slip": False}
    assert verdicts["value"]["gross slip"] == pytest.approx(3.2)
    assert verdicts["value"]["face slip"] == pytest.approx(1.6, rel=1e-5)
    assert verdicts["at"]["face slip"] == "least friction 0.1, preload 16"
    nominal = joint.safety.set_index("against")["nominal"]
    assert nominal["face slip"] == pytest.approx(3.0, rel=1e-5)
    first = fo.report(bolted_lap(), CYCLE, 0.15, limits={"face slip": 3.1}, pages=1)
    assert not first.verdicts["passed"].item()
