"""The scenes: closed forms, invariances, and every scene through the whole package."""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.meshes import matrices_of
from helpers.refused import refused


def pull(case="pull"):
    return fo.LoadCycle({"pull": 1.0}, [{case: 1.0}, {case: -1.0}])


def fitted(system, corners):
    """A cycle about the fit of mean pressure one."""
    return fo.LoadCycle({"fit": 1 / (system.bonded["fit"][1] / system.width).mean()}, corners)


@pytest.mark.parametrize("angle", [35, 45, 60])
@pytest.mark.parametrize("case", ["pull", "sway"])
def test_a_dovetail_locks_at_the_cotangent_of_its_angle(angle, case):
    """With q = -cot(angle) p the reactions of each flank have no vertical part: the blade is held
    by any pressure that it is wedged in with."""
    system = fo.scenes.Dovetail(angle=angle, elements=8, growth=1.8).condense()
    cot = 1 / np.tan(np.radians(angle))
    assert 0 < fo.shakedown_limit(system, pull(case), 0.99 * cot).load_factor < 1
    assert fo.shakedown_limit(system, pull(case), 1.001 * cot).load_factor == np.inf


def test_the_flanks_hold_the_pull():
    system = fo.scenes.Dovetail(angle=50, elements=6, growth=1.8, neck_half_width=0.7).condense()
    for case, expected in (("pull", (0.0, -1.4)), ("sway", (-1.4, 0.0))):
        q, p = system.bonded[case]
        tangents = np.column_stack([system.normals[:, 1], -system.normals[:, 0]])
        assert np.allclose(q @ tangents + p @ system.normals, expected, atol=1e-12)
    right = system.contact == "right"
    assert np.allclose(system.normals[right], [-np.sin(np.radians(50)), -np.cos(np.radians(50))])
    assert np.allclose(system.width[right].sum(), 1.0) and np.allclose(
        system.width[~right].sum(), 1.0
    )


def test_rounded_ends_open_like_a_parabola():
    scene = fo.scenes.Dovetail(
        elements=10, growth=1.8, grading=1.0, edge_radius=5.0, edge_length=0.25
    )
    system = scene.condense()
    s = np.r_[np.linspace(0, 1, 11), np.linspace(0, 1, 11)]
    from_end = np.minimum(s, 1 - s)
    assert np.allclose(system.gap, np.maximum(0.25 - from_end, 0.0) ** 2 / 10.0, atol=1e-15)
    assert not replace(scene, edge_radius=0.0).condense().gap.any()


def test_pressure_of_the_fit():
    """Plane strain, one material: E' d / (2 a) in an infinite plate; a round plate of the radius of
    the inner circle is softer (Lame)."""
    for half_width, tolerance in ((10.0, 0.01), (40.0, 0.002)):
        system = fo.scenes.PinInPlate(elements=80, plate_half_width=half_width).condense()
        q, p = system.bonded["fit"]
        infinite, round_plate = (
            1 / (1 - 0.3**2) / 2,
            1 / 1.3 / (0.4 + (0.4 + half_width**2) / (half_width**2 - 1)),
        )
        pressure = p / system.width
        assert (
            round_plate < pressure.mean() < infinite * 1.003
            and pressure.mean() == pytest.approx(infinite, rel=tolerance)
        )
        assert (
            np.ptp(pressure) < 1e-3 * pressure.mean()
            and np.abs(q / system.width).max() < 3e-3 * pressure.mean()
        )


def test_slip_of_a_pin_in_a_pulled_plate_begins_where_the_uniform_stress_says():
    """One material, glued: the pull sigma is uniform, so p = p0 - sigma (1 + cos 2t) / 2, |q| =
    sigma |sin 2t| / 2, and the first node slips at sigma / p0 = 2 f / (f + sqrt(1 + f^2)).
    """
    f, errors = 0.3, []
    expected = 2 * f / (f + np.hypot(1, f))
    for elements in (40, 80, 160):
        system = fo.scenes.PinInPlate(elements=elements, growth=1.3).condense()
        errors.append(
            fo.onset(system, fitted(system, [{"sigma": 1.0}]), f).slip.load_factor / expected - 1
        )
    assert np.abs(errors[2]) < 3e-3 and errors[0] > 2.5 * errors[1] > 6 * errors[2] > 0


def test_slip_of_a_loaded_pin_begins_where_kelvins_solution_says():
    """A uniform body force on a disc of an infinite body: outside, the field is that of a point
    force (Kelvin) and a^2 / 8 times its Laplacian, because the field is biharmonic. Tractions at
    the radius a: C cos t and T sin t.
    """
    f, nu = 0.3, 0.3
    C, T = ((5 - 4 * nu) / (8 * np.pi * (1 - nu)), (3 - 4 * nu) / (8 * np.pi * (1 - nu)))
    system = fo.scenes.PinInPlate(elements=160, plate_half_width=60.0, growth=1.3).condense()
    found = fo.onset(system, fitted(system, [{"Fx": 1.0}, {"Fy": 1.0}]), f)
    assert found.slip.load_factor == pytest.approx(f / np.hypot(T, f * C), rel=5e-3)
    assert found.separation.load_factor == pytest.approx(1 / C, rel=5e-3)


@refused(
    (fo.scenes.Dovetail, {"angle": 5.0}, "angle: 5"),
    (fo.scenes.Dovetail, {"elements": 5}, "multiple of 2"),
    (fo.scenes.Dovetail, {"edge_length": 0.6}, "edge_length: 0.6"),
    (fo.scenes.Dovetail, {"disc_half_width": 1.5}, "the slot takes"),
    (fo.scenes.Dovetail, {"growth": 1.0001}, "nodes"),
    (fo.scenes.PinInPlate, {"elements": 20}, "multiple of 8"),
    (fo.scenes.PinInPlate, {"plate_half_width": 1.4}, "plate_half_width: 1.4"),
    (fo.scenes.PinInPlate, {"growth": 1.00001, "elements": 8000}, "nodes"),
    (fo.scenes.RoundedPunch, {"flat_half_width": 1.0}, "flat_half_width: 1"),
    (
        fo.scenes.PressFit,
        {"collar_radius": 0.5},
        "collar_radius: 0.5; it must be more than shaft_radius = 1",
    ),
    (fo.scenes.PunchOnHalfPlane, {"elements": 17}, "elements: 17; give a multiple of 2"),
    (
        fo.scenes.PunchOnHalfPlane,
        {"block_half_width": 1.0},
        "block_half_width: 1; it must be more than half_width = 1",
    ),
    (fo.scenes.PunchOnHalfPlane, {"grading": 0.5}, "grading: 0.5"),
    (fo.scenes.PunchOnHalfPlane, {"growth": 1.0}, "growth: 1.0"),
    (fo.scenes.PunchOnHalfPlane, {"elements": 10**13}, "elements: 10000000000000"),
    (
        fo.scenes.PunchOnHalfPlane,
        {"half_width": 1e-300},
        "block_half_width: 12 beside half_width = 1e-300",
    ),
    (
        fo.scenes.PunchOnHalfPlane,
        {"half_width": 1e-4, "growth": 1.001},
        "growth = 1.001: they make a mesh of",
    ),
    (fo.scenes.PunchOnHalfPlane, {"grading": 9e14, "elements": 10_000}, "grading: 9e.14"),
    (fo.scenes.SquarePunch, {"elements": 1}, "elements"),
    (fo.scenes.SquarePunch, {"block_half_width": 1.0}, "block_half_width"),
    (fo.scenes.SquarePunch, {"growth": 1.0}, "growth"),
    (fo.scenes.SquarePunch, {"block_depth": 1e7}, "block_depth"),
)
def test_scenes_that_cannot_be_are_refused(kind, fields):
    kind(**fields)


@pytest.mark.parametrize(
    "scene",
    [
        fo.scenes.PunchOnHalfPlane(elements=6, growth=2.0),
        fo.scenes.Dovetail(angle=79, elements=4, growth=2.0),
        fo.scenes.PinInPlate(elements=8, growth=2.0),
        fo.scenes.PressFit(elements=4, growth=2.0),
        fo.scenes.SquarePunch(elements=2, growth=2.0),
    ],
    ids=lambda scene: type(scene).__name__,
)
def test_matrices_of_a_scene_make_its_contact_and_no_pair_may_be_exchanged(scene):
    model = scene.model()
    given, S = matrices_of(model), model.condense().S
    assert np.allclose(fo.condense(**given).S, S, rtol=0, atol=1e-12 * np.abs(S).max())
    for i in range(len(given["pairs"])):
        exchanged = given["pairs"].copy()
        exchanged[i] = exchanged[i, ::-1]
        with pytest.raises(
            fo.ModelError,
            match=f"normals: that of pair {i} at .* does not point from body 2 into body 1",
        ):
            fo.condense(**{**given, "pairs": exchanged})
