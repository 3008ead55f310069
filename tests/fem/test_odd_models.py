"""Values that are no errors but seldom intended cause one warning each.

The warning is at the user's own call. Calls of the package among its own functions cause none.
"""

import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from skfem import MeshHex, MeshQuad, MeshTri

import frictopt as fo
from helpers.meshes import blocks, box, hung, uniform_loads

SYSTEM = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense()
NODE_3D = fo.ContactSystem(np.eye(3), [[0.0, 0.0, 0.0]], {"P": [0, 0, 1], "Q": [1, 0, 0]})
CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}])


def warned(call):
    """The warnings of a call, which must name this file as the place of the call."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert all(
        warning.filename == __file__ and warning.category is fo.ModelWarning for warning in caught
    )
    return [str(warning.message) for warning in caught]


def model(E=(1.0, 1.0), x=(None, None), **contact):
    punch, block = blocks(x_punch=x[0], x_block=x[1]).values()
    bodies = {
        name: fo.fem.Body(body.mesh, fo.fem.Material(e))
        for name, body, e in (("punch", punch, E[0]), ("block", block, E[1]))
    }
    return fo.fem.ContactModel(
        bodies, hung(), uniform_loads(), [fo.fem.Contact("punch", "block", **contact)]
    )


def cubes(E=1.0, size=1.0):
    x = np.array([0.0, 1.0])
    bodies = {
        "punch": fo.fem.Body(box(MeshHex, *[size * x] * 3), fo.fem.Material(E)),
        "block": fo.fem.Body(box(MeshHex, x, x, x - 1)),
    }
    return fo.fem.ContactModel(
        bodies, [fo.fem.Support("block", "z-")], {"W": [fo.fem.BodyForce("punch", z=-1.0)]}
    )


def test_moduli_in_two_units():
    for call in (lambda: model((210e9, 115e3)), lambda: cubes(1e6)):
        (warning,) = warned(call)
        assert "of 'punch' and" in warning and "same unit" in warning
    assert not warned(lambda: cubes(1e4))


@pytest.mark.parametrize(
    ("punch", "block"), [(210.0, 115e3), (115e3, 210.0), (0.21, 210.0), (70.0, 210e3)]
)
def test_moduli_in_mpa_and_gpa(punch, block):
    (warning,) = warned(lambda: model((punch, block)))
    soft, stiff = ("punch", "block") if punch < block else ("block", "punch")
    assert warning.startswith(
        f"bodies: E = {min(punch, block):g} of {soft!r} and {max(punch, block):g} of {stiff!r}"
    )
    assert "in the same unit (MPa or GPa)?" in warning


@pytest.mark.parametrize(
    ("one", "other"), [(2.0, 210e3), (10.0, 210e3), (500.0, 210e3), (3e3, 210e3), (45e3, 600e3)]
)
def test_moduli_of_real_pairs(one, other):
    """They are rubbers, PTFE and PEEK on steel, and magnesium on tungsten carbide."""
    assert not warned(lambda: model((one, other)))


@pytest.mark.parametrize("system", [SYSTEM, NODE_3D])
def test_a_load_case_in_the_mean_load_and_again_in_each_corner(system):
    for amplitudes in ((1.0, 1.0), (1.2, 0.8)):
        whole = fo.LoadCycle(
            {"P": 1.0}, [{"P": amplitudes[0], "Q": 0.1}, {"P": amplitudes[1], "Q": -0.1}]
        )
        (warning,) = warned(lambda whole=whole: fo.shakedown_limit(system, whole, 0.5))
        assert warning.startswith(
            "cycle: 'P' is 1 in the mean load, and each corner adds to it; in a corner, give only the addition to the mean load"
        )
    for amplitudes in ((0.2, -0.2), (0.2, 0.0), (-0.2, -0.1)):  # to and fro, pulsating, and relief
        added = fo.LoadCycle(
            {"P": 1.0}, [{"P": amplitudes[0], "Q": 0.1}, {"P": amplitudes[1], "Q": -0.1}]
        )
        assert not warned(lambda added=added: fo.shakedown_limit(system, added, 0.5))
    # A load that rises in proportion is no mistake.
    assert not warned(
        lambda: fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"P": 1.0, "Q": 0.1}]), 0.5)
    )


@pytest.mark.parametrize(
    ("units", "coefficient", "meant"),
    [
        ("N, mm", 1.33e-13, 1.33e-7),
        ("N, m", 1.33e-7, 1.33e-13),
        ("kN, m", 1e-15, 1e-10),
        ("kN, mm", 1e-13, 1e-4),
        ("MN, m", 1e-14, 1e-8),
    ],
)
def test_a_coefficient_of_wear_in_other_units(units, coefficient, meant):
    """A coefficient of wear in other units than the model causes a warning.

    Coefficients of dry steel (Podra & Andersson 1999) and of other materials are in the unit of the
    model and in another unit.
    """
    system, cycle = replace(SYSTEM, units=units), CYCLE
    (warning,) = warned(
        lambda: fo.joints.wear(system, cycle, 0.3, 1.0, coefficient=coefficient, cycles=1)
    )
    force, length = units.split(", ")
    assert warning.startswith(f"coefficient: {coefficient:g} is ")
    assert f"forces are in {force} and lengths in {length}" in warning
    assert not warned(lambda: fo.joints.wear(system, cycle, 0.3, 1.0, coefficient=meant, cycles=1))
    # Units are not known.
    assert not warned(
        lambda: fo.joints.wear(SYSTEM, cycle, 0.3, 1.0, coefficient=coefficient, cycles=1)
    )


def soft_blocks(nu, element, kind=MeshQuad, kinematics="plane_strain"):
    """A block of steel on a block with another Poisson's ratio."""
    x = np.linspace(0.0, 1.0, 7)
    meshes = {"punch": box(MeshQuad, x, x), "block": box(kind, x, x - 1)}
    steel, soft = fo.fem.Material(1.0, 0.3), fo.fem.Material(1.0, nu)
    bodies = {
        "punch": fo.fem.Body(meshes["punch"], steel, "quadratic"),
        "block": fo.fem.Body(meshes["block"], soft, element),
    }
    loads = {
        "P": [fo.fem.Traction("punch", "y+", y=-1.0)],
        "Q": [fo.fem.Traction("punch", "y+", x=1.0)],
    }
    return fo.fem.ContactModel(
        bodies, [fo.fem.Support("block", "y-")], loads, kinematics=kinematics
    )


@pytest.mark.parametrize(
    ("nu", "element", "kind", "kinematics", "locks"),
    [
        (0.495, "linear", MeshQuad, "plane_strain", True),
        (0.495, "linear", MeshQuad, "axisymmetric", True),
        (0.495, "mean_dilatation", MeshTri, "plane_strain", True),
        (0.495, "mean_dilatation", MeshQuad, "plane_strain", False),
        (0.495, "quadratic", MeshTri, "plane_strain", False),
        (0.495, "linear", MeshTri, "plane_stress", False),
        (0.4, "linear", MeshTri, "plane_strain", False),
    ],
)
def test_elements_that_lock(nu, element, kind, kinematics, locks):
    warnings = warned(lambda: soft_blocks(nu, element, kind, kinematics))
    if not locks:
        assert not warnings
        return
    (text,) = warnings
    assert text.startswith(
        f"bodies['block']: nu = 0.495 and element {element!r} on a {kind.__name__}"
    )


def test_a_poisson_ratio_whose_digits_are_lost_is_named():
    """Down to 1 - 2 nu = 1e-6 the compliance approaches a limit; at 2e-10 no digits are left."""
    by_nu = [
        soft_blocks(0.5 - away / 2, "quadratic").condense().compliance for away in (1e-4, 1e-6)
    ]
    assert np.allclose(*by_nu, rtol=1e-2, atol=1e-6)
    with pytest.raises(fo.ModelError, match=r"^bodies\['block'\]: nu = 0.4999999999 is too close"):
        soft_blocks(0.4999999999, "quadratic").condense()
    with pytest.raises(fo.ModelError, match=r"^supports: the body at .* can still move"):
        fo.fem.ContactModel(
            soft_blocks(0.3, "quadratic").bodies,
            [],
            {"P": [fo.fem.Traction("punch", "y+", y=-1.0)]},
        ).condense()


def test_lengths_in_two_units():
    (warning,) = warned(lambda: cubes(size=1e-3))
    assert warning.startswith(
        "bodies: size = 0.001 of 'punch' and 1 of 'block'; are both in the same unit (mm or m)?"
    )
    assert not warned(lambda: cubes(size=1e-2))


def test_a_body_1_that_is_coarser_than_its_partner():
    fine, coarse = np.linspace(-1, 1, 41), np.linspace(-1, 1, 9)
    (warning,) = warned(lambda: model(x=(coarse, fine)))
    assert warning.startswith(
        "contacts: 'contact': the edges of body 'punch' are 5.0 times as long as those of body 'block'"
    )
    far = np.linspace(1, 2, 101)[1:]  # far finer, but beside the contact
    face = MeshQuad.init_tensor(np.r_[-far[::-1], fine, far], np.array([-1.0, 0.0])).with_defaults()
    bodies = {"punch": blocks(x_punch=coarse)["punch"], "block": fo.fem.Body(face)}
    wide = (
        [fo.fem.Support("block", "bottom")],
        {"P": [fo.fem.Traction("punch", "top", y=-1.0)]},
        [fo.fem.Contact("punch", "block", boundary_2="top")],
    )
    assert warned(lambda: fo.fem.ContactModel(bodies, *wide)) == [warning]
    assert not warned(lambda: model(x=(fine, coarse)))
    assert not warned(lambda: model(x=(coarse, np.linspace(-1, 1, 33))))


@pytest.mark.parametrize("system", [SYSTEM, NODE_3D])
def test_friction_in_per_cent_and_a_load_factor_of_zero(system):
    for ask in (fo.shakedown_limit, fo.onset):
        (warning,) = warned(lambda ask=ask: ask(system, CYCLE, 30.0))
        assert warning.startswith("friction: 30, above 5")
        assert not warned(lambda ask=ask: ask(system, CYCLE, friction=5.0))
    for ask in (fo.safe_slip, fo.march, fo.steady_state):
        (warning,) = warned(lambda ask=ask: ask(system, CYCLE, 0.5, load_factor=0))
        assert warning.startswith("load_factor: 0;")
        assert not warned(lambda ask=ask: ask(system, CYCLE, 0.5, 1.0))
    assert len(warned(lambda: fo.safe_slip(system, CYCLE, np.full(system.nodes, 6.0), 0.0))) == 2


@pytest.mark.parametrize(
    "ask",
    [
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).solve(f),
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).sweep([0.5, np.full(SYSTEM.nodes, f)]),
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).sweep(pd.Series([0.5, f])),
        lambda f: fo.GuaranteedModel(SYSTEM, CYCLE).solve(f),
        lambda f: (model := fo.DesignModel(SYSTEM, CYCLE, preloads=["P"])).solve(
            f, [model.preload <= 1.0]
        ),
        lambda f: fo.safe_region(SYSTEM, {"P": 1.0}, ["Q", "sigma"], f),
        lambda f: fo.dissipation_study(SYSTEM, CYCLE, [f], load_factors=[1.0]),
        lambda f: fo.dissipation_range(SYSTEM, CYCLE, f, load_factor=1.0),
        lambda f: fo.joints.backbone_curve(SYSTEM, CYCLE, f, load_factors=[1.0]),
    ],
)
def test_friction_in_per_cent_in_longer_questions(ask):
    (warning,) = warned(lambda: ask(30.0))
    assert warning.startswith("friction: 30, above 5")


def test_the_package_may_ask_itself_what_it_likes():
    assert not warned(lambda: fo.required_friction(SYSTEM, CYCLE, 1.0))
    assert not warned(lambda: fo.safe_region(SYSTEM, {"P": 1.0}, ["Q", "sigma"], 0.5))
    assert not warned(lambda: fo.guaranteed_limit(SYSTEM, CYCLE, 0.5))


def test_words_for_what_is_nearly_right():
    scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0)
    for almost in (scene, scene.model(), cubes(1.0)):
        with pytest.raises(
            fo.ModelError,
            match=rf"system: a {type(almost).__name__}; give a ContactSystem \(call its \.condense\(\)",
        ):
            fo.shakedown_limit(almost, CYCLE, 0.5)
    bare = MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0])
    with pytest.raises(
        fo.ModelError,
        match="a Contact takes the boundary 'contact' of both bodies unless others are named",
    ):
        fo.fem.ContactModel(
            {"one": fo.fem.Body(bare), "two": fo.fem.Body(bare)}, [], uniform_loads()
        )
