"""The sliding-off load with the motion that proves it, told contact by contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import COUNTS, Array, ContactSystem, SolveRecord, frame
from ..solve.problem import Explained

_MOVES = 1e-4  # of the largest motion: what is less is told as none, for answers of cone programs have this error
_FIT = COUNTS  # of the largest motion, up to which nodes move as one body
_TOLD = 3  # motions that a reason names


@dataclass(frozen=True, eq=False, repr=False)
class GrossSlip(Explained):
    """The load factor above which bodies slide off, turn over or lift off as a whole, with the motion that proves it.

    Attributes
    ----------
    load_factor
        Above it no state of rest exists, from no start, whatever slips and opens. Inf where the loads drive no motion that the contact alone holds;
        NaN where no load factor has a state of rest. With a `self_stress`: above it the transient from no slip slides off, if that is less.
    bound
        That of statics from above, also with a `self_stress`: `phi` times the reactions at load factor 0, over minus those of the cyclic load.
    least
        Below it no state of rest exists either; above 0 where the loads that the load factor leaves as they are slide a body off.
    corner, loads
        The corner that governs, and its loads in words; -1 and "" where none does.
    phi
        (t + 1, N) the motion that proves it, of body 1 relative to body 2: slips along the tangents, then lifts; the largest node has the size 1. It
        strains nothing, lifts each node by at least f times its slip, and the loads do work in it. 0 where there is none.
    motion
        The same, one row for each contact that moves: columns contact, nodes (that move), x and y (and z), the direction of the slide or in space the
        axis of the turn, slide (along it), lift (off a flat face), turn (angle, in the plane from x to y), at_x, at_y (and at_z), a point that does
        not turn, else NaN. NaN where the nodes of a contact do not move as one body.
    reason
        Why it is so, in words.
    self_stress
        (t + 1, N) contact forces within friction that balance themselves, their pressures adding up to 1: shear along the tangents, then pressure.
        None if there are none, or the cyclic loads drive no body. With them statics cannot know how far a fit presses.
    record, problem
        How it was found; its `residual`, at most 1e-9, is the largest error of both proofs. The cvxpy problem of the corner, in your units, or None.

    Examples
    --------
    >>> import frictopt as fo
    >>> block = fo.ContactSystem.from_blocks([[0.0]], [[0.0]], [[0.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([-1.0], [0.0])})
    >>> slide = fo.gross_slip(block, fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -0.5}]), friction=0.5)
    >>> slide.phi.round(3).tolist(), slide.loads  # it rises by the angle of friction
    ([[0.894], [0.447]], 'Q = +1')
    """

    _said = ("load_factor", "bound", "loads", "residual", "reason")
    load_factor: float
    bound: float
    least: float
    corner: int
    loads: str
    phi: Array
    motion: pd.DataFrame
    reason: str
    record: SolveRecord
    problem: cp.Problem | None
    self_stress: Array | None = None

    def to_frame(self) -> pd.DataFrame:
        """The motion, see there."""
        return self.motion.copy()

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        title = f"sliding-off load: load factor {self.load_factor:.12g}, bound {self.bound:.12g}"
        return title, self.load_factor if np.isfinite(self.load_factor) else None, None, self.reason


def motion_table(system: ContactSystem, phi: Array) -> pd.DataFrame:
    """See `GrossSlip.motion`; phi (t + 1, N) has the size 1."""
    names = np.zeros(system.nodes) if system.contact is None else np.asarray(system.contact)
    back = phi / np.vstack([system.stretch.reshape(system.nodes, -1).T, np.ones(system.nodes)])
    moves = np.einsum("an,nak->nk", back, system.frames)
    rows, moving = list[dict[str, Any]](), np.abs(phi).max(axis=0) > _MOVES
    for name in dict.fromkeys(names[moving].tolist()):
        own = moving & (names == name)
        contact = "the contact" if system.contact is None else name
        rows.append({"contact": contact, "nodes": int(own.sum()), **_as_one(system.points[own], system.normals[own], moves[own])})
    axes = "xyz"[: system.tangents + 1]
    columns = ["contact", "nodes", *axes, "slide", "lift", "turn", *(f"at_{axis}" for axis in axes)]
    return frame({name: [row[name] for row in rows] for name in columns}, units=system.units)


def _as_one(points: Array, normals: Array, moves: Array) -> dict[str, float]:
    """The rigid motion (n, axes) of points, as columns of the table; NaN where it is none."""
    (n, axes), centre = points.shape, points.mean(axis=0)
    arms = points - centre
    turns = np.stack([arms[:, ::-1] * [-1, 1]] if axes == 2 else [np.cross(axis, arms) for axis in np.eye(3)], axis=-1)
    basis = np.concatenate([np.tile(np.eye(axes), (n, 1, 1)), turns], axis=-1).reshape(n * axes, -1)
    found = np.linalg.lstsq(basis, moves.ravel())[0]
    shift, spin, along, at = found[:axes], found[axes:], np.zeros(axes), np.full(axes, np.nan)
    turn, slide, lift = float(np.linalg.norm(spin)), 0.0, 0.0
    if np.abs(basis @ found - moves.ravel()).max() > _FIT:
        along, turn, slide, lift = at, np.nan, np.nan, np.nan
    elif turn * np.linalg.norm(arms, axis=1).max() > _MOVES and axes == 2:
        turn, at = float(spin[0]), centre + np.array([-shift[1], shift[0]]) / spin[0]
    elif turn * np.linalg.norm(arms, axis=1).max() > _MOVES:
        along, at = spin / turn, centre + np.cross(spin, shift) / turn**2
        slide = float(along @ shift)
    else:
        flat = bool((np.abs(normals - normals[0]) <= _FIT).all())
        turn, lift = 0.0, float(shift @ normals[0]) if flat else 0.0
        shift = shift - lift * normals[0]
        slide = float(np.linalg.norm(shift))
        along = shift / slide if slide > _MOVES else along
    names = "xyz"[:axes]
    columns = {**dict(zip(names, along.tolist(), strict=True)), "slide": slide, "lift": lift, "turn": turn}
    return columns | {f"at_{name}": value for name, value in zip(names, at.tolist(), strict=True)}


def moves_told(motion: pd.DataFrame) -> str:
    """The motions of a table in words, contacts that move alike together."""
    told, axes = dict[str, list[str]](), [name for name in "xyz" if name in motion]
    for row in motion.to_dict("records"):
        along, at = (_point([row[of + name] for name in axes]) for of in ("", "at_"))
        if np.isnan(row["slide"]):
            text = "not as one body"
        elif row["turn"]:
            text = f"by a turn about {at}" if len(axes) == 2 else f"by a turn about the axis {along} through {at}"
        else:
            text = f"along {along}" if row["slide"] > _MOVES else "off"
        told.setdefault(text, []).append(str(row["contact"]))
    said = [f"{', '.join(names[:_TOLD])}{', ...' * (len(names) > _TOLD)} {text}" for text, names in told.items()]
    return f"body 1 moves at {'; '.join(said[:_TOLD])}{'; ...' * (len(said) > _TOLD)}"


def _point(values: list[float]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 4) + 0.0) + ")"
