"""A rigid sphere on a half-space by tamaas, run by a Python that has tamaas.

This Python need not have frictopt.

The program reads one question as JSON and writes the answer as JSON, see `programs`. Lengths are in
units of the side of the periodic box, and moduli such that E / (1 - nu^2) is 1. The material is
incompressible, so that pressure and shear do not couple, as in the closed forms.
"""

import json
import sys
import time
from typing import Any

import numpy as np
import tamaas as tm

Array = np.ndarray[Any, Any]

NU = 0.5


def sphere(asked: dict[str, Any]) -> tuple[Any, Array, float, Array]:
    """Model of the half-space, gap of the sphere, and its load, with a contact of radius `a`."""
    cells, a, radius = asked["cells"], asked["a"], asked["R"]
    kind = tm.model_type.surface_2d if asked["shear"] else tm.model_type.basic_2d
    model = tm.Model(kind, [1.0, 1.0], [cells, cells])
    model.E = 1.0 - NU**2
    model.nu = NU
    place = (np.arange(cells) - cells // 2) / cells
    x, y = np.meshgrid(place, place, indexing="ij")
    surface = -(x**2 + y**2) / (2 * radius)
    return model, surface, 4 * a**3 / (3 * radius), np.hypot(x, y)


def pressed(asked: dict[str, Any]) -> tuple[Array, Array]:
    """Pressures of a sphere that is pressed, and the distance of each cell from its middle."""
    model, surface, load, r = sphere(asked)
    solver = tm.PolonskyKeerRey(model, surface, asked["tolerance"])
    if not asked["periodic"]:
        tm.ModelFactory.registerNonPeriodic(model, "free")
        solver.setIntegralOperator("free")
    solver.solve(load)
    return np.array(model.traction), r


def sheared(asked: dict[str, Any]) -> tuple[Array, Array]:
    """Shear along the force and pressure of a sphere that is pressed and sheared at once."""
    model, surface, load, r = sphere(asked)
    method = getattr(tm, asked["method"])
    solver = method(model, surface, asked["tolerance"], asked["friction"])
    solver.max_iter = asked["iterations"]
    force = [asked["share"] * asked["friction"] * load, 0.0, load]
    solver.solve(force)
    return np.array(model.traction)[..., 0], r


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    tm.initialize(1)
    tm.set_log_level(tm.LogLevel.error)
    started = time.process_time()
    traction, r = (sheared if asked["shear"] else pressed)(asked)
    seconds = time.process_time() - started
    answer = {"traction": traction.ravel().tolist(), "r": r.ravel().tolist()}
    print(json.dumps(answer | {"seconds": seconds, "version": tm.__version__}))
