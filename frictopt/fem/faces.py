"""Faces of meshed bodies: the boundary of a contact as one chain of nodes, in order."""

from dataclasses import dataclass

import numpy as np

from ..contact.checks import Array, place
from ..errors import ModelError
from .bodies import Body
from .ordering import Integers

__all__ = ["Face", "face"]


@dataclass(frozen=True, eq=False)
class Face:
    """The nodes of a boundary in their order, with the body on the left of the way; a closed one begins again at its first node.

    Parameters
    ----------
    nodes
        (n,) nodes of the body, each once.
    points
        (n, 2) coordinates.
    closed
        Whether the last node is joined to the first.
    """

    nodes: Integers
    points: Array
    closed: bool

    @property
    def chain(self) -> Integers:
        """Places in `nodes` along the way: a closed face ends at its first node."""
        return np.arange(len(self.nodes) + self.closed) % len(self.nodes)

    @property
    def steps(self) -> Array:
        """(edges, 2) vectors from node to node."""
        return np.diff(self.points[self.chain], axis=0)

    @property
    def lengths(self) -> Array:
        """(edges,) lengths of the edges."""
        return np.asarray(np.hypot(*self.steps.T))

    @property
    def sag(self) -> Array:
        """(n,) distance by which the edges at a node may miss the curve that they stand for, from the angle that they turn there."""
        chain, step = self.chain, self.steps
        ahead, behind = (step, np.roll(step, 1, axis=0)) if self.closed else (step[1:], step[:-1])
        turn = np.abs(np.arctan2(behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], np.sum(ahead * behind, axis=1)))
        at = np.zeros(len(self.nodes))
        at[chain[:-1] if self.closed else chain[1:-1]] = turn
        edge = np.maximum(at[chain[:-1]], at[chain[1:]]) * self.lengths / 8
        worst = np.zeros(len(self.nodes))
        np.maximum.at(worst, chain[:-1], edge)
        np.maximum.at(worst, chain[1:], edge)
        return worst

    def reversed(self) -> "Face":
        """The same face with the body on the right of the way."""
        return Face(self.nodes[::-1], self.points[::-1], self.closed)


def face(body: Body, boundary: str, argument: str) -> Face:
    """The boundary of that name as a chain of nodes; error messages call it `argument`.

    Raises
    ------
    ModelError
        Unknown, inside the body, in several pieces, or touching itself.
    """
    mesh, facets = body.mesh, body.boundary(boundary, argument)
    first, second = mesh.facets[:, facets]
    centre = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1)
    along, across = mesh.p[:, second] - mesh.p[:, first], centre - mesh.p[:, first]
    left = along[0] * across[1] - along[1] * across[0] > 0
    start, end = np.where(left, first, second), np.where(left, second, first)
    for nodes in (start, end):
        values, times = np.unique(nodes, return_counts=True)
        if np.any(times > 1):
            node = int(values[times > 1][0])
            raise ModelError(f"{argument}: boundary {boundary!r} touches itself at {place(mesh.p[:, node])}; make a contact of each part")
    heads = np.setdiff1d(start, end)
    follower = dict(zip(start.tolist(), end.tolist(), strict=True))
    node = int(heads[0] if len(heads) else start.min())
    chain = [node]
    while (node := follower.get(node, chain[0])) != chain[0]:
        chain.append(node)
    if len(chain) - bool(len(heads)) < len(facets):
        other = int(np.setdiff1d(np.r_[start, end], chain)[0])
        raise ModelError(
            f"{argument}: boundary {boundary!r} is in several pieces, one at {place(mesh.p[:, chain[0]])}, another at {place(mesh.p[:, other])}; "
            "make a contact of each piece"
        )
    order = np.array(chain)
    return Face(order, mesh.p[:, order].T, not len(heads))
