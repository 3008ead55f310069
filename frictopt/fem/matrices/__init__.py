"""Stiffness matrices, decks and meshes of other codes."""

from .abaqus import read_abaqus
from .ansys import read_ansys
from .calculix import read_calculix
from .job import MatrixJob
from .meshes import read_mesh
from .nastran import read_nastran

__all__ = ["MatrixJob", "read_abaqus", "read_ansys", "read_calculix", "read_mesh", "read_nastran"]
