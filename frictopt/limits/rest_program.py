"""The programs of states of rest as arrays: one assembly for answers, searches and user rows.

A program has quantities, in the units of the user and in this order::

    forces      (K, M) at the instants: q by component, then p, or the gap w of an open node
    named       the load factor, a margin, preloads and other unknowns of a question
    slip        (t N,) of the closed nodes, by component
    own         unknowns of the rows of the user

A row `weights @ quantities + constant` is zero, or at least zero, or a part of a cone. Forces are
those without slip, plus the effects of the named unknowns, plus the response to the slip::

    forces_k = start_k + effects_k named + response slip

The solver has other unknowns x: the named ones, the residual shear forces of the closed nodes, the
slides that nothing resists, and own ones, each divided by its unit. In them q is one entry, and the
rest of the response is one dense block for all instants. `Solution` reads an answer back, and
proves its bound on the stiffness and the loads, without the solver and without these unknowns.
`models.py` lists the same programs for readers and for users.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ..base import CONDENSATION, Array, Integers
from ..solve.arrays import Arrays
from ..solve.rows import EQUATION, LINEAR, Rows, Stacked, Term, rows_of, stacked
from .elastic import SlipUnknowns
from .question import Question

NO_UNKNOWNS = np.zeros(0)
NO_NUMBERS = np.zeros(0, dtype=int)

# Label of the rows of the user.
USER = "user"


class Place(NamedTuple):
    """Where a named unknown is: its column of x, and its unit."""

    column: int
    unit: float


class RestProgram:
    """The program of states of rest, without rows at first.

    Parameters
    ----------
    questions
        For each slip: its closed nodes, their stiffness, and its units. Scenarios of a design have
        a slip each; otherwise there is one.
    units
        Name -> unit, one number or (n,), of the named unknowns.
    start
        (K, M) forces at the instants without slip, if all named unknowns are 0.
    effects
        Name -> (K, M, n) or (K, M) forces that a named unknown adds for each unit.
    slip_of
        (K,) number of the slip at each instant; None: the first.
    responses
        Further (M, t N) forces due to unit slips of the first question, at instants with other open
        nodes, and (K,) which of them belongs to each instant.
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
        # The responses, and the slip of each: first that of each question.
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

    def force(self, instants: Integers, entries: Integers) -> Integers:
        """Numbers of the quantities that are forces."""
        return np.asarray(instants * self.start.shape[1] + entries)

    def unknown(self, name: str) -> int:
        """Number of the quantity that is a named unknown."""
        return int(self.first_named + self.named[name].start)

    def row(self, label: str, weights: Mapping[str, float | Array], constant: float = 0.0) -> None:
        """Add a row `sum of weights * unknowns + constant >= 0`, in the unit of the first one.

        Weights are one number or those of all entries of a named unknown.
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

    @cached_property
    def of_slip(self) -> bool:
        """Whether a row contains the slip."""
        return any(
            ((rows.quantities >= self.first_slip) & (rows.quantities < self.first_own)).any()
            for rows in self.rows
        )

    @cached_property
    def slips(self) -> list[SlipUnknowns]:
        """The unknowns of the slips."""
        slips = list[SlipUnknowns]()
        first = len(self.named_units)
        for number, question in enumerate(self.questions):
            instant = int((self.response_of == number).argmax())
            start = None if self.of_slip else self.start[instant]
            with_slides = self.of_slip or len(self.responses) > len(self.questions)
            slips.append(SlipUnknowns(question, with_slides, start, first))
            first = slips[-1].slide.stop
        return slips

    @property
    def width(self) -> int:
        """The number of unknowns of the solver."""
        return self.slips[-1].slide.stop + len(self.own_units)

    @property
    def slides(self) -> int:
        """The number of equations of slides, which are the first rows of the arrays."""
        return sum(slip.elastic.slides.shape[1] for slip in self.slips)

    def slip_at(self, x: Array) -> Array:
        """(S t N,) slips of the closed nodes from the references on, from the unknowns x."""
        return np.concatenate([slip.slip_of(x) for slip in self.slips])

    @cached_property
    def stacked(self) -> Stacked:
        """All rows, in the order of the solver."""
        return stacked(self.rows)

    @cached_property
    def origin(self) -> Array:
        """(Q,) the quantities if all unknowns of the solver are zero."""
        references = [slip.reference for slip in self.slips]
        shift = [
            response @ references[of_slip]
            for response, of_slip in zip(self.responses, self.slips_of, strict=True)
        ]
        start = self.start + np.array(shift)[self.response_of]
        named = np.zeros(self.first_slip - self.first_named)
        own = np.zeros(len(self.own_units))
        return np.concatenate([start.ravel(), named, *references, own])

    def place(self, goal: str) -> Place:
        """Where a named unknown is; the objective of the user is the first of the own unknowns."""
        if goal in self.named:
            number = self.named[goal].start
            return Place(number, float(self.named_units[number]))
        return Place(self.slips[-1].slide.stop, float(self.own_units[0]))

    def arrays(self, goal: str, sense: float) -> Arrays:
        """The program that maximises (sense 1) or minimises (sense -1) a named unknown."""
        cost = np.zeros(self.width)
        cost[self.place(goal).column] = -sense
        return self.with_cost(cost)

    def with_cost(self, cost: Array) -> Arrays:
        """The program that minimises `cost @ x`."""
        block, columns, scales = self._parts()
        rows, units, at, quantities, weights, constants = self.stacked
        weights = weights / units[at]
        right = constants / units + np.bincount(at, weights * self.origin[quantities], len(units))
        forces = quantities < self.first_named
        effects = self.effects[quantities[forces]] * weights[forces, None]
        of_entry, of_named = np.nonzero(effects)
        by_named = effects[of_entry, of_named] * self.named_units[of_named]

        zero = self.slides
        entry_rows = [zero + at, zero + at[forces][of_entry]]
        entry_columns = [columns[quantities], of_named]
        values = [-weights * scales[quantities], -by_named]
        first = 0
        for slip in self.slips:
            of_slide, of_shear = np.nonzero(slip.equations)
            entry_rows.append(first + of_slide)
            entry_columns.append(slip.shear.start + of_shear)
            values.append(slip.equations[of_slide, of_shear])
            first += len(slip.equations)
        entries = np.concatenate(entry_rows), np.concatenate(entry_columns)
        shape = zero + len(units), len(cost) + len(block)
        return Arrays(
            sparse=csr_array((np.concatenate(values), entries), shape=shape),
            block=block,
            right=np.r_[np.zeros(zero), right],
            cost=cost,
            zero=zero + sum(len(part.constants) for part in rows if part.kind == EQUATION),
            sizes=np.concatenate([part.sizes for part in rows if part.kind != EQUATION]),
        )

    def _parts(self) -> tuple[Array, Integers, Array]:
        """The dense block, and for each quantity its entry of [x, block @ x] and its unit there."""
        width, entries = self.width, self.start.shape[1]
        n = self.question.system.nodes
        columns = np.zeros((len(self.responses), entries), dtype=int)
        scales = np.zeros((len(self.responses), entries))
        parts = list[Array]()
        end = width
        for number, (response, of_slip) in enumerate(
            zip(self.responses, self.slips_of, strict=True)
        ):
            slip = self.slips[of_slip]
            if number < len(self.slips):
                # The shear forces are unknowns themselves.
                columns[number, slip.elastic.slips] = np.arange(slip.shear.start, slip.shear.stop)
                scales[number, slip.elastic.slips] = slip.shear_units
                parts.append(slip.normal(width))
                dense = np.arange(entries - n, entries)
            else:
                parts.append(slip.of_response(response, width))
                dense = np.arange(entries)
            columns[number, dense] = end + np.arange(len(dense))
            scales[number, dense] = 1.0
            end += len(dense)

        slip_columns = np.zeros((len(self.slips), entries - n), dtype=int)
        slip_scales = np.zeros((len(self.slips), entries - n))
        for number, slip in enumerate(self.slips if self.of_slip else []):
            parts.append(slip.slip(width))
            slip_columns[number, slip.elastic.slips] = end + np.arange(len(slip.elastic.slips))
            slip_scales[number, slip.elastic.slips] = 1.0
            end += len(slip.elastic.slips)
        named = np.arange(len(self.named_units))
        own = np.arange(width - len(self.own_units), width)
        return (
            np.vstack(parts),
            np.r_[columns[self.response_of].ravel(), named, slip_columns.ravel(), own],
            np.r_[
                scales[self.response_of].ravel(),
                self.named_units,
                slip_scales.ravel(),
                self.own_units,
            ],
        )

    def violation(self, x: Array, ray: bool = False, label: str | None = None) -> float:
        """Largest violation of a row (with a label) by unknowns, relative to its terms.

        `ray`: by a direction, beyond what rounding of the stiffness explains.
        """
        _, units, at, quantities, weights, constants = self.stacked
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
        first = 0
        for rows in self.stacked.rows:
            part = slice(first, first := first + len(rows.constants))
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
        """(Q,) values of the quantities, and the sums of the sizes of their terms.

        The stiffness gives them, without the unknowns of the solver. `ray`: of a direction.
        """
        named = self.named_units * x[: len(self.named_units)]
        slips = [slip.slip_of(x) for slip in self.slips]
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
        return values + self.origin, sizes + np.abs(self.origin)
