"""Faces of meshed bodies: the boundary of a contact as one chain of nodes, in order."""

from dataclasses import dataclass

import numpy as np
from skfem import Mesh

from ..contact.checks import Array, place
from ..errors import ModelError
from .bodies import Body
from .ordering import Integers

__all__ = ["Face", "face", "lines_along"]


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
    mesh, start = body.mesh, f"{argument}: boundary {boundary!r}"
    (line, closed), *others = lines_along(mesh, body.boundary(boundary, argument), start)
    if others:
        one, other = (place(mesh.p[:, nodes[0]]) for nodes in (line, others[0][0]))
        raise ModelError(f"{start} is in several pieces, one at {one}, another at {other}; make a contact of each piece")
    nodes = line[::-1]
    if closed:
        nodes = np.roll(nodes, -int(nodes.argmin()))
    return Face(nodes, mesh.p[:, nodes].T, closed)


def lines_along(mesh: Mesh, facets: Integers, argument: str) -> list[tuple[Integers, bool]]:
    """Nodes of facets of a plane outline, line by line, the body on the right of the way, and whether the line is closed: it begins leftmost then.

    Raises
    ------
    ModelError
        A node that more than two facets share; the message calls the outline `argument`.
    """
    first, second = mesh.facets[:, facets]
    along, inward = mesh.p[:, second] - mesh.p[:, first], mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1) - mesh.p[:, first]
    left = along[0] * inward[1] - along[1] * inward[0] > 0
    start, end = np.where(left, second, first), np.where(left, first, second)
    for nodes in (start, end):
        if (np.bincount(nodes) > 1).any():
            raise ModelError(f"{argument} touches itself at {place(mesh.p[:, np.bincount(nodes).argmax()])}; make a contact of each part")
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    inner, lines = np.isin(start, end), []
    for i in np.lexsort((*mesh.p[::-1, start], inner)):  # ends of open lines come first
        node, line = int(start[i]), []
        while node in onward:
            line.append(node)
            node = onward.pop(node)
        if line:
            lines.append((np.array(line if inner[i] else [*line, node]), bool(inner[i])))
    return lines
