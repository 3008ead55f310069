"""Displacements under our forces by the matrix of CalculiX, against those that it computes itself under its own loads."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import frictopt as fo
from calculix import Block, chained, displacements, equation, lines, needs_ccx, node_set, run

pytestmark = needs_ccx

REFERENCE, ROTATION = "2000, 1.5, 1., 3.\n", "2001, 0., 0., 0.\n"
TOP_OF_NODES = "*SURFACE, NAME=ON_TOP, TYPE=NODE\nTOP\n"
RIGID = {
    "free": ("*RIGID BODY, NSET=TOP, REF NODE=2000\n", REFERENCE),
    "with a node for the rotation": ("*Rigid body, Nset=Top, Ref node=2000, Rot node=2001\n", REFERENCE + ROTATION),
    "that does not turn": ("*RIGID BODY, NSET=TOP, REF NODE=2000, ROT NODE=2001\n*BOUNDARY\n2001, 1, 3\n", REFERENCE + ROTATION),
    "that turns about one axis": ("*RIGID BODY, NSET=TOP, REF NODE=2000, ROT NODE=2001\n*BOUNDARY\n2001, 2, 3\n2000, 1\n", REFERENCE + ROTATION),
    "led by a node of the mesh": ("*RIGID BODY, NSET=TOP, REF NODE=503\n", ""),
    "by a coupling": (TOP_OF_NODES + "*COUPLING, REF NODE=2000, SURFACE=ON_TOP, CONSTRAINT NAME=C\n*KINEMATIC\n1, 3\n", REFERENCE),
    "of which a node follows another": (equation((530, 1, 1.0), (514, 1, -1.0)) + "*RIGID BODY, NSET=TOP, REF NODE=2000\n", REFERENCE),
    "none": ("", ""),
    "by equations": ("".join(equation(*terms) for terms in chained(range(525, 537), 3)), ""),
}


@pytest.mark.parametrize("kind", RIGID)
def test_displacements_under_our_forces_are_those_of_a_static_step(tmp_path, kind):
    """Forces on nodes that follow a rigid part, on the part itself and on others; a pressure on its face."""
    rule, nodes = RIGID[kind]
    block = Block(501, lines((0, 3, 3), (0, 2, 2), (0, 2, 2)), 500.0, 0.2, "B")
    top, bottom = block.on(2, 2), block.on(2, 0)
    deck = block.deck().replace("*ELEMENT", nodes + "*ELEMENT", 1) + node_set("TOP", top) + f"{node_set('BOT', bottom)}*BOUNDARY\nBOT, 1, 3\n{rule}"
    loaded = [int(top[-1]), 530, 520, 2000 if REFERENCE in nodes else 521]
    job = fo.read_calculix(run(tmp_path, deck)[0])
    row = {int(n): i for i, n in enumerate(job.deck.numbers)}
    force = job.force([row[n] for n in loaded], nodal=[1.0, 0.5, -3.0]) + job.force("TOP", pressure=0.7)
    found = spsolve(job.K.tocsc(), force)
    elements = [block.first + i for i, nodes in enumerate(block.elements) if np.isin(block.numbers[nodes[4:]], top).all()]
    loads = "*CLOAD\n" + "".join(f"{n}, {k}, {f}\n" for n in loaded for k, f in ((1, 1.0), (2, 0.5), (3, -3.0)))
    known = displacements(tmp_path, deck, loads + "*DLOAD\n" + "".join(f"{i}, P2, 0.7\n" for i in elements))
    moves = np.isin(np.arange(len(found)), job.unknowns)
    known = np.array([known[node][direction - 1] for node, direction in job.labels[moves]])
    assert np.abs(found[moves] - known).max() < 1e-6 * np.abs(known).max()  # CalculiX prints seven digits
