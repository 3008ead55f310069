"""An increment between two known states, as a problem that holds the later one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base import Array, choice
from ...contact import ContactSystem, joined
from ...errors import ModelError
from .by_booleans import ExactIncrement
from .increment import Increment, Posed
from .programs import ByProgram, FrozenBoundIncrement, complementarity_problem, put_into


def held_increment(
    system: ContactSystem,
    friction: Array,
    before: Array,
    bonded: Sequence[Array],
    after: tuple[Array, Array],
    form: str,
) -> Increment:
    """The increment from the slip `before` to the slip and gap `after`, under a load.

    `form` is that of `Trajectory.increment`.
    """
    choice("form", form, ("qp", "complementarity", "milp"))
    if form != "qp" and system.tangents == 2:
        raise ModelError(
            f"form: {form!r}; it needs a piecewise linear law, but the friction bound in space is "
            "a circle: choose 'qp'"
        )
    solver = ExactIncrement if form == "milp" else FrozenBoundIncrement
    engine: ByProgram = solver(system, friction)
    posed = Posed(engine, before, bonded)
    slip, gap = after
    found = posed.claim(joined(slip - before, gap) / posed.length)
    if form != "complementarity":
        return engine._answer(posed, found, found.status)
    step = found.slip - before
    z = np.concatenate([np.maximum(step, 0.0), np.maximum(-step, 0.0), found.gap])
    problem = complementarity_problem(system, friction, before, bonded).problem
    return put_into(problem, found, {"z": z})
