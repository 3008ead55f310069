"""A steady cycle contact by contact: how much of it slips or opens, its work, and the forces through it at the corners; and bolt by bolt."""

import numpy as np

from ..contact import CONDENSATION, SIMULTANEOUS, Array, Booleans, Table, frame, most_shear
from ..errors import ModelError
from .fretting import axes_of, slip_ways
from .trajectory import Trajectory


def contact_table(states: Trajectory, slipping: Booleans, opened: Booleans, work: Array) -> Table:
    """The table of the states of a steady cycle, with (N,) which nodes slip or open and their work, see `SteadyState.by_contact`."""
    system = states.system
    width = np.ones(system.nodes) if system.width is None else system.width
    names = np.full(system.nodes, "the contact") if system.contact is None else np.asarray(system.contact)
    contacts = list(dict.fromkeys(names.tolist()))
    member = np.array([names == name for name in contacts], dtype=float)  # (contacts, N)
    area = member @ width
    columns: dict[str, object] = {"contact": contacts, "nodes": member.sum(axis=1).astype(int)}
    if system.width is not None:
        columns["area"] = area
    for name, which in (("sticking", ~slipping & ~opened), ("slipping", slipping), ("open", opened & ~slipping)):
        columns[name] = member @ (width * which) / area
    columns["work"] = member @ work
    columns["slip_range"] = (member * np.linalg.norm(slip_ways(states), axis=-1)).max(axis=1)
    corners = states.cycle.corner_names
    ends = states.time[-1] - np.arange(len(corners))[::-1]  # of a period of two cycles the last one
    for corner, row in enumerate(np.searchsorted(states.time, ends + SIMULTANEOUS) - 1):
        columns[f"P_{corner}"] = member @ states.p[row]
        columns[f"Q_{corner}"] = _shear(member, system.frames, axes_of(states.q * system.stretch)[row])
        columns[f"fP_{corner}"] = member @ most_shear(system, states.friction, states.p[row])
    table = frame(columns, units=system.units)
    table.attrs["corners"] = list(corners)
    table.attrs["note"] = "shares are of the nodes: the system has no width" if system.width is None else "shares are of the area"
    return table


def _shear(member: Array, frames: Array, q: Array) -> Array:
    """(contacts,) resultants of shear forces q (N, t), see `SteadyState.by_contact`."""
    resultant = member @ np.einsum("na,nad->nd", q, frames[:, :-1])
    if q.shape[1] == 2:
        return np.asarray(np.linalg.norm(resultant, axis=1))
    first = frames[member.argmax(axis=1)]  # (contacts, 2, 2), those of the first node
    turns = np.array([np.abs(frames[own > 0] - one).max() > CONDENSATION for own, one in zip(member, first, strict=True)])
    return np.asarray(np.where(turns, np.linalg.norm(resultant, axis=1), np.einsum("cd,cd->c", resultant, first[:, 0])))


def tensions(states: Trajectory) -> Table:
    """What locked bolts carry in the states of a steady cycle, see `SteadyState.bolt_table`."""
    bolts = states.system.bolts
    if not bolts:
        raise ModelError("system: it has no locked bolt; give the model a BoltPreload(..., locked=True)")
    tension = np.array([states.tension(bolt) for bolt in bolts])
    low, high = tension.min(axis=1), tension.max(axis=1)
    columns = {
        "bolt": [*bolts],
        "force": [force for force, _ in bolts.values()],
        "tension_mean": (high + low) / 2,
        "tension_amplitude": (high - low) / 2,
    }
    return frame(columns, units=states.system.units)
