"""Joints and corners: sliders, a rod, layered beams, lap joints, and the corner of a square punch."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from skfem import MeshQuad

import frictopt as fo
from frictopt.reference import (
    bonded_corner,
    foundation_rod,
    rod_dissipation,
    sliding_corner_exponent,
)
from studies.validation.closed_forms import masing_dissipation

from ..paper import LOADS
from .case import Case, opposed

_BEAM_FRICTION, _LAP_FRICTION = 0.3, 0.1


@dataclass(frozen=True)
class Parameters:
    """Parameters of the cases."""

    # Amplitudes of the base of the sliders.
    slider_loads: tuple[float, ...] = (0.1, 0.2, 0.35, 0.5)
    # Number of nodes along the rod. All nodes but the last slip under the largest load.
    rod_nodes: int = 40
    # Loads relative to this largest load.
    rod_loads: tuple[float, ...] = (0.25, 0.5, 1.0)
    # Number of elements along the beam; four elements lie through each layer.
    beam_elements: int = 80
    # Length of the beam divided by the thickness of a layer.
    beam_length: float = 20.0
    # Loads relative to the load at which the layers slip.
    beam_loads: tuple[float, ...] = (1.1, 1.5, 2.0, 3.0)
    lap_elements: int = 200
    # Thickness of the outer plate divided by half the overlap.
    lap_thickness: float = 0.02
    # Loads relative to the load at which the plates slide off.
    lap_loads: tuple[float, ...] = (0.2, 0.4, 0.6, 0.8, 0.95)
    corner_elements: int = 124
    corner_grading: float = 200.0
    law_elements: int = 64
    law_gradings: tuple[float, float] = (100.0, 1000.0)
    law_frictions: tuple[float, ...] = (0.2, 0.3, 0.4)


def cases(parameters: Parameters) -> Iterator[Case]:
    """All cases of joints and of the corner."""
    yield _sliders(parameters)
    yield _rod(parameters)
    yield _layered_beam(parameters)
    yield _lap_joint(parameters)
    yield from _corner(parameters)
    yield _corner_law(parameters)


def _sliders(parameters: Parameters) -> Case:
    k, bound = np.array([1.0, 2.0, 4.0]), np.array([0.5, 0.6, 0.4])
    none, pressures = np.zeros(3), bound / 0.5
    blocks = np.diag(k), np.diag(none), np.eye(3)
    sliders = fo.ContactSystem.from_blocks(
        *blocks, np.arange(3.0), {"P": (none, pressures), "X": (-k, none)}
    )
    steady = [
        fo.steady_state(sliders, opposed({"P": 1.0}, {"X": 1.0}), 0.5, load)
        for load in parameters.slider_loads
    ]
    return Case(
        "Masing 1926, Iwan 1966",
        "work of friction per cycle of three sliders in parallel",
        "amplitude of their base",
        "the same sliders; rounding",
        parameters.slider_loads,
        partial(masing_dissipation, k, bound),
        [one.dissipation for one in steady],
        max(one.residual for one in steady),
    )


def _rod(parameters: Parameters) -> Case:
    """A rod of unit stiffness EA, with unit friction at each node and unit distance of the nodes.

    A force of n units makes n nodes slip.
    """
    n = parameters.rod_nodes
    rod = fo.ContactSystem.from_blocks(**foundation_rod(nodes=n + 2, EA=1.0, h=1.0))
    steady = [
        fo.steady_state(rod, opposed({"pressure": 1.0}, {"force": share * n}), 1.0, 1.0)
        for share in parameters.rod_loads
    ]
    return Case(
        "Menq, Bielak & Griffin 1986",
        "work of friction per cycle of a rod on a foundation, W EA tau / F^3",
        "nodes that slip / all",
        f"{n} nodes: one of n nodes has the share 1 - 1 / n^2 of the rod's work",
        parameters.rod_loads,
        lambda share: rod_dissipation(share * n, 1.0, 1.0) / (share * n) ** 3,
        [
            one.dissipation / (share * n) ** 3
            for one, share in zip(steady, parameters.rod_loads, strict=True)
        ],
        max(one.residual for one in steady),
    )


def beam(elements: int, length: float) -> fo.fem.ContactModel:
    """Two cantilevers of thickness 1, one on the other, under unit pressure.

    Each tip carries a force of half a unit. The roots cannot turn.
    """
    along, across = np.linspace(0.0, length, elements + 1), np.linspace(0.0, 1.0, 5)
    sides = {
        "face": lambda x: x[1] == 0.0,
        "pressed": lambda x: np.abs(x[1]) == 1.0,
        "root": lambda x: x[0] == 0.0,
        # The faces end in the root, and may open there.
        "held": lambda x: (x[0] == 0.0) & (np.abs(x[1]) > 0.25),
        "tip": lambda x: x[0] == length,
    }
    meshes = {
        name: MeshQuad.init_tensor(along, sign * across).with_boundaries(sides)
        for name, sign in (("upper", 1.0), ("lower", -1.0))
    }
    return fo.fem.ContactModel(
        bodies={
            name: fo.fem.Body(mesh, fo.fem.Material(nu=0.0), "quadratic")
            for name, mesh in meshes.items()
        },
        contacts=[fo.fem.Contact("upper", "lower", "face", "face")],
        supports=[
            support
            for name in meshes
            for support in (fo.fem.Support(name, "root", "x"), fo.fem.Support(name, "held", "y"))
        ],
        loads={
            "press": [fo.fem.Pressure(name, "pressed", 1.0) for name in meshes],
            "tip": [fo.fem.Traction(name, "tip", y=0.5) for name in meshes],
        },
    )


def beam_work(over: float, length: float) -> float:
    """Work of friction per cycle of two layers of unit thickness, pressure and modulus.

    `over` is the tip force divided by the tip force at first slip. This force is `4 f p h / 3`: the
    shear stress of one beam reaches f p, and the whole interface begins to slip. The slip is `(L^2
    - x^2) (3 F - 4 f p h) / (E h^2)` on the way up, and twice as large on the way back. So `W = 8 f
    p L^3 (F - 4 f p h / 3) / (E h^2)`, per width.
    """
    return 8 * _BEAM_FRICTION * length**3 * 4 / 3 * _BEAM_FRICTION * (over - 1)


def _layered_beam(parameters: Parameters) -> Case:
    length, slips = parameters.beam_length, 4 / 3 * _BEAM_FRICTION
    contact = beam(parameters.beam_elements, length).condense()
    steady = [
        fo.steady_state(
            contact, opposed({"press": 1.0}, {"tip": over * slips}), _BEAM_FRICTION, 1.0
        )
        for over in parameters.beam_loads
    ]
    unit = beam_work(2.0, length)
    return Case(
        "Goodman & Klumpp 1956",
        "work of friction per cycle of a cantilever of two layers / that at twice the force of "
        "first slip",
        "tip force / that of first slip",
        f"finite elements, {parameters.beam_elements} by 4 quadratic ones in a layer of L / h = "
        f"{length:g}; theirs is beam theory",
        parameters.beam_loads,
        lambda over: beam_work(over, length) / unit,
        [one.dissipation / unit for one in steady],
        max(one.residual for one in steady),
    )


def lap(elements: int, thickness: float) -> fo.fem.ContactModel:
    """A double lap joint, halved along its middle plate.

    The plates have equal stiffness, and overlap in -1 <= x <= 1 under unit pressure.
    """
    over, arm = np.linspace(-1.0, 1.0, elements + 1), np.linspace(1.0, 2.0, elements // 4 + 1)[1:]
    up = np.linspace(0.0, thickness, 3)
    sides = {
        "lap": lambda x: (x[1] == 0.0) & (np.abs(x[0]) < 1.0),
        "pressed": lambda x: (x[1] == thickness) & (np.abs(x[0]) < 1.0),
        "end": lambda x: np.abs(x[0]) == 2.0,
        "middle": lambda x: x[1] == -thickness,
    }
    axes = {"outer": (np.r_[over, arm], up), "inner": (np.r_[-arm[::-1], over], -up)}
    return fo.fem.ContactModel(
        bodies={
            name: fo.fem.Body(
                MeshQuad.init_tensor(*axis).with_boundaries(sides), fo.fem.Material(nu=0.0)
            )
            for name, axis in axes.items()
        },
        contacts=[fo.fem.Contact("outer", "inner", "lap", "lap")],
        supports=[fo.fem.Support("inner", "end"), fo.fem.Support("inner", "middle", "y")],
        loads={
            "press": [fo.fem.Pressure("outer", "pressed", 1.0)],
            "pull": [fo.fem.Traction("outer", "end", x=1.0)],
        },
    )


def _lap_joint(parameters: Parameters) -> Case:
    """The work W = F^3 / (3 EA tau) of a lap joint.

    Each plate carries F / 2 where the plates stick. At each end the friction tau transfers F / 2
    within the length `F / (2 tau)`.
    """
    h, slides = parameters.lap_thickness, 2 * _LAP_FRICTION
    contact = lap(parameters.lap_elements, h).condense()
    cycles = [
        opposed({"press": 1.0}, {"pull": share * slides / h}) for share in parameters.lap_loads
    ]
    steady = [fo.steady_state(contact, cycle, _LAP_FRICTION, 1.0) for cycle in cycles]
    how = f"finite elements, {parameters.lap_elements} along the overlap, h / L = {h / 2:g}; theirs are bars, so slip zones must be long beside h"
    return Case(
        "Metherell & Diller 1968",
        "work of friction per cycle of a lap joint, W EA tau / F^3",
        "force / that of sliding off",
        how,
        parameters.lap_loads,
        lambda _: 1 / 3,
        [
            one.dissipation * h * _LAP_FRICTION / (share * slides) ** 3
            for one, share in zip(steady, parameters.lap_loads, strict=True)
        ],
        max(one.residual for one in steady),
    )


def _corner(parameters: Parameters) -> Iterator[Case]:
    """Exponent and traction ratio of the singular modes near a corner.

    The tractions are the sum of both singular modes and a regular term. The weaker mode cancels in
    `q - ratio p`, where `ratio` is the traction ratio of this mode.
    """
    system = fo.scenes.PunchOnHalfPlane(
        elements=parameters.corner_elements, grading=parameters.corner_grading
    ).condense()
    edges = np.r_[system.x[0], (system.x[1:] + system.x[:-1]) / 2, system.x[-1]]
    q, p = (force / np.diff(edges) for force in system.reaction(LOADS.mean))
    distance = system.x / system.x[-1] + 1
    near = (distance > 0.03) & (distance < 0.2)
    strong, weak = bonded_corner()
    powers = distance[near, None] ** np.array([strong.exponent - 1, weak.exponent - 1, 1.0])
    sheared, pressed = (
        np.linalg.lstsq(powers, traction[near], rcond=None)[0][0] for traction in (q, p)
    )
    slope, _ = np.polyfit(
        np.log(distance[near]), np.log(np.abs((q - weak.traction_ratio * p)[near])), 1
    )
    source = "Williams 1952, Churchman & Hills 2006"
    how = (
        f"finite elements, {parameters.corner_elements} on the contact; fitted from 3 to 20 % of a"
    )
    quantity = "power of the distance from a bonded corner with which its tractions grow"
    yield Case(
        source, quantity, "", how, (np.nan,), lambda _: strong.exponent - 1, (float(slope),), 0.0
    )
    quantity = (
        "q / p of the stronger mode at a bonded corner: with more friction it sticks when pressed"
    )
    yield Case(
        source,
        quantity,
        "",
        how,
        (np.nan,),
        lambda _: strong.traction_ratio,
        (float(sheared / pressed),),
        0.0,
    )


def _corner_law(parameters: Parameters) -> Case:
    """The limit against the size of the corner element, see `studies.limits.corner_law`.

    At the limit the corner slides, and the bonded tractions there grow as the element shrinks.
    """
    sizes, limits, residuals = [], [], []
    for grading in parameters.law_gradings:
        scene = fo.scenes.PunchOnHalfPlane(elements=parameters.law_elements, grading=grading)
        found = [fo.shakedown_limit(scene.condense(), LOADS, f) for f in parameters.law_frictions]
        sizes.append(scene.corner_size)
        limits.append([limit.load_factor for limit in found])
        residuals += [limit.residual for limit in found]
    powers = np.diff(np.log(limits), axis=0)[0] / np.diff(np.log(sizes))[0]
    return Case(
        "Comninou 1976, Churchman & Hills 2006",
        "power of the corner element with which the shakedown limit of a square punch falls",
        "f",
        "finite elements, two corners a decade apart; theirs: exponents of the sliding and of the "
        "bonded corner",
        parameters.law_frictions,
        lambda f: sliding_corner_exponent(f) - bonded_corner()[0].exponent,
        [float(power) for power in powers],
        max(residuals),
    )
