"""Locked bolts.

They are compared with bars in series and in parallel, and with the same joints with bolts that are
not locked.
"""

import re

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from helpers.systems import unit_nodes

STEEL = fo.fem.Material(E=3.0, nu=0.3)


def bars(kind=MeshQuad, force=10.0):
    """A bolt, and a tube on a base beside it, whose tops a rigid head holds together.

    All are bars of one section.
    """
    up = "xyz"[kind().dim() - 1]
    levels = [np.array([0.0, 0.4, 1.0])] * (kind().dim() - 1)

    def bar(aside, low, high, **names):
        mesh = kind.init_tensor(levels[0] + aside, *levels[1:], np.linspace(low, high, 5))
        mesh = mesh.with_boundaries(
            {name: lambda x, at=at: x[-1] == at for name, at in names.items()},
            boundaries_only=False,
        )
        return fo.fem.Body(mesh, fo.fem.Material(E=3.0, nu=0.0))

    bodies = {
        "bolt": bar(0.0, 0.0, 2.0, foot=0.0, section=1.0, top=2.0),
        "tube": bar(5.0, 0.0, 2.0, contact=0.0, top=2.0),
        "base": bar(5.0, -1.0, 0.0, contact=0.0, foot=-1.0),
    }
    supports = [
        fo.fem.Support(body, where)
        for body, where in (("bolt", "foot"), ("base", "foot"), ("bolt", "top"), ("tube", "top"))
    ]
    lift = [fo.fem.Displacement(body, "top", **{up: 1.0}) for body in ("bolt", "tube")]
    loads = {"bolt": [fo.fem.BoltPreload("bolt", "section", force, locked=True)], "lift": lift}
    return fo.fem.ContactModel(bodies, supports, loads, [fo.fem.Contact("tube", "base")])


@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_bars_in_series_and_in_parallel(kind):
    """A locked bolt is a bar in parallel to the tube.

    Up to the knee the bolt takes a share of a pull in proportion to its stiffness; beyond the knee
    it takes all of the pull.
    """
    system, F, kb, kc = bars(kind).condense(), 10.0, 3.0 / 2, 3.0 / 3
    opens = F * (1 + kb / kc)
    # the head comes down by F / kc as the bolt is tightened without a pull, and is up again where
    # the joint opens
    cycle = fo.LoadCycle(
        {"bolt": 1.0, "lift": -F / kc},
        [{"lift": -F / kc / 2}, {"lift": F / kc}, {"lift": F / kc + 4.0}],
    )
    assert system.bolts["bolt"] == pytest.approx((F, F / kb))
    tight = fo.joints.tightened(system, cycle, 0.5)
    assert tight.mean["bolt"] * F / kb == pytest.approx(F / kb + F / kc, rel=1e-9)
    assert tight.corners == cycle.corners
    states = fo.march(system, tight, 0.5, 1.0, cycles=1)
    tension = states.tension("bolt")
    pull = -states.displacement("lift")
    assert pull[0] == pytest.approx(0.0, abs=1e-8) and pull.min() < -1 and opens + 1 < pull.max()
    assert np.allclose(tension, np.where(pull < opens, F + kb / (kb + kc) * pull, pull), rtol=1e-9)
    assert np.array_equal(states.gap.min(axis=1) > 1e-9, pull > opens + 1e-9)


def test_the_range_of_the_tension_over_a_cycle():
    system, F, kb, kc = bars().condense(), 10.0, 3.0 / 2, 3.0 / 3
    cycle = fo.LoadCycle({"bolt": 0.5, "lift": -F / kc}, [{"lift": -1.0}, {"lift": 2.0}])
    steady = fo.steady_state(system, fo.joints.tightened(system, cycle, 0.5), 0.5, 1.0)
    table = steady.bolt_table()
    assert table.bolt.tolist() == ["bolt"] and table.force.tolist() == [F]
    assert table.tension_mean[0] == pytest.approx(0.5 * F + 0.5 * kb)
    assert table.tension_amplitude[0] == pytest.approx(1.5 * kb)


RADII, HEAD = np.array([0.0, 0.25, 0.5, 0.6, 1.0, 1.5, 2.2, 3.0]), 1.5


def without(mesh, outside):
    return mesh.remove_elements(np.flatnonzero(outside(*mesh.p[:, mesh.t].mean(axis=1))))


def flange(locked=True, force=20.0, gap=None, stiffness=np.inf, cut=False):
    """Two axisymmetric plates, and a bolt with head and nut.

    The upper plate is pulled at its rim, or it is held there and cut by a free bolt.
    """
    heights = np.array([-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5])
    bolt = without(MeshQuad.init_tensor(RADII[:6], heights), lambda x, y: (x > 0.5) & (abs(y) < 1))
    bolt = bolt.with_boundaries(
        {
            name: lambda x, y=y: (x[1] == y) & (x[0] > 0.6)
            for name, y in (("head", 1.0), ("nut", -1.0))
        }
    )
    bolt = bolt.with_boundaries({"section": lambda x: x[1] == 0.5}, boundaries_only=False)
    plates = {}
    for name, y, (far, near) in (
        ("upper", heights[3:6], ("head", "joint")),
        ("lower", heights[1:4], ("joint", "nut")),
    ):
        mesh = MeshQuad.init_tensor(RADII[3:], y)
        sides = {far: y[-1], near: y[0]}
        sides = {
            side: lambda x, h=h, side=side: (x[1] == h) & ((x[0] < HEAD) | (side == "joint"))
            for side, h in sides.items()
        }
        rim = {"rim": lambda x, h=2 * y[1]: (x[1] == h) & (x[0] > 2.2)}
        plates[name] = mesh.with_boundaries({**sides, **rim}).with_boundaries(
            {"middle": lambda x: x[1] == 0.5}, boundaries_only=False
        )
    bodies = {
        name: fo.fem.Body(mesh, STEEL)
        for name, mesh in {"upper": plates["upper"], "lower": plates["lower"], "bolt": bolt}.items()
    }
    joint = fo.fem.Contact(
        "upper",
        "lower",
        "joint",
        "joint",
        gap=gap,
        tangential_stiffness=stiffness,
        normal_stiffness=2 * stiffness,
    )
    contacts = [
        joint,
        fo.fem.Contact("bolt", "upper", "head", "head"),
        fo.fem.Contact("bolt", "lower", "nut", "nut"),
    ]
    loads = {
        "bolt": [fo.fem.BoltPreload("bolt", "section", force, locked=locked)],
        "pull": [fo.fem.Traction("upper", "rim", y=0.4)],
    }
    loads |= {
        "twist": [fo.fem.Traction("upper", "rim", x=0.3)],
        "lift": [fo.fem.Displacement("lower", "rim", x=0.0, y=0.1)],
        "fit": [fo.fem.Interference("joint", 0.1)],
    }
    supports = [fo.fem.Support("lower", "rim")]
    if cut:
        supports.append(fo.fem.Support("upper", "rim"))
        loads |= {
            "plate": [fo.fem.BoltPreload("upper", "middle", 5.0)],
            "pull": [fo.fem.BodyForce("upper", y=1.0)],
            "twist": [fo.fem.BodyForce("bolt", y=0.3)],
        }
    return fo.fem.ContactModel(bodies, supports, loads, contacts, "axisymmetric")


@pytest.mark.parametrize(
    "more", [{}, {"stiffness": 3.0, "gap": lambda x, y: 0.01 * x**2}, {"cut": True}]
)
def test_a_locked_bolt_is_one_that_is_tightened_anew_in_each_state(more):
    """The faces of its section keep their distance. With the same tension both joints have the same
    forces in the contact, and the same displacements in the bodies."""
    model, again = flange(**more), flange(locked=False, **more)
    locked, free = model.condense(), again.condense()
    rng = np.random.default_rng(3)
    v = 0.1 * rng.normal(size=locked.nodes)
    w = rng.uniform(0.0, 0.1, locked.nodes)
    loads = dict(zip(locked.bonded, rng.normal(size=len(locked.bonded)).tolist(), strict=True))
    tension = locked.tension("bolt", [*loads.values()], v, w).item()
    same = {**loads, "bolt": tension / 20.0}
    u = np.r_[v, w - locked.gap]
    forces = [
        np.concatenate(system.reaction(state_loads)) + system.S @ u
        for system, state_loads in ((locked, loads), (free, same))
    ]
    assert np.abs(forces[0] - forces[1]).max() < 1e-11 * np.abs(forces[0]).max()
    # The distance by which the faces of a bolt that is not locked have come together.
    closer = free.displacements([*same.values()], v, w)[0] / 20.0
    assert closer == pytest.approx(loads["bolt"] * locked.bolts["bolt"][1], rel=1e-10)
    moved = [
        one.displacements([*state_loads.values()], v, w)[1:]
        for one, state_loads in ((locked, loads), (free, same))
    ]
    assert np.allclose(*moved, rtol=1e-10)
    with pytest.warns(fo.ModelWarning, match="is open by"):  # these are no states
        fields, others = (
            one.recover(state_loads, v, w).displacement
            for one, state_loads in ((model, loads), (again, same))
        )
    assert all(
        np.abs(fields[name] - others[name]).max() < 1e-11 * np.abs(others[name]).max()
        for name in others
    )


def test_without_friction_the_shortening_is_that_of_the_bolt_which_is_not_locked():
    """The state of such a bolt depends only on its force. The plates open at the rim, and the mean
    load pulls."""
    locked, free = flange().condense(), flange(locked=False).condense()
    cycle = fo.LoadCycle({"bolt": 0.8, "pull": 1.0}, [{"pull": 0.3}, {"pull": -0.3}])
    tight = fo.joints.tightened(locked, cycle, 0.0)
    one, other = (
        fo.march(system, state_loads, 0.0, 1.0, cycles=1)
        for system, state_loads in ((locked, tight), (free, cycle))
    )
    assert one.gap[0].any()
    assert np.allclose(one.gap[0], other.gap[0], atol=1e-9)
    assert one.tension("bolt")[0] == pytest.approx(16.0, rel=1e-9)
    assert other.displacement("bolt")[0] / 20.0 == pytest.approx(
        tight.mean["bolt"] * locked.bolts["bolt"][1], rel=1e-8
    )
    with pytest.raises(fo.ModelError, match=re.escape("case: 'bolt' is no locked bolt, [] are")):
        other.tension("bolt")
    with pytest.raises(fo.ModelError, match="it has no locked bolt"):
        fo.steady_state(free, cycle, 0.3, 1.0).bolt_table()


def clamped(force=(5.0, 8.0)):
    """Two plane plates that a clamp holds at either end: a bolt with arms for a head and a nut."""
    x = np.array([-1.8, -1.4, -1.2, -1.0, -0.6, -0.2])
    y = np.array([-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0])
    clamp = without(MeshQuad.init_tensor(x[:5], y), lambda x, y: (x > -1.4) & (abs(y) < 0.6))
    bodies = {}
    contacts = [fo.fem.Contact("upper", "lower", "joint", "joint")]
    loads = {}
    for name, (low, high) in {"upper": (0.0, 0.6), "lower": (-0.6, 0.0)}.items():
        mesh = MeshQuad.init_tensor(np.r_[x[2:], -x[:1:-1]], y[(low <= y) & (y <= high)])
        sides = {
            "joint": lambda x: x[1] == 0,
            "middle": lambda x: (abs(x[1]) == 0.6) & (abs(x[0]) < 0.25),
        }
        sides |= {
            name: lambda x, s=s: (abs(x[1]) == 0.6) & (s * x[0] > 0.55)
            for name, s in (("left", -1), ("right", 1))
        }
        bodies[name] = fo.fem.Body(mesh.with_boundaries(sides), STEEL)
    for (name, side), amount in zip((("left", 1), ("right", -1)), force, strict=True):
        mesh = clamp if side > 0 else MeshQuad(clamp.p * [[-1.0], [1.0]], clamp.t[::-1])
        mesh = mesh.with_boundaries(
            {
                arm: lambda x, h=h: (x[1] == h) & (abs(x[0]) < 1.25)
                for arm, h in (("upper", 0.6), ("lower", -0.6))
            }
        )
        mesh = mesh.with_boundaries(
            {"section": lambda x: (x[1] == 0) & (abs(x[0]) > 1.3)}, boundaries_only=False
        )
        bodies[name] = fo.fem.Body(mesh, STEEL)
        contacts += [
            fo.fem.Contact(name, plate, plate, name, f"{name} {plate}")
            for plate in ("upper", "lower")
        ]
        loads[name] = [fo.fem.BoltPreload(name, "section", amount, locked=True)]
    loads |= {
        "pull": [fo.fem.Traction("upper", "middle", y=1.0)],
        "shear": [fo.fem.Traction("upper", "middle", x=1.0)],
    }
    return fo.fem.ContactModel(bodies, [fo.fem.Support("lower", "middle")], loads, contacts)


def tighten(system=None, mean=None, friction=0.3):
    system = clamped().condense() if system is None else system
    return fo.joints.tightened(
        system,
        fo.LoadCycle({"left": 1.0, "right": 1.0} if mean is None else mean, [{"shear": 0.1}]),
        friction,
    )


def in_loads(**loads):
    model = flange()
    return lambda: fo.fem.ContactModel(
        model.bodies, model.supports, {**model.loads, **loads}, model.contacts, model.kinematics
    )


BOLT = fo.fem.BoltPreload("bolt", "section", 20.0, locked=True)
REFUSED = {
    "loads['bolt']: the locked bolt 'bolt', section 'section', with other loads": in_loads(
        bolt=[BOLT, fo.fem.BodyForce("bolt", y=1.0)]
    ),
    "loads['more']: the locked bolt 'bolt', section 'section', in another load case too": in_loads(
        more=[BOLT]
    ),
    "loads['free']: the locked bolt 'bolt', section 'section', in another load case": in_loads(
        free=[fo.fem.BoltPreload("bolt", "section")]
    ),
    "force: 0.0; it must be finite and above 0": lambda: fo.fem.BoltPreload(
        "bolt", "section", 0.0, locked=True
    ),
    "locked: 'yes'; give True or False": lambda: fo.fem.BoltPreload(
        "bolt", "section", locked="yes"
    ),
    "cycle: its mean load has none of the locked bolts ['left', 'right']": lambda: tighten(
        mean={"pull": 1.0}
    ),
    "cycle: mean['left'] = 0; give the share of its force": lambda: tighten(mean={"left": 0.0}),
    "does not close the section of bolt 'left': its other loads pull it to 1.312 before it is tightened to 1": lambda: (
        tighten(mean={"left": 0.2, "right": 2.0, "pull": 3.0, "shear": 0.1}, friction=0.8)
    ),
    "compliance: not known": lambda: tighten(
        clamped().condense().with_bonded({"more": ([0.0] * 20, [1.0] * 20)})
    ),
    "bolts: load case: 'nut'; give 'bolt'": lambda: one_bolt(nut=(1.0, 1.0)),
    "bolts['bolt']: 0 at index 1; give a force and a shortening above 0": lambda: one_bolt(
        bolt=(1.0, 0.0)
    ),
    "bolts['bolt']: shape (1,), expected (2,)": lambda: one_bolt(bolt=(1.0,)),
}


def one_bolt(**bolts):
    return unit_nodes({"bolt": ([0.0], [1.0])}, bolts=bolts)


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_no_locked_bolt_is_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        REFUSED[message]()


def test_an_archive_keeps_the_bolts(tmp_path):
    system = clamped().condense()
    system.save(tmp_path / "joint.npz")
    again = fo.ContactSystem.load(tmp_path / "joint.npz")
    assert again.bolts == system.bolts
    assert len(again.bolts) == 2
    assert again.bonded.keys() == system.bonded.keys()


def test_the_load_case_of_a_locked_bolt_has_no_overlap():
    loads = {"bolt": ([0.0], [2.0]), "pull": ([0.0], [-1.0])}
    bolts, L = {"bolt": (2.0, 0.1)}, [[-0.2, 0.0], [0.0, 0.0]]
    node = fo.ContactSystem.from_blocks(
        [[1.0]], [[0.0]], [[40.0]], [0.0], loads, compliance=L, bolts=bolts
    )
    with pytest.raises(fo.ModelError, match="cases: 'bolt' is a locked bolt"):
        node.with_interference({"bolt": 0.05})
    # 2, and what the fit adds by hand.
    assert node.with_interference({"fit": 0.05}).tension(
        "bolt", [1, 0, 1], [0.0], [0.0]
    ) == pytest.approx(3.0)
