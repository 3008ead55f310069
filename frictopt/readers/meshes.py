"""Meshes of files and decks, through meshio and scikit-fem."""

import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..base import SAME_POINT, Integers
from ..base.files import file_path
from ..errors import ModelError, ModelWarning
from ..fem.mixed import MIXED, places_among
from .bulk_data import bulk_deck
from .deck import FREE, LINES, PLANE_CORNERS, PLANES, THIN, Deck, corner_shape
from .groups import deck_of_file
from .keywords import read_deck
from .mixed_elements import FACE_CORNERS, in_tetrahedra, mesh_through_corners, with_midsides

# Ends of the names of files of Nastran's bulk data.
_NASTRAN = (".bdf", ".fem", ".nas")


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh with its named boundaries and subdomains.

    The file is a `.msh` of gmsh, an `.inp` of CalculiX or Abaqus, bulk data of Nastran (`.bdf`,
    `.nas`, `.fem`), or any other file that meshio reads. In gmsh, physical volumes are subdomains
    and physical surfaces are boundaries; in the plane, physical surfaces are subdomains and
    physical curves are boundaries. A group without a name is named by its number. In a deck, three
    things name a boundary: a node set (the facets of the outline between its nodes), a surface (its
    faces), and a set of elements that are faces (CPS3, CPS4; in the plane lines, T3D2; gmsh writes
    both). Any other element set is a subdomain. Names from decks are in capital letters.
    Groups of Salome (`.med`) are read by their names, and properties of Nastran by their numbers.
    Nodes without elements are left out. Elements that are neither solids nor their faces or edges,
    such as shells and rigid lines, are left out with one `ModelWarning`, which counts them and
    names their sets. The page "What is read of a file" lists all keywords: kept, refused, or
    without effect. The extra `mesh` of the installation brings meshio.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Mesh
        MeshTri, MeshQuad, MeshTet or MeshHex of scikit-fem with `boundaries` and `subdomains`; for
        quadratic elements MeshTri2, MeshQuad2, MeshTet2 or MeshHex2. If only edges have a node in
        the middle (8-node quadrilaterals, 20-node hexahedra), the nodes in the middle of faces and
        elements are added. Linear wedges, and linear elements of several shapes, become
        quadrilaterals or hexahedra with coincident corners. Quadratic wedges, and quadratic
        elements of several shapes, are cut into quadratic tetrahedra (in the plane into triangles).
        A linear element beside quadratic elements becomes quadratic.

    Raises
    ------
    ModelError
        The file is missing or unreadable, or its format is unknown. It has no solids, or elements
        whose faces are not known. A surface of a deck or a named group of gmsh is empty. A linear
        and a quadratic element share an edge. Neighbouring elements do not share their midside
        nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> mesh = fo.readers.read_mesh("tests/data/flat.inp")
    >>> mesh.t.shape, sorted(mesh.boundaries)[3:5]
    ((3, 865), ['N_CONTACT_BLOCK', 'N_CONTACT_PUNCH'])
    """
    file = file_path("path", path)
    ending = file.suffix.lower()
    if ending == ".inp":
        listed = read_deck(file, mesh_alone=True)
    elif ending in _NASTRAN:
        listed = bulk_deck(file, mesh_alone=True)
    else:
        listed = deck_of_file(file)
    deck = listed.without_thin()
    mesh = corner_mesh(deck, file.name)
    _warn_of_others(mesh, listed, file)
    return named_mesh(mesh, deck, file.name)[0]


def corner_mesh(deck: Deck, name: str) -> Mesh:
    """The mesh through the corners of the elements of a deck; errors call the deck by its name."""
    try:
        return mesh_of(deck, 2 if deck.by_shape()[0].kind in PLANE_CORNERS else 3)
    # scikit-fem refuses elements of nodes that are not in the file.
    except (ValueError, IndexError) as error:
        raise ModelError(f"mesh {name}: {str(error).removeprefix('deck: ')}") from error


def named_mesh(mesh: Mesh, deck: Deck, name: str) -> tuple[Mesh, csr_matrix]:
    """The mesh of a deck with its sets and all its nodes, from the mesh through its corners.

    The second result is the (nodes of the mesh, points of the deck) matrix whose rows give each
    node as a mean of points.
    """
    mesh = with_sets(mesh, deck, name)
    if isinstance(mesh, MIXED) and not deck.is_linear:
        return in_tetrahedra(mesh, deck)
    return with_midsides(mesh.remove_unused_nodes(), deck)


def _warn_of_others(mesh: Mesh, deck: Deck, file: Path) -> None:
    """Warn of elements of a deck that are not elements, faces or edges of its mesh."""
    counts: Counter[str] = Counter()
    names = set()
    for kind, numbers, nodes in deck.elements:
        if kind.startswith(THIN):
            others = numbers
        elif kind.startswith(LINES):
            sides = mesh.facets if mesh.dim() == 2 else mesh.edges
            others = numbers[places_among(nodes[:, [0, -1]], sides.T) < 0]
        elif kind.startswith(PLANES) and mesh.dim() == 3:
            faces = _corners_of_faces(nodes, len(mesh.facets))
            others = numbers[places_among(faces, mesh.facets.T) < 0]
        else:
            continue
        counts[kind] += len(others)
        names |= {name for name, set_ in deck.element_sets.items() if np.isin(others, set_).any()}
    if counts.total():
        types = ", ".join(f"{count} of type {kind}" for kind, count in counts.items() if count)
        sets = f" (in {', '.join(map(repr, sorted(names)))})" if names else ""
        warnings.warn(
            f"mesh {file.name}: elements that are neither solids nor their faces or edges are left "
            f"out: {types}{sets}; if they are faces of a body, save that body in the file, too "
            "(gmsh saves only what is in a group)",
            ModelWarning,
            stacklevel=3,  # the line that calls `read_mesh`
        )


def mesh_of(deck: Deck, directions: int) -> Mesh:
    """scikit-fem mesh through the corners of a deck's elements, with nodes in the deck's order."""
    parts = deck.by_shape()
    shape = parts[0].kind
    if (shape in PLANE_CORNERS) != (directions == 2):
        raise ModelError(
            f"deck: elements of shape {shape}, but {directions} directions of displacement; "
            "give plane elements for 2, solids for 3"
        )
    z = np.ptp(deck.points[np.concatenate([part.nodes.ravel() for part in parts]), 2])
    if directions == 2 and z > SAME_POINT * np.ptp(deck.points):
        raise ModelError(
            f"deck: z varies by {z:g}, and there are no solids; "
            "give a mesh in z = 0, or in gmsh physical groups of the volumes"
        )
    return mesh_through_corners(parts, deck.points[:, :directions])


def between(mesh: Mesh, nodes: Integers, numbers: Integers | None = None) -> Integers:
    """Facets of the outline whose corners are all among some nodes.

    If the numbers of all nodes are given, each of the nodes must be a corner of such a facet.
    """
    facets = _outline_between(mesh, nodes)
    if not len(facets):
        raise ModelError(
            f"nodes: no facet of the outline lies between these nodes ({len(nodes)}); "
            "give the nodes of a face"
        )
    if numbers is not None:
        alone = np.setdiff1d(nodes, mesh.facets[:, facets])
        if len(alone):
            raise ModelError(
                f"nodes: node {numbers[alone[0]]} lies on no facet of the outline between these "
                "nodes; give the nodes of a face"
            )
    return facets


def _outline_between(mesh: Mesh, nodes: Integers) -> Integers:
    facets = mesh.boundary_facets()
    return np.asarray(facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)])


def with_sets(mesh: Mesh, deck: Deck, what: str) -> Mesh:
    """The mesh with the sets of its deck as boundaries and subdomains.

    A set whose elements are not faces of the mesh becomes no boundary.
    """
    subdomains = _subdomains(deck)
    boundaries = _boundaries_of_node_sets(mesh, deck, subdomains)
    # A surface takes precedence over an element set, and both over a node set of the same name.
    faces = _faces_of_element_sets(deck) | _faces_of_surfaces(mesh, deck, what)
    for name, blocks in faces.items():
        if not any(map(len, blocks)):
            continue
        facets = _facets_of(mesh, blocks)
        if len(facets):
            boundaries[name] = facets
    return mesh.with_boundaries(boundaries).with_subdomains(subdomains)


def _subdomains(deck: Deck) -> dict[str, Integers]:
    """Element set -> its elements in the mesh; sets without elements are left out."""
    numbers = np.concatenate([part.numbers for part in deck.by_shape()])
    subdomains = {}
    for name, members in deck.element_sets.items():
        elements = np.flatnonzero(np.isin(numbers, members))
        if len(elements):
            subdomains[name] = elements
    return subdomains


def _boundaries_of_node_sets(
    mesh: Mesh, deck: Deck, subdomains: Mapping[str, Integers]
) -> dict[str, Integers]:
    """Node set -> facets of the outline between its nodes; sets without facets are left out."""
    boundaries = {}
    for name, nodes in deck.sets.items():
        # A set of all nodes of a subdomain, under its name, does not name a boundary.
        if name in subdomains and np.isin(mesh.t[:, subdomains[name]], nodes).all():
            continue
        facets = _outline_between(mesh, nodes)
        if len(facets):
            boundaries[name] = facets
    return boundaries


def _faces_of_element_sets(deck: Deck) -> dict[str, list[Integers]]:
    """Element set -> nodes (m, k) of the elements in it that only name faces, block by block."""
    faces = deck.faces
    return {
        name: [nodes[np.isin(numbers, members)] for numbers, nodes in faces]
        for name, members in deck.element_sets.items()
    }


def _faces_of_surfaces(mesh: Mesh, deck: Deck, what: str) -> dict[str, list[Integers]]:
    """Surface of elements -> corners (m, k) of its faces, part by part."""
    shapes = deck.by_shape()
    numbers = np.concatenate([part.numbers for part in shapes])
    outline = mesh.boundary_facets()
    faces: dict[str, list[Integers]] = {}
    for name, parts in deck.surfaces.items():
        faces[name] = []
        for members, face in parts:
            if face == FREE:
                free = outline[np.isin(numbers, members)[mesh.f2t[0, outline]]]
                faces[name].append(mesh.facets[:, free].T)
                continue
            for shape, of_shape, elements in shapes:
                named = elements[np.isin(of_shape, members)]
                face_corners = FACE_CORNERS[corner_shape(shape)]
                if face > len(face_corners) and len(named):
                    raise ModelError(
                        f"mesh {what}: surface {name}: face S{face} of elements with "
                        f"{len(face_corners)} faces; repair the deck"
                    )
                if len(named):
                    faces[name].append(named[:, face_corners[face - 1]])
        if not any(map(len, faces[name])):
            raise ModelError(
                f"mesh {what}: surface {name!r}: no solid of the deck has one of its faces; "
                "repair it, or take it out"
            )
    return faces


def _facets_of(mesh: Mesh, blocks: list[Integers]) -> Integers:
    """Facets of the mesh that are the given faces, whose nodes (m, k) begin with the corners."""
    corners = len(mesh.facets)
    faces = [_corners_of_faces(block, corners) for block in blocks]
    return np.setdiff1d(places_among(np.concatenate(faces), mesh.facets.T), [-1])


def _corners_of_faces(block: Integers, corners: int) -> Integers:
    """The corners (m, corners) of faces (m, nodes).

    A triangle repeats its last corner if the array has four columns.
    """
    is_triangle = block.shape[1] in (3, 6, 7)
    if corners == 4 and is_triangle:
        return block[:, [0, 1, 2, 2]]
    return block[:, :corners]
