"""Stresses at points as linear functions of loads and motions, against recovered fields."""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.refused import refused

PUNCH = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0)
MODELS = {
    "plane": PUNCH.model,
    "with springs": lambda: replace(
        PUNCH.model(),
        contacts=[fo.fem.Contact("punch", "block", tangential_stiffness=5.0, normal_stiffness=9.0)],
    ),
    "axisymmetric": fo.scenes.PressFit(elements=4, growth=2.0).model,
    "space": fo.scenes.SquarePunch(elements=2, growth=3.0).model,
}


@pytest.mark.filterwarnings("ignore:recover")
@pytest.mark.parametrize("side", [1, 2])
@pytest.mark.parametrize("name", MODELS)
def test_the_map_of_the_face_has_the_recovered_tensors(name, side):
    model = MODELS[name]()
    stresses = model.stress_map(depth=0.0, side=side)
    system = stresses.system
    rng = np.random.default_rng(0)
    loads = dict(zip(system.bonded, rng.normal(size=len(system.bonded)), strict=True))
    slip = 0.1 * rng.normal(size=system.slip_shape)
    gap = system.gap + rng.random(system.nodes)
    recovered = model.recover(loads, slip, gap).tensors_at_contact(side)
    for ours, theirs in zip(stresses.tensors(loads, slip, gap), recovered, strict=True):
        assert ours == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


def test_points_at_a_depth_have_the_nodal_stresses_of_their_body():
    model = PUNCH.model()
    mesh = model.bodies["block"].mesh
    fields = model.recover({"P": 1.0}, slip=np.zeros(5))
    node = int(np.abs(mesh.p - np.array([[0.0], [-0.5]])).sum(axis=0).argmin())
    stresses = model.stress_map(points=[mesh.p[:, node]], body="block")
    stress, _ = stresses.tensors({"P": 1.0}, np.zeros(5))
    assert stress[0, 1, 1] == pytest.approx(fields.stress_of("block", "yy")[node], rel=1e-9)
    below = model.stress_map(depth=0.5, side=2).points
    assert below[:, 1] == pytest.approx(np.full(5, -0.5)) and not below[2, 0]


@refused(
    (lambda model: model.stress_map(), "points, body, depth: give points and"),
    (lambda model: model.stress_map(points=[[0.0, 0.0]]), "points, body, depth: give points and"),
    (lambda model: model.stress_map(depth=100.0), "points, depth: .* outside of body 'punch'"),
    (lambda model: model.stress_map(points=[[0.0, 0.0]], body="floor"), "body: .*'floor'"),
    (lambda model: model.stress_map(depth=0.1, side=3), "side: 3"),
    (
        lambda model: model.stress_map(depth=0.1).tensors({"none": 1.0}, np.zeros(5)),
        "loads: 'none' is unknown",
    ),
)
def test_bad_maps_are_refused(call):
    call(PUNCH.model())
