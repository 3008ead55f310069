"""Contacts with ready-made meshes, for tests and comparisons.

A scene is a frozen dataclass of lengths, numbers of elements and materials. Its `model()` is a
`ContactModel` with meshes, supports and load cases, and its `condense()` the `ContactSystem`.

`scene.py` is the base of all scenes, with the checks of their fields and graded coordinates.
`punch.py`, `dovetail.py` and `shrunk.py` have the scenes. A new scene is a class beside these, with
`contact_nodes`, `_grids` and `model`.
"""

from .dovetail import Dovetail
from .punch import PunchOnHalfPlane, RoundedPunch, SquarePunch
from .shrunk import PinInPlate, PressFit

__all__ = ["Dovetail", "PinInPlate", "PressFit", "PunchOnHalfPlane", "RoundedPunch", "SquarePunch"]


def __dir__() -> list[str]:
    return __all__
