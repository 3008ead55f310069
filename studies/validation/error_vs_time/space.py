"""Three dimensions: the plane scene as a contact in space, and a sphere with a closed form.

The answers of the plane scene in space are known.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

import frictopt as fo
from frictopt.limits import pose
from frictopt.limits.program import assembled
from frictopt.reference import SphereContact, half_space_contact
from frictopt.solve.arrays import Arrays
from studies.paper import LOADS
from studies.validation.closed_forms import smallest_circle_limit
from studies.validation.error_vs_time.bare_lp import clarabel_cone
from studies.validation.error_vs_time.limits import exact_largest_margin, exact_least, exact_limit
from studies.validation.error_vs_time.methods import Method, Question, installed, relative
from studies.validation.error_vs_time.parameters import Parameters, Scene
from studies.validation.error_vs_time.transients import (
    CYCLES,
    STEPS,
    in_steps,
    last_work,
    posed,
    start_slip,
)
from studies.validation.fuzz.embedded import embedded

Array = np.ndarray[Any, Any]

# Shear force of the sphere, relative to the friction bound.
_SHEAR = 0.8
# Radius of the sphere and width of the grid, in units of the radius of the contact.
_RADIUS, _WIDTH = 5.0, 1.12


# The contact in three dimensions, and the unit vectors (N, 2) along which the plane slips.
InSpace = tuple[fo.ContactSystem, Array]


def in_space(parameters: Parameters, scene: Scene) -> InSpace:
    """The plane scene as a contact in three dimensions, which has the answers of the plane."""
    return embedded(scene.system, np.random.default_rng(parameters.seed), across=scene.system.A)


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """The questions about the plane scene in three dimensions."""
    space = in_space(parameters, scene)
    yield _limit(parameters, scene, space)
    yield _increment(parameters, scene, space)
    if elements in parameters.space_elements:
        yield _transient(parameters, scene, space)
        yield _steady(parameters, scene, space)
    yield from _answers(parameters, scene, space[0], elements)


def spheres(parameters: Parameters) -> Question:
    """Work of a sphere in the second cycle, for several numbers of cells across its grid."""
    E, f, nu = 1.0, 0.5, 0.0
    # This force makes a contact of radius 1.
    P = E / (1.5 * _RADIUS)
    # Motion of the far end under this shear (Mindlin and Deresiewicz).
    far = 3 * f * P / 8 * 2 / E * 2 * (1 - (1 - _SHEAR) ** (2 / 3))

    def followed(cells: int) -> Any:
        arrays: Any = half_space_contact(cells, _WIDTH, _RADIUS, E, nu)
        system = fo.ContactSystem(**arrays)
        cycle = fo.LoadCycle({"approach": 1 / _RADIUS}, [{"x": 1.0}, {"x": -1.0}])
        return fo.march(system, cycle, f, far, cycles=CYCLES, steps=2)

    def error(path: fo.results.Trajectory) -> float:
        corner = int(np.flatnonzero(path.time == 1)[0])
        ball = SphereContact(float(path.p[corner].sum()), _RADIUS, E, nu, f)
        return abs(last_work(path) / ball.dissipation(abs(float(path.q[corner, :, 0].sum()))) - 1)

    methods = [
        Method("frictopt, newton", "cells", f"{n}", partial(followed, n), error)
        for n in parameters.sphere_cells
    ]
    # The reference is the closed form of Mindlin and Deresiewicz with the forces of the mesh.
    return Question(
        "transient, 3-D", "work in the second cycle", "sphere on a half-space", 0, methods
    )


def _limit(parameters: Parameters, scene: Scene, space: InSpace) -> Question:
    """The shakedown limit in space."""
    system = space[0]
    friction = parameters.friction
    exact = exact_limit(scene.system, friction)
    shakedown_limit = partial(fo.shakedown_limit, system, LOADS, friction)
    error = relative(exact, lambda limit: limit.load_factor)
    methods = [
        Method("frictopt", "solver", solver, partial(shakedown_limit, solver=solver), error)
        for solver in ("CLARABEL", "CLARABEL_DIRECT")
    ]
    program = assembled.shakedown(pose(system, LOADS, friction))
    arrays, unit = program.arrays(), program.place.unit
    for tolerance in parameters.tolerances:
        bare = partial(_clarabel, arrays.widened, tolerance)
        methods.append(
            Method(
                "Clarabel",
                "tolerance",
                f"{tolerance:.0e}",
                bare,
                relative(exact, lambda cost: -cost * unit),
                rival="clarabel",
            )
        )
    return Question("lambda_2, 3-D", "load factor", _name(scene), system.nodes, methods)


def _clarabel(program: Arrays, tolerance: float) -> float:
    """Optimal cost of a cone program of frictopt, by Clarabel."""
    package, linear = installed("clarabel"), int((program.sizes == 1).sum())
    cones = [
        package.ZeroConeT(program.zero),
        package.NonnegativeConeT(linear),
        *map(package.SecondOrderConeT, program.sizes[linear:].tolist()),
    ]
    return clarabel_cone(program.cost, csc_matrix(program.matrix), program.right, cones, tolerance)


def _increment(parameters: Parameters, scene: Scene, space: InSpace) -> Question:
    """One increment from the state at the first corner, above the shakedown limit, to the second."""
    n = scene.system.nodes
    path, exact = posed(parameters, scene, parameters.overload)
    system, along = space
    before = path.state.u[:n, None] * along
    after = exact[:, None] * along
    bonded = path.corners[1][:n, None] * along, path.corners[1][n:]

    def error(found: fo.increments.Increment) -> float:
        return float(np.abs(found.slip - after).max() / np.abs(after - before).max())

    increment = fo.increments.NewtonIncrement(system, parameters.friction)
    solve = partial(increment.solve, before, bonded)
    methods = [Method("frictopt", "engine", "newton", solve, error)]
    return Question("increment, 3-D", "slip", _name(scene), n, methods)


def _transient(parameters: Parameters, scene: Scene, space: InSpace) -> Question:
    """The work of a transient in space."""
    friction, factor = parameters.friction, parameters.overload * scene.limit
    exact = last_work(fo.march(scene.system, LOADS, friction, factor, cycles=CYCLES))
    march = partial(fo.march, space[0], LOADS, friction, factor, cycles=CYCLES)
    methods = in_steps("frictopt, newton", march, parameters.space_steps, exact)
    return Question(
        "transient, 3-D", "work in the second cycle", _name(scene), scene.system.nodes, methods
    )


def _steady(parameters: Parameters, scene: Scene, space: InSpace) -> Question:
    """The work of a steady state in space."""
    friction, factor = parameters.friction, parameters.steady_overload * scene.limit
    start = start_slip(parameters, scene.system)
    exact = last_work(
        fo.march(
            scene.system,
            LOADS,
            friction,
            factor,
            initial_slip=start,
            cycles=parameters.reference_cycles,
        )
    )
    steady = partial(
        fo.steady_state, space[0], LOADS, friction, factor, initial_slip=start[:, None] * space[1]
    )
    error = relative(exact, lambda made: made.dissipation)
    methods = [
        Method("frictopt, newton", STEPS, f"{n}", partial(steady, steps=n), error)
        for n in parameters.space_steps
    ]
    # The reference is the work in cycle `reference_cycles` of the exact path in the plane.
    return Question(
        "steady state, 3-D", "work in a cycle", _name(scene), scene.system.nodes, methods
    )


def _name(scene: Scene) -> str:
    return f"{scene.name}, in space"


# Load factor of the least slip, relative to the shakedown limit.
_ABOVE = 1.5
# Tolerance of a limit after a protocol.
_PROVEN = 1e-4
# Half the side of the sphere's grid divided by the radius of its contact. The grid is small enough
# that every node is pressed.
_HALF = 0.6
# Number of rays on which a region is compared with its closed form.
_RAYS = 64


def _answers(
    parameters: Parameters, scene: Scene, system: fo.ContactSystem, elements: int
) -> Iterator[Question]:
    """Limits whose answers are known from the plane.

    On the coarsest mesh there are also two questions that follow transients.
    """
    plane = scene.system
    friction = parameters.friction
    name = _name(scene)
    n = plane.nodes

    def question(computation: str, quantity: str, run: Any, value: Any, exact: float) -> Question:
        return Question(
            computation,
            quantity,
            name,
            n,
            [Method("frictopt", "none", "default", run, relative(exact, value))],
        )

    guaranteed_friction = parameters.guaranteed_friction
    factor = parameters.margin_share * scene.limit
    above = _ABOVE * scene.limit
    run: Any = partial(fo.guaranteed_limit, system, LOADS, guaranteed_friction)
    yield question(
        "lambda_1, 3-D",
        "upper bound",
        run,
        lambda limit: limit.load_factor,
        exact_least(plane, guaranteed_friction),
    )

    run = partial(fo.safe_slip, system, LOADS, friction, factor)
    exact = exact_largest_margin(plane, friction, factor)
    yield question("safe slip, 3-D", "margin", run, lambda safe: safe.margin, exact)

    run = partial(fo.required_friction, system, LOADS, exact_limit(plane, friction))
    # The reference is the friction for which this load factor is the limit in the plane.
    yield question(
        "required friction, 3-D", "coefficient", run, lambda found: found.required, friction
    )

    run = partial(fo.shakedown_limit(system, LOADS, friction).least_slip, above)
    exact = fo.shakedown_limit(plane, LOADS, friction).least_slip(above).bound
    yield question(
        "least slip, 3-D", "bound, the limit given", run, lambda least: least.bound, exact
    )

    if elements == min(parameters.space_elements):

        def after_protocol(
            contact: fo.ContactSystem, steps: int | None = None
        ) -> fo.results.LimitAfterProtocol:
            limit = fo.shakedown_limit(contact, LOADS, friction)
            return fo.limit_after_protocol(limit, tolerance=_PROVEN, steps=steps)

        exact = after_protocol(plane).load_factor
        steps = parameters.search_steps
        error = relative(exact, lambda limit: limit.load_factor)
        methods = [
            Method("frictopt", STEPS, f"{many}", partial(after_protocol, system, many), error)
            for many in steps
        ]
        yield Question("limit after protocol, 3-D", "load factor", name, n, methods)

        asked = LOADS, friction, parameters.overload * scene.limit
        span = fo.dissipation_range(plane, *asked)

        def off(found: fo.results.DissipationRange) -> float:
            return max(abs(found.least / span.least - 1), abs(found.most / span.most - 1))

        methods = [
            Method(
                "frictopt",
                STEPS,
                f"{many}",
                partial(fo.dissipation_range, system, *asked, steps=many),
                off,
            )
            for many in steps
        ]
        yield Question("range of dissipation, 3-D", "least and most work", name, n, methods)


def amplitudes(parameters: Parameters) -> Question:
    """Safe amplitudes of shear along both axes of a sphere: error of the polygon of safe points.

    The closed form is a curve. The error is the largest relative shortfall of the polygon.
    """
    arrays: Any = half_space_contact(min(parameters.sphere_cells), _HALF, 5.0, 1.0, 0.0)
    system, friction = fo.ContactSystem(**arrays), parameters.space_friction
    mean = {"approach": 1 / 5.0}
    pressure = system.closed_reaction(mean)[1]

    def shortfall(region: fo.results.SafeRegion) -> float:
        found = []
        for angle in np.linspace(0, np.pi / 2, _RAYS):
            ray = np.array([np.cos(angle), np.sin(angle)])
            q = region.cycle(*ray).corner_reactions(system)[0]
            exact = smallest_circle_limit(pressure, q, friction)
            reach = [
                _crossing(one, other, ray)
                for one, other in zip(region.vertices, region.vertices[1:], strict=False)
            ]
            found.append(1 - min(reach) / exact)
        return float(np.max(np.abs(found)))

    methods = []
    for tolerance in parameters.region_tolerances:
        run = partial(fo.safe_region, system, mean, ["x", "y"], friction, tolerance=tolerance)
        methods.append(Method("frictopt", "tolerance", f"{tolerance:.0e}", run, shortfall))
    return Question(
        "safe region, 3-D", "amplitudes", "sphere on a half-space", system.nodes, methods
    )


def _crossing(one: Any, other: Any, ray: Any) -> float:
    """Multiple of a ray at which it meets the line through two points; inf if they are parallel."""
    across = np.array([other[1] - one[1], one[0] - other[0]])
    return float(across @ one / (across @ ray)) if across @ ray > 0 else np.inf
