"""CalculiX beside frictopt: what its stored matrices hold, and what its contact does.

Run with `python -m studies calculix [--quick]`; it needs `ccx` and prints two tables in Markdown.
The first table checks statements about matrices, each by small decks. The second table follows
three histories of a block on a block, by displacements of its top, with the contact formulations
of CalculiX and with frictopt on the same mesh.
"""

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from skfem import MeshQuad

import frictopt as fo
from studies.progress import each
from studies.tables import Study, Table, markdown

Array = np.ndarray[Any, Any]

MATERIAL = "*MATERIAL, NAME=M\n*ELASTIC\n1000., .3\n*DENSITY\n1.\n"
STORE = "*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*END STEP\n"
STEP = f"*STEP\n{STORE}"
# Formulation in CalculiX -> its type in `*CONTACT PAIR`.
FORMULATIONS = {
    "node to surface": "NODE TO SURFACE",
    "face to face": "SURFACE TO SURFACE",
    "mortar": "LINMORTAR",
}
OURS = "frictopt"


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    formulations: tuple[str, ...] = tuple(FORMULATIONS)
    histories: tuple[str, ...] = ("closed", "loop", "lands elsewhere")
    elements: int = 2  # along the upper block
    # Stiffness of penalty contact, force per length^3, normal and tangential; E is 1000.
    penalty: float = 1e5
    increments: int = 4  # of each segment of a history
    seconds: float = 300.0  # after which CalculiX is stopped


FULL = Parameters()
QUICK = Parameters(formulations=("node to surface",), histories=("closed",), increments=2)


@dataclass(frozen=True)
class History:
    """Displacements (x, y) of the top of the upper block, from (0, 0), its gap and friction."""

    corners: tuple[tuple[float, float], ...]
    gap: float
    friction: float


PRESS = -0.002
HISTORIES = {
    "closed": History(((0.0, PRESS), (0.0003, PRESS)), 0.0, 0.5),
    "loop": History(((0.0, PRESS), (0.002, PRESS), (-0.002, PRESS), (0.002, PRESS)), 0.0, 0.3),
    "lands elsewhere": History(((0.002, 0.0), (0.002, -0.003)), 0.001, 0.5),
}


class Job:
    """Decks that CalculiX runs in one folder."""

    def __init__(self, folder: Path, seconds: float) -> None:
        self.folder = folder
        self.seconds = seconds

    def run(self, deck: str) -> str:
        """Run a deck; what CalculiX says. The text is empty if it is stopped."""
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


def version() -> str:
    """The version of `ccx`."""
    said = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout
    found = re.search(r"Version (\S+)", said)
    return found[1] if found else "unknown"


def _cube(first: int, bottom: float, name: str) -> str:
    """A cube of one brick, its nodes and its element numbered from `first`."""
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
    """A row for each statement about stored matrices: what was seen, and whether it holds."""
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


def _row(statement: str, what: str, number: float, holds: bool) -> dict[str, Any]:
    return {
        "statement": statement,
        "what": what,
        "number": float(number),
        "holds": bool(holds),
        "version": version(),
        "residual": 0.0,
    }


def matrices(parameters: Parameters) -> Iterator[Mapping[str, Any]]:
    """The rows of `statements`."""
    _check_installed()
    with tempfile.TemporaryDirectory() as folder:
        yield from statements(Job(Path(folder), parameters.seconds))


def _check_installed() -> None:
    if shutil.which("ccx") is None:
        raise fo.ModelError("ccx: not found; install CalculiX (Debian: calculix-ccx)")


def lines(history: History, parameters: Parameters) -> dict[str, tuple[Array, Array]]:
    """Lines of the mesh of both blocks along x and y."""
    n = parameters.elements
    return {
        "up": (np.linspace(0.0, 2.0, n + 1), history.gap + np.linspace(0.0, 1.0, 3)),
        "lo": (np.linspace(-1.0, 3.0, 2 * n + 1), np.linspace(-1.0, 0.0, 3)),
    }


def deck_of(history: History, formulation: str, parameters: Parameters) -> str:
    """The deck of both blocks, one brick of 0.5 deep, with their contact and all steps."""
    text = MATERIAL
    top: list[int] = []
    bottom: list[int] = []
    for name, first in (("up", 1), ("lo", 1001)):
        x, y = lines(history, parameters)[name]
        grid = np.meshgrid(x, y, [0.0, 0.5], indexing="ij")
        points = np.column_stack([axis.ravel(order="F") for axis in grid])
        number = first + np.arange(len(points)).reshape(grid[0].shape, order="F")
        nodes = [f"{first + i}, " + ", ".join(f"{c:.12g}" for c in p) for i, p in enumerate(points)]
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        ends = [(slice(-1), slice(1, None))[k] for k in (0, 1)]
        corners = [
            number[ends[a], ends[b], ends[c]].ravel(order="F") for c in (0, 1) for a, b in ring
        ]
        rows = np.column_stack([first + np.arange(len(corners[0])), *corners])
        bricks = [", ".join(map(str, row)) for row in rows.tolist()]
        text += f"*NODE, NSET=N{name}\n" + "\n".join(nodes) + "\n"
        text += f"*ELEMENT, TYPE=C3D8, ELSET={name}\n" + "\n".join(bricks) + "\n"
        text += f"*SOLID SECTION, ELSET={name}, MATERIAL=M\n"
        across = len(x) - 1
        of_face = rows[:across, 0] if name == "up" else rows[across : 2 * across, 0]
        face = "S3" if name == "up" else "S5"
        text += f"*SURFACE, NAME=S{name}\n" + "".join(f"{e}, {face}\n" for e in of_face)
        top = number[:, -1].ravel().tolist() if name == "up" else top
        bottom = number[:, 0].ravel().tolist()
    text += "*NSET, NSET=TOP\n" + "".join(f"{n},\n" for n in top)
    text += "*NSET, NSET=BOTTOM\n" + "".join(f"{n},\n" for n in bottom)
    return text + _contact(history, formulation, parameters) + _steps(history, parameters)


def _contact(history: History, formulation: str, parameters: Parameters) -> str:
    penalty = f"PRESSURE-OVERCLOSURE=LINEAR\n{parameters.penalty}\n"
    if formulation == "node to surface":
        penalty = f"PRESSURE-OVERCLOSURE=LINEAR\n{parameters.penalty}, 1e-3\n"
    if formulation == "mortar":
        penalty = "PRESSURE-OVERCLOSURE=HARD\n"
    return (
        f"*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, {penalty}"
        f"*FRICTION\n{history.friction}, {parameters.penalty}\n"
        f"*CONTACT PAIR, INTERACTION=I, TYPE={FORMULATIONS[formulation]}\nSup, Slo\n"
        "*BOUNDARY\nBOTTOM, 1, 3\nNup, 3, 3\nNlo, 3, 3\n"
    )


def _steps(history: History, parameters: Parameters) -> str:
    size = 1 / parameters.increments
    text = ""
    for x, y in history.corners:
        text += (
            f"*STEP, INC=1000\n*STATIC\n{size}, 1., 1e-6, {size}\n"
            f"*BOUNDARY\nTOP, 1, 1, {x}\nTOP, 2, 2, {y}\n"
            "*NODE PRINT, NSET=TOP, TOTALS=ONLY\nRF\n*END STEP\n"
        )
    return text


_TOTAL = re.compile(r"total force.*?time\s+(\S+)\s*\n\s*\n\s+(\S+)\s+(\S+)\s+(\S+)")


def forces_of_calculix(
    job: Job, history: History, formulation: str, parameters: Parameters
) -> Array:
    """(m, 3) time, shear force and pressure of the contact per unit depth; empty without answer.

    Times are whole at the corners of the history.
    """
    if not job.run(deck_of(history, formulation, parameters)):
        return np.zeros((0, 3))
    printed = (job.folder / "job.dat").read_text(encoding="utf-8")
    totals = [[float(word) for word in found.groups()] for found in _TOTAL.finditer(printed)]
    forces = np.array(totals).reshape(-1, 4)
    complete = len(forces) and abs(forces[-1, 0] - len(history.corners)) < 1e-6
    # The reactions of the top are the forces of the contact on the upper block, with a minus; the
    # slice is 0.5 deep.
    return forces[:, :3] * [1.0, -2.0, -2.0] if complete else np.zeros((0, 3))


def forces_of_frictopt(history: History, parameters: Parameters) -> Array:
    """(m, 3) time, shear force and pressure of the contact, in as many increments."""
    meshes = {
        name: MeshQuad.init_tensor(*axes) for name, axes in lines(history, parameters).items()
    }
    heights = {"up": (history.gap, "top", history.gap + 1.0), "lo": (0.0, "bottom", -1.0)}
    bodies = {}
    for name, mesh in meshes.items():
        contact, far, height = heights[name]
        sides = {
            "contact": lambda x, y=contact: abs(x[1] - y) < 1e-9,
            far: lambda x, y=height: abs(x[1] - y) < 1e-9,
        }
        bodies[name] = fo.Body(mesh.with_boundaries(sides), fo.Material(1000.0, 0.3))
    system = fo.ContactModel(
        bodies,
        [fo.Support("up", "top"), fo.Support("lo", "bottom")],
        {axis: [fo.Displacement("up", "top", **{axis: 1.0})] for axis in "xy"},
        [fo.Contact("up", "lo", gap="measured" if history.gap else None)],
    ).condense()
    increment = fo.increments.NewtonIncrement(system, history.friction)
    slip = np.zeros(system.nodes)
    at = np.zeros(2)
    rows = []
    for step, corner in enumerate(history.corners):
        for share in np.linspace(0.0, 1.0, parameters.increments + 1)[1:]:
            x, y = at + share * (np.array(corner) - at)
            (q_x, p_x), (q_y, p_y) = system.bonded["x"], system.bonded["y"]
            state = increment.solve(slip, (x * q_x + y * q_y, x * p_x + y * p_y))
            slip = state.slip
            rows.append([step + share, state.q.sum(), state.p.sum()])
        at = np.array(corner)
    return np.array(rows)


def work_of_last_cycle(forces: Array, history: History) -> float:
    """Work that the top does from the last but two corner to the last one, per unit depth."""
    corners = np.array([(0.0, 0.0), *history.corners])
    x = np.interp(forces[:, 0], np.arange(len(corners)), corners[:, 0])
    in_cycle = forces[:, 0] >= len(history.corners) - 2 - 1e-9
    return float(-np.trapezoid(forces[in_cycle, 1], x[in_cycle]))


def contacts(parameters: Parameters) -> Iterator[Mapping[str, Any]]:
    """One row for each history and method."""
    _check_installed()
    with tempfile.TemporaryDirectory() as folder:
        job = Job(Path(folder), parameters.seconds)
        for name in each(parameters.histories, "histories"):
            history = HISTORIES[name]
            for method in (OURS, *parameters.formulations):
                if method == OURS:
                    forces = forces_of_frictopt(history, parameters)
                else:
                    forces = forces_of_calculix(job, history, method, parameters)
                yield _result(name, method, forces)


def _result(name: str, method: str, forces: Array) -> dict[str, Any]:
    history = HISTORIES[name]
    row = {"history": name, "method": method, "version": version(), "residual": 0.0}
    if not len(forces):
        return row | {"shear": np.nan, "pressure": np.nan, "first": np.nan, "work": np.nan}
    bound = history.friction * forces[:, 2]
    touches = forces[:, 2] > 1e-3 * forces[:, 2].max()
    shares = forces[touches, 1] / bound[touches]
    work = work_of_last_cycle(forces, history) if name == "loop" else np.nan
    return row | {
        "shear": float(shares[-1]),
        "pressure": float(forces[-1, 2]),
        "first": float(shares[0]),
        "work": work,
    }


def _report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Both tables in Markdown."""
    of_matrices = tables[MATRICES.name]
    of_contacts = tables[CONTACTS.name]
    statements_seen = [
        [row.statement, f"{row.what}: {row.number:.7g}", "yes" if row.holds else "no"]
        for row in of_matrices.itertuples()
    ]
    seen = [
        [row.history, row.method, *(_number(getattr(row, name)) for name in _NUMBERS)]
        for row in of_contacts.itertuples()
    ]
    return "\n\n".join(
        [
            f"CalculiX {of_matrices['version'].iloc[0]}",
            markdown(["statement", "seen", "holds"], statements_seen),
            markdown(["history", "method", *_NUMBERS.values()], seen),
        ]
    )


_NUMBERS = {
    "pressure": "pressing force",
    "first": "shear / bound, first contact",
    "shear": "shear / bound, end",
    "work": "work of the cycle",
}


def _number(value: float) -> str:
    if np.isnan(value):
        return ""
    return f"{0.0 if abs(value) < 1e-9 else value:.4g}"


MATRICES = Table(
    "calculix_matrices",
    "one statement about stored matrices",
    {
        "statement": "what CalculiX does",
        "what": "what the number is",
        "number": "what was seen",
        "holds": "whether the statement holds",
        "version": "of ccx",
    },
    full=FULL,
    quick=QUICK,
    compute=matrices,
)
CONTACTS = Table(
    "calculix_contacts",
    "one history by one method",
    {
        "history": "displacements of the top of the upper block",
        "method": "frictopt, or a formulation of CalculiX",
        "pressure": "force that presses at the end, per depth; nan: no answer in the time",
        "first": "shear force over friction times pressing force at the first increment in contact",
        "shear": "the same ratio at the end",
        "work": "work of friction of the last cycle, per depth",
        "version": "of ccx",
    },
    full=FULL,
    quick=QUICK,
    compute=contacts,
)

STUDY = Study(
    "validation.calculix",
    __doc__,
    "one formulation and one history, in seconds",
    (MATRICES, CONTACTS),
    _report,
)
