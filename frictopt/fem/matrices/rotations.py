"""Rigid parts of a job: their rotations leave the stiffness, which then is one of displacements alone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_matrix, identity

from ...contact.checks import Array
from ...contact.tolerances import SAME_POINT
from ...errors import ModelError
from ..ordering import Integers
from .constraints import Constraints, Equation, Rigid
from .deck import Deck


def without_rotations(K: csr_matrix, labels: Integers, deck: Deck) -> tuple[csr_matrix, Integers, Deck]:
    """(n, m) matrix T, labels and deck in which displacements of some nodes of each rigid part stand for its rotation: `u = T y`, `T^T K T`.

    A rotation is no displacement of a point, by which a condensation knows rigid motions. The displacements of a part are `u = R_1 a + R_2 b` by the
    displacement a and the rotation b of its reference. As many of them, u_c, as the rotation has unknowns give `b = R_2c^-1 (u_c - R_1c a)`.
    The equations of the deck then say what follows: the rotation, and the other nodes of the part.

    Parameters
    ----------
    K, labels
        Stiffness, and node and direction of each of its rows.
    deck
        Deck of the job.

    Raises
    ------
    ModelError
        Rotations of several parts without a node of their own, a reference that follows others, nodes that do not determine the rotation.
    """
    if not deck.constraints.rigid:
        return identity(len(labels), format="csr"), labels, deck
    deck = _with_rotation(labels, deck)
    constraints = deck.constraints
    place = {(int(node), int(direction) - 1): i for i, (node, direction) in enumerate(labels)}
    labels, change, kept = labels.copy(), identity(len(labels), format="lil"), np.ones(len(labels), dtype=bool)
    equations: list[Equation] = []
    for part in constraints.rigid:
        ends, R = _motion(part, constraints, deck.points)
        pilots = [(node, axis) for node in (part.reference, part.rotation) for axis in range(3) if node is not None]
        equations += [_following(end, pilots, line) for end, line in zip(ends, R, strict=True)]
        rows = np.array([place.get((int(deck.numbers[node]), axis), -1) for node, axis in pilots])
        turns = np.flatnonzero(rows[3:] >= 0) + 3
        idle = turns[~R[:, turns].any(axis=0) & (np.abs(K[rows[turns]]).max(axis=1).toarray().ravel() == 0)]  # the part does not feel them
        kept[rows[idle]] = False
        turns = np.setdiff1d(turns, idle)
        if not len(turns):
            continue
        number = deck.numbers[part.reference]
        chosen = _pivots(R[:, turns], number)
        free = np.flatnonzero(rows[:3] >= 0)
        if (R[chosen, :3].any(axis=0) & (rows[:3] < 0) & ~constraints.held[part.reference]).any():
            raise ModelError(f"deck: node {number}, the REF NODE of a rigid part, follows others; let the others follow it")
        back = np.linalg.inv(R[np.ix_(chosen, turns)])
        moved = -back @ R[chosen, :3]
        change[np.ix_(rows[turns], rows[turns])] = back
        change[np.ix_(rows[turns], rows[free])] = moved[:, free]
        pivots = [ends[i] for i in chosen]
        labels[rows[turns]] = [(deck.numbers[node], axis + 1) for node, axis in pivots]
        equations += [_following(pilots[i], [*pivots, *pilots[:3]], line) for i, line in zip(turns, np.hstack([back, moved]), strict=True)]
    constraints = replace(constraints, equations=(*constraints.equations, *equations))
    return csr_matrix(change)[:, np.flatnonzero(kept)], labels[kept], replace(deck, constraints=constraints)


def _following(end: tuple[int, int], others: Sequence[tuple[int, int]], weights: Array) -> Equation:
    """The equation of a displacement that is the weighted sum of others."""
    return (*end, 1.0), *((*other, -float(weight)) for other, weight in zip(others, weights, strict=True) if weight)


def _motion(part: Rigid, constraints: Constraints, points: Array) -> tuple[list[tuple[int, int]], Array]:
    """Node and axis of each of the m displacements that follow, and (m, 6) their change by the displacement and the rotation of the reference."""
    other = {(node, axis) for (node, axis, _), *_ in constraints.equations} | {(part.reference, axis) for axis in range(3)}
    ends = [(int(node), axis) for node in part.nodes for axis in part.axes if (node, axis) not in other]
    axes = [axis for _, axis in ends]
    arms = points[[node for node, _ in ends]] - points[part.reference]
    turns = np.cross(np.eye(3), arms[:, None])  # of each node, about each axis
    return ends, np.hstack([np.eye(3)[axes], turns[np.arange(len(ends)), :, axes]])


def _pivots(R: Array, reference: int) -> Integers:
    """Rows of R that determine as many rotations as it has columns."""
    _, triangle, order = qr(R.T, mode="economic", pivoting=True)
    sizes = np.abs(np.diag(triangle))
    if len(sizes) < R.shape[1] or sizes[-1] <= SAME_POINT * sizes[0]:
        raise ModelError(f"deck: the nodes that follow REF NODE {reference} do not determine its rotation; hold it, or give nodes off a line")
    return np.asarray(order[: R.shape[1]])


def _with_rotation(labels: Integers, deck: Deck) -> Deck:
    """The deck with the node that the code made for the rotation of the one rigid part that names none."""
    without = [part for part in deck.constraints.rigid if part.rotation is None]
    made = np.setdiff1d(labels[:, 0], deck.numbers)
    if not without:
        return deck
    if len(without) > 1 or len(made) > 1:
        raise ModelError(
            f"deck: {len(without)} rigid parts name no ROT NODE, and the matrix has the nodes {made.tolist()} that are not in the deck; name a ROT "
            "NODE in each *RIGID BODY, and use *RIGID BODY in place of *COUPLING"
        )
    constraints, at = deck.constraints, without[0].reference
    return replace(
        deck,
        numbers=np.append(deck.numbers, made if len(made) else deck.numbers.max() + 1),
        points=np.vstack([deck.points, deck.points[at]]),
        constraints=replace(
            constraints,
            held=np.vstack([constraints.held, [[False] * 3]]),
            rigid=tuple(replace(part, rotation=len(deck.numbers)) if part.rotation is None else part for part in constraints.rigid),
        ),
    )
