"""Modes of vibration: those that CalculiX printed, and the load of one."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ...contact import Array, Integers, finite_array, finite_number, frozen, whole_array
from ...errors import ModelError
from ..given import checked_stiffness
from .constraints import displaced
from .deck import Deck
from .text import text_of

_FREQUENCY = re.compile(r"^ +\d+(?: +\S+){2} +(\S+) +\S+ *$", re.MULTILINE)  # number, eigenvalue, rad per time, cycles per time, imaginary part
_PRINTED = re.compile(r"displacements \(vx,vy,vz\).*\n\s*\n((?: *\d+(?: +\S+){3} *\n)+)")


def modal_load(M: object, mode: ArrayLike, *, natural_frequency: float | None = None, glued: ArrayLike | None = None) -> Array:
    """The load that moves a structure in one of its modes alone, `M mode`, for `condense`; its displacement is the amplitude of the mode.

    Parameters
    ----------
    M
        (n, n) mass matrix of the separate bodies, sparse; or, with a natural frequency, their stiffness as `condense` takes it.
    mode
        (n,) shape of a mode of the glued structure, of any size: it is normalised to unit modal mass.
    natural_frequency
        Frequency of the mode in cycles per unit of time, where `M` is the stiffness: `K mode` is `omega^2 M mode`, and the forces by which the glued
        bodies hold each other. None: it is the mass.
    glued
        With a natural frequency (m, 2) rows that are glued to each other, such as `job.unknowns[pairs].transpose(0, 2, 1).reshape(-1, 2)`; -1 where
        one is held. The forces between them cancel in their sum, of which each gets one half.

    Returns
    -------
    Array
        (n,) forces.

    Raises
    ------
    ModelError
        A matrix that is not square or of another size than the mode, or in which the mode has no mass; a stiffness without `glued`, or rows that it
        does not have.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> K, M = np.diag([8.0, 18.0]), np.diag([2.0, 2.0])
    >>> load = fo.modal_load(M, [3.0, 0.0])
    >>> load.round(6).tolist() == fo.modal_load(K, [1.0, 0.0], natural_frequency=2.0 / (2 * np.pi), glued=np.empty((0, 2))).round(6).tolist()
    True
    """
    shape = finite_array("mode", mode, (None,))
    matrix = checked_stiffness(M, "M")
    if matrix.shape != (len(shape), len(shape)):
        raise ModelError(f"M: shape {matrix.shape}, and a mode of {len(shape)} unknowns; give both in the same unknowns")
    load = np.asarray(matrix @ shape)
    if natural_frequency is not None:
        if glued is None:
            raise ModelError("glued: None; a stiffness needs the rows that are glued to each other, whose forces are not those of the mode")
        rows = whole_array("glued", glued, (None, 2), least=-1, most=len(shape) - 1)
        mean = np.where((rows >= 0).all(axis=1), load[rows].mean(axis=1), 0.0)
        load[rows[rows >= 0]] = np.repeat(mean, (rows >= 0).sum(axis=1))
        load /= (2 * np.pi * finite_number("natural_frequency", natural_frequency, above=0.0)) ** 2
    mass = float(shape @ load)
    if not mass > 0:
        raise ModelError(f"mode: its modal mass is {mass:g}; give the mass matrix and a mode that moves it")
    return frozen(load / np.sqrt(mass))


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
