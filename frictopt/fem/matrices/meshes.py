"""Meshes of files and decks, through meshio and scikit-fem."""

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ...contact.checks import Array, shown
from ...contact.tolerances import SAME_POINT
from ...errors import ModelError
from ..ordering import Integers
from .deck import Deck, read_deck

__all__ = ["file_path", "mesh_of", "meshio_library", "read_mesh"]

_PLANE, _SOLID = ("triangle", "quad"), ("tetra", "hexahedron")
_SMALL = ("vertex", "line", "line3")  # cells that only carry names


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh with its named boundaries and subdomains: `.msh` of gmsh, `.inp` of CalculiX or Abaqus, or what else meshio reads.

    In a deck, a node set names the facets of the outline between its nodes, in the plane a set of lines (T3D2, as gmsh writes curves) the facets that
    they are, and any other element set a subdomain; names are in capital letters. Nodes of no element are left out. The extra `mesh` of the
    installation brings meshio.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    MeshTri, MeshQuad, MeshTet or MeshHex
        Mesh of scikit-fem with `boundaries` and `subdomains`.

    Raises
    ------
    ModelError
        The file is missing or unreadable; elements of several shapes (they would be cut or dropped in silence), quadratic ones; nodes of a
        plane mesh out of the plane z = 0.

    Examples
    --------
    >>> import frictopt as fo
    >>> mesh = fo.read_mesh("tests/data/flat.inp")
    >>> mesh.t.shape, sorted(mesh.boundaries)[3:5]
    ((3, 865), ['N_CONTACT_BLOCK', 'N_CONTACT_PUNCH'])
    """
    file = file_path("path", path)
    if file.suffix.lower() == ".inp":
        deck = read_deck(file)
        mesh = mesh_of(deck, 2 if deck.shaped()[0] in _PLANE else 3)
        return _named(mesh, deck).remove_unused_nodes()
    found = _read(file)
    kinds = {block.type for block in found.cells if len(block.data)} - set(_SMALL)
    solids = sorted(kinds - set(_PLANE) if kinds & set(_SOLID) else kinds)  # faces of solids only carry names
    if len(solids) != 1 or solids[0] not in _PLANE + _SOLID:
        problem = f"elements {', '.join(solids)}" if solids else "no elements"
        raise ModelError(f"mesh {file.name}: {problem}; give linear elements of one shape: triangles, quadrilaterals, tetrahedra or hexahedra")
    own = {name: cells for name, cells in found.cell_sets.items() if not name.startswith("gmsh:")}  # of the user, not of gmsh itself
    found.cell_sets = own or _groups(found)
    found.field_data = {}
    try:
        mesh = _of_scikit_fem(found, solids[0])
    except (ValueError, IndexError, KeyError, TypeError) as error:
        raise ModelError(f"mesh {file.name}: scikit-fem cannot use it ({error}); write it again, as .msh 4.1 for instance") from error
    if mesh.dim() == 2:
        _check_plane(found.points, file.name)
    return mesh.remove_unused_nodes()


def mesh_of(deck: Deck, directions: int) -> Mesh:
    """scikit-fem mesh of a deck, its nodes in the order of the deck.

    Raises
    ------
    ModelError
        Elements of several shapes or of one that is not supported, a mesh in space where a plane one is wanted, or the reverse.
    """
    shape, _, nodes = deck.shaped()
    if (shape in _PLANE) != (directions == 2):
        raise ModelError(f"deck: elements of shape {shape}, but {directions} directions of displacement; give plane elements for 2, solids for 3")
    if directions == 2:
        _check_plane(deck.points, "of the deck")
    return _of_scikit_fem(meshio_library().Mesh(deck.points, [(shape, nodes)]), shape)


def file_path(argument: str, path: str | Path) -> Path:
    """The path as such."""
    if not isinstance(path, str | Path) or not str(path):
        raise ModelError(f"{argument}: {shown(path)}; give the path of a file")
    return Path(path)


def _named(mesh: Mesh, deck: Deck) -> Mesh:
    """The mesh with the sets of its deck as boundaries and subdomains."""
    facets = mesh.boundary_facets()
    boundaries: dict[str, Integers] = {name: facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)] for name, nodes in deck.sets.items()}
    numbers = deck.shaped()[1]
    subdomains = {name: np.flatnonzero(np.isin(numbers, members)) for name, members in deck.element_sets.items()}
    if mesh.dim() == 2:
        lines, ends = deck.lines
        facet = csr_matrix((np.arange(1, mesh.facets.shape[1] + 1), mesh.facets), shape=(len(deck.points),) * 2)  # by its nodes, the lower one first
        for name, members in deck.element_sets.items():
            low, high = np.sort(ends[np.isin(lines, members)]).T
            if len(low):
                boundaries[name] = np.setdiff1d(facet[low, high], [0]) - 1
    return mesh.with_boundaries({name: found for name, found in boundaries.items() if len(found)}).with_subdomains(
        {name: found for name, found in subdomains.items() if len(found)}
    )


def _check_plane(points: Array, what: str) -> None:
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > SAME_POINT * np.ptp(points):
        raise ModelError(f"mesh {what}: z varies by {np.ptp(points[:, 2]):g}; give a mesh in the plane z = 0")


def _read(file: Path) -> Any:
    library = meshio_library()
    try:
        with redirect_stdout(StringIO()):  # meshio prints why each format that it tries first does not fit
            return library.read(file)
    except (Exception, SystemExit) as error:  # meshio leaves the process where a file is damaged
        raise ModelError(f"mesh {str(file)!r}: meshio cannot read it ({str(error).strip() or type(error).__name__}); give a mesh file") from error


def _groups(found: Any) -> dict[str, list[Integers]]:
    """Groups of `.msh` 2.2, which has them as numbers of cells, as the sets of cells that later versions have."""
    blocks = list(zip(found.cells, found.cell_data.get("gmsh:physical", []), strict=False))  # nothing else has them
    return {name: [np.flatnonzero((own == group) & (cells.dim == dim)) for cells, own in blocks] for name, (group, dim) in found.field_data.items()}


def _of_scikit_fem(mesh: Any, shape: str) -> Mesh:
    """The mesh of scikit-fem, from one of meshio."""
    from skfem.io.meshio import from_meshio  # here, for it imports meshio

    return from_meshio(mesh, force_meshio_type=shape)


def meshio_library() -> Any:
    """The library meshio, where it is installed."""
    try:
        import meshio  # of the extra `mesh`
    except ImportError as error:
        raise ModelError("meshio: not installed; install frictopt with its extra `mesh`") from error
    return meshio
