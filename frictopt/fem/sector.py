"""A sector of a ring: its dependent nodes, and checks that supports and loads repeat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, diags, identity, kron
from scipy.sparse.linalg import LinearOperator, cg

from ..base import COUNTS, ROUNDING, SAME_POINT, Array, Booleans, Integers, first_of, place
from ..errors import ModelError
from .bodies import Body
from .interface import ASKEW, blocks_of
from .supports import Seam, axis_of


@dataclass(frozen=True, eq=False)
class Sector:
    """Nodes of the high cut faces, which follow the low ones: `u_i = Q u_j`.

    Attributes
    ----------
    copies
        (all nodes,) node j of which each node i is a turned copy; -1: none.
    fixed
        Nodes on the axis, which both faces have.
    turn, shift
        (d, d) matrix Q, and (d,) the point to which the origin is turned.
    along
        (d,) unit vector along the axis; zero in the plane.
    count
        Number of sectors of the ring.
    """

    copies: Integers
    fixed: Integers
    turn: Array
    shift: Array
    along: Array
    count: int

    @property
    def nodes(self) -> Integers:
        """Nodes that follow."""
        return np.flatnonzero(self.copies >= 0)

    @property
    def across(self) -> Booleans:
        """(d,) coordinate axes across the axis of the ring, along which nodes on it do not move."""
        across = np.abs(self.along) <= SAME_POINT
        if len(self.fixed) and np.count_nonzero(~across) > 1:
            raise ModelError(
                f"supports: nodes of a sector lie on its axis, which is along {place(self.along)}; "
                "turn the mesh so that the axis is x, y or z"
            )
        return across

    @property
    def _centre(self) -> Array:
        """(d,) a point of the axis."""
        return np.asarray(np.linalg.pinv(np.eye(len(self.turn)) - self.turn) @ self.shift)

    def closed(self, bodies: Mapping[str, Body]) -> dict[str, Body]:
        """The bodies with copied nodes exactly at the turned places of their originals.

        Coordinates have errors. With them, a ring would resist a turn about its axis a little.
        """
        if self.count == 1:
            return dict(bodies)
        centre = self._centre
        points = np.concatenate([body.mesh.p.T for body in bodies.values()])
        copied = np.flatnonzero(self.copies >= 0)
        points[copied] = points[self.copies[copied]] @ self.turn.T + self.shift
        heights = (points[self.fixed] - centre) @ self.along
        points[self.fixed] = centre + np.multiply.outer(heights, self.along)
        moved = {}
        start = 0
        for name, body in bodies.items():
            end = start + body.mesh.p.shape[1]
            moved[name] = body.moved(points[start:end].T)
            start = end
        return moved

    @property
    def on_cuts(self) -> Integers:
        """All nodes that follow, or are followed."""
        return np.concatenate([self.nodes, self.copies[self.nodes], self.fixed])

    def follow(self, rows: Integers, free_rows: Integers, points: Array) -> csr_matrix:
        """The matrix (size, size) of `u = C u` that lets nodes follow.

        Given are the parts of an assembly. The free rows (nodes, d) are -1 if held; they become -2
        if a node follows.
        """
        nodes = self.nodes
        originals = self.copies[nodes]
        held = free_rows == -1
        # (n, d) share of each axis of a copy, turned back, in which its original is held.
        share = held[originals] @ (self.turn**2).T
        i = first_of((held[nodes] & (share < 1 - ASKEW)).any(axis=1))
        if i is not None:
            raise ModelError(
                f"supports: the node at {place(points[nodes[i]])} is held, but not the node at "
                f"{place(points[originals[i]])}, of which it is the copy on the other cut face; "
                "hold both, because supports repeat from sector to sector"
            )
        free_rows[nodes] = np.where(held[nodes], -1, -2)
        to_all = identity(len(points), format="csr")
        turned = kron(to_all[:, nodes] @ to_all[originals], self.turn)
        stays = np.ones(rows.size)
        stays[rows[nodes]] = 0.0
        by_nodes = csr_matrix((np.ones(rows.size), (rows.ravel(), np.arange(rows.size))))
        return csr_matrix(diags(stays) + by_nodes @ turned @ by_nodes.T)

    def check_moved(self, argument: str, moved: Array, turned: Array, points: Array) -> None:
        """Check that the displacements (nodes, d) of supports repeat from sector to sector.

        `turned` (nodes, d) are those of nodes that follow, NaN if none is given.
        """
        rounding = ROUNDING * np.nanmax(np.abs(moved), initial=0.0)
        i = first_of((np.abs(moved - turned)[self.nodes] > rounding).any(axis=1))
        if i is not None:
            raise ModelError(
                f"{argument}: the displacement of the node at {place(points[self.nodes[i]])}, on a "
                "cut face of a sector, differs from the turned displacement of the other face; "
                "give displacements that repeat from sector to sector"
            )

    def check_loads(self, argument: str, loads: Sequence[Any]) -> None:
        """Check that spins and constant loads are the same in the next sector.

        Loads that are functions are not checked.
        """
        d = len(self.turn)
        for load in loads:
            shift = np.zeros(d)
            if hasattr(load, "centre"):
                centre, axis = axis_of(load, d)
                shift = self.shift
            else:
                centre = np.zeros(d)
                parts = [getattr(load, name, 0.0) for name in "xyz"[:d]]
                axis = np.array([0.0 if callable(part) else part or 0.0 for part in parts])
            vector = axis[:d]
            off = np.abs([self.turn @ vector - vector, self.turn @ centre + shift - centre]).max()
            if off > SAME_POINT * np.abs([vector, centre, self.shift]).max():
                raise ModelError(
                    f"{argument}: {load} differs in the next sector, turned by "
                    f"360/{self.count} degrees; give functions of the coordinates that turn so, a "
                    "spin about the axis, or the whole ring"
                )

    def once(
        self, names: Sequence[str], pairs: tuple[Any, ...], points: Array, errors: Array
    ) -> tuple[Any, ...]:
        """The pairs without the pairs of copied nodes, which are the same pairs of the ring.

        A pair of a copied node adds its normal and width to the pair of the node that it copies. Of
        each pair are given the number of its contact, its node of body 1, its place on body 2 (a
        row over all nodes), normal, width, gap, and whether it lies opposite body 2.
        """
        contact, nodes, projection, normals, widths, gap, inside = pairs
        high = np.flatnonzero(np.isin(nodes, self.nodes))
        low = self._originals(contact, nodes, high)
        k = first_of(self._unmatched(nodes, projection, high, low))
        if k is not None:
            raise ModelError(
                f"contacts: {names[contact[k]]!r} reaches the cut of the sector at "
                f"{place(points[nodes[k]])}, and its nodes there are not the same on both bodies "
                "and on both cut faces; let nodes match there (gmsh: fragment the bodies, and "
                "setPeriodic from cut to cut), call the faces on one side `low` of both bodies, or "
                "cut where no contact is"
            )
        # Each gap has the errors of two places.
        written = 4 * np.linalg.norm(errors[nodes[high]], axis=1)
        k = first_of(np.abs(gap[high] - gap[low]) > COUNTS * gap.max(initial=0.0) + written)
        if k is not None:
            raise ModelError(
                f"contacts: the gap of {names[contact[high[k]]]!r} at "
                f"{place(points[nodes[high[k]]])} is {gap[high[k]]:g}, and {gap[low[k]]:g} at the "
                "original node on the other cut face; give gaps that repeat from sector to sector"
            )
        widths[low] += widths[high]
        inside[low] |= inside[high]
        normals[low] += normals[high] @ self.turn
        left = np.delete(np.arange(len(nodes)), high)
        return tuple(part[left] for part in pairs)

    def _originals(self, contact: Integers, nodes: Integers, high: Integers) -> Integers:
        """Numbers of the pairs of the same contact that pairs of copied nodes copy; -1: none."""
        numbers = {
            pair: k for k, pair in enumerate(zip(contact.tolist(), nodes.tolist(), strict=True))
        }
        low = [numbers.get((int(contact[k]), int(self.copies[nodes[k]])), -1) for k in high]
        return np.array(low, dtype=np.intp)

    def _unmatched(
        self, nodes: Integers, projection: csr_matrix, high: Integers, low: Integers
    ) -> Booleans:
        """Pairs at the cuts without a partner, or without a turned copy on body 2."""
        copies = self.copies
        links = projection.tocoo()
        columns = np.where(copies[links.col] >= 0, copies[links.col], links.col)
        turned = csr_matrix((links.data, (links.row, columns)), shape=projection.shape)
        follows = np.isin(links.col, self.nodes)
        unmatched = np.bincount(links.row, follows, minlength=len(nodes)) > 0
        unmatched |= np.isin(nodes, copies[copies >= 0]) & ~np.isin(np.arange(len(nodes)), low)
        unmatched[high] = (low < 0) | (
            np.asarray(abs(turned[high] - projection[low]).sum(axis=1)).ravel() > COUNTS
        )
        return unmatched

    def seam(self, first: int, body: Body) -> Seam | None:
        """Copied nodes of a body, the nodes that they copy, and Q; None if it has none.

        `first` is the number of the body's first node.
        """
        copied = np.flatnonzero(self.copies[first : first + body.mesh.p.shape[1]] >= 0)
        if not len(copied):
            return None
        return copied, self.copies[first + copied] - first, self.turn


def on_seam(
    mass: csr_matrix, moments: Sequence[Array], entries: Sequence[int], seam: Seam
) -> list[Array]:
    """Nodal components of a symmetric tensor by their moments with the functions of the nodes.

    At nodes that copy others they are the turned components. `entries` are the numbers of the
    components in a matrix of three rows.
    """
    high, low, turn = seam
    a, b = np.divmod(entries, 3)
    n = mass.shape[0]
    whole = np.zeros((n, 3, 3))
    whole[:, a, b] = np.transpose(moments)
    whole[:, b, a] = np.transpose(moments)
    Q = np.eye(3)
    Q[: len(turn), : len(turn)] = turn
    # The matrix that gives the values of all nodes from the values of the original nodes.
    turns = np.tile(np.eye(9), (n, 1, 1))
    turns[high] = np.kron(Q, Q)
    original = np.arange(n)
    original[high] = low
    leads = identity(n, format="csr")[original][:, np.delete(np.arange(n), high)]
    spread = csr_matrix(blocks_of(turns) @ kron(leads, identity(9)))
    spread.eliminate_zeros()
    scale = np.repeat(leads.T @ mass.diagonal(), 9)

    def applied(values: Array) -> Array:
        return np.asarray(spread.T @ (mass @ (spread @ values).reshape(n, 9)).ravel())

    # A mass is well conditioned, so conjugate gradients take few steps.
    operator = LinearOperator((len(scale), len(scale)), matvec=applied, dtype=np.float64)
    forces = spread.T @ whole.ravel()
    values = spread @ cg(operator, forces, rtol=ROUNDING, M=diags(1 / scale))[0]
    tensors = values.reshape(whole.shape)
    return [tensors[:, i, j] for i, j in zip(a, b, strict=True)]
