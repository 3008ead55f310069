"""Contacts of any number, direction and shape.

They are compared with closed forms, equilibrium, and the same contacts turned or with exchanged
bodies.
"""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.meshes import (
    blocks,
    extruded,
    ring,
    rotation,
    turned,
    two_blocks,
    uniform_loads,
    wedge,
)

FLAT, SOLID = (
    list(product(kinds, repeat=2)) for kinds in ((MeshQuad, MeshTri), (MeshTet, MeshHex))
)


@pytest.mark.parametrize(
    ("kinds", "upper", "lower", "seed", "element", "nu"),
    [
        *(
            (kinds, (5, 6), *rest)
            for kinds in SOLID
            for rest in (((4, 3), 0, None, 0.3), ((7, 8), 1, None, 0.3), ((5, 6), None, None, 0.3))
        ),
        *((kinds, (5, 6), (4, 3), 2, "quadratic", 0.3) for kinds in SOLID),
        *(
            (kinds, *cells, 3, None, 0.3)
            for kinds in FLAT
            for cells in (((7,), (7,)), ((8,), (10,)), ((3,), (7,)), ((7,), (3,)))
        ),
        *(
            (kinds, (7,), cells, 4, element, 0.45)
            for kinds in FLAT
            for cells in ((7,), (5,))
            for element in ("mean_dilatation", "quadratic")
        ),
        *(
            (kinds, (7,), (7,), None, element, 0.4999)
            for kinds in FLAT
            for element in ("linear", "mean_dilatation")
        ),
    ],
)
def test_any_uniform_stress_passes_between_any_meshes(kinds, upper, lower, seed, element, nu):
    """Tractions, displacements and stresses are exact, also where nodes match and facets do not."""
    d, rng = len(upper) + 1, np.random.default_rng(seed or 0)
    R = np.linalg.qr(rng.normal(size=(d, d)))[0]
    shift = rng.normal(size=d)
    R[:, 0] *= np.linalg.det(R)
    stress = np.zeros((3, 3))
    stress[:d, :d] = (
        R
        @ (np.array([[0.3, 0.2, 0.4], [0.2, -0.5, 0.1], [0.4, 0.1, -1.0]])[3 - d :, 3 - d :])
        @ R.T
    )
    stress[2, 2] += nu * np.trace(stress) * (d == 2)  # plane strain
    strain = (1 + nu) * stress - nu * np.trace(stress) * np.eye(3)
    spin = rng.normal(size=(d, d))
    gradient = strain[:d, :d] + 0.3 * (spin - spin.T)
    bodies = {
        name: fo.fem.Body(turned(mesh, R).translated(shift), fo.fem.Material(1.0, nu), part)
        for (name, mesh), part in zip(
            two_blocks(kinds, upper, lower, seed).items(), (element, None), strict=True
        )
    }
    low, traction = f"{'xyz'[d - 1]}-", stress[:d, :d] @ R
    load = [
        fo.fem.Displacement(
            "lower",
            low,
            *(
                lambda *x, row=row: sum(g * (a - b) for g, a, b in zip(row, x, shift, strict=True))
                for row in gradient
            ),
        )
    ]
    for name, side in (
        (name, side)
        for name, body in bodies.items()
        for side in body.mesh.boundaries
        if side not in ("contact", low)
    ):
        load.append(
            fo.fem.Traction(name, side, *(float(f"{side[1]}1") * traction[:, "xyz".index(side[0])]))
        )
    model = fo.fem.ContactModel(
        bodies, [fo.fem.Support("lower", low)], {"load": load}, [fo.fem.Contact("upper", "lower")]
    )
    system = model.condense()
    q, p = system.bonded["load"]
    force = (
        np.einsum("nt,nta->na", q.reshape(-1, d - 1), system.frames[:, :-1])
        + p[:, None] * system.normals
    )
    rounding = max(1e-12, 1e-15 / (1 - 2 * nu))  # forces have that of the bulk modulus
    assert np.allclose(force, -system.width[:, None] * traction[:, -1], rtol=0, atol=rounding)
    assert np.allclose(system.normals, R[:, -1])
    assert system.width.sum() == pytest.approx(2.0 ** (d - 1), abs=1e-12)
    assert system.nodes == np.prod(np.array(upper) + 1)
    assert np.linalg.eigvalsh(system.S)[0] > -1e-13 * np.abs(system.S).max()
    assert np.array_equal(system.S, system.S.T)
    fields = model.recover({"load": 1.0}, np.zeros(system.slip_shape))
    rounding = max(1e-12, 1e-13 / (1 - 2 * nu))
    rows, columns = np.array([[0, 1, 0, 2, 0, 1], [0, 1, 1, 2, 2, 2]])[:, : 4 if d == 2 else 6]
    for name, body in bodies.items():
        assert np.allclose(
            fields.displacement[name],
            gradient @ (body.mesh.p - shift[:, None]),
            rtol=0,
            atol=rounding,
        )
        for found, tensor in ((fields.stress[name], stress), (fields.strain[name], strain)):
            assert np.allclose(found, tensor[rows, columns][:, None], rtol=0, atol=rounding)
    for side in (1, 2):
        for found, tensor in zip(
            fields.at_contact(side), (stress[:d, :d], strain[:d, :d]), strict=True
        ):
            along = np.einsum(
                "nta,ab,nsb->nts", system.frames[:, :-1], tensor, system.frames[:, :-1]
            )
            assert np.allclose(found.reshape(along.shape), along, rtol=0, atol=rounding)


def limits(system):
    cycle = fo.LoadCycle({"P": 1.0, "fit": 20.0}, [{"Q": -1.0}, {"Q": 1.0}])
    return fo.shakedown_limit(system, cycle, 0.3).load_factor


def reactions(system):
    return np.concatenate([np.concatenate(system.bonded[name]) for name in sorted(system.bonded)])


@cache
def upright(jaws):
    """The wedge as it stands, and its limit."""
    return (system := wedge(jaws=jaws).condense()), limits(system)


@pytest.mark.parametrize("angle", [0.3, np.pi / 4, np.pi / 2, 2.0, np.pi, 4.0])
@pytest.mark.parametrize("jaws", [(4, 6), (4, 7)])
def test_a_scene_turned_by_any_angle_has_the_same_answers(angle, jaws):
    """It has two inclined contacts of three bodies, with nodes that match or not."""
    (straight, limit), turned = upright(jaws), wedge(angle, jaws=jaws).condense()
    assert np.allclose(turned.S, straight.S, rtol=0, atol=1e-11 * np.abs(straight.S).max())
    assert np.allclose(reactions(turned), reactions(straight), rtol=0, atol=1e-11)
    assert np.allclose(turned.x - turned.x[0], straight.x - straight.x[0], atol=1e-12)
    assert np.allclose(turned.width, straight.width)
    assert np.allclose(turned.points, straight.points @ rotation(angle).T)
    assert np.allclose(turned.normals, straight.normals @ rotation(angle).T)
    assert 0.1 < limit < 10.0
    assert limits(turned) == pytest.approx(limit, rel=1e-10)


def resultant(system, case):
    """Force and moment about the origin of body 2 on body 1."""
    q, p = system.bonded[case]
    t = np.column_stack([system.normals[:, 1], -system.normals[:, 0]])
    force = q[:, None] * t + p[:, None] * system.normals
    x, y = system.points.T
    return np.r_[force.sum(axis=0), (x * force[:, 1] - y * force[:, 0]).sum()]


def test_arc_length_runs_on_from_contact_to_contact():
    system = wedge().condense()
    steps = np.diff(system.x)
    edge = 1 / np.sin(np.pi / 3) / 6
    # A contact begins one spacing after the one before.
    assert np.allclose(steps, edge)
    assert system.nodes == 14
    assert np.allclose(system.width.reshape(2, 7), edge * np.r_[0.5, np.ones(5), 0.5])


def fitted(
    pin, plate, delta=0.01, bore=0.3, rim=4.0, hole=1.0, exchanged=False, start=0.0, gap=None
):
    """A hollow pin shrunk into a plate, or in a wider hole."""
    faces = (
        ("plate", "pin", "hole", "surface") if exchanged else ("pin", "plate", "surface", "hole")
    )
    return fo.fem.ContactModel(
        bodies={
            "pin": fo.fem.Body(ring(np.linspace(bore, 1.0, 12), pin, "bore", "surface", start)),
            "plate": fo.fem.Body(ring(np.geomspace(hole, rim, 20), plate, "hole", "rim")),
        },
        contacts=[fo.fem.Contact(*faces, name="fit", gap=gap)],
        supports=[
            fo.fem.Support("plate", (rim, 0.0), "xy"),
            fo.fem.Support("plate", (-rim, 0.0), "y"),
        ],
        loads={
            "fit": [fo.fem.Interference("fit", delta)],
            "pull": [fo.fem.Traction("pin", "bore", x=1.0)],
        },
    )


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize(
    ("pin", "plate", "start", "spread"),
    [(60, 60, 0.0, 1e-12), (60, 72, 0.0, 5e-3), (72, 60, 0.04, 5e-3), (60, 60, 0.05, 5e-3)],
)
def test_a_pin_shrunk_into_a_plate_has_the_pressure_of_lame(pin, plate, start, spread, exchanged):
    """p = delta / (a (C_1 + C_2)), C = (r_1^2 + r_2^2) / (r_2^2 - r_1^2) / E' -+ nu'/E' of the
    hollow pin and of the plate, in plane strain."""
    a, bore, rim, delta = 1.0, 0.3, 4.0, 0.01
    modulus, ratio = 1 / (1 - 0.3**2), 0.3 / 0.7
    compliance = (
        (a**2 + bore**2) / (a**2 - bore**2) - ratio + (rim**2 + a**2) / (rim**2 - a**2) + ratio
    ) / modulus
    system = fitted(pin, plate, exchanged=exchanged, start=start).condense()
    q, p = system.bonded["fit"]
    pressure = p / system.width
    assert pressure.mean() == pytest.approx(delta / a / compliance, rel=3e-3)
    assert np.ptp(pressure) < spread * pressure.mean() and np.abs(q).max() < spread * p.max()
    assert np.allclose(np.sum(system.normals * system.points, axis=1), 1.0 if exchanged else -1.0)
    force = 2 * pin * bore * np.sin(np.pi / pin) * (-1.0 if exchanged else 1.0)
    assert np.allclose(resultant(system, "pull"), [-force, 0.0, 0.0], atol=2e-3)


@pytest.mark.parametrize("exchanged", [False, True])
def test_a_fit_slides_at_its_torque_unless_its_facets_wedge_the_part_that_turns(exchanged):
    """The bound is friction times the sum of pressures. With the held plate as body 1 it holds only
    for slips of a size that assembly can leave."""
    model = fitted(16, 16, exchanged=exchanged, start=0.02)
    torque = fo.fem.Traction("pin", "bore", x=lambda x, y: -y, y=lambda x, y: x)
    model = replace(
        model, loads={**model.loads, "torque": [torque]}, supports=[fo.fem.Support("plate", "rim")]
    )
    system = model.condense()
    cycle = fo.LoadCycle({"fit": 1.0}, [{"torque": 1.0}, {"torque": -1.0}])
    gross = 0.2 * system.bonded["fit"][1].sum() / abs(system.bonded["torque"][0].sum())
    free, bound = (
        fo.shakedown_limit(system, cycle, 0.2, **options).load_factor
        for options in ({}, {"slip_bound": 0.01})
    )
    assert bound == pytest.approx(gross, rel=5e-3)
    assert free == (np.inf if exchanged else pytest.approx(gross, rel=1e-3))


@pytest.mark.parametrize("kind", [MeshQuad, MeshTri, MeshHex, MeshTet])
def test_a_fit_turns_without_wedging_whatever_its_elements(kind):
    """Elements have uneven sizes, with diagonals or without. The normals go through the axis, and
    the fit slides at friction times the sum of pressures."""
    whole = ring([0.3, 0.6, 1.0, 1.6, 2.4], 24, "bore", "rim")
    angle = np.arctan2(*whole.p[::-1])
    radius, angle = np.hypot(*whole.p), angle + 0.3 * np.sin(angle)
    whole = MeshQuad(radius * np.array([np.cos(angle), np.sin(angle)]), whole.t)
    mesh = {
        MeshQuad: whole,
        MeshTri: whole.to_meshtri(),
        MeshHex: extruded(whole),
        MeshTet: extruded(whole).to_meshtet(),
    }[kind]
    mesh = mesh.with_boundaries(
        {"bore": lambda x: np.hypot(*x[:2]) < 0.31, "rim": lambda x: np.hypot(*x[:2]) > 2.3}
    )
    mesh = mesh.with_subdomains(
        {"pin": lambda x: np.hypot(*x[:2]) < 0.99, "plate": lambda x: np.hypot(*x[:2]) > 0.99}
    )
    model = fo.fem.ContactModel(
        fo.fem.split_bodies(mesh, dict.fromkeys(("pin", "plate"), fo.fem.Material(nu=0.0))),
        contacts=[fo.fem.Contact("pin", "plate", "plate", "pin", name="fit")],
        supports=[fo.fem.Support("plate", "rim")],
        loads={
            "fit": [fo.fem.Interference("fit", 0.01)],
            "torque": [fo.fem.Traction("pin", "bore", x=lambda x, y, *_: -y, y=lambda x, *_: x)],
        },
    )
    system = model.condense()
    assert np.allclose(system.normals[:, :2], -system.points[:, :2])
    assert np.allclose(system.normals[:, 2:], 0.0)
    limit = fo.shakedown_limit(system, fo.LoadCycle({"fit": 1.0}, [{"torque": 1.0}]), 0.1)
    x, y, *_ = np.array(
        [
            system.points.T,
            np.einsum("nr,nra->an", np.column_stack(system.bonded["torque"]), system.frames),
        ]
    ).swapaxes(0, 1)
    torque = abs(x[0] @ y[1] - y[0] @ x[1])
    assert limit.load_factor == pytest.approx(
        0.1 * system.bonded["fit"][1].sum() / torque, rel=5e-3
    )
    assert limit.largest_slip < 0.01


def test_interference_is_a_negative_gap():
    """Its bonded reactions are (B^T d, C d), and they add to the tractions of the same load case."""
    plain = wedge().condense()
    d = np.repeat([0.01, 0.02], 7)
    assert np.allclose(np.r_[plain.bonded["fit"]], plain.S @ np.r_[np.zeros(14), d], atol=1e-15)
    both = wedge(
        loads={
            "all": [
                *wedge().loads["P"],
                *wedge().loads["fit"],
                fo.fem.Interference("left flank", 0.005),
            ]
        }
    ).condense()
    d[:7] += 0.005
    assert np.allclose(
        np.r_[both.bonded["all"]],
        np.r_[plain.bonded["P"]] + plain.S @ np.r_[np.zeros(14), d],
        atol=1e-14,
    )


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_gap_of_a_rounded_punch_is_measured(angle):
    """The punch is a parabola of height x^2 / 10 above a flat block. Without a measurement the gap
    is zero."""
    x = np.linspace(-1.0, 1.0, 21)
    raw = blocks(x_punch=x, x_block=np.linspace(-1.0, 1.0, 17))
    mesh = raw["punch"].mesh
    bent = MeshQuad(
        rotation(angle) @ (mesh.p + [[0.0], [0.1]] * mesh.p[0] ** 2), mesh.t
    ).with_boundaries(mesh.boundaries)
    flat = blocks(x_block=np.linspace(-1.0, 1.0, 17), angle=angle)["block"]
    parts = {
        "bodies": {"punch": fo.fem.Body(bent), "block": flat},
        "supports": [fo.fem.Support("block", "bottom")],
        "loads": uniform_loads(angle),
    }
    system = fo.fem.ContactModel(
        **parts, contacts=[fo.fem.Contact("punch", "block", gap="measured")]
    ).condense()
    assert np.allclose(system.gap, 0.1 * x**2, rtol=0.03, atol=1e-4)
    with pytest.raises(fo.ModelError, match="the faces do not touch, they are "):
        fo.fem.ContactModel(**parts)
