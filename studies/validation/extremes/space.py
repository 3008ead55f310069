"""Questions with extreme input in three dimensions, each with an independent answer."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

import frictopt as fo
from studies.validation.closed_forms import smallest_circle_limit
from studies.validation.extremes.probes import Probe, Sizes, shakedown
from studies.validation.polygons import polygon_limit

_BULK = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
_TURNING = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])


def space_probes(sizes: Sizes) -> Iterator[Probe]:
    """All questions in three dimensions."""
    scene = fo.scenes.SquarePunch(elements=min(4, sizes.elements // 4), growth=2.0)
    for f in (0.01, 0.1, 0.5, 2.0, 5.0):
        yield from _limits("friction, 3-D", f"f = {f:g}", scene, f)
    for ratio in (1e-4, 1e-2, 1e2, 1e4):
        yield from _limits(
            "stiffness of punch over block, 3-D",
            f"{ratio:g}",
            replace(scene, punch_material=fo.fem.Material(ratio)),
            0.5,
        )
    for nu in (0.0, 0.4999):
        material = fo.fem.Material(1.0, nu)
        mean = replace(
            scene, punch_material=material, block_material=material, element="mean_dilatation"
        )
        yield from _limits("Poisson's ratio, 3-D", f"{nu:g}", mean, 0.5)
    plain = scene.condense()
    known = partial(shakedown, plain, _BULK, 0.5)
    for unit in (1e-12, 1e12):
        scaled = fo.ContactSystem(
            unit * plain.S,
            plain.points,
            {name: (unit * q, unit * p) for name, (q, p) in plain.bonded.items()},
        )
        yield Probe(
            "units, 3-D",
            f"{unit:g}",
            "shakedown limit",
            partial(shakedown, scaled, _BULK, 0.5),
            lambda: known().number,
            "other units",
        )
    for nodes in (1, 10, sizes.elements):
        yield _uncoupled(nodes)


def _limits(
    extreme: str, value: str, scene: fo.scenes.SquarePunch, friction: float
) -> Iterator[Probe]:
    """Questions about limits with all nodes closed, because the polygons have no open nodes."""
    system = scene.condense()
    closed = np.zeros(system.nodes, dtype=bool)
    for cycle, question in (
        (_BULK, "shakedown limit, bulk"),
        (_TURNING, "shakedown limit, turning"),
    ):
        yield Probe(
            extreme,
            value,
            question,
            partial(shakedown, system, cycle, friction, open_nodes=closed),
            partial(polygon_limit, system, cycle, friction),
            "linear programs, polygons for the circles, scipy",
        )


def _uncoupled(nodes: int) -> Probe:
    """The question about an uncoupled contact whose pressures differ much."""
    rng = np.random.default_rng(nodes)
    G = rng.normal(size=(2 * nodes, 2 * nodes))
    S = np.zeros((3 * nodes, 3 * nodes))
    S[: 2 * nodes, : 2 * nodes] = G @ G.T / nodes + np.eye(2 * nodes)
    S[2 * nodes :, 2 * nodes :] = np.eye(nodes)
    p0 = 10.0 ** rng.uniform(-3, 3, nodes)
    q1 = rng.normal(size=(5, nodes, 2))
    cases = {f"{k}": np.r_[q[:, 0], q[:, 1], np.zeros(nodes)] for k, q in enumerate(q1)}
    system = fo.ContactSystem(
        S, rng.normal(size=(nodes, 3)), {"mean": np.r_[np.zeros(2 * nodes), p0], **cases}
    )
    cycle = fo.LoadCycle({"mean": 1.0}, [{name: 1.0} for name in cases])
    return Probe(
        "pressures over six decades, uncoupled, 3-D",
        f"{nodes} nodes",
        "shakedown limit",
        partial(shakedown, system, cycle, 0.5),
        partial(smallest_circle_limit, p0, q1, 0.5),
        "smallest circle",
    )
