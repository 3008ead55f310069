"""The units of a system: names for pictures and tables. No number depends on them."""

import re

from ..errors import ModelError
from .checks import check_text

_STRESS = {("N", "mm"): "MPa", ("kN", "mm"): "GPa", ("N", "m"): "Pa", ("kN", "m"): "kPa", ("MN", "m"): "MPa"}
_MEANING = re.compile(r"\(((?:1 / )?(?:force|length)(?: (?:times|per) (?:length|area|depth))*)\)")


def checked_units(units: object) -> str | None:
    """Check the names of the units of force and length, "N, mm"; None: not known.

    Raises
    ------
    ModelError
        No text, or not two names.
    """
    if units is None:
        return None
    check_text("units", units, 'the names of the units of force and length, such as "N, mm"')
    names = [name.strip() for name in str(units).split(",")]
    if len(names) != 2 or not all(names):
        raise ModelError(f'units: {units!r}; give the names of the units of force and length, such as "N, mm"')
    return ", ".join(names)


def in_units(text: str, units: str | None) -> str:
    """A text with its meanings in parentheses, such as "(force per area)", in units, such as "(MPa)"; None: as it is.

    Examples
    --------
    >>> from frictopt.contact.units import in_units
    >>> in_units("slip $v$ (length), traction (force per area), work (force times length per depth)", "N, mm")
    'slip $v$ (mm), traction (MPa), work (N mm / mm)'
    """
    if units is None:
        return text
    force, length = units.split(", ")

    def named(match: re.Match[str]) -> str:
        meaning = match[1]
        if meaning == "force per area" and (force, length) in _STRESS:
            return f"({_STRESS[force, length]})"
        words = {"times": "", "per": "/", "area": f"{length}²", "depth": length, "length": length, "force": force}
        return f"({' '.join(filter(None, (words.get(word, word) for word in meaning.split())))})"

    return _MEANING.sub(named, text)
