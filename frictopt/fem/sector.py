"""Sectors of a ring: the nodes of one cut face follow the nodes of the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, diags, identity, kron
from scipy.sparse.linalg import cg
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..base import (
    COUNTS,
    ROUNDING,
    SAME_POINT,
    Array,
    Booleans,
    Integers,
    finite_number,
    first_of,
    place,
)
from ..errors import ModelError
from .bodies import Body, check_names, numbered_nodes
from .elasticity import Kinematics, facet_nodes, in_space
from .faces import Face, facets_around
from .interface import ASKEW, blocks_of
from .supports import Seam, axis_of, checked_axis


@dataclass(frozen=True, eq=False)
class Sector:
    """Nodes of the high cut faces, which follow nodes of the low cut faces: `u_i = Q u_j`.

    Attributes
    ----------
    copies
        (all nodes,) node j of which each node i is a turned copy; -1: none.
    fixed
        Nodes on the axis, which both cut faces contain.
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
        """(d,) whether a coordinate axis lies across the axis of the ring.

        Nodes on the axis of the ring do not move along such coordinate axes.
        """
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
        return np.linalg.pinv(np.eye(len(self.turn)) - self.turn) @ self.shift

    def closed(self, bodies: Mapping[str, Body]) -> dict[str, Body]:
        """The bodies with copied nodes exactly at the turned places of their originals.

        Otherwise, because of errors of coordinates, a ring would slightly resist a turn about its
        axis.
        """
        if self.count == 1:
            return dict(bodies)
        centre = self._centre
        points = np.concatenate([body.mesh.p.T for body in bodies.values()])
        points[self.nodes] = points[self.copies[self.nodes]] @ self.turn.T + self.shift
        heights = (points[self.fixed] - centre) @ self.along
        points[self.fixed] = centre + np.multiply.outer(heights, self.along)
        own_nodes = numbered_nodes(bodies)
        return {name: body.moved(points[own_nodes[name]].T) for name, body in bodies.items()}

    @property
    def on_cuts(self) -> Integers:
        """All nodes that follow, or are followed."""
        return np.concatenate([self.nodes, self.copies[self.nodes], self.fixed])

    def follow(self, free_rows: Integers, points: Array) -> csr_matrix:
        """The matrix (size, size) of `u = C u` that lets nodes follow.

        The `free_rows` (nodes, d) of an assembly are -1 if held; they become -2 if a node follows.
        """
        nodes = self.nodes
        originals = self.copies[nodes]
        held = free_rows == -1
        # (n, d) how much each axis of a copy, turned back, lies along held axes of its original.
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
        stays = np.ones(points.shape)
        stays[nodes] = 0.0
        return csr_matrix(diags(stays.ravel()) + turned)

    def check_moved(self, argument: str, moved: Array, turned: Array, points: Array) -> None:
        """Check that the displacements (nodes, d) of supports repeat from sector to sector.

        `turned` (nodes, d) are the displacements of nodes that follow; NaN where none is given.
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
        """The pairs without the pairs of copied nodes, which are copies of other pairs.

        A pair of a copied node adds its normal and width to the pair of the node that it copies.
        `pairs` has for each pair the number of its contact, its node of body 1, its place on body 2
        (a row over all nodes), normal, width, gap, and whether it lies opposite body 2.
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
        # Each of the two gaps has the errors of two places.
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
        """For each pair of a copied node, the pair of the same contact that it copies; -1: none."""
        pairs = contact * len(self.copies) + nodes
        copied = contact[high] * len(self.copies) + self.copies[nodes[high]]
        number = dict(zip(pairs.tolist(), range(len(pairs)), strict=True))
        return np.array([number.get(pair, -1) for pair in copied.tolist()], dtype=np.intp)

    def _unmatched(
        self, nodes: Integers, projection: csr_matrix, high: Integers, low: Integers
    ) -> Booleans:
        """Pairs at the cuts without a pair at the other cut, or without a turned copy on body 2."""
        copies = self.copies
        links = projection.tocoo()
        columns = np.where(copies[links.col] >= 0, copies[links.col], links.col)
        turned = csr_matrix((links.data, (links.row, columns)), shape=projection.shape)
        follows = np.isin(links.col, self.nodes)
        unmatched = np.bincount(links.row, follows, minlength=len(nodes)) > 0
        unmatched |= np.isin(nodes, copies[self.nodes]) & ~np.isin(np.arange(len(nodes)), low)
        unmatched[high] = (low < 0) | (
            np.asarray(abs(turned[high] - projection[low]).sum(axis=1)).ravel() > COUNTS
        )
        return unmatched

    def seam(self, nodes: Integers) -> Seam | None:
        """Copied nodes of a body, the nodes that they copy, and Q; None if the body has none.

        `nodes` are the body's nodes.
        """
        copies = self.copies[nodes]
        copied = np.flatnonzero(copies >= 0)
        return (copied, copies[copied] - nodes[0], self.turn) if len(copied) else None


def on_seam(mass: csr_matrix, moments: Array, seam: Seam) -> Array:
    """Nodal values (3, 3, nodes) of a symmetric tensor, from its moments with the functions there.

    At nodes that copy others, the tensor is turned.
    """
    high, low, turn = seam
    n = mass.shape[0]
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
    of_leads = spread.T @ kron(mass, identity(9)) @ spread
    # A mass is well conditioned, so conjugate gradients take few steps.
    scaled = diags(1 / of_leads.diagonal())
    values = spread @ cg(of_leads, spread.T @ moments.T.ravel(), rtol=ROUNDING, M=scaled)[0]
    return np.asarray(values).reshape(n, 3, 3).T


@dataclass(frozen=True)
class Cyclic:
    """Sector of a ring: a body that represents all equal sectors of the ring.

    The displacements of one cut face follow the displacements of the other, turned about the axis.
    For each body that is cut, add one `Cyclic` to the supports of a model. The sectors must be
    alike, and so must their loads: turned by the angle of a sector, each load equals the load of
    the next sector.

    Limits and slips are then the limits and slips of the ring; forces, areas, widths, works and
    compliances refer to one sector. The ring and each body may turn about the axis and move along
    it, unless something holds them; they cannot move in any other way. A sector includes only slips
    that repeat from sector to sector, just as one half of a symmetric joint includes only symmetric
    slips. Faces at which neighbouring sectors slide on each other, such as shrouds of blades,
    cannot be cut faces.

    The meshes of both cut faces must match. A contact may reach the cut only if its nodes match
    there. Theory, "Sectors of a ring".

    Parameters
    ----------
    body
        Name of the body in its model.
    low, high
        Names of the two cut faces, boundaries of its mesh: `high` is `low` turned about the axis by
        360 degrees divided by a whole number. This number follows from the mesh. The faces may meet
        on the axis.
    axis
        Direction (x, y, z) of the axis of a body in space, of any length. In the plane the axis is
        normal to it.
    centre
        Point (x, y), in space (x, y, z), of the axis; None: the origin.
    tolerance
        Position tolerance, length: nodes of `high` that are at most this far from the turned nodes
        of `low` move onto them before assembly, without strain, see `Contact.adjust`.

    Raises
    ------
    ModelError
        A name is not a text, both faces have one name, or the axis has no direction. In a model:
        `high` is not a turned copy of `low` (the message has the largest distance between them);
        bodies have different axes or angles; supports or displacements differ between `high` and
        `low`; a contact reaches the cut with nodes that do not match; or the bodies are
        axisymmetric.

    Examples
    --------
    >>> import numpy as np
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> grid = MeshQuad.init_tensor([1.0, 1.5, 2.0], np.linspace(0, np.pi / 2, 5))
    >>> points = grid.p[0] * np.array([np.cos(grid.p[1]), np.sin(grid.p[1])])
    >>> faces = {
    ...     "low": lambda x: x[1] < 1e-9,
    ...     "high": lambda x: x[0] < 1e-9,
    ...     "bore": lambda x: np.hypot(*x) < 1.01,
    ...     "rim": lambda x: np.hypot(*x) > 1.9,
    ... }
    >>> mesh = MeshQuad(points, grid.t).with_boundaries(faces)
    >>> disc = MeshQuad(2 * mesh.p, mesh.t).with_boundaries(mesh.boundaries)
    >>> model = fo.fem.ContactModel(
    ...     {"ring": fo.fem.Body(mesh), "rim": fo.fem.Body(disc)},
    ...     supports=[
    ...         fo.fem.Cyclic("ring", "low", "high"),
    ...         fo.fem.Cyclic("rim", "low", "high"),
    ...         fo.fem.Support("rim", "rim"),
    ...     ],
    ...     loads={"fit": [fo.fem.Interference("rim", 1e-3)]},
    ...     contacts=[fo.fem.Contact("ring", "rim", "rim", "bore")],
    ... )
    >>> system = model.condense()  # the nodes on both cuts are one
    >>> system.nodes, round(float(system.width.sum()), 3)
    (4, 3.121)
    """

    body: str
    low: str
    high: str
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    centre: tuple[float, ...] | None = None
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        finite_number("tolerance", self.tolerance, least=0.0)
        check_names(self, "body", "low", "high")
        if self.low == self.high:
            raise ModelError(
                f"high: {self.high!r} is `low` too; name the two cut faces of the sector"
            )
        checked_axis(self)


def sector_of(cuts: Sequence[Cyclic], bodies: Mapping[str, Body], kinematics: Kinematics) -> Sector:
    """The sector of all bodies, with the numbers of their nodes in the model.

    Without cuts there is one sector, the whole ring.
    """
    sectors = _sectors(cuts, bodies, kinematics)
    _check_same_turn(sectors, bodies)
    own_nodes = numbered_nodes(bodies)
    copies = np.full(sum(map(len, own_nodes.values())), -1)
    fixed = np.zeros(0, dtype=np.intp)
    for name, sector in sectors.items():
        own = own_nodes[name]
        copies[own] = np.where(sector.copies < 0, -1, own[sector.copies])
        fixed = np.r_[fixed, own[sector.fixed]]
    d = next(iter(bodies.values())).mesh.dim()
    whole = Sector(copies, fixed, np.eye(d), np.zeros(d), np.zeros(d), count=1)
    return replace(next(iter(sectors.values()), whole), copies=copies, fixed=fixed)


def _sectors(
    cuts: Sequence[Cyclic], bodies: Mapping[str, Body], kinematics: Kinematics
) -> dict[str, Sector]:
    """Body -> its sector, for each body that is cut."""
    if cuts and kinematics == "axisymmetric":
        raise ModelError(
            f"supports: {cuts[0]} in an axisymmetric model, which is the whole ring; leave it out, "
            "or mesh the sector in space"
        )
    sectors: dict[str, Sector] = {}
    for cut in cuts:
        if cut.body not in bodies or cut.body in sectors:
            raise ModelError(
                f"supports: body {cut.body!r} of {cut} is unknown, or has another Cyclic; this "
                f"model has {sorted(bodies)}"
            )
        sectors[cut.body] = _sector(bodies[cut.body], cut)
    return sectors


def _check_same_turn(sectors: Mapping[str, Sector], bodies: Mapping[str, Body]) -> None:
    """Check that all sectors turn about the same axis by the same angle."""
    for name, sector in sectors.items():
        first_name, first = next(iter(sectors.items()))
        size = np.ptp(bodies[first_name].mesh.p)
        turn = np.abs(sector.turn - first.turn).max()
        shift = np.abs(sector.shift - first.shift).max() / size
        if max(turn, shift) > SAME_POINT:
            raise ModelError(
                f"supports: the sectors of bodies {first_name!r} and {name!r} have different axes "
                "or angles; give all bodies the same"
            )


def _sector(body: Body, cut: Cyclic) -> Sector:
    """The sector of one body, from the angle between its cut faces."""
    mesh = body.mesh
    d = mesh.dim()
    centre, along = axis_of(cut, d)
    argument = f"sector of body {cut.body!r}"
    low = body.boundary(cut.low, argument)
    high = body.boundary(cut.high, argument)
    angle = _angle(body, low, high, centre, along)
    # Largest number of sectors of a ring.
    most_sectors = 1000
    count = round(2 * np.pi / max(abs(angle), 2 * np.pi / most_sectors))
    # Either face may be named first.
    if angle < 0 and count > 2:
        low, high = high, low
    turn = Rotation.from_rotvec(2 * np.pi / count * along).as_matrix()[:d, :d]

    # At face `low`, the body must lie in the direction of the turn.
    x = mesh.p.T
    middles = x[mesh.facets[:, low]].mean(axis=0)
    onward = np.cross(along, in_space(middles - centre))[:, :d]
    if count > 2 and (onward * (x[mesh.t[:, mesh.f2t[0, low]]].mean(axis=0) - middles)).sum() < 0:
        raise ModelError(
            f"supports: body {cut.body!r} goes the long way round from {cut.low!r} to "
            f"{cut.high!r}, {360 - 360 / count:g} of 360 degrees; a sector is 360 degrees divided "
            "by a whole number"
        )

    back = (x - centre) @ turn + centre  # all nodes turned back by one sector
    nodes = facet_nodes(mesh, high)
    others = facet_nodes(mesh, low)
    fixed = np.intersect1d(nodes, others)
    errors = body.errors + cut.tolerance / 2
    turned = errors @ np.abs(turn)
    off, nearest = cKDTree(x[others]).query(back[nodes])
    if len(nodes) != len(others):
        off = np.maximum(off, cKDTree(back[nodes]).query(x[others])[0].max())
    allowed = np.linalg.norm(turned[nodes] + errors[others[nearest]], axis=1)
    off_axis = np.linalg.norm(back[fixed] - x[fixed], axis=1)
    is_off_axis = off_axis > np.linalg.norm(turned + errors, axis=1)[fixed]
    if len(nodes) != len(others) or (off > allowed).any() or is_off_axis.any():
        middles = ""
        if abs(abs(angle) * count - 2 * np.pi) > SAME_POINT:
            middles = f"; their middles are {np.degrees(angle):.6g} degrees apart"
        raise ModelError(
            f"supports: the faces {cut.high!r} and {cut.low!r} of body {cut.body!r} are not turned "
            f"copies of each other: turned by 360/{count} degrees about the axis, they are up to "
            f"{np.r_[off, off_axis].max():.4g} apart, more than {allowed.max():.1g}{middles}; give "
            "two faces that are turned copies, 360 degrees divided by a whole number apart, with "
            "one mesh (gmsh: setPeriodic), and check axis and centre; if the distance is noise, "
            "give the Cyclic a tolerance"
        )
    copies = np.full(len(x), -1)
    follows = ~np.isin(nodes, fixed)
    copies[nodes[follows]] = others[nearest[follows]]
    return Sector(copies, fixed, turn, centre - turn @ centre, along[:d], count)


def _angle(body: Body, low: Integers, high: Integers, centre: Array, along: Array) -> float:
    """Angle about the axis between the middles of the two cut faces, -pi to pi."""
    arms = np.zeros((2, 3))
    for arm, facets in zip(arms, (low, high), strict=True):
        face = Face(facets_around(body.mesh, facets), body.mesh.p.T, body.errors)
        arm[: len(centre)] = face.sizes @ face.corners.mean(axis=1) / face.sizes.sum() - centre
    low_arm, high_arm = arms
    sine = along @ np.cross(low_arm, high_arm)
    cosine = low_arm @ high_arm - (along @ low_arm) * (along @ high_arm)
    return float(np.arctan2(sine, cosine))
