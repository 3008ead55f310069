"""Checks of the parts of a contact system.

Each function returns the checked value, or raises a ModelError with a remedy.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base import (
    CONDENSATION,
    Array,
    check_entries,
    checked_cases,
    choice,
    finite_array,
    finite_number,
    for_each,
    frozen,
    real_array,
    shown,
)
from ..errors import ModelError
from .components import parted

# Stiffness of the softest spring; the inverse of this number is the stiffness of the stiffest one.
# Products of two larger numbers overflow.
_SOFTEST = 1e-150


def _is_empty(name: str, values: object) -> bool:
    """Whether an optional array is None or has no entries, and so gets its default."""
    return values is None or real_array(name, values).size == 0


def checked_frames(frames: object, n: int, axes: int) -> Array:
    """Check the directions of the nodes, (N, axes, axes); by default they are the axes."""
    if _is_empty("frames", frames):
        return frozen(np.tile(np.eye(axes), (n, 1, 1)))
    checked = finite_array("frames", frames, (n, axes, axes))
    errors = np.abs(checked @ checked.transpose(0, 2, 1) - np.eye(axes)).max(axis=(1, 2))
    if errors.max() > 10 * CONDENSATION:
        raise ModelError(
            f"frames: the directions of node {int(errors.argmax())} are not orthonormal; give unit "
            "tangents and the unit normal"
        )
    return checked


def positive(name: str, values: object, shape: tuple[int, ...], remedy: str) -> Array:
    """Check an array of this shape with finite numbers > 0."""
    checked = finite_array(name, values, shape)
    check_entries(name, checked, checked > 0, remedy)
    return checked


def checked_gap(gap: object, n: int) -> Array:
    """Check initial gaps (N,) >= 0; by default all are 0."""
    if _is_empty("gap", gap):
        return frozen(np.zeros(n))
    checked = finite_array("gap", gap, (n,))
    remedy = "the bodies cannot overlap before loading, give gap >= 0"
    check_entries("gap", checked, checked >= 0, remedy)
    return checked


def checked_stretch(stretch: object, shape: tuple[int, ...]) -> Array:
    """Check the factors > 0 that stretch slips, in the shape of slips; by default all are 1."""
    if _is_empty("stretch", stretch):
        return frozen(np.ones(shape))
    return positive("stretch", stretch, shape, "give a ratio above 0")


def checked_strength(argument: str, strength: object, n: int) -> Array:
    """Check shear strengths > 0, one number or (N,); by default all are inf."""
    if _is_empty(argument, strength):
        return frozen(np.full(n, np.inf))
    checked = real_array(argument, strength)
    remedy = "give a largest shear > 0, or inf for no limit; a surface without shear has friction 0"
    check_entries(argument, checked, checked > 0, remedy)  # NaN > 0 is False
    return frozen(for_each(argument, checked, n))


def checked_springs(argument: str, stiffness: object, n: int) -> Array:
    """Check stiffnesses of springs, one number or (N,), > 0 and up to infinity."""
    checked = real_array(argument, stiffness)
    stiff_enough = checked >= _SOFTEST  # False for NaN
    soft_enough = (checked <= 1 / _SOFTEST) | (checked == np.inf)
    remedy = (
        f"give the stiffness of the surface, force per length^3, from {_SOFTEST:g} to "
        f"{1 / _SOFTEST:g}, or inf for a rigid surface"
    )
    check_entries(argument, checked, stiff_enough & soft_enough, remedy)
    return frozen(for_each(argument, checked, n))


def compliances(tangential: object, normal: object, width: Array, tangents: int) -> Array:
    """(M,) compliances of the springs of a surface at nodes of some width (N,).

    `tangential` and `normal` are the stiffnesses of the surface, force per length^3, one number or
    (N,).
    """
    along = 1 / (checked_springs("tangential", tangential, len(width)) * width)
    across = 1 / (checked_springs("normal", normal, len(width)) * width)
    return np.concatenate([*[along] * tangents, across])


def checked_bonded(
    argument: str, bonded: object, n: int, tangents: int
) -> Mapping[str, tuple[Array, Array]]:
    """Check bonded reactions, load case name -> (q, p) or (M,), and return the pairs read-only."""
    cases = checked_cases(argument, bonded, "(q, p)")
    if not cases:
        raise ModelError(f"{argument}: no load case; give at least one, name -> (q, p)")
    pairs = {
        name: checked_pair(f"{argument}[{name!r}]", reactions, n, tangents)
        for name, reactions in cases.items()
    }
    return MappingProxyType(pairs)


def checked_pair(argument: str, reactions: Any, n: int, tangents: int) -> tuple[Array, Array]:
    """Check tangential and normal forces of n nodes, (q, p) or (M,) in the order of S."""
    shape = (n,) if tangents == 1 else (n, 2)
    try:
        is_pair = np.ndim(reactions[0]) > 0
        if is_pair:
            q, p = reactions
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise ModelError(
            f"{argument}: {shown(reactions)} is no pair; give (q, p), arrays of shapes {shape} and "
            f"{(n,)}"
        ) from error
    if not is_pair:
        axes = tangents + 1
        q, p = parted(finite_array(argument, reactions, (axes * n,)), axes)
    return finite_array(f"{argument} q", q, shape), finite_array(f"{argument} p", p, (n,))


def checked_bolts(bolts: object, cases: Mapping[str, object]) -> Mapping[str, tuple[float, float]]:
    """Check locked bolts, load case name -> (force, shortening), and return them read-only."""
    checked = {}
    for case, pair in checked_cases("bolts", bolts, "(force, shortening)").items():
        choice("bolts: load case", case, cases)
        name = f"bolts[{case!r}]"
        values = finite_array(name, pair, (2,))
        check_entries(name, values, values > 0, "give a force and a shortening above 0", "index")
        force, shortening = values.tolist()
        checked[case] = force, shortening
    return MappingProxyType(checked)


def checked_sizes(sizes: object, cases: Mapping[str, object]) -> Mapping[str, float]:
    """Check sizes of load cases, name -> number > 0, and return them read-only."""
    checked = {}
    for case, size in checked_cases("load_size", sizes, "size of its forces").items():
        choice("load_size: load case", case, cases)
        checked[case] = finite_number(f"load_size[{case!r}]", size, above=0.0)
    return MappingProxyType(checked)
