"""Matrices of CalculiX."""

from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.tolerances import SAME_POINT
from ...errors import ModelError
from ..ordering import Flags, Integers
from .deck import Deck, read_deck
from .job import MatrixJob
from .meshes import file_path
from .rows import numbers_in, symmetric


def read_calculix(job: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read what CalculiX writes for a step of `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `NAME.sti`, `NAME.mas`, `NAME.dof` and the deck `NAME.inp`.

    CalculiX writes one triangle of each matrix, without the displacements that `*BOUNDARY` holds or that follow others by a constraint, and no
    loads: `MatrixJob.force` makes them, and knows the constraints. Rotations of a `*RIGID BODY` and the incompatible modes of C3D8I are generalised
    coordinates. Stiffness and mass of a plane job are divided by the thickness of its section. The contact itself must not be in the deck: each body
    keeps its own nodes there.

    Parameters
    ----------
    job
        Path of the job without ending, `NAME`.
    deck
        Path of the deck; by default `NAME.inp` where there is one.

    Raises
    ------
    ModelError
        A file that is missing or damaged, a matrix without labels, of another size than its labels, or not symmetric; plane elements to which
        CalculiX gives displacements along z (plane stress), or of several thicknesses; a rigid part whose rotation nodes do not determine.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job.K.shape, job.labels[0].tolist()  # the first row is the displacement of node 3 along x
    ((964, 964), [3, 1])
    """
    base = file_path("job", job)
    sti, dof, inp = (base.with_name(f"{base.name}.{ending}") for ending in ("sti", "dof", "inp"))
    if base.parent.is_dir() and not sti.exists():
        raise ModelError(
            f"stiffness: there is no {str(sti)!r}; CalculiX writes it in a step of *FREQUENCY, SOLVER=MATRIXSTORAGE, for which each material needs "
            "*DENSITY: see what it says when it runs"
        )
    labels = np.column_stack(numbers_in(dof, "labels", ".", 2))
    mas = sti.with_suffix(".mas")
    K, M = _matrix("stiffness", sti, dof, len(labels)), _matrix("mass", mas, dof, len(labels)) if mas.exists() else None
    path = inp if deck is None else file_path("deck", deck)
    if deck is None and not path.exists():
        return MatrixJob(K, labels, M=M)
    written = read_deck(path)
    labels, felt = with_rotations(K, labels, written)
    _check_plane(labels, written)
    K, M = (None if part is None else csr_matrix(part[felt][:, felt]) / written.thickness for part in (K, M))
    return MatrixJob(K, labels[felt], written, M=M)


def _matrix(what: str, path: Path, dof: Path, n: int) -> csr_matrix:
    """A matrix of n rows, of which the file has one triangle."""
    row, column, value = numbers_in(path, what, r"\s+", 3)
    if min(row.min(), column.min()) < 1 or max(row.max(), column.max()) != n:
        raise ModelError(
            f"{what}: {path.name} has rows {min(row.min(), column.min()):g} to {max(row.max(), column.max()):g}, {dof.name} has {n} labels; "
            "give both files of the same job"
        )
    return symmetric(what, row - 1, column - 1, value.astype(np.float64), n)


def _check_plane(labels: Integers, deck: Deck) -> None:
    """Check that plane elements have displacements in their plane alone."""
    thick = sorted({kind for kind, _, _ in deck.elements if kind.startswith(("CPS", "CPE"))})
    if thick and (labels[:, 1] == 3).any():
        raise ModelError(
            f"deck: elements {', '.join(thick)} have displacements along z in CalculiX's matrix, which no plane contact has; for plane stress write "
            "CPE elements with E (1 + 2 nu) / (1 + nu)^2 in place of E and nu / (1 + nu) in place of nu, which is the same in the plane; leave out "
            "trusses, beams and shells"
        )


def with_rotations(K: csr_matrix, labels: Integers, deck: Deck) -> tuple[Integers, Flags]:
    """(n, 2) labels in which rotations of rigid parts are directions 4 to 6 of the reference, and (n,) which rows something resists.

    Incompatible modes of an element, C3D8I, are displacements of three nodes that are not in the deck; labels have these with a minus.

    Raises
    ------
    ModelError
        Rotations of several parts without a node of their own, nodes that do not determine the rotation.
    """
    constraints, labels, felt = deck.constraints, labels.copy(), np.ones(len(labels), dtype=bool)
    unnamed = sum(rotation is None for _, rotation in constraints.rigid)
    made = np.setdiff1d(labels[:, 0], deck.numbers)
    if unnamed > 1 or (unnamed and len(made) > 1):
        raise ModelError(
            f"deck: {unnamed} rigid parts name no ROT NODE, and the matrix has nodes {', '.join(map(str, made[:3]))}{', ...' * (len(made) > 3)} "
            "that are not in the deck; name a ROT NODE in each *RIGID BODY, and use *RIGID BODY in place of *COUPLING"
        )
    for reference, rotation in constraints.rigid:
        rows = np.flatnonzero(np.isin(labels[:, 0], made if rotation is None else deck.numbers[rotation]))
        labels[rows] = np.column_stack([np.full(len(rows), deck.numbers[reference]), labels[rows, 1] + 3])
        felt[rows] = abs(K[rows]).max(axis=1).toarray().ravel() > 0  # CalculiX writes rotations too that the part does not feel
        moved = constraints.part(reference)[1][:, labels[rows[felt[rows]], 1] - 1]
        if np.linalg.matrix_rank(moved, SAME_POINT * np.abs(moved).max(initial=0.0)) < moved.shape[1]:
            raise ModelError(
                f"deck: the nodes that follow REF NODE {deck.numbers[reference]} do not determine its rotation; hold it, or give nodes off a line"
            )
    if any(kind.startswith("C3D8I") for kind, _, _ in deck.elements):
        labels[np.isin(labels[:, 0], made), 0] *= -1
    return labels, felt
