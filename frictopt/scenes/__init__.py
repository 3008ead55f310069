"""Contacts that are ready to use: frozen descriptions with structured meshes of their own."""

from .dovetail import Dovetail
from .punch import PunchOnHalfPlane, RoundedPunch, SquarePunch
from .shrunk import PinInPlate, PressFit

__all__ = ["Dovetail", "PinInPlate", "PressFit", "PunchOnHalfPlane", "RoundedPunch", "SquarePunch"]


def __dir__() -> list[str]:
    return __all__
