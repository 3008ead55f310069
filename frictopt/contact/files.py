"""Files: those to be written, checked before anything is computed; npz archives of plain arrays, as of a contact system; and what is printed."""

from pathlib import Path
from typing import Any

import numpy as np

from ..base.files import packed, unpacked
from .components import joined

_NAMES = ("S", "points", "gap", "frames", "contact", "width", "E_star", "compliance", "units")
_FORM = "frictopt contact system 7"


def write(path: str | Path, system: Any) -> None:
    """Write a contact system: its parts (None as an empty array), load cases and bonded reactions; locked bolts, shear strength where it has any."""
    plain = {
        name: np.array([] if (value := getattr(system, name)) is None else value) for name in _NAMES
    }
    bonded = [joined(*pair) for pair in system.bonded.values()]
    more = (
        {"locked": list(system.bolts), "bolts": list(system.bolts.values())} if system.bolts else {}
    )
    more |= (
        {"sized": list(system.load_size), "load_size": list(system.load_size.values())}
        if system.load_size
        else {}
    )
    more |= {"shear_strength": system.shear_strength} if system.capped else {}
    more |= {"stretch": system.stretch} if system.orthotropic else {}
    packed(path, _FORM, cases=list(system.bonded), bonded=bonded, **more, **plain)


def read(source: str | Path) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""
    return unpacked(
        source,
        _FORM,
        _arguments,
        "a contact system",
        "give one of `frictopt condense` or ContactSystem.save",
    )


def _arguments(arrays: dict[str, Any]) -> dict[str, Any]:
    bolts = {name: arrays.pop(name).tolist() for name in ("locked", "bolts") if name in arrays}
    sizes = {name: arrays.pop(name).tolist() for name in ("sized", "load_size") if name in arrays}
    laws: dict[str, Any] = {
        name: arrays.pop(name) for name in ("shear_strength", "stretch") if name in arrays
    }
    if arrays.keys() != {"cases", "bonded", *_NAMES} or len(bolts) == 1 or len(sizes) == 1:
        raise ValueError("it does not hold the arrays of a contact system")
    bonded = dict(zip(arrays.pop("cases").tolist(), arrays.pop("bonded"), strict=True))
    known = {
        name: None if not array.size else array if array.ndim else array.item()
        for name, array in arrays.items()
    }
    named = {
        "bolts": dict(zip(*bolts.values(), strict=True)) if bolts else {},
        "load_size": dict(zip(*sizes.values(), strict=True)) if sizes else {},
    }
    return {"bonded": bonded, **named, **laws, **known}
