"""What a design adds to a state of rest, and why there is none that is best."""

from collections.abc import Iterable, Mapping
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import GROWN, Array
from ..errors import ModelError
from .models import Row, named
from .programs import Program
from .question import Question

_NAMED = 4  # unbounded parts of a design that an error names


class NoneSafeError(ModelError):
    """No design is safe with given nodes open; with others one may be."""


def added(asked: Question, acting: Array, preload: cp.Variable | None, profile: cp.Variable | None) -> tuple[list[cp.Expression], list[Row]]:
    """What preloads of these reactions and a profile add to q, p, and to gaps and slips of open nodes; and rows that define it."""
    system, n, moved = asked.system, asked.system.nodes, asked.open.any()
    parts, rows = list[list[cp.Expression]](), list[Row]()
    for chosen, r, names in ((preload, acting, ("Q", "P", "w", "v")), (profile, -system.S[:, -n:], ("-B.T", "-C", "-w", "-v"))):
        if chosen is not None:
            left = asked.carried(r.T).reshape(r.shape[::-1]).T
            follow = -(asked.give @ r) if asked.give is not None else np.zeros_like(r)
            open_slip = follow[:-n][np.tile(asked.open, system.tangents)]
            matrices = (left[:-n], left[-n:], *((follow[-n:][asked.open], open_slip) if moved else ()))
            terms = [named(matrix, name) @ chosen for matrix, name in zip(matrices, names, strict=False)]
            if chosen is profile:  # dense: equations of their own do not go through cvxpy
                unknown = [cp.Variable(len(part), name=f"{name}_g") for part, name in zip(matrices, "qpwv", strict=False)]
                rows += [part == product for part, product in zip(unknown, terms, strict=True)]
                terms = list(unknown)
            parts.append(terms)
    q, *others = (sum(each[1:], each[0]) for each in zip(*parts, strict=True))
    return [q if system.tangents == 1 else cp.reshape(q, system.slip_shape, order="F"), *others], rows


def refused(program: Program, entries: Mapping[cp.Variable | None, Iterable[object]], units: Mapping[cp.Variable, Any], chosen: bool) -> None:
    """Say why there is no best design; None where that cannot be proven. `entries` are the names of those of each unknown of the design.

    Raises
    ------
    ModelError
        Where it is proven; `NoneSafeError` if the contact has a part in it.
    """
    if none := program.chain.contradiction():
        ruling, own = program.ruling(none.ruling), {row.id for row in program.own.values()}
        safe = "no design is safe at any load factor with all nodes closed" if none.ruling - own else "they contradict each other"
        error = NoneSafeError if none.ruling - own else ModelError
        if not ruling:
            raise error(f"preloads: {safe}; press nodes that are open, or ask `shakedown_limit` of designs of your own")
        raise error(f"{', '.join(ruling)}: {safe} under these constraints; drop or relax one")
    growth = program.chain.growth()
    if growth is None:
        return
    found = dict[str, float]()
    for variable, names in entries.items():
        if variable is not None:
            along = np.ravel(program.chain.value_along(growth, variable) / units[variable])
            found |= {f"{variable.name()}[{name!r}]": value for name, value in zip(names, along.tolist(), strict=True)}
    largest, goal = max(map(abs, found.values())), "objective" if chosen else "load_factor"
    if not largest > GROWN:
        raise ModelError(f"{goal}: it grows without end whatever the design; bound it by a constraint, or give another objective")
    grows = {name: value for name, value in found.items() if abs(value) > GROWN * largest}
    named_parts = [f"{name} has no {'upper' if value > 0 else 'lower'} bound" for name, value in [*grows.items()][:_NAMED]]
    more = f" and {len(grows) - _NAMED} more" if len(grows) > _NAMED else ""
    raise ModelError(
        f"{goal}: it grows without end with the design: {', '.join(named_parts)}{more}; bound them by constraints, or say what they cost"
    )
