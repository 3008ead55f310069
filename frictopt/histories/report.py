"""What there is to know of a joint under its loads, in one call: every number with what it means and whether it settles with the mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..contact import ROUNDING, Booleans, ContactSystem, LoadCycle, bar_of, checked_cycle, checked_system, friction_coefficients
from ..contact.checks import warns_of_odd_values
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import ShakedownLimit, gross_slip, guaranteed_limit, required_friction, shakedown_limit
from ..transients.march import mean_state
from .backbone import Asked, rising_factors, with_compliance
from .report_result import Report

LOAD_FACTORS = (0.25, 0.5, 1.0, 2.0)
"""Load factors of the curve, unless others are asked for; scaled down where the contact slides off before the last one."""

_BELOW = 0.95  # share of the gross-slip load up to which the curve goes: nearer to it many cycles pass before the slip is steady
_STEPS = 2  # increments from corner to corner in space
_PARTS = {  # as they are called -> attribute of the report
    "mean load": "mean_state",
    "gross-slip load": "gross_slip",
    "curve": "curve",
    "shakedown limit": "limit",
    "guaranteed limit": "guaranteed",
    "required friction": "required",
}
_SEARCHED = "not asked, for with open nodes in space its search takes minutes: call `fo.{}` yourself"


@warns_of_odd_values
def report(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factors: ArrayLike | None = None,
    *,
    steps: int | None = None,
    progress: bool = True,
) -> Report:
    """All that frictopt has to say of a joint under its loads, the user's load being that of load factor 1.

    Its parts are: the nodes that the mean load leaves open; the load at which bodies slide off (`gross_slip`); what grows with the load, from no slip
    (`backbone_curve`), with the steady state at load factor 1; shakedown and guaranteed limit; the friction that would keep the contact stuck
    (`required_friction`); and advice. A part without an answer stands there with the reason. Where the mean load leaves nodes open in space, the
    shakedown limit is that with these nodes open, and guaranteed limit and required friction are left out, for they search for minutes: ask
    `shakedown_limit`, `guaranteed_limit` and `required_friction` themselves. These two do not know a shear strength.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factors
        (K,) load factors of the curve, > 0 and rising, to which 1 is added; None: 1/4, 1/2, 1 and 2, or less, where 2 is above 95 % of the
        gross-slip load.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 2 in space, whose `step_error` says what they leave), and
        whether to show a bar after two seconds. Ctrl-C stays a KeyboardInterrupt with an attribute `report`, which holds what is known by then.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    >>> joint = fo.report(punch, fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}]), friction=0.9, load_factors=[0.5, 1.5])
    >>> print(joint.advice[0])
    From assembly without slip the contact stops slipping at your load.
    """
    f = np.array(friction_coefficients(friction, checked_system(system).nodes))
    checked_cycle(cycle).corner_reactions(system)  # says which load case is unknown
    in_space = system.tangents == 2
    steps = _STEPS if steps is None and in_space else steps
    factors = None if load_factors is None else rising_factors(load_factors)
    found, missing, at = dict[str, Any](), dict[str, str](), ""

    def ask(part: str, question: Callable[[], Any]) -> Any:
        """The answer, kept; None where there is no such state, or no proof of one."""
        nonlocal at
        at = part
        try:
            found[_PARTS[part]] = answer = question()
        except (NoContinuation, SolverError) as error:
            missing[part], answer = str(error), None
        bar.update()
        return answer

    def limit_of(opened: Booleans) -> ShakedownLimit:
        """The limit with these nodes open."""
        try:
            return shakedown_limit(system, cycle, f, open=opened)
        except ModelError as error:  # the closed nodes do not hold the open ones
            raise NoContinuation(str(error)) from error

    def kept(_: object) -> tuple[str, Report, str]:
        left = [part for part, name in _PARTS.items() if name not in found and part not in missing]
        known = Report(system, cycle, f, missing | dict.fromkeys(left, "interrupted"), **found)
        return "report", known, f"what is known by then is the attribute `report`, without {', '.join(left)}"

    with bar_of(progress, "report", "part", total=len(_PARTS), best=lambda: at, keeps=kept) as bar:
        mean = ask("mean load", lambda: mean_state(system, cycle, f))
        slides = ask("gross-slip load", lambda: gross_slip(system, cycle, f))
        most = np.inf if slides is None else slides.load_factor
        if factors is None:
            factors = (min(1.0, _BELOW * most / LOAD_FACTORS[-1]) if most > 0 else 1.0) * np.array(LOAD_FACTORS)
        rests = 1 <= most * (1 + ROUNDING)
        joint, load = with_compliance(system, cycle, f, None)
        asked = Asked(joint, cycle, f, load, slides or SolverError(missing["gross-slip load"]), None, steps)
        curve = ask("curve", lambda: asked.followed(np.union1d(factors, [1.0] * rests), True))
        if curve and rests and not any(steady and steady.load_factor == 1 for steady in curve.steady_states):
            missing["steady state at load factor 1"] = curve.note
        opened = in_space and mean is not None and bool(mean.open.any())
        ask("shakedown limit", lambda: limit_of(mean.open) if opened else shakedown_limit(system, cycle, f))
        if opened:
            missing |= {part: _SEARCHED.format(part.replace(" ", "_")) for part in ("guaranteed limit", "required friction")}
        elif system.capped:
            missing |= dict.fromkeys(("guaranteed limit", "required friction"), "not known of a surface with a shear strength")
        else:
            ask("guaranteed limit", lambda: guaranteed_limit(system, cycle, f))
            ask("required friction", lambda: required_friction(system, cycle, 1.0))
    if curve:
        limits = {name: found[of].load_factor for name, of in (("shakedown_limit", "limit"), ("guaranteed_limit", "guaranteed")) if of in found}
        found["curve"] = replace(curve, **limits)
    return Report(system, cycle, f, missing, **found)
