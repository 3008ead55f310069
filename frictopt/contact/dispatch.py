"""How a public question about a contact in space reaches the room that answers it."""

import sys
import warnings
from collections.abc import Callable, Mapping
from functools import wraps
from importlib import import_module
from inspect import signature
from typing import Any

from ..errors import ModelError, ModelWarning
from .checks import finite_number, real_array
from .system import ContactSystem

__all__ = ["answered_by_kind"]

_OURS = "frictopt."  # rooms of the package, whose own questions are not the user's
_ROUGH = 5.0  # largest coefficient of friction that is passed without a word: of dry metals it is 0.1 to 1.5, of rubber up to 4

_ANSWERS = {  # public question -> file of the function of that name for three dimensions
    "safe_slip": "spatial.margin",
    "shakedown_limit": "spatial.shakedown",
}
_GUARANTEE = "is not yet offered in three dimensions; use shakedown_limit, above which nothing is safe, and steady_state from several starts below it"
_REFUSED = {
    "guaranteed_limit": f"guaranteed_limit {_GUARANTEE}",
    "safe_vertices": "safe_vertices is for plane contacts only: the safe slips of friction circles are no polytope; use safe_slip",
}


def answered_by_kind(plane: Callable[..., Any]) -> Callable[..., Any]:
    """A public function whose first argument is the contact: what is answered elsewhere for one in space goes to the function that does so."""
    names = list(signature(plane).parameters)

    @wraps(plane)
    def asked(*args: Any, **kwargs: Any) -> Any:
        if not sys._getframe(1).f_globals.get("__name__", "").startswith(_OURS):
            _warn_of_odd_numbers(dict(zip(names, args, strict=False)) | kwargs)
        system = args[0] if args else kwargs.get("system")
        if not isinstance(system, ContactSystem) or system.tangents == 1:
            return plane(*args, **kwargs)
        if plane.__name__ in _REFUSED:
            raise ModelError(_REFUSED[plane.__name__])
        if plane.__name__ not in _ANSWERS:
            return plane(*args, **kwargs)
        own = getattr(import_module(f"frictopt.{_ANSWERS[plane.__name__]}"), plane.__name__)
        return _handed_over(own, f"{plane.__name__} of a contact in space", args, kwargs)

    return asked


def _warn_of_odd_numbers(given: Mapping[str, object]) -> None:
    """Warn of values that a user who asks a question may not have meant: what is no number is for the question to refuse."""
    try:
        friction = float(real_array("friction", given.get("friction", 0.0)).max(initial=0.0))
        load_factor = finite_number("load_factor", given.get("load_factor", 1.0))
    except ModelError:
        return
    if friction > _ROUGH:
        warnings.warn(f"friction: {friction:g}, above {_ROUGH:g}; give the coefficient of friction, not per cent", ModelWarning, stacklevel=3)
    if load_factor == 0:
        warnings.warn("load_factor: 0; the corners of the cycle carry no load then, only the mean load acts", ModelWarning, stacklevel=3)


def _handed_over(own: Callable[..., Any], title: str, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Any:
    try:
        signature(own).bind(*args, **kwargs)
    except TypeError as error:
        raise ModelError(f"{title}: {error}; its arguments are {', '.join(signature(own).parameters)}") from error
    return own(*args, **kwargs)
