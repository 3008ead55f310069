"""Finite-element models of a contact, condensed to its interface."""

from .bodies import Body, BodyForce, Support, Traction
from .condense import condense
from .contacts import Contact, Interference
from .elasticity import Material
from .matrices import MatrixJob, read_abaqus, read_calculix, read_mesh
from .model import ContactModel
from .scenes import Dovetail, PinInPlate, PunchOnHalfPlane, RoundedPunch
from .split import split_bodies

__all__ = [
    "Body",
    "BodyForce",
    "Contact",
    "ContactModel",
    "Dovetail",
    "Interference",
    "Material",
    "MatrixJob",
    "PinInPlate",
    "PunchOnHalfPlane",
    "RoundedPunch",
    "Support",
    "Traction",
    "condense",
    "read_abaqus",
    "read_calculix",
    "read_mesh",
    "split_bodies",
]
