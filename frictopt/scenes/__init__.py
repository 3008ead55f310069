"""Contacts that are ready to use: frozen descriptions with structured meshes of their own."""

from .dovetail import Dovetail
from .pin import PinInPlate
from .press_fit import PressFit
from .punch import PunchOnHalfPlane, RoundedPunch, SquarePunch

__all__ = ["Dovetail", "PinInPlate", "PressFit", "PunchOnHalfPlane", "RoundedPunch", "SquarePunch"]
