"""Forces on nodes, and forces at a point that are spread over nodes (RBE3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import SAME_POINT, Array, Integers, finite_number, shown
from ..contact.components import rigid_displacements
from ..errors import ModelError
from .bodies import Body
from .elasticity import Amount, Kinematics, node_areas
from .loads import ForceLoad, components
from .supports import Place, checked_point, nodes_of

# Smallest divisor of a vector that is scaled to length one, so that zero vectors stay zero.
TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class PointForce(ForceLoad):
    """Force (x, y), in space (x, y, z), on each of some nodes of one body.

    In the plane it is per unit depth. In axisymmetric models a node is a ring, and the force is the
    sum around the circumference.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        The nodes, as in a `Support`.
    x, y, z
        Components, each a number or a function of the coordinates (arrays); zero by default.

    Raises
    ------
    ModelError
        The body is not a string, no component is given, a component is neither a finite number nor
        a function, or there is no such node.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.PointForce("punch", (0.5, 1.0), y=-2.0)
    PointForce(body='punch', where=(0.5, 1.0), x=0.0, y=-2.0, z=0.0)
    """

    body: str
    where: Place
    x: Amount | None = None
    y: Amount | None = None
    z: Amount | None = None

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        nodes = nodes_of(body, self.body, self.where)
        forces = np.zeros(body.mesh.p.shape)
        forces[:, nodes] = components(self, body.written[:, nodes])
        return forces

    def _size(self, body: Body, kinematics: Kinematics) -> float:
        return float(np.linalg.norm(self._forces(body, kinematics), axis=0).sum())


@dataclass(frozen=True)
class RemoteForce(ForceLoad):
    """Force and moment at a point, spread over nodes of one body (RBE3).

    The nodal forces have the resultants of the load. Of all forces with these resultants they are
    the smallest in the mean square, weighted by the areas of the nodes. The nodes stay free to move
    apart. With a `RigidCoupling` of the same nodes, this force is the load on the point of that
    coupling.

    Parameters
    ----------
    body
        Name of the body in its model.
    where
        The nodes, as in a `Support`. Nodes of a boundary are weighted by their shares of its area
        (in the plane, of its length); nodes of any other place have equal weights.
    x, y, z
        Components of the force, numbers, zero by default. In the plane the force is per unit depth.
        In axisymmetric models it is the sum around the circumference, and only y is allowed.
    moment
        Moment about the point: in space (x, y, z), in the plane a number, counterclockwise; None:
        zero.
    point
        Coordinates of the point; None: the weighted mean of the nodes.

    Raises
    ------
    ModelError
        The body is not a string, neither a force nor a moment is given, or one is not finite. In a
        model: the nodes lie on a line and cannot carry the moment, or an axisymmetric model has a
        moment or a radial force.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.fem.RemoteForce(
    ...     "lever", "eye", x=10.0, moment=(0.0, 0.0, 2.0), point=(0.0, 5.0, 0.0)
    ... ).moment
    (0.0, 0.0, 2.0)
    """

    body: str
    where: Place
    x: float | None = None
    y: float | None = None
    z: float | None = None
    moment: float | tuple[float, ...] | None = None
    point: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_reference(self)
        moment = self.moment
        if isinstance(moment, tuple | list):
            moment = checked_point("moment", moment, "three numbers, about x, y and z", (3,))
        elif moment is not None:
            moment = finite_number("moment", moment)
        object.__setattr__(self, "moment", moment)

    def _forces(self, body: Body, kinematics: Kinematics) -> Array:
        d = body.mesh.dim()
        around = nodes_around(self, body, kinematics)
        forces = distribution(around, kinematics)
        load = np.concatenate([components(self, np.zeros(d)), self._moments(d)])
        if kinematics == "axisymmetric":
            if load[0] != 0 or load[2] != 0:
                raise ModelError(
                    f"loads: {self} has a radial force or a moment; forces around the axis "
                    "balance such loads: give only y"
                )
            load = load[1:2]
        check_carried(self, around, forces, load)
        spread = np.zeros(body.mesh.p.shape)
        spread[:, around.nodes] = (forces @ load).reshape(-1, d).T
        return spread

    def _moments(self, d: int) -> Array:
        """(1,) moment in the plane, (3,) in space."""
        count = 1 if d == 2 else 3
        moments = np.zeros(count) if self.moment is None else np.atleast_1d(self.moment)
        if len(moments) != count:
            raise ModelError(
                f"RemoteForce moment: {shown(self.moment)}; body {self.body!r} has {d} dimensions: "
                f"give {'a number' if d == 2 else 'three numbers, about x, y and z'}"
            )
        return moments

    def _size(self, body: Body, kinematics: Kinematics) -> float:
        """The size of the force; 0 if there is a moment, whose size is not comparable."""
        if self.moment is not None:
            return 0.0
        return float(np.linalg.norm(components(self, np.zeros(body.mesh.dim()))))


@dataclass(frozen=True, eq=False)
class NodesAround:
    """The nodes of a load or coupling, and its point."""

    # (n,) nodes of the body, and their coordinates (n, d)
    nodes: Integers
    points: Array
    # (n,) weights of the nodes: their parts of the area of a boundary, or 1
    weights: Array
    # (d,) coordinates of the point
    point: Array


def nodes_around(part: Any, body: Body, kinematics: Kinematics) -> NodesAround:
    """The nodes of a load or coupling of a body, and its point."""
    nodes = nodes_of(body, part.body, part.where)
    points = body.mesh.p[:, nodes].T
    weights = np.ones(len(nodes))
    if isinstance(part.where, str):
        facets = body.boundary(part.where, "where")
        weights = node_areas(body.mesh, facets, kinematics)[nodes]
    if part.point is None:
        return NodesAround(nodes, points, weights, weights @ points / weights.sum())
    if len(part.point) != points.shape[1]:
        raise ModelError(
            f"point: {part.point}; give the {points.shape[1]} coordinates of a point for body "
            f"{part.body!r}"
        )
    return NodesAround(nodes, points, weights, np.array(part.point))


def check_reference(part: Any) -> None:
    """Check the point of a load or coupling, and make it a tuple."""
    if part.point is not None:
        point = checked_point("point", part.point, "one point (x, y), in space (x, y, z)")
        object.__setattr__(part, "point", point)


def motions_of_point(points: Array, about: Array) -> Array:
    """(n d, m) displacements of points (n, d) in unit displacements and rotations of a point."""
    motions = rigid_displacements(points - about)
    return motions.reshape(points.size, -1)


def distribution(around: NodesAround, kinematics: Kinematics) -> Array:
    """(n d, m) nodal forces of unit loads on the point.

    The nodal force is `w_i (F / sum w + turn x r_i)`, with the weight w_i and the arm r_i from the
    weighted mean of the nodes. The vector `turn` is chosen so that the forces have the right moment
    about this mean.
    """
    points = around.points
    weights = around.weights
    middle = weights @ points / weights.sum()
    motions = motions_of_point(points, middle)
    repeated = np.repeat(weights, points.shape[1])[:, None]
    if kinematics == "axisymmetric":
        along_axis = motions[:, 1:2]
        return np.asarray(repeated * along_axis / weights.sum())
    # The forces are weighted motions, scaled so that their resultants about the middle are unit
    # loads.
    sizes = np.maximum(np.abs(motions).max(axis=0), TINY)
    scaled = motions / sizes
    squares = scaled.T @ (repeated * scaled)
    inverse = np.linalg.pinv(squares, rcond=SAME_POINT, hermitian=True)
    forces = repeated * scaled @ inverse / sizes
    # A unit load on the point also has a moment about the middle.
    shift = motions_of_point(around.point[None], middle)
    to_middle = np.eye(motions.shape[1])
    to_middle[:, : points.shape[1]] = shift.T
    return np.asarray(forces @ to_middle)


def check_carried(part: Any, around: NodesAround, forces: Array, load: Array) -> None:
    """Check that nodal forces (n d, m) of unit loads have the resultants of a load (m,)."""
    points = around.points
    d = points.shape[1]
    if len(load) <= d:
        return
    reach = float(np.linalg.norm(points - around.point, axis=1).max())
    missing = np.abs(motions_of_point(points, around.point).T @ (forces @ load) - load)
    size = np.linalg.norm(load[:d]) * reach + np.linalg.norm(load[d:])
    if missing[:d].max() * reach > SAME_POINT * size or missing[d:].max() > SAME_POINT * size:
        raise ModelError(
            f"{part}: its nodes ({len(points)}) cannot carry the moment, because they lie on a "
            "line or are one node; name more nodes, or put the point on their line"
        )
