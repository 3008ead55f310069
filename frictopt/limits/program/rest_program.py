"""The programs of states of rest as arrays, for answers, searches and user constraints.

A program has quantities, in the units of the user and in this order::

    forces      (K, M) at the instants: q by component, then p, or the gap w of an open node
    named       the load factor, a margin, preloads and other unknowns of a question
    slip        (t N,) of the closed nodes, by component
    own         unknowns of the rows of the user

A row `weights @ quantities + constant` is zero, or at least zero, or a part of a cone. The forces
are the forces without slip, plus the effects of the named unknowns, plus the response to the slip::

    forces_k = start_k + effects_k named + response slip

The solver has other unknowns x: the named ones, the residual shear forces of the closed nodes, the
slides that nothing resists (`SlipUnknowns`), and the own ones. Each is divided by its unit. A
residual shear force is then one entry of x. The rest of the response is one dense block for all
instants. `Solution` turns an answer back into quantities. It proves the bound from the stiffness
and the loads, without the solver and without the unknowns x. `printed/models.py` lists most
programs for readers and users; `assembled.py` has the table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from scipy.sparse import csr_array

from ...base import CONDENSATION, Array, Integers, unresisted
from ...contact import ContactProducts, ContactSystem
from ...solve.arrays import EQUATION, LINEAR, Arrays, Rows, Stacked, Term, rows_of, stacked
from .question import Question


class Elastic(NamedTuple):
    """The closed nodes of a question: which of their slips meet a resistance, and which do not."""

    slips: Integers  # (c,) entries of their slips among the slips of all nodes
    slides: Array  # (c, k) slips that nothing resists
    compliance: Array  # (c, c) of the slips that meet a resistance
    normal: Array  # (N, c) normal forces, or gaps of open nodes, due to unit residual shear forces
    opening: Array  # (N, k) gaps of open nodes due to unit slides


# The elastic data of the closed contact, and of the last set of open nodes, by system.
_ELASTIC: WeakKeyDictionary[ContactSystem, dict[bytes, Elastic]] = WeakKeyDictionary()


def elastic(question: Question) -> Elastic:
    """See `Elastic`. The data of the closed contact and of the last set of open nodes are kept."""
    known = _ELASTIC.setdefault(question.system, {})
    key = b"" if question.compliance is None else question.open_nodes.tobytes()
    if key in known:
        return known[key]
    system = question.system
    n, t = system.nodes, system.tangents
    if isinstance(system, ContactProducts):
        return Elastic(
            np.arange(t * n),
            system.slides,
            system.slipping,
            system.pressing,
            opening=np.zeros((n, system.slides.shape[1])),
        )
    # `MovingAreas` has no compliance: its arrays belong to the closed contact, even if some nodes
    # never touch.
    opened = question.open_nodes if question.compliance is not None else np.zeros(n, dtype=bool)
    slips = np.flatnonzero(np.tile(~opened, t))
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
    known[key] = Elastic(slips, slides, compliance, normal @ compliance, opening)
    return known[key]


def is_held(question: Question) -> bool:
    """Whether every slip meets a resistance: supports hold the bodies along the contact."""
    return not elastic(question).slides.size


def slip_units(question: Question) -> Array:
    """(t N,) units of the slips."""
    shear = np.tile(question.shear_unit, question.system.tangents)
    return shear / question.system.own_stiffness[: len(shear)]


class SlipUnknowns:
    """The unknowns of the slip of a state of rest, each in its unit.

    They are the slides that nothing resists, and the residual shear forces of the closed nodes,
    which do no work on these slides.

    Parameters
    ----------
    question
        The closed nodes, their stiffness, and the units.
    with_slides
        Whether rows depend on the slides. If not, a slide is an unknown only if it changes gaps.
    start
        (M,) forces without slip. The slip is counted from a reference slip that takes the shear of
        these forces away: with little friction all safe slips are close to the reference, and small
        differences keep their digits. None: the slip is counted from zero, because rows contain it,
        and the reference may be far larger than the slip.
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
        """(t N,) slip of the closed nodes beyond the reference, from the solver's unknowns."""
        slip = np.zeros(len(self.reference))
        by_shear = self.elastic.compliance @ (self.shear_units * x[self.shear])
        slip[self.elastic.slips] = by_shear + self.slides @ x[self.slide]
        return slip

    def part(self, by_shear: Array, by_slides: Array, width: int) -> Array:
        """(n, width) coefficients of n quantities for all unknowns of the solver.

        They follow from the rates of the quantities with the residual shear forces (n, c) and with
        the slides (n, k). The `width` is the number of unknowns; other unknowns have zeros.
        """
        part = np.zeros((len(by_shear), width))
        part[:, self.shear] = by_shear * self.shear_units
        part[:, self.slide] = by_slides
        return part

    def rates_of(self, stress: Array) -> tuple[Array, Array]:
        """The rates of a quantity with the unknowns, (c,) and (k,).

        `stress` (t N,) are its rates with the slip.
        """
        of_slips = stress[self.elastic.slips]
        return self.shear_units * (self.elastic.compliance @ of_slips), self.slides.T @ of_slips


NO_UNKNOWNS = np.zeros(0)
NO_NUMBERS = np.zeros(0, dtype=int)

# Label of the rows of the user.
USER = "user"


class Place(NamedTuple):
    """Where the goal is: its column of x, and its unit."""

    column: int
    unit: float


class Form(NamedTuple):
    """A program in the unknowns of the solver."""

    slips: list[SlipUnknowns]
    stacked: Stacked  # all rows, in the order of the solver
    origin: Array  # (Q,) the quantities if all unknowns are zero
    slides: int  # number of equations of slides, which are the first rows of the arrays
    arrays: Arrays  # without a cost


class RestProgram:
    """The program of states of rest, without rows at first.

    Parameters
    ----------
    questions
        For each slip: its closed nodes, their stiffness, and its units. Scenarios of a design have
        a slip each; otherwise there is one.
    units
        Name -> unit, one number or (n,), of the named unknowns. The first one is the `goal`, whose
        largest or least value is sought, until another goal or an objective of the user is set.
    start
        (K, M) forces at the instants without slip, if all named unknowns are 0.
    effects
        Name -> (K, M, n) or (K, M) forces that a named unknown adds for each unit.
    slip_of
        (K,) index of the slip at each instant; None: the first.
    responses
        Further forces (M, t N) due to unit slips of the first question, for instants with other
        open nodes; and (K,) the index of the response at each instant.
    """

    def __init__(
        self,
        questions: Sequence[Question],
        units: Mapping[str, Any],
        start: Array,
        effects: Mapping[str, Array],
        *,
        slip_of: Integers | None = None,
        responses: tuple[Sequence[Array], Integers] = ((), NO_NUMBERS),
    ) -> None:
        self.questions = questions
        self.question = questions[0]
        self.rows = list[Rows]()
        count, entries = start.shape
        self.start = start
        # The responses, beginning with one for each question, and the index of the slip of each
        # response.
        more, response_of = responses
        self.responses = [*(question.response for question in questions), *more]
        self.slips_of = [*range(len(questions)), *([0] * len(more))]
        self.response_of = np.zeros(count, dtype=int) if slip_of is None else slip_of
        if len(more):
            self.response_of = len(questions) + response_of

        self.named = dict[str, slice]()
        end = 0
        for name, unit in units.items():
            self.named[name] = slice(end, end + np.size(unit))
            end += np.size(unit)
        self.goal = next(iter(units), "")
        self.named_units = np.concatenate([NO_UNKNOWNS, *map(np.ravel, units.values())])
        self.effects = np.zeros((count * entries, end))
        for name, effect in effects.items():
            self.effects[:, self.named[name]] = effect.reshape(count * entries, -1)

        # The rows of the user, and the units of their own unknowns.
        self.user: Any = None
        self.own_units = NO_UNKNOWNS
        self.first_named = count * entries
        self.first_slip = self.first_named + end
        slips = self.question.system.tangents * self.question.system.nodes
        self.first_own = self.first_slip + len(questions) * slips

    @property
    def constraints(self) -> tuple[str, ...]:
        """Names of the rows of the user, and "objective" if they have one."""
        return () if self.user is None else self.user.of.names

    def force(self, instants: Integers | int, entries: Integers) -> Integers:
        """Numbers of the quantities that are the forces of these entries at instants."""
        return np.asarray(instants * self.start.shape[1] + entries)

    def unknown(self, name: str) -> int:
        """Number of the quantity that is a named unknown."""
        return int(self.first_named + self.named[name].start)

    def row(self, label: str, weights: Mapping[str, float | Array], constant: float = 0.0) -> None:
        """Add a row `sum of weights * unknowns + constant >= 0`, in the unit of the first unknown.

        A weight is one number, or an array with a number for each entry of its named unknown.
        """
        terms = list[Term]()
        for name, of_entries in weights.items():
            each = np.atleast_1d(of_entries)
            terms += [(self.unknown(name) + np.array([j]), each[[j]]) for j in range(len(each))]
        unit = self.named_units[terms[0][0] - self.first_named]
        self.add(label, LINEAR, [terms], np.array([constant]), unit)

    def add(self, *row: Any) -> None:
        """Add rows, see `rows_of`."""
        self.rows.append(rows_of(*row))

    def no_force(
        self, label: str, axis: int, instants: Integers, nodes: Integers, unit: Array
    ) -> None:
        """Add equations: nodes have no force along an axis at instants; `unit` (N,)."""
        entries = axis * self.question.system.nodes + nodes
        force = self.force(instants, entries), np.ones(len(nodes))
        self.add(label, EQUATION, [[force]], np.zeros(len(nodes)), unit[nodes], instants, nodes)

    @cached_property
    def form(self) -> Form:
        """The program in the unknowns of the solver, once it has all its rows."""
        return _form(self)

    @property
    def place(self) -> Place:
        """Where the goal is; the objective of the user is the first of the own unknowns."""
        if self.goal in self.named:
            number = self.named[self.goal].start
            return Place(number, float(self.named_units[number]))
        return Place(self.form.slips[-1].slide.stop, float(self.own_units[0]))

    def arrays(self, sense: float = 1.0) -> Arrays:
        """The program that maximises (sense 1) or minimises (sense -1) the goal."""
        arrays = self.form.arrays
        cost = np.zeros(len(arrays.cost))
        cost[self.place.column] = -sense
        return replace(arrays, cost=cost)

    def violation(self, x: Array, ray: bool = False, label: str | None = None) -> float:
        """Largest violation of a row by the unknowns x, relative to the terms of the row.

        `label`: only rows with this label count. `ray`: x is a direction, and a violation counts
        only as far as rounding of the stiffness does not explain it.
        """
        _, units, at, quantities, weights, constants, *_ = self.form.stacked
        count = len(constants)
        values, sizes = self.quantities(x, ray)
        each = weights * values[quantities]
        terms = np.bincount(at, np.abs(each), count).astype(float)
        slack = np.bincount(at, each, count).astype(float)
        rounding = np.zeros(count)
        if ray:
            rounding += CONDENSATION * np.bincount(at, np.abs(weights * sizes[quantities]), count)
        else:
            slack += constants
            terms += np.abs(constants) + units
        off = 0.0
        for rows, part in self.form.stacked.parts:
            if label not in (None, rows.label):
                continue
            for size in np.unique(rows.sizes):
                heads = (np.cumsum(rows.sizes) - rows.sizes)[rows.sizes == size]
                entries = heads[:, None] + np.arange(size)
                s, scale, rounded = (v[part][entries] for v in (slack, terms, rounding))
                outside = np.linalg.norm(s[:, 1:], axis=1) - s[:, 0]
                if rows.kind == EQUATION:
                    outside = np.abs(s[:, 0])
                scale, rounded = scale.sum(axis=1), rounded.sum(axis=1)
                share = (outside - rounded) / np.where(scale > 0, scale, 1.0)
                off = max(off, float(share.max(initial=0.0)))
        return off

    def quantities(self, x: Array, ray: bool = False) -> tuple[Array, Array]:
        """(Q,) values of the quantities at x, and the sums of the sizes of their terms.

        They are computed from the slips by the stiffness, not by the arrays of the solver. `ray`: x
        is a direction, so that constants do not count.
        """
        named = self.named_units * x[: len(self.named_units)]
        slips = [slip.slip_of(x) for slip in self.form.slips]
        own = self.own_units * x[len(x) - len(self.own_units) :]
        shape = self.start.shape
        forces = (self.effects @ named).reshape(shape)
        sizes = (np.abs(self.effects) @ np.abs(named)).reshape(shape)
        for number, (response, of_slip) in enumerate(
            zip(self.responses, self.slips_of, strict=True)
        ):
            here = self.response_of == number
            forces[here] += response @ slips[of_slip]
            sizes[here] += np.abs(response) @ np.abs(slips[of_slip])
        values = np.concatenate([forces.ravel(), named, *slips, own])
        sizes = np.concatenate([sizes.ravel(), np.abs(values[self.first_named :])])
        if ray:
            return values, sizes
        return values + self.form.origin, sizes + np.abs(self.form.origin)


def _form(program: RestProgram) -> Form:
    """The program in the solver's unknowns: rows of quantities become rows of these unknowns."""
    rows = stacked(program.rows)
    _, units, at, quantities, weights, constants, zero, sizes = rows
    questions, responses = program.questions, program.responses

    # The unknowns: named unknowns, the unknowns of each slip, own unknowns.
    named = len(program.named_units)
    of_slip = (quantities >= program.first_slip) & (quantities < program.first_own)
    has_slip = bool(of_slip.any())
    slips = list[SlipUnknowns]()
    end = named
    for number, question in enumerate(questions):
        start = program.start[(program.response_of == number).argmax()]
        with_slides = has_slip or len(responses) > len(questions)
        slips.append(SlipUnknowns(question, with_slides, None if has_slip else start, end))
        end = slips[-1].slide.stop
    width = end + len(program.own_units)

    # The quantities if all unknowns are zero: the slips are then the reference slips.
    references = [slip.reference for slip in slips]
    shift = [
        response @ references[number]
        for response, number in zip(responses, program.slips_of, strict=True)
    ]
    origin = np.concatenate(
        [
            (program.start + np.array(shift)[program.response_of]).ravel(),
            np.zeros(named),
            *references,
            np.zeros(len(program.own_units)),
        ]
    )

    # Shear forces do no work on any slide. These equations come first.
    entries = list[tuple[Array, Integers, Integers]]()  # values, rows, columns
    slides = 0
    for slip in slips:
        work = slip.elastic.slides.T * (slip.shear_units / slip.shear_units.max(initial=0.0))
        of_slide, of_shear = np.nonzero(work)
        columns = slip.shear.start + of_shear
        entries.append((work[of_slide, of_shear], slides + of_slide, columns))
        slides += len(work)

    # A quantity is an entry of [x, block @ x]. A force also has the effects of the named unknowns.
    block, places, scales = _block(program, slips, width, has_slip)
    weights = weights / units[at]
    entries.append((-weights * scales[quantities], slides + at, places[quantities]))
    forces = quantities < program.first_named
    effects = program.effects[quantities[forces]] * weights[forces, None]
    of_entry, of_named = np.nonzero(effects)
    effect = effects[of_entry, of_named] * program.named_units[of_named]
    entries.append((-effect, slides + at[forces][of_entry], of_named))

    right = constants / units + np.bincount(at, weights * origin[quantities], len(units))
    values, at_row, at_column = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    shape = slides + len(units), width + len(block)
    arrays = Arrays(
        sparse=csr_array((values, (at_row, at_column)), shape=shape),
        block=block,
        right=np.concatenate([np.zeros(slides), right]),
        cost=np.zeros(width),
        zero=slides + zero,
        sizes=sizes,
    )
    return Form(slips, rows, origin, slides, arrays)


def _block(
    program: RestProgram, slips: Sequence[SlipUnknowns], width: int, has_slip: bool
) -> tuple[Array, Integers, Array]:
    """The dense block, and for each quantity its entry of [x, block @ x] and its unit there."""
    entries = program.start.shape[1]
    n = program.question.system.nodes
    parts = list[Array]()
    end = width

    # Normal forces and gaps are in the block, and for further responses also the shear forces.
    places = np.zeros((len(program.responses), entries), dtype=int)
    scales = np.zeros((len(program.responses), entries))
    for number, response in enumerate(program.responses):
        slip = slips[program.slips_of[number]]
        closed = slip.elastic
        if number < len(slips):
            # The shear forces are unknowns themselves.
            places[number, closed.slips] = np.arange(slip.shear.start, slip.shear.stop)
            scales[number, closed.slips] = slip.shear_units
            opening = closed.opening[:, : len(slip.slide_units)] * slip.slide_units
            parts.append(slip.part(closed.normal, opening, width))
        else:
            by_slip = response[:, closed.slips]
            parts.append(slip.part(by_slip @ closed.compliance, by_slip @ slip.slides, width))
        dense = np.arange(entries - len(parts[-1]), entries)
        places[number, dense] = end + np.arange(len(dense))
        scales[number, dense] = 1.0
        end += len(dense)

    # The slips are in the block, too, if rows contain them.
    slip_places = np.zeros((len(slips), entries - n), dtype=int)
    slip_scales = np.zeros((len(slips), entries - n))
    for number, slip in enumerate(slips if has_slip else []):
        parts.append(slip.part(slip.elastic.compliance, slip.slides, width))
        slip_places[number, slip.elastic.slips] = end + np.arange(len(slip.elastic.slips))
        slip_scales[number, slip.elastic.slips] = 1.0
        end += len(slip.elastic.slips)

    named, own = program.named_units, program.own_units
    of_forces, of_named = places[program.response_of].ravel(), np.arange(len(named))
    of_own = np.arange(width - len(own), width)
    return (
        np.vstack(parts),
        np.concatenate([of_forces, of_named, slip_places.ravel(), of_own]),
        np.concatenate([scales[program.response_of].ravel(), named, slip_scales.ravel(), own]),
    )
