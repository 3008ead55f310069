"""Closed-form solutions of frictional contact, and the check of states by the contact law.

Tests compare results of the package with these solutions. Each has its citation and units.
`corners.py` has the singular fields at corners, `half_spaces.py` discrete contacts of half-planes
and half-spaces, `hertz.py` cylinder and sphere, `sliders.py` rods.

A dissipation is the work of friction in one cycle of the steady state. `ModelError` is raised for
values that are not real and finite or out of the given range, and for lengths that do not match.
"""

from ..contact import check_contact_law
from .corners import CornerMode, bonded_corner, sliding_corner_exponent
from .half_spaces import half_plane_contact, half_plane_influence, half_space_contact
from .hertz import LineContact, SphereContact
from .sliders import foundation_rod, rod_dissipation

__all__ = [
    "CornerMode",
    "LineContact",
    "SphereContact",
    "bonded_corner",
    "check_contact_law",
    "foundation_rod",
    "half_plane_contact",
    "half_plane_influence",
    "half_space_contact",
    "rod_dissipation",
    "sliding_corner_exponent",
]


def __dir__() -> list[str]:
    return __all__
