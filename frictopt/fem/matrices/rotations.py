"""Nodes that CalculiX makes: their displacements are rotations of rigid parts, or modes within elements."""

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.tolerances import SAME_POINT
from ...errors import ModelError
from ..ordering import Flags, Integers
from .deck import Deck


def with_rotations(K: csr_matrix, labels: Integers, deck: Deck) -> tuple[Integers, Flags]:
    """(n, 2) labels in which rotations of rigid parts are directions 4 to 6 of the reference, and (n,) which rows something resists.

    Incompatible modes of an element, C3D8I, are displacements of three nodes that are not in the deck; labels have these with a minus.

    Raises
    ------
    ModelError
        Rotations of several parts without a node of their own, nodes that do not determine the rotation.
    """
    constraints, labels, felt = deck.constraints, labels.copy(), np.ones(len(labels), dtype=bool)
    unnamed = sum(rotation is None for _, rotation in constraints.rigid)
    made = np.setdiff1d(labels[:, 0], deck.numbers)
    if unnamed > 1 or (unnamed and len(made) > 1):
        raise ModelError(
            f"deck: {unnamed} rigid parts name no ROT NODE, and the matrix has nodes {', '.join(map(str, made[:3]))}{', ...' * (len(made) > 3)} "
            "that are not in the deck; name a ROT NODE in each *RIGID BODY, and use *RIGID BODY in place of *COUPLING"
        )
    for reference, rotation in constraints.rigid:
        rows = np.flatnonzero(np.isin(labels[:, 0], made if rotation is None else deck.numbers[rotation]))
        labels[rows] = np.column_stack([np.full(len(rows), deck.numbers[reference]), labels[rows, 1] + 3])
        felt[rows] = abs(K[rows]).max(axis=1).toarray().ravel() > 0  # CalculiX writes rotations too that the part does not feel
        moved = constraints.part(reference)[1][:, labels[rows[felt[rows]], 1] - 1]
        if np.linalg.matrix_rank(moved, SAME_POINT * np.abs(moved).max(initial=0.0)) < moved.shape[1]:
            raise ModelError(
                f"deck: the nodes that follow REF NODE {deck.numbers[reference]} do not determine its rotation; hold it, or give nodes off a line"
            )
    if any(kind.startswith("C3D8I") for kind, _, _ in deck.elements):
        labels[np.isin(labels[:, 0], made), 0] *= -1
    return labels, felt
