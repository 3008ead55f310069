"""Checks of the parts of a contact system, the tangential and normal components of its vectors, and the course of contacts in the plane."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from ..errors import ModelError
from .checks import Array, Names, checked_cases, finite_array, frozen, real_array, shown
from .tolerances import CONDENSATION, SAME_POINT

_ORTHONORMAL = 10 * CONDENSATION  # error of the frames of the pairs up to which they are orthonormal, as for given normals
_SOFTEST = 1e-150  # stiffness of a spring, and largest compliance: the product of two larger numbers overflows


def joined(q: Array, p: Array) -> Array:
    """(..., M) values ordered by component, from tangential (..., N) or (..., N, 2) and normal ones (..., N): the inverse of `parted`."""
    return np.concatenate([q, p] if q.ndim == p.ndim else [q[..., 0], q[..., 1], p], axis=-1)


def parted(r: Array, axes: int) -> tuple[Array, Array]:
    """Tangential (..., N) or (..., N, 2) and normal (..., N) parts of (..., M) values ordered by component; `axes` is 2 in the plane, 3 in space."""
    n = r.shape[-1] // axes
    q, p = r[..., :-n], r[..., -n:]
    return (q if axes == 2 else np.stack([q[..., :n], q[..., n:]], axis=-1)), p


def check_order(x: Array) -> None:
    """Check that coordinates along an interface rise."""
    if np.any(np.diff(x) <= 0):
        first = int(np.argmax(np.diff(x) <= 0))
        raise ModelError(f"x: x[{first + 1}] = {x[first + 1]:g} does not exceed x[{first}] = {x[first]:g}; order the nodes along the interface")


def checked_frames(frames: object, n: int, axes: int) -> Array:
    """Check the directions of the nodes; None, or empty: the axes."""
    if frames is None or real_array("frames", frames).size == 0:
        return frozen(np.tile(np.eye(axes), (n, 1, 1)))
    checked = finite_array("frames", frames, (n, axes, axes))
    errors = np.abs(checked @ checked.transpose(0, 2, 1) - np.eye(axes)).max(axis=(1, 2))
    if errors.max() > _ORTHONORMAL:
        raise ModelError(f"frames: the directions of node {int(errors.argmax())} are not orthonormal; give unit tangents and the unit normal")
    return checked


def checked_width(width: object, n: int) -> Array:
    """Check tributary lengths or areas."""
    checked = finite_array("width", width, (n,))
    if checked.min() <= 0:
        raise ModelError(f"width: {checked.min():g} at node {int(checked.argmin())}; give the length or area that the node collects, > 0")
    return checked


def checked_springs(argument: str, stiffness: object, n: int | None = None) -> Array:
    """Check stiffnesses of springs, one number or (n,), > 0 and up to infinity."""
    given = real_array(argument, stiffness)
    if given.shape not in ((), (n,)):
        raise ModelError(f"{argument}: shape {given.shape}; give one number" + (f" or one for each node, {(n,)}" if n else ""))
    values = np.broadcast_to(given, n or ())
    fits = (values >= _SOFTEST) & ((values <= 1 / _SOFTEST) | (values == np.inf))  # also false for NaN
    if not fits.all():
        where = "" if given.ndim == 0 else f" at node {int(np.argmin(fits))}"
        raise ModelError(
            f"{argument}: {np.ravel(values)[np.argmin(fits)]:g}{where}; give the stiffness of the surface, force per length^3, from {_SOFTEST:g} to "
            f"{1 / _SOFTEST:g}, or inf for a rigid one"
        )
    return frozen(values)


def compliances(tangential: object, normal: object, width: Array, tangents: int) -> Array:
    """(M,) compliances of the springs of a surface with some stiffness, one number or one a node, at nodes of some width."""
    along, across = (1 / (checked_springs(name, k, len(width)) * width) for name, k in (("tangential", tangential), ("normal", normal)))
    return np.concatenate([*[along] * tangents, across])


def checked_bonded(argument: str, bonded: object, n: int, tangents: int) -> Mapping[str, tuple[Array, Array]]:
    """Check bonded reactions, load case name -> (q, p) or all of them in the order of S, and return the pairs read-only."""
    if not (cases := checked_cases(argument, bonded, "(q, p)")):
        raise ModelError(f"{argument}: no load case; give at least one, name -> (q, p)")
    return MappingProxyType({name: checked_pair(f"{argument}[{name!r}]", given, n, tangents) for name, given in cases.items()})


def checked_pair(argument: str, given: Any, n: int, tangents: int) -> tuple[Array, Array]:
    """Check tangential and normal forces of n nodes, (q, p) or all of them in the order of S."""
    shape = (n,) if tangents == 1 else (n, 2)
    try:
        flat = np.ndim(given[0]) == 0
        q, p = ((), ()) if flat else given
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise ModelError(f"{argument}: {shown(given)} is no pair; give (q, p), arrays of shapes {shape} and {(n,)}") from error
    if flat:
        q, p = parted(finite_array(argument, given, ((tangents + 1) * n,)), tangents + 1)
    return finite_array(f"{argument} q", q, shape), finite_array(f"{argument} p", p, (n,))


def runs(names: Sequence[str] | Names) -> list[slice]:
    """The nodes of each contact, from the name of the contact of each node."""
    starts = [i for i in range(len(names)) if i == 0 or names[i] != names[i - 1]]
    return [slice(start, end) for start, end in pairwise([*starts, len(names)])]


def arc_length(points: Array, frames: Array, contact: Names | None) -> Array:
    """(N,) coordinates along the tangent where all nodes have the same and follow each other along it, else arc length, contact after contact.

    The arc length begins at the first node's coordinate along its tangent; each further contact begins one spacing after the end of the one before.
    """
    pieces = [slice(None)] if contact is None else runs(contact)
    along = points @ frames[0, 0]
    if (frames == frames[0]).all() and (len(pieces) == 1 or np.all(np.diff(along) > 0)):
        return np.asarray(along)
    x, end = np.empty(len(points)), 0.0
    for number, piece in enumerate(pieces):
        p = points[piece]
        lengths = np.hypot(*np.diff(p, axis=0).T)
        step = float(lengths.mean()) if len(lengths) else 1.0
        first = float(frames[0, 0] @ p[0])
        start = end + step if number else first * (abs(first) > SAME_POINT * lengths.sum())
        x[piece] = start + np.r_[0.0, np.cumsum(lengths)]
        end = float(x[piece][-1])
    return x
