"""Decks for CalculiX, their results, and the same contacts by dense matrices of scikit-fem.

Lagrange's multipliers glue the bodies of the dense matrices.
"""

import os
import subprocess
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag
from skfem import (
    Basis,
    ElementHex1,
    ElementQuad1,
    ElementVector,
    MeshHex,
    MeshQuad,
    MeshTet,
    MeshTri,
)
from skfem.io.meshio import HEX_MAPPING
from skfem.models.elasticity import lame_parameters, linear_elasticity

from helpers.multipliers import by_multipliers
from helpers.quadratic import dimensions

MATRIX = "*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n"


def lines(*ends):
    return [np.linspace(a, b, n + 1) for a, b, n in ends]


@dataclass
class Block:
    """A box of bricks or a rectangle of quadrilaterals.

    The numbers of the nodes begin with `first`. The lines of the mesh along each axis are given.
    """

    first: int
    lines: list
    E: float
    nu: float
    name: str
    kind: str = ""
    thickness: str = ""
    numbers: np.ndarray = field(init=False)
    points: np.ndarray = field(init=False)

    def __post_init__(self):
        grid = np.meshgrid(*self.lines, indexing="ij")
        self.points = np.column_stack([axis.ravel(order="F") for axis in grid])
        self.numbers = self.first + np.arange(len(self.points))
        self.kind = self.kind or ("CPE4" if len(self.lines) == 2 else "C3D8")

    @property
    def elements(self):
        """(m, 4) or (m, 8) nodes, as rows of `points`."""
        number = np.arange(len(self.points)).reshape([len(line) for line in self.lines], order="F")
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        corners = ring if number.ndim == 2 else [(i, j, k) for k in (0, 1) for i, j in ring]
        ends = [[slice(1, None) if corner else slice(-1) for corner in shift] for shift in corners]
        return np.column_stack([number[tuple(end)].ravel() for end in ends])

    def on(self, axis, value):
        """Numbers of the nodes on a plane."""
        return self.numbers[self.points[:, axis] == value]

    def deck(self):
        nodes = "".join(
            f"{n}, {', '.join(map(repr, map(float, point)))}\n"
            for n, point in zip(self.numbers, self.points, strict=True)
        )
        rows = enumerate(self.numbers[self.elements], self.first)
        elements = "".join(f"{i}, {', '.join(map(str, row))}\n" for i, row in rows)
        section = f"*SOLID SECTION, ELSET={self.name}, MATERIAL={self.name}\n{self.thickness}\n"
        material = f"*MATERIAL, NAME={self.name}\n*ELASTIC\n{self.E!r}, {self.nu!r}\n*DENSITY\n1.\n"
        return f"*NODE, NSET=ALL\n{nodes}*ELEMENT, TYPE={self.kind}, ELSET={self.name}\n{elements}{material}{section}"

    def stiffness(self):
        """The stiffness (size, size) by scikit-fem, node by node."""
        mesh, element = (
            (MeshQuad, ElementQuad1()) if len(self.lines) == 2 else (MeshHex, ElementHex1())
        )
        mesh = mesh.init_tensor(*self.lines)
        basis = Basis(mesh, ElementVector(element))
        K = linear_elasticity(*lame_parameters(self.E, self.nu)).assemble(basis).toarray()
        place = {tuple(point): i for i, point in enumerate(mesh.p.T)}
        order = np.concatenate([basis.nodal_dofs[:, place[tuple(point)]] for point in self.points])
        return K[np.ix_(order, order)]


def node_set(name, numbers):
    return f"*NSET, NSET={name}\n" + "".join(f"{n},\n" for n in numbers)


def equation(*terms):
    return f"*EQUATION\n{len(terms)}\n" + "".join(
        f"{node}, {direction}, {weight!r}\n" for node, direction, weight in terms
    )


def run(folder, deck, step=MATRIX, name="job"):
    """Let CalculiX compute a step; return the path of the job, and the output of CalculiX."""
    (folder / f"{name}.inp").write_text(deck + f"*STEP\n{step}*END STEP\n")
    said = subprocess.run(
        ["ccx", "-i", name],
        cwd=folder,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    return folder / name, said.stdout


def displacements(folder, deck, loads):
    """Number of a node -> its displacements by CalculiX."""
    job, _ = run(folder, deck, f"*STATIC\n{loads}*NODE PRINT, NSET=ALL\nU\n", "static")
    rows = [line.split() for line in job.with_suffix(".dat").read_text().splitlines()]
    return {
        int(row[0]): np.array(row[1:], dtype=float)
        for row in rows
        if len(row) == 4 and row[0].isdecimal()
    }


def chained(top, direction):
    """Equations by which each node follows the one before."""
    return [
        [(int(n), direction, 1.0), (int(before), direction, -1.0)] for before, n in pairwise(top)
    ]


def glued(blocks, held, pairs, equations, loads):
    """Stiffness of the pairs of a contact, direction by direction, and their reactions under loads.

    Multipliers glue the pairs.

    Parameters
    ----------
    blocks
        The blocks.
    held
        Numbers of nodes that do not move.
    pairs
        Numbers of the nodes of body 1 and of body 2.
    equations
        Tuples of (node, direction, weight).
    loads
        Tuples of (node, direction, force).
    """
    d, numbers = len(blocks[0].lines), np.concatenate([block.numbers for block in blocks])
    place = {int(n): d * i for i, n in enumerate(numbers)}

    def row(terms):
        line = np.zeros(d * len(numbers))
        for node, direction, weight in terms:
            line[place[node] + direction - 1] += weight
        return line

    glue = [[(a, k + 1, 1.0), (b, k + 1, -1.0)] for k in range(d) for a, b in pairs]
    K, G = (
        block_diag(*(block.stiffness() for block in blocks)),
        np.array([row(rule) for rule in [*glue, *equations]]),
    )
    S, R = by_multipliers(
        K,
        np.column_stack([row(load) for load in loads]),
        G,
        [place[n] + k for n in held for k in range(d)],
    )
    return S[: len(glue), : len(glue)], R[: len(glue)]


NODES = {"CPE6": 6, "CPE8": 8, "C3D10": 10, "C3D20": 20, "C3D20R": 20}
KINDS = {"CPE6": MeshTri, "CPE8": MeshQuad, "C3D10": MeshTet, "C3D20": MeshHex, "C3D20R": MeshHex}
FLIPS = {
    6: [0, 2, 1, 5, 4, 3],
    8: [0, 3, 2, 1, 7, 6, 5, 4],
    10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    20: list(range(20)),
}
AXES = {6: (1, 2), 8: (1, 3), 10: (1, 2, 3), 20: (1, 3, 4)}


def elements(mesh, kind):
    """The nodes (m, k) of the elements of a scikit-fem mesh, in the order of the other code."""
    n, t = NODES[kind], mesh.dofs.element_dofs
    t = t[HEX_MAPPING][:20] if n == 20 else t[:n]
    sides = np.stack([mesh.p[:, t[i]] - mesh.p[:, t[0]] for i in AXES[n]])
    return np.where(np.linalg.det(sides.transpose(2, 0, 1)) > 0, t, t[FLIPS[n]]).T


def deck(bodies, kind):
    """Two boxes with node sets for both faces of the contact (CU, CL), the top and the held bottom."""
    text, element, d = "", 1, dimensions(KINDS[kind])
    first = {"upper": 1, "lower": 1001}
    for name, body in bodies.items():
        rows = elements(body.mesh, kind) + first[name]
        used = np.unique(rows)
        points = body.mesh.p[:, used - first[name]].T.tolist()
        text += "*NODE, NSET=ALL\n" + "".join(
            f"{n}, {', '.join(map(repr, point))}\n" for n, point in zip(used, points, strict=True)
        )
        text += f"*ELEMENT, TYPE={kind}, ELSET={name}\n"
        for row in rows.tolist():
            numbers = [element, *row]
            text += (
                ",\n".join(
                    ", ".join(map(str, numbers[i : i + 8])) for i in range(0, len(numbers), 8)
                )
                + "\n"
            )
            element += 1
        for label, boundary in {
            "upper": (("CU", "contact"), ("TOP", "far")),
            "lower": (("CL", "contact"), ("BOT", "far")),
        }[name]:
            text += node_set(
                label, np.intersect1d(body.boundary_nodes(boundary, "") + first[name], used)
            )
        material = body.material
        text += f"*MATERIAL, NAME={name}\n*ELASTIC\n{material.E!r}, {material.nu!r}\n*DENSITY\n1.\n*SOLID SECTION, ELSET={name}, MATERIAL={name}\n\n"
    return text + f"*BOUNDARY\nBOT, 1, {d}\n"
