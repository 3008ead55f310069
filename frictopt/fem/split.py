"""One mesh of several bodies, as most mesh generators write it, split into the bodies."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from skfem import Mesh

from ..contact.checks import check_text, shown
from ..errors import ModelError
from .bodies import Body, check_kind
from .elasticity import ElementName, Material
from .elements import points_from


def split_bodies(mesh: Mesh, materials: Mapping[str, Material], *, element: ElementName | None = None) -> dict[str, Body]:
    """Split a mesh with a named subdomain for each body into bodies with nodes of their own.

    Each body keeps the named boundaries of the mesh that it has facets on. The facets that it shares with another body become one more boundary, of
    the name of that body: between a pin and a plate that share nodes the contact is `Contact("pin", "plate", "plate", "pin")`.

    Parameters
    ----------
    mesh
        The mesh, of a kind that a `Body` has, for example of `read_mesh("model.msh")`.
    materials
        Name of a subdomain -> material of the body; every element is in one of them.
    element
        Element of all bodies, see `Body`.

    Returns
    -------
    dict
        Name of the subdomain -> body.

    Raises
    ------
    ModelError
        Another kind of mesh, a subdomain that is unknown, elements in none or in two of the subdomains, a boundary called as another body, or what
        `Body` refuses.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> mesh = MeshQuad.init_tensor([0.0, 1.0], [-1.0, 0.0, 1.0])
    >>> mesh = mesh.with_subdomains({"punch": lambda x: x[1] > 0, "block": lambda x: x[1] < 0})
    >>> bodies = fo.split_bodies(mesh, {"punch": fo.Material(E=2.0), "block": fo.Material()})
    >>> sorted(bodies["punch"].mesh.boundaries)
    ['block']
    """
    check_kind(mesh)
    if not isinstance(materials, Mapping) or not materials:
        raise ModelError(f"materials: {shown(materials)}; give a mapping, name of a subdomain -> Material")
    subdomains = mesh.subdomains or {}
    owner = np.full(mesh.t.shape[1], -1)
    for number, name in enumerate(materials):
        check_text("materials: name", name, "the name of a subdomain")
        if name not in subdomains:
            hint = "" if subdomains else "; name each body in the mesh (gmsh: a physical group of its volumes, in the plane of its surfaces)"
            raise ModelError(f"materials: subdomain {name!r} is unknown; this mesh names {sorted(subdomains)}{hint}")
        elements = np.asarray(subdomains[name])
        if np.any(owner[elements] >= 0):
            raise ModelError(f"materials: subdomain {name!r} shares elements with {list(materials)[owner[elements].max()]!r}; give each to one body")
        owner[elements] = number
    if owner.min() < 0:
        raise ModelError(f"materials: {int((owner < 0).sum())} elements are in none of {list(materials)}; name all subdomains, or remove these")
    inner = np.flatnonzero(mesh.f2t[1] >= 0)
    sides = owner[mesh.f2t[:, inner]]
    bodies = {}
    for number, (name, material) in enumerate(materials.items()):
        boundaries = dict(mesh.boundaries or {})
        for other, neighbour in enumerate(materials):
            shared = inner[(sides == number).any(axis=0) & (sides == other).any(axis=0)]
            if other != number and len(shared):
                if neighbour in boundaries:
                    raise ModelError(f"mesh: boundary {neighbour!r} has the name of a body that {name!r} shares facets with; call it otherwise")
                boundaries[neighbour] = shared
        elements = np.flatnonzero(owner == number)
        own = replace(mesh, _boundaries=boundaries).restrict(elements, skip_subdomains=True)
        kept = {boundary: facets for boundary, facets in own.boundaries.items() if len(facets)}
        try:
            bodies[name] = Body(replace(own, doflocs=points_from(mesh, elements, own), _boundaries=kept), material, element)
        except ModelError as error:
            raise ModelError(f"body {name!r}: {error}") from error
    return bodies
