"""Values that are no errors but seldom meant: one warning each, at the user's own call, and none from calls of the package among its own."""

import warnings

import numpy as np
import pandas as pd
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo
from meshes import blocks, box, hung, uniform_loads

SYSTEM = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense()
NODE_3D = fo.ContactSystem(np.eye(3), [[0.0, 0.0, 0.0]], {"P": [0, 0, 1], "Q": [1, 0, 0]})
CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}])


def warned(call):
    """The warnings of a call, which must name this file as the place of the call."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert all(warning.filename == __file__ and warning.category is fo.ModelWarning for warning in caught)
    return [str(warning.message) for warning in caught]


def model(E=(1.0, 1.0), x=(None, None), **contact):
    punch, block = blocks(x_punch=x[0], x_block=x[1]).values()
    bodies = {name: fo.Body(body.mesh, fo.Material(e)) for name, body, e in (("punch", punch, E[0]), ("block", block, E[1]))}
    return fo.ContactModel(bodies, hung(), uniform_loads(), [fo.Contact("punch", "block", **contact)])


def cubes(E=1.0, size=1.0):
    x = np.array([0.0, 1.0])
    bodies = {"punch": fo.Body(box(MeshHex, *[size * x] * 3), fo.Material(E)), "block": fo.Body(box(MeshHex, x, x, x - 1))}
    return fo.ContactModel(bodies, [fo.Support("block", "z-")], {"W": [fo.BodyForce("punch", z=-1.0)]})


def test_moduli_in_two_units():
    for call in (lambda: model((210e9, 115e3)), lambda: cubes(1e6)):
        (told,) = warned(call)
        assert "of 'punch' and" in told and "same unit" in told
    assert not warned(lambda: model((210.0, 115000.0))) and not warned(lambda: cubes(1e4))


def test_lengths_in_two_units():
    (told,) = warned(lambda: cubes(size=1e-3))
    assert told.startswith("bodies: size = 0.001 of 'punch' and 1 of 'block'; are both in the same unit (mm or m)?")
    assert not warned(lambda: cubes(size=1e-2))


def test_a_body_1_that_is_coarser_than_its_partner():
    fine, coarse = np.linspace(-1, 1, 41), np.linspace(-1, 1, 9)
    (told,) = warned(lambda: model(x=(coarse, fine)))
    assert told.startswith("contacts: 'contact': the edges of body 'punch' are 5.0 times as long as those of body 'block'")
    far = np.linspace(1, 2, 101)[1:]  # far finer, but beside the contact
    face = MeshQuad.init_tensor(np.r_[-far[::-1], fine, far], np.array([-1.0, 0.0])).with_defaults()
    bodies = {"punch": blocks(x_punch=coarse)["punch"], "block": fo.Body(face)}
    wide = [fo.Support("block", "bottom")], {"P": [fo.Traction("punch", "top", y=-1.0)]}, [fo.Contact("punch", "block", boundary_2="top")]
    assert warned(lambda: fo.ContactModel(bodies, *wide)) == [told]
    assert not warned(lambda: model(x=(fine, coarse))) and not warned(lambda: model(x=(coarse, np.linspace(-1, 1, 33))))


@pytest.mark.parametrize("system", [SYSTEM, NODE_3D])
def test_friction_in_per_cent_and_a_load_factor_of_zero(system):
    for ask in (fo.shakedown_limit, fo.onset):
        (told,) = warned(lambda ask=ask: ask(system, CYCLE, 30.0))
        assert told.startswith("friction: 30, above 5")
        assert not warned(lambda ask=ask: ask(system, CYCLE, friction=5.0))
    for ask in (fo.safe_slip, fo.march, fo.steady_state):
        (told,) = warned(lambda ask=ask: ask(system, CYCLE, 0.5, load_factor=0))
        assert told.startswith("load_factor: 0;")
        assert not warned(lambda ask=ask: ask(system, CYCLE, 0.5, 1.0))
    assert len(warned(lambda: fo.safe_slip(system, CYCLE, np.full(system.nodes, 6.0), 0.0))) == 2


@pytest.mark.parametrize(
    "ask",
    [
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).solve(f),
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).sweep([0.5, np.full(SYSTEM.nodes, f)]),
        lambda f: fo.ShakedownModel(SYSTEM, CYCLE).sweep(pd.Series([0.5, f])),
        lambda f: fo.SafeSlipModel(SYSTEM, CYCLE).solve(f, 0.0),
        lambda f: fo.GuaranteedModel(SYSTEM, CYCLE).solve(f),
        lambda f: (model := fo.DesignModel(SYSTEM, CYCLE, preloads=["P"])).solve(f, [model.preload <= 1.0]),
        lambda f: fo.safe_region(SYSTEM, {"P": 1.0}, ["Q", "sigma"], f),
        lambda f: fo.dissipation_study(SYSTEM, CYCLE, [f], load_factors=[1.0]),
        lambda f: fo.dissipation_range(SYSTEM, CYCLE, f, load_factor=1.0),
        lambda f: fo.limit_after_protocol(SYSTEM, CYCLE, f),
        lambda f: fo.least_excursion(SYSTEM, CYCLE, f, load_factor=1.0, excursion={"P": -0.5}),
        lambda f: fo.backbone_curve(SYSTEM, CYCLE, f, load_factors=[1.0]),
    ],
)
def test_friction_in_per_cent_in_longer_questions(ask):
    (told,) = warned(lambda: ask(30.0))
    assert told.startswith("friction: 30, above 5")


def test_the_package_may_ask_itself_what_it_likes():
    assert not warned(lambda: fo.required_friction(SYSTEM, CYCLE, 1.0))
    assert not warned(lambda: fo.safe_region(SYSTEM, {"P": 1.0}, ["Q", "sigma"], 0.5))
    assert not warned(lambda: fo.guaranteed_limit(SYSTEM, CYCLE, 0.5))


def test_words_for_what_is_nearly_right():
    scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0)
    for almost in (scene, scene.model(), cubes(1.0)):
        with pytest.raises(fo.ModelError, match=rf"system: a {type(almost).__name__}; give a ContactSystem \(call its \.condense\(\)"):
            fo.shakedown_limit(almost, CYCLE, 0.5)
    bare = MeshQuad.init_tensor([0.0, 1.0], [0.0, 1.0])
    with pytest.raises(fo.ModelError, match="a Contact takes the boundary 'contact' of both bodies unless others are named"):
        fo.ContactModel({"one": fo.Body(bare), "two": fo.Body(bare)}, [], uniform_loads())
