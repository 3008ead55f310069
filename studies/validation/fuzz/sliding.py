"""Sliding-off loads of bodies that the contact alone holds.

A closed form or a plain linear program of scipy gives the load at which the body slides off.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

import frictopt as fo
from studies.validation.fuzz.checks import Finding, findings_of
from studies.validation.fuzz.known import same
from studies.validation.polygons import balanced

KINDS = "pad", "tripod", "line", "slope", "far pole"
_SAME = 1e-7


class Body(NamedTuple):
    """A body that only its contact holds, pressed by P and pushed by Q along the contact.

    Attributes
    ----------
    system, friction
        The contact and its coefficient of friction.
    motions
        (M, 3) or (M, 6) shifts and turns of the body.
    sliding_off
        The load factor at which the body slides off by a closed form. None: there is no closed
        form.
    """

    system: fo.ContactSystem
    friction: float
    motions: np.ndarray
    sliding_off: float | None


def body(seed: int, kind: str, axes: int) -> Body:
    """A random body of a kind, in the plane (2 axes) or in space (3 axes), in random units."""
    rng = np.random.default_rng([seed, axes, KINDS.index(kind)])
    side, force, push = 10.0 ** rng.uniform([-3, -3, -3], [1, 6, 6])
    points = side * _places(rng, kind, axes - 1)
    points = np.sort(points, axis=0) if axes == 2 else points
    n = len(points)
    # The share of the pressure that each node carries. With the centre of pressure at the origin,
    # shears of the same shares shift the body without a turn.
    share = rng.uniform(0.5, 1.5, n)
    share /= share.sum()
    points -= share @ points
    friction = 10.0 ** (rng.uniform(-6, -1) if rng.random() < 0.3 else rng.uniform(-1, 0.3))
    pressed = np.eye(axes)[-1]
    pushed = np.append(_direction(rng, axes - 1), 0.0)
    sliding_off = None
    if kind == "slope":
        angle = rng.uniform(0.05, 1.0)
        # The friction is close to the friction at which the weight alone moves the body.
        relative_excess = rng.choice([-1, 1]) * 10.0 ** rng.uniform(-3.3, -0.4)
        friction = float(np.tan(angle) * (1 + relative_excess))
        pressed = np.append(np.sin(angle) * np.eye(axes - 1)[0], np.cos(angle))
        # The push is across the slope in space, and down the slope in the plane.
        pushed = np.eye(axes)[axes - 2]
        sliding_off = _on_slope(angle, friction, axes) * force / push
    elif kind != "far pole":
        sliding_off = friction * force / push
    P = np.outer(force * pressed, share)
    Q = np.outer(push * pushed, share)
    if kind == "far pole":
        Q += push * side * 10.0 ** rng.uniform(-5, -0.5) * _turning(points, axes)
    motions = _rigid(points, axes)
    root = rng.normal(size=(axes * n,) * 2)
    # The projection removes the rigid motions, so that no spring resists them.
    elastic = np.eye(axes * n) - motions @ np.linalg.pinv(motions)
    S = 10.0 ** rng.uniform(0, 9) * elastic @ (root @ root.T + np.eye(len(root))) @ elastic
    # Forces in balance inside the body do not change the load at which it slides off.
    balanced_forces = 0.3 * force / n * elastic @ rng.normal(size=axes * n)
    loads = {"P": P.ravel() + balanced_forces, "Q": Q.ravel()}
    places = np.column_stack([points, np.zeros(n)])
    system = fo.ContactSystem((S + S.T) / 2, places, loads)
    return Body(system, friction, motions, sliding_off)


def _places(rng: np.random.Generator, kind: str, along: int) -> np.ndarray:
    """(N, along) places of the nodes on a face of size 1."""
    if kind == "line":
        line = np.zeros((3, along))
        line[:, 0] = np.sort(rng.uniform(-0.5, 0.5, 3))
        return line
    if kind == "tripod":
        turns = 2 * np.pi * (np.arange(3) + rng.uniform(-0.3, 0.3, 3)) / 3
        return 0.5 * np.column_stack([np.cos(turns), np.sin(turns)])[:, :along]
    return rng.uniform(-0.5, 0.5, (int(rng.integers(3, 30)), along))


def _direction(rng: np.random.Generator, along: int) -> np.ndarray:
    """A random unit vector."""
    vector = rng.normal(size=along)
    return vector / np.linalg.norm(vector)


def _turning(points: np.ndarray, axes: int) -> np.ndarray:
    """(axes, n) nodal forces with a moment of 1: shears in space, pressures in the plane."""
    arm = points - points.mean(axis=0)
    if axes == 2:
        forces = np.column_stack([0 * arm, arm])
    else:
        forces = np.column_stack([-arm[:, 1], arm[:, 0], 0 * arm[:, 0]])
    return np.asarray(forces.T / (arm**2).sum())


def _rigid(points: np.ndarray, axes: int) -> np.ndarray:
    """Shifts, then turns about the normal and the tangents, in units of the face."""
    one = np.ones(len(points))
    none = np.zeros(len(points))
    scaled = points.T / np.abs(points).max()
    x = scaled[0]
    if axes == 2:
        return np.column_stack([np.r_[one, none], np.r_[none, one], np.r_[none, x]])
    y = scaled[1]
    shifts = [np.r_[one, none, none], np.r_[none, one, none], np.r_[none, none, one]]
    turns = [np.r_[-y, x, none], np.r_[none, none, x], np.r_[none, none, y]]
    return np.column_stack([*shifts, *turns])


def _on_slope(angle: float, friction: float, axes: int) -> float:
    """Push over weight at which a block on a slope slides off; nan if its weight alone moves it.

    The push is across the slope in space, and down the slope in the plane.
    """
    pressure = np.cos(angle)
    down = np.sin(angle)
    reserve = friction * pressure - down
    if reserve < 0:
        return float("nan")
    if axes == 2:
        return float(reserve)
    # Pythagoras: push and weight down the slope are at right angles.
    return float(np.sqrt(reserve * (friction * pressure + down)))


def _slides_off(seed: int, kind: str, axes: int) -> tuple[float, bool]:
    """Compare the sliding-off load with a closed form, or with a plain linear program."""
    system, friction, motions, expected = body(seed, kind, axes)
    answer = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), friction)
    if expected is None:
        expected = balanced(system, motions, friction)
    if expected is not None:
        same("it slides off at", answer.load_factor, expected, _SAME)
    return answer.record.residual, expected is not None


def sliding_findings(seed: int, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Findings about a body of each kind, in the plane and in space, or of the named questions."""
    names = [name for name in SLIDING if checks is None or name in checks]
    return findings_of({name: SLIDING[name] for name in names}, seed, seed)


SLIDING: Mapping[str, Callable[[int], tuple[float, bool]]] = {
    f"slides off, {kind}{', 3-D' * (axes == 3)}": partial(_slides_off, kind=kind, axes=axes)
    for axes in (2, 3)
    for kind in KINDS
}
"""Question -> function that answers it and compares the answer."""
