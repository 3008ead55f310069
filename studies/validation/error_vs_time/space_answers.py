"""What else limits answer in three dimensions: of the plane scene as a contact in space, and safe amplitudes of a sphere in closed form."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.reference import half_space_contact, smallest_circle_limit

from ...paper import LOADS
from .guaranteed import exact_least
from .limits import exact_largest_margin, exact_limit
from .methods import Method, Question, relative
from .parameters import Parameters
from .scenes import Scene
from .space import in_space
from .transients import STEPS

_ABOVE = 1.5  # load factor of the least slip, over the shakedown limit
_PROVEN = 1e-4  # tolerance of a limit after protocol
_HALF = 0.6  # of the side of the sphere's grid, over the radius of its contact: every node is pressed
_RAYS = 64  # on which a region is compared with its closed form


def questions(parameters: Parameters, scene: Scene, elements: int) -> Iterator[Question]:
    """Limits whose answers are those of the plane, and on the coarsest mesh two that follow transients."""
    plane, friction = scene.system, parameters.friction
    system, _ = in_space(parameters, scene)
    name, n = f"{scene.name}, in space", plane.nodes

    def question(computation: str, quantity: str, run: Any, value: Any, exact: float) -> Question:
        return Question(computation, quantity, name, n, [Method("frictopt", "none", "default", run, relative(exact, value))])

    rubbing, factor, above = parameters.guaranteed_friction, parameters.margin_share * scene.limit, _ABOVE * scene.limit
    run: Any = partial(fo.guaranteed_limit, system, LOADS, rubbing)
    yield question("lambda_1, 3-D", "upper bound", run, lambda limit: limit.load_factor, exact_least(plane, rubbing))

    run, exact = partial(fo.safe_slip, system, LOADS, friction, factor), exact_largest_margin(plane, friction, factor)
    yield question("safe slip, 3-D", "margin", run, lambda safe: safe.margin, exact)

    run = partial(fo.required_friction, system, LOADS, exact_limit(plane, friction))
    # reference: the friction at which the plane's limit is that load factor
    yield question("required friction, 3-D", "coefficient", run, lambda found: found.required, friction)

    run = partial(fo.shakedown_limit(system, LOADS, friction).least_slip, above)
    exact = fo.shakedown_limit(plane, LOADS, friction).least_slip(above).bound
    yield question("least slip, 3-D", "bound, the limit given", run, lambda least: least.bound, exact)

    if elements == min(parameters.space_elements):
        exact = fo.limit_after_protocol(plane, LOADS, friction, tolerance=_PROVEN).load_factor
        ask, steps = partial(fo.limit_after_protocol, system, LOADS, friction, tolerance=_PROVEN), parameters.search_steps
        error = relative(exact, lambda found: found.load_factor)
        methods = [Method("frictopt", STEPS, f"{many}", partial(ask, steps=many), error) for many in steps]
        yield Question("limit after protocol, 3-D", "load factor", name, n, methods)

        asked = LOADS, friction, parameters.overload * scene.limit
        span = fo.dissipation_range(plane, *asked)

        def off(found: fo.results.DissipationRange) -> float:
            return max(abs(found.least / span.least - 1), abs(found.most / span.most - 1))

        methods = [Method("frictopt", STEPS, f"{many}", partial(fo.dissipation_range, system, *asked, steps=many), off) for many in steps]
        yield Question("range of dissipation, 3-D", "least and most work", name, n, methods)


def amplitudes(parameters: Parameters) -> Question:
    """Safe amplitudes of shear along both axes of a sphere, a curve: largest shortfall of the polygon of safe points, over its tolerance."""
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
            reach = [_crossing(one, other, ray) for one, other in zip(region.vertices, region.vertices[1:], strict=False)]
            found.append(1 - min(reach) / exact)
        return float(np.max(np.abs(found)))

    methods = []
    for tolerance in parameters.region_tolerances:
        run = partial(fo.safe_region, system, mean, ["x", "y"], friction, tolerance=tolerance)
        methods.append(Method("frictopt", "tolerance", f"{tolerance:.0e}", run, shortfall))
    return Question("safe region, 3-D", "amplitudes", "sphere on a half-space", system.nodes, methods)


def _crossing(one: Any, other: Any, ray: Any) -> float:
    """Where a ray from zero meets the line through two points, in multiples of the ray; inf where it is along the line."""
    across = np.array([other[1] - one[1], one[0] - other[0]])
    return float(across @ one / (across @ ray)) if across @ ray > 0 else np.inf
