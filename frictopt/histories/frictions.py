"""The frictions of a study: numbers, fields over the nodes, and distributions from which the nodes draw."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..contact import friction_coefficients
from ..contact.checks import LARGEST_SEED, Array, frozen, whole_number
from ..errors import ModelError


def friction_fields(friction: Any, nodes: int, rng: object) -> list[Array]:
    """(N,) coefficients of each friction: of one, or of a list of numbers, fields and distributions; see `dissipation_study`."""
    if isinstance(friction, Mapping):
        raise ModelError(f"friction: a {type(friction).__name__}; give a coefficient, or a list of frictions")
    several = np.iterable(friction) and not isinstance(friction, str | bytes)
    items = list(friction) if several else [friction]
    if not items:
        raise ModelError("friction: empty; give at least one coefficient")
    if several and len(items) == nodes > 1 and not any(np.iterable(item) or hasattr(item, "rvs") for item in items):
        raise ModelError(
            f"friction: {nodes} numbers for {nodes} nodes, one friction of all nodes or {nodes} frictions; give [friction] or np.c_[friction]"
        )
    if any(hasattr(item, "rvs") for item in items) and rng is None:
        raise ModelError("rng: None, and friction has a distribution; give a seed, so that the study can be repeated")
    seed = rng if rng is None or isinstance(rng, np.random.Generator) else whole_number("rng", rng, least=0, most=LARGEST_SEED)
    generator = None if seed is None else np.random.default_rng(seed)
    drawn = [item.rvs(size=nodes, random_state=generator) if hasattr(item, "rvs") else item for item in items]
    column = all(isinstance(item, np.ndarray) and item.shape == (1,) for item in drawn)  # np.c_[...]
    return [frozen(friction_coefficients(item[0] if column else item, nodes)) for item in drawn]
