"""A sphere on a half-space: pressed, sheared once, and sheared to and fro."""

from collections.abc import Iterator, Mapping
from functools import partial
from math import pi
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.reference import SphereContact, half_space_contact
from studies.validation.error_vs_time.methods import Method
from studies.validation.peers.parameters import Parameters
from studies.validation.peers.programs import SICONOS, TAMAAS
from studies.validation.peers.questions import Asked, Contact

Array = np.ndarray[Any, Any]

# Radius of the sphere; the radius of the contact is 1.
RADIUS = 5.0
# Width of the grid of cells divided by the width of the contact.
WIDTH = 1.12
# Shear force over f P.
SHARE = 0.5
FRICTION = 0.5


def contacts(parameters: Parameters) -> Iterator[Contact]:
    """The three contacts."""
    yield _pressed(parameters)
    yield _sheared(parameters)
    yield _to_and_fro(parameters)


def ellipse(r: Array, a: float) -> Array:
    """The square root of 1 - (r / a)^2 for r below a, and 0 outside."""
    return np.asarray(np.sqrt(np.maximum(1 - (r / a) ** 2, 0.0)))


def pressure(r: Array) -> Array:
    """Pressure of Hertz over its peak, with a contact of radius 1."""
    return ellipse(r, 1.0)


def shear(r: Array) -> Array:
    """Shear of Cattaneo and Mindlin over f times the peak pressure."""
    stick = (1 - SHARE) ** (1 / 3)
    return np.asarray(pressure(r) - stick * ellipse(r, stick))


def norm_error(found: Array, exact: Array) -> float:
    """The norm of the difference over the norm of the exact values."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


# If both materials are incompressible, or equal, shear and pressure are uncoupled.
_NU = 0.5


def _grid(cells: int, nu: float) -> fo.ContactSystem:
    """The contact on a grid of cells."""
    arrays: Any = half_space_contact(cells, WIDTH, RADIUS, 1.0, nu)
    return fo.ContactSystem(**arrays)


def _far(nu: float) -> float:
    """Motion of the far end under the share of the shear force (Mindlin and Deresiewicz)."""
    load = 1 / (1.5 * RADIUS * (1 - nu**2))  # makes a contact of radius 1
    modulus = 1 / (2 * (1 + nu))
    slide = 3 * FRICTION * load * (2 - nu) / (16 * modulus)
    return float(2 * slide * (1 - (1 - SHARE) ** (2 / 3)))


def _peak(cells: int, nu: float) -> float:
    """Force on a cell under the peak pressure of Hertz."""
    load = 1 / (1.5 * RADIUS * (1 - nu**2))  # makes a contact of radius 1
    return float(1.5 * load / pi * (2 * WIDTH / cells) ** 2)


def _sheared_once(cells: int, nu: float) -> tuple[Array, Array]:
    """Distance of cells from the middle, and shear along the force over f times the peak pressure."""
    system = _grid(cells, nu)
    cycle = fo.LoadCycle({"approach": 1 / RADIUS}, [{"x": 1.0}, {"x": -1.0}])
    path = fo.march(system, cycle, FRICTION, _far(nu), cycles=1, steps=1)
    corner = int(np.flatnonzero(path.time == 1)[0])
    r = np.hypot(system.points[:, 0], system.points[:, 1])
    return r, np.abs(path.q[corner, :, 0]) / (FRICTION * _peak(cells, nu))


def _pressed(parameters: Parameters) -> Contact:
    """The sphere that is only pressed."""

    def pressed(cells: int) -> tuple[Array, Array]:
        system = _grid(cells, _NU)
        increment = fo.increments.NewtonIncrement(system, FRICTION)
        load = system.reaction({"approach": 1 / RADIUS})
        state = increment.solve(np.zeros(system.slip_shape), load)
        r = np.hypot(system.points[:, 0], system.points[:, 1])
        return r, state.p / _peak(cells, _NU)

    ours = [
        Method(
            "frictopt",
            "cells across",
            f"{cells}",
            partial(pressed, cells),
            lambda found: norm_error(found[1], pressure(found[0])),
        )
        for cells in parameters.sphere_cells
    ]
    peers = [
        Asked(
            TAMAAS,
            "PolonskyKeerRey" if periodic else "PolonskyKeerRey, no neighbours",
            f"{cells} x {cells} cells, a = {a:g} L",
            _of_tamaas(cells, a) | {"shear": False, "periodic": periodic, "tolerance": 1e-12},
            partial(_error_of_tamaas, a, pressure, 1.0),
        )
        for periodic in (False, True)
        for cells in parameters.tamaas_cells
        for a in parameters.tamaas_radii[1:]
    ]
    name = "sphere, pressed"
    return Contact(name, "pressure, norm of the difference", "Hertz", ours, peers)


def _of_tamaas(cells: int, a: float) -> dict[str, Any]:
    """The part of a question to tamaas that describes the grid."""
    return {"cells": cells, "a": a, "R": 4.0}


def _error_of_tamaas(a: float, exact: Any, friction: float, answer: Mapping[str, Any]) -> float:
    """Error of the tractions of tamaas, which have E / (1 - nu^2) = 1 and the radius 4."""
    found = np.abs(answer["traction"]) / (friction * 2 * a / (pi * 4.0))
    return norm_error(found, exact(np.array(answer["r"]) / a))


def _sheared(parameters: Parameters) -> Contact:
    """The sphere that is pressed and sheared once."""
    ours = [
        Method(
            "frictopt",
            "cells across",
            f"{cells}",
            partial(_sheared_once, cells, _NU),
            lambda found: norm_error(found[1], shear(found[0])),
        )
        for cells in parameters.sphere_cells
    ]
    peers = [
        Asked(
            TAMAAS,
            method,
            f"{cells} x {cells} cells, a = {a:g} L",
            _of_tamaas(cells, a)
            | {
                "shear": True,
                "method": method,
                "friction": FRICTION,
                "share": SHARE,
                "tolerance": 1e-9,
                "iterations": parameters.tamaas_iterations,
            },
            partial(_error_of_tamaas, a, shear, FRICTION),
        )
        for method in ("PolonskyKeerTan", "Condat", "Kato", "BeckTeboulle")
        for cells in parameters.tamaas_cells[:-1]
        for a in parameters.tamaas_radii
    ]
    name = "sphere, pressed and sheared once, Q = 0.5 f P"
    return Contact(name, "shear, norm of the difference", "Cattaneo and Mindlin", ours, peers)


def work_error(work: float, normal: float, tangential: float) -> float:
    """Error of the work of a cycle, for a sphere with nu = 0 under these forces."""
    ball = SphereContact(normal, RADIUS, 1.0, 0.0, FRICTION)
    return abs(work / ball.dissipation(tangential) - 1)


def _to_and_fro(parameters: Parameters) -> Contact:
    """The sphere sheared to and fro: Siconos has the matrices and loads of frictopt."""
    cycle = fo.LoadCycle({"approach": 1 / RADIUS}, [{"x": 1.0}, {"x": -1.0}])

    def followed(cells: int) -> fo.results.Trajectory:
        return fo.march(_grid(cells, 0.0), cycle, FRICTION, _far(0.0), cycles=2, steps=2)

    def error(path: fo.results.Trajectory) -> float:
        corner = int(np.flatnonzero(path.time == 1)[0])
        forces = float(path.p[corner].sum()), abs(float(path.q[corner, :, 0].sum()))
        return work_error(float(path.cycle_work[-1].sum()), *forces)

    ours, peers = [], []
    for cells in parameters.siconos_cells:
        ours.append(Method("frictopt", "cells across", f"{cells}", partial(followed, cells), error))
        path = followed(cells)
        corner = int(np.flatnonzero(path.time == 1)[0])
        forces = float(path.p[corner].sum()), abs(float(path.q[corner, :, 0].sum()))
        system = _grid(cells, 0.0)
        question = {
            "space": True,
            "friction": FRICTION,
            "S": system.S.tolist(),
            "loads": _loads(system, _far(0.0)),
            "iterations": 100 * parameters.siconos_iterations,
        }
        for solver, tolerance in (("NSGS", None), ("NSGS", 1e-10), ("NSN_AC", 1e-10)):
            said = "its own tolerance" if tolerance is None else f"tolerance {tolerance:.0e}"
            peers.append(
                Asked(
                    SICONOS,
                    solver,
                    f"{cells} cells across, {said}",
                    question | {"solver": f"SICONOS_FRICTION_3D_{solver}", "tolerance": tolerance},
                    partial(_error_of_siconos, forces),
                )
            )
    name = "sphere, sheared to and fro, Q = 0.5 f P"
    return Contact(name, "work of a cycle", "Mindlin and Deresiewicz", ours, peers)


def _loads(system: fo.ContactSystem, far: float) -> list[list[float]]:
    """Reactions of the closed contact after each increment.

    One increment presses the sphere. Two increments follow for each half cycle.
    """
    motions = [0.0, 0.5, 1.0] + 2 * [0.0, -1.0, 0.0, 1.0]
    loads = []
    for motion in motions:
        q, p = system.closed_reaction({"approach": 1 / RADIUS, "x": motion * far})
        loads.append(np.concatenate([q.T.ravel(), p]).tolist())
    return [loads[0], *loads]


def _error_of_siconos(forces: tuple[float, float], answer: Mapping[str, Any]) -> float:
    """Error of the work of the last cycle of Siconos."""
    return work_error(sum(answer["works"][-4:]), *forces)
