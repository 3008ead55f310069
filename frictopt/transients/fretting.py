"""What frets where: the steady cycle of a contact, node by node, in the words of fretting fatigue."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..contact.checks import Array, finite_array
from ..contact.show import components, frame, places
from ..contact.tolerances import COUNTS
from ..errors import ModelError
from .critical_plane import furthest
from .trajectory import Trajectory

if TYPE_CHECKING:
    import pandas as pd

_NOTE = "at the ends of a contact with sharp corners, tractions, F1, F2 and SWT are a property of the mesh; refine it before you compare them"


def fretting_table(states: Trajectory, work: Array, stress: ArrayLike | None, strain: ArrayLike | None) -> "pd.DataFrame":
    """The table of a steady cycle with so much work of friction at each node, (N,), see `SteadyState.fretting_table`."""
    system = states.system
    width, names, unit = (system.width, ("tau", "pressure"), "") if system.width is not None else (np.ones(system.nodes), ("q", "p"), "_force")
    closed = states.gap <= 0
    way = furthest(np.where(closed[..., None], _axes(states.slip), np.nan))
    slip = np.linalg.norm(way, axis=-1)
    columns: dict[str, ArrayLike] = {"node": np.arange(system.nodes)}
    if system.contact is not None:
        columns["contact"] = system.contact
    columns |= {**places(system), "slip_range": slip}
    for name, values in zip(names, (states.q, states.p), strict=True):
        part = _axes(values) / width[:, None]
        columns[f"{name}_amplitude"] = np.linalg.norm(furthest(part), axis=-1) / 2
        columns |= components(f"{name}_mean", ((part.max(axis=0) + part.min(axis=0)) / 2).reshape(values.shape[1:]))
    columns["work"], columns["share"] = work, work / (work.sum() or 1.0)
    if system.width is not None:
        columns["work_density"] = work / width
    columns[f"F1{unit}"] = first = np.linalg.norm(_axes(states.q), axis=-1).max(axis=0) / width * slip
    if (stress is None) != (strain is None):
        raise ModelError("stress, strain: one of them alone; give both, as BodyFields.at_contact does, or none")
    if stress is not None:
        shape = (None, system.nodes) if system.tangents == 1 else (None, system.nodes, 2, 2)
        sigma, epsilon = (finite_array(name, values, shape) for name, values in (("stress", stress), ("strain", strain)))
        if len(sigma) != len(epsilon) or not len(sigma):
            raise ModelError(f"stress, strain: {len(sigma)} and {len(epsilon)} states; give both at the same states, at least one")
        if system.tangents > 1:
            way = way / np.where(slip > COUNTS * np.abs(states.slip).max(), slip, np.nan)[:, None]
            sigma, epsilon = (np.einsum("mnab,na,nb->mn", part, way, way) for part in (sigma, epsilon))
        tension = np.maximum(sigma.max(axis=0), 0.0)
        columns[f"F2{unit}"], columns["SWT"] = np.nan_to_num(tension) * first, tension * np.ptp(epsilon, axis=0) / 2
    table = frame(columns, units=system.units)
    table.attrs["note"] = _NOTE if system.width is not None else f"nodal forces, not tractions: the system has no width; {_NOTE}"
    return table


def _axes(values: Array) -> Array:
    """(T, N, t) values with a last axis for the tangents."""
    return values if values.ndim == 3 else values[..., None]
