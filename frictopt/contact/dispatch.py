"""How a public question about a contact that is not plane reaches the room that answers it."""

import sys
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import wraps
from importlib import import_module
from inspect import signature
from typing import Any, ParamSpec, Protocol, TypeVar, cast, overload

import numpy as np

from ..errors import ModelError, ModelWarning
from .checks import Array

__all__ = ["OtherContact", "answered_by_axes", "answered_by_kind"]

_OURS = "frictopt."  # rooms of the package, whose own questions are not the user's
_ROUGH = 5.0  # largest coefficient of friction that is passed without a word: of dry metals it is 0.1 to 1.5, of rubber up to 4

F = TypeVar("F", bound=Callable[..., Any])
P = ParamSpec("P")
R = TypeVar("R", covariant=True)


class OtherContact(ABC):
    """A contact that is not plane: load cycles act on it, and it names the functions that answer questions about it."""

    A: Array
    B: Array
    C: Array
    points: Array
    gap: Array

    @property
    @abstractmethod
    def nodes(self) -> int:
        """Number of node pairs, N."""

    @property
    @abstractmethod
    def slip_shape(self) -> tuple[int, ...]:
        """Shape of a slip of all nodes."""

    @abstractmethod
    def reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Bonded reactions `(q, p)` under a sum of load cases."""

    @abstractmethod
    def closed_reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Reactions `(q, p)` with every gap pressed shut and no slip."""

    @classmethod
    @abstractmethod
    def answers(cls, question: str) -> Callable[..., Any]:
        """The function that answers a public question about such a contact, or a `ModelError` that says why there is none."""


class Asked(Protocol[P, R]):
    """A public question about a plane contact, or about one of another kind."""

    @overload
    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R: ...
    @overload
    def __call__(self, system: OtherContact, /, *args: Any, **kwargs: Any) -> Any: ...


def answered_by_kind(plane: Callable[P, R]) -> Asked[P, R]:
    """A public function whose first argument is the contact: one of another kind goes to the function that answers for it."""
    names = list(signature(plane).parameters)

    @wraps(plane)
    def asked(*args: Any, **kwargs: Any) -> Any:
        if not sys._getframe(1).f_globals.get("__name__", "").startswith(_OURS):
            _warn_of_odd_numbers(dict(zip(names, args, strict=False)) | kwargs)
        system = args[0] if args else kwargs.get("system")
        if not isinstance(system, OtherContact):
            return plane(*args, **kwargs)
        return _handed_over(system.answers(plane.__name__), f"{plane.__name__} of a {type(system).__name__}", args, kwargs)

    return cast(Asked[P, R], asked)


def _warn_of_odd_numbers(given: Mapping[str, Any]) -> None:
    """Warn of values that a user who asks a question may not have meant: what is no number is for the question to refuse."""
    try:
        friction, load_factor = float(np.max(given.get("friction", 0.0))), float(given.get("load_factor", 1.0))
    except (TypeError, ValueError, OverflowError):
        return
    if friction > _ROUGH:
        warnings.warn(f"friction: {friction:g}, above {_ROUGH:g}; give the coefficient of friction, not per cent", ModelWarning, stacklevel=3)
    if load_factor == 0:
        warnings.warn("load_factor: 0; the corners of the cycle carry no load then, only the mean load acts", ModelWarning, stacklevel=3)


def answered_by_axes(plane: F) -> F:
    """A public function of points in the plane: with points in space it goes to the function of its name in the room for three dimensions."""

    @wraps(plane)
    def asked(*args: Any, **kwargs: Any) -> Any:
        points: Any = signature(plane).bind_partial(*args, **kwargs).arguments.get("points")
        try:
            in_space = np.shape(points)[1:] == (3,)
        except (TypeError, ValueError):  # no array at all
            in_space = False
        if not in_space:
            return plane(*args, **kwargs)
        own = getattr(import_module(f"frictopt.spatial.{plane.__name__}"), plane.__name__)
        return _handed_over(own, f"{plane.__name__} in three dimensions", args, kwargs)

    return asked  # type: ignore[return-value]


def _handed_over(own: Callable[..., Any], title: str, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Any:
    try:
        signature(own).bind(*args, **kwargs)
    except TypeError as error:
        raise ModelError(f"{title}: {error}; its arguments are {', '.join(signature(own).parameters)}") from error
    return own(*args, **kwargs)
