import numpy as np
import pytest

import frictopt as fo


def test_default_has_the_papers_size():
    model = fo.scenes.PunchOnHalfPlane().model()
    unknowns = 2 * sum(body.mesh.p.shape[1] for body in model.bodies.values())
    assert 45_000 < unknowns < 55_000
    assert len(model.bodies["punch"].boundary_nodes("contact", "contact")) == 125


@pytest.mark.parametrize("elements", [2, 16, 64])
@pytest.mark.parametrize("grading", [1.0, 20.0, "sine"])
def test_contact_nodes(elements, grading):
    scene = fo.scenes.PunchOnHalfPlane(
        elements=elements, half_width=3.0, grading=grading, block_half_width=20.0
    )
    x = scene.contact_nodes
    sizes = np.diff(x)
    assert (
        len(x) == elements + 1 and x[-1] == 3.0 and np.array_equal(x, -x[::-1]) and sizes.min() > 0
    )
    if grading != "sine" and elements > 2:
        assert sizes[elements // 2] / sizes[-1] == pytest.approx(grading, rel=1e-10)
        assert np.allclose(
            np.diff(np.log(sizes[elements // 2 :])),
            np.diff(np.log(sizes[elements // 2 :]))[0],
            atol=1e-10,
        )
    if grading == "sine":
        assert np.allclose(
            x, 3.0 * np.sin(np.pi / 2 * np.linspace(-1, 1, elements + 1)), atol=1e-14
        )
    assert scene.corner_size == sizes[-1]


def test_reactions_balance_the_loads_and_a_free_punch_has_three_free_motions(punch):
    system = punch(16)
    assert system.bonded["P"][1].sum() == pytest.approx(2.0, rel=1e-11)
    assert system.bonded["Q"][0].sum() == pytest.approx(-2.0, rel=1e-11)
    assert abs(system.bonded["sigma"][1].sum()) < 1e-11 and abs(system.bonded["P"][0].sum()) < 1e-11
    turn = np.r_[np.zeros(17), system.x]
    for motion in (np.r_[np.ones(17), np.zeros(17)], np.r_[np.zeros(17), np.ones(17)], turn):
        assert np.abs(system.S @ motion).max() < 1e-14
    assert np.sort(np.linalg.eigvalsh(system.S))[3] > 1e-3


def test_the_scene_is_its_own_mirror_image(punch):
    system = punch(16)
    flip = (slice(None, None, -1),) * 2
    assert (
        np.array_equal(system.A, system.A[flip])
        and np.array_equal(system.B, -system.B[flip])
        and np.array_equal(system.C, system.C[flip])
    )
    for name, sign in (("P", -1), ("sigma", -1), ("Q", 1)):
        q, p = system.bonded[name]
        assert np.array_equal(q, sign * q[::-1]) and np.array_equal(p, -sign * p[::-1])


def test_a_pulled_block_pulls_the_ends_of_the_punch_apart(punch):
    system = punch(16)
    q, _ = system.bonded["sigma"]
    assert (q[:8] < -1e-3).all() and (q[9:] > 1e-3).all()


def test_bonded_corner_has_the_exponents_and_ratios_of_the_three_quarter_plane():
    """Tractions over 3 .. 20 % of a from the corner are the sum of both singular modes (Williams
    1952): one power law alone does not fit.

    With the exponents of the closed form, separate fits of p and q must give the closed form's
    traction ratios; with its ratios, the symmetric part of the tractions must fall with the closed
    form's exponent.
    """
    modes = fo.reference.bonded_corner()
    system = fo.scenes.PunchOnHalfPlane(elements=124, grading=200.0).condense()
    edges = np.r_[system.x[0], (system.x[1:] + system.x[:-1]) / 2, system.x[-1]]
    q, p = (force / np.diff(edges) for force in system.bonded["P"])
    r = 1.0 + system.x
    near = (r > 0.03) & (r < 0.2)
    powers = r[near, None] ** (
        np.array([mode.exponent for mode in modes] + [2.0]) - 1
    )  # and the next, regular term
    fits = [np.linalg.lstsq(powers, values[near], rcond=None)[0] for values in (q, p)]
    assert fits[0][0] / fits[1][0] == pytest.approx(0.543075578737, abs=0.02)
    symmetric = (q - modes[1].traction_ratio * p)[near]
    assert np.polyfit(np.log(r[near]), np.log(np.abs(symmetric)), 1)[0] == pytest.approx(
        0.544483736782 - 1, abs=0.03
    )


def test_accuracy_that_is_lost_is_said():
    with pytest.raises(fo.ModelError, match="equilibrium of the bodies"):
        fo.scenes.PunchOnHalfPlane(
            elements=6, growth=2.5, grading=3.0, punch_material=fo.fem.Material(1e11)
        ).condense()


def test_sizes_need_not_add_up_in_floating_point():
    model = fo.scenes.PunchOnHalfPlane(
        elements=4, half_width=0.2, punch_height=0.4, block_half_width=0.9, block_depth=0.9
    ).model()
    assert (
        model.bodies["block"].mesh.p[0].max() == 0.9
        and len(model.bodies["block"].mesh.boundaries["left"]) > 0
    )
