"""Contacts in the plane: a block that slides as a whole, and a cylinder sheared to and fro."""

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from skfem import MeshQuad

import frictopt as fo
from studies.validation.error_vs_time.lemke import Lemke
from studies.validation.error_vs_time.methods import Method, installed, relative
from studies.validation.error_vs_time.parameters import CYLINDER, CYLINDER_LOADS, SHEAR, cylinder
from studies.validation.error_vs_time.transients import last_work
from studies.validation.peers.parameters import Parameters
from studies.validation.peers.programs import GETFEM, KRATOS, SICONOS
from studies.validation.peers.questions import Asked, Contact

Array = np.ndarray[Any, Any]

# The block: sides 1, Young's modulus 1, Poisson's ratio 0. Its top is pushed down and moved to and
# fro. Strains are small, because Kratos moves the contact with the bodies.
SHEAR_MODULUS = 0.5
FRICTION = 0.5
DOWN = 1e-4
FAR = 2e-4
# Friction bound of the shear stress.
BOUND = FRICTION * DOWN

# Largest number of pivots of Lemke's method, which needs fewer.
_PIVOTS = 100000


def contacts(parameters: Parameters) -> Iterator[Contact]:
    """The block and the cylinder."""
    yield _block(parameters)
    yield _cylinder(parameters)


def block_work() -> float:
    """Work of a cycle of a slider on a spring: `4 f P (far - f P / k)`."""
    return 4 * BOUND * (FAR - BOUND / SHEAR_MODULUS)


def corners() -> list[tuple[float, float]]:
    """Motion of the top and shear stress at the corners of the loop, two cycles from no load."""
    back = 2 * BOUND / SHEAR_MODULUS
    loop = [(FAR - back, -BOUND), (-FAR, -BOUND), (back - FAR, BOUND), (FAR, BOUND)]
    return [(0.0, 0.0), (BOUND / SHEAR_MODULUS, BOUND), (FAR, BOUND), *loop, *loop]


def steps(increments: int) -> list[tuple[float, float]]:
    """Motion and shear stress after each increment, with a number of increments per segment."""
    path = [(0.0, 0.0)]
    for before, after in pairwise(np.array(corners())):
        for k in range(1, increments + 1):
            x, shear = before + k / increments * (after - before)
            path.append((float(x), float(shear)))
    return path


def work_of_top(motions: Array, shears: Array, increments: int) -> float:
    """Work of the top in the last cycle, from the shear force after each increment."""
    x, force = motions[-4 * increments - 1 :], shears[-4 * increments - 1 :]
    return float(abs(np.trapezoid(force, x)))


def block_of_frictopt(elements: int) -> fo.ContactSystem:
    """The block on fixed ground; "down" and "x" move its top, "side" shears its sides."""
    along = np.linspace(0.0, 1.0, elements + 1)
    edges = {
        "contact": lambda x: x[1] == 0.0,
        "top": lambda x: x[1] == 1.0,
        "left": lambda x: (x[0] == 0.0) & (x[1] >= 0.0),
        "right": lambda x: (x[0] == 1.0) & (x[1] >= 0.0),
    }
    block = fo.fem.Body(
        MeshQuad.init_tensor(along, along).with_boundaries(edges),
        fo.fem.Material(2 * SHEAR_MODULUS, 0.0),
    )
    ground = fo.fem.Body(
        MeshQuad.init_tensor(along, np.array([-1.0 / elements, 0.0])).with_boundaries(
            {"contact": lambda x: x[1] == 0.0, "base": lambda x: x[1] < 0.0}
        ),
        fo.fem.Material(2 * SHEAR_MODULUS, 0.0),
    )
    return fo.fem.ContactModel(
        {"block": block, "ground": ground},
        [
            fo.fem.Support("block", "top"),
            fo.fem.Support("ground", "base"),
            fo.fem.Support("ground", "contact"),
        ],
        {
            "down": [fo.fem.Displacement("block", "top", y=-1.0)],
            "x": [fo.fem.Displacement("block", "top", x=1.0)],
            "side": [
                fo.fem.Traction("block", "right", y=1.0),
                fo.fem.Traction("block", "left", y=-1.0),
            ],
        },
    ).condense(progress=False)


def _block_path(elements: int) -> fo.results.Trajectory:
    """The exact path of the block over two cycles."""
    loop = [{"x": x, "side": shear} for x, shear in corners()[-4:]]
    cycle = fo.LoadCycle({"down": DOWN}, loop)
    return fo.march(block_of_frictopt(elements), cycle, FRICTION, 1.0, cycles=2)


def _block(parameters: Parameters) -> Contact:
    """The block, with the methods of frictopt, GetFEM and Kratos."""
    ours, peers = [], []
    path = steps(1)
    question = {"shear_modulus": SHEAR_MODULUS, "friction": FRICTION, "down": DOWN, "steps": path}
    for elements in parameters.block_elements:
        ours.append(
            Method(
                "frictopt, exact path and condensation",
                "elements",
                f"{elements} x {elements}",
                partial(_block_path, elements),
                relative(block_work(), last_work),
            )
        )
        setting = f"elements {elements} x {elements}"
        own = {"elements": elements, "augmentation": 1.0, "tolerance": 1e-12}
        error = partial(_error_of_top, np.array(path)[:, 0], 1)
        for method, history in (("with wt", True), ("without wt", False)):
            asked = question | own | {"history": history}
            peers.append(Asked(GETFEM, f"integral contact, {method}", setting, asked, error))
        for increments in parameters.kratos_increments:
            finer = steps(increments)
            asked = question | own | {"process_friction": FRICTION, "steps": finer}
            error_of_finer = partial(_error_of_top, np.array(finer)[:, 0], increments)
            said = f"{setting}, steps from corner to corner: {increments}"
            peers.append(Asked(KRATOS, "ALM mortar", said, asked, error_of_finer))
    name = "block on rigid ground, slides as a whole"
    return Contact(name, "work of a cycle", "slider on a spring", ours, peers)


def _error_of_top(motions: Array, increments: int, answer: Mapping[str, Any]) -> float:
    """Relative error of the work of the top, from the shear forces of a peer."""
    shears = np.array(answer["shears"])
    return abs(work_of_top(motions, shears, increments) / block_work() - 1)


def _cylinder(parameters: Parameters) -> Contact:
    """The cylinder, with the methods of frictopt, quantecon and Siconos."""
    exact = CYLINDER.dissipation(SHEAR)
    ours, peers = [], []
    for cells in parameters.cylinder_cells:
        followed = partial(fo.march, cylinder(cells), CYLINDER_LOADS, CYLINDER.f, SHEAR, cycles=2)
        setting = f"{cells}"
        error = relative(exact, last_work)
        ours.append(Method("frictopt, exact path", "cells", setting, followed, error))
        for increments in parameters.cylinder_steps:
            loads = _loads(cylinder(cells), increments)
            setting = f"cells {cells}, {increments} increments from corner to corner"
            if installed("quantecon"):
                work = partial(_lemke, cells, loads, increments)
                named = ("Lemke", "none", setting, work, relative(exact, float), "quantecon")
                ours.append(Method(*named))
            question = {
                "space": False,
                "friction": CYLINDER.f,
                "force": CYLINDER.P / cells,
                "S": cylinder(cells).S.tolist(),
                "loads": [load.tolist() for load in loads],
                "tolerance": None,
            }
            error_of_works = partial(_error_of_works, exact, 2 * increments)
            limits = {"LEMKE": _PIVOTS, "NEWTON_MIN_FBLSA": parameters.siconos_iterations}
            for solver, iterations in limits.items():
                asked = question | {"solver": f"SICONOS_LCP_{solver}", "iterations": iterations}
                peers.append(Asked(SICONOS, f"LCP {solver}", setting, asked, error_of_works))
    name = "cylinder, sheared to and fro, Q = 0.75 f P"
    return Contact(name, "work of a cycle", "closed form of a half-plane", ours, peers)


def _loads(system: fo.ContactSystem, increments: int) -> list[Array]:
    """Reactions (2N,) of the closed contact after each increment of two cycles.

    One increment leads to the mean load.
    """
    mean = np.concatenate(system.closed_reaction(CYLINDER_LOADS.mean))
    ends = [
        np.concatenate(system.closed_reaction({**CYLINDER_LOADS.mean, "Q": sign * SHEAR}))
        for sign in (1.0, -1.0)
    ]
    loads = [mean, mean]
    for before, after in pairwise([mean, *ends, *ends]):
        for k in range(1, increments + 1):
            loads.append(before + k / increments * (after - before))
    return loads


def _lemke(cells: int, loads: list[Array], increments: int) -> float:
    """Work in the second cycle, by increments of quantecon's method."""
    rival = Lemke(cylinder(cells), CYLINDER.f, CYLINDER.P / cells)
    v, pressure, works = np.zeros(cells), np.zeros(cells), []
    for load in loads[1:]:
        new, after = rival.increment(v, load)
        works.append(float(CYLINDER.f * np.abs(new - v) @ (pressure + after) / 2))
        v, pressure = new, after
    return sum(works[-2 * increments :])


def _error_of_works(exact: float, count: int, answer: Mapping[str, Any]) -> float:
    """Relative error of the sum of the last works of a peer."""
    return float(abs(sum(answer["works"][-count:]) / exact - 1))
