"""Mirror images of a contact that are the contact itself, and what slips and mechanisms of a part of its nodes mean for all.

The slips that are their own images are the sums of all images of a slip of the kept nodes, one of each set of nodes that are images of each other. A
node in a mirror plane is its own image: it slips along the plane alone, and its slip here counts twice.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..contact import ContactSystem
from ..contact.checks import Array, Booleans
from ..contact.coulomb import lengths
from ..contact.parts import joined, parted
from ..contact.tolerances import CONDENSATION, SAME_POINT
from .mechanism import Mechanism

Integers = NDArray[np.intp]

_ALONG = 10 * CONDENSATION  # error of tangents that lie along a mirror plane or across it, as of frames


@dataclass(frozen=True, eq=False)
class Mirrors:
    """The G images of a contact in its mirror planes, itself the first: 2 for one plane, 4 for two.

    Attributes
    ----------
    planes
        (P, t + 1) normals of the mirror planes.
    place
        (G, M) unknown of S at the place of the image of each one.
    sign
        (G, M) factor that its motion gets there.
    corner
        (G, K) corner with the image of the loads of each corner.
    nodes
        Number of nodes, N.
    open
        Of the closed nodes alone: the images of the open ones; else None.
    """

    planes: Array
    place: Integers
    sign: Array
    corner: Integers
    nodes: int
    open: "Mirrors | None" = None

    def and_in(self, plane: Array, place: Integers, sign: Array, corner: Integers) -> "Mirrors":
        """These images, and their images in one more plane, which is across the others."""
        more = plane, place[self.place], sign[self.place] * self.sign, corner[self.corner]
        own = self.planes, self.place, self.sign, self.corner
        planes, places, signs, corners = (np.vstack(pair) for pair in zip(own, more, strict=True))
        return Mirrors(planes, places, signs, corners, self.nodes)

    def among(self, nodes: Booleans) -> "Mirrors":
        """These images of some nodes alone, none of which is the image of another node."""
        these = np.tile(nodes, self.place.shape[1] // self.nodes)
        number = np.cumsum(these) - 1
        return replace(self, place=number[self.place[:, these]], sign=self.sign[:, these], nodes=int(nodes.sum()))

    @cached_property
    def source(self) -> Integers:
        """(N,) the kept node that each node is, or is an image of."""
        return np.asarray(self.place[:, : self.nodes].min(axis=0))

    @cached_property
    def kept(self) -> Integers:
        """(n,) the kept nodes."""
        return np.unique(self.source)

    @cached_property
    def times(self) -> Array:
        """(t, n) how often the slip of a kept node counts there along each tangent: 0 across a mirror plane."""
        times = np.where(self.place == np.arange(self.place.shape[1]), self.sign, 0.0).sum(axis=0)
        return np.asarray(times.reshape(-1, self.nodes)[:-1, self.kept])

    def folded(self, matrix: Array) -> Array:
        """(m n, t n) what a matrix (m N, t N) makes at the kept nodes of their slips, ordered by component."""
        return self.by_kept(matrix.reshape(-1, self.nodes, matrix.shape[1])[:, self.kept].reshape(-1, matrix.shape[1]))

    def by_kept(self, rows: Array) -> Array:
        """(m, t n) what rows (m, t N) make of slips of the kept nodes."""
        return np.asarray(sum(rows[:, place] * sign for _, place, sign in self._images(len(self.times))))

    def slip(self, own: Array) -> Array:
        """(N,) or (N, 2) slip of the whole contact that a slip of the kept nodes means."""
        slip = np.zeros(own[0].size * self.nodes)
        for _, place, sign in self._images(own[0].size):
            slip[place] += sign * own.T.ravel()
        return slip.reshape(*own.shape[1:], self.nodes).T

    def expanded(self, motion: Mechanism, friction: Array) -> Mechanism:
        """The mechanism of the whole contact: the mean of the images of that of the kept nodes.

        Where images slip against each other at one node, this is an opening.
        """
        axes, own = len(self.times) + 1, joined(motion.slips, motion.lift)
        mean, hold, press = np.zeros((len(own), axes * self.nodes)), None, None
        for corner, place, sign in self._images(axes):
            mean[np.ix_(corner, place)] += sign * own / len(self.corner)
        slips, lift = parted(mean, axes)
        if self.open is not None and motion.press is not None:
            press = np.zeros((len(own), self.open.nodes))
            for corner, place, _ in self.open._images(1):
                press[np.ix_(corner, place)] += motion.press / len(self.corner)
        if motion.hold is not None:
            hold = self.slip((motion.hold.T / np.maximum(self.times.max(axis=0), 1.0)).T) / len(self.corner)
        return Mechanism(slips, (lift - friction * lengths(slips, lift)).clip(0.0), friction, hold, press)

    def _images(self, axes: int) -> Iterator[tuple[Integers, Integers, Array]]:
        """Of each image its corners, and places and signs of what the kept nodes do along the first axes."""
        kept = (self.kept + self.nodes * np.arange(axes)[:, None]).ravel()
        return zip(self.corner, self.place[:, kept], self.sign[:, kept], strict=True)


def mirror_planes(system: ContactSystem) -> Iterator[tuple[Array, Integers, Array]]:
    """Normals of planes that mirror nodes and frames onto nodes and frames, but for the sense of tangents; with place and sign, see `Mirrors`.

    In the plane the one across the middle; in space those through the middle of the nodes, across an axis or across a tangent of the first node.
    """
    nodes, first, frames = np.arange(system.nodes), system.nodes * np.arange(system.tangents + 1)[:, None], system.frames
    if system.tangents == 1:
        yield frames[0, 0], (first + nodes[::-1]).ravel(), np.repeat([-1.0, 1.0], system.nodes)
        return
    at = system.points - system.points.mean(axis=0)
    tree = cKDTree(at)
    for normal in (*np.eye(3), *(tangent for tangent in frames[0, :2] if np.abs(tangent).max() < 1 - _ALONG)):
        mirror = np.eye(3) - 2 * np.outer(normal, normal)
        apart, image = tree.query(at @ mirror)
        turn = frames[image] @ mirror @ frames.transpose(0, 2, 1)
        sign = np.round(np.diagonal(turn, axis1=1, axis2=2))
        along = np.abs(turn - sign[:, :, None] * np.eye(3)).max() <= _ALONG and (sign[:, 2] == 1).all()
        if along and apart.max() <= SAME_POINT * np.abs(at).max() and (image[image] == nodes).all():
            yield normal, (first + image).ravel(), sign.T.ravel()
