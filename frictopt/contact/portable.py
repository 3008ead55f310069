"""Results that can be pickled and copied, and whose arrays stay read-only."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass

import numpy as np


class Portable:
    """Base of dataclasses whose arrays are read-only, and which can be pickled, copied and sent to other processes; a copy is read-only as well.

    A solved cvxpy `problem` can do none of this: copies leave it behind.
    """

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __getstate__(self) -> dict[str, object]:
        names = [one.name for one in fields(self)]  # type: ignore[arg-type]
        return {name: None if name == "problem" else getattr(self, name) for name in names}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        _seal(list(state.values()))


def _seal(value: object) -> None:
    """Make all arrays in a value read-only, also those in the parts of our own dataclasses."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple | list):
        for part in value:
            _seal(part)
    elif isinstance(value, Mapping):
        _seal(list(value.values()))
    elif is_dataclass(value) and type(value).__module__.startswith("frictopt."):
        _seal(list(vars(value).values()))
