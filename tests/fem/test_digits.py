"""Coordinates have the digits of their file.

Six digits are enough, and errors name deviations beyond the digits.
"""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from skfem import MeshHex, MeshQuad

import frictopt as fo
from frictopt.fem.coincidence import coordinate_errors, measured
from frictopt.fem.faces import Face
from helpers.cases import few


def digits(x, count):
    """The numbers with so many digits."""
    return np.array([float(f"{value:.{count - 1}e}") for value in x.ravel()]).reshape(x.shape)


def decimals(x, count):
    """The numbers with so many decimals: the largest one, of 0.1 to 1, has as many digits."""
    return np.array([float(f"{value:.{count}f}") for value in x.ravel()]).reshape(x.shape)


def lap(space, written, angle, apart=0.0, **how):
    """Two plates of 1 x 0.2, turned by an angle, with faces that are meshed differently.

    A uniform pressure of 1 goes through them.
    """
    bodies = {}
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    for name, n, z in (("a", 7, [0.0, 0.1, 0.2]), ("b", 5, [-0.2, -0.1, 0.0])):
        x = np.linspace(0.0, 1.0, n + 1)
        mesh = (
            MeshHex.init_tensor(x, x, np.array(z))
            if space
            else MeshQuad.init_tensor(x, np.array(z))
        )
        mesh = mesh.with_boundaries(
            {"c": lambda x: x[-1] == 0, "far": lambda x: abs(x[-1]) > 0.199}
        )
        p = mesh.p.copy()
        p[[0, -1]] = turn @ (mesh.p[[0, -1]] + np.array([[0.0], [apart * (name == "a")]]))
        bodies[name] = fo.fem.Body(type(mesh)(written(p), mesh.t, mesh.boundaries))
    loads = {"P": [fo.fem.Pressure("a", "far", 1.0)]}
    return fo.fem.ContactModel(
        bodies, [fo.fem.Support("b", "far")], loads, [fo.fem.Contact("a", "b", "c", "c", **how)]
    ).condense()


def single(x, _count=7):
    """The numbers in single precision, as in binary files."""
    return x.astype(np.float32).astype(float)


@settings(max_examples=few(60))
@given(
    angle=st.floats(0.05, 3.0),
    space=st.booleans(),
    shift=st.sampled_from([0.0, 0.3, -70.0]),
    gap=st.sampled_from([None, "measured"]),
)
def test_faces_touch_in_single_precision(angle, space, shift, gap):
    """Faces that touch do so in a file of single precision, and gaps beyond it are told."""
    error = float(np.spacing(np.float32(abs(shift) + 1.0)))
    system = lap(space, lambda x: single(x + shift), angle, gap=gap)
    assert system.bonded["P"][1].sum() == pytest.approx(1.0, rel=100 * error)
    assert not system.gap.any()
    with pytest.raises(fo.ModelError, match="the bodies overlap by"):
        lap(space, lambda x: single(x + shift), angle, apart=-4 * error)
    far = lap(space, lambda x: single(x + shift), angle, apart=4 * error, gap="measured").gap
    assert far == pytest.approx(4 * error, abs=2 * error)


@settings(max_examples=few(60))
@given(
    angle=st.floats(0.05, 3.0),
    count=st.sampled_from([6, 7, 8]),
    form=st.sampled_from([digits, decimals]),
    space=st.booleans(),
)
@example(angle=0.8491652678121971, count=7, form=decimals, space=True)
def test_what_is_beyond_the_digits_is_told(angle, count, form, space):
    """The answer names deviations beyond the digits.

    The last digit of numbers up to 1 is at most 10^-count. Errors of half a unit in two coordinates
    of two points are sqrt(2) units, and so is the sag. Places at the rim of a face have errors of up
    to 8.5 units, because some of their weights are negative.
    """
    far = 10 * 10.0**-count * (10 if count < 8 and form is digits else 1)
    with pytest.raises(fo.ModelError, match="the bodies overlap by"):
        lap(space, lambda x: form(x, count), angle, apart=-far)
    with pytest.raises(fo.ModelError, match="the faces do not touch"):
        lap(space, lambda x: form(x, count), angle, apart=far)
    gap = lap(space, lambda x: form(x, count), angle, apart=far, gap="measured").gap
    assert gap == pytest.approx(far, abs=2 * 10.0**-count)


def sixth(written):
    """The sixth of a rim that is pressed on a hub and sheared around, with its limit."""

    def around(x, y):
        return np.arctan2(y, x)

    bodies = {}
    for name, radii in (("hub", [1.0, 1.5, 2.0]), ("rim", [2.0, 2.5, 3.0, 4.0])):
        grid = MeshQuad.init_tensor(np.array(radii), np.linspace(0.2, 0.2 + np.pi / 3, 7))
        grid = grid.with_boundaries(
            {
                "low": lambda x: x[1] < 0.2001,
                "high": lambda x: x[1] > 0.1999 + np.pi / 3,
                "inner": lambda x, r=radii[0]: x[0] == r,
                "outer": lambda x, r=radii[-1]: x[0] == r,
            }
        )
        points = grid.p[0] * np.array([np.cos(grid.p[1]), np.sin(grid.p[1])])
        bodies[name] = fo.fem.Body(MeshQuad(written(points), grid.t, grid.boundaries))
    shear = fo.fem.Traction(
        "rim", "outer", x=lambda x, y: -np.sin(around(x, y)), y=lambda x, y: np.cos(around(x, y))
    )
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Cyclic("hub", "low", "high"), fo.fem.Cyclic("rim", "low", "high")]
        + [fo.fem.Support("hub", "inner")],
        {"fit": [fo.fem.Interference("fit", 0.01)], "Q": [shear]},
        [fo.fem.Contact("hub", "rim", "outer", "inner", name="fit")],
    )
    cycle = fo.LoadCycle({"fit": 1.0}, [{"Q": 1e-3}, {"Q": -1e-3}])
    return fo.shakedown_limit(model.condense(), cycle, 0.15)


@pytest.mark.parametrize("count", [6, 7])
@pytest.mark.parametrize("form", [digits, decimals, single])
def test_a_sector_of_few_digits_is_free_to_turn(count, form):
    """A rim turns freely on its hub, also if the copied nodes of its sector are rounded.

    The digits change the shape of the contact: its edges have a hundred times the length of the
    last digit and more, and its normals lean by that.
    """
    limit = sixth(lambda points: form(points, count))
    assert limit.load_factor == pytest.approx(sixth(np.array).load_factor, rel=10.0 ** (3 - count))


@pytest.mark.parametrize("count", [6, 8])
def test_a_line_has_the_sag_of_its_curve_and_none_of_its_digits(count):
    """The sag of an arc is that of its longest edges, edge^2 / 8 times the curvature."""
    x = np.linspace(0.0, 1.0, 8)
    facets = np.column_stack([np.arange(7), np.arange(1, 8)])

    def of_line(curvature):
        points = digits(np.column_stack([x, 0.1 + x / 3 + curvature * x**2 / 2]), count)
        return Face(facets, points, coordinate_errors(points)).sag()

    slope = 1 / 3 + 0.2 * x[3]
    edge = (x[1] - x[0]) * np.sqrt(1 + slope**2)
    assert not of_line(0.0).any()
    assert of_line(0.2)[3] == pytest.approx(edge**2 / 8 * 0.2 / (1 + slope**2) ** 1.5, rel=0.1)


def plates(gap, size=10.0):
    """Two plates along axes, of round numbers but for the gap between them."""
    bodies = {}
    for name, y in (("low", [0.0, size]), ("high", [size + gap, 2 * size + gap])):
        mesh = MeshQuad.init_tensor(np.linspace(0.0, size, 3), np.array(y))
        ends = {"bottom": y[0], "top": y[1]}
        bodies[name] = fo.fem.Body(
            mesh.with_boundaries({key: lambda x, at=at: x[1] == at for key, at in ends.items()})
        )
    contact = fo.fem.Contact("high", "low", "bottom", "top", gap="measured")
    return fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("low", "bottom")],
        {"P": [fo.fem.Pressure("high", "top", 1.0)]},
        [contact],
    ).condense()


@pytest.mark.parametrize("gap", [1e-3, 1e-4, 1e-5, 1e-6, 3e-7])
def test_a_gap_of_one_unit_in_the_last_digit_is_a_gap(gap):
    assert plates(gap).gap == pytest.approx(gap, rel=1e-6)


def ring(count, start, form=digits):
    """A sector of a ring in space.

    The nodes on one cut are turned copies of the nodes on the other cut.
    """
    n = 12
    mesh = MeshHex.init_tensor(
        np.linspace(30, 40, 4), np.linspace(start, start + 2 * np.pi / n, 5), np.array([0.0, 5.0])
    )
    at = {"low": (1, start), "high": (1, start + 2 * np.pi / n), "foot": (2, 0.0), "top": (2, 5.0)}
    mesh = mesh.with_boundaries(
        {name: lambda x, i=i, v=v: abs(x[i] - v) < 1e-9 for name, (i, v) in at.items()}
    )
    p = np.array([mesh.p[0] * np.cos(mesh.p[1]), mesh.p[0] * np.sin(mesh.p[1]), mesh.p[2]])
    return MeshHex(form(p, count), mesh.t, mesh.boundaries)


@pytest.mark.parametrize("count", [6, 7, 8, 10])
@pytest.mark.parametrize("start", [0.0, 0.2, 1.1, 2.5, 4.4])
def test_cut_faces_of_sectors_are_copies(count, start):
    """Two rings lie on each other. The pressure on one sector goes through its contact, which
    reaches the cuts."""
    mesh = ring(count, start)
    below = MeshHex(mesh.p - [[0], [0], [5]], mesh.t, mesh.boundaries)
    bodies = {"a": fo.fem.Body(mesh), "b": fo.fem.Body(below)}
    supports = [
        fo.fem.Support("b", "foot"),
        fo.fem.Cyclic("a", "low", "high"),
        fo.fem.Cyclic("b", "low", "high"),
    ]
    system = fo.fem.ContactModel(
        bodies,
        supports,
        {"P": [fo.fem.Pressure("a", "top", 1.0)]},
        [fo.fem.Contact("a", "b", "foot", "top")],
    ).condense()
    area = 4 * np.sin(2 * np.pi / 48) / 2 * (40**2 - 30**2)  # of four flat pieces
    assert system.bonded["P"][1].sum() == pytest.approx(area, rel=10.0 ** (2 - count))


@pytest.mark.parametrize(("units", "found"), [(0, 4), (1, 4), (3, 3)])
def test_nodes_of_a_job_match_to_their_digits(units, found):
    """Two bricks lie on each other; a node of one brick is moved along the face by units of the
    sixth digit."""
    x = digits(
        np.array([(a, b, c) for c in (0, 1, 1, 2) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))])
        * np.sqrt(2.0)
        + 1,
        6,
    )
    x[10, 0] += units * 1e-5
    joined = np.kron(np.eye(2), 25 * np.eye(24) - np.ones((24, 24)))
    labels = [[node, direction] for node in range(1, 17) for direction in (1, 2, 3)]
    job = fo.readers.MatrixJob(joined, labels, dict(enumerate(x.tolist(), 1)))
    pairs = np.column_stack([np.arange(4, 8), np.arange(8, 12)])
    ask = {
        "loads": {"P": np.ones(48)},
        "pairs": pairs,
        "normals": [0.0, 0.0, 1.0],
        "unknowns": job.unknowns,
        "points": job.points,
    }
    if found == 4:
        assert not fo.condense(job.K, **ask).gap.any()
    else:
        with pytest.raises(fo.ModelError, match="lie 3e-05 apart"):
            fo.condense(job.K, **ask)


def test_a_computed_zero_hides_no_digits():
    """Meshers write numbers of seven digits, and many digits of 1e-17 where they computed a zero."""
    x = digits(np.random.default_rng(0).uniform(-1.0, 1.0, size=(50, 3)), 7)
    x[:3] = 0.0
    computed = np.where(x == 0, np.array([1.7320508075689e-17, -3.1622776601684e-18, 1e-16 / 7]), x)
    errors = coordinate_errors(computed)
    assert errors[3:] == pytest.approx(coordinate_errors(x)[3:], rel=1e-12)
    assert errors.max() < 1e-7


def test_turned_and_round_coordinates_have_no_digits():
    x = np.random.default_rng(0).uniform(-1.0, 1.0, size=(50, 2))
    assert coordinate_errors(x).max() == pytest.approx(5e-10 * np.ptp(x, axis=0).max())
    assert coordinate_errors(np.round(x, 3)).max() == pytest.approx(
        5e-10 * np.ptp(np.round(x, 3), axis=0).max()
    )
    assert measured(np.array([1.0, 0.5]), np.array([1.0 + 1e-6, 1.0])).tolist() == [1.0, 0.0]
