"""Warnings of values that are no errors, but that a user may not have meant."""

import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from inspect import signature
from numbers import Real
from typing import TypeVar

from ..errors import ModelError, ModelWarning
from .checks import real_array

F = TypeVar("F", bound=Callable[..., object])

_OURS = "frictopt."  # rooms of the package, whose own questions are not the user's
_ROUGH = 5.0  # largest coefficient of friction that is passed without a word: of dry metals it is 0.1 to 1.5, of rubber up to 4


def warns_of_odd_values(question: F) -> F:
    """A public question, with a warning of values that a user who asks it may not have meant."""
    names = list(signature(question).parameters)

    @wraps(question)
    def asked(*args: object, **kwargs: object) -> object:
        if sys._getframe(1).f_globals.get("__name__", "").startswith(_OURS):
            return question(*args, **kwargs)
        given = dict(zip(names, args, strict=False)) | kwargs
        with suppress(ModelError):  # what is no number is for the question to refuse
            friction = float(real_array("friction", given.get("friction", 0.0)).max(initial=0.0))
            if friction > _ROUGH:
                text = f"friction: {friction:g}, above {_ROUGH:g}; give the coefficient of friction, not per cent"
                warnings.warn(text, ModelWarning, stacklevel=2)
        load_factor = given.get("load_factor")
        if isinstance(load_factor, Real) and load_factor == 0 and getattr(given.get("cycle"), "fixed", None) is None:
            text = "load_factor: 0; the corners of the cycle carry no load then, only the mean load acts"
            warnings.warn(text, ModelWarning, stacklevel=2)
        return question(*args, **kwargs)

    return asked  # type: ignore[return-value]
