"""Meshes of files and decks, through meshio and scikit-fem."""

from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ...contact.checks import Array, place, shown
from ...contact.tolerances import SAME_POINT
from ...errors import ModelError
from ..elements import QUADRATIC, completion
from ..ordering import Integers, places_among
from .deck import Deck, read_deck
from .kinds import PLANE, SOLID
from .rows import library

_CORNERS = {  # of the faces S1, S2, ... of an element in decks
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}
_SMALL = ("vertex", "line", "line3")  # cells that only carry names


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
    if file.suffix.lower() == ".inp":
        deck = read_deck(file)
        try:
            mesh = mesh_of(deck, 2 if deck.shaped()[0] in PLANE else 3)
        except ModelError as error:
            raise ModelError(f"mesh {file.name}: {error}") from error
        return with_midsides(_named(mesh, deck, file.name).remove_unused_nodes(), deck.shaped()[2], deck.points)[0]
    found = _read(file)
    kinds = {block.type for block in found.cells if len(block.data)} - set(_SMALL)
    solids = sorted(kinds - set(PLANE) if kinds & set(SOLID) else kinds)  # faces of solids only carry names
    if len(solids) != 1 or solids[0] not in PLANE | SOLID:
        problem = f"elements {', '.join(solids)}" if solids else "no elements"
        raise ModelError(f"mesh {file.name}: {problem}; give elements of one shape, linear or quadratic: {', '.join(PLANE | SOLID)}")
    elements = np.concatenate([block.data for block in found.cells if block.type == solids[0]])
    groups, names = _groups(found), found.field_data
    try:
        mesh = _of_scikit_fem(elements, solids[0], found.points)
    except (ValueError, IndexError, KeyError, TypeError) as error:
        raise ModelError(f"mesh {file.name}: scikit-fem cannot use it ({error}); write it again, as .msh 4.1 for instance") from error
    d = mesh.dim()
    if d == 2:
        _check_plane(found.points, file.name)
    faces: dict[str, list[Integers]] = {name: [] for name, (_, dim) in names.items() if dim == d - 1}
    bodies: dict[str, list[Integers]] = {}
    for name, cells in groups.items():
        first = 0
        for block, own in zip(found.cells, cells, strict=False):
            if block.dim == d - 1 and len(own):
                faces.setdefault(name, []).append(block.data[own])
            elif block.type == solids[0]:
                bodies.setdefault(name, []).append(first + own)
                first += len(block.data)
    subdomains = {name: own for name, parts in bodies.items() if len(own := np.concatenate(parts))}
    mesh = mesh.with_boundaries(_faces(mesh, faces, file.name)).with_subdomains(subdomains).remove_unused_nodes()
    return with_midsides(mesh, elements, found.points)[0]


def mesh_of(deck: Deck, directions: int) -> Mesh:
    """scikit-fem mesh of a deck, through the corners of its elements and with its nodes in the order of the deck.

    Raises
    ------
    ModelError
        Elements of several shapes or of one that is not supported, a mesh in space where a plane one is wanted, or the reverse.
    """
    shape, _, nodes = deck.shaped()
    if (shape in PLANE) != (directions == 2):
        raise ModelError(f"deck: elements of shape {shape}, but {directions} directions of displacement; give plane elements for 2, solids for 3")
    if directions == 2:
        _check_plane(deck.points, "of the deck")
    return _of_scikit_fem(nodes, shape, deck.points)


def with_midsides(mesh: Mesh, elements: Integers, points: Array) -> tuple[Mesh, csr_matrix]:
    """The mesh of quadratic elements through whose corners a linear one goes, and the (its nodes, points) matrix of its nodes by the given ones.

    Parameters
    ----------
    mesh
        Linear mesh; corners keep its numbers.
    elements, points
        (m, k) nodes of its elements as rows of the (n, 2 or 3) points, in the order of meshio; linear ones are left as they are.

    Raises
    ------
    ModelError
        Elements with an edge in common that have different nodes amid it.
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


def _named(mesh: Mesh, deck: Deck, what: str) -> Mesh:
    """The mesh with the sets of its deck as boundaries and subdomains."""
    facets, (shape, numbers, elements) = mesh.boundary_facets(), deck.shaped()
    subdomains = {name: own for name, members in deck.element_sets.items() if len(own := np.flatnonzero(np.isin(numbers, members)))}
    bodies = {
        name for name, own in subdomains.items() if name in deck.sets and np.isin(elements[own], deck.sets[name]).all()
    }  # sets of all their nodes
    outlines = {name: facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)] for name, nodes in deck.sets.items() if name not in bodies}
    faces = {name: [nodes[np.isin(own, members)] for own, nodes in deck.faces] for name, members in deck.element_sets.items()}
    corners = next(found for kind, found in _CORNERS.items() if shape.startswith(kind))
    for name, parts in deck.surfaces.items():
        if odd := [face for _, face in parts if face > len(corners)]:
            raise ModelError(f"mesh {what}: surface {name}: face S{odd[0]} of elements with {len(corners)} faces; repair the deck")
        faces[name] = [elements[np.isin(numbers, own)][:, corners[face - 1]] for own, face in parts]
    named = _faces(mesh, {name: own for name, own in faces.items() if sum(map(len, own))}, what)
    return mesh.with_boundaries({name: own for name, own in outlines.items() if len(own)} | named).with_subdomains(subdomains)


def _faces(mesh: Mesh, faces: Mapping[str, Sequence[Integers]], what: str) -> dict[str, Integers]:
    """Facets of a mesh by their nodes, (m, k) in each of some blocks; each is a facet of an element."""
    found, k = {}, len(mesh.facets)
    for name, blocks in faces.items():
        nodes = np.unique(
            np.sort(np.concatenate([np.zeros((0, k), dtype=int), *(own[:, :k] for own in blocks if own.shape[1] >= k)]), axis=1), axis=0
        )
        places = places_among(nodes, mesh.facets.T)
        found[name] = np.sort(places)
        if (lost := np.count_nonzero(places < 0)) or not len(nodes):
            problem = f"{lost} of its {len(nodes)} faces belong to no element" if lost else "it names no faces"
            raise ModelError(f"mesh {what}: boundary {name!r}: {problem}; put the body beside it into a group too (gmsh saves only what is in one)")
    return found


def _check_plane(points: Array, what: str) -> None:
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > SAME_POINT * np.ptp(points):
        raise ModelError(
            f"mesh {what}: z varies by {np.ptp(points[:, 2]):g}, and there are no solids; give a mesh in the plane z = 0, or put the volumes of the "
            "bodies into groups (gmsh: physical groups; it saves only what is in one)"
        )


def _read(file: Path) -> Any:
    meshio = meshio_library()
    try:
        with redirect_stdout(StringIO()):  # meshio prints why each format that it tries first does not fit
            return meshio.read(file)
    except (Exception, SystemExit) as error:  # meshio leaves the process where a file is damaged
        raise ModelError(f"mesh {str(file)!r}: meshio cannot read it ({str(error).strip() or type(error).__name__}); give a mesh file") from error


def _groups(found: Any) -> dict[str, list[Integers]]:
    """Cells of each group in each block: sets of the author, and groups of gmsh, those without a name by their number."""
    names = {(int(number), int(dim)): name for name, (number, dim) in found.field_data.items()}
    tags = found.cell_data.get("gmsh:physical", [])  # nothing else has them
    groups: dict[str, list[Integers]] = {}
    for i, (cells, own) in enumerate(zip(found.cells, tags, strict=False)):
        for number in np.unique(own[own > 0]).tolist():
            group = groups.setdefault(names.get((number, cells.dim), str(number)), [np.zeros(0, dtype=np.intp) for _ in tags])
            group[i] = np.flatnonzero(own == number)
    return groups | {name: cells for name, cells in found.cell_sets.items() if not name.startswith("gmsh:")}  # not of gmsh itself


def _of_scikit_fem(elements: Integers, shape: str, points: Array) -> Mesh:
    """The mesh of scikit-fem through the corners of some elements."""
    from skfem.io.meshio import from_meshio  # here, for it imports meshio

    linear = shape.rstrip("0123456789")
    corners = elements[:, : (PLANE | SOLID)[linear]]
    return from_meshio(meshio_library().Mesh(points, [(linear, corners)]), force_meshio_type=linear)


def meshio_library() -> Any:
    """The library meshio."""
    return library("meshio", "meshio", "mesh")
