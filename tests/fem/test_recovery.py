"""The fields in the bodies.

They are compared with the state of the contact, scikit-fem's own elasticity, and files.
"""

import numpy as np
import pytest
from skfem.models.elasticity import linear_elasticity

import frictopt as fo
from helpers.meshes import blocks, hung, uniform_loads, vector_field
from helpers.refused import refused

MODELS = {
    "punch": fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).model(),
    "dovetail": fo.scenes.Dovetail(elements=6, growth=1.6).model(),
    "pin": fo.scenes.PinInPlate(elements=24, growth=1.6).model(),
    "press fit": fo.scenes.PressFit(elements=8, growth=1.6).model(),
}


def states(name):
    """A model, its system, loads of all cases, and a random slip and gap."""
    model, rng = MODELS[name], np.random.default_rng(1)
    system = model.condense()
    loads = {case: float(rng.normal()) for case in model.loads}
    force = np.abs(np.concatenate(system.reaction(loads))).max()
    return (
        model,
        system,
        loads,
        *(force / system.stiffness_scale * rng.normal(size=(2, system.nodes))),
    )


@pytest.mark.parametrize("name", MODELS)
def test_recovered_reactions_are_those_of_the_state(name):
    model, system, loads, v, w = states(name)
    w = system.gap + np.abs(w)
    fields = model.recover(loads, v, w)
    q, p = system.reaction(loads)
    q = q + system.A @ v + system.B.T @ (w - system.gap)
    p = p + system.B @ v + system.C @ (w - system.gap)
    assert np.abs([fields.q - q, fields.p - p]).max() < 1e-9 * np.abs([q, p]).max()


def test_the_field_of_a_rounded_punch_is_that_of_its_states():
    """It includes the initial gap of the model. A warning names a system with a gap that the model
    does not have."""
    scene = fo.scenes.RoundedPunch(
        radius=50, punch=fo.scenes.PunchOnHalfPlane(elements=20, grading=1.0, growth=1.5)
    )
    system = scene.condense()
    model = scene.model()
    loads = {"P": 0.004, "Q": -0.0002}
    path = fo.march(
        system, fo.LoadCycle({"P": 0.004}, [{"Q": 0.0002}, {"Q": -0.0002}]), 0.5, 1.0, cycles=1
    )
    v, w, p = path.slip[-1], path.gap[-1], path.p[-1]
    fields = model.recover(loads, v, w)
    assert (w > 0).any() and np.abs([fields.p - p, fields.q - path.q[-1]]).max() < 1e-9 * p.max()
    assert np.array_equal(model.condense().gap, system.gap)
    flat = scene.punch.condense()
    carried = np.hypot(
        *np.add(flat.reaction(loads), (flat.A @ v + flat.B.T @ w, flat.B @ v + flat.C @ w))
    )
    most = int(np.argmax(np.where(w > 0, carried, 0.0)))
    with pytest.warns(
        fo.ModelWarning,
        match=f"recover: node {most} is open by {w[most]:g} and carries a force of {carried[most]:.3g}: .*must be part of the model",
    ):
        scene.punch.model().recover(loads, v, w)
    with pytest.warns(fo.ModelWarning, match="give all loads of the state"):
        model.recover({"P": 0.004}, v, w)


def test_without_loads_nothing_moves_where_the_bodies_are_apart():
    """Without an argument the gap is the initial gap, of a function and of a mesh."""
    punch, block = (body.mesh for body in blocks().values())
    bodies = {"punch": fo.fem.Body(punch.translated([0.0, 0.25])), "block": fo.fem.Body(block)}
    for model in (
        fo.scenes.RoundedPunch(
            radius=50, punch=fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0)
        ).model(),
        fo.fem.ContactModel(
            bodies, hung(), uniform_loads(), [fo.fem.Contact("punch", "block", gap="measured")]
        ),
    ):
        n = model.condense().nodes
        fields = model.recover({}, np.zeros(n))
        assert model.condense().gap.any() and all(not u.any() for u in fields.displacement.values())


@pytest.mark.parametrize("name", ["punch", "dovetail"])
def test_the_recovered_field_is_in_equilibrium(name):
    """The recovered field is in equilibrium, by scikit-fem's own stiffness.

    No force is left at nodes without load, support or contact, and all forces on a body balance.
    """
    model, system, loads, v, w = states(name)
    fields = model.recover(loads, v, system.gap + np.abs(w))
    for body, part in model.bodies.items():
        basis, u = vector_field(part.mesh, fields.displacement[body])
        forces = linear_elasticity(*part.material.lame).assemble(basis) @ u
        nodes = np.unique(
            np.concatenate(
                [
                    part.mesh.facets[:, part.mesh.boundaries[boundary]].ravel()
                    for boundary in [*part.mesh.boundaries]
                ]
            )
        )
        free = np.setdiff1d(np.arange(part.mesh.p.shape[1]), nodes)
        assert np.abs(forces[basis.nodal_dofs[:, free]]).max() < 1e-10 * np.abs(forces).max()
    first = model.contacts[0].body_1
    frames = np.stack(
        [np.column_stack([system.normals[:, 1], -system.normals[:, 0]]), system.normals]
    )
    across = (fields.q[:, None] * frames[0] + fields.p[:, None] * frames[1]).sum(axis=0)
    applied = np.zeros(2)
    for case, amplitude in loads.items():
        for part in model.loads[case]:
            if part.body == first:
                applied += amplitude * part._forces(model.bodies[first], "plane_strain").sum(axis=1)
    assert np.allclose(across + applied, 0.0, atol=1e-9 * np.abs(fields.p).max())


def test_stress_along_the_interface():
    """The stress along the interface is the mean stress of each body in the middle.

    A plate is pulled along its contact and is stuck to a soft plate.
    """
    scene = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6, punch_material=fo.fem.Material(1e-6))
    fields = scene.model().recover({"sigma": 2.0}, np.zeros(9))
    stress, strain = fields.at_contact(2)
    assert np.allclose(stress[2:-2], 2.0, rtol=0.02)
    assert np.allclose(strain[2:-2], 2.0 * (1 - 0.3**2), rtol=0.02)
    soft, same = fields.at_contact(1)
    assert np.abs(soft).max() < 1e-4 and np.allclose(same[2:-2], strain[2:-2], rtol=0.02)


def test_stresses_by_name():
    """Stresses by name are the rows of `BodyFields.stress`.

    Von Mises' stress follows from the deviator of the whole tensor.
    """
    model = fo.scenes.SquarePunch(elements=2, growth=2.0).model()
    fields = model.recover({"P": 1.0}, np.zeros((9, 2)))
    rows = dict(zip(("xx", "yy", "xy", "zz", "xz", "yz"), fields.stress["punch"], strict=True))
    assert all(np.array_equal(fields.stress_of("punch", name), row) for name, row in rows.items())
    tensors = np.moveaxis([[rows["".join(sorted(a + b))] for a in "xyz"] for b in "xyz"], -1, 0)
    deviators = tensors - np.trace(tensors, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    mises = np.sqrt(1.5 * (deviators**2).sum(axis=(1, 2)))
    assert fields.stress_of("punch", "von Mises") == pytest.approx(mises, rel=1e-12)
    most = max(("punch", "block"), key=lambda name: fields.stress_of(name, "von Mises").max())
    values = fields.stress_of(most, "von Mises")
    at = ", ".join(f"{x:g}" for x in fields.bodies[most].mesh.p[:, values.argmax()])
    assert f"largest_von_mises={values.max():.6g} in {most} at ({at})" in repr(fields)
    z = model.bodies["punch"].mesh.p[2]
    # The pressure there.
    assert fields.stress_of("punch", "zz")[z > 0.99 * z.max()] == pytest.approx(-1.0, rel=0.05)


def test_mean_dilatation_has_its_own_stress():
    """In a punch of rubber div u times Lame's first constant would oscillate by hundreds of times
    the pressure."""
    rubber = fo.fem.Material(1.0, 0.49999)
    scene = fo.scenes.PunchOnHalfPlane(
        elements=8,
        growth=1.6,
        punch_material=rubber,
        block_material=rubber,
        element="mean_dilatation",
    )
    fields = scene.model().recover({"P": 1.0}, np.zeros(9))
    top = scene.model().bodies["punch"].mesh.p[1] > 1.5
    assert np.allclose(fields.stress["punch"][1, top], -1.0, atol=0.2)
    assert np.abs(fields.stress["block"]).max() < 5.0


@pytest.mark.parametrize(
    ("name", "mean", "corner"),
    [("punch", {"P": 1.0}, {"sigma": 2.0}), ("square", {"P": 1.0}, {"Qx": 0.3})],
)
def test_a_steady_state_is_recovered_at_its_last_corner(name, mean, corner):
    model = MODELS[name] if name in MODELS else fo.scenes.SquarePunch(elements=2).model()
    cycle = fo.LoadCycle(mean, [{case: -value for case, value in corner.items()}, corner])
    steady = fo.steady_state(model.condense(), cycle, 0.4, 1.1)
    fields, states = model.recover(steady), steady.states()
    force = np.abs(states.p[-1]).max()
    assert steady.outcome.name == "CYCLIC_SLIP"
    assert np.abs(fields.q - states.q[-1]).max() < 1e-8 * force
    assert np.abs(fields.p - states.p[-1]).max() < 1e-8 * force
    with pytest.raises(fo.ModelError, match="slip, gap: a steady state includes them"):
        model.recover(steady, steady.slip)


@refused(
    (
        lambda model, fields: model.recover({"P": 1.0}),
        "slip: None; give the slip .*or a steady state",
    ),
    (lambda model, fields: model.recover({"none": 1.0}, np.zeros(9)), "load case 'none': unknown"),
    (lambda model, fields: fields.at_contact(3), "side: 3"),
    (lambda model, fields: fields.stress_of("none", "xx"), "body: 'none'; give"),
    (
        lambda model, fields: fields.stress_of("punch", "xz"),
        "component: 'xz'; give 'xx' or 'yy' or 'xy' or 'zz' or 'von Mises'",
    ),
)
def test_bad_calls_are_refused(call):
    model = MODELS["punch"]
    call(model, model.recover({"P": 1.0}, np.zeros(9)))
