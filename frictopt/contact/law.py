"""The contact law: how large a shear force a node can carry under its normal force.

All laws of the package have one form. At each node a concave, piecewise linear function of the
normal force bounds the shear force, and friction opposes the slip::

    |q| <= min over the terms of (slope * p + constant),    p >= 0

Coulomb's law has only the term `f p`. A shear strength of the surface adds the term `c`, which does
not depend on the pressure. Friction that differs along the two tangents is Coulomb's law in
stretched coordinates, see `ContactSystem.with_orthotropic_friction`. A new law is a new term of
`contact_law`: programs, increments, gross slip and the check of the law use these terms. Questions
that do not know the shear strength refuse it, see `checked_law`.
"""

from dataclasses import dataclass

import numpy as np

from ..base import Array, Integers
from ..base.checks import PerNode, per_node
from ..errors import ModelError
from .system import ContactSystem, checked_system


@dataclass(frozen=True, eq=False)
class BoundTerm:
    """A linear term of the friction bound, `slope * p + constant`, at the nodes that have it.

    Attributes
    ----------
    row
        Label of the rows of a program that hold this term, such as "stuck".
    symbol
        Name of the constant in a printed program.
    which
        Name, in a printed program, of the nodes that have this term.
    slope
        (N,) increase of the bound with the normal force, dimensionless.
    constant
        (N,) bound without normal force, force; inf at nodes without this term.
    """

    row: str
    slope: Array
    constant: Array
    symbol: str = ""
    which: str = ""

    @property
    def nodes(self) -> Integers:
        """Numbers of the nodes that have this term."""
        return np.flatnonzero(np.isfinite(self.constant))


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """The bound of the shear forces of all nodes, as its linear terms; the smallest term governs.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> from frictopt.contact import contact_law
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads, width=[1.0])
    >>> law = contact_law(node.with_shear_strength(0.8), 0.5)
    >>> [term.row for term in law.terms]
    ['stuck', 'strength']
    >>> law.bound(np.array([[1.0], [2.0]])).tolist()
    [[0.5], [0.8]]
    """

    terms: tuple[BoundTerm, ...]

    def bound(self, p: Array) -> Array:
        """(..., N) largest shear force under normal forces p (..., N)."""
        bounds = [term.slope * p + term.constant for term in self.terms]
        return np.asarray(np.min(bounds, axis=0))

    @property
    def slopes(self) -> Array:
        """(J, N) slopes of the J terms, a new array."""
        return np.array([term.slope for term in self.terms])

    @property
    def constants(self) -> Array:
        """(J, N) constants of the J terms, force; a new array."""
        return np.array([term.constant for term in self.terms])

    @property
    def wedging_slope(self) -> Array:
        """(N,) slope of the bound under large normal forces.

        A slip may wedge the bodies if it lifts its node by less than this slope times the slip.
        """
        slopes = np.where(np.isfinite(self.constants), self.slopes, np.inf)
        return np.asarray(slopes.min(axis=0))


def contact_law(system: ContactSystem, friction: Array | float) -> ContactLaw:
    """The law of a contact; `friction` has been checked, one coefficient or one per node."""
    coefficients = np.broadcast_to(friction, system.nodes)
    zero = np.zeros(system.nodes)
    coulomb = BoundTerm("stuck", coefficients, zero)
    if not system.capped:
        return ContactLaw((coulomb,))
    strength = BoundTerm("strength", zero, system.shear_strength, symbol="c", which="strong")
    return ContactLaw((coulomb, strength))


ROWS = ("stuck", "strength")
"""Labels of the rows of all terms."""

# The public questions that can be answered with a shear strength.
_KNOW_STRENGTH = ("shakedown_limit", "gross_slip", "march", "steady_state")


def friction_coefficients(friction: PerNode, system: ContactSystem) -> Array:
    """Check coefficients of friction: one, one per node or one per contact; returns a new (N,).

    ModelError for entries that are not real and finite, for negative entries, and for another
    number of entries.
    """
    remedy = "a coefficient of friction is not negative"
    return np.array(per_node("friction", friction, checked_system(system), remedy))


def checked_law(system: object, question: str) -> ContactSystem:
    """Check that a `question` knows the law of a contact; every question knows Coulomb's law.

    `question` is a name of a public function, or another name for error messages.
    """
    checked = checked_system(system)
    if checked.capped and question not in _KNOW_STRENGTH:
        *first, last = _KNOW_STRENGTH
        raise ModelError(
            f"system: it has a shear strength, which {question} does not know; ask "
            f"{', '.join(first)} or {last}, or leave it out: system.with_shear_strength(np.inf)"
        )
    return checked


def most_shear(system: ContactSystem, friction: Array | float, p: Array) -> Array:
    """(..., N) largest shear force under normal forces p (..., N), by the law of the contact."""
    return contact_law(system, friction).bound(p)


def lengths(q: Array, p: Array) -> Array:
    """(..., N) lengths of shear forces or slips q, (..., N) or (..., N, 2).

    The normal forces p (..., N) show which of the two shapes q has.
    """
    if q.ndim == p.ndim:
        return np.abs(q)
    return np.asarray(np.linalg.norm(q, axis=-1))


def reach(q0: Array, g0: Array, q1: Array, g1: Array) -> Array:
    """Largest lam with `|q0 + lam q1| <= g0 + lam g1`, for q (..., 2) and g (...,).

    It is inf if the inequality holds for every larger lam. The squares of both sides give `a lam^2
    + 2 b lam <= c`. If rounding leaves no solution, the discriminant counts as zero.
    """
    a = (q1**2).sum(axis=-1) - g1**2
    b = (q0 * q1).sum(axis=-1) - g0 * g1
    c = g0**2 - (q0**2).sum(axis=-1)
    root = np.sqrt(np.maximum(b**2 + a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # If a and b vanish, the path runs along the cone, up to its apex if it points there.
        apex = np.where(g1 < 0, g0 / -g1, np.inf)
        # The root has two forms. The form without cancellation of digits is used.
        last = np.where(b > 0, c / (b + root), np.where(a > 0, (root - b) / a, apex))
    return np.where(g1 >= np.linalg.norm(q1, axis=-1), np.inf, last)
