"""Matrices of axisymmetric decks: forces and areas of the whole circumference, beside CalculiX."""

import numpy as np
import pytest

import frictopt as fo
from helpers.calculix import displacements, run

PLACES = [(1, 0), (1.5, 0), (2.2, 0), (1, 0.7), (1.5, 0.7), (2.2, 0.7)]
DECK = (
    "*NODE, NSET=ALL\n"
    + "".join(f"{i}, {x}, {y}\n" for i, (x, y) in enumerate(PLACES, 1))
    + "*ELEMENT, TYPE=CAX4, ELSET=QUAD\n1, 1, 2, 5, 4\n*ELEMENT, TYPE=CAX3, ELSET=TRI\n3, 2, 3, 6\n4, 2, 6, 5\n"
    "*ELSET, ELSET=E\nQUAD, TRI\n*MATERIAL, NAME=M\n*ELASTIC\n2.1, 0.3\n*DENSITY\n1.\n*SOLID SECTION, ELSET=E, MATERIAL=M\n"
    "*NSET, NSET=TOP\n4, 5, 6\n*NSET, NSET=BORE\n1, 4\n*BOUNDARY\n1, 2\n2, 2\n3, 2\n"
)
QUADS = DECK.replace(
    "TYPE=CAX3, ELSET=TRI\n3, 2, 3, 6\n4, 2, 6, 5", "TYPE=CAX4, ELSET=TRI\n4, 2, 3, 6, 5"
)
# CalculiX prints displacements of the middle of its sector, and its unknowns are 1 degree beside.
PRINTED = np.array([np.cos(np.radians(1)), 1.0])
LOADS = {
    "axial pressure": ("*DLOAD\nE, P3, 0.4\n", ("TOP", {"pressure": 0.4}), 3e-4),
    "radial pressure": ("*DLOAD\nQUAD, P4, 0.4\n", ("BORE", {"pressure": 0.4}), 3e-4),
    "a node": ("*CLOAD\n6, 2, 3.\n4, 1, 1.\n", None, 2e-6),
}


@pytest.mark.ccx
@pytest.mark.parametrize("load", LOADS)
def test_forces_are_those_of_the_whole_circumference(tmp_path, load):
    """The facets of CalculiX's sector of 2 degrees are flat: pressures differ by 1.5e-4.

    It spreads the pressure on a CAX3 evenly to both nodes, so these decks have CAX4 alone.
    """
    theirs, face, error = LOADS[load]
    text = QUADS if face else DECK
    job = fo.readers.read_calculix(run(tmp_path, text)[0])
    if face:
        force = job.force(face[0], **face[1])
    else:
        force = job.force([5], nodal=[0.0, 3.0]) + job.force([3], nodal=[1.0, 0.0])
    u = np.linalg.solve(job.K.toarray(), force)
    ours = np.where(job.unknowns >= 0, u[job.unknowns], 0.0) * PRINTED
    expected = displacements(tmp_path, text, theirs)
    for number, row in zip(job.deck.numbers, ours, strict=True):
        assert np.allclose(row, expected[int(number)][:2], atol=error * np.abs(ours).max())


@pytest.mark.ccx
def test_areas_and_totals_are_those_of_the_whole_circumference(tmp_path):
    job = fo.readers.read_calculix(run(tmp_path, DECK)[0])
    assert job.areas("TOP").sum() == pytest.approx(np.pi * (2.2**2 - 1), rel=1e-12)
    assert job.areas("BORE").tolist() == pytest.approx([0.7 * np.pi] * 2, rel=1e-12)
    force = job.force("TOP", total=[0.0, -5.0])
    assert force.sum() == pytest.approx(-5.0, rel=1e-12)
    assert np.allclose(force, job.force("TOP", pressure=5.0 / job.areas("TOP").sum()))
    mixed = DECK.replace("TYPE=CAX3", "TYPE=CPE3")
    (tmp_path / "job.inp").write_text(mixed)
    with pytest.raises(fo.ModelError, match=r"elements CAX4, CPE3; give plane elements or axi"):
        fo.readers.read_calculix(tmp_path / "job")


def test_a_negative_radius_is_named(tmp_path):
    """A matrix file of Abaqus has a deck whose section lies on both sides of the axis."""
    rows = [(node, axis) for node in range(1, 7) for axis in (1, 2)]
    lines = [
        f"{n}, {i}, {m}, {j}, {2.0 if (n, i) == (m, j) else 0.1}" for n, i in rows for m, j in rows
    ]
    (tmp_path / "job.mtx").write_text("\n".join(lines))
    (tmp_path / "job.inp").write_text(DECK.replace("\n4, 1, 0.7\n", "\n4, -0.25, 0.7\n"))
    job = fo.readers.read_abaqus(tmp_path / "job.mtx", deck=tmp_path / "job.inp")
    radius = r"x = -0.25 at node 4 of an axisymmetric element; x is its radius, >= 0"
    for question in (lambda: job.areas("TOP"), lambda: job.force("TOP", pressure=1.0)):
        with pytest.raises(fo.ModelError, match=radius):
            question()
