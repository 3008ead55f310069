"""Matrices of CalculiX and Abaqus, whose decks have one grammar: of whole models, and of substructures, whose files are linear user elements."""

import re
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..base import ROUNDING, SAME_POINT, Array, Booleans, Integers
from ..base.libraries import file_path
from ..errors import ModelError
from .deck import Deck, blocks, entries, fields, number, text_of
from .job import MatrixJob
from .keywords import read_deck

_REMEDY = "write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, for one substructure"
_WIDTH = 20  # characters of a number that CalculiX reads
_NODES = re.compile(r"\*\*.*ELEMENT NODES.*\n((?:\s*\*\*.*\n)*)", re.IGNORECASE)


def read_calculix(job: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read what CalculiX writes for a step of `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `NAME.sti`, `NAME.mas`, `NAME.dof` and the deck `NAME.inp`.

    CalculiX writes one triangle of each matrix, without the displacements that `*BOUNDARY` holds or
    that follow others by a constraint, and no loads: `MatrixJob.force` makes them, and knows the
    constraints. Rotations of a `*RIGID BODY` and the incompatible modes of C3D8I are generalised
    coordinates. Stiffness and mass of a plane job are divided by the thickness of its section. The
    contact itself must not be in the deck: each body keeps its own nodes there.

    Parameters
    ----------
    job
        Path of the job, `NAME` or that of one of its files.
    deck
        Path of the deck; by default `NAME.inp` where there is one.

    Raises
    ------
    ModelError
        A file that is missing or damaged, a matrix without labels, of another size than its labels,
        or not symmetric; plane elements to which CalculiX gives displacements along z (plane
        stress), or of several thicknesses; a rigid part whose rotation nodes do not determine; a
        contact in a `*STEP, PERTURBATION`, whose springs are in the matrix; numbers of the deck
        that CalculiX does not read whole, because they have more than 20 characters.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_calculix("tests/data/flat")
    >>> job.K.shape, job.labels[0].tolist()  # the first row is the displacement of node 3 along x
    ((964, 964), [3, 1])
    """
    base = file_path("job", job)
    base = base.with_suffix("") if base.suffix in (".inp", ".sti", ".mas", ".dof") else base
    sti, mas, dof, inp = (
        base.with_name(f"{base.name}.{ending}") for ending in ("sti", "mas", "dof", "inp")
    )
    if base.parent.is_dir() and not sti.exists():
        how = "CalculiX writes it in a step of *FREQUENCY, SOLVER=MATRIXSTORAGE, for which each material needs *DENSITY"
        raise ModelError(f"stiffness: there is no {str(sti)!r}; {how}") from FileNotFoundError(sti)
    labels = np.column_stack(numbers_in(dof, "labels", ".", 2))
    K, M = (
        _matrix("stiffness", sti, dof, len(labels)),
        _matrix("mass", mas, dof, len(labels)) if mas.exists() else None,
    )
    path = inp if deck is None else file_path("deck", deck)
    if deck is None and not path.exists():
        return MatrixJob(K, labels, M=M)
    _check_widths(path)
    written, keywords = (
        read_deck(path),
        [(keyword, options) for keyword, options, _ in blocks(path)],
    )
    perturbed = any(
        keyword == "STEP" and "PERTURBATION" in options for keyword, options in keywords
    )
    if perturbed and any(
        keyword == "CONTACTPAIR" for keyword, _ in keywords
    ):  # CalculiX 2.20 was seen to do so
        raise ModelError(
            f"deck {path.name}: *STEP, PERTURBATION puts the springs of each *CONTACT PAIR into the matrix; take *CONTACT PAIR out"
        )
    labels, felt = with_rotations(K, labels, written)
    thick = sorted({kind for kind, _, _ in written.elements if kind.startswith(("CPS", "CPE"))})
    if thick and (labels[:, 1] == 3).any():
        raise ModelError(
            f"deck: elements {', '.join(thick)} have displacements along z in CalculiX's matrix; for plane stress write CPE elements with "
            "E (1 + 2 nu) / (1 + nu)^2 for E and nu / (1 + nu) for nu, and leave out trusses, beams and shells"
        )
    K, M = (
        None if part is None else csr_matrix(part[felt][:, felt]) / written.thickness
        for part in (K, M)
    )
    return MatrixJob(K, labels[felt], written, M=M)


def _check_widths(path: Path) -> None:
    """Check that CalculiX, which reads the first characters of a number, has read the numbers of the deck."""
    for keyword, _, lines in blocks(path):
        for entry in (entry for line in lines for entry in entries(line) if len(entry) > _WIDTH):
            try:
                value = number(entry)
            except ValueError:  # a name
                continue
            try:
                cut = number(entry[:_WIDTH])
            except ValueError:
                cut = np.nan
            if not abs(cut - value) <= ROUNDING * abs(value):
                raise ModelError(
                    f"deck {path.name}: *{keyword} has {entry}, of which CalculiX reads {_WIDTH} characters, {entry[:_WIDTH]}; "
                    "write numbers with fewer, such as %.12e, and let CalculiX write its matrix again"
                )


def _matrix(what: str, path: Path, dof: Path, n: int) -> csr_matrix:
    """A matrix of n rows, of which the file has one triangle."""
    row, column, value = numbers_in(path, what, r"\s+", 3)
    first, last = min(row.min(), column.min()), max(row.max(), column.max())
    if first < 1 or last != n:
        raise ModelError(
            f"{what}: {path.name} has rows {first:g} to {last:g}, {dof.name} has {n} labels; give both files of the same job"
        )
    return symmetric(what, row - 1, column - 1, value.astype(np.float64), n)


def with_rotations(K: csr_matrix, labels: Integers, deck: Deck) -> tuple[Integers, Booleans]:
    """(n, 2) labels in which rotations of rigid parts are directions 4 to 6 of the reference, and (n,) which rows something resists.

    Incompatible modes of an element, C3D8I, are displacements of three nodes that are not in the
    deck; labels have these with a minus.
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
        rows = np.flatnonzero(
            np.isin(labels[:, 0], made if rotation is None else deck.numbers[rotation])
        )
        labels[rows] = np.column_stack(
            [np.full(len(rows), deck.numbers[reference]), labels[rows, 1] + 3]
        )
        felt[rows] = (
            abs(K[rows]).max(axis=1).toarray().ravel() > 0
        )  # CalculiX writes rotations too that the part does not feel
        moved = constraints.part(reference)[1][:, labels[rows[felt[rows]], 1] - 1]
        if (
            np.linalg.matrix_rank(moved, SAME_POINT * np.abs(moved).max(initial=0.0))
            < moved.shape[1]
        ):
            node = deck.numbers[reference]
            raise ModelError(
                f"deck: the nodes that follow REF NODE {node} do not determine its rotation; hold it, or give nodes off a line"
            )
    if any(kind.startswith("C3D8I") for kind, _, _ in deck.elements):
        labels[np.isin(labels[:, 0], made), 0] *= -1
    return labels, felt


def read_abaqus(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read a stiffness that Abaqus writes: of the whole model, or of a substructure.

    That of `*MATRIX GENERATE, STIFFNESS` with `*MATRIX OUTPUT, STIFFNESS, FORMAT=MATRIX INPUT` has
    rows "node, direction, node, direction, value" (Abaqus Keywords Guide, `*MATRIX INPUT`), one
    triangle or the whole matrix. Unknowns that are coupled to no other are held ones or follow
    others, and are left out. That of `*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER
    DEFINED` is a linear user element; it keeps the retained displacements alone: retain those of
    the contact and of the loads. Rotations, unknowns of modes and those of internal nodes (numbers
    that are not positive) are generalised coordinates. The stiffness of a plane job with a deck is
    divided by the thickness of its section.

    Parameters
    ----------
    path
        Path of the file, such as `NAME_STIF1.mtx`.
    deck
        Path of the input deck, for nodes and sets; a flat one, without parts and instances.

    Raises
    ------
    ModelError
        A file that is missing or damaged, FORMAT=COORDINATE (it carries no labels), no
        displacements, a matrix that is not symmetric; the substructure of CalculiX, which has the
        form of that of Abaqus but is not reduced.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.read_abaqus("tests/data/spring_STIF1.mtx")
    >>> job.K.toarray().tolist(), job.labels.tolist()
    ([[2.0, -1.0], [-1.0, 2.0]], [[7, 1], [9, 1]])
    """
    file = file_path("path", path)
    text = text_of(file, "stiffness")
    of_element = any(
        line.upper().startswith(("*USER ELEMENT", "*MATRIX"))
        for line in map(str.strip, text.splitlines())
    )
    K, labels = stiffness_of_element(text, file) if of_element else _assembled(file)
    nodes = None if deck is None else read_deck(file_path("deck", deck))
    return MatrixJob(K / (1.0 if nodes is None else nodes.thickness), labels, nodes)


def _assembled(file: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness and labels of rows of five numbers."""
    node, direction, other_node, other_direction, value = numbers_in(file, "stiffness", ",", 5)
    ends = np.concatenate(
        [np.column_stack([node, direction]), np.column_stack([other_node, other_direction])]
    )
    distinct, place = np.unique(ends, axis=0, return_inverse=True)
    row, column = np.split(place.ravel(), 2)
    K = symmetric("stiffness", row, column, value.astype(np.float64), len(distinct))
    free = np.unique(np.concatenate([row[row != column], column[row != column]]))
    return K[free][:, free], distinct[free]


def stiffness_of_element(text: str, path: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness, and node and direction of each of its rows, of a user element.

    The nodes stand in comments after "ELEMENT NODES". The first data line has the directions of the
    first node and those that follow; each further one the place of a node in that list from which
    on other directions hold, and these. The matrix has its lower triangle row by row.
    """
    found, listed = list(blocks(path)), _NODES.search(text)
    elements = [lines for keyword, _, lines in found if keyword == "USERELEMENT"]
    parts = [
        lines
        for keyword, options, lines in found
        if keyword == "MATRIX" and options.get("TYPE") == "STIFFNESS"
    ]
    try:
        nodes = [
            int(field)
            for line in (listed[1] if listed else "").splitlines()
            for field in fields(line.strip(" *"))
        ]
        changes = [[int(field) for field in fields(line)] for lines in elements for line in lines]
        values = [number(field) for lines in parts for line in lines for field in fields(line)]
    except ValueError as error:
        raise ModelError(
            f"stiffness: {path.name} cannot be read ({error}); give the file as the code wrote it"
        ) from error
    if (count := len(elements)) != 1 or not nodes or not changes or not values:
        raise ModelError(
            f"stiffness: {path.name} has {count} elements, {len(nodes)} nodes and {len(values)} numbers of a stiffness; {_REMEDY}"
        )
    if nodes[0] in nodes[1:]:  # Abaqus lists each node once
        remedy = "store the whole stiffness by *FREQUENCY, SOLVER=MATRIXSTORAGE, and read it with read_calculix; condense reduces it"
        raise ModelError(
            f"stiffness: {path.name} is by CalculiX, which leaves out the elimination in this file; {remedy}"
        )
    starts = [1, *(first for first, *_ in changes[1:])]
    if starts != sorted(set(starts)) or starts[-1] > len(nodes):
        raise ModelError(
            f"stiffness: directions of {path.name} change at nodes {starts[1:]} of {len(nodes)}; give the file as the code wrote it"
        )
    directions = [changes[0], *(rest for _, *rest in changes[1:])]
    labels = np.array(
        [
            (nodes[i], k)
            for i in range(len(nodes))
            for k in directions[np.searchsorted(starts, i + 1, side="right") - 1]
        ]
    )
    size = len(labels)
    if len(values) != size * (size + 1) // 2:
        raise ModelError(
            f"stiffness: {path.name} has {len(values)} numbers, not {size * (size + 1) // 2} for a triangle of {size} rows; {_REMEDY}"
        )
    K = np.zeros((size, size))
    K[np.tril_indices(size)] = values
    own = np.sqrt(np.abs(np.diag(K)))
    K[np.abs(K) <= ROUNDING * np.outer(own, own)] = (
        0.0  # rounding of the elimination joins no bodies
    )
    return csr_matrix(K + np.tril(K, -1).T), labels


def numbers_in(path: Path, what: str, separator: str, columns: int) -> Any:
    """The columns of a text file without header, as a list of `columns` arrays; lines that begin with * are comments."""
    import pandas as pd  # here, for only reading needs it

    text = text_of(path, what)
    try:
        table = pd.read_csv(
            StringIO(text), sep=separator, header=None, comment="*", skipinitialspace=True
        )
        found = table.shape[1]
        if (
            found == columns
            and all(kind.kind in "iuf" for kind in table.dtypes)
            and not table.isna().any(axis=None)
        ):
            return [table[i].to_numpy() for i in range(columns)]
        problem = f"rows of {found} columns" if found != columns else "entries that are no numbers"
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        problem = str(error).strip()
    raise ModelError(
        f"{what}: {str(path)!r} does not hold rows of {columns} numbers ({problem}); {_remedy(text, columns)}"
    )


def _remedy(text: str, columns: int) -> str:
    first = next(
        (line for line in text.splitlines() if line.strip() and not line.startswith("*")), ""
    )
    if columns == 5 and len(first.replace(",", " ").split()) == 3:
        return "rows of 3 are Abaqus's FORMAT=COORDINATE, which does not say which nodes they belong to: write it with FORMAT=MATRIX INPUT"
    if "nan" in text:
        return "the code itself wrote nan, as CalculiX does for *MPC: write such a constraint as *EQUATION"
    return "give the file as the code wrote it"


def symmetric(what: str, row: Integers, column: Integers, value: Array, size: int) -> csr_matrix:
    """(size, size) matrix from its entries: those of one triangle, which the other one mirrors, or all of them."""
    if not np.isfinite(value).all():
        raise ModelError(
            f"{what}: entry {int(np.argmin(np.isfinite(value))) + 1} is not finite; let the code write the matrix again"
        )
    if np.any(row < column) != np.any(row > column):
        off = row != column
        row, column, value = (
            np.r_[row, column[off]],
            np.r_[column, row[off]],
            np.r_[value, value[off]],
        )
    K = csr_matrix((value, (row, column)), shape=(size, size))
    if K.nnz != len(value):
        raise ModelError(f"{what}: entries are given twice; let the code write the matrix again")
    return K
