"""How a contact system is kept in a file: an npz archive of plain arrays."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ..base.files import packed, unpacked
from .components import joined

_FORM = "frictopt contact system 7"
# Parts that belong to load cases. The names of these load cases are an array of their own.
_NAMES = {"bonded": "cases", "bolts": "locked", "load_size": "sized"}


def write(path: str | Path, system: Any) -> None:
    """Write a contact system to an archive: an array for each part, empty if there is none."""
    arrays: dict[str, Any] = {"S": system.S}
    for part in [field.name for field in fields(system) if field.init]:
        value = getattr(system, part)
        if isinstance(value, Mapping):
            arrays[_NAMES[part]] = list(value)
            value = list(value.values())
        arrays[part] = [] if value is None else value
    arrays["bonded"] = [joined(*pair) for pair in arrays["bonded"]]
    packed(path, _FORM, **arrays)


def read(source: str | Path, kind: Any) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""

    def arguments(arrays: dict[str, Any]) -> dict[str, Any]:
        of_cases = {}
        for part, names in _NAMES.items():
            keys, values = arrays.pop(names, np.zeros(0)), arrays.pop(part, np.zeros(0))
            of_cases[part] = dict(zip(keys.tolist(), values, strict=True))
        if not {"S", "points"} <= arrays.keys() <= {field.name for field in fields(kind)}:
            raise ValueError("it does not hold the arrays of a contact system")
        for part, array in arrays.items():
            if not array.ndim:
                arrays[part] = array.item()
            elif not array.size:
                arrays[part] = None
        return arrays | of_cases

    remedy = "give a file that ContactSystem.save wrote"
    return unpacked(source, _FORM, arguments, "a contact system", remedy, any_version=True)


def is_contact(source: str | Path) -> bool:
    """Whether a file is marked as an archive of a contact system, of any version."""
    try:
        with np.load(source, allow_pickle=False) as archive:
            return str(archive["format"]).startswith(_FORM.rstrip("0123456789"))
    except Exception:  # of a damaged or foreign file; `read` then says why
        return False
