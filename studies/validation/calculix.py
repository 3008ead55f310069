"""CalculiX beside frictopt: the content of its stored matrices, and the behaviour of its contact.

Run with `python -m studies calculix [--quick]`; it needs `ccx` and prints two tables in Markdown.
The first table checks statements about matrices and contact, each by small decks, see
`calculix_statements.py`. The second table follows three histories of a block on a block.
Displacements of the top of the upper block are prescribed. The contact formulations of CalculiX and
frictopt have the same mesh.
"""

import shutil
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
from studies.validation.calculix_statements import MATERIAL, Array, Job, statements, version

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
    # Number of elements along the upper block.
    elements: int = 2
    # Stiffness of penalty contact, force per length^3, normal and tangential; E is 1000.
    penalty: float = 1e5
    # Number of increments of each segment of a history.
    increments: int = 4
    # Seconds after which CalculiX is stopped.
    seconds: float = 300.0


FULL = Parameters()
QUICK = Parameters(formulations=("node to surface",), histories=("closed",), increments=2)


@dataclass(frozen=True)
class History:
    """Path (x, y) of the top of the upper block from (0, 0), the initial gap, and the friction."""

    corners: tuple[tuple[float, float], ...]
    gap: float
    friction: float


PRESS = -0.002
HISTORIES = {
    "closed": History(((0.0, PRESS), (0.0003, PRESS)), 0.0, 0.5),
    "loop": History(((0.0, PRESS), (0.002, PRESS), (-0.002, PRESS), (0.002, PRESS)), 0.0, 0.3),
    "lands elsewhere": History(((0.002, 0.0), (0.002, -0.003)), 0.001, 0.5),
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
    """The part of the deck with the contact and the supports."""
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
    """The part of the deck with the steps."""
    size = 1 / parameters.increments
    text = ""
    for x, y in history.corners:
        text += (
            f"*STEP, INC=1000\n*STATIC\n{size}, 1., 1e-6, {size}\n"
            f"*BOUNDARY\nTOP, 1, 1, {x}\nTOP, 2, 2, {y}\n"
            "*NODE PRINT, NSET=TOP, TOTALS=ONLY\nRF\n*END STEP\n"
        )
    return text


def forces_of_calculix(
    job: Job, history: History, formulation: str, parameters: Parameters
) -> Array:
    """(m, 3) time, shear force and pressure of the contact per unit depth, by CalculiX.

    The array is empty if CalculiX gives no answer. Times are whole numbers at the corners of the
    history.
    """
    if not job.run(deck_of(history, formulation, parameters)):
        return np.zeros((0, 3))
    forces = job.totals()
    complete = len(forces) and abs(forces[-1, 0] - len(history.corners)) < 1e-6
    # The reactions of the top are the forces of the contact on the upper block, with the
    # opposite sign. The slice is 0.5 deep.
    return forces[:, :3] * [1.0, -2.0, -2.0] if complete else np.zeros((0, 3))


def forces_of_frictopt(history: History, parameters: Parameters) -> Array:
    """(m, 3) time, shear force and pressure of the contact, in the same increments."""
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
        bodies[name] = fo.fem.Body(mesh.with_boundaries(sides), fo.fem.Material(1000.0, 0.3))
    system = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("up", "top"), fo.fem.Support("lo", "bottom")],
        {axis: [fo.fem.Displacement("up", "top", **{axis: 1.0})] for axis in "xy"},
        [fo.fem.Contact("up", "lo", gap="measured" if history.gap else None)],
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
    """Work done by the top in the last two segments of the history, per unit depth."""
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
    "one statement about stored matrices or contact",
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
    "studies.validation.calculix",
    __doc__,
    "one formulation and one history, in seconds",
    (MATRICES, CONTACTS),
    _report,
)
