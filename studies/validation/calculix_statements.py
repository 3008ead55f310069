"""Statements about the matrices and the contact of CalculiX, each checked by small decks.

A matrix of CalculiX is the file of a step `*FREQUENCY, SOLVER=MATRIXSTORAGE`.
"""

import os
import re
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]

MATERIAL = "*MATERIAL, NAME=M\n*ELASTIC\n1000., .3\n*DENSITY\n1.\n"
STORE = "*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*END STEP\n"
STEP = f"*STEP\n{STORE}"
_TOTAL = re.compile(r"total force.*?time\s+(\S+)\s*\n\s*\n\s+(\S+)\s+(\S+)\s+(\S+)")


class Job:
    """Decks that CalculiX runs in one folder."""

    def __init__(self, folder: Path, seconds: float) -> None:
        self.folder = folder
        self.seconds = seconds

    def run(self, deck: str) -> str:
        """Run a deck, and return the output of CalculiX; the text is empty if CalculiX is stopped."""
        for path in self.folder.iterdir():
            path.unlink()
        (self.folder / "job.inp").write_text(deck, encoding="utf-8")
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        try:
            done = subprocess.run(
                ["ccx", "-i", "job"],
                cwd=self.folder,
                env=environment,
                capture_output=True,
                text=True,
                timeout=self.seconds,
            )
        except subprocess.TimeoutExpired:
            return ""
        return done.stdout

    def matrix(self, deck: str) -> tuple[list[tuple[int, int]], Array]:
        """Labels (node, direction) of a stored stiffness, and the stiffness."""
        self.run(deck)
        lines = (self.folder / "job.dof").read_text(encoding="utf-8").splitlines()
        labels = [tuple(map(int, line.strip().split("."))) for line in lines]
        K = np.zeros((len(labels),) * 2)
        row, column, value = np.loadtxt(self.folder / "job.sti", unpack=True)
        i = row.astype(int) - 1
        j = column.astype(int) - 1
        K[i, j] = value
        K[j, i] = value
        return [(node, direction) for node, direction in labels], K

    def totals(self) -> Array:
        """(m, 4) time and total force (x, y, z) of each `*NODE PRINT` of the deck."""
        printed = (self.folder / "job.dat").read_text(encoding="utf-8")
        totals = [[float(word) for word in found.groups()] for found in _TOTAL.finditer(printed)]
        return np.array(totals).reshape(-1, 4)


def version() -> str:
    """The version of `ccx`."""
    said = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout
    found = re.search(r"Version (\S+)", said)
    return found[1] if found else "unknown"


def _cube(first: int, bottom: float, name: str) -> str:
    """A cube of one brick, with nodes and element numbered from `first`."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    places = [(x, y, bottom + z) for z in (0.0, 1.0) for x, y in corners]
    nodes = "".join(f"{first + i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(places))
    numbers = ", ".join(str(first + i) for i in range(8))
    return (
        f"*NODE, NSET=N{name}\n{nodes}*ELEMENT, TYPE=C3D8, ELSET={name}\n{first}, {numbers}\n"
        f"*SOLID SECTION, ELSET={name}, MATERIAL=M\n"
    )


HELD = "*BOUNDARY\n1, 1, 3\n2, 1, 3\n3, 1, 3\n4, 1, 3\n"
TWO_CUBES = MATERIAL + _cube(1, 0.0, "LO") + _cube(11, 1.0, "UP")
PAIR = (
    "*SURFACE, NAME=A\n11, S1\n*SURFACE, NAME=B\n1, S2\n*SURFACE INTERACTION, NAME=I\n"
    "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1e5, 1.\n"
    "*CONTACT PAIR, INTERACTION=I, TYPE=NODE TO SURFACE\nA, B\n"
)


def _change(one: Array, other: Array) -> float:
    """The largest change of an entry, relative to the largest entry."""
    return float(np.abs(other - one).max() / np.abs(one).max())


def statements(job: Job) -> Iterator[Mapping[str, Any]]:
    """A row for each statement: the number that was seen, and whether the statement holds."""
    yield from _of_matrices(job)
    yield from _of_sectors(job)
    yield from _of_substructures(job)
    yield from _of_contacts(job)


def _of_matrices(job: Job) -> Iterator[Mapping[str, Any]]:
    """Rows about the matrices of one body and of two bodies."""
    labels, K = job.matrix(TWO_CUBES + HELD + STEP)
    held = [label for label in labels if label[0] <= 4]
    yield _row("Rows of held displacements", "number", len(held), not held)

    _, other = job.matrix(TWO_CUBES + PAIR + HELD + STEP)
    change = _change(K, other)
    yield _row("`*CONTACT PAIR`, plain step", "change of the matrix", change, change == 0)
    _, other = job.matrix(TWO_CUBES + PAIR + HELD + f"*STEP, PERTURBATION\n{STORE}")
    change = _change(K, other)
    yield _row("`*CONTACT PAIR`, `PERTURBATION`", "change of the matrix", change, change > 0.1)

    turned = "*TRANSFORM, NSET=NUP, TYPE=R\n0., 1., 0., -1., 0., 0.\n"
    _, other = job.matrix(TWO_CUBES + HELD + turned + STEP)
    change = _change(K, other)
    yield _row("`*TRANSFORM` of nodes", "change of the matrix", change, change == 0)

    follows = "*EQUATION\n2\n11, 1, 1., 5, 1, -1.\n"
    labels, _ = job.matrix(TWO_CUBES + HELD + follows + STEP)
    count = labels.count((11, 1))
    yield _row("Rows of the first term of `*EQUATION`", "number", count, count == 0)

    ring = (
        "*NODE\n1, 1., 0., 0.\n2, 2., 0., 0.\n3, 2., 1., 0.\n4, 1., 1., 0.\n"
        "*ELEMENT, TYPE=CAX4, ELSET=E\n1, 1, 2, 3, 4\n*SOLID SECTION, ELSET=E, MATERIAL=M\n"
        "*BOUNDARY\n1, 2, 2\n2, 2, 2\n"
    )
    labels, K = job.matrix(MATERIAL + ring + STEP)
    lifted = np.array([float(direction == 2) for _, direction in labels])
    # A strain of 1 along the axis, in a ring of radii 1 and 2 and height 1.
    whole = 2 * np.pi * 1.5 * 1000 * 0.7 / (1.3 * 0.4)
    ratio = whole / float(lifted @ K @ lifted)
    expected = 2 * np.pi / np.sin(np.radians(2.0))
    yield _row("Whole ring / matrix of `CAX4`", "ratio", ratio, abs(ratio / expected - 1) < 1e-6)

    shell = (
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n"
        "*ELEMENT, TYPE=S4, ELSET=E\n1, 1, 2, 3, 4\n*SHELL SECTION, ELSET=E, MATERIAL=M\n.1\n"
        "*BOUNDARY\n1, 1, 3\n2, 1, 3\n"
    )
    labels, _ = job.matrix(MATERIAL + shell + STEP)
    made = len({node for node, _ in labels if node > 4})
    yield _row("Nodes of an `S4` that are not in the deck", "number", made, made > 0)

    def square(number: str) -> str:
        return (
            f"{MATERIAL}*NODE\n1, 0., 0., 0.\n2, {number}, 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n"
            "*ELEMENT, TYPE=CPE4, ELSET=E\n1, 1, 2, 3, 4\n*SOLID SECTION, ELSET=E, MATERIAL=M\n1.\n"
            f"*BOUNDARY\n1, 1, 2\n{STEP}"
        )

    _, short = job.matrix(square("1."))
    _, long = job.matrix(square("1.000000000000000000e+01"))
    change = _change(short, long)
    yield _row("1.000000000000000000e+01 read as 1", "change of the matrix", change, change == 0)


def _of_sectors(job: Job) -> Iterator[Mapping[str, Any]]:
    """Rows about a sector of a ring: a brick between the radii 1 and 2, one of twelve."""
    angle = np.radians(30.0)
    flat = [(r * np.cos(t), r * np.sin(t)) for r, t in ((1, 0), (2, 0), (2, angle), (1, angle))]
    places = [(x, y, z) for z in (0.0, 1.0) for x, y in flat]
    nodes = "".join(f"{i}, {x:.12f}, {y:.12f}, {z}\n" for i, (x, y, z) in enumerate(places, 1))
    deck = (
        f"{MATERIAL}*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
        "*SOLID SECTION, ELSET=E, MATERIAL=M\n*SURFACE, NAME=LEADS\n1, S3\n"
        "*SURFACE, NAME=FOLLOWS\n1, S5\n"
        "*TIE, CYCLIC SYMMETRY, NAME=T, POSITION TOLERANCE=.01\nFOLLOWS, LEADS\n"
        "*CYCLIC SYMMETRY MODEL, N=12, TIE=T\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n1, 3, 3\n"
    )
    labels, K = job.matrix(deck + STEP)
    following = [label for label in labels if label[0] in (3, 4, 7, 8)]
    count = len(following)
    yield _row("Rows of the face of a cyclic sector that follows", "number", count, count == 0)

    # In the nodal diameter 0 all sectors move alike, so a turn about the axis costs no energy.
    turn = np.array([(-places[n - 1][1], places[n - 1][0], 0.0)[d - 1] for n, d in labels])
    energy = float(turn @ K @ turn) / float(turn @ turn) / float(np.abs(K).max())
    yield _row("Turn of a cyclic sector about its axis", "energy", energy, abs(energy) < 1e-9)

    chosen = "1\n*SELECT CYCLIC SYMMETRY MODES, NMIN=1, NMAX=1\n*END STEP\n"
    job.run(f"{deck}*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n{chosen}")
    lines = len((job.folder / "job.dof").read_text(encoding="utf-8").split())
    rows = np.loadtxt(job.folder / "job.sti")[:, :2].max() / lines
    yield _row("Rows / labels with `*SELECT CYCLIC SYMMETRY MODES`", "ratio", rows, rows == 2)


def _of_substructures(job: Job) -> Iterator[Mapping[str, Any]]:
    """A row about the matrix of a substructure: a cube with two retained nodes."""
    deck = MATERIAL + _cube(1, 0.0, "LO") + HELD
    labels, K = job.matrix(deck + STEP)
    retained = [(node, direction) for node in (5, 6) for direction in (1, 2, 3)]
    dofs = "".join(f"{node}, {direction}\n" for node, direction in retained)
    job.run(
        f"{deck}*STEP\n*SUBSTRUCTURE GENERATE\n*RETAINED NODAL DOFS\n{dofs}"
        "*SUBSTRUCTURE MATRIX OUTPUT, FILE NAME=reduced, STIFFNESS=YES\n*END STEP\n"
    )
    text = (job.folder / "reduced.mtx").read_text(encoding="utf-8")
    words = re.split(r"[,\s]+", text.split("*MATRIX,TYPE=STIFFNESS")[1].strip(" ,\n"))
    stored = np.array([float(word) for word in words])
    rows = [labels.index(label) for label in retained]
    whole = K[np.ix_(rows, rows)][np.tril_indices(len(rows))]
    difference = _change(whole, stored)
    yield _row(
        "`*SUBSTRUCTURE GENERATE`: rows and columns of the whole matrix",
        "change of the matrix",
        difference,
        difference < 1e-9,
    )


def _of_contacts(job: Job) -> Iterator[Mapping[str, Any]]:
    """Rows about the contact of two cubes; the upper cube is pressed, and then moved."""
    linear = "LINEAR\n1e5, 1."
    first = "*MATERIAL, NAME=SOFT\n*ELASTIC\n10., .3\n"
    for name in ("NODE TO SURFACE", "SURFACE TO SURFACE"):
        of_none = _forces(job, first + TWO_CUBES, name, linear, ".5\n")
        of_half = _forces(job, first + TWO_CUBES, name, linear, ".5, 5.\n")
        of_other = _forces(job, TWO_CUBES, name, linear, ".5\n")
        shear = of_none[-1, 1]
        change = abs(float(of_half[-1, 1] / shear) - 1)
        holds = change < 1e-9 and abs(of_other[-1, 1] / shear) > 10
        where = f"`*FRICTION` without stick slope, {name.lower()}: E / 2 of the first material"
        yield _row(where, "change of the shear force", change, holds)

    table = "TABULAR\n0., 0.\n100., 1e-3"
    at_nodes = _forces(job, TWO_CUBES, "NODE TO SURFACE", table)[-1, 3]
    at_faces = _forces(job, TWO_CUBES, "SURFACE TO SURFACE", table)[-1, 3]
    share = abs(float(at_faces / at_nodes))
    yield _row(
        "`PRESSURE-OVERCLOSURE=TABULAR`, surface to surface: no contact",
        "force / that of node to surface",
        share,
        share < 1e-9,
    )


def _forces(job: Job, cubes: str, name: str, behaviour: str, friction: str = "") -> Array:
    """(m, 4) time and forces at the top of two cubes, pressed by 0.002 and moved by 0.0002."""
    text = (
        f"{cubes}*SURFACE, NAME=A\n11, S1\n*SURFACE, NAME=B\n1, S2\n"
        f"*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE={behaviour}\n"
    )
    text += f"*FRICTION\n{friction}" if friction else ""
    text += f"*CONTACT PAIR, INTERACTION=I, TYPE={name}\nA, B\n{HELD}"
    text += "*NSET, NSET=TOP\n15, 16, 17, 18\n"
    for x in (0.0, 0.0002):
        text += (
            f"*STEP, INC=1000\n*STATIC\n1., 1.\n*BOUNDARY\nTOP, 1, 1, {x}\nTOP, 2, 2, 0.\n"
            "TOP, 3, 3, -.002\n*NODE PRINT, NSET=TOP, TOTALS=ONLY\nRF\n*END STEP\n"
        )
    job.run(text)
    return job.totals()


def _row(statement: str, what: str, number: float, holds: bool) -> dict[str, Any]:
    return {
        "statement": statement,
        "what": what,
        "number": float(number),
        "holds": bool(holds),
        "version": version(),
        "residual": 0.0,
    }
