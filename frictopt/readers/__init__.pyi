from .ansys_nastran import read_ansys, read_nastran
from .calculix_abaqus import read_abaqus, read_calculix
from .job import MatrixJob
from .labelled import modal_load
from .meshes import read_mesh

__all__ = [
    "MatrixJob",
    "modal_load",
    "read_abaqus",
    "read_ansys",
    "read_calculix",
    "read_mesh",
    "read_nastran",
]
