"""Finite-element models of a contact, condensed to its interface."""

from .bodies import Body, Support
from .bolts import BoltPreload
from .condense import condense
from .contacts import Contact, Interference
from .elasticity import Material
from .loads import BodyForce, Centrifugal, Displacement, Expansion, Pressure, Traction
from .matrices import MatrixJob, read_abaqus, read_ansys, read_calculix, read_mesh, read_nastran
from .modal import modal_load
from .model import ContactModel
from .paraview import write_paraview
from .recovery import BodyFields
from .split import split_bodies

__all__ = [
    "Body",
    "BodyFields",
    "BodyForce",
    "BoltPreload",
    "Centrifugal",
    "Contact",
    "ContactModel",
    "Displacement",
    "Expansion",
    "Interference",
    "Material",
    "MatrixJob",
    "Pressure",
    "Support",
    "Traction",
    "condense",
    "modal_load",
    "read_abaqus",
    "read_ansys",
    "read_calculix",
    "read_mesh",
    "read_nastran",
    "split_bodies",
    "write_paraview",
]
