"""Finite-element models of a contact, condensed to its interface."""

from .bodies import Body, Support, Traction
from .condense import condense
from .contacts import Contact, Interference
from .elasticity import Material
from .model import ContactModel
from .punch import PunchOnHalfPlane
from .split import split_bodies

__all__ = ["Body", "Contact", "ContactModel", "Interference", "Material", "PunchOnHalfPlane", "Support", "Traction", "condense", "split_bodies"]
