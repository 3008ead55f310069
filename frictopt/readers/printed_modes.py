"""Modes of vibration that CalculiX prints into `NAME.dat`."""

import re
from pathlib import Path

import numpy as np

from ..base import Array, Integers, frozen
from ..errors import ModelError
from .deck_text import text_of
from .labels import displaced

# A line of the table of modes: number, eigenvalue, frequency in radians and in cycles per unit of
# time, imaginary part.
_FREQUENCY = re.compile(r"^ +\d+(?: +\S+){2} +(\S+) +\S+ *$", re.MULTILINE)
# The displacements of a mode: a title, an empty line, and lines of a node and three numbers.
_DISPLACEMENTS = re.compile(r"displacements \(vx,vy,vz\).*\n\s*\n((?: *\d+(?: +\S+){3} *\n)+)")
# An exponent of three digits leaves no room for its letter: 1.0-100.
_WITHOUT_LETTER = re.compile(r"(\d)([+-]\d{3})$")


def printed_modes(path: Path, labels: Integers) -> tuple[Array, Array]:
    """Frequencies (m,) and shapes (m, n) of the modes, for the n unknowns of a matrix.

    `labels` (n, 2) are node and direction of each unknown. See `MatrixJob.modes`.
    """
    if not displaced(labels).all():
        raise ModelError(
            "modes: the matrix has unknowns that are no displacements of nodes, and CalculiX "
            "prints none else; find modes from K and M"
        )
    text = text_of(path, "modes")
    head, *modes = re.split(r"E I G E N V A L U E +N U M B E R +\d+", text)
    table = head.partition("E I G E N V A L U E   O U T P U T")[2]
    table = table.partition("P A R T I C I P A T I O N")[0]
    frequencies = [float(value) for value in _FREQUENCY.findall(table)]
    if not frequencies or len(frequencies) != len(modes):
        raise ModelError(
            f"modes: {str(path)!r} has frequencies: {len(frequencies)}, modes: {len(modes)}; "
            "give the .dat of a *FREQUENCY step with *NODE PRINT of U"
        )
    shapes = [_shape(mode, labels, path) for mode in modes]
    return frozen(frequencies), frozen(shapes)


def _shape(mode: str, labels: Integers, path: Path) -> Array:
    """(n,) displacements of one mode."""
    printed = _printed(mode)
    missing = set(labels[:, 0].tolist()) - printed.keys()
    if missing:
        raise ModelError(
            f"modes: {str(path)!r} has no displacement of node {min(missing)} of the matrix; "
            "print U of all nodes (*NODE PRINT)"
        )
    return np.array([printed[node][direction - 1] for node, direction in labels.tolist()])


def _printed(mode: str) -> dict[int, list[float]]:
    """Number of each node -> its displacements."""
    displacements = {}
    for table in _DISPLACEMENTS.findall(mode):
        for line in table.splitlines():
            node, *values = line.split()
            displacements[int(node)] = [
                float(_WITHOUT_LETTER.sub(r"\1E\2", value)) for value in values
            ]
    return displacements
