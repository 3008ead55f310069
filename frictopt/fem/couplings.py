"""Couplings of nodes to a point as supports: rigid (RBE2) and distributing (RBE3).

Some displacements of the nodes follow others. The point adds no unknown: the rigid motion of the
nodes follows from some of their displacements, one for each component of the motion. A load on the
point of a rigid coupling is a `RemoteForce` on its nodes, because only the resultant of the load
matters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_matrix, diags

from ..base import ROUNDING, SAME_POINT, Array, Booleans, Integers, choice, place
from ..errors import ModelError
from .bodies import Body, check_names
from .elasticity import Kinematics
from .faces import unit_vectors
from .node_forces import (
    TINY,
    NodesAround,
    check_carried,
    check_reference,
    distribution,
    motions_of_point,
    nodes_around,
)
from .supports import AXES, Place, checked_place


@dataclass(frozen=True)
class _Coupling:
    """Base of couplings: nodes of one body, a point, and motions of the point that are zero.

    Attributes
    ----------
    directions, rotations
        Axes along which displacements of the point are zero, and axes about which its rotations are
        zero.
    """

    body: str
    where: Place
    directions: str = ""
    rotations: str = ""
    point: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        check_names(self, "body")
        object.__setattr__(self, "where", checked_place(self.where))
        choice("directions", self.directions, ("", *AXES))
        choice("rotations", self.rotations, ("", *AXES))
        check_reference(self)

    def _held(self, d: int, kinematics: Kinematics) -> Booleans:
        """(m,) whether each motion of the point is zero, in the order of `motions_of_point`."""
        if kinematics == "axisymmetric":
            if set(self.directions) - {"y"} or self.rotations:
                raise ModelError(
                    f"supports: {self}; a ring moves as a rigid body only along y: give "
                    "directions='y' and no rotations"
                )
            return np.array([bool(self.directions)])
        axes = "z" if d == 2 else "xyz"
        if d == 2 and ("z" in self.directions or set(self.rotations) - {"z"}):
            raise ModelError(
                f"supports: {self} of a plane body; give directions x and y, and rotations z, alone"
            )
        along = [axis in self.directions for axis in "xyz"[:d]]
        return np.array([*along, *(axis in self.rotations for axis in axes)])


@dataclass(frozen=True)
class RigidCoupling(_Coupling):
    """Nodes that move as a rigid body (RBE2), for the supports of a `ContactModel`.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        The nodes, as in a `Support`.
    directions, rotations
        Displacements of the point that are zero, such as "xy", and rotations that are zero, such as
        "z". By default none is zero: the nodes move freely as a rigid body. If all are zero, so are
        all displacements of the nodes.
    point
        Coordinates of the point; None: the weighted mean of the nodes. The point matters only if
        some of its motions are zero and others are not. A load on the point is a `RemoteForce` on
        the same nodes with the same point.

    Raises
    ------
    ModelError
        Directions or rotations are unknown. In a model: the nodes also belong to a contact,
        another coupling, a bolt or a sector, or supports prevent their rigid motion.

    Examples
    --------
    A flange whose face stays flat, and can turn only about x:

    >>> import frictopt as fo
    >>> face = fo.fem.RigidCoupling("pipe", "flange", "xyz", "yz", point=(0.0, 0.0, 0.0))
    >>> face.rotations
    'yz'
    """

    def _shares(
        self, around: NodesAround, held: Booleans, kinematics: Kinematics
    ) -> tuple[Integers, Integers, Array]:
        """The f displacements that follow, the k that lead, and the matrix (f, k) between them.

        `held` (n d,) says of each displacement of the nodes whether supports hold it. Displacements
        have the same numbers in the results.
        """
        d = around.points.shape[1]
        motions = motions_of_point(around.points, around.point)
        if kinematics == "axisymmetric":
            motions = motions[:, 1:2]
        motions = motions[:, ~self._held(d, kinematics)]
        motions = motions / np.maximum(np.abs(motions).max(axis=0, initial=0.0), TINY)
        if np.abs(motions[held]).max(initial=0.0) > SAME_POINT:
            raise ModelError(
                f"supports: {self} has nodes that other supports hold against its motions; leave "
                "those nodes out, or hold the point along and about these axes too"
            )
        free = np.flatnonzero(~held)
        leaders = free[_independent(motions[free].T)]
        followers = np.setdiff1d(free, leaders)
        share = motions[followers] @ np.linalg.pinv(motions[leaders], rcond=SAME_POINT)
        return followers, leaders, share


@dataclass(frozen=True)
class DistributingCoupling(_Coupling):
    """Nodes whose mean motions are zero (RBE3), for the supports of a `ContactModel`.

    The point has the mean displacement of the nodes, and the rotation that fits their displacements
    best. The nodes stay free to move apart, so nothing is stiffened. The reactions act like a
    `RemoteForce` on the same nodes. The coupling connects all its nodes to each other in the
    stiffness matrix: up to a thousand nodes take little time.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        The nodes, as in a `Support`, weighted as in a `RemoteForce`.
    directions, rotations
        Displacements of the point that are zero, such as "xy", and rotations that are zero, such as
        "z". At least one is needed.
    point
        Coordinates of the point; None: the weighted mean of the nodes.

    Raises
    ------
    ModelError
        Directions or rotations are unknown, or none is given. In a model: the nodes also belong to
        a contact, another coupling, a bolt or a sector; or the nodes lie on a line and a rotation
        about this line is to be zero.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.DistributingCoupling("bracket", "hole", "xyz").directions
    'xyz'
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.directions and not self.rotations:
            raise ModelError(
                "directions: none, and no rotations; name the motions of the point that are zero"
            )

    def _shares(
        self, around: NodesAround, held: Booleans, kinematics: Kinematics
    ) -> tuple[Integers, Integers, Array]:
        forces = distribution(around, kinematics)
        is_zero = self._held(around.points.shape[1], kinematics)
        for load in np.eye(len(is_zero))[is_zero]:
            check_carried(self, around, forces, load)
        free = np.flatnonzero(~held)
        constraints = unit_vectors(forces[free][:, is_zero].T)
        followers = _independent(constraints)
        if len(followers) < len(constraints):
            raise ModelError(
                f"supports: {self} cannot hold its point so: its nodes lie on a line or are one "
                "node, or other supports hold them; name fewer directions and rotations"
            )
        leaders = np.setdiff1d(np.arange(len(free)), followers)
        share = np.asarray(-np.linalg.solve(constraints[:, followers], constraints[:, leaders]))
        return free[followers], free[leaders], share


Coupling: TypeAlias = RigidCoupling | DistributingCoupling


@dataclass(frozen=True, eq=False)
class Coupled:
    """Displacements of a model that couplings bind."""

    # (size, size) matrix by which displacements follow; rows of displacements that are zero are
    # empty
    matrix: csr_matrix
    # nodes of all couplings
    nodes: Integers

    def hold(self, nodes: Integers, direction: Array) -> bool:
        """Whether couplings prevent some nodes from moving together along a direction (d,)."""
        motion = np.zeros((self.matrix.shape[0] // len(direction), len(direction)))
        motion[nodes] = direction
        prevented = self.matrix @ motion.ravel() - motion.ravel()
        return bool(np.abs(prevented).max() > SAME_POINT)


def coupled(
    couplings: Sequence[Coupling],
    bodies: Mapping[str, Body],
    own_nodes: Mapping[str, Integers],
    free: Booleans,
    taken: Integers,
    points: Array,
    kinematics: Kinematics,
) -> Coupled:
    """Bind the displacements of the couplings of a model.

    `free` (nodes, d) are the displacements that nothing holds yet. The nodes `taken` belong to
    other parts of the model and must not be in a coupling. No node may be in two couplings.
    """
    unknowns = np.arange(points.size).reshape(points.shape)
    kept = np.ones(points.size)
    links = csr_matrix((points.size,) * 2)
    used = np.zeros(0, dtype=np.intp)
    for coupling in couplings:
        body = bodies[choice("supports: body", coupling.body, bodies)]
        around = nodes_around(coupling, body, kinematics)
        nodes = own_nodes[coupling.body][around.nodes]
        both = np.intersect1d(nodes, np.r_[taken, used])
        if len(both):
            raise ModelError(
                f"supports: {coupling} has the node at {place(points[both[0]])}, which also "
                "belongs to a contact or another coupling; leave it out"
            )
        used = np.r_[used, nodes]
        rows = unknowns[nodes].ravel()
        followers, leaders, share = coupling._shares(around, ~free[nodes].ravel(), kinematics)
        share = np.where(np.abs(share) > ROUNDING, share, 0.0)
        follow, lead = np.nonzero(share)
        places = rows[followers[follow]], rows[leaders[lead]]
        links = links + csr_matrix((share[follow, lead], places), shape=links.shape)
        kept[rows[followers]] = 0.0
    return Coupled(csr_matrix(links + diags(kept)), used)


def _independent(rows: Array) -> Integers:
    """(r,) independent columns of a matrix (m, n) of rank r, the largest first."""
    if not rows.size:
        return np.zeros(0, dtype=np.intp)
    triangle, order = qr(rows, mode="r", pivoting=True)
    sizes = np.abs(np.diag(triangle))
    return np.asarray(order[: int(np.sum(sizes > SAME_POINT * sizes[0]))])
