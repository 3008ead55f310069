"""What is asked of bodies that the contact alone holds: the load at which they slide off, by hand, or by plain linear programs of scipy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

import frictopt as fo
from validation.fuzz.checks import Finding, asked
from validation.fuzz.known import same
from validation.polygons import balanced

KINDS = "pad", "tripod", "line", "slope", "far pole"
_SAME = 1e-7


class Body(NamedTuple):
    """A body on springs that nothing else holds, pressed by P and pushed by Q along its contact."""

    system: fo.ContactSystem
    friction: float
    motions: np.ndarray  # (M, 3) or (M, 6) its shifts and turns
    hand: float | None  # load factor at which it slides off; None where a program has to say it


def body(seed: int, kind: str, axes: int) -> Body:
    """A random body of a kind, in the plane or in space, in units of its own."""
    rng = np.random.default_rng([seed, axes, KINDS.index(kind)])
    side, force, push = 10.0 ** rng.uniform([-3, -3, -3], [1, 6, 6])
    points = side * _places(rng, kind, axes - 1)
    points = np.sort(points, axis=0) if axes == 2 else points
    n = len(points)
    share = rng.uniform(0.5, 1.5, n)
    share /= (
        share.sum()
    )  # of the pressure that each node carries; shears of the same shares only shift the body
    points -= share @ points
    friction = 10.0 ** (rng.uniform(-6, -1) if rng.random() < 0.3 else rng.uniform(-1, 0.3))
    pressed, pushed, hand = np.eye(axes)[-1], np.append(_direction(rng, axes - 1), 0.0), None
    if kind == "slope":
        angle = rng.uniform(0.05, 1.0)
        friction = float(
            np.tan(angle) * (1 + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-3.3, -0.4))
        )
        pressed = np.append(np.sin(angle) * np.eye(axes - 1)[0], np.cos(angle))
        pushed = np.eye(axes)[axes - 2]  # across the slope, in the plane down
        hand = _on_slope(angle, friction, axes) * force / push
    elif kind != "far pole":
        hand = friction * force / push
    P, Q = (np.outer(total, share) for total in (force * pressed, push * pushed))
    if kind == "far pole":
        Q += push * side * 10.0 ** rng.uniform(-5, -0.5) * _turning(points, axes)
    motions = _rigid(points, axes)
    root, off = (
        rng.normal(size=(axes * n,) * 2),
        np.eye(axes * n) - motions @ np.linalg.pinv(motions),
    )
    S = 10.0 ** rng.uniform(0, 9) * off @ (root @ root.T + np.eye(len(root))) @ off
    own = (
        0.3 * force / n * off @ rng.normal(size=axes * n)
    )  # forces of the bodies' own, in balance, which change nothing
    loads = {"P": P.ravel() + own, "Q": Q.ravel()}
    places = np.column_stack([points, np.zeros(n)])
    return Body(fo.ContactSystem((S + S.T) / 2, places, loads), friction, motions, hand)


def _places(rng: np.random.Generator, kind: str, along: int) -> np.ndarray:
    """Nodes along a face of size 1."""
    if kind == "line":
        return np.column_stack([np.sort(rng.uniform(-0.5, 0.5, 3)), *[np.zeros(3)] * (along - 1)])
    if kind == "tripod":
        turns = 2 * np.pi * (np.arange(3) + rng.uniform(-0.3, 0.3, 3)) / 3
        return 0.5 * np.column_stack([np.cos(turns), np.sin(turns)])[:, :along]
    return rng.uniform(-0.5, 0.5, (int(rng.integers(3, 30)), along))


def _direction(rng: np.random.Generator, along: int) -> np.ndarray:
    way = rng.normal(size=along)
    return way / np.linalg.norm(way)


def _turning(points: np.ndarray, axes: int) -> np.ndarray:
    """(axes, n) forces of moment 1 over the size of the face: about the normal, in the plane by pressure."""
    off = points - points.mean(axis=0)
    turned = (
        np.column_stack([0 * off, off])
        if axes == 2
        else np.column_stack([-off[:, 1], off[:, 0], 0 * off[:, 0]])
    )
    return np.asarray(turned.T / (off**2).sum())


def _rigid(points: np.ndarray, axes: int) -> np.ndarray:
    """Shifts, then turns about the normal and the tangents, in units of the face."""
    one, none, (x, *y) = (
        np.ones(len(points)),
        np.zeros(len(points)),
        points.T / np.abs(points).max(),
    )
    if axes == 2:
        return np.column_stack([np.r_[one, none], np.r_[none, one], np.r_[none, x]])
    shifts = [np.r_[one, none, none], np.r_[none, one, none], np.r_[none, none, one]]
    return np.column_stack(
        [*shifts, np.r_[-y[0], x, none], np.r_[none, none, x], np.r_[none, none, y[0]]]
    )


def _on_slope(angle: float, friction: float, axes: int) -> float:
    """Push over weight at which a block on a slope slides off, across the slope or, in the plane, down; nan where the weight alone does it."""
    normal, down = np.cos(angle), np.sin(angle)
    left = friction * normal - down
    return (
        float("nan")
        if left < 0
        else float(left if axes == 2 else np.sqrt(left * (friction * normal + down)))
    )


def _slides_off(seed: int, kind: str, axes: int) -> tuple[float, bool]:
    system, friction, motions, hand = body(seed, kind, axes)
    found = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), friction)
    known = balanced(system, motions, friction) if hand is None else hand
    if known is not None:
        same("it slides off at", found.load_factor, known, _SAME)
    return found.record.residual, known is not None


def sliding_findings(seed: int, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Ask of a body of each kind, in the plane and in space, or of some by name, when it slides off."""
    return asked(
        {name: ask for name, ask in SLIDING.items() if checks is None or name in checks}, seed, seed
    )


SLIDING: Mapping[str, Callable[[int], tuple[float, bool]]] = {
    f"slides off, {kind}{', 3-D' * (axes == 3)}": partial(_slides_off, kind=kind, axes=axes)
    for axes in (2, 3)
    for kind in KINDS
}
"""Question -> what asks it and compares the answer."""
