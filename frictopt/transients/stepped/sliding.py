"""Gross sliding in three dimensions: a rigid motion of the bodies that friction cannot stop."""

import numpy as np
from scipy.optimize import linprog

from ...contact.checks import Array
from ...contact.parts import joined, parted
from ...contact.system import ContactSystem
from ...contact.tolerances import COUNTS, RESIDUAL
from ...errors import NoContinuation

__all__ = ["check_sliding"]

_DIRECTIONS = 64  # corners of the polygon around the friction circle, which exceeds it by 0.12 % there
_EVEN = 0.5  # a motion whose mean is at least so large a part of it is a slide, else a turn


def check_sliding(system: ContactSystem, friction: Array, loads: dict[str, Array]) -> None:
    """Check that contact forces can balance each load, in words that name the motion if they cannot.

    A motion phi = (v, w) that strains nothing, S phi = 0, has the work `phi . r = phi . r^w` with the reactions of every state. Where `w >= f |v|`
    at all nodes, contact forces have no negative work in it (`p >= 0`, `|q| <= f p`). So a load with `phi . r^w < 0` has no state: this proves gross
    sliding, turning over or lift-off, whatever the slip and the history. The search is a linear program with a polygon around each friction circle.

    Parameters
    ----------
    system, friction
        The contact and its (N,) coefficients of friction.
    loads
        Name of a load, as the beginning of a sentence -> its bonded reactions (3N,).

    Raises
    ------
    NoContinuation
        A load has no state.
    """
    V = system.rigid_motions
    if not V.shape[1]:
        return
    v, w = (np.moveaxis(part, 0, -1) for part in parted(V.T, 3))
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    edges = (1 + COUNTS) / np.cos(np.pi / _DIRECTIONS) * np.column_stack([np.cos(angles), np.sin(angles)])
    rough = friction > 0
    needed = np.einsum("da,nak,n->ndk", edges, v[rough], friction[rough]) - w[rough][:, None]
    rows = np.concatenate([needed.reshape(-1, V.shape[1]), -w])
    for name, load in loads.items():
        if force := float(np.abs(load).max()):
            for found in (_slide(system, friction, load), linprog(V.T @ load / force, rows, np.zeros(len(rows)), bounds=(-1, 1)).x):
                phi = np.zeros(len(load)) if found is None else V @ found
                if _proves(phi, friction, load):
                    raise NoContinuation(_sentence(system, name, load, phi))


def _slide(system: ContactSystem, friction: Array, load: Array) -> Array | None:
    """The slide of a body 1 as a whole against the shear of a load, rising by the largest friction: its part in each rigid motion, if it is one."""
    (q, p), frames = parted(load, 3), system.frames
    normal = frames[:, 2].mean(axis=0)
    pull = np.einsum("na,nak->k", np.column_stack([q, p]), frames)
    pull = pull - (pull @ normal) * normal / max(normal @ normal, RESIDUAL)
    size = float(np.linalg.norm(pull))
    if not size > 0:
        return None
    moved = frames @ (friction.max() * normal - pull / size)
    phi = joined(moved[:, :2], moved[:, 2])
    parts = np.asarray(system.rigid_motions.T @ phi)
    return parts if np.abs(system.rigid_motions @ parts - phi).max() <= RESIDUAL * np.abs(phi).max() else None


def _proves(phi: Array, friction: Array, load: Array) -> bool:
    """Whether a rigid motion has negative work with the load, and none with contact forces, beyond rounding."""
    slid, lifted = parted(phi, 3)
    reserve = float((lifted - friction * np.linalg.norm(slid, axis=1)).min())
    return bool(phi @ load < -COUNTS * np.abs(phi) @ np.abs(load) and reserve >= -RESIDUAL * np.abs(phi).max())


def _sentence(system: ContactSystem, name: str, load: Array, phi: Array) -> str:
    """What moves, where to, and the forces: those of the load and of friction in units of the mean slip."""
    (slid, lifted), (q, p) = parted(phi, 3), parted(load, 3)
    sizes = np.linalg.norm(slid, axis=1)
    moves = np.abs(phi).reshape(3, -1).max(axis=0) > COUNTS * np.abs(phi).max()
    where = f"body 1 (at {int(moves.sum())} of {system.nodes} nodes)"
    mean = float(sizes[moves].mean())
    demand, holds = (float(part) / (mean or 1.0) for part in (-np.sum(slid * q), lifted @ p))
    if mean <= COUNTS * np.abs(phi).max() or demand <= 0 or holds <= 0:
        return f"{name} lifts {where} off or turns it over: no pressure with friction up to f p balances it; press the bodies together, or hold them"
    along = np.einsum("na,nak->nk", slid, system.frames[:, :2])[moves].mean(axis=0)
    size = float(np.linalg.norm(along))
    way = ", ".join(f"{part:g}" for part in (along / (size or 1.0)).round(6) + 0.0)
    motion = f"slides as a whole along ({way})" if size > _EVEN * mean else "turns as a whole on its contact"
    return (
        f"{name} is beyond friction: {where} {motion}; the load drives it with {demand:.4g}, and friction can hold f P = {holds:.4g} at most: press "
        "the bodies together, hold them by supports, or load them less"
    )
