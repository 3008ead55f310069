"""Two joints from their load history to fretting: a dovetail root, and a collar on a shaft.

Run with `python -m studies joint [--quick]`. The dovetail is the root of a blade; the collar is
shrunk onto the shaft. Lengths are in mm, stresses in MPa, forces in N (dovetail: per mm of depth;
press fit: of the whole circumference). The histories are invented: random turning points, sampled
on the straight segments between them, as by a data logger.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .tables import Row, Study, Table, described, markdown

STEEL = fo.fem.Material(E=210e3, nu=0.3)


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Number of elements on each flank.
    dovetail_elements: int = 40
    press_fit_elements: int = 80
    growth: float = 1.15
    # Number of turning points of each history.
    turns: int = 24
    # Number of rows from one turning point to the next.
    samples: int = 400
    seed: int = 20


FULL = Parameters()
QUICK = Parameters(dovetail_elements=10, press_fit_elements=16, growth=1.5, turns=8, samples=10)


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint: its model, friction, static load, and the history of its cyclic loads (time and load cases)."""

    name: str
    model: fo.fem.ContactModel
    friction: float
    mean: Mapping[str, float]
    loads: tuple[str, str]
    history: pd.DataFrame


def joints(parameters: Parameters) -> Iterator[Joint]:
    """The joints of the study."""
    rng = np.random.default_rng(parameters.seed)
    sizes = {
        "flank_length": 8.0,
        "neck_half_width": 8.0,
        "neck_height": 16.0,
        "foot_height": 6.0,
        "lug_height": 6.0,
    }
    dovetail = fo.scenes.Dovetail(
        elements=parameters.dovetail_elements,
        growth=parameters.growth,
        disc_half_width=40.0,
        disc_depth=40.0,
        edge_length=1.0,
        blade_material=STEEL,
        disc_material=STEEL,
        **sizes,
    )
    yield Joint(
        "dovetail",
        dovetail.model(),
        0.5,
        {"pull": 100.0},
        ("pull", "sway"),
        _history(rng, parameters, {"pull": (80.0, 120.0), "sway": (-4, 4)}),
    )
    press_fit = fo.scenes.PressFit(
        elements=parameters.press_fit_elements,
        growth=parameters.growth,
        shaft_radius=20.0,
        collar_radius=40.0,
        collar_length=40.0,
        shaft_length=160.0,
        shaft_material=STEEL,
        collar_material=STEEL,
    )
    loads = {"tension": (-40.0, 40.0), "push": (-5e3, 5e3)}
    yield Joint(
        "press fit",
        press_fit.model(),
        0.3,
        {"fit": 0.02},
        ("tension", "push"),
        _history(rng, parameters, loads),
    )


def _history(
    rng: np.random.Generator, parameters: Parameters, ranges: Mapping[str, tuple[float, float]]
) -> pd.DataFrame:
    """Rows of a data logger: straight segments between random turning points.

    At one turning point all loads have their largest values, and at another their least values.
    """
    least, most = np.array(list(ranges.values())).T
    turns = rng.uniform(least, most, size=(parameters.turns, len(ranges)))
    turns[1], turns[2] = most, least
    time = np.arange((parameters.turns - 1) * parameters.samples + 1) / parameters.samples
    columns = {
        name: np.interp(time, np.arange(parameters.turns), turn)
        for name, turn in zip(ranges, turns.T, strict=True)
    }
    return pd.DataFrame({"time": time, **columns})


def _cycle(joint: Joint) -> fo.LoadCycle:
    return fo.LoadCycle.from_history(joint.history, mean=dict(joint.mean))


def _fretting(
    joint: Joint, system: fo.ContactSystem
) -> tuple[fo.results.SteadyState, pd.DataFrame]:
    """The steady state under the history, and its fretting table with the stress of body 2."""
    steady = fo.steady_state(system, _cycle(joint), joint.friction, 1.0)
    stress, strain = zip(
        *(fields.at_contact(2) for fields in joint.model._over(steady, every=False)),
        strict=True,
    )
    return steady, steady.fretting_table(stress=np.array(stress), strain=np.array(strain))


def report(parameters: Parameters) -> Iterator[Row]:
    """One row for each joint."""
    for joint in joints(parameters):
        system, cycle = joint.model.condense(), _cycle(joint)
        limit = fo.shakedown_limit(system, cycle, joint.friction)
        required = fo.required_friction(system, cycle, 1.0)
        steady, table = _fretting(joint, system)
        worst = table.loc[table["F2"].idxmax()]
        yield {
            "joint": joint.name,
            "nodes": system.nodes,
            "samples": len(joint.history),
            "corners": len(cycle.corners),
            "friction": joint.friction,
            "shakedown": limit.load_factor,
            "required_friction": required.required,
            "outcome": steady.outcome.name,
            "dissipation": steady.dissipation,
            "slipping": int(steady.slipping.sum()),
            "worst_contact": worst["contact"],
            "worst_x": worst["x"],
            **{f"largest_{name}": table[name].max() for name in ("slip_range", "F1", "F2", "SWT")},
            "residual": max(limit.residual, required.residual, steady.residual),
        }


def fretting(parameters: Parameters) -> Iterator[Row]:
    """One row for each node of each joint."""
    for joint in joints(parameters):
        steady, table = _fretting(joint, joint.model.condense())
        yield table.filter(described(_NODES)).assign(joint=joint.name, residual=steady.residual)


def regions(parameters: Parameters) -> Iterator[Row]:
    """One row for each vertex of the safe region of each joint, and one for its load history."""
    for joint in joints(parameters):
        region = fo.safe_region(joint.model.condense(), joint.mean, joint.loads, joint.friction)
        head = {
            "joint": joint.name,
            "first": joint.loads[0],
            "second": joint.loads[1],
            "residual": region.residual,
        }
        yield from [head | {"what": "vertex", "a": a, "b": b} for a, b in region.vertices]
        reach = [
            float(np.abs(joint.history[name] - joint.mean.get(name, 0.0)).max())
            for name in joint.loads
        ]
        yield head | {"what": "history", "a": reach[0], "b": reach[1]}


def _summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The report's table, a column for each joint."""
    lines: dict[str, Any] = {
        "samples, and corners left of them": lambda row: f"{row.samples}, {row.corners}",
        "shakedown limit, times the history": lambda row: f"{row.shakedown:.3f}",
        "friction, and what the history requires": lambda row: (
            f"{row.friction:g}, {row.required_friction:.3f}"
        ),
        "steady state": lambda row: f"{row.outcome}, {row.dissipation:.3g} N mm a cycle",
        "nodes that slip": lambda row: f"{row.slipping} of {row.nodes}",
        "largest slip range": lambda row: f"{1e3 * row.largest_slip_range:.2f} um",
        "largest F1, F2": lambda row: f"{row.largest_F1:.3g} N/mm, {row.largest_F2:.3g} N^2/mm^3",
        "largest Smith-Watson-Topper": lambda row: f"{row.largest_SWT:.3g} MPa",
        "where": lambda row: f"{row.worst_contact}, x = {row.worst_x:.2f} mm",
    }
    found = list(tables["joint_report"].itertuples())
    return markdown(
        ["", *(row.joint for row in found)],
        [[name, *(text(row) for row in found)] for name, text in lines.items()],
    )


_REPORT = {
    "samples": "rows of the history",
    "corners": "points at which it turns",
    "required_friction": "least friction with which the history is safe",
    "outcome": "steady state under the history",
    "dissipation": "work of friction per cycle, N mm (the dovetail: per mm)",
    "slipping": "number of nodes that slip",
    "worst_contact": "contact with the largest F2",
    "worst_x": "its place, mm",
    "largest_slip_range": "mm",
    "largest_F1": "N/mm",
    "largest_F2": "N^2/mm^3",
    "largest_SWT": "MPa",
}
_NODES = {
    "contact": "its contact",
    "x": "arc length, mm",
    "slip_range": "mm",
    "work": "work of friction per cycle, N mm",
    "F1": "Ruiz's first parameter, N/mm",
    "F2": "Ruiz's second parameter, N^2/mm^3, stress of body 2",
    "SWT": "Smith-Watson-Topper parameter, MPa, stress of body 2",
}
_REGION = {
    "first": "load of amplitude a",
    "second": "load of amplitude b",
    "what": "vertex of the safe amplitudes, or largest amplitudes of the history",
    "a": "amplitude, MPa (push: N)",
    "b": "amplitude, MPa (push: N)",
}

JOINTS = Table("joint_report", "one joint", _REPORT, full=FULL, quick=QUICK, compute=report)
FRETTING = Table(
    "joint_fretting", "one node of one joint", _NODES, full=FULL, quick=QUICK, compute=fretting
)
REGION = Table(
    "joint_region",
    "one point in the plane of two amplitudes of one joint",
    _REGION,
    full=FULL,
    quick=QUICK,
    compute=regions,
)

STUDY = Study(
    "studies.joint",
    __doc__,
    "coarse meshes and short histories, in seconds",
    (JOINTS, FRETTING, REGION),
    _summary,
)
