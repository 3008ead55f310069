"""Contact forces within friction that balance loads in rigid motions of the bodies.

The functions here list the rows of forces [q, p] that obey the contact law. Three questions use
these rows. What is the largest load that such forces balance (`limits/balance/statics.py`)? Can
such forces balance each other without a load? In which rigid motion do such forces fail to balance
a load?
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import RESIDUAL, Array
from ..contact import BoundTerm, ContactLaw, ContactSystem, contact_law
from ..errors import SolverError
from ..solve.answer import answer
from ..solve.arrays import CONE, EQUATION, LINEAR, Rows, dense_rows, program_of, rows_of

# Forces balance each other if their works in the rigid motions are below this share of the sum of
# their pressures.
BALANCED = 1e-6


def force_rows(law: ContactLaw, shear_unit: Array, node_unit: Array, axes: int) -> list[Rows]:
    """The rows of the contact law on forces [q, p] (M,), which come first in the program."""
    n = len(node_unit)
    # A friction bound in proportion to the pressure already excludes negative pressures.
    pressed = np.zeros(n, dtype=bool)
    for term in law.terms:
        pressed[term.nodes] |= (term.slope > 0)[term.nodes] & (term.constant == 0)[term.nodes]
    others = np.flatnonzero(~pressed)
    pressure = [[(axes * n + others, np.ones(len(others)))]]
    constant = np.zeros(len(others))
    rows = [rows_of("pressed", LINEAR, pressure, constant, node_unit[others])]
    for term in law.terms:
        nodes = term.nodes
        ones = np.ones(len(nodes))
        bound = [(axes * n + nodes, term.slope[nodes])] if term.slope[nodes].any() else []
        constant, unit = term.constant[nodes], shear_unit[nodes]
        if axes == 1:
            sides = [[[(nodes, -sign * ones), *bound]] for sign in (1.0, -1.0)]
            rows += [rows_of(term.row, LINEAR, side, constant, unit) for side in sides]
        else:
            shear = [[(axis * n + nodes, ones)] for axis in range(axes)]
            rows.append(rows_of(term.row, CONE, [bound, *shear], constant, unit))
    return rows


def balance_rows(V: Array, r0: Array, r1: Array, sizes: Array) -> Rows:
    """Rows by which forces do the work of the load `r0 + load_factor r1` (M,) in each motion of V.

    V is (M, k). In the program, the load factor comes after the forces; `sizes` (k,) are the units
    of the works.
    """
    works = np.column_stack([V.T, -(V.T @ r1)])
    return dense_rows("balance", EQUATION, works, -(V.T @ r0), sizes)


def distance_row(V: Array, load: Array, size: float) -> Rows:
    """The cone `|V' forces - V' load| <= size distance`.

    In the program, the distance comes after the forces (M,).
    """
    M, count = V.shape
    distance = size * np.eye(1, M + 1, M)
    works = np.column_stack([V.T, np.zeros(count)])
    constants = np.r_[0.0, -(V.T @ load)]
    return dense_rows("distance", CONE, np.vstack([distance, works]), constants, np.full(1, size))


class Nearest(NamedTuple):
    """Forces [q, p] (M,) whose works in some motions are closest to the works of a load.

    `motion` (M,) proves that no forces are closer. The size of this motion is 1, or 0 if the
    distance is 0. `residual` is the error of this proof.
    """

    forces: Array
    distance: float
    motion: Array
    residual: float


def nearest(rows: list[Rows], V: Array, load: Array, tolerance: float = RESIDUAL) -> Nearest:
    """Forces that obey the rows, with works in the motions V (M, k) closest to a load's works.

    The load is (M,). The unit of the distance is the largest force of the load, or 1 if this force
    is 0. SolverError if the solver finds no answer.
    """
    size = float(np.abs(load).max()) or 1.0
    units = np.full(len(load) + 1, size)
    units[-1] = 1.0
    cost = np.eye(1, len(units), len(load))[0]
    program = program_of([*rows, distance_row(V, load, size)], units, cost)
    by_size = np.cumsum(program.sizes) + program.zero
    # Cones come last, in the order of the rows.
    first = int(by_size[-1]) - V.shape[1]

    def claimed(x: Array, y: Array) -> Nearest:
        motion = -V @ y[first:]
        bound, error = program.lower_bound(x, y)
        residual = max(program.violation(x), abs(x[-1] - bound), error / len(x))
        return Nearest(size * x[:-1], float(x[-1]), motion, float(residual))

    found, _ = answer(program, claimed, tolerance=tolerance)
    return found


def self_stress(system: ContactSystem, friction: Array, N: Array) -> Array | None:
    """Contact forces (t + 1, N) within friction that balance each other; None if there are none.

    The forces do no work in the rigid motions N, and their pressures add up to 1. SolverError if
    the solver does not decide.
    """
    n, axes = system.nodes, system.tangents
    ones = np.ones(n)
    # A node with a shear strength does not wedge: its bound does not grow with the pressure.
    slope = contact_law(system, friction).wedging_slope
    law = ContactLaw((BoundTerm("stuck", slope, np.zeros(n)),))
    pressures = np.r_[np.zeros(axes * n), ones][None]
    total = dense_rows("total", EQUATION, pressures, -np.ones(1), np.ones(1))
    rows = [*force_rows(law, ones, ones, axes), total]
    try:
        found = nearest(rows, N, np.zeros(len(N)), tolerance=BALANCED)
    except SolverError as error:
        raise SolverError(f"self-stress: {error}") from error
    if found.distance > BALANCED:
        return None
    return found.forces.reshape(axes + 1, n)
