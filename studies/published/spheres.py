"""A sphere on a half-space of the same material, sheared to and fro and twisted.

Results are means over several meshes of square cells.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

import frictopt as fo
from frictopt.reference import SphereContact, half_space_contact

from .case import Array, Case, first_loading, opposed, stuck

_R, _E, _NU, _FRICTION = 5.0, 1.0, 0.3, 0.5
# The radius of the contact is 1.
_P = _E / (1.5 * _R * (1 - _NU**2))
_HALF_LENGTH = 1.12
_G = _E / (2 * (1 + _NU))


@dataclass(frozen=True)
class Parameters:
    """Parameters of the cases."""

    # Numbers of cells along the diameter.
    cells: tuple[int, ...] = (16, 17, 18, 19)
    # Shear forces Q / (f P). The forces are approximate, because the motion of the far end is
    # prescribed.
    shears: tuple[float, ...] = (0.5, 0.8)
    # Radii of the stick zone under a twist.
    sticks: tuple[float, ...] = (0.3, 0.5, 0.7, 0.9)
    steps: int = 2


def cases(parameters: Parameters) -> Iterator[Case]:
    """All cases of spheres."""
    yield _sheared([_sphere(cells, 0.0) for cells in parameters.cells], parameters)
    yield from _twisted([_sphere(cells, _NU) for cells in parameters.cells], parameters)


def _sphere(cells: int, nu: float) -> fo.ContactSystem:
    arrays: dict[str, Any] = half_space_contact(cells, _HALF_LENGTH, _R, _E, nu)
    return fo.ContactSystem(**arrays)


def _sheared(meshes: list[fo.ContactSystem], parameters: Parameters) -> Case:
    """The sphere sheared to and fro, with Poisson's ratio 0.

    With another ratio the closed form neglects slip across the force. The motion of the far end is
    prescribed, and the closed form is evaluated for the force that frictopt finds.
    """
    ratios, residuals = [], []
    force = _E / (1.5 * _R)
    for share in parameters.shears:
        shift = 3 * _FRICTION * force / 4 / (_E / 2) * (1 - (1 - share) ** (2 / 3))
        cycle, found = opposed({"approach": 1 / _R}, {"x": shift}), []
        for system in meshes:
            path = fo.march(system, cycle, _FRICTION, 1.0, cycles=2, steps=parameters.steps)
            at = int(np.flatnonzero(path.time == 1)[0])
            ball = SphereContact(float(path.p[at].sum()), _R, _E, 0.0, _FRICTION)
            found.append(path.cycle_work[-1].sum() / ball.dissipation(abs(path.q[at, :, 0].sum())))
            residuals.append(path.residual)
        ratios.append(float(np.mean(found)))
    return Case(
        "Mindlin & Deresiewicz 1953",
        "work of friction per cycle of a sphere / theirs",
        "Q / (f P)",
        f"{_meshes_in_words(parameters)}; edges of contact and stick cut square cells, "
        "and the error changes sign from mesh to mesh",
        parameters.shears,
        lambda _: 1.0,
        ratios,
        max(residuals),
    )


def _twisted(meshes: list[fo.ContactSystem], parameters: Parameters) -> Iterator[Case]:
    torques, radii, residuals = [], [], []
    for stick in parameters.sticks:
        found, zones = [], []
        for system, cells in zip(meshes, parameters.cells, strict=True):
            x, y = system.points[:, 0], system.points[:, 1]
            turned = system.with_bonded(
                {**system.bonded, "twist": -system.S @ np.concatenate([-y, x, np.zeros_like(x)])}
            )
            q, p, residual = first_loading(
                turned,
                opposed({"approach": 1 / _R}, {"twist": twist(stick)}),
                _FRICTION,
                parameters.steps,
            )
            found.append(abs(float(x @ q[:, 1] - y @ q[:, 0])) / (_FRICTION * _P))
            zones.append(
                sqrt(np.count_nonzero(stuck(q, p, _FRICTION)) / pi) * 2 * _HALF_LENGTH / cells
            )
            residuals.append(residual)
        torques.append(float(np.mean(found)))
        radii.append(float(np.mean(zones)))
    source, over = "Lubkin 1951", "radius of the stick zone / a of theirs"
    meshes_used = _meshes_in_words(parameters)
    how = f"{meshes_used}, {parameters.steps} increments, the far end turned as theirs"
    yield Case(
        source,
        "twisting couple on a sphere / (f P a)",
        over,
        how,
        parameters.sticks,
        torque,
        torques,
        max(residuals),
    )
    how = f"{how}; counted in cells"
    yield Case(
        source,
        "radius of the stick zone / a under a twist",
        over,
        how,
        parameters.sticks,
        lambda stick: stick,
        radii,
        max(residuals),
    )


def _meshes_in_words(parameters: Parameters) -> str:
    return f"mean over meshes of {', '.join(map(str, parameters.cells))} cells across"


def _elliptic(stick: float | Array) -> Array:
    """K - E at the modulus `sqrt(1 - stick^2)`."""
    return np.asarray(ellipk(1 - np.square(stick)) - ellipe(1 - np.square(stick)))


def twist(stick: float) -> float:
    """Relative angle of the spheres when the stick zone has this radius, a = 1.

    `3 f P (K - E) / (2 pi G a^2)` (Lubkin 1951). Rigid twists of circles of all radii s from c to a
    add up to the traction f p in the slip zone. Each circle has the traction `r / sqrt(s^2 - r^2)`
    inside (Reissner & Sagoci 1944). The twist of each circle follows from Abel's equation.
    """
    return 3 * _FRICTION * _P / (2 * pi * _G) * float(_elliptic(stick))


def torque(stick: float) -> float:
    """Couple over `f P a` at this radius of the stick zone, a = 1.

    The couple is the sum of the couples `16 G s^3 / 3` of the rigid twists of `twist`: `(4 / pi)
    (c^3 (K - E)(c) + 3 times the integral of s^2 (K - E)(s) from c to 1)`. If the whole contact
    slips, it is `3 pi / 16`.
    """
    rest, _ = quad(lambda s: s**2 * float(_elliptic(s)), stick, 1.0)
    return 4 / pi * float((stick**3 * float(_elliptic(stick)) if stick > 0 else 0.0) + 3 * rest)
