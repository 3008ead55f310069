"""A stiffness matrix that another code wrote, with the deck that says where its nodes are; and modes of vibration.

The modes are those that CalculiX printed. A mode makes a load.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh

from ..base import (
    Array,
    Integers,
    Shown,
    finite_array,
    finite_number,
    first_of,
    frozen,
    place,
    shown,
    whole,
    whole_array,
)
from ..base.libraries import file_path
from ..errors import ModelError
from ..fem.coincidence import coincident, coordinate_errors
from ..fem.elasticity import facet_nodes, parts_of, places_among
from ..fem.faces import lines_along
from ..fem.matrix_checks import checked_stiffness
from ..fem.rigid import node_graph
from .deck import Deck, checked_labels, displaced, rows_of_nodes, text_of
from .keywords import deck_of_points
from .meshes import between, mesh_of, named, with_midsides

_FREQUENCY = re.compile(
    r"^ +\d+(?: +\S+){2} +(\S+) +\S+ *$", re.MULTILINE
)  # number, eigenvalue, rad per time, cycles per time, imaginary part
_PRINTED = re.compile(r"displacements \(vx,vy,vz\).*\n\s*\n((?: *\d+(?: +\S+){3} *\n)+)")


def modal_load(
    M: object,
    mode: ArrayLike,
    *,
    natural_frequency: float | None = None,
    glued: ArrayLike | None = None,
) -> Array:
    """The load that moves a structure in one of its modes alone, `M mode`, for `condense`; its displacement is the amplitude of the mode.

    Parameters
    ----------
    M
        (n, n) mass matrix of the separate bodies, sparse; or, with a natural frequency, their
        stiffness as `condense` takes it.
    mode
        (n,) shape of a mode of the glued structure, of any size: it is normalised to unit modal
        mass.
    natural_frequency
        Frequency of the mode in cycles per unit of time, where `M` is the stiffness: `K mode` is
        `omega^2 M mode`, and the forces by which the glued bodies hold each other. None: it is the
        mass.
    glued
        With a natural frequency (m, 2) rows that are glued to each other, such as
        `job.unknowns[pairs].transpose(0, 2, 1).reshape(-1, 2)`; -1 where one is held. The forces
        between them cancel in their sum, of which each gets one half.

    Returns
    -------
    Array
        (n,) forces.

    Raises
    ------
    ModelError
        A matrix that is not square or of another size than the mode, or in which the mode has no
        mass; a stiffness without `glued`, or rows that it does not have.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> K, M = np.diag([8.0, 18.0]), np.diag([2.0, 2.0])
    >>> load = fo.modal_load(M, [3.0, 0.0])
    >>> load.round(6).tolist() == fo.modal_load(K, [1.0, 0.0], natural_frequency=2.0 / (2 * np.pi), glued=np.empty((0, 2))).round(6).tolist()
    True
    """
    shape = finite_array("mode", mode, (None,))
    matrix = checked_stiffness(M, "M")
    if matrix.shape != (len(shape), len(shape)):
        raise ModelError(
            f"M: shape {matrix.shape}, and a mode of {len(shape)} unknowns; give both in the same unknowns"
        )
    load = np.asarray(matrix @ shape)
    if natural_frequency is not None:
        if glued is None:
            raise ModelError(
                "glued: None; a stiffness needs the rows that are glued to each other, whose forces are not those of the mode"
            )
        rows = whole_array("glued", glued, (None, 2), least=-1, most=len(shape) - 1)
        mean = np.where((rows >= 0).all(axis=1), load[rows].mean(axis=1), 0.0)
        load[rows[rows >= 0]] = np.repeat(mean, (rows >= 0).sum(axis=1))
        load /= (2 * np.pi * finite_number("natural_frequency", natural_frequency, above=0.0)) ** 2
    mass = float(shape @ load)
    if not mass > 0:
        raise ModelError(
            f"mode: its modal mass is {mass:g}; give the mass matrix and a mode that moves it"
        )
    return frozen(load / np.sqrt(mass))


def printed_modes(path: Path, labels: Integers, deck: Deck | None) -> tuple[Array, Array]:
    """Frequencies (m,) and shapes (m, n) of a file `NAME.dat`, for the nodes and directions (n, 2) of n unknowns; see `MatrixJob.modes`."""
    rigid = (
        [] if deck is None else [deck.numbers[reference] for reference, _ in deck.constraints.rigid]
    )
    if not (displaced(labels) | np.isin(labels[:, 0], rigid)).all():
        raise ModelError(
            "modes: the matrix has unknowns that are no displacements of nodes, and CalculiX prints none else; find modes from K and M"
        )
    head, *modes = re.split(r"E I G E N V A L U E +N U M B E R +\d+", text_of(path, "modes"))
    table = head.partition("E I G E N V A L U E   O U T P U T")[2].partition(
        "P A R T I C I P A T I O N"
    )[0]
    frequencies = [float(value) for value in _FREQUENCY.findall(table)]
    if not frequencies or len(frequencies) != len(modes):
        counts = f"{len(frequencies)} frequencies and {len(modes)} modes"
        raise ModelError(
            f"modes: {str(path)!r} has {counts}; give the .dat of a step of *FREQUENCY with *NODE PRINT, NSET=.. of U"
        )
    return frozen(frequencies), frozen([_shape(mode, labels, path, deck) for mode in modes])


def _shape(mode: str, labels: Integers, path: Path, deck: Deck | None) -> Array:
    """(n,) displacements of one mode, and the rotations of rigid parts by the displacements of their nodes."""
    rows = [row.split() for block in _PRINTED.findall(mode) for row in block.splitlines()]
    printed = {
        int(node): [float(re.sub(r"(\d)([+-]\d{3})$", r"\1E\2", value)) for value in values]
        for node, *values in rows
    }
    needed, turned = set(labels[:, 0].tolist()), labels[~displaced(labels), 0]
    if deck is not None:
        for reference in np.flatnonzero(np.isin(deck.numbers, turned)).tolist():
            unknowns, R = deck.constraints.part(reference)
            nodes, number = deck.numbers[unknowns // 6].tolist(), int(deck.numbers[reference])
            needed |= {number, *nodes}
            if needed <= printed.keys():
                moved = [
                    printed[node][axis] for node, axis in zip(nodes, unknowns % 6, strict=True)
                ] - R[:, :3] @ printed[number]
                printed[number] += np.linalg.lstsq(R[:, 3:], moved)[0].tolist()
    if lost := sorted(needed - printed.keys()):
        raise ModelError(
            f"modes: {str(path)!r} has no displacement of node {lost[0]} of the matrix; print U of all nodes (*NODE PRINT)"
        )
    return np.array([printed[node][direction - 1] for node, direction in labels.tolist()])


@dataclass(frozen=True, eq=False, repr=False)
class LabelledMatrix(Shown):
    """Base of `MatrixJob`: its rows, bodies and mesh, the faces at which bodies match, and modes."""

    K: csr_matrix
    labels: Integers
    deck: Deck | Mapping[int, Sequence[float]] | None = None
    M: csr_matrix | None = None

    def __post_init__(self) -> None:
        labels, deck = (
            checked_labels(self.labels),
            deck_of_points(self.deck) if isinstance(self.deck, Mapping) else self.deck,
        )
        if deck is not None and not isinstance(deck, Deck):
            raise ModelError(
                f"deck: {shown(self.deck)}; give the deck of another job, a mapping number of a node -> its coordinates, or None"
            )
        vars(self).update(labels=labels, deck=deck)
        for name in ("K",) if self.M is None else ("K", "M"):
            matrix = checked_stiffness(getattr(self, name), name)
            if matrix.shape[0] != len(labels):
                raise ModelError(
                    f"{name}: {shown(matrix)}; give a real sparse matrix of the size of the labels, {len(labels)}"
                )
            vars(self)[name] = csr_matrix((matrix + matrix.T) / 2)

    def _answer(self) -> Mapping[str, object]:
        found = {
            "unknowns": len(self.labels),
            "directions": self._directions,
            "generalised": len(self.generalised),
        }
        sets = None if self.deck is None else sorted({*self._known.sets, *self._known.surfaces})
        return {name: count for name, count in found.items() if count} | {"sets": sets}

    @property
    def _directions(self) -> int:
        return max(2, int(self.labels[displaced(self.labels), 1].max()))

    @property
    def _known(self) -> Deck:
        if not isinstance(self.deck, Deck):
            raise ModelError(
                "deck: this job has none; read it with deck='NAME.inp' to use its nodes and sets"
            )
        return self.deck

    @cached_property
    def points(self) -> Array:
        """(nodes, d) coordinates of the nodes of the deck; d = 2 for a plane job."""
        return frozen(self._known.points[:, : self._directions])

    @cached_property
    def unknowns(self) -> Integers:
        """(nodes, d) row of K of each node's displacements, -1 where `*BOUNDARY` holds them, -2 where K has none else: they follow others.

        Where the job has no deck that tells held displacements (-1), those that K lacks are -2 too:
        such a node carries no contact until you say -1.

        Raises
        ------
        ModelError
            The matrix has labels of nodes that are not in the deck.
        """
        return rows_of_nodes(self.labels, self._known.numbers, self._known.constraints)[
            :, : self._directions
        ]

    @property
    def generalised(self) -> Integers:
        """(m,) rows of K that are no displacement of a node, which `condense` eliminates: rotations, modal unknowns, scalar points."""
        return np.flatnonzero(~displaced(self.labels))

    @cached_property
    def bodies(self) -> Integers:
        """(nodes,) number of the body that each node belongs to: what K joins is one body. -1 for nodes without a row in K."""
        _, body = connected_components(
            node_graph(self.K, self.unknowns, self.generalised), directed=False
        )
        present = (self.unknowns >= 0).any(axis=1)
        body[present] = np.unique(body[present], return_inverse=True)[1]
        return whole(np.where(present, body, -1))

    @cached_property
    def mesh(self) -> Mesh:
        """scikit-fem mesh of the deck through the corners of its elements, nodes in the order of `points`; see `Deck.shaped` for the errors."""
        return mesh_of(self._known, self._directions)

    @cached_property
    def _whole(self) -> tuple[Mesh, csr_matrix]:
        """The mesh with the nodes amid edges, and the (its nodes, nodes of the deck) matrix of its nodes."""
        return with_midsides(self.mesh, self._known.shaped()[2], self._known.points)

    def _matching(self) -> list[Integers]:
        """(N, 2) pairs of each connected face at which two bodies have their nodes, and the facets between them, in the same places.

        Without elements, in space, nodes alone tell, and what two bodies share is one face.
        """
        body, mesh = (
            self.bodies,
            self.mesh if self._known.elements or self._directions == 2 else None,
        )
        i, j = coincident(self.points, coordinate_errors(self.points, self._known.corners))
        i, j = np.where(body[i] < body[j], (i, j), (j, i))
        found: list[Integers] = []
        for a, b in combinations(np.unique(body[body >= 0]), 2):
            own = (body[i] == a) & (body[j] == b)
            one, two = i[own], j[own]
            for nodes in (one, two):
                if (k := first_of(np.bincount(nodes) > 1)) is not None:
                    raise ModelError(
                        f"matching_faces: the node at {place(self.points[k])} lies on several of one other body; merge these nodes"
                    )
            image = np.full(len(self.points), -1)
            image[two] = one
            found += [np.column_stack([image[nodes], nodes]) for nodes in _faces(mesh, image)]
        return found

    def nodes(self, where: str | ArrayLike) -> Integers:
        """Nodes as rows of `points`, each once.

        Parameters
        ----------
        where
            Name of a node set or surface; or the rows themselves, such as
            `np.flatnonzero(job.points[:, 1] == 0)`.

        Raises
        ------
        ModelError
            The deck names no such set, or it is empty; numbers that are no rows of `points`; a
            surface without faces, or between whose nodes there are other facets.
        """
        deck, name = self._known, where.upper() if isinstance(where, str) else ""
        if name in deck.sets or name not in deck.surfaces:
            return deck.nodes(where)
        alone = replace(deck, sets={}, element_sets={}, surfaces={name: deck.surfaces[name]})
        facets = named(self.mesh, alone, "of the deck").boundaries[name]
        whole, origin = self._whole
        if len(between(self.mesh, np.unique(self.mesh.facets[:, facets]))) != len(facets):
            raise ModelError(
                f"surface {name!r}: other facets lie between its nodes too; name flat parts of it"
            )
        return np.unique(origin[facet_nodes(whole, facets)].indices)

    def modes(self, path: str | Path) -> tuple[Array, Array]:
        """Natural frequencies (m,), cycles per unit of time, and shapes (m, n) of the modes that CalculiX printed, for `modal_load`.

        The file `NAME.dat` is that of a step of `*FREQUENCY` with `*NODE PRINT` of the
        displacements U of all nodes. Its deck has the nodes of this job, with the contact glued: by
        `*TIE`, by equations, or by nodes that the bodies share.

        Raises
        ------
        ModelError
            A file that is missing or holds no modes, or none of a node of the matrix; unknowns that
            are no displacements.

        Examples
        --------
        >>> import frictopt as fo
        >>> job = fo.read_calculix("tests/data/flat")
        >>> frequencies, shapes = job.modes("tests/data/flat_glued.dat")
        >>> frequencies.tolist(), shapes.shape
        ([24757.59, 47452.97], (2, 964))
        """
        return printed_modes(
            file_path("modes", path),
            self.labels,
            self.deck if isinstance(self.deck, Deck) else None,
        )


def _faces(mesh: Mesh | None, image: Integers) -> list[Integers]:
    """Nodes of each connected face of facets of the outline whose images, where they are no less than 0, are facets of the outline too."""
    if mesh is None:
        return [np.flatnonzero(image >= 0)] if (image >= 0).any() else []
    outline = mesh.boundary_facets()
    nodes = mesh.facets[:, outline]
    here = (image[nodes] >= 0).all(axis=0)
    here[here] = places_among(image[nodes[:, here]].T, nodes.T) >= 0
    if mesh.dim() == 2:
        return (
            [line for line, _ in lines_along(mesh, outline[here], "matching_faces: the outline")]
            if here.any()
            else []
        )
    ends = nodes[:, here]
    part = parts_of((np.tile(ends[0], len(ends) - 1), ends[1:].ravel()), len(image))
    return [
        np.unique(ends[:, part[ends[0]] == number])
        for number in dict.fromkeys(part[ends[0]].tolist())
    ]
