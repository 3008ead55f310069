"""Position tolerances: nodes are moved onto the opposite face, unstrained."""

import re
from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad

import frictopt as fo

STEEL = fo.fem.Material(E=200.0, nu=0.3)
SHEAR = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
KINDS = {"plane": (MeshQuad, None), "space": (MeshHex, None), "quadratic": (MeshHex, "quadratic")}


def block(kind, heights, shift, element=None, size=3):
    """A block 1 wide whose nodes on the height 0 are shifted by a function of the coordinates."""
    lines = [np.linspace(0.0, 1.0, size + 1)] * (1 if kind is MeshQuad else 2)
    mesh = kind.init_tensor(*lines, np.array(heights))
    names = {
        "contact": lambda x: x[-1] == 0,
        "top": lambda x: x[-1] == heights[-1],
        "bottom": lambda x: x[-1] == heights[0],
        "left": lambda x: x[0] == 0,
    }
    mesh = mesh.with_boundaries(names)
    points = mesh.p + (mesh.p[-1] == 0) * shift(mesh.p)
    moved = kind(points, mesh.t).with_boundaries(mesh.boundaries)
    return fo.fem.Body(moved, STEEL, element)


def along_normal(function):
    """Shifts along the last axis by a function of x."""

    def shift(x):
        steps = np.zeros(x.shape)
        steps[-1] = function(x[0])
        return steps

    return shift


def still(x):
    return np.zeros(x.shape)


def pad(upper=still, lower=still, kind="plane", **contact):
    """A block on another one, pressed and sheared."""
    mesh, element = KINDS[kind]
    return fo.fem.ContactModel(
        {
            "upper": block(mesh, [0.0, 0.3, 0.7], upper, element),
            "lower": block(mesh, [-0.6, -0.2, 0.0], lower, element),
        },
        contacts=[fo.fem.Contact("upper", "lower", **contact)],
        supports=[fo.fem.Support("lower", "bottom")],
        loads={
            "P": [fo.fem.Pressure("upper", "top", 10.0)],
            "Q": [fo.fem.Traction("upper", "top", x=1.0)],
        },
    )


def limits(model):
    system = model.condense(progress=False)
    return [
        ask(system, SHEAR, friction=0.3, progress=False).load_factor
        for ask in (fo.shakedown_limit, fo.gross_slip)
    ]


@pytest.mark.parametrize("by", ["a point", "a function"])
def test_places_name_nodes_by_their_coordinates_before_the_moves(by):
    """The nodes of the face have moved; a force and a support still find them as the mesh was."""
    clean, lifted = [
        pad(along_normal(lambda x, height=height: height + 0 * x), adjust=2e-3)
        for height in (0.0, -1e-3)
    ]

    def where(height):
        return (0.0, height) if by == "a point" else lambda x, y: (x == 0) & (y == height)

    found = [
        limits(
            replace(
                model,
                supports=[*model.supports, fo.fem.Support("upper", (1.0, height), "x")],
                loads={
                    "P": model.loads["P"],
                    "Q": [
                        fo.fem.PointForce(
                            "upper", where(height), x=lambda x, y, h=height: 1.0 * (y == h)
                        )
                    ],
                },
            )
        )
        for model, height in ((clean, 0.0), (lifted, -1e-3))
    ]
    assert found[1] == pytest.approx(found[0], rel=1e-9)


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("kind", KINDS)
def test_noise_in_all_directions_on_a_face_changes_no_limit(kind, size):
    """On matching meshes nodes return to their places, so that nothing at all is left of noise."""
    random = np.random.default_rng(1)

    def noise(x):
        return size * random.uniform(-1, 1, x.shape)

    exact = pad(kind=kind)
    noisy = pad(upper=noise, kind=kind, adjust=2 * size)
    np.testing.assert_allclose(limits(noisy), limits(exact), rtol=1e-9)
    # Shear per pressure is 1 / 10.
    assert limits(noisy)[1] == pytest.approx(0.3 * 10, rel=1e-9)
    (note,) = noisy.notes
    assert re.fullmatch(r"adjust, body 'upper': \d+ nodes moved, by up to .*", note)
    assert note in repr(noisy)
    largest = float(note.rsplit(" ", 1)[1])
    assert 0.5 * size < largest < 2 * size


def test_only_overlaps_move_if_the_tolerance_is_zero():
    waves = along_normal(lambda x: np.where(x < 0.5, -1e-4, 1e-4))
    model = pad(waves, adjust=0)
    system = model.condense(progress=False)
    np.testing.assert_allclose(system.gap, np.where(system.x < 0.5, 0.0, 1e-4), atol=1e-15)
    apart = int((system.x >= 0.5).sum())
    assert model.notes == (
        "adjust, body 'upper': 2 nodes moved, by up to 0.0001",
        f"contact 'contact': {apart} of {system.nodes} nodes apart, by up to 0.0001",
    )
    # Without a tolerance an overlap and a gap are refused, with the way out.
    for gap in (None, "measured"):
        with pytest.raises(fo.ModelError, match=r"overlap by 0.0001.*give the Contact adjust="):
            pad(waves, gap=gap)
    with pytest.raises(fo.ModelError, match=r"do not touch.*give the Contact adjust="):
        pad(along_normal(lambda x: 1e-4 + 0 * x))


def test_chosen_nodes_move_however_far_they_are():
    apart = along_normal(lambda x: 0.01 + 0 * x)
    model = pad(apart, adjust=lambda x, y: x < 0.5)
    system = model.condense(progress=False)
    np.testing.assert_allclose(system.gap, np.where(system.x < 0.5, 0.0, 0.01), rtol=1e-3)
    assert pad(apart, adjust="left").condense(progress=False).gap.argmin() == 0


@pytest.mark.parametrize("tilt", [1e-2, -1e-2])
def test_a_taper_stays_a_taper(tilt):
    """A block on a slope moves downhill under the shear P tan(phi - beta)."""
    slope = along_normal(lambda x: tilt * x)

    def noisy_slope(x):
        steps = slope(x)
        steps[-1] += 1e-5 * np.sin(50 * x[0])
        return steps

    slides = limits(pad(noisy_slope, slope, adjust=1e-4))[1]
    assert slides == pytest.approx(10 * np.tan(np.arctan(0.3) - abs(np.arctan(tilt))), rel=1e-6)


def test_a_shallow_curve_beyond_the_tolerance_stays_curved():
    crown = along_normal(lambda x: 4e-3 * x * (1 - x))
    assert pad(crown, crown, adjust=1e-6).notes == ()


def test_a_node_of_two_contacts_comes_to_their_common_edge():
    random = np.random.default_rng(3)
    x, y = np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 3)
    places = {
        "under": lambda x: x[1] == 0,
        "side": lambda x: x[0] == 0,
        "top": lambda x: x[1] == 1,
        "face": lambda x: x[0] == 0,
        "up": lambda x: x[1] == 0,
    }
    box = MeshQuad.init_tensor(x, y).with_boundaries(places)
    lean = np.array([[1.0, 0.3], [0.0, 1.0]])  # the wall leans
    noisy = MeshQuad(lean @ box.p + 1e-5 * random.uniform(-1, 1, box.p.shape), box.t)
    # No node of the floor or the wall is at the edge.
    floor = MeshQuad.init_tensor([-0.2, 0.4, 1.0], y - 1).with_boundaries(places)
    wall = MeshQuad.init_tensor(x - 1, [0.05, 0.4, 1.0]).with_boundaries(
        {"face": lambda x: x[0] == 0, "far": lambda x: x[0] == -1}
    )
    with pytest.warns(fo.ModelWarning, match="has no opposite part"):
        model = fo.fem.ContactModel(
            {
                "box": fo.fem.Body(noisy.with_boundaries(box.boundaries)),
                "floor": fo.fem.Body(floor),
                "wall": fo.fem.Body(
                    MeshQuad(lean @ wall.p, wall.t).with_boundaries(wall.boundaries)
                ),
            },
            contacts=[
                fo.fem.Contact("box", "floor", "under", "up", adjust=1e-4),
                fo.fem.Contact("box", "wall", "side", "face", adjust=1e-4),
            ],
            supports=[fo.fem.Support("floor", lambda x, y: y == -1), fo.fem.Support("wall", "far")],
            loads={"P": [fo.fem.Pressure("box", "top", 1.0)]},
        )
    system = model.condense(progress=False)
    of_floor = system.contact == "under"
    np.testing.assert_allclose(system.points[of_floor, 1], 0.0, atol=1e-15)
    x, y = system.points[~of_floor].T
    np.testing.assert_allclose(x, 0.3 * y, atol=1e-15)
    np.testing.assert_allclose(system.points[of_floor][0], 0.0, atol=1e-15)


def test_moves_that_would_change_elements_are_refused():
    def stepped(x):
        return along_normal(lambda x: np.where(np.isclose(x, 1 / 3), 0.05, 0.0))(x)

    message = r"adjust, body 'upper': node \d at \(0.333333, 0.05\) would move by 0.05, and an element there"
    with pytest.raises(fo.ModelError, match=message):
        pad(stepped, adjust=0.1)
    for wrong, message in {-1.0: "adjust", "nowhere": "'nowhere' is unknown", 1j: "adjust"}.items():
        with pytest.raises(fo.ModelError, match=message):
            pad(adjust=wrong)
