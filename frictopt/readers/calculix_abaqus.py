"""Matrices of CalculiX and Abaqus, whose decks have the same grammar.

Abaqus writes substructures as linear user elements, with their nodes in comments.
"""

import re
from io import StringIO
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..base import ROUNDING, Array, Integers, number_of
from ..base.files import file_path
from ..errors import ModelError
from .deck import SLENDER, Deck
from .deck_text import blocks, entries, fields, number, text_of
from .job import MatrixJob
from .keywords import FLAT, read_deck

# CalculiX reads this many characters of a number in a deck.
_WIDTH = 20
# CalculiX replaces axisymmetric elements by a sector of 2 degrees. This number of sectors makes up
# the circumference.
_SECTORS = 180.0


def read_calculix(job: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read the stiffness of a step of `*FREQUENCY, SOLVER=MATRIXSTORAGE` of CalculiX.

    Its files are `NAME.sti`, `NAME.dof` and the deck `NAME.inp`. CalculiX writes one triangle of
    the matrix. It leaves out the displacements that `*BOUNDARY` holds, or that a constraint
    determines. It writes no loads: `MatrixJob.force` makes them. The incompatible modes of C3D8I,
    and the nodes of beams and shells are generalised coordinates. The stiffness of a plane job is
    divided by the thickness of its section. An axisymmetric job refers to the whole circumference:
    its stiffness is 180 times the stiffness in the file. The contact itself must not be in the
    deck: each body keeps its own nodes there.

    Parameters
    ----------
    job
        Path of the job, `NAME`, or the path of one of its files.
    deck
        Path of the deck; by default `NAME.inp`, if it exists.

    Returns
    -------
    MatrixJob
        The matrix with its labels, nodes and sets, as arguments of `condense`.

    Raises
    ------
    ModelError
        A file is missing or damaged. The matrix has no labels, another size than its labels, or is
        not symmetric. Plane elements have displacements along z in CalculiX (plane stress), or
        several thicknesses. The deck has a `*RIGID BODY` or a kinematic `*COUPLING`, which
        `read_joint` reads. A `*STEP, PERTURBATION` has a contact, whose springs are in the matrix.
        A number of the deck has more than 20 characters, and CalculiX reads only the first 20.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.readers.read_calculix("tests/data/flat")
    >>> job.K.shape, job.labels[0].tolist()  # the first row is the displacement of node 3 along x
    ((964, 964), [3, 1])
    """
    base = file_path("job", job)
    if base.suffix in (".inp", ".sti", ".dof"):
        base = base.with_suffix("")
    sti, dof, inp = (base.with_name(f"{base.name}.{suffix}") for suffix in ("sti", "dof", "inp"))
    _check_stiffness_is_there(sti)
    labels = np.column_stack(numbers_in(dof, "labels", ".", 2))
    K = _stiffness(sti, dof, len(labels))
    if deck is None and not inp.exists():
        return MatrixJob(K, labels)

    deck_path = inp if deck is None else file_path("deck", deck)
    _check_deck(deck_path)
    listed = read_deck(deck_path)
    labels = with_generalised(labels, listed)
    _check_no_plane_stress(labels, listed)
    # With this factor, the stiffness is per unit depth, or of the whole circumference.
    factor = _SECTORS if listed.is_axisymmetric else 1 / listed.thickness
    return MatrixJob(factor * K, labels, listed)


def _check_stiffness_is_there(sti: Path) -> None:
    if sti.parent.is_dir() and not sti.exists():
        raise ModelError(
            f"stiffness: there is no {str(sti)!r}; CalculiX writes it in a step of *FREQUENCY, "
            "SOLVER=MATRIXSTORAGE, for which each material needs *DENSITY"
        ) from FileNotFoundError(sti)


def _stiffness(path: Path, dof: Path, size: int) -> csr_matrix:
    """The whole matrix; the file has one triangle of it."""
    row, column, value = numbers_in(path, "stiffness", r"\s+", 3)
    first = min(row.min(), column.min())
    last = max(row.max(), column.max())
    if first < 1 or last != size:
        remedy = "give both files of the same job"
        if last == 2 * size:
            remedy += (
                ", and if its step has *SELECT CYCLIC SYMMETRY MODES, leave that out: it makes the "
                "matrix complex, and the labels are of its real part alone"
            )
        raise ModelError(
            f"stiffness: {path.name} has rows {first:g} to {last:g}, {dof.name} has "
            f"{number_of(size, 'label')}; {remedy}"
        )
    return symmetric(row - 1, column - 1, value, size)


def _check_deck(path: Path) -> None:
    """Check that CalculiX has read each number whole, and that no keyword makes unknown rows.

    Such rows are not displacements of nodes. Also, CalculiX 2.20 puts the springs of a
    contact into the matrix of a perturbation step.
    """
    keywords = set()
    has_perturbation = False
    for block in blocks(path):
        keywords.add(block.keyword)
        has_perturbation |= block.keyword == "STEP" and "PERTURBATION" in block.parameters
        for entry in (entry for line in block.lines for entry in entries(line)):
            if len(entry) > _WIDTH and _is_cut(entry):
                raise ModelError(
                    f"deck {path.name}: *{block.keyword} has {entry}, of which CalculiX reads "
                    f"{_WIDTH} characters, {entry[:_WIDTH]}; write numbers with fewer, such as "
                    "%.12e, and let CalculiX write its matrix again"
                )
    if has_perturbation and "CONTACTPAIR" in keywords:
        raise ModelError(
            f"deck {path.name}: *STEP, PERTURBATION puts the springs of each *CONTACT PAIR into "
            "the matrix; take *CONTACT PAIR out"
        )
    if keywords & {"RIGIDBODY", "KINEMATIC"}:
        raise ModelError(
            f"deck {path.name}: the matrix has rotations of its *RIGID BODY or *COUPLING; read the "
            "deck itself, by read_joint, or write the constraint as *EQUATION"
        )


def _is_cut(entry: str) -> bool:
    """Whether an entry is a number that changes if only its first characters are read."""
    try:
        value = number(entry)
    except ValueError:
        # The entry is a name.
        return False
    try:
        cut = number(entry[:_WIDTH])
    except ValueError:
        return True
    return not abs(cut - value) <= ROUNDING * abs(value)


def _check_no_plane_stress(labels: Integers, deck: Deck) -> None:
    kinds = {block.kind for block in deck.elements if block.kind.startswith(("CPS", "CPE"))}
    if kinds and (labels[:, 1] == 3).any():
        raise ModelError(
            f"deck: elements {', '.join(sorted(kinds))} have displacements along z in CalculiX's "
            "matrix; for plane stress write CPE elements with E (1 + 2 nu) / (1 + nu)^2 for E and "
            "nu / (1 + nu) for nu, and leave out trusses, beams and shells"
        )


def with_generalised(labels: Integers, deck: Deck) -> Integers:
    """Labels (n, 2), with a minus for rows that are not displacements of nodes.

    The incompatible modes of an element C3D8I are displacements of three nodes that are not in the
    deck. CalculiX also makes nodes for beams and shells.
    """
    labels = labels.copy()
    made_nodes = np.setdiff1d(labels[:, 0], deck.numbers)
    if any(block.kind.startswith("C3D8I") for block in deck.elements):
        labels[np.isin(labels[:, 0], made_nodes), 0] *= -1
    of_slender = np.isin(labels[:, 0], _nodes_of_slender_elements(deck, made_nodes))
    labels[of_slender, 0] = -labels[:, 0].max() - 1 - np.arange(np.count_nonzero(of_slender))
    return labels


def _nodes_of_slender_elements(deck: Deck, made_nodes: Integers) -> Integers:
    """Numbers of nodes that only beams and shells have, and of nodes that CalculiX makes for them.

    CalculiX turns beams and shells into solids. So one node number can have several rows.
    """
    slender = [block.nodes.ravel() for block in deck.elements if block.kind.startswith(SLENDER)]
    if not slender:
        return np.zeros(0, dtype=np.intp)
    others = [block.nodes.ravel() for block in deck.elements if not block.kind.startswith(SLENDER)]
    alone = np.setdiff1d(np.concatenate(slender), np.concatenate([[], *others]))
    return np.union1d(deck.numbers[alone.astype(np.intp)], made_nodes)


def read_abaqus(path: str | Path, *, deck: str | Path | None = None) -> MatrixJob:
    """Read a stiffness that Abaqus writes: of the whole model, or of a substructure.

    `*MATRIX GENERATE, STIFFNESS` with `*MATRIX OUTPUT, STIFFNESS, FORMAT=MATRIX INPUT` writes rows
    "node, direction, node, direction, value" (Abaqus Keywords Guide, `*MATRIX INPUT`), for one
    triangle or for the whole matrix. Unknowns that are not coupled to others are held, or follow
    other unknowns; they are left out. `*SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER
    DEFINED` writes a linear user element that has only the retained displacements: retain the nodes
    of the contact and of the loads. Rotations, unknowns of modes and unknowns of internal nodes
    (numbers that are not positive) are generalised coordinates. The stiffness of a plane job with a
    deck is divided by the thickness of its section. The stiffness of an axisymmetric job refers to
    the whole circumference.

    Parameters
    ----------
    path
        Path of the file, such as `NAME_STIF1.mtx`.
    deck
        Path of the input deck, for nodes and sets. The deck is flat or has one instance.

    Returns
    -------
    MatrixJob
        The matrix with its labels, nodes and sets, as arguments of `condense`.

    Raises
    ------
    ModelError
        The file is missing or damaged, has FORMAT=COORDINATE (without labels), or has no
        displacements; the matrix is not symmetric; or the file is a substructure of CalculiX, which
        has the form of Abaqus but is not reduced.

    Examples
    --------
    >>> import frictopt as fo
    >>> job = fo.readers.read_abaqus("tests/data/spring_STIF1.mtx")
    >>> job.K.toarray().tolist(), job.labels.tolist()
    ([[2.0, -1.0], [-1.0, 2.0]], [[7, 1], [9, 1]])
    """
    file = file_path("path", path)
    text = text_of(file, "stiffness")
    heads = ("*USER ELEMENT", "*MATRIX")
    is_element = any(line.strip().upper().startswith(heads) for line in text.splitlines())
    K, labels = _stiffness_of_element(text, file) if is_element else _assembled(file)
    if deck is None:
        return MatrixJob(K, labels)
    deck_path = file_path("deck", deck)
    _check_one_instance(deck_path)
    listed = read_deck(deck_path)
    return MatrixJob(K / listed.thickness, labels, listed)


def _check_one_instance(path: Path) -> None:
    count = sum(block.keyword == "INSTANCE" for block in blocks(path))
    if count > 1:
        raise ModelError(
            f"deck {path.name}: it has {count} instances, and Abaqus numbers the nodes of the "
            f"matrix anew; {FLAT}, and let Abaqus write the matrix again"
        )


def _assembled(file: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness and labels of rows of five numbers."""
    node, direction, other_node, other_direction, value = numbers_in(file, "stiffness", ",", 5)
    ends = np.concatenate(
        [np.column_stack([node, direction]), np.column_stack([other_node, other_direction])]
    )
    labels, place = np.unique(ends, axis=0, return_inverse=True)
    row, column = np.split(place.ravel(), 2)
    K = symmetric(row, column, value, len(labels))
    coupled = row != column
    free = np.unique(np.concatenate([row[coupled], column[coupled]]))
    return K[free][:, free], labels[free]


def numbers_in(path: Path, what: str, separator: str, columns: int) -> list[Any]:
    """The columns of a text file without header; lines that begin with * are comments."""
    # Imported here, because only reading needs it.
    import pandas as pd

    text = text_of(path, what)
    try:
        table = pd.read_csv(
            StringIO(text), sep=separator, header=None, comment="*", skipinitialspace=True
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        problem = str(error).strip()
    else:
        numeric = all(dtype.kind in "iuf" for dtype in table.dtypes)
        if table.shape[1] != columns:
            problem = f"rows of {number_of(table.shape[1], 'column')}"
        elif not numeric or table.isna().any(axis=None):
            problem = "entries that are no numbers"
        else:
            return [table[i].to_numpy() for i in range(columns)]
    raise ModelError(
        f"{what}: {str(path)!r} does not hold rows of {columns} numbers ({problem}); "
        f"{_remedy(text, columns)}"
    )


def _remedy(text: str, columns: int) -> str:
    lines = (line for line in text.splitlines() if line.strip() and not line.startswith("*"))
    first = next(lines, "")
    if columns == 5 and len(first.replace(",", " ").split()) == 3:
        return (
            "rows of 3 are Abaqus's FORMAT=COORDINATE, which does not name their nodes: "
            "write it with FORMAT=MATRIX INPUT"
        )
    if "nan" in text:
        return (
            "the code itself wrote nan, as CalculiX does for *MPC: "
            "write such a constraint as *EQUATION"
        )
    return "give the file as the code wrote it"


def symmetric(row: Integers, column: Integers, value: Array, size: int) -> csr_matrix:
    """(size, size) matrix from its entries: all entries, or the entries of one triangle."""
    finite = np.isfinite(value)
    if not finite.all():
        raise ModelError(
            f"stiffness: entry {int(np.argmin(finite)) + 1} is not finite; "
            "let the code write the matrix again"
        )
    has_one_triangle = np.any(row < column) != np.any(row > column)
    if has_one_triangle:
        off_diagonal = row != column
        mirrored_row = np.r_[row, column[off_diagonal]]
        column = np.r_[column, row[off_diagonal]]
        row = mirrored_row
        value = np.r_[value, value[off_diagonal]]
    K = csr_matrix((value, (row, column)), shape=(size, size))
    if K.nnz != len(value):
        raise ModelError("stiffness: entries are given twice; let the code write the matrix again")
    return K


_NODES = re.compile(r"\*\*.*ELEMENT NODES.*\n((?:\s*\*\*.*\n)*)", re.IGNORECASE)
_WRITE = (
    "write it with *SUBSTRUCTURE MATRIX OUTPUT, STIFFNESS=YES, OUTPUT FILE=USER DEFINED, "
    "for one substructure"
)
_AS_WRITTEN = "give the file as the code wrote it"


def _stiffness_of_element(text: str, path: Path) -> tuple[csr_matrix, Integers]:
    """Stiffness of a user element, and the labels (n, 2) of its rows: node and direction."""
    elements = 0
    directions = list[list[int]]()
    triangle = list[float]()
    try:
        nodes = _nodes_in_comments(text)
        for block in blocks(path):
            if block.keyword == "USERELEMENT":
                elements += 1
                directions += [list(map(int, row)) for row in block.rows]
            elif block.keyword == "MATRIX" and block.parameters.get("TYPE") == "STIFFNESS":
                triangle += map(number, chain.from_iterable(block.rows))
    except ValueError as error:
        raise ModelError(
            f"stiffness: {path.name} cannot be read ({error}); {_AS_WRITTEN}"
        ) from error
    if elements != 1 or not (nodes and directions and triangle):
        raise ModelError(
            f"stiffness: {path.name} has elements: {elements}, nodes: {len(nodes)}, numbers "
            f"of a stiffness: {len(triangle)}; {_WRITE}"
        )
    # Abaqus lists each node once.
    if nodes[0] in nodes[1:]:
        raise ModelError(
            f"stiffness: {path.name} is by CalculiX, which leaves out the elimination in this "
            "file; store the whole stiffness by *FREQUENCY, SOLVER=MATRIXSTORAGE, and read it with "
            "read_calculix; condense reduces it"
        )
    labels = _labels(nodes, directions, path.name)
    return csr_matrix(_whole(triangle, len(labels), path.name)), labels


def _nodes_in_comments(text: str) -> list[int]:
    """Numbers of the nodes in the comments after "ELEMENT NODES"."""
    comments = _NODES.search(text)
    lines = comments[1].splitlines() if comments else []
    return [int(entry) for line in lines for entry in fields(line.strip(" *"))]


def _labels(nodes: list[int], direction_lines: list[list[int]], file: str) -> Integers:
    """(n, 2) node and direction of each row.

    The first line of directions has the directions of the first nodes. Each further line has the
    place in `nodes`, from 1, of the first node with other directions, and then these directions.
    """
    first_directions, *changes = direction_lines
    starts = [1, *(change[0] for change in changes)]
    rises = all(start < following for start, following in pairwise(starts))
    if not rises or starts[-1] > len(nodes):
        raise ModelError(
            f"stiffness: directions of {file} change at nodes {starts[1:]} of {len(nodes)}; "
            f"{_AS_WRITTEN}"
        )
    directions = [first_directions, *(change[1:] for change in changes)]
    labels = []
    for place, node in enumerate(nodes, start=1):
        latest = np.searchsorted(starts, place, side="right") - 1
        labels += [(node, direction) for direction in directions[latest]]
    return np.array(labels)


def _whole(triangle: list[float], size: int, file: str) -> Array:
    expected = size * (size + 1) // 2
    if len(triangle) != expected:
        raise ModelError(
            f"stiffness: {file} has {number_of(len(triangle), 'number')}, not {expected} for "
            f"a triangle of {size} rows; {_WRITE}"
        )
    K = np.zeros((size, size))
    K[np.tril_indices(size)] = triangle
    # Entries that are rounding of the elimination must not join bodies.
    scale = np.sqrt(np.abs(np.diag(K)))
    K[np.abs(K) <= ROUNDING * np.outer(scale, scale)] = 0.0
    return K + np.tril(K, -1).T
