"""Pictures of models with their contacts, supports and loads, and of fields in their bodies."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..base import ROUNDING, Array
from ..plots.bodies import (
    Mesh,
    axes_of,
    corners,
    draw_bodies,
    draw_edges,
    finish_axes,
    legend_of_bodies,
)
from ..plots.style import (
    BLACK,
    GREY,
    AnyAxes,
    Look,
    arrows,
    as_is,
    picture,
    series,
    spread,
    together,
)
from .bodies import Body
from .bolts import BoltPreload
from .contacts import Interference
from .couplings import Coupling, RigidCoupling
from .elasticity import integration_points
from .loads import Displacement, Pressure, Traction
from .model import ContactModel
from .modes import Modes
from .recovery import BodyFields, von_mises
from .sector import Cyclic
from .supports import Support, nodes_of

# Largest displacement of a mode in a picture, as a share of the size of the bodies.
_BENT = 0.15

# Mark of a support that holds one direction.
_MARKS = {"x": ">", "y": "^", "z": "v"}


def _meshes(bodies: Mapping[str, Body]) -> dict[str, Mesh]:
    return {name: body.mesh for name, body in bodies.items()}


def _colors(count: int) -> list[str]:
    return [series(number, count)["color"] for number in range(count)]


@picture.register
def _model(model: ContactModel, ax: AnyAxes) -> AnyAxes:
    """Each body in its colour, contacts in black, held nodes as marks, and loads as arrows.

    In space the surfaces of the bodies are drawn. Arrows show the directions of each load case.
    """
    meshes = _meshes(model.bodies)
    (axes,), ends = axes_of(meshes, ax)
    in_space = ends.shape[1] == 3
    length = (0.12 if in_space else 0.08) * float((ends[1] - ends[0]).max())
    colors = _colors(len(meshes) + len(model.loads))
    draw_bodies(axes, meshes, colors, face=0.04, edge=0.5)
    _contacts(axes, model, in_space)
    _supports(axes, model, in_space)
    for case, color in zip(model.loads, colors[len(meshes) :], strict=True):
        load_arrows(axes, model, case, length, color)
    finish_axes(axes, ends, 0.1 * length)
    legend_of_bodies(axes, ax)
    return axes


def _contacts(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """The face of body 1 of each contact. Several contacts are numbered; the legend names them."""
    for number, contact in enumerate(model.contacts, start=1):
        mesh = model.bodies[contact.body_1].mesh
        facets = mesh.boundaries[contact.boundary_1]
        several = len(model.contacts) > 1
        label = as_is(f"{number}: {contact.name}") if several else "contact"
        if in_space:
            face = Poly3DCollection(
                corners(mesh, facets),
                facecolor=(BLACK, 0.6),
                edgecolor=BLACK,
                linewidth=0.3,
                label=label,
            )
            axes.add_collection3d(face)
        else:
            draw_edges(axes, mesh, facets, color=BLACK, lw=2.5, label=label)
        if several:
            middle = mesh.p[:, mesh.facets[:, facets]].mean(axis=(1, 2))
            box = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.5, "pad": 2.0}
            # The text stays above all faces, which matplotlib orders by their distance in space.
            axes.text(
                *middle, number, ha="center", va="center", bbox=box, fontsize="small", zorder=1e3
            )


def _supports(axes: AnyAxes, model: ContactModel, in_space: bool) -> None:
    """Marks at some nodes of each support, which show the directions that it holds."""
    look: Look = {"markersize": 3.5} if in_space else {"markersize": 4.5, "clip_on": False}
    for support in model.supports:
        body = model.bodies[support.body]
        if isinstance(support, Cyclic):
            nodes = [body.boundary_nodes(cut, "supports") for cut in (support.low, support.high)]
        else:
            nodes = [nodes_of(body, support.body, support.where)]
        marker, label = _mark(support, "xyz" if in_space else "xy")
        groups = [body.mesh.p[:, group] for group in nodes]
        points = [places[:, spread(places, 25 if in_space else 17)] for places in groups]
        axes.plot(*np.hstack(points), marker, color=BLACK, label=label, **look)


def _mark(support: Support | Cyclic | Coupling, axes: str) -> tuple[str, str]:
    """Marker and label of a support."""
    if isinstance(support, Cyclic):
        return "o", "cut of a sector"
    if not isinstance(support, Support):
        return "P", "rigid" if isinstance(support, RigidCoupling) else "held in the mean"
    held = support.directions or axes
    return _MARKS.get(held, "s"), f"held in {', '.join(held)}"


@picture.register
def _fields(fields: BodyFields, ax: AnyAxes) -> AnyAxes:
    """Nodal von Mises stress in all bodies; in space, its mean over each face of their surfaces.

    The colours end at the value that 99 of 100 nodes do not exceed.
    """
    meshes = _meshes(fields.bodies)
    (axes,), ends = axes_of(meshes, ax)
    in_space = ends.shape[1] == 3
    stress = {name: von_mises(rows) for name, rows in fields.stress.items()}
    highest = float(np.quantile(np.concatenate(list(stress.values())), 0.99))
    look: Look = {"cmap": "viridis", "rasterized": True, "clim": (0.0, highest)}
    if in_space:
        # All faces are in one collection, because only within a collection does matplotlib hide
        # faces behind others.
        faces = [face for mesh in meshes.values() for face in corners(mesh)]
        means = [
            stress[name][mesh.facets[:, mesh.boundary_facets()]].mean(axis=0)
            for name, mesh in meshes.items()
        ]
        collection = Poly3DCollection(faces, array=np.concatenate(means), **look)
        # White edges show the shape of a body where all its faces have the same dark colour.
        collection.set(edgecolor=("white", 0.3), linewidth=0.3)
        colours = axes.add_collection3d(collection)
    for name, mesh in meshes.items() if not in_space else ():
        t = mesh.t
        # A quadrilateral is drawn as two triangles.
        triangles = t.T if len(t) == 3 else np.concatenate([t[[0, 1, 2]].T, t[[0, 2, 3]].T])
        colours = axes.tripcolor(*mesh.p, triangles, stress[name], shading="gouraud", **look)
        draw_edges(axes, mesh, mesh.boundary_facets(), color=BLACK, lw=0.6)
    label = "von Mises stress (force per area)"
    # In space the colour bar is beside the labels of the axis z.
    place: Look = {"shrink": 0.6, "pad": 0.12} if in_space else {}
    axes.figure.colorbar(colours, ax=axes, extend="max", label=label, **place)
    finish_axes(axes, ends, 0.0)
    if ax is None and not in_space:
        axes.figure.set_layout_engine("compressed")
    return axes


@picture.register
def _modes(modes: Modes, ax: AnyAxes, numbers: Sequence[int]) -> AnyAxes:
    """The shapes of some modes: each body in its colour, over the undeformed body in grey."""
    panels, ends = axes_of(_meshes(modes.bodies), ax, len(numbers))
    for axes, number in zip(panels, numbers, strict=True):
        shape = {name: shapes[number] for name, shapes in modes.shapes.items()}
        axes.set_title(f"mode {number}: {modes.frequency[number]:.5g} (cycles per time)")
        _bent(axes, ends, modes.bodies, shape)
    legend_of_bodies(panels[-1], ax)
    return together(panels)


def _bent(
    axes: AnyAxes, ends: Array, bodies: Mapping[str, Body], shape: Mapping[str, Array]
) -> None:
    """Draw bodies under the displacements of a mode, whose size has no meaning."""
    size = float((ends[1] - ends[0]).max())
    largest = max(float(np.linalg.norm(u, axis=0).max()) for u in shape.values())
    bent = dict[str, Mesh]()
    for name, mesh in _meshes(bodies).items():
        draw_bodies(axes, {"as it was": mesh}, [GREY], face=0.0, edge=0.3)
        moves = _BENT * size / largest * shape[name]
        bent[name] = replace(mesh, doflocs=mesh.doflocs + moves)
    # Faces behind others must not shine through: bodies and bolts would look alike.
    draw_bodies(axes, bent, _colors(len(bent)), face=0.9, edge=0.4)
    finish_axes(axes, ends, _BENT * size)


def load_arrows(axes: AnyAxes, model: ContactModel, case: str, length: float, color: str) -> None:
    """Arrows of equal length along loaded boundaries, and a line of the legend.

    If a traction presses, its arrow ends on the face; all other arrows begin there. A load that
    does not act on a surface has at most one arrow, and the legend names its kind.
    """
    kinds = Counter[str]()
    in_space = model.kinematics == "space"
    look: Look = {"units": "inches", "width": 0.014, "headwidth": 6, "zorder": 2.5}
    if in_space:
        look = {"linewidth": 1.0, "arrow_length_ratio": 0.35}
    for part in model.loads[case]:
        if not isinstance(part, Traction | Pressure):
            # BoltPreload becomes "bolt preload".
            kinds[re.sub("(?<!^)(?=[A-Z])", " ", type(part).__name__).lower()] += 1
        if isinstance(part, BoltPreload | Displacement | Interference):
            continue
        body = model.bodies[part.body]
        if isinstance(part, Traction | Pressure):
            begin, step = _on_surface(part, body, length)
        else:
            forces = part._forces(body, model.kinematics or "plane_strain")
            begin, step = _resultant(forces, body.mesh.p, length)
        arrows(axes, begin, step, color=color, **look)
    label = f"load {as_is(case)}"
    if kinds:
        label += f" ({', '.join(f'{count} x {kind}' for kind, count in kinds.items())})"
    axes.plot([], [], color=color, marker=">", label=label)


def _on_surface(part: Traction | Pressure, body: Body, length: float) -> tuple[Array, Array]:
    """(n, d) origins and steps of arrows along the mean tractions of facets.

    Nodal forces would mislead: at corners of quadratic elements they are zero up to rounding, or
    point against the load.
    """
    facets = body.boundary(part.boundary, "loads")
    places, outward, sizes, *_ = integration_points(body.mesh, facets)
    share = sizes / sizes.sum(axis=1, keepdims=True)
    fields = places, part._on_face(places, outward), outward
    points, traction, normals = ((values * share).sum(axis=2) for values in fields)
    strength = np.linalg.norm(traction, axis=0)
    chosen = [facet for facet in spread(points, 9) if strength[facet] > 0]
    step = traction[:, chosen] / strength[chosen] * length
    # A traction presses if it has a component, beyond rounding, against the outward normal.
    presses = (step * normals[:, chosen]).sum(axis=0) < -1e-3 * length
    return (points[:, chosen] - np.where(presses, step, 0.0)).T, step.T


def _resultant(forces: Array, places: Array, length: float) -> tuple[Array, Array]:
    """(1, d) origin and step of an arrow along the sum of nodal forces (d, n).

    The arrow begins at the outermost loaded node, because inside a body it would be hidden. Forces
    that balance each other, such as the forces of an expansion, have no arrow: the result is (0,
    d).
    """
    strength = np.linalg.norm(forces, axis=0)
    total = forces.sum(axis=1)
    size = np.linalg.norm(total)
    if size <= ROUNDING * strength.sum():
        none = np.empty((0, len(total)))
        return none, none
    direction = total / size
    middle = places @ strength / strength.sum()
    end = (direction @ places[:, strength > 0]).max()
    begin = middle + (end - direction @ middle) * direction
    return begin[None], length * direction[None]
