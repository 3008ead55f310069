from .ansys_nastran import read_ansys, read_nastran
from .calculix_abaqus import read_abaqus, read_calculix
from .job import MatrixJob
from .meshes import read_mesh

__all__ = [
    "MatrixJob",
    "read_abaqus",
    "read_ansys",
    "read_calculix",
    "read_mesh",
    "read_nastran",
]
