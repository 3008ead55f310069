"""A square punch in three dimensions: its face at the limit, errors of increments, and proofs.

Run with `python -m studies spatial [--quick]`. The loads are bulk stress, and shear that turns, in
units of the mean pressure on the punch.
"""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

import frictopt as fo

from .progress import each
from .space import LOADS
from .tables import Row, Study, Table, described, markdown, two_digits


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    map_elements: int = 16
    map_friction: float = 0.5
    step_elements: int = 6
    # Load factor of the transients relative to lambda_2.
    step_ratio: float = 1.15
    steps: tuple[int, ...] = (2, 4, 8, 16, 32, 64)
    reference_steps: int = 256
    proof_elements: int = 19
    proof_frictions: tuple[float, ...] = (0.1, 0.3, 0.5, 1.0, 2.0)
    # Young's modulus of the punch relative to the block.
    proof_ratios: tuple[float, ...] = (1e-4, 1e-2, 1.0, 1e2, 1e4)
    # Units of force, and of length.
    proof_units: tuple[float, ...] = (1e-12, 1e12)


FULL = Parameters()
QUICK = Parameters(
    map_elements=4,
    step_elements=2,
    steps=(2, 4, 8),
    reference_steps=32,
    proof_elements=3,
    proof_frictions=(0.3,),
)


def faces_at_limit(parameters: Parameters) -> Iterator[Row]:
    """One row per load cycle and node, at the limit."""
    scene = fo.scenes.SquarePunch(elements=parameters.map_elements)
    system = scene.condense()
    for load, cycle in each(LOADS.items(), "faces at the limit"):
        limit = fo.shakedown_limit(system, cycle, parameters.map_friction)
        face = limit.to_frame().filter(described(_MAP))
        share = (
            limit.mechanism.groupby("node")["share"]
            .sum()
            .reindex(range(system.nodes), fill_value=0.0)
        )
        mean_pressure = float(system.bonded["P"][1].sum()) / (4 * scene.half_width**2)
        unit = mean_pressure * scene.half_width / scene.block_material.E
        face = face.assign(
            first_ratio=limit.traction_ratios[0],
            slip1=face["slip1"] / unit,
            slip2=face["slip2"] / unit,
            share=share.to_numpy(),
        )
        yield face.assign(load=load, load_factor=limit.load_factor, residual=limit.residual)


def error_of_increments(parameters: Parameters) -> Iterator[Row]:
    """One row per load cycle and number of increments."""
    system = fo.scenes.SquarePunch(elements=parameters.step_elements).condense()
    for load in ("to and fro", "turning, 4 corners"):
        cycle = LOADS[load]
        limit = fo.shakedown_limit(system, cycle, parameters.map_friction)
        at = parameters.step_ratio * limit.load_factor
        states = {
            steps: fo.steady_state(system, cycle, parameters.map_friction, at, steps=steps)
            for steps in each(
                (*parameters.steps, parameters.reference_steps), f"increments, {load}"
            )
        }
        reference = states[parameters.reference_steps].dissipation
        for steps, steady in list(states.items())[:-1]:
            error = abs(steady.dissipation / reference - 1)
            yield {
                "load": load,
                "steps": steps,
                "error": error,
                **{
                    column: getattr(steady, column)
                    for column in ("dissipation", "step_error", "cycles", "residual")
                },
            }


def proofs_of_limits(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh, ratio of stiffness, unit, load cycle and friction.

    Other units are tried only on the even mesh of bodies of equal stiffness.
    """
    cases = [(mesh, ratio) for mesh in ("even", "uneven") for ratio in parameters.proof_ratios]
    for mesh, ratio in each(cases, "proofs of limits"):
        model = fo.scenes.SquarePunch(
            elements=parameters.proof_elements, punch_material=fo.fem.Material(ratio)
        ).model()
        system = (_uneven(model) if mesh == "uneven" else model).condense()
        others = [(unit, 1.0) for unit in parameters.proof_units] + [
            (1.0, unit) for unit in parameters.proof_units
        ]
        for force, length in [(1.0, 1.0), *(others if mesh == "even" and ratio == 1.0 else [])]:
            bonded = {name: (q / force, p / force) for name, (q, p) in system.bonded.items()}
            scaled = fo.ContactSystem(
                system.S * (length / force), system.points / length, bonded, frames=system.frames
            )
            for load in ("bulk", "turning, 4 corners"):
                for friction in parameters.proof_frictions:
                    named = {
                        "mesh": mesh,
                        "nodes": system.nodes,
                        "ratio": ratio,
                        "force": force,
                        "length": length,
                        "load": load,
                    }
                    yield named | {"friction": friction} | _proof(scaled, LOADS[load], friction)


def _proof(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float) -> dict[str, Any]:
    """The gap between the bounds of slip and mechanism with all nodes closed, or the error in its place.

    The nodes are kept closed even if high friction would open some of them.
    """
    with threadpool_limits(1):
        start = time.process_time()
        try:
            limit = fo.shakedown_limit(
                system, cycle, friction, open_nodes=np.zeros(system.nodes, dtype=bool)
            )
        except fo.SolverError as error:
            return {
                "result": str(error),
                "load_factor": np.nan,
                "gap": np.nan,
                "seconds": time.process_time() - start,
                "residual": np.nan,
            }
        seconds = time.process_time() - start
    gap = abs(limit.bound / limit.load_factor - 1)
    return {
        "result": "answer",
        "load_factor": limit.load_factor,
        "gap": gap,
        "seconds": seconds,
        "residual": limit.residual,
    }


def _uneven(model: fo.fem.ContactModel) -> fo.fem.ContactModel:
    """The model with the nodes of its face moved towards the edges.

    Along each side the element at the edge is at most a tenth of the element in the middle.
    """

    def moved(x: Any) -> Any:
        return np.where(np.abs(x) < 1, np.sign(x) * (1 - (1 - np.abs(x)) ** 2), x)

    def with_moved(body: fo.fem.Body) -> fo.fem.Body:
        p, mesh = body.mesh.p.copy(), body.mesh
        p[:2] = moved(p[:2])
        return fo.fem.Body(
            type(mesh)(p, mesh.t).with_boundaries(dict(mesh.boundaries)),
            body.material,
            body.element,
        )

    return fo.fem.ContactModel(
        {name: with_moved(body) for name, body in model.bodies.items()}, model.supports, model.loads
    )


def _report(tables: Mapping[str, pd.DataFrame]) -> str:
    """The proofs of the limits, in Markdown."""
    proofs = tables["spatial_proofs"]
    ratios = list(dict.fromkeys(proofs["ratio"]))
    rows = []
    for (mesh, force, length, load), part in proofs.groupby(
        ["mesh", "force", "length", "load"], sort=False
    ):
        units = [
            f"unit of {name} {unit:g}"
            for name, unit in (("force", force), ("length", length))
            if unit != 1
        ]
        cells = [_cell(part[part["ratio"] == ratio]) for ratio in ratios]
        rows.append([", ".join([f"{mesh} mesh", *units, load]), *cells])
    head = [
        f"largest gap and time, N = {proofs['nodes'].iloc[0]}",
        *(f"ratio {ratio:g}" for ratio in ratios),
    ]
    return f"\n{markdown(head, rows)}"


def _cell(rows: pd.DataFrame) -> str:
    if not len(rows):
        return ""
    refused = int((rows["result"] != "answer").sum())
    answers = f"{rows['gap'].max():.0e}, {two_digits(rows['seconds'].max())} s"
    return answers + (f", {refused} refused" if refused else "")


_MAP = {
    "load_factor": "shakedown limit lambda_2, load over mean pressure",
    "y": "position / a",
    "slip1": "safe residual slip along x, v E / (a times mean pressure)",
    "slip2": "the same along y",
    "traction_ratio": "largest |q| / (f p) over the corners",
    "first_ratio": "|q| / (f p) at the first corner; NaN where p vanishes",
    "share": "share of the node in the slip of the limiting mechanism",
}
_STEP = {
    "steps": "increments from corner to corner",
    "dissipation": "work of friction per cycle in the steady state",
    "error": "its distance from that of the reference number of increments, relative",
    "step_error": "the error that the result itself gives",
    "cycles": "cycles followed",
}
_PROOF = {
    "mesh": "'even', or 'uneven': elements of the face that shrink towards the edges",
    "ratio": "Young's modulus of the punch over that of the block",
    "force": "unit of force",
    "length": "unit of length",
    "result": "'answer', or why the limit is refused",
    "load_factor": _MAP["load_factor"],
    "gap": "distance of the bound of the mechanism from what the slip carries, relative",
}

MAPS = Table(
    "spatial_maps",
    "one node at the shakedown limit",
    _MAP,
    full=FULL,
    quick=QUICK,
    compute=faces_at_limit,
)
STEPS = Table(
    "spatial_steps",
    "steady state with one number of increments",
    _STEP,
    full=FULL,
    quick=QUICK,
    compute=error_of_increments,
)

PROOFS = Table(
    "spatial_proofs",
    "shakedown limit at one corner of the range",
    _PROOF,
    full=FULL,
    quick=QUICK,
    compute=proofs_of_limits,
)

STUDY = Study(
    "studies.spatial", __doc__, "coarse meshes, in seconds", (MAPS, STEPS, PROOFS), _report
)
