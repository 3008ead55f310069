"""Load cases of an assembled model: nodal forces, moved supports and interferences."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from ..base import ROUNDING, Array, Booleans, choice, first_of, place
from ..errors import ModelError
from .assembly import Assembly
from .bodies import Body, on_axis
from .bolts import BoltPreload
from .contacts import Interference
from .elasticity import Kinematics
from .loads import (
    BodyForce,
    Centrifugal,
    Displacement,
    Expansion,
    NodalForces,
    Pressure,
    Traction,
    values_at,
)
from .node_forces import PointForce, RemoteForce
from .supports import nodes_of

Load: TypeAlias = (
    Traction
    | Pressure
    | PointForce
    | RemoteForce
    | BodyForce
    | Centrifugal
    | Expansion
    | Displacement
    | Interference
    | BoltPreload
    | NodalForces
)


def load_case(model: Assembly, argument: str, loads: Sequence[Load]) -> tuple[Array, Array, Array]:
    """Nodal forces (size,), displacements (size,), and overlaps (N,) of the pairs in a load case.

    Only moved supports, the nodes glued to them, and the far face of a locked bolt (shortened by 1)
    have displacements other than zero. Error messages call the load case `argument`.
    """
    forces = np.zeros(model.points.shape)
    prescribed = np.full(model.points.shape, np.nan)  # nan: not prescribed
    overlaps = dict.fromkeys(model.names, 0.0)
    for load in loads:
        if isinstance(load, Interference):
            overlaps[choice(f"{argument}: contact", load.contact, overlaps)] += load.amount
        elif isinstance(load, Displacement):
            _prescribe(model, argument, load, prescribed)
        elif not (isinstance(load, BoltPreload) and load.locked):
            body = model.body(argument, load.body)
            if isinstance(load, Traction | Pressure):
                body.boundary(load.boundary, argument)
            if isinstance(load, PointForce | RemoteForce):
                _check_once(model, argument, load)
            forces[model.own_nodes[load.body]] += load._forces(body, model.kinematics).T
    given = float(np.abs(forces).max())
    felt = model.tied.T @ forces.ravel()
    _check_felt(model, argument, loads, felt.reshape(forces.shape), given)

    displacements = _glued_along(model, argument, prescribed, loads)
    for cut in model.cuts:
        shortening = 1.0 if cut.bolt.locked and cut.bolt in loads else 0.0
        displacements[cut.far] = displacements[cut.near] - cut.axis * shortening
    return felt, displacements.ravel(), np.array(list(overlaps.values()))[model.contact]


def _check_once(model: Assembly, argument: str, load: PointForce | RemoteForce) -> None:
    """Check that no node on a cut of a sector gets its force twice, once through its copy."""
    if isinstance(load, RemoteForce) and isinstance(load.where, str):
        return  # nodes are weighted by area, so a node and its copy together count once
    body = model.body(argument, load.body)
    nodes = model.own_nodes[load.body][nodes_of(body, load.body, load.where)]
    copied = np.intersect1d(nodes, model.sector.nodes)
    if len(copied):
        raise ModelError(
            f"{argument}: {load} has the node at {place(model.points[copied[0]])} on the cut "
            "`high` of a sector, which is a copy of a node on `low`: leave nodes on `high` out"
        )


def _prescribe(model: Assembly, argument: str, load: Displacement, prescribed: Array) -> None:
    """Enter a displacement into `prescribed` (nodes, d); nan: not prescribed."""
    nodes = model.nodes(argument, load)
    body = model.body(argument, load.body)
    points = body.written[:, nodes - model.own_nodes[load.body][0]]
    for name in "xyz":
        amount = getattr(load, name)
        if amount is None:
            continue
        (axis,) = model.axes(argument, load.body, name)
        values = values_at(f"displacement {name}", amount, points)
        if np.any(model.free_rows[nodes, axis] != -1):
            raise ModelError(
                f"{argument}: {load} moves nodes in {name} that no support holds; hold them by a "
                "Support"
            )
        if model.kinematics == "axisymmetric" and axis == 0:
            is_on_axis = on_axis(model.points[:, 0])[nodes]
            off_axis = values[is_on_axis & (np.abs(values) > ROUNDING * np.abs(values).max())]
            if off_axis.size:
                raise ModelError(
                    f"{argument}: {load} moves nodes by {off_axis[0]:g} off the axis, x = 0; give "
                    "a function of x that is zero there"
                )
        before = prescribed[nodes, axis]
        differs = np.abs(before - values) > ROUNDING * np.maximum(np.abs(before), np.abs(values))
        if (i := first_of(differs)) is not None:
            raise ModelError(
                f"{argument}: {load} and another displacement move the node at "
                f"{place(model.points[nodes[i]])} differently in {name}; give one displacement"
            )
        prescribed[nodes, axis] = values


def _glued_along(model: Assembly, argument: str, prescribed: Array, loads: Sequence[Load]) -> Array:
    """Displacements (nodes, d) of moved supports, and of the nodes that are glued to them."""
    displacements = np.nan_to_num(prescribed)
    followed = (model.tied @ displacements.ravel()).reshape(displacements.shape)
    model.sector.check_moved(argument, prescribed, followed, model.points)
    model.sector.check_loads(argument, loads)
    if not displacements.any():
        return displacements

    rounding = ROUNDING * np.abs(displacements).max()
    held, opening = model.held
    imposed = np.abs(opening @ displacements) > rounding
    _check_together(argument, imposed, model.points[held])
    dependent, _, Q = model.pairs.dependent_nodes
    glued = Q @ displacements
    # On a plane of symmetry a dependent node follows only those nodes of its pair that lie on it.
    held_share = Q @ (model.free_rows < 0)
    error = np.abs(displacements[dependent] * held_share - glued)
    is_prescribed = ~np.isnan(prescribed[dependent])
    _check_together(argument, is_prescribed & (error > rounding), model.points[dependent])
    displacements[dependent] = np.where(is_prescribed, displacements[dependent], glued)
    return displacements


def _check_together(argument: str, differs: Booleans, points: Array) -> None:
    """Check that displacements do not move both bodies at points (n, d) in different ways."""
    if (i := first_of(differs.any(axis=1))) is not None:
        raise ModelError(
            f"{argument}: a displacement moves both bodies at {place(points[i])}, in different "
            "ways; give both the same displacement"
        )


def _check_felt(
    model: Assembly, argument: str, loads: Sequence[Load], forces: Array, largest: float
) -> None:
    """Check that supports do not carry all the forces of a load case right where the forces act.

    `forces` are (nodes, d), and `largest` is the largest force before couplings pass it on.
    """
    on_places = [
        load for load in loads if isinstance(load, Traction | Pressure | PointForce | RemoteForce)
    ]
    felt = np.abs(forces[model.free_rows != -1]).max(initial=0.0)
    if len(on_places) < len(loads) or largest == 0 or felt > ROUNDING * largest:
        return
    bodies = {load.body for load in on_places}
    supports = [
        support for support in (*model.supports, *model.couplings) if support.body in bodies
    ]
    raise ModelError(
        f"{argument}: {on_places} act only where supports hold the body, {supports}; load another "
        "boundary, or hold fewer directions"
    )


def load_sizes(
    loads: Mapping[str, Sequence[Any]], bodies: Mapping[str, Body], kinematics: Kinematics
) -> dict[str, float]:
    """Load case name -> integral of the absolute values of its tractions and forces per volume.

    Forces on nodes count with their absolute values. Load cases that contain moments or other
    loads, or have no size, are left out.
    """
    sizes = {}
    for name, parts in loads.items():
        if not all(hasattr(part, "_size") for part in parts):
            continue
        size = sum(part._size(bodies[part.body], kinematics) for part in parts)
        if size > 0:
            sizes[name] = size
    return sizes
