"""Modes of vibration that CalculiX printed."""

import re
from pathlib import Path

import numpy as np

from ...contact.checks import Array, frozen
from ...errors import ModelError
from ..ordering import Integers
from .blocks import text_of
from .deck import Deck
from .labels import displaced

_FREQUENCY = re.compile(r"^ +\d+(?: +\S+){2} +(\S+) +\S+ *$", re.MULTILINE)  # number, eigenvalue, rad per time, cycles per time, imaginary part
_PRINTED = re.compile(r"displacements \(vx,vy,vz\).*\n\s*\n((?: *\d+(?: +\S+){3} *\n)+)")


def printed_modes(path: Path, labels: Integers, deck: Deck | None) -> tuple[Array, Array]:
    """Frequencies (m,) and shapes (m, n) of a file `NAME.dat`, for the nodes and directions (n, 2) of n unknowns; see `MatrixJob.modes`."""
    rigid = [] if deck is None else [deck.numbers[reference] for reference, _ in deck.constraints.rigid]
    if not (displaced(labels) | np.isin(labels[:, 0], rigid)).all():
        raise ModelError("modes: the matrix has unknowns that are no displacements of nodes, and CalculiX prints none else; find modes from K and M")
    head, *modes = re.split(r"E I G E N V A L U E +N U M B E R +\d+", text_of(path, "modes"))
    table = head.partition("E I G E N V A L U E   O U T P U T")[2].partition("P A R T I C I P A T I O N")[0]
    frequencies = [float(value) for value in _FREQUENCY.findall(table)]
    if not frequencies or len(frequencies) != len(modes):
        raise ModelError(
            f"modes: {str(path)!r} has {len(frequencies)} frequencies and {len(modes)} modes; give the .dat of a step of *FREQUENCY with "
            "*NODE PRINT, NSET=.. of U"
        )
    return frozen(frequencies), frozen([_shape(mode, labels, path, deck) for mode in modes])


def _shape(mode: str, labels: Integers, path: Path, deck: Deck | None) -> Array:
    """(n,) displacements of one mode, and the rotations of rigid parts by the displacements of their nodes."""
    rows = [row.split() for block in _PRINTED.findall(mode) for row in block.splitlines()]
    printed = {int(node): [float(re.sub(r"(\d)([+-]\d{3})$", r"\1E\2", value)) for value in values] for node, *values in rows}
    needed, turned = set(labels[:, 0].tolist()), labels[~displaced(labels), 0]
    if deck is not None:
        for reference in np.flatnonzero(np.isin(deck.numbers, turned)).tolist():
            unknowns, R = deck.constraints.part(reference)
            nodes, number = deck.numbers[unknowns // 6].tolist(), int(deck.numbers[reference])
            needed |= {number, *nodes}
            if needed <= printed.keys():
                moved = [printed[node][axis] for node, axis in zip(nodes, unknowns % 6, strict=True)] - R[:, :3] @ printed[number]
                printed[number] += np.linalg.lstsq(R[:, 3:], moved)[0].tolist()
    if lost := sorted(needed - printed.keys()):
        raise ModelError(f"modes: {str(path)!r} has no displacement of node {lost[0]} of the matrix; print U of all nodes (*NODE PRINT)")
    return np.array([printed[node][direction - 1] for node, direction in labels.tolist()])
