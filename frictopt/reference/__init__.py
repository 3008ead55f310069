"""Closed-form solutions of frictional contact, and the check of states by the contact law.

Tests compare results of the package with them. Each has its citation and units. `corners.py` has
the singular fields at corners, `half_spaces.py` discrete contacts of half-planes and half-spaces,
`hertz.py` cylinder and sphere, `sliders.py` springs and rods, `uncoupled.py` uncoupled nodes.

Limits and dissipation of a load that swings between two corners: bonded reactions `r0 + lam * s *
r1` with `s = -1, +1`, tangential parts `q0, q1` along +x, normal parts `p0, p1` positive in
compression. A limit is finite, inf (no load factor is too large) or nan (nothing is safe, not even
`lam = 0`). A dissipation is the work of friction in one cycle of the steady state. `ModelError` is
raised for values that are not real and finite or out of the given range, and for lengths that do
not match.
"""

from ..contact import check_contact_law
from .corners import CornerMode, bonded_corner, sliding_corner_exponent
from .half_spaces import half_plane_contact, half_plane_influence, half_space_contact
from .hertz import LineContact, SphereContact, contact_modulus
from .sliders import foundation_rod, masing_dissipation, rod_dissipation
from .uncoupled import (
    single_node_dissipation,
    single_node_limit,
    smallest_circle,
    smallest_circle_limit,
    uncoupled_limit,
)

__all__ = [
    "CornerMode",
    "LineContact",
    "SphereContact",
    "bonded_corner",
    "check_contact_law",
    "contact_modulus",
    "foundation_rod",
    "half_plane_contact",
    "half_plane_influence",
    "half_space_contact",
    "masing_dissipation",
    "rod_dissipation",
    "single_node_dissipation",
    "single_node_limit",
    "sliding_corner_exponent",
    "smallest_circle",
    "smallest_circle_limit",
    "uncoupled_limit",
]


def __dir__() -> list[str]:
    return __all__
