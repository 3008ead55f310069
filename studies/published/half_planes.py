"""Cylinders and rounded punches on half-planes: stick zones and work of friction, with bulk stress and with a normal force that varies.

All lengths are in units of the half-width of the contact, and E* = 1.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import asin, log, pi, radians, sin, sqrt

import numpy as np
from scipy.optimize import brentq

import frictopt as fo
from frictopt.reference import LineContact, half_plane_contact

from .case import Array, Case, first_loading, opposed, stuck

_FRICTION = 0.4
# The half-width of the contact is 1.
_CYLINDER = LineContact(P=pi / 4, R=1.0, E_star=1.0, f=_FRICTION)
# Shear force at which the cylinder slides.
_GROSS = _FRICTION * _CYLINDER.P
_HALF_LENGTH = 1.25
# Number of steps of a cycle of springs.
_STEPS = 240


@dataclass(frozen=True)
class Parameters:
    """Parameters of the cases."""

    cells: int = 250
    # Shear forces Q / (f P).
    shears: tuple[float, ...] = (0.25, 0.5, 0.75, 0.95)
    bulk_shear: float = 0.5
    # Bulk stresses sigma / (f p_0).
    bulks: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 1.0)
    swing_shear: float = 0.5
    # Amplitudes of the normal force relative to its mean.
    swings: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.4)
    # Phases of the normal force in degrees.
    phases: tuple[float, ...] = (0.0, 30.0, 60.0, 90.0)
    # Number of corners of the polygon that approximates an ellipse.
    points: int = 64
    # Number of springs of the method of others.
    springs: int = 1000
    still_swing: float = 0.3
    still_shear: float = 0.2
    # Half-width of the flat part of the rounded punch.
    flat: float = 0.6


def cases(parameters: Parameters) -> Iterator[Case]:
    """All cases of half-planes."""
    cylinder = fo.ContactSystem.from_blocks(
        **half_plane_contact(parameters.cells, _HALF_LENGTH, 1.0, R=1.0)
    )
    cell = 2 * _HALF_LENGTH / parameters.cells
    yield from _cattaneo_mindlin(cylinder, cell, parameters)
    yield from _bulk_stress(cylinder, cell, parameters)
    yield from _varying_normal_force(cylinder, cell, parameters)
    yield _out_of_phase(cylinder, parameters)
    yield _rounded_punch(parameters)


def _cattaneo_mindlin(
    cylinder: fo.ContactSystem, cell: float, parameters: Parameters
) -> Iterator[Case]:
    sticks, works, residuals = [], [], [0.0]
    for share in parameters.shears:
        cycle = opposed({"P": _CYLINDER.P}, {"Q": share * _GROSS})
        q, p, residual = first_loading(cylinder, cycle, _FRICTION)
        steady = fo.steady_state(cylinder, cycle, _FRICTION, 1.0)
        sticks.append(cell * np.count_nonzero(stuck(q, p, _FRICTION)) / 2)
        works.append(steady.dissipation)
        residuals += [residual, steady.residual]
    source, cells = "Cattaneo 1938, Mindlin 1949", f"{parameters.cells} cells"
    yield Case(
        source,
        "half-width of the stick zone / a",
        "Q / (f P)",
        f"{cells}; the zone ends between two of them, so within {cell:.2g}",
        parameters.shears,
        lambda share: _CYLINDER.stick_half_width(share * _GROSS),
        sticks,
        max(residuals),
    )
    yield Case(
        source,
        "work of friction per cycle, cylinder, W E* / (f P)^2",
        "Q / (f P)",
        f"{cells}; pressure is even within a cell",
        parameters.shears,
        lambda share: _CYLINDER.dissipation(share * _GROSS) / _GROSS**2,
        [work / _GROSS**2 for work in works],
        max(residuals),
    )


def _bulk_stress(cylinder: fo.ContactSystem, cell: float, parameters: Parameters) -> Iterator[Case]:
    """Shear force and bulk stress in the half-plane grow together; all slip has one sense.

    Under full slip the surfaces separate tangentially with the slope `2 f p_0 x / (E* a)`. The bulk
    stress adds `sigma / (2 E*)` to this slope, the strain `(1 - nu^2) sigma / E` of one of two
    equal bodies. A corrective traction as in Hertz's theory removes the sum in the stick zone. The
    middle of this zone is moved by `e = a sigma / (4 f p_0)`, and its half-width is the half-width
    without bulk stress (Nowell & Hills 1987).
    """
    zones, residuals = [], []
    # Bonded reaction to a bulk stress of 1.
    stretch = -cylinder.A @ (cylinder.x / 2)
    pulled = cylinder.with_bonded({**cylinder.bonded, "bulk": (stretch, np.zeros(cylinder.nodes))})
    unit = _FRICTION * _CYLINDER.peak_pressure
    for bulk in parameters.bulks:
        cycle = opposed(
            {"P": _CYLINDER.P}, {"Q": parameters.bulk_shear * _GROSS, "bulk": bulk * unit}
        )
        q, p, residual = first_loading(pulled, cycle, _FRICTION)
        zones.append(cylinder.x[stuck(q, p, _FRICTION)])
        residuals.append(residual)
    how = f"{parameters.cells} cells, Q = {parameters.bulk_shear:g} f P; within a cell, {cell:.2g}"
    source = "Nowell & Hills 1987"
    over = "sigma / (f p_0)"
    middles = [float(zone.mean()) for zone in zones]
    halves = [cell * len(zone) / 2 for zone in zones]
    yield Case(
        source,
        "middle of the stick zone / a",
        over,
        how,
        parameters.bulks,
        lambda bulk: bulk / 4,
        middles,
        max(residuals),
    )
    half = sqrt(1 - parameters.bulk_shear)
    yield Case(
        source,
        "half-width of the stick zone / a under bulk stress",
        over,
        how,
        parameters.bulks,
        lambda _: half,
        halves,
        max(residuals),
    )


def _varying_normal_force(
    cylinder: fo.ContactSystem, cell: float, parameters: Parameters
) -> Iterator[Case]:
    permanent, works, residuals = [], [], []
    for swing in parameters.swings:
        steady = fo.steady_state(cylinder, _swinging(swing, parameters.swing_shear), _FRICTION, 1.0)
        path = steady.states()
        still = (np.ptp(path.slip, axis=0) < 1e-12) & (path.p.min(axis=0) > _FRICTION * 1e-9)
        permanent.append(cell * np.count_nonzero(still) / 2)
        works.append(steady.dissipation / _GROSS**2)
        residuals.append(steady.residual)
    over = "amplitude of P / mean P"
    how = (
        f"{parameters.cells} cells, shear in phase, Q = {parameters.swing_shear:g} f P at the ends"
    )
    half = sqrt(1 - parameters.swing_shear)
    yield Case(
        "Barber, Davies & Hills 2011",
        "half-width of the permanent stick zone / a under a normal force that varies",
        over,
        f"{how}; within a cell, {cell:.2g}",
        parameters.swings,
        lambda _: half,
        permanent,
        max(residuals),
    )
    yield Case(
        "Mindlin & Deresiewicz 1953, Jäger 1998",
        "work of friction per cycle under a normal force that varies, W E* / (f P)^2",
        over,
        f"{how}; pressure is even within a cell",
        parameters.swings,
        partial(work_of_both, share=parameters.swing_shear),
        works,
        max(residuals),
    )
    rest = fo.steady_state(
        cylinder, _swinging(parameters.still_swing, parameters.still_shear), _FRICTION, 1.0
    )
    yield Case(
        "Mindlin & Deresiewicz 1953",
        "the same where the shear force changes by less than f times the normal force",
        over,
        f"{parameters.cells} cells, Q = {parameters.still_shear:g} f P: what has slipped once "
        "rests, so no work in either",
        (parameters.still_swing,),
        lambda _: 0.0,
        (rest.dissipation / _GROSS**2,),
        rest.residual,
    )


def _swinging(swing: float, share: float) -> fo.LoadCycle:
    return opposed({"P": _CYLINDER.P}, {"P": swing * _CYLINDER.P, "Q": share * _GROSS})


def work_of_both(swing: float, share: float) -> float:
    """Work of friction per cycle, W E* / (f P)^2, of a cylinder under forces in phase.

    The normal force varies by `swing P`, and the shear force by `share f P`. At a point of the
    path, the change of shear since the last end of the path is the difference of two terms. The
    first term is full slip under the sum of both pressures. The second term is twice the shear of a
    stick zone that would carry the force P_s (Mindlin & Deresiewicz 1953 for spheres, Jäger 1998
    for all shapes). In the plane the normal and the tangential approach both vary with the force by
    `D(P) = -P log P / (pi E*)`, up to terms that cancel. `S` is the integral of D. `g`, above 1, is
    the change of shear over the change of the normal force, divided by f. P_c is the force of the
    permanent stick zone. Then the area of the loop is::

        W = 2 f^2 g (2 (S_1 - S_c) / (g - 1) + 2 (S_2 - S_c) / (g + 1) - (S_2 - S_1) - (P_2 - P_1)
        D_c)
    """
    P, g = _CYLINDER.P, share / swing
    low, high, core = P * (1 - swing), P * (1 + swing), P * (1 - share)

    def displacement(force: float) -> float:
        return -force * log(force) / pi

    def integral(force: float) -> float:
        return -(force**2) * (2 * log(force) - 1) / (4 * pi)

    at_low, at_high, at_core = integral(low), integral(high), integral(core)
    sums = (
        2 * (at_low - at_core) / (g - 1)
        + 2 * (at_high - at_core) / (g + 1)
        - (at_high - at_low)
        - (high - low) * displacement(core)
    )
    return 2 * g * sums / P**2


def _out_of_phase(cylinder: fo.ContactSystem, parameters: Parameters) -> Case:
    swing, share = parameters.still_swing, parameters.swing_shear
    steady = []
    for phase in parameters.phases:
        loads: dict[str, float | tuple[float, float]] = {
            "Q": share * _GROSS,
            "P": (swing * _CYLINDER.P, phase),
        }
        cycle = fo.LoadCycle.harmonic(loads, mean={"P": _CYLINDER.P}, points=parameters.points)
        steady.append(fo.steady_state(cylinder, cycle, _FRICTION, 1.0))
    how = f"{parameters.cells} cells, Q = {share:g} f P, amplitude of P {swing:g} P, {parameters.points} corners in place of an ellipse"
    return Case(
        "Putignano, Ciavarella & Barber 2011",
        "work of friction per cycle of a cylinder under loads out of phase, W E* / (f P)^2",
        "phase of the normal force, degrees",
        f"{how}; theirs: superposition in steps of {360 / _STEPS:g} degrees with "
        f"{parameters.springs} springs",
        parameters.phases,
        lambda phase: work_of_springs(swing, share, phase, parameters.springs),
        [one.dissipation / _GROSS**2 for one in steady],
        max(one.residual for one in steady),
        curve=False,
    )


def work_of_springs(swing: float, share: float, phase: float, springs: int) -> float:
    """Work of friction per cycle, W E* / (f P)^2, of a cylinder under harmonic forces.

    The normal force is `P + swing P cos(t + phase)`, the shear force `share f P cos t`. The
    superposition of Jäger and Ciavarella equals uncoupled springs. Each spring touches above some
    normal force. Its pressure is the growth of D since that force (see `work_of_both`, with a rigid
    motion that makes D rise), and it slips at f times this pressure. The springs are equally stiff
    in both directions. Together, the springs that touch at a force have the stiffness of the
    contact at this force, `1 / D'`. The second cycle is steady.
    """
    P = _CYLINDER.P

    def displacement(force: Array) -> Array:
        return force - force * np.log(force) / pi

    touch = np.linspace(0.0, P * (1 + swing), springs + 1)
    stiffness = np.diff(np.r_[0.0, 1 / (1 - (1 + np.log(touch[1:])) / pi)])
    middle = displacement((touch[1:] + touch[:-1]) / 2)
    spring, works = np.zeros(springs), []
    for angle in np.linspace(0.0, 4 * pi, 2 * _STEPS + 1):
        normal_force = P * (1 + swing * np.cos(angle + radians(phase)))
        shear_force = share * _GROSS * np.cos(angle)
        bound = _FRICTION * np.maximum(displacement(np.array(normal_force)) - middle, 0.0)
        arguments = spring, bound, stiffness, shear_force
        motion = brentq(_missing, -9.0, 9.0, args=arguments, xtol=1e-13)
        moved = np.clip(spring + motion, -bound, bound)
        works.append(float(stiffness @ (bound * np.abs(spring + motion - moved))))
        spring = moved
    return sum(works[_STEPS + 1 :]) / _GROSS**2


def _missing(way: float, spring: Array, bound: Array, stiffness: Array, shear: float) -> float:
    return float(stiffness @ np.clip(spring + way, -bound, bound)) - shear


def _rounded_punch(parameters: Parameters) -> Case:
    bare = fo.ContactSystem.from_blocks(**half_plane_contact(parameters.cells, _HALF_LENGTH, 1.0))
    punch = bare.with_gap(np.maximum(np.abs(bare.x) - parameters.flat, 0.0) ** 2 / 2)
    force, cell = force_on_rounded(1.0, parameters.flat), 2 * _HALF_LENGTH / parameters.cells
    sticks, residuals = [], []
    for share in parameters.shears:
        q, p, residual = first_loading(
            punch, opposed({"P": force}, {"Q": share * _FRICTION * force}), _FRICTION
        )
        sticks.append(cell * np.count_nonzero(stuck(q, p, _FRICTION)) / 2)
        residuals.append(residual)

    def stick(share: float) -> float:
        return float(
            brentq(
                lambda half: force_on_rounded(half, parameters.flat) - (1 - share) * force,
                parameters.flat,
                1.0,
            )
        )

    return Case(
        "Ciavarella, Hills & Monno 1998",
        f"half-width of the stick zone / a, punch of rounded edges, flat over {parameters.flat:g} a",
        "Q / (f P)",
        f"{parameters.cells} cells; within one, {cell:.2g}",
        parameters.shears,
        stick,
        sticks,
        max(residuals),
    )


def force_on_rounded(half: float, flat: float) -> float:
    """Normal force on a contact of this half-width under a punch with rounded edges, E* = 1.

    The punch is flat over `flat`, and its edges have the radius 1. `P = E* a^2 (pi - 2 phi - sin 2
    phi) / (4 R)` with `sin phi = flat / a` (Ciavarella, Hills & Monno 1998). This force is `E*`
    times the integral of the slope of the profile times `x / sqrt(a^2 - x^2)`. With the force `P -
    Q / f` the contact is the stick zone (Ciavarella 1998, Jäger 1998).
    """
    phi = asin(min(1.0, flat / half))
    return half**2 * (pi - 2 * phi - sin(2 * phi)) / 4
