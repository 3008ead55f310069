"""Frequency and damping of three joints against load and friction; a bolted joint on three meshes.

Run with `python -m studies damping [--quick]`. Damping is given with its range over residual slips.
The joints are plane: the paper's punch on a block that is stretched, the dovetail root of a blade
that sways, and a lap joint of two plates, pressed together on their overlap and pulled. Load
factors are relative to the shakedown limit, frequencies relative to the glued joint, as if the load
were the load of a mode. The range covers the steady states that a search finds; there may be
others.

The bolted joint is in space: two plates, clamped by one bolt, which are pulled to and fro and lift
off around it. Its load factors are relative to the load at which the plates slide off. Its
transients have two increments per segment.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from skfem import MeshQuad

import frictopt as fo

from .design import lap as bolted
from .progress import each
from .tables import Row, Study, Table, described, markdown

_BOLTED_FRICTION, _STEPS = 0.3, 2
# Length of each plate beyond the overlap, and thickness, relative to half the length of the
# overlap.
_ARM, _THICKNESS = 3.0, 0.5


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    punch_elements: int = 40
    # Number of elements on each flank.
    dovetail_elements: int = 12
    lap_elements: int = 32
    friction: float = 0.6
    # Load factors relative to the shakedown limit.
    ratios: tuple[float, ...] = tuple(
        round(float(ratio), 6) for ratio in np.geomspace(0.2, 2.5, 12)
    )
    frictions: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    friction_ratios: tuple[float, ...] = (0.8, 1.5)
    # Numbers of elements along the bolted joint.
    meshes: tuple[int, ...] = (18, 24, 30)
    # Load factors of the bolted joint, relative to the load at which its plates slide off.
    shares: tuple[float, ...] = (0.1, 0.2, 0.3, 0.5, 0.7, 0.9)


FULL = Parameters()
QUICK = Parameters(
    punch_elements=2,
    dovetail_elements=2,
    lap_elements=3,
    ratios=(0.3, 0.9, 1.5),
    frictions=(0.4, 0.7),
    friction_ratios=(1.5,),
    meshes=(6, 9),
    shares=(0.3, 0.9),
)


def lap(elements: int) -> fo.fem.ContactModel:
    """Two plates of one thickness that overlap in -1 <= x <= 1, under unit pressure there.

    The lower plate is clamped, and the upper plate is pulled by 1.
    """
    over = np.linspace(-1.0, 1.0, elements + 1)
    arm = np.linspace(1.0, 1.0 + _ARM, elements + 1)[1:]
    up = np.linspace(0.0, _THICKNESS, max(2, elements // 4) + 1)
    plates = {"upper": (np.r_[over, arm], up), "lower": (np.r_[-arm[::-1], over], -up[::-1])}
    sides = {
        "lap": lambda x: (x[1] == 0.0) & (np.abs(x[0]) < 1.0),
        "pressed": lambda x: (np.abs(x[1]) == _THICKNESS) & (np.abs(x[0]) < 1.0),
        "end": lambda x: np.abs(x[0]) == 1.0 + _ARM,
    }
    return fo.fem.ContactModel(
        bodies={
            name: fo.fem.Body(MeshQuad.init_tensor(*axes).with_boundaries(sides))
            for name, axes in plates.items()
        },
        contacts=[fo.fem.Contact("upper", "lower", "lap", "lap")],
        supports=[fo.fem.Support("lower", "end"), fo.fem.Support("upper", "end", "y")],
        loads={
            "press": [fo.fem.Pressure(name, "pressed", 1.0) for name in plates],
            "pull": [fo.fem.Traction("upper", "end", x=1.0)],
        },
    )


def joints(parameters: Parameters) -> dict[str, tuple[fo.ContactSystem, fo.LoadCycle]]:
    """The contact and load cycle of each joint, by name."""
    return {
        "punch": (
            fo.scenes.PunchOnHalfPlane(elements=parameters.punch_elements).condense(),
            _cycle("P", "sigma"),
        ),
        "dovetail": (
            fo.scenes.Dovetail(elements=parameters.dovetail_elements).condense(),
            _cycle("pull", "sway"),
        ),
        "lap joint": (lap(parameters.lap_elements).condense(), _cycle("press", "pull")),
    }


def _cycle(mean: str, case: str) -> fo.LoadCycle:
    return fo.LoadCycle({mean: 1.0}, [{case: 1.0}, {case: -1.0}])


def backbones(parameters: Parameters) -> pd.DataFrame:
    """One row for each joint and load factor."""
    asked = each(joints(parameters).items(), "backbones")
    return pd.concat(
        [_curve(name, joint, parameters.friction, parameters.ratios) for name, joint in asked],
        ignore_index=True,
    )


def by_friction(parameters: Parameters) -> pd.DataFrame:
    """One row for each friction and load factor of the dovetail and of the lap joint."""
    joint_of_name = joints(parameters)
    pairs = [(name, f) for name in ("dovetail", "lap joint") for f in parameters.frictions]
    curves = []
    for name, f in each(pairs, "frictions"):
        curves.append(_curve(name, joint_of_name[name], f, parameters.friction_ratios))
    return pd.concat(curves, ignore_index=True)


def _curve(
    name: str, joint: tuple[fo.ContactSystem, fo.LoadCycle], f: float, ratios: tuple[float, ...]
) -> pd.DataFrame:
    system, cycle = joint
    limit = fo.shakedown_limit(system, cycle, f).load_factor
    (case,) = cycle.corners[0]
    compliance = float(np.diag(np.asarray(system.compliance))[list(system.bonded).index(case)])
    # The modal mass is 1. Frequency ratios do not depend on it.
    glued = 1 / (2 * np.pi * np.sqrt(compliance))
    curve = fo.joints.backbone_curve(
        system, cycle, f, limit * np.array(ratios), natural_frequency=glued, with_range=True
    )
    rows = (
        curve.to_frame()
        .filter(described(_COLUMNS))
        .assign(joint=name, friction=f, load_ratio=ratios, residual=curve.residual)
    )
    rows["guaranteed_ratio"] = curve.guaranteed_limit / limit
    rows[_FREQUENCIES] /= curve.natural_frequency
    return rows


def meshes(parameters: Parameters) -> Iterator[Row]:
    """One row for each mesh of the bolted joint and load factor."""
    cycle = fo.LoadCycle({"bolt 1": 1.0}, [{"pull": 1.0}, {"pull": -1.0}])
    for elements in parameters.meshes:
        system = bolted(elements).condense()
        limit = fo.shakedown_limit(system, cycle, _BOLTED_FRICTION)
        slides = fo.gross_slip(system, cycle, _BOLTED_FRICTION).load_factor
        factors = slides * np.array(parameters.shares)
        curve = fo.joints.backbone_curve(system, cycle, _BOLTED_FRICTION, factors, steps=_STEPS)
        rows = (
            curve.to_frame()
            .filter(described(_MESHES))
            .assign(elements=elements, nodes=system.nodes, load_share=parameters.shares)
        )
        yield rows.assign(
            shakedown_share=limit.load_factor / slides,
            open=int(limit.open.sum()),
            residual=max(limit.residual, curve.residual),
        )


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
BACKBONE = Table(
    "damping_backbone",
    "one joint at one load factor",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=backbones,
)
_MESHES = {
    "elements": "number of elements along the joint",
    "load_share": "load factor over that at which the plates slide off",
    "shakedown_share": "shakedown limit over the same",
    "open": "number of nodes that stay open at the limit",
    "outcome": "what happens after many cycles",
    "work": "work of friction per cycle",
    "slipping": "share of the area of the contact that slips in the steady cycle",
    "slip_range": "largest distance of two slips of a node",
}
FRICTION = Table(
    "damping_friction",
    "one joint at one friction and load factor",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=by_friction,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The limits of each joint, and the scatter of its damping."""
    rows = []
    for name, table in tables[BACKBONE.name].groupby("joint", sort=False):
        worst = table.loc[(table["most_damping"] - table["least_damping"]).idxmax()]
        band = f"{100 * worst['least_damping']:.2g} to {100 * worst['most_damping']:.2g} % at {worst['load_ratio']:.2f}"
        rows.append(
            [
                str(name),
                f"{table['guaranteed_ratio'].iloc[0]:.3f}",
                f"{100 * table['damping'].max():.2g} %",
                band,
            ]
        )
    said = markdown(
        [
            "joint",
            "guaranteed over shakedown limit",
            "largest damping from a start without slip",
            "widest range, and where",
        ],
        rows,
    )
    return f"{said}\n\n{_on_meshes(tables[MESHES.name])}"


def _on_meshes(table: pd.DataFrame) -> str:
    """Limit, work and slipping share of the bolted joint on each mesh."""
    rows, meshes = [], table.groupby("elements")
    for share, of_load in table.groupby("load_share"):
        rows.append(
            [
                f"{share:g}",
                *(
                    ", ".join(f"{value:.3g}" for value in of_load[name])
                    for name in ("work", "slipping")
                ),
            ]
        )
    limits = ", ".join(f"{value:.2g}" for value in meshes["shakedown_share"].first())
    said = f"The bolted joint with {', '.join(map(str, meshes.groups))} elements: shakedown limit {limits} of the load at which the plates slide off."
    return f"{said}\n\n{markdown(['load over that', 'work per cycle', 'share that slips'], rows)}"


MESHES = Table(
    "backbone_meshes",
    "the bolted joint on one mesh at one load factor",
    _MESHES,
    full=FULL,
    quick=QUICK,
    compute=meshes,
)
STUDY = Study(
    __name__,
    __doc__,
    "coarse meshes and few amplitudes, in seconds",
    (BACKBONE, FRICTION, MESHES),
    summary,
)
