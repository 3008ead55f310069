"""Contacts that lift off: limits of a pin, a fir tree and a flange, and uncoupled contacts.

Run with `python -m studies lift_off [--quick]`. The pin is `PinInPlate`, pushed to and fro. The fir
tree is the mesh of the tutorial; it spins, and a body force of 0.01 N/mm^3 pushes the blade to and
fro. The flange is half a pipe joint with four bolts of 25 kN each, pulled to and fro by 1 kN along
one diameter. The uncoupled contacts test the theorem: random contacts of one to four nodes with
gaps, B = 0, and cyclic loads that lift nodes off.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from skfem import MeshHex

import frictopt as fo

from .progress import each
from .tables import Row, Study, Table, markdown

_FIR = Path(__file__).parents[1] / "docs" / "tutorial" / "blade.msh"
_TO_AND_FRO = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}])
# Force of a bolt in N, pull in N, radius of a washer in mm.
_BOLT, _PULL, _WASHER = 25e3, 1e3, 8.0
# Load factor of the transient that first settles the contact under the mean load.
_LITTLE = 1e-3


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Numbers of elements and frictions.
    pins: tuple[tuple[int, float], ...] = (
        (8, 0.8),
        (16, 0.5),
        (16, 1.0),
        (32, 0.9),
    )
    fir_frictions: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    # Numbers of elements around half the pipe, and frictions.
    flanges: tuple[tuple[int, float], ...] = (
        (12, 0.15),
        (12, 0.2),
        (12, 0.3),
        (18, 0.15),
    )
    # Number of uncoupled contacts, with seeds from 0 on.
    contacts: int = 200
    starts: int = 5
    # Number of cycles whose energy is followed.
    cycles: int = 6
    # Relative distance of the transients from a limit, below and above it.
    apart: float = 0.02


FULL = Parameters()
QUICK = Parameters(((8, 0.8),), (0.3,), ((6, 0.15),), contacts=6, starts=2)


def fir_tree() -> fo.ContactSystem:
    """A blade in its disc with four flanks."""
    titanium, density = fo.fem.Material(E=115e3, nu=0.33), 4.4e-9
    bodies = fo.fem.split_bodies(
        fo.readers.read_mesh(_FIR), {"blade": titanium, "disc": titanium}, element="quadratic"
    )
    spin = [
        fo.fem.Centrifugal(name, density, speed=1200.0, centre=(0.0, -300.0)) for name in bodies
    ]
    contacts = [
        fo.fem.Contact("blade", "disc", flank, flank, name=flank)
        for flank in ("R1", "L1", "R2", "L2")
    ]
    supports = [
        fo.fem.Support("disc", "bottom"),
        *(fo.fem.Support("disc", side, "y") for side in ("left", "right")),
    ]
    loads: dict[str, list[fo.fem.Centrifugal | fo.fem.BodyForce]] = {
        "mean": [*spin],
        "cyclic": [fo.fem.BodyForce("blade", x=1e-2)],
    }
    return fo.fem.ContactModel(bodies, supports, loads, contacts=contacts, units="N, mm").condense()


def flange(elements: int) -> fo.ContactSystem:
    """Half a pipe joint beside its plane of symmetry.

    Bolts press on washers with a constant force.
    """
    radii = np.linspace(30.0, 60.0, 6)
    angles = np.linspace(0.0, np.pi, elements + 1)
    heights = np.array([0.0, 6.0, 12.0, 26.0, 40.0])
    bolts = 48.0 * np.array(
        [[np.cos(angle), np.sin(angle)] for angle in (np.pi / 4, 3 * np.pi / 4)]
    )
    sides = {
        "face": lambda x: x[2] == 0,
        "end": lambda x: np.abs(x[2]) == 40,
        "cut": lambda x: np.abs(x[1]) < 1e-9,
        "washers": lambda x: (
            (np.abs(x[2]) == 12)
            & (np.min([np.hypot(*(x[:2].T - bolt).T) for bolt in bolts], axis=0) < _WASHER)
        ),
    }
    bodies = {}
    for name, up in (("upper", heights), ("lower", -heights[::-1])):
        box = MeshHex.init_tensor(radii, angles, up)
        r, _, z = box.p[:, box.t].mean(axis=1)
        pipe = box.remove_elements(np.flatnonzero((r > 36) & (np.abs(z) > 12)))
        r, angle, z = pipe.p
        bodies[name] = fo.fem.Body(
            MeshHex(np.array([r * np.cos(angle), r * np.sin(angle), z]), pipe.t).with_boundaries(
                sides
            ),
            fo.fem.Material(E=210e3),
        )
    pressed, pulled = (_area(bodies["upper"], side) for side in ("washers", "end"))
    loads: dict[str, list[fo.fem.Pressure | fo.fem.Traction]] = {
        "mean": [fo.fem.Pressure(name, "washers", 2 * _BOLT / pressed) for name in bodies]
    }
    loads["cyclic"] = [fo.fem.Traction("upper", "end", x=_PULL / 2 / pulled)]
    supports = [
        fo.fem.Support("lower", "end"),
        fo.fem.Support("lower", "cut", "y"),
        fo.fem.Support("upper", "cut", "y"),
    ]
    return fo.fem.ContactModel(
        bodies,
        supports,
        loads,
        contacts=[fo.fem.Contact("upper", "lower", "face", "face")],
        units="N, mm",
    ).condense()


def _area(body: fo.fem.Body, side: str) -> float:
    a, b, c, d = np.moveaxis(body.mesh.p[:, body.mesh.facets[:, body.mesh.boundaries[side]]], 1, 0)
    return float(np.linalg.norm(np.cross((c - a).T, (d - b).T), axis=1).sum()) / 2


def joints(parameters: Parameters) -> Iterator[Row]:
    """One row for each joint and friction coefficient."""
    pin = fo.LoadCycle({"fit": 1.0}, [{"Fx": -1.0}, {"Fx": 1.0}])
    for elements, friction in each(parameters.pins, "pin"):
        yield {"joint": "pin"} | _limits(
            fo.scenes.PinInPlate(elements=elements).condense(),
            pin,
            friction,
            parameters.apart,
            events=True,
        )
    fir = fir_tree()
    for friction in each(parameters.fir_frictions, "fir tree"):
        yield {"joint": "fir tree"} | _limits(
            fir, _TO_AND_FRO, friction, parameters.apart, events=False
        )
    for elements, friction in each(parameters.flanges, "flange"):
        yield {"joint": "flange"} | _limits(
            flange(elements), _TO_AND_FRO, friction, parameters.apart, events=False
        )


def _limits(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float, apart: float, events: bool
) -> dict[str, Any]:
    """Limits with all nodes closed, with the nodes that the settled mean load opens, and by search.

    Transients start from the state of the limit, just below and just above the limit.
    """
    steps = None if system.slip_shape == (system.nodes,) else 4
    path = fo.march(system, cycle, friction, _LITTLE, cycles=1, steps=steps)
    settled = path.gap[path.time == 0][-1] > 0
    closed = fo.shakedown_limit(system, cycle, friction, open_nodes=np.zeros_like(settled))
    with_settled = fo.shakedown_limit(system, cycle, friction, open_nodes=settled)
    limit = fo.shakedown_limit(system, cycle, friction, events=events)
    ends = [
        fo.steady_state(
            system,
            cycle,
            friction,
            factor * limit.load_factor,
            initial_state=limit.state,
            steps=steps,
        ).outcome.name
        for factor in (1 - apart, 1 + apart)
    ]
    return {
        "nodes": system.nodes,
        "friction": friction,
        "all_closed": closed.load_factor,
        "settled": with_settled.load_factor,
        "shakedown": limit.load_factor,
        "open": int(limit.open.sum()),
        "opening": limit.events["node"].nunique(),
        "sliding": limit.bound_for_all,
        "below": ends[0],
        "above": ends[1],
        "residual": limit.residual,
    }


def uncoupled_contact(seed: int) -> tuple[fo.ContactSystem, float]:
    """A random contact with B = 0, and its friction.

    Some nodes have gaps, and the mean load pulls some nodes.
    """
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, 5))
    A, C = (G @ G.T / nodes + 0.5 * np.eye(nodes) for G in rng.normal(size=(2, nodes, nodes)))
    pressed = rng.uniform(0.5, 1.5, nodes)
    is_pulled = rng.random(nodes) < 0.3
    pressed = pressed - np.where(is_pulled, rng.uniform(0.5, 2.0, nodes), 0.0)
    loads = {
        "mean": (0.1 * rng.normal(size=nodes), pressed),
        "cyclic": (rng.normal(size=nodes), rng.normal(size=nodes)),
    }
    gap = np.where(rng.random(nodes) < 0.3, 0.3 * rng.random(nodes), 0.0)
    none = np.zeros((nodes, nodes))
    system = fo.ContactSystem.from_blocks(A, none, C, np.arange(nodes), loads, gap)
    return system, float(rng.uniform(0.2, 1.0))


def uncoupled(parameters: Parameters) -> Iterator[Row]:
    """One row for each contact with a finite limit."""
    for seed in each(range(parameters.contacts), "uncoupled contacts"):
        system, friction = uncoupled_contact(seed)
        limit = fo.shakedown_limit(system, _TO_AND_FRO, friction, events=True)
        if limit.kind is not fo.LimitKind.FINITE or limit.load_factor <= limit.least:
            continue
        starts = 2 * np.random.default_rng(seed).normal(size=(parameters.starts, system.nodes))
        factors = limit.least + np.array([1 - parameters.apart, 1 + parameters.apart]) * (
            limit.load_factor - limit.least
        )
        below, above = (
            [
                fo.steady_state(system, _TO_AND_FRO, friction, factor, initial_slip=start)
                for start in starts
            ]
            for factor in factors.tolist()
        )
        work = np.array([steady.dissipation for steady in above])
        yield {
            "seed": seed,
            "nodes": system.nodes,
            "opening": limit.events["node"].nunique(),
            "rest_below": sum(steady.outcome is fo.Outcome.SHAKEDOWN for steady in below),
            "rest_above": sum(steady.outcome is fo.Outcome.SHAKEDOWN for steady in above),
            "growth": max(
                _growth(system, friction, factor, starts, parameters.cycles)
                for factor in factors.tolist()
            ),
            "spread": float(np.ptp(work) / work.max()) if work.max() > 0 else 0.0,
            "residual": max(limit.residual, *(steady.residual for steady in (*below, *above))),
        }


def _growth(
    system: fo.ContactSystem, friction: float, load_factor: float, starts: NDArray[Any], cycles: int
) -> float:
    """The largest growth of the energy of the difference between the first transient and another one.

    The growth from one corner to the next is relative to the energy of the difference of the
    starts.
    """
    paths = [
        fo.march(system, _TO_AND_FRO, friction, load_factor, initial_slip=start, cycles=cycles)
        for start in starts
    ]
    slips_at_corners = []
    for path in paths:
        visits = [np.flatnonzero(path.time == corner)[-1] for corner in range(1, 2 * cycles + 1)]
        slips_at_corners.append(path.slip[visits])
    slips = np.array(slips_at_corners)
    energy = _energy(system, slips[1:] - slips[0])
    energy_of_starts = _energy(system, starts[1:] - starts[0])
    return float((np.diff(energy, axis=1).max(axis=1) / energy_of_starts).max())


def _energy(system: fo.ContactSystem, slips: NDArray[Any]) -> NDArray[Any]:
    """Twice the elastic energy of slips (..., N)."""
    return np.asarray(np.einsum("...i,ij,...j->...", slips, system.A, slips))


_JOINTS = {
    "all_closed": "limit with all nodes closed; NaN where no slip is safe so",
    "settled": "limit with the nodes open that the settled mean load opens, the others closed",
    "shakedown": "limit of the best set of open nodes that the search finds; of the pin with nodes that open and close in each cycle",
    "open": "nodes that stay open in it",
    "opening": "nodes that open and close in each cycle in it",
    "sliding": "load above which nothing rests, whatever opens",
    "below": "end of the transient from the state of the limit, `apart` below it",
    "above": "the same above it",
}
_UNCOUPLED = {
    "seed": "of the contact",
    "opening": "nodes that open and close in each cycle at the limit",
    "rest_below": "starts that come to rest just below the limit",
    "rest_above": "the same just above",
    "growth": "largest growth of the energy between two transients, over that of their starts; 0 or less, up to rounding",
    "spread": "largest less least work of friction of the starts above, over the largest",
}
JOINTS = Table(
    "lift_off_joints",
    "one joint with one friction",
    _JOINTS,
    full=FULL,
    quick=QUICK,
    compute=joints,
)
UNCOUPLED = Table(
    "lift_off_uncoupled",
    "one uncoupled contact",
    _UNCOUPLED,
    full=FULL,
    quick=QUICK,
    compute=uncoupled,
)


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Limits of the joints, and counts of the uncoupled contacts, in Markdown."""
    joined, free = tables[JOINTS.name], tables[UNCOUPLED.name]
    columns = ["all_closed", "settled", "shakedown", "sliding"]
    numbers = [
        ["none" if np.isnan(value) else f"{value:.4g}" for value in row]
        for row in joined[columns].to_numpy()
    ]
    rows = [
        [
            row.joint,
            str(row.nodes),
            f"{row.friction:g}",
            *of,
            str(row.open),
            str(row.opening),
            f"{_word(row.below)}, {_word(row.above)}",
        ]
        for row, of in zip(joined.itertuples(), numbers, strict=True)
    ]
    head = [
        "joint",
        "N",
        "f",
        "all closed",
        "settled set",
        "best set",
        "slides off",
        "open",
        "open and close",
        "2 % below, above",
    ]
    of = {
        "that open and close nodes in each cycle": free["opening"] > 0,
        "whose nodes stay as they are": free["opening"] == 0,
    }
    counts = [
        [
            name,
            str(len(part)),
            str(int(part["rest_below"].sum())),
            str(int(part["rest_above"].sum())),
            f"{part['growth'].max():.0e}",
        ]
        for name, part in ((name, free[which]) for name, which in of.items())
    ]
    second = markdown(
        [
            "uncoupled contacts",
            "number",
            "starts at rest 2 % below",
            "2 % above",
            "largest growth of E",
        ],
        counts,
    )
    starts = (FULL if len(free) > QUICK.contacts else QUICK).starts
    return f"{markdown(head, rows)}\n\n{second}\n\nEach of these contacts has {starts} random starts below its limit and {starts} above."


def _word(outcome: str) -> str:
    return {"SHAKEDOWN": "rests", "CYCLIC_SLIP": "slips", "RATCHETING": "ratchets"}[outcome]


STUDY = Study(
    "studies.lift_off",
    __doc__,
    "one joint of each kind and few contacts, in seconds",
    (JOINTS, UNCOUPLED),
    report,
)
