"""What frets where: a steady cycle, node by node, in the words of fretting fatigue, and its parameters on critical planes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    COUNTS,
    SIMULTANEOUS,
    Array,
    Booleans,
    Table,
    components,
    finite_array,
    frame,
    listed,
)
from ..base.results import named_places
from ..contact import most_shear
from ..errors import ModelError
from .trajectory import Trajectory

_NOTE = "at the ends of a contact with sharp corners, tractions, F1, F2 and SWT are a property of the mesh; refine it before you compare them"
_ENDS_NOTE = "; from, to: least and largest normal stress in the cycle on the critical plane of SWT"
_PLANES, _BEST = (
    800,
    20,
    # planes that are tried first, 5 degrees apart, and the best of them: one alone may be beside a
    # lower peak
)
_STEP, _FINER, _ROUNDS = (
    5.0,
    0.4,
    10,
    # degrees of the first steps about them, how much smaller they become, and how often: at last 0.001
    # degrees
)


def fretting_table(
    states: Trajectory, work: Array, stress: ArrayLike | None, strain: ArrayLike | None
) -> Table:
    """The table of a steady cycle with so much work of friction at each node, (N,), see `SteadyState.fretting_table`."""
    system, q = states.system, states.q * states.system.stretch
    width, names, unit = (
        (system.width, ("tau", "pressure"), "")
        if system.width is not None
        else (np.ones(system.nodes), ("q", "p"), "_force")
    )
    way = slip_ways(states)
    slip = np.linalg.norm(way, axis=-1)
    columns: dict[str, ArrayLike] = {
        "node": np.arange(system.nodes),
        **named_places(system),
        "slip_range": slip,
    }
    for name, values in zip(names, (q, states.p), strict=True):
        part = axes_of(values) / width[:, None]
        columns[f"{name}_amplitude"] = np.linalg.norm(furthest(part), axis=-1) / 2
        columns |= components(
            f"{name}_mean", ((part.max(axis=0) + part.min(axis=0)) / 2).reshape(values.shape[1:])
        )
    columns["work"], columns["share"] = work, work / (work.sum() or 1.0)
    if system.width is not None:
        columns["work_density"] = work / width
    columns[f"F1{unit}"] = first = np.linalg.norm(axes_of(q), axis=-1).max(axis=0) / width * slip
    if (stress is None) != (strain is None):
        raise ModelError(
            "stress, strain: one of them alone; give both, as BodyFields.at_contact does, or none"
        )
    if stress is not None:
        shape = (None, system.nodes) if system.tangents == 1 else (None, system.nodes, 2, 2)
        sigma, epsilon = (
            finite_array(name, values, shape)
            for name, values in (("stress", stress), ("strain", strain))
        )
        if len(sigma) != len(epsilon) or not len(sigma):
            raise ModelError(
                f"stress, strain: {len(sigma)} and {len(epsilon)} states; give both at the same states, at least one"
            )
        if system.tangents > 1:
            way = way / np.where(slip > COUNTS * np.abs(states.slip).max(), slip, np.nan)[:, None]
            sigma, epsilon = (
                np.einsum("mnab,na,nb->mn", part, way, way) for part in (sigma, epsilon)
            )
        tension = np.maximum(sigma.max(axis=0), 0.0)
        columns[f"F2{unit}"], columns["SWT"] = (
            np.nan_to_num(tension) * first,
            tension * np.ptp(epsilon, axis=0) / 2,
        )
    table = frame(columns, units=system.units)
    less = "nodal forces, not tractions: the system has no width, which `condense(..., width=job.areas(pairs[:, 1]))` gives; "
    table.attrs["note"] = _NOTE if system.width is not None else less + _NOTE
    return table


def axes_of(values: Array) -> Array:
    """(T, N, t) values with a last axis for the tangents."""
    return values if values.ndim == 3 else values[..., None]


def slip_ways(states: Trajectory) -> Array:
    """(N, t) difference of those two slips of each node, while it is closed, that are furthest apart."""
    return furthest(
        np.where((states.gap <= 0)[..., None], axes_of(states.slip / states.system.stretch), np.nan)
    )


def with_worst_planes(
    table: Table, fields: object, side: int, weights: Mapping[str, float]
) -> Table:
    """Add parameters from fields at the states of one cycle, or a list of such lists: at each node and for each parameter the worst cycle."""
    tensors, given = "tensors_at_contact", listed("fields", fields if np.iterable(fields) else [])
    cycles = (
        [given]
        if given and hasattr(given[0], tensors)
        else [listed("fields", cycle if np.iterable(cycle) else []) for cycle in given]
    )
    if not cycles or not all(
        len(cycle) > 1 and all(hasattr(state, tensors) for state in cycle) for cycle in cycles
    ):
        raise ModelError(
            "fields: give fields of ContactModel.recover at two states of a cycle or more, a list of such lists, or the model itself"
        )
    found = [_columns(cycle, side, weights) for cycle in cycles]
    worst = {
        name: np.max([one[name] for one in found], axis=0)
        for name in ("SWT", "Findley", "Fatemi_Socie", "Crossland")
    }
    first = np.argmax([one["SWT"] for one in found], axis=0)
    ends = {name: np.choose(first, [one[name] for one in found]) for name in ("from", "to")}
    if len(first) != len(table):
        raise ModelError(
            f"fields: those of a contact with {len(first)} nodes, this one has {len(table)}; give those of its model"
        )
    table = table.assign(**worst, **ends)
    table.attrs["note"] += _ENDS_NOTE
    return table


def _columns(cycle: Sequence[Any], side: int, weights: Mapping[str, float]) -> dict[str, Array]:
    stress, strain = (
        np.array(parts)
        for parts in zip(*(state.tensors_at_contact(side) for state in cycle), strict=True)
    )
    rows = [
        critical_planes(stress[:, node], strain[:, node], **weights)
        for node in range(stress.shape[1])
    ]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def critical_planes(
    stress: ArrayLike, strain: ArrayLike, *, findley: float, crossland: float, fatemi_socie: float
) -> dict[str, float]:
    """Parameters of one point over M states, each on the plane through it on which the parameter is largest.

    Stress, tension positive, and strain are (M, 3, 3). Amplitudes of vectors are half the largest
    distance of two states, which is exact for loads in phase. Weights are those of
    `SteadyState.fretting_table`. SWT is the largest tensile stress on the plane times the amplitude
    of its normal strain, and `from` and `to` are the least and largest normal stress on that plane;
    Findley is the shear amplitude plus `findley` times the largest normal stress; Fatemi_Socie the
    amplitude of the shear angle times 1 plus `fatemi_socie` times the largest normal stress, or 0
    where pressure makes that negative; Crossland, which has no plane, the amplitude of the root of
    J2 plus `crossland` times the largest hydrostatic stress.

    Examples
    --------
    >>> import numpy as np
    >>> from frictopt.transients.fretting import critical_planes
    >>> pull = np.diag([100.0, 0.0, 0.0])
    >>> found = critical_planes([pull, -pull], [pull / 200e3, -pull / 200e3], findley=0.0, crossland=0.0, fatemi_socie=0.0)
    >>> round(found["SWT"], 9), round(found["Findley"], 6), round(found["Crossland"], 6), round(found["from"], 6)
    (0.05, 50.0, 57.735027, -100.0)
    """
    sigma, epsilon = np.asarray(stress, dtype=float), np.asarray(strain, dtype=float)
    pressure = np.trace(sigma, axis1=1, axis2=2) / 3
    deviator = sigma - pressure[:, None, None] * np.eye(3)

    def swt(n: Array) -> Array:
        normal = _normal(epsilon, n)
        return np.asarray(
            np.maximum(_normal(sigma, n).max(axis=0), 0.0)
            * (normal.max(axis=0) - normal.min(axis=0))
            / 2
        )

    def shear(n: Array) -> Array:
        return np.asarray(_amplitude(_shear(sigma, n)) + findley * _normal(sigma, n).max(axis=0))

    def angle(n: Array) -> Array:
        return np.asarray(
            2
            * _amplitude(_shear(epsilon, n))
            * (1 + fatemi_socie * _normal(sigma, n).max(axis=0)).clip(0.0)
        )

    plane = _worst(swt)
    normal = _normal(sigma, plane)
    return {
        "SWT": float(swt(plane)[0]),
        "Findley": float(shear(_worst(shear))[0]),
        "Fatemi_Socie": float(angle(_worst(angle))[0]),
        "Crossland": float(
            _amplitude(deviator.reshape(len(sigma), 9)) / np.sqrt(2) + crossland * pressure.max()
        ),
        "from": float(normal.min()),
        "to": float(normal.max()),
    }


def _normal(tensors: Array, n: Array) -> Array:
    """(M, planes) normal components on planes with normals (planes, 3)."""
    return np.asarray(np.einsum("pi,mij,pj->mp", n, tensors, n))


def _shear(tensors: Array, n: Array) -> Array:
    """(M, planes, 3) components along the planes."""
    return np.asarray(np.einsum("mij,pj->mpi", tensors, n) - _normal(tensors, n)[..., None] * n)


def _amplitude(vectors: Array) -> Array:
    """Half the largest distance of two of M vectors, (M, ..., k)."""
    return np.asarray(np.linalg.norm(furthest(vectors), axis=-1) / 2)


def furthest(values: Array) -> Array:
    """(..., k) difference of those two of M vectors, (M, ..., k), that are furthest apart and not NaN; 0 where there are none."""
    if values.shape[-1] == 1:
        return np.asarray(
            np.nan_to_num(np.fmax.reduce(values, axis=0) - np.fmin.reduce(values, axis=0))
        )
    found: Array = np.zeros(values.shape[1:])
    for apart in range(1, len(values)):
        change = values[apart:] - values[:-apart]
        size = np.nan_to_num(np.linalg.norm(change, axis=-1), nan=0.0)[..., None]
        best = np.take_along_axis(change, size.argmax(axis=0)[None], axis=0)[0]
        found = np.where(
            size.max(axis=0) > np.linalg.norm(found, axis=-1, keepdims=True), best, found
        )
    return found


def _worst(value: Callable[[Array], Array]) -> Array:
    """(1, 3) normal of the plane with the largest value: the best of even points on the half-sphere, then of ever finer grids about each of these."""
    height, turn = (
        (np.arange(_PLANES) + 0.5) / _PLANES,
        np.pi * (1 + np.sqrt(5)) * np.arange(_PLANES),
    )
    even = np.column_stack(
        [np.sqrt(1 - height**2) * np.cos(turn), np.sqrt(1 - height**2) * np.sin(turn), height]
    )
    best, step, around = (
        even[np.argsort(value(even))[-_BEST:]],
        _STEP,
        np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], dtype=float),
    )
    for _ in range(_ROUNDS):
        first = np.cross(best, np.eye(3)[np.abs(best).argmin(axis=1)])
        first /= np.linalg.norm(first, axis=1)[:, None]
        tilted = best[:, None] + np.tan(np.radians(step)) * (
            around @ np.stack([first, np.cross(best, first)], axis=1)
        )
        tilted /= np.linalg.norm(tilted, axis=2)[..., None]
        most = value(tilted.reshape(-1, 3)).reshape(len(best), -1).argmax(axis=1)
        best, step = tilted[np.arange(len(best)), most], step * _FINER
    return best[[int(np.argmax(value(best)))]]


def contact_table(states: Trajectory, slipping: Booleans, opened: Booleans, work: Array) -> Table:
    """The table of the states of a steady cycle, with (N,) which nodes slip or open and their work, see `SteadyState.by_contact`."""
    system = states.system
    width = np.ones(system.nodes) if system.width is None else system.width
    names = (
        np.full(system.nodes, "the contact")
        if system.contact is None
        else np.asarray(system.contact)
    )
    contacts = list(dict.fromkeys(names.tolist()))
    member = np.array([names == name for name in contacts], dtype=float)  # (contacts, N)
    area = member @ width
    columns: dict[str, object] = {"contact": contacts, "nodes": member.sum(axis=1).astype(int)}
    if system.width is not None:
        columns["area"] = area
    for name, which in (
        ("sticking", ~slipping & ~opened),
        ("slipping", slipping),
        ("open", opened & ~slipping),
    ):
        columns[name] = member @ (width * which) / area
    columns["work"] = member @ work
    columns["slip_range"] = (member * np.linalg.norm(slip_ways(states), axis=-1)).max(axis=1)
    corners = states.cycle.corner_names
    ends = states.time[-1] - np.arange(len(corners))[::-1]  # of a period of two cycles the last one
    for corner, row in enumerate(np.searchsorted(states.time, ends + SIMULTANEOUS) - 1):
        columns[f"P_{corner}"] = member @ states.p[row]
        columns[f"Q_{corner}"] = _shear_through(
            member, system.frames, axes_of(states.q * system.stretch)[row]
        )
        columns[f"fP_{corner}"] = member @ most_shear(system, states.friction, states.p[row])
    table = frame(columns, units=system.units)
    table.attrs["corners"] = list(corners)
    table.attrs["note"] = (
        "shares are of the nodes: the system has no width"
        if system.width is None
        else "shares are of the area"
    )
    return table


def _shear_through(member: Array, frames: Array, q: Array) -> Array:
    """(contacts,) resultants of shear forces q (N, t), see `SteadyState.by_contact`."""
    resultant = member @ np.einsum("na,nad->nd", q, frames[:, :-1])
    if q.shape[1] == 2:
        return np.asarray(np.linalg.norm(resultant, axis=1))
    first = frames[member.argmax(axis=1)]  # (contacts, 2, 2), those of the first node
    turns = np.array(
        [
            np.abs(frames[own > 0] - one).max() > CONDENSATION
            for own, one in zip(member, first, strict=True)
        ]
    )
    return np.asarray(
        np.where(
            turns, np.linalg.norm(resultant, axis=1), np.einsum("cd,cd->c", resultant, first[:, 0])
        )
    )


def tensions(states: Trajectory) -> Table:
    """What locked bolts carry in the states of a steady cycle, see `SteadyState.bolt_table`."""
    bolts = states.system.bolts
    if not bolts:
        raise ModelError(
            "system: it has no locked bolt; give the model a BoltPreload(..., locked=True)"
        )
    tension = np.array([states.tension(bolt) for bolt in bolts])
    low, high = tension.min(axis=1), tension.max(axis=1)
    columns = {
        "bolt": [*bolts],
        "force": [force for force, _ in bolts.values()],
        "tension_mean": (high + low) / 2,
        "tension_amplitude": (high - low) / 2,
    }
    return frame(columns, units=states.system.units)
