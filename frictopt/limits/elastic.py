"""The slips of the closed nodes of a contact as unknowns: residual shear forces, free slides."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..base import CONDENSATION, Array, Integers, unresisted
from ..contact import ContactSystem
from .question import Question


class Elastic(NamedTuple):
    """The closed nodes of a question: what resists their slips, and what does not."""

    closed: Integers
    slips: Integers  # (c,) entries of their slips among those of all nodes
    slides: Array  # (c, k) slips that nothing resists
    compliance: Array  # (c, c) of all other slips
    normal: Array  # (N, c) normal forces, or gaps of open nodes, by residual shear forces
    opening: Array  # (N, k) gaps of open nodes by slides


# The elastic data of the closed contact, and of the open nodes that were asked last, by system.
_ELASTIC: WeakKeyDictionary[ContactSystem, dict[bytes, Elastic]] = WeakKeyDictionary()


def elastic(question: Question) -> Elastic:
    """See `Elastic`. It is computed once for the closed contact and the open nodes asked last."""
    known = _ELASTIC.setdefault(question.system, {})
    key = b"" if question.compliance is None else question.open_nodes.tobytes()
    if key in known:
        return known[key]
    system = question.system
    n, t = system.nodes, system.tangents
    # The arrays of moving areas are those of the closed contact, whichever nodes never press.
    opened = question.open_nodes if question.compliance is not None else np.zeros(n, dtype=bool)
    closed = np.flatnonzero(~opened)
    slips = np.concatenate([closed + axis * n for axis in range(t)])
    sizes = system.own_stiffness
    normal = question.response[-n:, slips]
    square = question.response[np.ix_(slips, slips)]
    pressing = np.where(opened, 0.0, 1 / np.sqrt(sizes[-n:]))[:, None] * normal
    slides, compliance = unresisted(square, sizes[slips], pressing)
    opening = normal @ slides
    unmoved = np.abs(opening) <= CONDENSATION * np.abs(slides).max(axis=0, initial=0.0)
    opening[unmoved | ~opened[:, None]] = 0.0
    for other in [other for other in known if other]:
        del known[other]
    known[key] = Elastic(closed, slips, slides, compliance, normal @ compliance, opening)
    return known[key]


def is_held(question: Question) -> bool:
    """Whether every slip meets a resistance: supports hold the bodies along the contact."""
    return not elastic(question).slides.size


def slip_units(question: Question) -> Array:
    """(t N,) units of the slips."""
    shear = np.tile(question.shear_unit, question.system.tangents)
    return np.asarray(shear / question.system.own_stiffness[: len(shear)])


class SlipUnknowns:
    """The unknowns of the slip of a state of rest, each in its unit.

    They are the residual shear forces of the closed nodes, which do no work on slides that nothing
    resists, and these slides.

    Parameters
    ----------
    question
        The closed nodes, their stiffness, and the units.
    with_slides
        Whether rows depend on the slides. Without them the slip has none.
    start
        (M,) forces without slip. The slip is counted from the reference that takes their shear
        away: with little friction all safe slips are close to it, and small differences keep their
        digits. None: it is counted from zero, because rows contain the slip, and the reference may
        be far larger than it.
    first
        Number of unknowns of the solver before these.
    """

    def __init__(
        self, question: Question, with_slides: bool, start: Array | None, first: int
    ) -> None:
        self.question = question
        self.elastic = elastic(question)
        slips = self.elastic.slips
        self.shear_units = question.shear_unit[slips % question.system.nodes]
        slides = self.elastic.slides
        if not (with_slides or self.elastic.opening.any()):
            slides = slides[:, :0]
        stiffness = question.system.own_stiffness[slips]
        self.slide_units = question.force / (stiffness @ slides**2)
        self.slides = slides * self.slide_units
        self.shear = slice(first, first + len(slips))
        self.slide = slice(self.shear.stop, self.shear.stop + len(self.slide_units))
        self.reference = np.zeros(question.response.shape[1])
        if start is not None:
            self.reference[slips] = -self.elastic.compliance @ start[slips]

    def slip_of(self, x: Array) -> Array:
        """(t N,) slip of the closed nodes from the reference on, from the solver's unknowns."""
        slip = np.zeros(len(self.reference))
        by_shear = self.elastic.compliance @ (self.shear_units * x[self.shear])
        slip[self.elastic.slips] = by_shear + self.slides @ x[self.slide]
        return slip

    def part(self, by_shear: Array, by_slides: Array, width: int) -> Array:
        """Quantities as functions of all unknowns, from their rates with shear and with slides."""
        part = np.zeros((len(by_shear), width))
        part[:, self.shear] = by_shear * self.shear_units
        part[:, self.slide] = by_slides
        return part

    def of_response(self, response: Array, width: int) -> Array:
        """Forces (M,) due to unit slips as functions of all unknowns."""
        of_slips = response[:, self.elastic.slips]
        return self.part(of_slips @ self.elastic.compliance, of_slips @ self.slides, width)

    def normal(self, width: int) -> Array:
        """(N,) normal forces, or gaps of open nodes, as functions of all unknowns."""
        opening = self.elastic.opening[:, : len(self.slide_units)] * self.slide_units
        return self.part(self.elastic.normal, opening, width)

    def slip(self, width: int) -> Array:
        """(c,) slips of the closed nodes as functions of all unknowns."""
        return self.part(self.elastic.compliance, self.slides, width)

    def rates_of(self, stress: Array) -> tuple[Array, Array]:
        """The rates (c,) and (k,) with the unknowns of what has the rates (t N,) with the slip."""
        of_slips = stress[self.elastic.slips]
        return self.shear_units * (self.elastic.compliance @ of_slips), self.slides.T @ of_slips

    @property
    def equations(self) -> Array:
        """(k, c) the shear forces do no work on any slide, of which each has a row."""
        relative = self.shear_units / self.shear_units.max(initial=0.0)
        return np.asarray(self.elastic.slides.T * relative)
