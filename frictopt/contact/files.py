"""How a contact system is kept in a file: an npz archive of plain arrays."""

from pathlib import Path
from typing import Any

import numpy as np

from ..base.files import packed, unpacked
from .components import joined

_FORM = "frictopt contact system 7"
# Parts that every archive has, under their names; None is an empty array.
_PARTS = ("S", "points", "gap", "frames", "contact", "width", "E_star", "compliance", "units")
# Mappings from load cases are kept as two arrays, of names and of values, and only if not empty.
_MAPPINGS = {"bolts": "locked", "load_size": "sized"}
# Parts that are kept only if the contact has them.
_OPTIONAL = ("shear_strength", "stretch", "deck_node")


def write(path: str | Path, system: Any) -> None:
    """Write a contact system to an archive."""
    arrays: dict[str, Any] = {}
    for part in _PARTS:
        value = getattr(system, part)
        arrays[part] = np.array([] if value is None else value)
    arrays["cases"] = list(system.bonded)
    arrays["bonded"] = [joined(*pair) for pair in system.bonded.values()]
    for part, names in _MAPPINGS.items():
        mapping = getattr(system, part)
        if mapping:
            arrays[names] = list(mapping)
            arrays[part] = list(mapping.values())
    if system.capped:
        arrays["shear_strength"] = system.shear_strength
    if system.orthotropic:
        arrays["stretch"] = system.stretch
    if system.deck_node is not None:
        arrays["deck_node"] = system.deck_node
    if system.axisymmetric:
        arrays["axisymmetric"] = True
    if system.thickness is not None:
        arrays["thickness"] = system.thickness
    packed(path, _FORM, **arrays)


def read(source: str | Path) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""
    remedy = "give a file that ContactSystem.save wrote"
    return unpacked(source, _FORM, _arguments, "a contact system", remedy, any_version=True)


def is_contact(source: str | Path) -> bool:
    """Whether a file says that it is an archive of a contact system, in any version."""
    try:
        with np.load(source, allow_pickle=False) as archive:
            return str(archive["format"]).startswith(_FORM.rstrip("0123456789"))
    except Exception:  # of a damaged or foreign file; `read` then says why
        return False


def _arguments(arrays: dict[str, Any]) -> dict[str, Any]:
    arguments: dict[str, Any] = {}
    for part, names in _MAPPINGS.items():
        has_part = part in arrays
        if has_part != (names in arrays):
            raise ValueError(f"it has {part!r} without {names!r}, or the reverse")
        arguments[part] = {}
        if has_part:
            keys = arrays.pop(names).tolist()
            arguments[part] = dict(zip(keys, arrays.pop(part).tolist(), strict=True))
    for part in _OPTIONAL:
        if part in arrays:
            arguments[part] = arrays.pop(part)
    if "axisymmetric" in arrays:
        arguments["axisymmetric"] = bool(arrays.pop("axisymmetric"))
    if "thickness" in arrays:
        arguments["thickness"] = float(arrays.pop("thickness"))
    if arrays.keys() != {"cases", "bonded", *_PARTS}:
        raise ValueError("it does not hold the arrays of a contact system")
    cases = arrays.pop("cases").tolist()
    arguments["bonded"] = dict(zip(cases, arrays.pop("bonded"), strict=True))
    for part, array in arrays.items():
        if not array.size:
            arguments[part] = None
        elif array.ndim:
            arguments[part] = array
        else:
            arguments[part] = array.item()
    return arguments
