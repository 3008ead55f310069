"""Quadratic elements in decks of CalculiX.

They are compared with uniform stress, meshes of the package with the same elements, static steps,
and rigid motions.
"""

import re

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from skfem import MeshTri

import frictopt as fo
from helpers.calculix import KINDS, NODES, deck, displacements, elements, run
from helpers.quadratic import dimensions, two_boxes

pytestmark = pytest.mark.ccx


def condensed(job, load, direction):
    pairs = job.pairs("CU", "CL")
    return fo.condense(job.K, {"P": load(job)}, pairs, direction, job.unknowns, job.points)


@pytest.mark.parametrize("kind", NODES)
def test_a_uniform_pressure_gives_each_corner_its_share(tmp_path, kind):
    """No lateral strain: the stress is uniform, though the bottom is held."""
    d, material = dimensions(KINDS[kind]), fo.fem.Material(2.0, 0.0)
    bodies = two_boxes(KINDS[kind], material, bulge=None)
    job = fo.readers.read_calculix(run(tmp_path, deck(bodies, kind))[0])
    tied = job.with_linear_faces("CU", "CL")
    system = condensed(tied, lambda job: job.force("TOP", pressure=1.0), np.eye(d)[-1])
    reference = fo.fem.ContactModel(
        bodies, [fo.fem.Support("lower", "far")], {"P": [fo.fem.Pressure("upper", "far")]}
    ).condense()
    place = [np.linalg.norm(reference.points - point, axis=1).argmin() for point in system.points]
    q, p = system.bonded["P"]
    assert np.allclose(p, reference.width[place], rtol=0, atol=1e-10) and np.abs(q).max() < 1e-10
    assert tied.force("TOP", pressure=1.0).sum() == pytest.approx(-1.0)
    assert len(system.points) == 3 ** (d - 1)
    # On the corners, which the nodes amid edges follow.
    assert tied.force("CU", pressure=1.0).sum() == pytest.approx(1.0)
    assert np.allclose(tied.normals(tied.pairs("CU", "CL")[:, 1]), np.eye(d)[-1])
    assert len(tied.normals("CU")) == 3 ** (d - 1)


@pytest.mark.parametrize("kind", ["CPE8", "C3D20", "C3D10"])
def test_displacements_under_our_forces_are_those_of_a_static_step(tmp_path, kind):
    """A traction on a face becomes nodal forces of the elements of CalculiX, whose own step has the
    pressure P on element faces."""
    d = dimensions(KINDS[kind])
    bodies = two_boxes(KINDS[kind], fo.fem.Material(2.0, 0.3), bulge=None)
    text = deck(bodies, kind) + "*BOUNDARY\nCU, 1, 3\nCL, 1, 3\n"
    job = fo.readers.read_calculix(base := run(tmp_path, text)[0])
    found = spsolve(job.K.tocsc(), job.force("TOP", pressure=0.7))
    top = set(job.deck.numbers[job.nodes("TOP")].tolist())
    faces = {  # P-number -> corners, as the manual of CalculiX counts them
        8: {1: (0, 1), 2: (1, 2), 3: (2, 3), 4: (3, 0)},
        10: {1: (0, 1, 2), 2: (0, 3, 1), 3: (1, 3, 2), 4: (2, 3, 0)},
        20: {
            1: (0, 1, 2, 3),
            2: (4, 7, 6, 5),
            3: (0, 4, 5, 1),
            4: (1, 5, 6, 2),
            5: (2, 6, 7, 3),
            6: (3, 7, 4, 0),
        },
    }[NODES[kind]]
    rows = enumerate((elements(bodies["upper"].mesh, kind) + 1).tolist(), 1)
    loads = [
        (i, face)
        for i, row in rows
        for face, corners in faces.items()
        if {row[c] for c in corners} <= top
    ]
    (tmp_path / "faces.inp").write_text(
        text + "*SURFACE, NAME=Faces\n" + "".join(f"{i}, S{face}\n" for i, face in loads)
    )
    by_faces = fo.readers.read_calculix(base, deck=tmp_path / "faces.inp")
    assert np.array_equal(np.sort(by_faces.nodes("faces")), np.sort(job.nodes("TOP")))
    assert np.array_equal(by_faces.force("faces", pressure=0.7), job.force("TOP", pressure=0.7))
    known = displacements(
        tmp_path, text, "*DLOAD\n" + "".join(f"{i}, P{face}, 0.7\n" for i, face in loads)
    )
    known = np.array([known[node][direction - 1] for node, direction in job.labels])
    assert len(loads) == (2 if d == 2 else 8 if kind == "C3D10" else 4)
    assert np.abs(found - known).max() < 1e-6 * np.abs(known).max()


def test_faces_with_free_midside_nodes_make_no_pairs(tmp_path):
    bodies = two_boxes(MeshTri, fo.fem.Material(), bulge=None)
    job = fo.readers.read_calculix(run(tmp_path, deck(bodies, "CPE6"))[0])
    message = r"node \d+, a midside node of a contact face, does not follow its corners; name both faces in job.with_linear_faces"
    for ask in (
        lambda: job.pairs("CU", "CL"),
        lambda: job.with_linear_faces("CU", "CU").pairs("CU", "CL"),
    ):
        with pytest.raises(fo.ModelError, match=message):
            ask()
    numbers = job.deck.numbers[np.setdiff1d(job.nodes("CU"), job.deck.midsides)]
    corners = np.isin(job.labels[:, 0], numbers) | ~np.isin(
        job.labels[:, 0], job.deck.numbers[job.nodes("CU")]
    )
    with pytest.raises(
        fo.ModelError,
        match=r"node \d+, a midside node of a contact face, has no row in the matrix; retain such nodes",
    ):
        fo.readers.MatrixJob(job.K[corners][:, corners], job.labels[corners], job.deck).pairs(
            "CU", "CL"
        )
    with pytest.raises(
        fo.ModelError,
        match=re.escape(
            "nodes: no facet of the outline lies between these nodes (1); give the nodes of a face"
        ),
    ):
        job.with_linear_faces([0], "CL")
    corner = int(job.deck.numbers[job.nodes("CU")].min())
    rule = f"*EQUATION\n2\n{corner}, 1, 1., {job.deck.numbers[job.nodes('TOP')].max()}, 1, -1.\n"
    (tmp_path / "chained").mkdir()
    chained = fo.readers.read_calculix(run(tmp_path / "chained", deck(bodies, "CPE6") + rule)[0])
    with pytest.raises(
        fo.ModelError, match=rf"with_linear_faces: corner node {corner} follows others"
    ):
        chained.with_linear_faces("CU", "CL")
