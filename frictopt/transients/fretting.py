"""Tables of a steady cycle: fretting of each node, the state of each contact, tensions of bolts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    COUNTS,
    ROUNDING,
    SIMULTANEOUS,
    Array,
    Booleans,
    Integers,
    Table,
    components,
    finite_array,
    frame,
    listed,
    number_of,
    shown,
)
from ..base.results import named_places
from ..contact import ContactSystem, most_shear
from ..contact.diagnosis import nodes_of_contacts
from ..errors import ModelError
from .critical_plane import critical_planes, furthest
from .trajectory import Trajectory

MESH_NOTE = (
    "at the ends of a contact with sharp corners, tractions, F1, F2 and SWT are a property of the "
    "mesh; refine it before you compare them"
)
FORCES_NOTE = (
    "nodal forces, not tractions: the system has no width, which "
    "`condense(..., width=job.areas(pairs[:, 1]))` gives; "
)
ENDS_NOTE = "; from, to: least and largest normal stress in the cycle on the critical plane of SWT"


def fretting_table(
    states: Trajectory, work: Array, stress: ArrayLike | None, strain: ArrayLike | None
) -> Table:
    """The table of a steady cycle with work of friction (N,), see `SteadyState.fretting_table`."""
    system = states.system
    q = states.q * system.stretch
    names = ("q", "p") if system.width is None else ("tau", "pressure")
    unit = "_force" if system.width is None else ""
    width = np.ones(system.nodes) if system.width is None else system.width
    slip = slip_ways(states)
    slip_range = np.linalg.norm(slip, axis=-1)
    columns: dict[str, ArrayLike] = {
        "node": np.arange(system.nodes),
        **named_places(system),
        "slip_range": slip_range,
    }
    for name, values in zip(names, (q, states.p), strict=True):
        part = axes_of(values) / width[:, None]
        middle = (part.max(axis=0) + part.min(axis=0)) / 2
        columns[f"{name}_amplitude"] = np.linalg.norm(furthest(part), axis=-1) / 2
        columns |= components(f"{name}_mean", middle.reshape(values.shape[1:]))
    columns["work"] = work
    columns["share"] = work / (work.sum() or 1.0)
    if system.width is not None:
        columns["work_density"] = work / width
    first_ruiz = np.linalg.norm(axes_of(q), axis=-1).max(axis=0) / width * slip_range
    columns[f"F1{unit}"] = first_ruiz
    if (stress is None) != (strain is None):
        raise ModelError(
            "stress, strain: only one is given; give both, as BodyFields.at_contact returns them, "
            "or neither"
        )
    if stress is not None:
        if system.tangents > 1:
            # Nodes that do not slip have no direction of slip: NaN.
            slips = slip_range > COUNTS * np.abs(states.slip).max()
            slip = slip / np.where(slips, slip_range, np.nan)[:, None]
        sigma, epsilon = _along_slip(system, stress, strain, slip)
        tension = np.maximum(sigma.max(axis=0), 0.0)
        columns[f"F2{unit}"] = np.nan_to_num(tension) * first_ruiz
        columns["SWT"] = tension * np.ptp(epsilon, axis=0) / 2
    table = frame(columns, units=system.units)
    table.attrs["note"] = MESH_NOTE if system.width is not None else FORCES_NOTE + MESH_NOTE
    return table


def _along_slip(
    system: ContactSystem, stress: ArrayLike, strain: ArrayLike | None, direction: Array
) -> tuple[Array, Array]:
    """(M, N) stress and strain along the tangent, in space along unit vectors (N, 2)."""
    shape = (None, system.nodes) if system.tangents == 1 else (None, system.nodes, 2, 2)
    sigma = finite_array("stress", stress, shape)
    epsilon = finite_array("strain", strain, shape)
    if len(sigma) != len(epsilon) or not len(sigma):
        raise ModelError(
            f"stress, strain: {len(sigma)} and {number_of(len(epsilon), 'state')}; give both at "
            "the same states, at least one"
        )
    if system.tangents == 1:
        return sigma, epsilon
    return (
        np.einsum("mnab,na,nb->mn", sigma, direction, direction),
        np.einsum("mnab,na,nb->mn", epsilon, direction, direction),
    )


def axes_of(values: Array) -> Array:
    """(T, N, t) values with a last axis for the tangents."""
    return values if values.ndim == 3 else values[..., None]


def slip_ways(states: Trajectory) -> Array:
    """(N, t) largest difference of two slips of each node while closed; 0 if it is rounding."""
    slip = axes_of(states.slip / states.system.stretch)
    ways = furthest(np.where((states.gap <= 0)[..., None], slip, np.nan))
    ways[np.linalg.norm(ways, axis=-1) <= ROUNDING * np.abs(states.slip).max()] = 0.0
    return ways


def with_critical_planes(
    table: Table, fields: object, side: int, weights: Mapping[str, float]
) -> Table:
    """Add the parameters on critical planes; `fields` lists the fields at states of a cycle."""
    states = listed("fields", fields if np.iterable(fields) else [])
    if len(states) < 2 or not all(hasattr(state, "tensors_at_contact") for state in states):
        raise ModelError(
            "fields: give fields of ContactModel.recover at two states of a cycle or more, or the "
            "model itself"
        )
    tensors = [state.tensors_at_contact(side) for state in states]
    stress = np.array([pair[0] for pair in tensors])  # (M, N, 3, 3)
    strain = np.array([pair[1] for pair in tensors])
    if stress.shape[1] != len(table):
        raise ModelError(
            f"fields: they belong to a contact with {number_of(stress.shape[1], 'node')}, but this "
            f"contact has {len(table)}; give the fields of its model"
        )
    table = table.assign(**critical_planes(stress, strain, weights))
    table.attrs["note"] += ENDS_NOTE
    return table


def contact_table(
    states: Trajectory, slipping: Booleans, opened: Booleans, work: Array, model: Any
) -> Table:
    """The table of the contacts, see `SteadyState.by_contact`.

    `states` are the states of a steady cycle. `slipping` and `opened` are masks (N,) of the nodes,
    and `work` (N,) is their work of friction. If the model is given, its ties have rows, too.
    """
    system = states.system
    width = np.ones(system.nodes) if system.width is None else system.width
    faces = nodes_of_contacts(system)
    contacts = list(faces)
    member = np.array(list(faces.values()), dtype=float)  # (contacts, N)
    area = member @ width
    columns: dict[str, object] = {"contact": contacts, "nodes": member.sum(axis=1).astype(int)}
    if system.width is not None:
        columns["area"] = area
    shares = {
        "sticking": ~slipping & ~opened,
        "slipping": slipping,
        "open": opened & ~slipping,
    }
    for name, which in shares.items():
        columns[name] = member @ (width * which) / area
    columns["work"] = member @ work
    columns["slip_range"] = (member * np.linalg.norm(slip_ways(states), axis=-1)).max(axis=1)

    corners = states.cycle.corner_names
    q = axes_of(states.q * system.stretch)
    rows = rows_of_corners(states)
    for corner, row in enumerate(rows):
        columns[f"P_{corner}"] = member @ states.p[row]
        columns[f"Q_{corner}"] = _shear_through(member, system.frames, q[row])
        columns[f"fP_{corner}"] = member @ most_shear(system, states.friction, states.p[row])
    if model is not None and not hasattr(model, "ties"):
        raise ModelError(f"model: {shown(model)}; give the ContactModel that was condensed")
    table = frame(columns)
    if model is not None and model.ties:
        import pandas as pd  # imported here, because only tables need it

        of_ties = _rows_of_ties(model._through_ties(states, rows))
        table = pd.concat([table, of_ties], ignore_index=True)
    if system.units is not None:
        table.attrs["units"] = system.units
    table.attrs["corners"] = list(corners)
    table.attrs["note"] = "shares are of the area"
    if system.width is None:
        table.attrs["note"] = "shares are of the nodes: the system has no width"
    return table


def _rows_of_ties(through: Mapping[str, Array]) -> Table:
    """Rows of ties, from name -> (3, K) normal force, shear and moment at the corners.

    A tie has no nodes of a contact, and its whole area sticks.
    """
    rows = []
    for name, forces in through.items():
        row = {"contact": name, "nodes": 0, "sticking": 1.0}
        row |= dict.fromkeys(("slipping", "open", "work", "slip_range"), 0.0)
        for part, values in zip("PQM", forces, strict=True):
            row |= {f"{part}_{corner}": value for corner, value in enumerate(values)}
        rows.append(row)
    return frame(rows)


def rows_of_corners(states: Trajectory) -> Integers:
    """The numbers of the states at the corners, in the second cycle if the period is two."""
    times = states.time[-1] - np.arange(len(states.cycle.corners))[::-1]
    return np.asarray(np.searchsorted(states.time, times + SIMULTANEOUS) - 1)


def _shear_through(member: Array, frames: Array, q: Array) -> Array:
    """(contacts,) resultants of shear forces q (N, t), see `SteadyState.by_contact`."""
    resultant = member @ np.einsum("na,nad->nd", q, frames[:, :-1])
    size = np.linalg.norm(resultant, axis=1)
    if q.shape[1] == 2:
        return np.asarray(size)
    resultants = []
    for k, nodes in enumerate(member > 0):
        own_frames = frames[nodes]
        turns = np.abs(own_frames - own_frames[0]).max() > CONDENSATION
        resultants.append(size[k] if turns else resultant[k] @ own_frames[0, 0])
    return np.array(resultants)


def tensions(states: Trajectory) -> Table:
    """The tensions of locked bolts in a steady cycle, see `SteadyState.bolt_table`."""
    bolts = states.system.bolts
    if not bolts:
        raise ModelError(
            "system: it has no locked bolt; give the model a BoltPreload(..., locked=True)"
        )
    tension = np.array([states.tension(bolt) for bolt in bolts])
    low = tension.min(axis=1)
    high = tension.max(axis=1)
    columns = {
        "bolt": [*bolts],
        "force": [force for force, _ in bolts.values()],
        "tension_mean": (high + low) / 2,
        "tension_amplitude": (high - low) / 2,
    }
    return frame(columns, units=states.system.units)
