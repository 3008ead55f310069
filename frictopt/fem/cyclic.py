"""Sectors of rings: one cut face of a body follows the other, turned about the axis of the ring.

`sector_of` finds the angle of the sector and the nodes that follow, as a `Sector`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ..base import SAME_POINT, Array, Integers, check_text, finite_number
from ..errors import ModelError
from .bodies import Body
from .elasticity import Kinematics, facet_nodes
from .faces import areas_of, facets_around
from .sector import Sector
from .supports import axis_of, checked_axis


@dataclass(frozen=True)
class Cyclic:
    """Sector of a body that represents a whole ring of sectors.

    The displacements of one cut face follow the displacements of the other, turned about the axis.
    Add one `Cyclic` per body that is cut to the supports of a model. The sectors must be alike, and
    so must their loads: turned by the angle of a sector, each load equals the load of the next
    sector.

    Limits and slips are then the limits and slips of the ring; forces, areas, widths, works and
    compliances refer to one sector. The ring and each body may turn about the axis and move along
    it, unless something holds them; they cannot move in any other way. A sector includes only slips
    that repeat from sector to sector, as one half of a symmetric joint includes only symmetric
    slips. Faces at which neighbouring sectors slide on each other, such as shrouds of blades, are
    no cut faces.

    The meshes of both cut faces must match. A contact may reach the cut only if its nodes match
    there. Theory, "Sectors of a ring".

    Parameters
    ----------
    body
        Name of the body in its model.
    low, high
        Names of the two cut faces, boundaries of its mesh: `high` is `low` turned about the axis by
        360 degrees divided by a whole number. This number follows from the mesh. They may meet on
        the axis.
    axis
        Direction (x, y, z) of the axis of a body in space, of any length. In the plane the axis is
        normal to it.
    centre
        Point (x, y), in space (x, y, z), of the axis; None: the origin.
    tolerance
        Position tolerance, length: nodes of `high` that are so far from the turned nodes of `low`
        move onto them before assembly, without strain, see `Contact.adjust`.

    Raises
    ------
    ModelError
        Names that are no texts, one name for both faces, an axis without direction. In a model:
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
        check_text("body", self.body, "the name of a body of the model")
        for side in ("low", "high"):
            check_text(side, getattr(self, side), "the name of a boundary of the mesh")
        if self.low == self.high:
            raise ModelError(
                f"high: {self.high!r} is `low` too; name the two cut faces of the sector"
            )
        checked_axis(self)


def sector_of(cuts: Sequence[Cyclic], bodies: Mapping[str, Body], kinematics: Kinematics) -> Sector:
    """The nodes of all bodies, one body after the other, that follow other nodes.

    Without cuts the sector is the whole, the only one of its ring.
    """
    sectors = _sectors(cuts, bodies, kinematics)
    _check_same_turn(sectors, bodies)
    copies = list[Integers]()
    fixed = [np.zeros(0, dtype=np.intp)]
    start = 0
    for name, body in bodies.items():
        of_body = np.full(body.mesh.p.shape[1], -1)
        if name in sectors:
            of_body = sectors[name].copies
            fixed.append(start + sectors[name].fixed)
        copies.append(np.where(of_body < 0, -1, start + of_body))
        start += len(of_body)
    d = next(iter(bodies.values())).mesh.dim()
    whole = Sector(copies[0], fixed[0], np.eye(d), np.zeros(d), np.zeros(d), count=1)
    return replace(
        next(iter(sectors.values()), whole),
        copies=np.concatenate(copies),
        fixed=np.concatenate(fixed),
    )


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
    mesh = body.through_corners.mesh
    d = body.mesh.dim()
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
    x = body.mesh.p.T
    middles = x[mesh.facets[:, low]].mean(axis=0)
    onward = np.cross(along, np.pad(middles - centre, ((0, 0), (0, 3 - d))))[:, :d]
    if count > 2 and (onward * (x[mesh.t[:, mesh.f2t[0, low]]].mean(axis=0) - middles)).sum() < 0:
        raise ModelError(
            f"supports: body {cut.body!r} goes the long way round from {cut.low!r} to "
            f"{cut.high!r}, {360 - 360 / count:g} of 360 degrees; a sector is 360 degrees divided "
            "by a whole number"
        )

    back = (x - centre) @ turn + centre  # all nodes turned back by one sector
    nodes = facet_nodes(body.mesh, high)
    others = facet_nodes(body.mesh, low)
    fixed = np.intersect1d(nodes, others)
    errors = body.errors + cut.tolerance / 2
    turned = errors @ np.abs(turn)
    off, nearest = (np.asarray(found) for found in cKDTree(x[others]).query(back[nodes]))
    if len(nodes) != len(others):
        off = np.maximum(off, cKDTree(back[nodes]).query(x[others])[0].max())
    allowed = np.linalg.norm(turned[nodes] + errors[others[nearest]], axis=1)
    off_axis = np.linalg.norm(back[fixed] - x[fixed], axis=1)
    is_off_axis = off_axis > np.linalg.norm(turned + errors, axis=1)[fixed]
    if len(nodes) != len(others) or (off > allowed).any() or is_off_axis.any():
        apart = float(np.r_[off, off_axis].max())
        raise ModelError(_no_copies(cut, apart, float(allowed.max()), angle, count))
    copies = np.full(len(x), -1)
    follows = ~np.isin(nodes, fixed)
    copies[nodes[follows]] = others[nearest[follows]]
    return Sector(copies, fixed, turn, centre - turn @ centre, along[:d], count)


def _angle(body: Body, low: Integers, high: Integers, centre: Array, along: Array) -> float:
    """Angle about the axis between the middles of the two cut faces, -pi to pi."""
    mesh = body.through_corners.mesh
    arms = []
    for facets in (low, high):
        corners = body.mesh.p.T[facets_around(mesh, facets)]  # (facets, corners, d)
        sizes = np.linalg.norm(areas_of(corners), axis=1)
        arm = sizes @ corners.mean(axis=1) / sizes.sum() - centre
        arms.append(np.pad(arm, (0, 3 - len(arm))))
    low_arm, high_arm = arms
    sine = along @ np.cross(low_arm, high_arm)
    cosine = low_arm @ high_arm - (along @ low_arm) * (along @ high_arm)
    return float(np.arctan2(sine, cosine))


def _no_copies(cut: Cyclic, apart: float, allowed: float, angle: float, count: int) -> str:
    """Message on faces that are no turned copies of each other."""
    middles = ""
    if abs(abs(angle) * count - 2 * np.pi) > SAME_POINT:
        middles = f"; their middles are {np.degrees(angle):.6g} degrees apart"
    return (
        f"supports: the faces {cut.high!r} and {cut.low!r} of body {cut.body!r} are not turned "
        f"copies of each other: turned by 360/{count} degrees about the axis, they are up to "
        f"{apart:.4g} apart, more than {allowed:.1g}{middles}; give two faces that are turned "
        "copies, 360 degrees divided by a whole number apart, with one mesh (gmsh: setPeriodic), "
        "and check axis and centre; if the distance is noise, give the Cyclic a tolerance"
    )
