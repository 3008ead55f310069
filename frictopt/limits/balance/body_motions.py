"""Rigid motions of bodies at their contacts, as a table and in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base import COUNTS, Array, Table, frame
from ...contact import ContactSystem

# Motions below this share of the largest one are reported as zero: cone solvers have this error.
MOVES = 1e-4
# Nodes move as one body if they are off its motion by at most this share of the largest motion.
_FIT = COUNTS
# Largest number of contacts, and of motions, that a reason names.
_MOST_PARTS = 3


def motion_table(system: ContactSystem, phi: Array) -> Table:
    """The table of `GrossSlip.motion`, from motions phi (t + 1, N) whose largest has the size 1."""
    names = np.zeros(system.nodes) if system.contact is None else system.contact
    stretch = np.vstack([system.stretch.reshape(system.nodes, -1).T, np.ones(system.nodes)])
    # (N, axes) motions in the axes of space, from slips along the tangents and lifts.
    moves = np.einsum("an,nak->nk", phi / stretch, system.frames)
    moving = np.abs(phi).max(axis=0) > MOVES

    rows = list[list[Any]]()
    for name in dict.fromkeys(names[moving].tolist()):
        nodes = moving & (names == name)
        motion = _motion_as_one_body(system.points[nodes], system.normals[nodes], moves[nodes])
        contact = "the contact" if system.contact is None else name
        rows.append([contact, int(nodes.sum()), *motion])
    axes = "xyz"[: system.tangents + 1]
    columns = ["contact", "nodes", *axes, "slide", "lift", "turn", *(f"at_{axis}" for axis in axes)]
    return frame(rows, system.units, columns)


def _motion_as_one_body(points: Array, normals: Array, moves: Array) -> list[float]:
    """The rigid motion of some nodes, see `GrossSlip.motion`: direction, slide, lift, turn, point.

    NaN if they do not move as one body. The direction is that of the slide, or of the axis of a
    turn in space; the point does not turn.
    """
    axes = points.shape[1]
    centre = points.mean(axis=0)
    arms = points - centre
    shift, spin, error = _rigid_fit(arms, moves)
    if error > _FIT:
        return [np.nan] * (2 * axes + 3)

    turn = float(np.linalg.norm(spin))
    turns = turn * np.linalg.norm(arms, axis=1).max() > MOVES
    if turns and axes == 2:
        at = centre + np.array([-shift[1], shift[0]]) / spin[0]
        return [0.0, 0.0, 0.0, 0.0, float(spin[0]), *at.tolist()]
    if turns:
        axis = spin / turn
        at = centre + np.cross(spin, shift) / turn**2
        return [*axis.tolist(), float(axis @ shift), 0.0, turn, *at.tolist()]

    lift = 0.0
    if (np.abs(normals - normals[0]) <= _FIT).all():
        lift = float(shift @ normals[0])
    shift = shift - lift * normals[0]
    slide = float(np.linalg.norm(shift))
    direction = shift / slide if slide > MOVES else np.zeros(axes)
    return [*direction.tolist(), slide, lift, 0.0, *[np.nan] * axes]


def _rigid_fit(arms: Array, moves: Array) -> tuple[Array, Array, float]:
    """Shift and spin that fit motions (n, axes) of points at these arms best, and the error."""
    n, axes = arms.shape
    if axes == 2:
        turns = [arms[:, ::-1] * [-1, 1]]
    else:
        turns = [np.cross(axis, arms) for axis in np.eye(3)]
    shifts = np.tile(np.eye(axes), (n, 1, 1))
    basis = np.concatenate([shifts, np.stack(turns, axis=-1)], axis=-1).reshape(n * axes, -1)
    fit = np.linalg.lstsq(basis, moves.ravel())[0]
    error = float(np.abs(basis @ fit - moves.ravel()).max())
    return fit[:axes], fit[axes:], error


def motions_in_words(motion: Table) -> str:
    """The motions of a table in words, contacts that move alike together."""
    contacts: dict[str, list[str]] = {}
    for row in motion.to_dict("records"):
        contacts.setdefault(_in_words(row), []).append(str(row["contact"]))
    motions = [f"{_first_parts(names, ', ')} {text}" for text, names in contacts.items()]
    return f"body 1 moves at {_first_parts(motions, '; ')}"


def _in_words(row: dict[Any, Any]) -> str:
    names = [name for name in "xyz" if name in row]
    direction = _point([row[name] for name in names])
    at = _point([row[f"at_{name}"] for name in names])
    if np.isnan(row["slide"]):
        return "not as one body"
    if row["turn"] and len(names) == 2:
        return f"by a turn about {at}"
    if row["turn"]:
        return f"by a turn about the axis {direction} through {at}"
    return f"along {direction}" if row["slide"] > MOVES else "off"


def _first_parts(parts: Sequence[str], separator: str) -> str:
    shown = list(parts[:_MOST_PARTS])
    if len(parts) > _MOST_PARTS:
        shown.append("...")
    return separator.join(shown)


def _point(values: list[float]) -> str:
    # Adding 0 turns -0 into 0.
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 4) + 0.0) + ")"
