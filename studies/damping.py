"""Frequency and damping of three joints against the amplitude of their load and against friction, and their range over residual slips.

Run with `python -m studies damping [--quick]`. The joints are plane: the paper's punch on a block that is stretched, the dovetail root of a blade
that sways, and a lap joint of two plates, pressed together where they overlap and pulled. Load factors are over the shakedown limit, frequencies over
that of the glued joint, as if the load were that of a mode. The range is that of the steady states that a search finds; others may lie outside.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from skfem import MeshQuad

import frictopt as fo

from .progress import each
from .tables import Study, Table, described, markdown

_ARM, _THICKNESS = 3.0, 0.5  # of each plate beyond the overlap, over half its length


@dataclass(frozen=True)
class Parameters:
    """What the study varies."""

    punch_elements: int = 40
    dovetail_elements: int = 12  # on each flank
    lap_elements: int = 32
    friction: float = 0.6
    ratios: tuple[float, ...] = tuple(round(float(ratio), 6) for ratio in np.geomspace(0.2, 2.5, 12))  # over the shakedown limit
    frictions: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    friction_ratios: tuple[float, ...] = (0.8, 1.5)


FULL = Parameters()
QUICK = Parameters(punch_elements=2, dovetail_elements=2, lap_elements=3, ratios=(0.3, 0.9, 1.5), frictions=(0.4, 0.7), friction_ratios=(1.5,))


def lap(elements: int) -> fo.ContactModel:
    """Two plates of one thickness that overlap in -1 <= x <= 1, under unit pressure there; the lower one is clamped, the upper one pulled by 1."""
    over, arm = np.linspace(-1.0, 1.0, elements + 1), np.linspace(1.0, 1.0 + _ARM, elements + 1)[1:]
    up = np.linspace(0.0, _THICKNESS, max(2, elements // 4) + 1)
    plates = {"upper": (np.r_[over, arm], up), "lower": (np.r_[-arm[::-1], over], -up[::-1])}
    sides = {
        "lap": lambda x: (x[1] == 0.0) & (np.abs(x[0]) < 1.0),
        "pressed": lambda x: (np.abs(x[1]) == _THICKNESS) & (np.abs(x[0]) < 1.0),
        "end": lambda x: np.abs(x[0]) == 1.0 + _ARM,
    }
    return fo.ContactModel(
        bodies={name: fo.Body(MeshQuad.init_tensor(*axes).with_boundaries(sides)) for name, axes in plates.items()},
        contacts=[fo.Contact("upper", "lower", "lap", "lap")],
        supports=[fo.Support("lower", "end"), fo.Support("upper", "end", "y")],
        loads={"press": [fo.Pressure(name, "pressed", 1.0) for name in plates], "pull": [fo.Traction("upper", "end", x=1.0)]},
    )


def joints(parameters: Parameters) -> dict[str, tuple[fo.ContactSystem, fo.LoadCycle]]:
    """The joints, name -> contact and load cycle."""
    return {
        "punch": (fo.scenes.PunchOnHalfPlane(elements=parameters.punch_elements).condense(), _cycle("P", "sigma")),
        "dovetail": (fo.scenes.Dovetail(elements=parameters.dovetail_elements).condense(), _cycle("pull", "sway")),
        "lap joint": (lap(parameters.lap_elements).condense(), _cycle("press", "pull")),
    }


def _cycle(mean: str, case: str) -> fo.LoadCycle:
    return fo.LoadCycle({mean: 1.0}, [{case: 1.0}, {case: -1.0}])


def backbones(parameters: Parameters) -> pd.DataFrame:
    """One row for each joint and load factor."""
    asked = each(joints(parameters).items(), "backbones")
    return pd.concat([_curve(name, joint, parameters.friction, parameters.ratios) for name, joint in asked], ignore_index=True)


def by_friction(parameters: Parameters) -> pd.DataFrame:
    """One row for each friction and load factor of the dovetail and of the lap joint."""
    made = joints(parameters)
    asked = each([(name, f) for name in ("dovetail", "lap joint") for f in parameters.frictions], "frictions")
    return pd.concat([_curve(name, made[name], f, parameters.friction_ratios) for name, f in asked], ignore_index=True)


def _curve(name: str, joint: tuple[fo.ContactSystem, fo.LoadCycle], f: float, ratios: tuple[float, ...]) -> pd.DataFrame:
    system, cycle = joint
    limit = fo.shakedown_limit(system, cycle, f).load_factor
    (case,) = cycle.corners[0]
    compliance = float(np.diag(np.asarray(system.compliance))[list(system.bonded).index(case)])
    glued = 1 / (2 * np.pi * np.sqrt(compliance))  # with a modal mass of 1, which the frequencies over it do not depend on
    curve = fo.backbone_curve(system, cycle, f, limit * np.array(ratios), natural_frequency=glued, range=True)
    rows = curve.to_frame().filter(described(_COLUMNS)).assign(joint=name, friction=f, load_ratio=ratios, residual=curve.residual)
    rows["guaranteed_ratio"] = curve.guaranteed_limit / limit
    rows[_FREQUENCIES] /= curve.natural_frequency
    return rows


_FREQUENCIES = ["frequency", "least_frequency", "most_frequency"]
_COLUMNS = {
    "guaranteed_ratio": "guaranteed limit over the shakedown limit",
    "frequency": "frequency from a start without residual slip, over that of the glued joint",
    "least_frequency": "least of those found over the residual slips",
    "most_frequency": "largest of those found",
    "damping": "damping ratio from a start without residual slip",
    "least_damping": "least of those found over the residual slips",
    "most_damping": "largest of those found",
    "exponent": "d ln work / d ln load factor, without residual slip",
}
BACKBONE = Table("damping_backbone", "one joint at one load factor", _COLUMNS, full=FULL, quick=QUICK, compute=backbones)
FRICTION = Table("damping_friction", "one joint at one friction and load factor", _COLUMNS, full=FULL, quick=QUICK, compute=by_friction)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """How far apart the limits of each joint are, and how much its damping scatters."""
    rows = []
    for name, table in tables[BACKBONE.name].groupby("joint", sort=False):
        worst = table.loc[(table["most_damping"] - table["least_damping"]).idxmax()]
        band = f"{100 * worst['least_damping']:.2g} to {100 * worst['most_damping']:.2g} % at {worst['load_ratio']:.2f}"
        rows.append([str(name), f"{table['guaranteed_ratio'].iloc[0]:.3f}", f"{100 * table['damping'].max():.2g} %", band])
    return markdown(["joint", "guaranteed over shakedown limit", "largest damping without residual slip", "widest range, and where"], rows)


STUDY = Study(__name__, __doc__, "coarse meshes and few amplitudes, in seconds", (BACKBONE, FRICTION), summary)
