"""Meshes of files and decks, through meshio and scikit-fem."""

from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import replace
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ...contact import SAME_POINT, Array, Integers, place, shown
from ...errors import ModelError
from ..elasticity import QUADRATIC, completion, places_among
from .deck import PLANE, SOLID, Constraints, Deck
from .keywords import read_deck

_CORNERS = {  # of the faces S1, S2, ... of an element in decks
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
_GROUPS = "put the body beside it into a group too (gmsh saves only what is in one)"


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh with its named boundaries and subdomains: `.msh` of gmsh, `.inp` of CalculiX or Abaqus, or what else meshio reads.

    In gmsh, physical volumes (in the plane surfaces) are subdomains and physical surfaces (curves) boundaries, called by number if without name. In
    a deck, a node set names the facets of the outline between its nodes, a set of faces (CPS3, CPS4; in the plane of lines, T3D2; gmsh writes both)
    or a surface of element faces (S1, S2, ...) the facets that they are, and any other element set a subdomain; names are in capital letters. Nodes
    of no element are left out. The extra `mesh` of the installation brings meshio.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Mesh
        MeshTri, MeshQuad, MeshTet or MeshHex of scikit-fem with `boundaries` and `subdomains`; of quadratic elements MeshTri2, MeshQuad2, MeshTet2 or
        MeshHex2. Where only edges have a node in the middle (8-node quadrilaterals, 20-node hexahedra), those amid faces and elements are added.

    Raises
    ------
    ModelError
        The file is missing or unreadable; elements of several shapes (they would be cut or dropped in silence), or of which some are quadratic; a
        boundary whose faces belong to no element, or that has none; faces in space without solids; midside nodes that elements do not share.

    Examples
    --------
    >>> import frictopt as fo
    >>> mesh = fo.read_mesh("tests/data/flat.inp")
    >>> mesh.t.shape, sorted(mesh.boundaries)[3:5]
    ((3, 865), ['N_CONTACT_BLOCK', 'N_CONTACT_PUNCH'])
    """
    file = file_path("path", path)
    deck = read_deck(file) if file.suffix.lower() == ".inp" else _deck_of(file)
    try:
        shape, _, elements = deck.shaped()
        mesh = mesh_of(deck, 2 if shape in PLANE else 3)
    except (ModelError, ValueError, IndexError) as error:  # scikit-fem refuses elements of nodes that are not in the file
        raise ModelError(f"mesh {file.name}: {str(error).removeprefix('deck: ')}") from error
    return with_midsides(named(mesh, deck, file.name).remove_unused_nodes(), elements, deck.points)[0]


def mesh_of(deck: Deck, directions: int) -> Mesh:
    """scikit-fem mesh of a deck, through the corners of its elements and with its nodes in the order of the deck."""
    shape, _, nodes = deck.shaped()
    if (shape in PLANE) != (directions == 2):
        raise ModelError(f"deck: elements of shape {shape}, but {directions} directions of displacement; give plane elements for 2, solids for 3")
    z = np.ptp(deck.points[:, 2])
    if directions == 2 and z > SAME_POINT * np.ptp(deck.points):
        raise ModelError(f"deck: z varies by {z:g}, and there are no solids; give a mesh in z = 0, or in gmsh physical groups of the volumes")
    linear = shape.rstrip("0123456789")
    whole = library().Mesh(deck.points, [(linear, nodes[:, : (PLANE | SOLID)[linear]])])
    from skfem.io.meshio import from_meshio  # here, for it imports meshio

    return from_meshio(whole, force_meshio_type=linear)


def between(mesh: Mesh, nodes: Integers, numbers: Integers | None = None) -> Integers:
    """Facets of the outline all corners of which are among some nodes; with the numbers of all nodes, each of these is a corner of one."""
    facets = mesh.boundary_facets()
    inside = facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]
    if not len(inside):
        raise ModelError(f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face")
    if numbers is not None and len(lost := np.setdiff1d(nodes, mesh.facets[:, inside])):
        raise ModelError(f"nodes: node {numbers[lost[0]]} lies on no facet of the outline between these nodes; give the nodes of a face")
    return np.asarray(inside)


def with_midsides(mesh: Mesh, elements: Integers, points: Array) -> tuple[Mesh, csr_matrix]:
    """The mesh of quadratic elements through whose corners a linear one goes, and the (its nodes, points) matrix of its nodes by the given ones.

    `elements` (m, k) are the nodes of its elements as rows of the points, in the order of meshio; linear ones are left as they are.
    """
    from skfem.io.meshio import INV_HEX_MAPPING  # here, for it imports meshio

    given, corners = elements.shape[1], len(mesh.t)
    used, t = np.unique(elements[:, :corners], return_inverse=True)
    numbers = np.unique(mesh.t)
    if given == corners:
        return mesh, csr_matrix((np.ones(len(used)), (numbers, used)), shape=(mesh.p.shape[1], len(points)))
    order, kind = INV_HEX_MAPPING[:given] if corners == 8 else np.arange(given), QUADRATIC[type(mesh)]
    t = numbers[t.reshape(-1, corners)][:, order[:corners]].T  # in the order of the file: scikit-fem sorts the corners of triangles
    curved = kind(mesh.p, np.ascontiguousarray(t), mesh.boundaries, mesh.subdomains)
    node, first = np.unique(curved.dofs.element_dofs, return_index=True)
    local, element = np.divmod(first, len(elements))
    weights, places = completion(kind, given)[local], elements[element][:, order]
    origin = csr_matrix((weights.ravel(), (np.repeat(node, given), places.ravel())), shape=(curved.dofs.N, len(points)))
    origin.eliminate_zeros()
    if len(lost := np.setdiff1d(elements, origin.indices)):
        raise ModelError(f"mesh: the midside node at {place(points[lost[0]])} is on an edge that has another one; merge nodes that coincide")
    return replace(curved, doflocs=np.ascontiguousarray((origin @ points[:, : mesh.dim()]).T)), origin


def file_path(argument: str, path: str | Path) -> Path:
    """The path as such."""
    if not isinstance(path, str | Path) or not str(path):
        raise ModelError(f"{argument}: {shown(path)}; give the path of a file")
    return Path(path)


def named(mesh: Mesh, deck: Deck, what: str) -> Mesh:
    """The mesh with the sets of its deck as boundaries and subdomains."""
    facets, (shape, numbers, elements) = mesh.boundary_facets(), deck.shaped()
    subdomains = {name: own for name, members in deck.element_sets.items() if len(own := np.flatnonzero(np.isin(numbers, members)))}
    # whose node sets have all their nodes, and name no outline
    bodies = {name for name, own in subdomains.items() if name in deck.sets and np.isin(elements[own], deck.sets[name]).all()}
    outlines = {name: facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)] for name, nodes in deck.sets.items() if name not in bodies}
    faces = {name: [nodes[np.isin(own, members)] for own, nodes in deck.faces] for name, members in deck.element_sets.items()}
    corners = next(found for kind, found in _CORNERS.items() if shape.startswith(kind))
    for name, parts in deck.surfaces.items():
        if odd := [face for _, face in parts if face > len(corners)]:
            raise ModelError(f"mesh {what}: surface {name}: face S{odd[0]} of elements with {len(corners)} faces; repair the deck")
        faces[name] = [elements[np.isin(numbers, own)][:, corners[face - 1]] for own, face in parts]
    found, k = {name: own for name, own in outlines.items() if len(own)}, len(mesh.facets)
    for name, blocks in faces.items():
        nodes = np.concatenate([np.zeros((0, k), dtype=int), *(own[:, :k] for own in blocks if own.shape[1] >= k)])
        places = places_among(nodes, mesh.facets.T)
        lost, some = np.count_nonzero(places < 0), any(map(len, blocks))
        if lost or (some and not len(nodes)):
            raise ModelError(f"mesh {what}: boundary {name!r}: {lost} of its {len(nodes)} faces belong to no element; {_GROUPS}")
        if some:
            found[name] = np.unique(places)
    return mesh.with_boundaries(found).with_subdomains(subdomains)


def _deck_of(file: Path) -> Deck:
    """What meshio reads, its elements numbered one block after the other; groups of gmsh without a name are called by their number."""
    with redirect_stdout(StringIO()):  # meshio prints why each format that it tries first does not fit
        found = by_library("meshio", library().read, file, "mesh")
    first = np.cumsum([0, *(len(block.data) for block in found.cells)])
    sets = {name: [np.zeros(0, dtype=np.intp)] for name in found.field_data}
    names = {(int(number), int(dim)): name for name, (number, dim) in found.field_data.items()}
    for start, block, own in zip(first, found.cells, found.cell_data.get("gmsh:physical", []), strict=False):  # nothing else has them
        for number in np.unique(own[own > 0]).tolist():
            sets.setdefault(names.get((number, block.dim), str(number)), []).append(start + np.flatnonzero(own == number))
    for name, cells in found.cell_sets.items():
        if not name.startswith("gmsh:"):  # not of gmsh itself
            sets[name] = [start + np.asarray(own, dtype=np.intp) for start, own in zip(first, cells, strict=False)]
    points = np.pad(found.points, ((0, 0), (0, 3 - found.points.shape[1])))
    blocks = ((block.type, start + np.arange(len(block.data)), block.data) for start, block in zip(first, found.cells, strict=False))
    elements = tuple((kind, numbers, nodes[:, [0, 2, 1]] if kind == "line3" else nodes) for kind, numbers, nodes in blocks if len(nodes))
    groups = {name: np.concatenate(own) for name, own in sets.items()}
    for name, (_, dim) in found.field_data.items():
        if dim == max(block.dim for block in found.cells) - 1 and not len(groups[name]):
            raise ModelError(f"mesh {file.name}: boundary {name!r}: it names no faces; {_GROUPS}")
    return Deck(np.arange(len(points)), points, {}, elements, groups, (), Constraints(np.zeros((len(points), 6), dtype=bool)))


def library(module: str = "meshio", name: str = "meshio", extra: str = "mesh") -> Any:
    """A module of a library, which is installed by its name or by an extra of ours."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ModelError(f"{name}: not installed; python -m pip install 'frictopt[{extra}]'") from error


def by_library(name: str, read: Callable[[str], Any], file: Path, what: str) -> Any:
    """What a library reads from a file."""
    if not file.is_file():
        raise ModelError(f"{what}: there is no file {str(file)!r}; give its path")
    try:
        return read(str(file))
    except (Exception, SystemExit) as error:  # libraries let through whatever a damaged file makes; meshio leaves the process
        problem = str(error).strip() or type(error).__name__
        raise ModelError(f"{what}: {name} cannot read {str(file)!r} ({problem}); give the file as the code wrote it") from error
