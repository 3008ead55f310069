"""Measured and computed data sets of others beside results of frictopt.

Run with `python -m studies datasets [--quick]`. It prints a table in Markdown. The numbers of
others are in `theirs.csv`, with their sources and licences. Closed forms of others are in the study
`published`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.reference import half_plane_contact

from ..published.case import opposed, stuck
from ..published.joints import lap
from ..tables import Study, Table, markdown

Array = np.ndarray[Any, Any]

_NUMBERS = Path(__file__).with_name("theirs.csv")


@dataclass(frozen=True)
class Parameters:
    """Meshes of frictopt."""

    # Number of cells of the cylinders, along 1.15 times the contact width by Hertz's theory.
    cells: int = 151
    # Number of increments of the pressing, as in the finer example of MOOSE.
    increments: int = 2
    # Number of increments that approximate slow pressing.
    many: int = 40
    lap_elements: int = 100
    # Thickness of the outer plate divided by half the overlap.
    lap_thickness: float = 0.02


FULL = Parameters()
QUICK = Parameters(cells=41, many=8, lap_elements=60, lap_thickness=0.03)


@dataclass(frozen=True)
class Comparison:
    """One number of others beside the number of frictopt.

    Attributes
    ----------
    source, quantity
        The source of the number, and its meaning.
    theirs, ours
        Both numbers.
    why
        The computation by frictopt, and the reason for the difference.
    residual
        Residual of the result of frictopt.
    """

    source: str
    quantity: str
    theirs: float
    ours: float
    why: str
    residual: float = 0.0


def numbers(source: str, quantity: str) -> tuple[Array, Array]:
    """Places and values of a quantity from a source."""
    table = pd.read_csv(_NUMBERS, comment="#")
    rows = table[(table["source"] == source) & (table["quantity"] == quantity)]
    return rows["at"].to_numpy(), rows["value"].to_numpy()


def total_of_half(at: Array, values: Array) -> float:
    """Integral of an even function by the trapezoidal rule.

    The values are at equal distances on one half.
    """
    return float((at[1] - at[0]) * (values[0] + 2 * values[1:].sum()))


def dundurs(moduli: tuple[float, float], poisson: float) -> float:
    """Second constant of Dundurs for two materials in plane strain; the second may be rigid (inf)."""
    first, second = (0.0 if np.isinf(E) else 1 / E for E in moduli)
    return float((first - second) * (1 - 2 * poisson) / (2 * (1 - poisson) * (first + second)))


def pressed_cylinder(
    force: float, radius: float, E_star: float, beta: float, friction: float, cells: int, steps: int
) -> tuple[Array, Array, Array]:
    """Places, pressure and shear of a cylinder that is pressed in equal increments."""
    width = 1.15 * np.sqrt(4 * force * radius / (pi * E_star))
    system = fo.ContactSystem.from_blocks(
        **half_plane_contact(cells, width, E_star, R=radius, beta=beta)
    )
    increment = fo.increments.NewtonIncrement(system, friction)
    slip = np.zeros(cells)
    for step in range(1, steps + 1):
        state = increment.solve(slip, system.reaction({"P": force * step / steps}))
        slip = state.slip
    size = 2 * width / cells
    return system.x, state.p / size, state.q / size


def comparisons(parameters: Parameters) -> Iterator[Comparison]:
    """All comparisons."""
    yield from _moose(parameters)
    yield _roller(parameters)
    yield from _beam(parameters)


# Modulus, Poisson's ratio, radius and friction of the cylinder of MOOSE.
_MODULUS, _POISSON, _RADIUS, _FRICTION = 1e6, 0.3, 3.0, 0.4


def _moose(parameters: Parameters) -> Iterator[Comparison]:
    """A cylinder on rigid ground; the force is the integral of the pressure of MOOSE."""
    E_star = _MODULUS / (1 - _POISSON**2)
    beta = dundurs((_MODULUS, np.inf), _POISSON)
    for name, steps in (("multipliers", 3), ("augmented", parameters.increments)):
        at, theirs = numbers(f"moose {name}", "pressure")
        force = total_of_half(at, theirs)
        hertz = np.sqrt(force * E_star / (pi * _RADIUS))
        x, p, q = pressed_cylinder(force, _RADIUS, E_star, beta, _FRICTION, parameters.cells, steps)
        source = f"MOOSE, cylinder on rigid ground, {name}"
        why = (
            f"two half-planes, {steps} increments as theirs; friction raises the pressure, "
            f"which is {hertz:.0f} without it (Hertz)"
        )
        yield Comparison(source, "pressure in the middle", theirs[0], p.max(), why)
        half = len(at) // 2
        why = "the same; between the middle and the edge"
        quantity = f"pressure at x = {at[half]:.4f}"
        yield Comparison(source, quantity, theirs[half], float(np.interp(at[half], x, p)), why)
    at, shear = numbers("moose augmented", "shear")
    _, pressure = numbers("moose augmented", "pressure")
    edge = float(at[np.argmax(shear > 0.999 * _FRICTION * pressure)])
    width = 2 * x[-1] / (len(x) - 1)
    inside = np.count_nonzero(stuck(q, p, _FRICTION) & (np.abs(x) < 0.95 * at[-1])) * width / 2
    slow = pressed_cylinder(
        force, _RADIUS, E_star, beta, _FRICTION, parameters.cells, parameters.many
    )
    zone = np.count_nonzero(stuck(slow[2], slow[1], _FRICTION)) * width / 2
    yield Comparison(
        source,
        "distance from the middle at which slip begins",
        edge,
        inside,
        "two increments as theirs; theirs has a penalty against slip, so that shear in the middle "
        f"is smaller. The zone depends on the increments: {zone:.4f} with {parameters.many}",
    )


def _roller(parameters: Parameters) -> Comparison:
    """A steel cylinder of radius 50 mm on aluminium, under 35 kN / mm."""
    force, radius = 35000.0, 50.0
    block, roller = 70000.0, 210000.0
    E_star = 1 / ((1 - _POISSON**2) * (1 / block + 1 / roller))
    beta = dundurs((block, roller), _POISSON)
    _, pressure, _ = pressed_cylinder(
        force, radius, E_star, beta, 0.1, parameters.cells, parameters.many
    )
    _, theirs = numbers("roller", "pressure")
    hertz = np.sqrt(force * E_star / (pi * radius))
    return Comparison(
        "NAFEMS, roller on a block, f = 0.1 (MARC)",
        "pressure in the middle, MPa",
        theirs[0],
        pressure.max(),
        f"two half-planes, {hertz:.0f} without friction; theirs is the stress of finite elements in "
        "a block of finite size",
    )


def _beam(parameters: Parameters) -> Iterator[Comparison]:
    """Exponents of the measured damping, and of a lap joint under even pressure."""
    acceleration, force = numbers("beam", "force")
    frequency = numbers("beam", "frequency")[1]
    # This ratio is proportional to the damping ratio.
    ratio = force / acceleration
    above = np.log(ratio[2:] - ratio[0])
    measured = float(np.polyfit(np.log(acceleration[2:]), above, 1)[0])
    contact = lap(parameters.lap_elements, parameters.lap_thickness).condense(progress=False)
    friction, shares = 0.1, np.array([0.3, 0.8])
    slides = 2 * friction / parameters.lap_thickness
    states = [
        fo.steady_state(contact, opposed({"press": 1.0}, {"pull": share * slides}), friction, 1.0)
        for share in shares
    ]
    work = np.array([state.dissipation for state in states])
    ours = float(np.polyfit(np.log(shares), np.log(work / shares**2), 1)[0])
    source = "Brake-Reuss beam, forced response (measured)"
    yield Comparison(
        source,
        "exponent of damping against amplitude, less the damping of the least amplitude",
        measured,
        ours,
        "a lap joint under even pressure, no fit; the exponent depends on the pressure at the edge "
        "of the contact, which was not measured",
        max(state.residual for state in states),
    )
    yield Comparison(
        source,
        "frequency at 80 m/s^2 / that at 5 m/s^2",
        float(frequency[-1] / frequency[0]),
        np.nan,
        "no number: with friction of a fixed closed contact the frequency falls as the amplitude "
        "grows. The measured one falls by 0.3 % up to 40 m/s^2 and then rises above its first "
        "value, so pressure, contact area or temperature changed",
    )


def compared(parameters: Parameters) -> Iterator[Mapping[str, Any]]:
    """One row for each comparison."""
    for one in comparisons(parameters):
        yield {
            "source": one.source,
            "quantity": one.quantity,
            "theirs": float(one.theirs),
            "ours": float(one.ours),
            "difference": float(one.ours / one.theirs - 1),
            "why": one.why,
            "residual": one.residual,
        }


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """The table."""
    rows = []
    for row in tables[DATASETS.name].itertuples():
        known = not np.isnan(row.ours)
        ours = f"{row.ours:.5g}" if known else "none"
        difference = f"{100 * row.difference:+.2g} %" if known else ""
        rows.append([row.source, row.quantity, f"{row.theirs:.5g}", ours, difference, row.why])
    head = ["source", "quantity", "theirs", "ours", "difference", "how ours is made, and why"]
    return markdown(head, rows)


_COLUMNS = {
    "source": "whose data",
    "quantity": "what is compared",
    "theirs": "their number, in their units",
    "ours": "our number; NaN if the model has none",
    "difference": "ours / theirs - 1",
    "why": "how ours is made, and why it differs",
}
DATASETS = Table(
    "datasets", "one number of others", _COLUMNS, full=FULL, quick=QUICK, compute=compared
)
STUDY = Study("studies.datasets", __doc__, "coarse meshes, in seconds", (DATASETS,), report)
