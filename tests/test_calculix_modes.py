"""Masses and modes of CalculiX: those of the glued job from its matrices, and the damping that comes of them."""

import numpy as np
import pytest
from scipy.linalg import eigh

import frictopt as fo
from calculix import equation, needs_ccx, run
from test_calculix import condensed, plane

pytestmark = needs_ccx


def glued_modes(job, pairs):
    """Squares of the angular frequencies, and shapes of the modes of a job with its pairs glued, one a column, from K and M."""
    rows = np.arange(len(job.labels))
    one, two = job.unknowns[pairs].transpose(1, 0, 2)
    rows[one] = rows[two]
    _, glued = np.unique(rows, return_inverse=True)
    T = np.eye(glued.max() + 1)[glued]
    squares, modes = eigh(T.T @ job.K @ T, T.T @ job.M @ T)
    return squares, T @ modes


PRINT = "*FREQUENCY\n3\n*NODE PRINT, NSET=ALL\nU\n"


@pytest.mark.parametrize("thickness", ["1.", "4."])
def test_from_the_deck_to_the_backbone(tmp_path, thickness):
    """Matrices of the separate bodies, modes of the deck with equations; in between nothing but the files."""
    _, pairs, deck = plane(thickness=thickness)
    job = fo.read_calculix(run(tmp_path, deck)[0])
    equations = "".join(equation((a, k, 1.0), (b, k, -1.0)) for a, b in pairs for k in (1, 2))
    frequencies, shapes = job.modes(f"{run(tmp_path, deck + equations, PRINT, 'glued')[0]}.dat")
    squares, modes = glued_modes(job, job.pairs("CU", "CL"))
    assert frequencies == pytest.approx(np.sqrt(squares[:3]) / (2 * np.pi), rel=1e-6)
    sizes = np.sqrt(np.einsum("mi,mi->m", shapes @ job.M, shapes))
    assert np.abs(np.einsum("mi,im->m", shapes @ job.M, modes[:, :3])) / sizes == pytest.approx([1.0] * 3, rel=1e-9)
    system, _ = condensed(job)
    load = fo.modal_load(job.M, shapes[0])
    joint = fo.condense(job.K, {"P": job.force("TOP", pressure=1.0), "mode": load}, job.pairs("CU", "CL"), [0.0, 1.0], job.unknowns, job.points)
    assert np.allclose(joint.S, system.S) and joint.compliance[1, 1] == pytest.approx((2 * np.pi * frequencies[0]) ** -2, rel=1e-6)
    cycle = fo.LoadCycle({"P": 1.0}, [{"mode": 1.0}, {"mode": -1.0}])
    limit = fo.shakedown_limit(joint, cycle, 0.5).load_factor
    curve = fo.damping_curve(joint, cycle, 0.5, [0.5 * limit, 1.04 * limit], natural_frequency=frequencies[0])
    assert curve.frequency[1] < curve.frequency[0] <= curve.natural_frequency == pytest.approx(frequencies[0], rel=1e-6)
    assert curve.damping[1] > 0 and curve.least_damping[0] == 0
    with pytest.raises(fo.ModelError, match=r"natural_frequency: .* and the compliance of the load says"):
        fo.damping_curve(joint, cycle, 0.5, [limit], natural_frequency=frequencies[1])


def test_a_rigid_tool_has_its_mass(tmp_path):
    """The rotation of a rigid part has its mass, and its part in the modes that CalculiX prints, by the displacements of its nodes."""
    _, pairs, deck = plane()
    deck = deck.replace("*ELEMENT", "2000, 1.5, 2.5, 0.0\n*ELEMENT", 1) + "*RIGID BODY, NSET=TOP, REF NODE=2000\n"
    job = fo.read_calculix(run(tmp_path, deck)[0])
    equations = "".join(equation((a, k, 1.0), (b, k, -1.0)) for a, b in pairs for k in (1, 2))
    frequencies, shapes = job.modes(f"{run(tmp_path, deck + equations, PRINT, 'glued')[0]}.dat")
    squares, modes = glued_modes(job, job.pairs("CU", "CL"))
    assert frequencies == pytest.approx(np.sqrt(squares[:3]) / (2 * np.pi), rel=1e-6)
    assert shapes[0] * np.sign(shapes[0] @ job.M @ modes[:, 0]) == pytest.approx(modes[:, 0], abs=1e-6 * np.abs(modes[:, 0]).max())


def test_a_mass_of_another_size_is_refused():
    job = fo.read_calculix("tests/data/flat")
    for odd in (job.M[:3, :3], "M"):
        with pytest.raises(fo.ModelError, match=r"^M: "):
            fo.MatrixJob(job.K, job.labels, job.deck, odd)
