"""Limits of the paper's scene without transients: onset, shakedown limit and safe slip.

Run with `python -m studies limits [--quick]`. Onset and shakedown limit are computed for many
frictions, and the shakedown limit also for many corner sizes. The safe slip is computed at the
limit. All limits are amplitudes of the bulk stress over the mean pressure, sigma / (P / 2a).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo
from frictopt.reference import bonded_corner, sliding_corner_exponent

from .paper import LOADS, force_unit, slip_unit
from .progress import each
from .tables import Row, Study, Table, described

# Friction must be below this share of the traction ratio of the bonded corner. Closer to this ratio
# the limit follows no power law of the mesh.
_BELOW = 0.95


def _steps(*runs: tuple[float, float, float]) -> tuple[float, ...]:
    """Values of runs (first, last, step), joined and rounded, so that 0.7 is exactly 0.7."""
    return tuple(
        round(float(value), 6)
        for first, last, step in runs
        for value in np.arange(first, last + step / 2, step)
    )


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Numbers of elements on the contact of the friction table, grading "sine".
    elements: tuple[int, ...] = (16, 32, 64, 124)
    frictions: tuple[float, ...] = _steps(
        (0.1, 0.65, 0.025), (0.655, 0.75, 0.005), (0.775, 1.5, 0.025), (1.6, 3.0, 0.1)
    )
    corner_frictions: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.543, 0.6, 0.7, 0.8)
    # Meshes of the corner table, grading "sine".
    corner_elements: tuple[int, ...] = (8, 12, 16, 24, 32, 48, 64, 96, 124, 192, 256)
    # Number of elements of the meshes with different gradings.
    graded_elements: int = 64
    gradings: tuple[float, ...] = (2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
    # Number of elements with the default grading, for the reactions.
    reaction_elements: int = 124
    reaction_frictions: tuple[float, ...] = (0.3, 0.7)
    surface_friction: float = 0.5
    # Meshes of the table of contact stiffness, grading "sine".
    surface_elements: tuple[int, ...] = (16, 24, 32, 48, 64, 96, 124, 192, 256)
    # E* divided by the contact stiffness and by a; 0 is a hard contact.
    surfaces: tuple[float, ...] = (0.0, 0.005, 0.02, 0.1)


FULL = Parameters()
QUICK = Parameters(
    elements=(8, 16, 32),
    frictions=_steps((0.1, 1.5, 0.1)),
    corner_frictions=(0.2, 0.4, 0.543, 0.65, 0.7),
    corner_elements=(8, 16, 32),
    graded_elements=16,
    gradings=(2, 20, 200),
    reaction_elements=16,
    reaction_frictions=(0.3, 0.7),
    surface_elements=(16, 32, 64),
    surfaces=(0.0, 0.1),
)


def limits_by_friction(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh and friction coefficient."""
    for elements in each(parameters.elements, "limits by friction"):
        scene = fo.scenes.PunchOnHalfPlane(elements=elements, grading="sine")
        system = scene.condense()
        part = _limits(system, parameters.frictions)
        onsets = pd.DataFrame([_onsets(system, friction) for friction in parameters.frictions])
        q0, p0 = LOADS.mean_reaction(system)
        yield pd.concat([part, onsets], axis=1).assign(
            **_mesh(scene), mean_demand=float(np.max(np.abs(q0) / p0))
        )


def limits_by_corner(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh and friction coefficient."""
    scenes = [
        fo.scenes.PunchOnHalfPlane(elements=elements, grading="sine")
        for elements in parameters.corner_elements
    ]
    scenes += [
        fo.scenes.PunchOnHalfPlane(elements=parameters.graded_elements, grading=float(grading))
        for grading in parameters.gradings
    ]
    for scene in each(scenes, "limits by corner size"):
        yield _limits(scene.condense(), parameters.corner_frictions).assign(**_mesh(scene))


def corner_law(table: pd.DataFrame) -> pd.DataFrame:
    """The law of the corner, for the meshes of the table `CORNER` with one number of elements.

    Their gradings are decades apart, coarse first. At the limit the corner slides, while its bonded
    tractions grow as `r ** (l_bonded - 1)`. If friction is below the traction ratio of the bonded
    corner, the limit varies with the size h of the corner element as `h ** (l_sliding - l_bonded)`.
    Here l_sliding and l_bonded are the exponents of the sliding and of the bonded corner. So the
    limit has no value without a mesh. `expected` is the exponent in closed form. `exponent` is the
    exponent between the previous mesh and this mesh.
    """
    bonded = bonded_corner()[0]
    rows = table[
        (table["grading"] != "sine") & (table["friction"] < _BELOW * bonded.traction_ratio)
    ]
    decades = np.log10(rows["grading"].astype(float))
    # Exponents between closer meshes scatter.
    apart = decades.max() - decades
    rows = rows[np.isclose(apart, apart.round())].sort_values(
        ["friction", "corner_size"], ascending=[True, False], ignore_index=True
    )
    steps = np.log(rows[["load_factor", "corner_size"]]).groupby(rows["friction"]).diff()
    expected = rows["friction"].map(
        lambda friction: sliding_corner_exponent(friction) - bonded.exponent
    )
    return rows.assign(expected=expected, exponent=steps["load_factor"] / steps["corner_size"])


def reactions_at_limit(parameters: Parameters) -> Iterator[Row]:
    """One row per friction coefficient, load corner and node."""
    scene = fo.scenes.PunchOnHalfPlane(elements=parameters.reaction_elements)
    model = fo.ShakedownModel(scene.condense(), LOADS)
    for friction in each(parameters.reaction_frictions, "reactions at the limit"):
        limit = model.solve(friction)
        for corner in range(len(LOADS.corners)):
            yield _corner_reactions(limit, friction, corner).assign(**_mesh(scene))


def limits_by_surface(parameters: Parameters) -> Iterator[Row]:
    """One row per mesh and stiffness of the surfaces."""
    f = parameters.surface_friction
    for elements in each(parameters.surface_elements, "limits by contact stiffness"):
        scene = fo.scenes.PunchOnHalfPlane(elements=elements, grading="sine")
        hard = scene.condense()
        for give in parameters.surfaces:
            stiffness = (hard.E_star or np.nan) / (give * scene.half_width) if give else np.inf
            system = hard.with_contact_stiffness(tangential=stiffness, normal=stiffness)
            limit, first = fo.shakedown_limit(system, LOADS, f), fo.onset(system, LOADS, f)
            row = {
                "surface": give,
                "friction": f,
                "onset": first.slip.load_factor,
                "load_factor": limit.load_factor,
                "residual": limit.residual,
            }
            yield _mesh(scene) | row


def _mesh(scene: fo.scenes.PunchOnHalfPlane) -> dict[str, Any]:
    return {
        "elements": scene.elements,
        "grading": str(scene.grading),
        "corner_size": scene.corner_size / scene.half_width,
    }


def _limits(system: fo.ContactSystem, frictions: Iterable[float]) -> pd.DataFrame:
    """Shakedown limits."""
    return fo.ShakedownModel(system, LOADS).sweep(frictions).filter(described(_LIMIT))


def _onsets(system: fo.ContactSystem, friction: float) -> dict[str, Any]:
    """First slip and first separation of the bonded contact.

    The bulk is pulled (plus) or pressed (minus).
    """
    row: dict[str, Any] = {}
    onset = fo.onset(system, fo.LoadCycle(LOADS.mean, [{"sigma": 1.0}, {"sigma": -1.0}]), friction)
    for name, slip, separation in zip(
        ("plus", "minus"), onset.slips, onset.separations, strict=True
    ):
        row[f"slip_{name}"], row[f"separation_{name}"] = slip.load_factor, separation.load_factor
    return row | {"mean_slips": len(onset.mean_slips)}


def _corner_reactions(
    limit: fo.results.ShakedownLimit, friction: float, corner: int
) -> pd.DataFrame:
    system = limit.system
    q, p = (values[corner] for values in limit.reactions)
    force = force_unit(system)
    mechanism = limit.mechanism
    share = (
        mechanism[mechanism["corner"] == corner]
        .groupby("node")["share"]
        .sum()
        .reindex(range(system.nodes), fill_value=0.0)
    )
    # Without pressure q vanishes, too, and their ratio has no meaning.
    loaded = p > 1e-9 * np.mean(p)
    return pd.DataFrame(
        {
            "friction": friction,
            "load_factor": limit.load_factor,
            "sigma": LOADS.corners[corner]["sigma"],
            "x": system.x / system.x[-1],
            "q": q / force,
            "p": p / force,
            "ratio": np.divide(q, friction * p, out=np.full_like(q, np.nan), where=loaded),
            "slip": limit.slip / slip_unit(system),
            "share": share.to_numpy(),
            "residual": limit.residual,
        }
    )


_LIMIT = {
    "grading": "grading of the contact",
    "load_factor": "shakedown limit lambda_2",
    "least": "least safe load factor, 0 where the mean load alone is safe",
    "node": "node with the largest share of the mechanism",
}
_ONSET = {
    "mean_demand": "largest |q| / p of the bonded contact under the mean load: the friction needed to hold it",
    "slip_plus": "load factor at the first slip, bulk pulled; 0 if it happens under the mean load alone",
    "separation_plus": "load factor at the first separation, bulk pulled",
    "mean_slips": "number of nodes that slip under the mean load alone",
    "slip_minus": "load factor at the first slip, bulk pressed; 0 if it happens under the mean load alone",
    "separation_minus": "load factor at the first separation, bulk pressed",
}
_REACTION = {
    "grading": _LIMIT["grading"],
    "load_factor": _LIMIT["load_factor"],
    "sigma": "load corner: sigma over the load factor",
    "ratio": "q / (f p); NaN where p vanishes",
    "slip": "safe residual slip v E* / (a P / 2a)",
    "share": "share of the node, at this load corner, in the slip of the limiting mechanism",
}

FRICTION = Table(
    "limits_friction",
    "limits of one mesh at one friction",
    _LIMIT | _ONSET,
    full=FULL,
    quick=QUICK,
    compute=limits_by_friction,
)
CORNER = Table(
    "limits_corner",
    "shakedown limit of one mesh at one friction",
    _LIMIT,
    full=FULL,
    quick=QUICK,
    compute=limits_by_corner,
)
REACTIONS = Table(
    "limits_reactions",
    "one node at one load corner, at the shakedown limit",
    _REACTION,
    full=FULL,
    quick=QUICK,
    compute=reactions_at_limit,
)
_SURFACE_COLUMNS = {
    "grading": _LIMIT["grading"],
    "surface": "E* over the contact stiffness, over a; 0 for the hard contact",
    "load_factor": _LIMIT["load_factor"],
}
SURFACE = Table(
    "limits_surface",
    "onset and shakedown limit of one mesh with one contact stiffness",
    _SURFACE_COLUMNS,
    FULL,
    QUICK,
    limits_by_surface,
)

STUDY = Study(
    "studies.limits",
    __doc__,
    "few coarse meshes, in seconds",
    (FRICTION, CORNER, REACTIONS, SURFACE),
)
