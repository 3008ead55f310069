"""The probability that a contact can stop slipping, if its friction and its loads are random.

FORM (the first-order reliability method): each input is a function of standard normal numbers u.
The design point is the point nearest to u = 0 at which the limit equals the load. It is found with
the rates of the limit. If the limit is replaced by its tangent plane there, the probability is
Phi(|u|), or Phi(-|u|) if the load is above the limit at u = 0. A sample of limits corrects this
value: the plane is a control variate, so that only draws that the plane gets wrong matter. Hasofer
and Lind (1974), Rackwitz and Fiessler (1978).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy  # its parts are imported when they are used
from scipy.linalg import block_diag

from ..base import (
    Array,
    Booleans,
    Kept,
    checked_cases,
    distribution,
    finite_number,
    frozen,
    is_distribution,
    progress_bar,
    shown,
    whole_number,
)
from ..base.checks import LARGEST_SEED, is_named
from ..contact import LoadCycle
from ..errors import ModelError
from .answers.shakedown_answer import ShakedownAnswer

AskLimit = Callable[[LoadCycle, Array], ShakedownAnswer]
"""Returns the limit for a load cycle and a friction, with the open nodes of the given limit."""
Stops = Callable[[ShakedownAnswer, float], bool]
"""Returns whether slip stops at a load factor, with the input of a limit."""
_LOAD = "the load factor"
# Two points with a smaller distance, in standard deviations, count as one.
_SAME = 1e-3
# Largest distance of a point from u = 0. Beyond 8, rounding makes a normal number infinite.
_FARTHEST = 7.0
# Largest number of limits in the search for the design point; about five are usual.
_MOST = 50


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownProbability(Kept):
    """The probability that slip stops from some start, see `ShakedownLimit.probability`.

    Attributes
    ----------
    probability, method
        The probability by FORM, corrected by the sample, and its method in words.
    standard_error
        Standard error of the probability.
    form, sampled
        The probability by FORM alone (NaN if no design point is found), and by the sample alone.
    importance
        Random input -> its share in the variance of the limit at the design point; empty without
        such a point.
    limits
        (draws,) limits of the sample.
    assembled
        The probability that slip stops from no slip; None if not requested. Its field `form` is
        still the probability for some start.

    Examples
    --------
    >>> import frictopt as fo
    >>> from scipy.stats import norm
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.8}, {"force": -0.8}])
    >>> limit = fo.shakedown_limit(rod, cycle, friction=0.5)
    >>> limit.probability(friction=norm(0.4, 0.1), draws=20).limits.shape
    (20,)
    """

    _shown_names = ("probability", "standard_error", "form", "sampled", "method")
    probability: float
    standard_error: float
    form: float
    sampled: float
    method: str
    importance: dict[str, float] = field(repr=False)
    limits: Array = field(repr=False)
    assembled: ShakedownProbability | None = field(default=None, repr=False)


class RandomLimit:
    """The limit and the load factor as functions of standard normal numbers.

    Nodes are open and closed as in the given limit, because a search for better sets takes long.
    ModelError if no input is random.
    """

    def __init__(
        self,
        limit: ShakedownAnswer,
        ask: AskLimit,
        friction: Any,
        preload: Any,
        load: Any,
        correlation_length: Any,
    ) -> None:
        self.limit = limit
        self._ask = ask
        self.load = load
        self.names = list[str]()  # of the input of each normal number
        self.mixing = np.zeros((0, 0))
        self._values = list[tuple[Any, int | str]]()  # law, and node, load case or `_LOAD`
        if friction is not None:
            self._add_friction(friction, correlation_length)
        for case, law in checked_cases("preload", preload or {}, "distribution").items():
            if case not in limit.cycle.mean:
                raise ModelError(f"preload[{case!r}]: the mean load has no such load case")
            self._add(case, law, [case], np.ones((1, 1)))
        if is_distribution(load):
            self._add(_LOAD, load, [_LOAD], np.ones((1, 1)))
        else:
            finite_number("load", load, least=0.0)
        if not self.names:
            raise ModelError(
                "friction, preload, load: none is a distribution of scipy.stats; give one"
            )

    def _add(self, name: str, law: Any, places: list[Any], mixing: Array) -> None:
        """Add an input with a value at each place; `mixing` correlates the values."""
        distribution(name, law)
        self.names += [name] * mixing.shape[1]
        self.mixing = block_diag(self.mixing, mixing)
        self._values += [(law, place) for place in places]

    def _add_friction(self, friction: Any, correlation_length: Any) -> None:
        """Add the friction of all nodes, or of each contact; a field if a length is given."""
        system = self.limit.system
        named = is_named(friction)
        laws = dict(friction) if named else {"friction": friction}
        faces = np.array([] if system.contact is None else system.contact)
        for name, law in laws.items():
            nodes = np.flatnonzero(faces == name) if named else np.arange(system.nodes)
            if not len(nodes):
                known = sorted(set(faces.tolist()))
                raise ModelError(f"friction: {shown(name)} is not one of the contacts {known}")
            mixing = np.ones((len(nodes), 1))
            if correlation_length is not None:
                length = finite_number("correlation_length", correlation_length, least=0.0)
                points = system.points[nodes]
                distance = np.linalg.norm(points[:, None] - points, axis=-1)
                # Rounding must not make the matrix indefinite. A length of 0 must not divide by 0.
                correlation = np.exp(-distance / max(length, 1e-300)) + 1e-9 * np.eye(len(nodes))
                mixing = np.linalg.cholesky(correlation)
            self._add(f"friction of {name}" if named else name, law, list(nodes), mixing)

    def at(self, u: Array) -> tuple[ShakedownAnswer, float, Array]:
        """The limit and the load factor at the numbers u, and the derivatives of the inputs."""
        normal = self.mixing @ u
        density = np.exp(-(normal**2) / 2) / np.sqrt(2 * np.pi)
        friction = self.limit.friction.copy()
        inputs = {**self.limit.cycle.mean, _LOAD: self.load}
        slopes = np.empty_like(normal)
        for k, (law, place) in enumerate(self._values):
            value = float(law.ppf(scipy.special.ndtr(normal[k])))
            slopes[k] = density[k] / law.pdf(value)
            if isinstance(place, str):
                inputs[place] = value
            else:
                friction[place] = max(value, 0.0)
        load = inputs.pop(_LOAD)
        cycle = replace(self.limit.cycle, mean=inputs)
        return self._ask(cycle, friction), load, slopes

    def derivative(self, limit: ShakedownAnswer, slopes: Array) -> Array:
        """The derivative of `limit - load factor` with respect to u."""
        mean = limit.load_rates.query("part == 'mean'").set_index("load")["rate"]
        rates: dict[Any, float] = {_LOAD: -1.0, **mean, **dict(enumerate(limit.friction_rate))}
        return np.array([rates[place] for _, place in self._values] * slopes) @ self.mixing

    def design_point(self) -> tuple[float, Array] | None:
        """The margin at u = 0 in standard deviations, and the unit vector along which it grows.

        The margin is negative if the load is above the limit at u = 0. The result is None if no
        design point is found.
        """
        u = np.zeros(len(self.names))
        for _ in range(_MOST):
            limit, load, slopes = self.at(u)
            derivative = self.derivative(limit, slopes)
            size = float(np.linalg.norm(derivative))
            margin = limit.load_factor - load
            if not (size > 0 and np.isfinite(margin)):
                return None
            distance = float(margin - derivative @ u) / size
            # On the plane through the limit here, this is the point nearest to u = 0.
            nearest = -np.clip(distance, -_FARTHEST, _FARTHEST) * derivative / size
            if np.linalg.norm(nearest - u) <= _SAME:
                return distance, derivative / size
            u = nearest
        return None


def probability_of(
    random: RandomLimit, stops: Stops | None, draws: Any, seed: Any
) -> ShakedownProbability:
    """The probability that the load factor has a safe slip, by FORM and by a sample.

    With `stops`, also the probability that slip stops; the same plane is its control variate.
    """
    draws = whole_number("draws", draws, least=10)
    seed = whole_number("seed", seed, least=0, most=LARGEST_SEED)
    numbers = np.random.default_rng(seed).standard_normal((draws, len(random.names)))
    design = random.design_point()
    limits, safe, stopped = _by_sample(random, numbers, stops)
    form = np.nan
    importance = dict[str, float]()
    on_plane = np.zeros(draws)
    by_form = ""
    if design is not None:
        distance, direction = design
        form = float(scipy.special.ndtr(distance))
        on_plane = distance + numbers @ direction >= 0
        by_form = f"by FORM ({form:.3g}), corrected "
        for name, share in zip(random.names, direction**2, strict=True):
            importance[name] = importance.get(name, 0.0) + float(share)

    def corrected(outcomes: Booleans, way: str) -> ShakedownProbability:
        missed = outcomes - 1.0 * on_plane
        probability = float(np.clip(np.nan_to_num(form) + missed.mean(), 0.0, 1.0))
        # One draw more is counted as misjudged by FORM, so that the error is above 0.
        variance = (np.abs(missed).sum() + 1) / (draws + 2) - missed.mean() ** 2
        error = float(np.sqrt(variance / draws))
        method = f"{by_form}by {draws} {way}; standard error {error:.2g}"
        sampled = float(outcomes.mean())
        return ShakedownProbability(probability, error, form, sampled, method, importance, limits)

    answer = corrected(safe, "draws")
    if stops is None:
        return answer
    return replace(
        answer, assembled=corrected(stopped, "steady states from no slip (FORM: some start)")
    )


def _by_sample(
    random: RandomLimit, numbers: Array, stops: Stops | None
) -> tuple[Array, Booleans, Booleans]:
    """The limits of a sample, and whether a slip is safe in each draw.

    With `stops`, also whether slip stops in each draw.
    """
    limits = list[float]()
    safe = list[bool]()
    stopped = list[bool]()
    with progress_bar(True, "probability", "draw", total=len(numbers)) as bar:
        for u in numbers:
            drawn, factor, _ = random.at(u)
            limits.append(drawn.load_factor)
            safe.append(bool(drawn.least <= factor <= drawn.load_factor))
            if stops is not None:
                stopped.append(stops(drawn, factor))
            bar.update()
    return frozen(limits), np.array(safe), np.array(stopped)
