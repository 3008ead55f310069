"""Matrices of CalculiX."""

from pathlib import Path

import numpy as np

from ...errors import ModelError
from .deck import read_deck
from .job import MatrixJob
from .meshes import file_path
from .rows import numbers_in, symmetric

__all__ = ["read_calculix"]


def read_calculix(job: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read the stiffness that CalculiX writes for a step of `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `NAME.sti`, `NAME.dof` and the deck `NAME.inp`.

    CalculiX writes one triangle of the matrix, without the unknowns that `*BOUNDARY` holds or constraints eliminate, and no loads:
    `MatrixJob.force` makes them. Glued or tied faces must not be in the deck: each body keeps its own nodes on the contact.

    Parameters
    ----------
    job
        Path of the job without ending, `NAME`.
    deck
        Path of the deck; by default `NAME.inp` where there is one.

    Raises
    ------
    ModelError
        A file that is missing or damaged, a matrix without labels, of another size than its labels, or not symmetric.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job.K.shape, job.labels[0].tolist()  # the first row is the displacement of node 3 along x
    ((964, 964), [3, 1])
    """
    base = file_path("job", job)
    sti, dof, inp = (base.with_name(f"{base.name}.{ending}") for ending in ("sti", "dof", "inp"))
    row, column, value = numbers_in(sti, "stiffness", r"\s+", 3)
    labels = np.column_stack(numbers_in(dof, "labels", ".", 2))
    n = len(labels)
    if min(row.min(), column.min()) < 1 or max(row.max(), column.max()) != n:
        raise ModelError(
            f"stiffness: {sti.name} has rows {min(row.min(), column.min()):g} to {max(row.max(), column.max()):g}, {dof.name} has {n} labels; "
            "give both files of the same job"
        )
    K = symmetric("stiffness", row - 1, column - 1, value.astype(np.float64), n)
    path = inp if deck is None else file_path("deck", deck)
    return MatrixJob(K, labels, read_deck(path) if deck is not None or path.exists() else None)
