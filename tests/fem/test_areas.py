"""Areas of the nodes on faces of decks.

They are compared with areas by hand and with the forces of a uniform pressure.
"""

import numpy as np
import pytest
from skfem import MeshHex, MeshTet

import frictopt as fo
from helpers.calculix import Block, deck, node_set, run
from helpers.quadratic import arched, two_boxes

GRID = [0.0, 0.2, 0.7, 1.0], [0.0, 0.5, 2.0]


def halves(line):
    return np.convolve(np.diff(line), [0.5, 0.5])


@pytest.fixture
def bricks(tmp_path):
    """Two blocks of bricks of different sizes, 1 x 2, one on the other, and their job."""
    low, up = (
        Block(first, [*map(np.array, GRID), np.array(z)], 1000.0, 0.3, name)
        for first, z, name in ((1, [-1.0, 0.0], "LOW"), (101, [0.0, 1.0], "UP"))
    )
    sets = (
        node_set("CU", up.on(2, 0))
        + node_set("CL", low.on(2, 0))
        + node_set("TOP", up.on(2, 1))
        + node_set("BOT", low.on(2, -1))
    )
    return fo.readers.read_calculix(
        run(tmp_path, f"{up.deck()}{low.deck()}{sets}*BOUNDARY\nBOT, 1, 3\n")[0]
    )


@pytest.mark.ccx
def test_the_areas_of_bricks_are_products_of_half_sides_in_the_order_of_the_pairs(bricks):
    pairs = bricks.pairs("CU", "CL")
    areas = bricks.areas(pairs[:, 1])
    points = bricks.points[pairs[:, 1]]
    by_hand = [
        halves(GRID[0])[GRID[0].index(x)] * halves(GRID[1])[GRID[1].index(y)] for x, y, _ in points
    ]
    assert areas == pytest.approx(by_hand, rel=1e-12) and areas.sum() == pytest.approx(2.0)
    backwards = pairs[::-1, 0]
    assert bricks.areas(backwards) == pytest.approx(by_hand[::-1], rel=1e-12)
    assert np.sort(bricks.areas("CL")) == pytest.approx(np.sort(by_hand))
    assert not areas.flags.writeable


def test_a_plane_face_has_the_lengths_that_condense_finds(flat):
    pairs = flat.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    system = fo.condense(
        flat.K,
        {"P": flat.force("N_TOP", pressure=1.0)},
        pairs,
        [0.0, 1.0],
        flat.unknowns,
        flat.points,
    )
    assert np.allclose(flat.areas(pairs[:, 1]), system.width, rtol=1e-12)


@pytest.mark.ccx
@pytest.mark.parametrize("kind", ["C3D10", "C3D20"])
def test_faces_of_quadratic_elements_give_their_corners_what_a_uniform_pressure_does(
    tmp_path, kind
):
    bodies = two_boxes(
        {"C3D10": MeshTet, "C3D20": MeshHex}[kind], fo.fem.Material(2.0, 0.3), bulge=None
    )
    job = fo.readers.read_calculix(run(tmp_path, deck(bodies, kind))[0]).with_linear_faces(
        "CU", "CL"
    )
    nodes = job.pairs("CU", "CL")[:, 1]
    push = job.force("CL", pressure=1.0)[job.unknowns[nodes]]
    assert job.areas(nodes) == pytest.approx(-push[:, 2], rel=1e-9)
    assert job.areas(nodes).sum() == pytest.approx(1.0)


@pytest.mark.ccx
def test_a_curved_face_has_the_area_of_the_facets_through_its_corners(tmp_path):
    """A mesh of the package with the same elements has the same area."""
    bodies = two_boxes(MeshTet, fo.fem.Material(2.0, 0.3), bulge=arched)
    job = fo.readers.read_calculix(run(tmp_path, deck(bodies, "C3D10"))[0]).with_linear_faces(
        "CU", "CL"
    )
    nodes = job.pairs("CU", "CL")[:, 1]
    model_system = fo.fem.ContactModel(
        bodies, [fo.fem.Support("lower", "far")], {"P": [fo.fem.Pressure("upper", "far")]}
    ).condense()
    place = [
        np.linalg.norm(model_system.points - point, axis=1).argmin() for point in job.points[nodes]
    ]
    assert job.areas(nodes) == pytest.approx(model_system.width[place], rel=1e-9)


def test_bad_faces_are_named(flat):
    with pytest.raises(
        fo.ModelError, match=r"nodes: no facet of the outline lies between these nodes \(1\)"
    ):
        flat.areas([0])
    with pytest.raises(fo.ModelError, match="node set 'none': unknown"):
        flat.areas("none")
    top = flat.nodes("N_TOP")
    with pytest.raises(fo.ModelError, match="lies on no facet of the outline between these nodes"):
        flat.areas(np.r_[top, np.setdiff1d(flat.nodes("N_BOTTOM"), top)[:1]])
