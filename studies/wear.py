"""Wear of a cylinder, a rounded punch and a lap joint over the cycles.

Run with `python -m studies wear [--quick]`. Profiles, work of friction, damping, frequency and
limits are computed. The cylinder (Hertz, half-width of the contact 1) is sheared by shares of the
gross-slip load. The rounded punch wears while its block is stretched above the shakedown limit, and
the lap joint while it is pulled by 1.6 times its limit. The coefficient of wear is 1e-3 in the
units of each contact.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
import pandas as pd

import frictopt as fo

from .damping import lap
from .paper import LOADS
from .tables import Row, Study, Table, described, markdown, two_digits

_FRICTION, _COEFFICIENT = 0.5, 1e-3
# Load of the lap joint, relative to its shakedown limit before wear.
_ABOVE = 1.6
_CYLINDER = fo.reference.LineContact(P=1.0, R=1.0, E_star=4 / pi, f=_FRICTION)


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    nodes: int = 128
    # Shear relative to gross slip.
    shares: tuple[float, ...] = (0.3, 0.5, 0.7)
    # Number of elements of the rounded punch.
    elements: int = 48
    # Numbers of nodes of the cylinder whose limit is computed.
    meshes: tuple[int, ...] = (16, 32, 64, 128, 256)
    profiles: int = 6
    lap_elements: int = 32
    # Numbers of load cycles of the lap joint.
    lives: tuple[float, ...] = tuple(
        round(float(cycles)) for cycles in np.geomspace(30, 100_000, 15)
    )


FULL = Parameters()
QUICK = Parameters(
    lap_elements=8,
    lives=(100, 1000, 10_000),
    nodes=32,
    shares=(0.5, 0.7),
    elements=24,
    meshes=(16, 32, 64),
    profiles=4,
)


def _cylinder(nodes: int) -> fo.ContactSystem:
    arrays = fo.reference.half_plane_contact(nodes, 1.4, _CYLINDER.E_star, R=1.0)
    return fo.ContactSystem.from_blocks(**arrays, width=np.full(nodes, 2.8 / nodes))


def _cycle(share: float) -> fo.LoadCycle:
    return fo.LoadCycle({"P": 1.0}, [{"Q": share * _FRICTION}, {"Q": -share * _FRICTION}])


def profiles(parameters: Parameters) -> pd.DataFrame:
    """One row for each node and number of cycles, at half of gross slip."""
    history = fo.joints.wear(
        _cylinder(parameters.nodes), _cycle(0.5), _FRICTION, 1.0, coefficient=_COEFFICIENT
    )
    largest, x = history.depth.max(axis=1), history.system.x
    chosen = np.unique(
        [
            np.abs(largest - part).argmin()
            for part in np.linspace(0.0, largest[-1], parameters.profiles)
        ]
    )
    form = _CYLINDER.worn_depth(x, 0.5 * _FRICTION)
    parts = [
        pd.DataFrame(
            {"x": x, "depth": history.depth[row], "pressure": history.pressure[row]}
        ).assign(cycles=history.cycles[row])
        for row in chosen
    ]
    return pd.concat(parts, ignore_index=True).assign(
        end=np.tile(form, len(chosen)), residual=history.residual
    )


def histories(parameters: Parameters) -> Iterator[Row]:
    """One row for each jump of each contact."""
    punch = fo.scenes.RoundedPunch(
        punch=fo.scenes.PunchOnHalfPlane(elements=parameters.elements)
    ).condense()
    above = 1.2 * fo.shakedown_limit(punch, LOADS, _FRICTION).load_factor
    asked = [
        (f"cylinder, {share:g} of gross slip", _cylinder(parameters.nodes), _cycle(share), 1.0)
        for share in parameters.shares
    ]
    for name, contact, cycle, load_factor in [*asked, ("rounded punch", punch, LOADS, above)]:
        history = fo.joints.wear(contact, cycle, _FRICTION, load_factor, coefficient=_COEFFICIENT)
        table = history.to_frame()
        shares = table["work"] / table["work"][0]
        yield table.filter(described(_HISTORY_COLUMNS)).assign(
            contact=name, work_share=shares, residual=history.residual
        )


def limits(parameters: Parameters) -> Iterator[Row]:
    """One row for each mesh of the cylinder, worn in under half of gross slip."""
    for nodes in parameters.meshes:
        contact = _cylinder(nodes)
        end = fo.joints.worn_in(contact, _cycle(0.5), _FRICTION, 1.0)
        before = fo.shakedown_limit(contact, _cycle(0.5), _FRICTION).load_factor
        after = fo.shakedown_limit(end.system, _cycle(0.5), _FRICTION).load_factor
        yield {"nodes": nodes, "before": before, "after": after, "residual": end.residual}


def life(parameters: Parameters) -> Iterator[Row]:
    """One row for each number of cycles of the lap joint.

    Each row continues from the state of the row before.
    """
    system = lap(parameters.lap_elements).condense()
    cycle = fo.LoadCycle({"press": 1.0}, [{"pull": 1.0}, {"pull": -1.0}])
    load = _ABOVE * fo.shakedown_limit(system, cycle, _FRICTION).load_factor
    steady = fo.steady_state(system, cycle, _FRICTION, load)
    done = 0.0
    assert system.compliance is not None
    glued = system.compliance[-1, -1]
    for cycles in (0.0, *parameters.lives):
        if cycles:
            history = fo.joints.wear(
                steady.system,
                cycle,
                _FRICTION,
                load,
                coefficient=_COEFFICIENT,
                cycles=cycles - done,
                initial_state=steady.state,
                progress=False,
            )
            steady, done = history.steady, cycles
        swing = float(np.ptp(steady.displacement("pull"))) / 2
        damping = steady.dissipation / (2 * pi * load * swing)
        frequency = np.sqrt(load * glued / swing)
        limit = fo.shakedown_limit(steady.system, cycle, _FRICTION)
        guaranteed = fo.guaranteed_limit(steady.system, cycle, _FRICTION)
        found = {
            "cycles": cycles,
            "damping": damping,
            "frequency": frequency,
            "limit": limit.load_factor / load,
        }
        residual = max(steady.residual, limit.residual, guaranteed.residual)
        yield {**found, "guaranteed": guaranteed.load_factor / load, "residual": residual}


_PROFILES_COLUMNS = {
    "cycles": "load cycles",
    "depth": "depth worn off",
    "pressure": "pressure at the last corner",
    "end": "depth in the end, in closed form",
}
PROFILES = Table(
    "wear_profiles",
    "profiles of a cylinder at half of gross slip while it wears",
    _PROFILES_COLUMNS,
    FULL,
    QUICK,
    profiles,
)
_HISTORY_COLUMNS = {
    "contact": "which",
    "cycles": "load cycles",
    "work_share": "work of friction per cycle, over that of the unworn contact",
    "largest_depth": "largest depth worn off",
}
HISTORY = Table(
    "wear_history", "work of friction while contacts wear", _HISTORY_COLUMNS, FULL, QUICK, histories
)
_LIMITS_COLUMNS = {
    "before": "limit with open nodes of the unworn contact",
    "after": "the same of the contact worn in",
}
LIMITS = Table(
    "wear_limits",
    "limits of a cylinder before and after wear, over the load that wears it",
    _LIMITS_COLUMNS,
    FULL,
    QUICK,
    limits,
)
_LIFE_COLUMNS = {
    "cycles": "load cycles",
    "damping": "damping ratio of the steady cycle",
    "frequency": "its frequency, over that of the joint that is glued",
    "limit": "shakedown limit of the worn joint, over the load that wears it",
    "guaranteed": "guaranteed limit of the worn joint, over that load",
}
LIFE = Table(
    "wear_life",
    "damping, frequency and limits of a lap joint while it wears",
    _LIFE_COLUMNS,
    FULL,
    QUICK,
    life,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """The time and the depth of wear of each contact."""
    rows = []
    for name, table in tables[HISTORY.name].groupby("contact", sort=False):
        rows.append(
            [
                str(name),
                f"{table['cycles'].iloc[-1]:.3g}",
                two_digits(table["work_share"].max()),
                f"{table['largest_depth'].iloc[-1]:.3g}",
            ]
        )
    joint = tables[LIFE.name]
    first, last = (
        ", ".join(f"{name} {row[name]:.3g}" for name in ("damping", "frequency", "limit"))
        for row in (joint.iloc[0], joint.iloc[-1])
    )
    contacts = markdown(["contact", "cycles", "largest work over the first", "largest depth"], rows)
    return f"{contacts}\n\nlap joint: {first}; after {joint['cycles'].iloc[-1]:,.0f} cycles {last}"


STUDY = Study(
    __name__, __doc__, "coarse meshes, in half a minute", (PROFILES, HISTORY, LIMITS, LIFE), summary
)
