"""Meshes of files and decks, through meshio and scikit-fem."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Mesh

from ..base import SAME_POINT, Array, Integers, place
from ..base.libraries import file_path, library
from ..errors import ModelError
from ..fem.elasticity import QUADRATIC, completion, places_among
from .deck import FREE, PLANE, SOLID, Deck
from .groups import GROUPED, deck_of_file
from .keywords import read_deck

_CORNERS = {  # of the faces S1, S2, ... of an element in decks
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh with its named boundaries and subdomains: `.msh` of gmsh, `.inp` of CalculiX or Abaqus, or what else meshio reads.

    In gmsh, physical volumes (in the plane surfaces) are subdomains and physical surfaces (curves)
    boundaries, called by number if without name. In a deck, a node set names the facets of the
    outline between its nodes; a set of faces (CPS3, CPS4; in the plane of lines, T3D2; gmsh writes
    both) or a surface names the facets that they are; and any other element set is a subdomain;
    names are in capital letters. Groups of Salome (`.med`) are read by their names. Nodes of no
    element are left out. The page "What is read of a file" lists what is kept, refused, or without
    effect. The extra `mesh` of the installation brings meshio.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Mesh
        MeshTri, MeshQuad, MeshTet or MeshHex of scikit-fem with `boundaries` and `subdomains`; of
        quadratic elements MeshTri2, MeshQuad2, MeshTet2 or MeshHex2. Where only edges have a node
        in the middle (8-node quadrilaterals, 20-node hexahedra), those amid faces and elements are
        added.

    Raises
    ------
    ModelError
        The file is missing or unreadable; elements of several shapes (they would be cut or dropped
        in silence), or of which some are quadratic; a boundary whose faces belong to no element, or
        that has none; a surface of other faces than those of solids; faces in space without solids;
        midside nodes that elements do not share.

    Examples
    --------
    >>> import frictopt as fo
    >>> mesh = fo.read_mesh("tests/data/flat.inp")
    >>> mesh.t.shape, sorted(mesh.boundaries)[3:5]
    ((3, 865), ['N_CONTACT_BLOCK', 'N_CONTACT_PUNCH'])
    """
    file = file_path("path", path)
    deck = read_deck(file, mesh_alone=True) if file.suffix.lower() == ".inp" else deck_of_file(file)
    try:
        shape, _, elements = deck.shaped()
        mesh = mesh_of(deck, 2 if shape in PLANE else 3)
    except (
        ModelError,
        ValueError,
        IndexError,
    ) as error:  # scikit-fem refuses elements of nodes that are not in the file
        raise ModelError(f"mesh {file.name}: {str(error).removeprefix('deck: ')}") from error
    return with_midsides(named(mesh, deck, file.name).remove_unused_nodes(), elements, deck.points)[
        0
    ]


def mesh_of(deck: Deck, directions: int) -> Mesh:
    """scikit-fem mesh of a deck, through the corners of its elements and with its nodes in the order of the deck."""
    shape, _, nodes = deck.shaped()
    if (shape in PLANE) != (directions == 2):
        raise ModelError(
            f"deck: elements of shape {shape}, but {directions} directions of displacement; give plane elements for 2, solids for 3"
        )
    z = np.ptp(deck.points[:, 2])
    if directions == 2 and z > SAME_POINT * np.ptp(deck.points):
        raise ModelError(
            f"deck: z varies by {z:g}, and there are no solids; give a mesh in z = 0, or in gmsh physical groups of the volumes"
        )
    linear = shape.rstrip("0123456789")
    whole = library().Mesh(deck.points, [(linear, nodes[:, : (PLANE | SOLID)[linear]])])
    from skfem.io.meshio import from_meshio  # here, for it imports meshio

    return from_meshio(whole, force_meshio_type=linear)


def between(mesh: Mesh, nodes: Integers, numbers: Integers | None = None) -> Integers:
    """Facets of the outline all corners of which are among some nodes; with the numbers of all nodes, each of these is a corner of one."""
    facets = mesh.boundary_facets()
    inside = facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]
    if not len(inside):
        raise ModelError(
            f"nodes: no facet of the outline lies between these {len(nodes)} nodes; give the nodes of a face"
        )
    if numbers is not None and len(lost := np.setdiff1d(nodes, mesh.facets[:, inside])):
        raise ModelError(
            f"nodes: node {numbers[lost[0]]} lies on no facet of the outline between these nodes; give the nodes of a face"
        )
    return np.asarray(inside)


def with_midsides(mesh: Mesh, elements: Integers, points: Array) -> tuple[Mesh, csr_matrix]:
    """The mesh of quadratic elements through whose corners a linear one goes, and the (its nodes, points) matrix of its nodes by the given ones.

    `elements` (m, k) are the nodes of its elements as rows of the points, in the order of meshio;
    linear ones are left as they are.
    """
    from skfem.io.meshio import INV_HEX_MAPPING  # here, for it imports meshio

    given, corners = elements.shape[1], len(mesh.t)
    used, t = np.unique(elements[:, :corners], return_inverse=True)
    numbers = np.unique(mesh.t)
    if given == corners:
        return mesh, csr_matrix(
            (np.ones(len(used)), (numbers, used)), shape=(mesh.p.shape[1], len(points))
        )
    order, kind = (
        INV_HEX_MAPPING[:given] if corners == 8 else np.arange(given),
        QUADRATIC[type(mesh)],
    )
    t = numbers[t.reshape(-1, corners)][
        :, order[:corners]
    ].T  # in the order of the file: scikit-fem sorts the corners of triangles
    curved = kind(mesh.p, np.ascontiguousarray(t), mesh.boundaries, mesh.subdomains)
    node, first = np.unique(curved.dofs.element_dofs, return_index=True)
    local, element = np.divmod(first, len(elements))
    weights, places = completion(kind, given)[local], elements[element][:, order]
    origin = csr_matrix(
        (weights.ravel(), (np.repeat(node, given), places.ravel())),
        shape=(curved.dofs.N, len(points)),
    )
    origin.eliminate_zeros()
    if len(lost := np.setdiff1d(elements, origin.indices)):
        raise ModelError(
            f"mesh: the midside node at {place(points[lost[0]])} is on an edge that has another one; merge nodes that coincide"
        )
    return replace(
        curved, doflocs=np.ascontiguousarray((origin @ points[:, : mesh.dim()]).T)
    ), origin


def named(mesh: Mesh, deck: Deck, what: str) -> Mesh:
    """The mesh with the sets of its deck as boundaries and subdomains."""
    facets, (shape, numbers, elements) = mesh.boundary_facets(), deck.shaped()
    subdomains = {
        name: own
        for name, members in deck.element_sets.items()
        if len(own := np.flatnonzero(np.isin(numbers, members)))
    }
    # whose node sets have all their nodes, and name no outline
    bodies = {
        name
        for name, own in subdomains.items()
        if name in deck.sets and np.isin(elements[own], deck.sets[name]).all()
    }
    outlines = {
        name: facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]
        for name, nodes in deck.sets.items()
        if name not in bodies
    }
    faces = {
        name: [nodes[np.isin(own, members)] for own, nodes in deck.faces]
        for name, members in deck.element_sets.items()
    }
    corners = next(found for kind, found in _CORNERS.items() if shape.startswith(kind))
    for name, parts in deck.surfaces.items():
        if odd := [face for _, face in parts if face > len(corners)]:
            raise ModelError(
                f"mesh {what}: surface {name}: face S{odd[0]} of elements with {len(corners)} faces; repair the deck"
            )
        faces[name] = []
        for own, face in parts:
            members = np.isin(numbers, own)
            free = mesh.facets[:, facets[members[mesh.f2t[0, facets]]]].T
            faces[name].append(free if face == FREE else elements[members][:, corners[face - 1]])
        if not any(map(len, faces[name])):
            raise ModelError(
                f"mesh {what}: surface {name!r}: no solid of the deck has one of its faces; repair it, or take it out"
            )
    found, k = {name: own for name, own in outlines.items() if len(own)}, len(mesh.facets)
    for name, blocks in faces.items():
        nodes = np.concatenate(
            [np.zeros((0, k), dtype=int), *(own[:, :k] for own in blocks if own.shape[1] >= k)]
        )
        places = places_among(nodes, mesh.facets.T)
        lost, some = np.count_nonzero(places < 0), any(map(len, blocks))
        if lost or (some and not len(nodes)):
            raise ModelError(
                f"mesh {what}: boundary {name!r}: {lost} of its {len(nodes)} faces belong to no element; {GROUPED}"
            )
        if some:
            found[name] = np.unique(places)
    return mesh.with_boundaries(found).with_subdomains(subdomains)
