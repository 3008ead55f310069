"""Best designs: profiles of a punch, relief of a dovetail's flanks, and the bolts of a lap joint.

Run with `python -m studies design [--quick]`. Material is removed from the face of the paper's
punch up to a depth. The unit of the depth is the half-width of the punch times its mean pressure
over the modulus E. The best profiles are compared with the profile that wear makes. The
face "three shapes" is a constant plus multiples of x^2, x^4 and x^6. The lap joint is in space: three bolts in a row, a
small pressure, and a pull and a side load to and fro.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from skfem import MeshHex

import frictopt as fo

from .paper import LOADS
from .progress import each
from .tables import Row, Study, Table, markdown

_FRICTION, _ABOVE, _BOLTS, _WASHER = 0.5, 1.3, (-1.0, 0.0, 1.0), 0.35
_SHEARED = fo.LoadCycle(
    {"press": 0.3}, [{"pull": 1.0, "side": 0.1}, {"pull": -1.0, "side": 0.1}, {"side": -0.1}]
)


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    elements: int = 64
    frictions: tuple[float, ...] = (0.3, 0.5, 0.7)
    depths: tuple[float, ...] = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
    worn_elements: int = 40
    flank_elements: int = 20
    relief: tuple[float, ...] = (0.0, 0.01, 0.03, 0.1, 0.3)
    # Number of elements along the lap.
    lap_elements: int = 12
    load_factors: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4)


FULL = Parameters()
QUICK = Parameters(
    elements=16,
    frictions=(0.5,),
    depths=(0.0, 0.1, 0.5),
    worn_elements=12,
    flank_elements=4,
    relief=(0.0, 0.1),
    lap_elements=6,
    load_factors=(0.1, 0.2),
)


def lap(elements: int) -> fo.fem.ContactModel:
    """Two thick plates that overlap in -1.5 <= x <= 1.5, with three bolts.

    Each bolt presses both faces around its place by a total force of 1.
    """
    over = np.linspace(-1.5, 1.5, elements + 1)
    arm = np.linspace(1.5, 3.0, 1 + elements // 3)[1:]
    across = np.linspace(-0.5, 0.5, 1 + max(2, elements // 3))
    up = np.linspace(0.0, 1.0, 1 + max(2, elements // 4))
    sides = {
        "lap": lambda x: (x[2] == 0.0) & (np.abs(x[0]) < 1.5),
        "outer": lambda x: (np.abs(x[2]) == 1.0) & (np.abs(x[0]) < 1.5),
        "end": lambda x: np.abs(x[0]) == 3.0,
    }
    plates = {
        "upper": (np.r_[over, arm], across, up),
        "lower": (np.r_[-arm[::-1], over], across, -up[::-1]),
    }
    bodies = {
        name: fo.fem.Body(MeshHex.init_tensor(*axes).with_boundaries(sides))
        for name, axes in plates.items()
    }
    loads: dict[str, list[fo.fem.Pressure | fo.fem.Traction]] = {
        f"bolt {k}": [fo.fem.Pressure(name, "outer", _washer(place)) for name in bodies]
        for k, place in enumerate(_BOLTS)
    }
    loads |= {"press": [fo.fem.Pressure(name, "outer") for name in bodies]}
    loads |= {
        "pull": [fo.fem.Traction("upper", "end", x=1.0)],
        "side": [fo.fem.Traction("upper", "end", y=1.0)],
    }
    return fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("lower", "end")],
        loads,
        contacts=[fo.fem.Contact("upper", "lower", "lap", "lap")],
    )


def _washer(place: float) -> Callable[..., NDArray[np.float64]]:
    return lambda x, y, z: (
        np.exp(-((x - place) ** 2 + y**2) / (2 * _WASHER**2)) / (2 * np.pi * _WASHER**2)
    )


def _designs(
    system: fo.ContactSystem, friction: float, depths: Sequence[float]
) -> Iterator[tuple[float, str, fo.results.Design]]:
    """The best free profile and the best of three shapes for each depth."""
    model = fo.DesignModel(system, LOADS, profile=True)
    deepest = cp.Parameter(nonneg=True)
    factors = cp.Variable(4)
    bounds = [model.profile >= 0, model.profile <= deepest]
    faces = {
        "free": bounds,
        "three shapes": [*bounds, model.profile == system.x[:, None] ** [0, 2, 4, 6] @ factors],
    }
    for depth in depths:
        for face, constraints in faces.items():
            deepest.value = depth
            yield depth, face, model.solve(friction, constraints)


def limits(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction, depth and kind of face."""
    system = fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense()
    for friction in each(parameters.frictions, "frictions"):
        for depth, face, design in _designs(system, friction, parameters.depths):
            yield {"depth": depth, "face": face, **_limits(design, friction)}


def _limits(design: fo.results.Design, friction: float) -> dict[str, float]:
    lower = fo.guaranteed_limit(design.system, design.cycle, friction).load_factor
    return {
        "friction": friction,
        "load_factor": design.load_factor,
        "guaranteed": lower,
        "residual": design.residual,
    }


def profiles(parameters: Parameters) -> Iterator[Row]:
    """One row for each node and profile: the flat punch, the worn punch, and the best profiles.

    The worn punch and the best profiles have the same depth.
    """
    system = fo.scenes.PunchOnHalfPlane(elements=parameters.worn_elements).condense()
    flat = fo.shakedown_limit(system, LOADS, _FRICTION)
    worn = fo.joints.wear(system, LOADS, _FRICTION, _ABOVE * flat.load_factor, coefficient=1e-3)
    rest = fo.shakedown_limit(worn.system, LOADS, _FRICTION)
    faces: dict[str, tuple[NDArray[np.float64], fo.results.ShakedownLimit | fo.results.Design]] = {
        "flat": (np.zeros(system.nodes), flat),
        "worn": (worn.depth[-1], rest),
    }
    for _, face, design in _designs(system, _FRICTION, [float(worn.depth[-1].max())]):
        faces[face] = design.system.gap, design
    for face, (profile, found) in faces.items():
        columns = {
            "x": system.x,
            "profile": profile,
            "pressure": found.reactions[1].mean(axis=0) / system.width,
        }
        yield pd.DataFrame(
            {"face": face, **columns, "load_factor": found.load_factor, "residual": found.residual}
        )


def relief(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction and depth of the relief."""
    system = fo.scenes.Dovetail(elements=parameters.flank_elements).condense()
    model = fo.DesignModel(
        system, fo.LoadCycle({"pull": 1.0}, [{"sway": 1.0}, {"sway": -1.0}]), profile=True
    )
    deepest = cp.Parameter(nonneg=True)
    for friction in parameters.frictions:
        for depth in parameters.relief:
            deepest.value = depth
            yield {
                "depth": depth,
                **_limits(
                    model.solve(friction, [model.profile >= 0, model.profile <= deepest]), friction
                ),
            }


def bolts(parameters: Parameters) -> Iterator[Row]:
    """One row for each load factor: the least bolt forces that carry it."""
    system = lap(parameters.lap_elements).condense()
    names = [f"bolt {k}" for k in range(len(_BOLTS))]
    model = fo.DesignModel(system, _SHEARED, preloads=names)
    carried = cp.Parameter(nonneg=True)
    constraints = [(model.load_factor >= carried).set_label("load"), model.preload >= 0]
    for carried.value in parameters.load_factors:
        design = model.solve(_FRICTION, constraints, objective=-cp.sum(model.preload))
        total = float(design.preload.sum())
        equal = fo.LoadCycle({**_SHEARED.mean, **dict.fromkeys(names, total / 3)}, _SHEARED.corners)
        even = fo.shakedown_limit(system, equal, _FRICTION)
        found = {
            "total": total,
            "price": float(design.prices["load"]),
            "even": even.load_factor,
            "residual": design.residual,
        }
        yield {"load_factor": carried.value, **design.preload, **found}


_LIMITS_COLUMNS = {
    "depth": "largest depth taken off",
    "face": "free, or three shapes",
    "load_factor": "shakedown limit",
}
LIMITS = Table(
    "design_limits", "limits of a punch with the best profile", _LIMITS_COLUMNS, FULL, QUICK, limits
)
_PROFILES_COLUMNS = {
    "face": "which",
    "profile": "material taken off",
    "pressure": "mean pressure over the corners at the limit, per length",
    "load_factor": "shakedown limit; of the worn face the limit with open nodes",
}
PROFILES = Table(
    "design_profiles",
    "profiles of a punch: flat, worn in above its limit, and the best ones as deep",
    _PROFILES_COLUMNS,
    FULL,
    QUICK,
    profiles,
)
_RELIEF_COLUMNS = {name: meaning for name, meaning in _LIMITS_COLUMNS.items() if name != "face"}
RELIEF = Table(
    "design_relief",
    "limits of a dovetail with the best relief of its flanks",
    _RELIEF_COLUMNS,
    FULL,
    QUICK,
    relief,
)
_BOLTS_COLUMNS = {
    "load_factor": "load that is carried",
    **{
        f"bolt {k}": f"force of bolt {k}; the upper plate is pulled at the side of the last one"
        for k in range(3)
    },
    "total": "sum of the forces",
    "price": "rate of the sum with the load: what one more load factor costs",
    "even": "load factor that the same sum carries in three equal bolts",
}
BOLTS = Table(
    "design_bolts", "least bolt forces of a lap joint in space", _BOLTS_COLUMNS, FULL, QUICK, bolts
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The gain of the deepest profiles, and the saving of bolt forces."""
    rows = []
    for (friction, face), table in tables[LIMITS.name].groupby(["friction", "face"]):
        flat, deepest = table.iloc[0], table.iloc[-1]
        gains = [f"{deepest[name] / flat[name]:.2f}" for name in ("load_factor", "guaranteed")]
        rows.append([f"punch, {face}, depth {deepest['depth']:g}", f"{friction:g}", *gains])
    for friction, table in tables[RELIEF.name].groupby("friction"):
        least, deepest = table.iloc[0], table.iloc[-1]
        rows.append(
            [
                f"dovetail, depth {deepest['depth']:g}",
                f"{friction:g}",
                f"{deepest['load_factor'] / least['load_factor']:.2f}",
                "-",
            ]
        )
    last = tables[BOLTS.name].iloc[-1]
    rows.append(
        [
            "lap joint, best bolts over equal ones",
            f"{_FRICTION:g}",
            f"{last['load_factor'] / last['even']:.2f}",
            "-",
        ]
    )
    return markdown(
        [
            "design",
            "friction",
            "shakedown limit over that before",
            "guaranteed limit over that before",
        ],
        rows,
    )


STUDY = Study(
    __name__, __doc__, "coarse meshes, in a few seconds", (LIMITS, PROFILES, RELIEF, BOLTS), summary
)
