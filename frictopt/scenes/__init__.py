"""Contacts with meshes of their own, to try and to compare.

A scene is a dataclass of lengths and materials with `model()` and `condense()`; `scene.py` is their
base. A new scene is a class beside those of `punch.py`, `dovetail.py` and `shrunk.py`.
"""

from .dovetail import Dovetail
from .punch import PunchOnHalfPlane, RoundedPunch, SquarePunch
from .shrunk import PinInPlate, PressFit

__all__ = ["Dovetail", "PinInPlate", "PressFit", "PunchOnHalfPlane", "RoundedPunch", "SquarePunch"]


def __dir__() -> list[str]:
    return __all__
