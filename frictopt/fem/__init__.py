"""Finite-element models of a contact, condensed to its interface."""

from .bodies import Body, Support, Traction
from .condense import condense
from .elasticity import Material
from .model import ContactModel
from .punch import PunchOnHalfPlane

__all__ = ["Body", "ContactModel", "Material", "PunchOnHalfPlane", "Support", "Traction", "condense"]
