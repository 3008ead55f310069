"""The parts of a contact system: components of its vectors, checks, the course of contacts in the plane; stiffness, open nodes, springs, overlaps."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base import (
    CONDENSATION,
    RIGID,
    SAME_POINT,
    Array,
    Booleans,
    check_entries,
    checked_cases,
    choice,
    finite_array,
    finite_number,
    for_each,
    frozen,
    real_array,
    shown,
)
from ..base.checks import Names
from ..errors import ModelError

_ORTHONORMAL = (
    10 * CONDENSATION
)  # error of the frames of the pairs up to which they are orthonormal, as for given normals
# eigenvalue of the stiffness of open nodes, over the largest, from which on they are held: the data
# have this error
_HELD = CONDENSATION
# stiffness of a spring, and largest compliance: the product of two larger numbers overflows
_SOFTEST = 1e-150
_BLOCK = 256  # rows and columns that are factored at once


def joined(q: Array, p: Array) -> Array:
    """(..., M) values ordered by component, from tangential (..., N) or (..., N, 2) and normal ones (..., N): the inverse of `parted`."""
    return np.concatenate([q, p] if q.ndim == p.ndim else [q[..., 0], q[..., 1], p], axis=-1)


def parted(r: Array, axes: int) -> tuple[Array, Array]:
    """Tangential (..., N) or (..., N, 2) and normal (..., N) parts of (..., M) values ordered by component; `axes` is 2 in the plane, 3 in space."""
    n = r.shape[-1] // axes
    q, p = r[..., :-n], r[..., -n:]
    return (q if axes == 2 else np.stack([q[..., :n], q[..., n:]], axis=-1)), p


def checked_frames(frames: object, n: int, axes: int) -> Array:
    """Check the directions of the nodes; None, or empty: the axes."""
    if frames is None or real_array("frames", frames).size == 0:
        return frozen(np.tile(np.eye(axes), (n, 1, 1)))
    checked = finite_array("frames", frames, (n, axes, axes))
    errors = np.abs(checked @ checked.transpose(0, 2, 1) - np.eye(axes)).max(axis=(1, 2))
    if errors.max() > _ORTHONORMAL:
        raise ModelError(
            f"frames: the directions of node {int(errors.argmax())} are not orthonormal; give unit tangents and the unit normal"
        )
    return checked


def above_zero(
    name: str,
    values: object,
    shape: tuple[int, ...],
    remedy: str,
    *,
    zero: bool = False,
    none: float | None = None,
) -> Array:
    """Check finite numbers of a shape, above 0 or, with `zero`, from 0 on; None, or empty: each is `none`, if that is given."""
    if none is not None and (values is None or real_array(name, values).size == 0):
        return frozen(np.full(shape, none))
    checked = finite_array(name, values, shape)
    check_entries(name, checked, checked >= 0 if zero else checked > 0, remedy)
    return checked


def checked_strength(argument: str, strength: object, n: int) -> Array:
    """Check shear strengths, one number or (n,), > 0 and up to infinity; None, or empty: none."""
    if strength is None or (given := real_array(argument, strength)).size == 0:
        return frozen(np.full(n, np.inf))
    check_entries(
        argument,
        given,
        given > 0,
        "give a largest shear > 0, inf for none; a surface that bears none has friction 0",
    )  # NaN is not, too
    return frozen(for_each(argument, given, n))


def checked_springs(argument: str, stiffness: object, n: int) -> Array:
    """Check stiffnesses of springs, one number or (n,), > 0 and up to infinity."""
    given = real_array(argument, stiffness)
    fits = (given >= _SOFTEST) & ((given <= 1 / _SOFTEST) | (given == np.inf))  # also false for NaN
    remedy = f"give the stiffness of the surface, force per length^3, from {_SOFTEST:g} to {1 / _SOFTEST:g}, or inf for a rigid one"
    check_entries(argument, given, fits, remedy)
    return frozen(for_each(argument, given, n))


def compliances(tangential: object, normal: object, width: Array, tangents: int) -> Array:
    """(M,) compliances of the springs of a surface with some stiffness, one number or one a node, at nodes of some width."""
    along, across = (
        1 / (checked_springs(name, k, len(width)) * width)
        for name, k in (("tangential", tangential), ("normal", normal))
    )
    return np.concatenate([*[along] * tangents, across])


def checked_bonded(
    argument: str, bonded: object, n: int, tangents: int
) -> Mapping[str, tuple[Array, Array]]:
    """Check bonded reactions, load case name -> (q, p) or all of them in the order of S, and return the pairs read-only."""
    if not (cases := checked_cases(argument, bonded, "(q, p)")):
        raise ModelError(f"{argument}: no load case; give at least one, name -> (q, p)")
    return MappingProxyType(
        {
            name: checked_pair(f"{argument}[{name!r}]", given, n, tangents)
            for name, given in cases.items()
        }
    )


def checked_bolts(
    argument: str, bolts: object, cases: Mapping[str, object]
) -> Mapping[str, tuple[float, float]]:
    """Check locked bolts, load case name -> (force, shortening), and return them read-only."""
    found = {}
    for case, pair in checked_cases(argument, bolts, "(force, shortening)").items():
        choice(f"{argument}: load case", case, cases)
        values = finite_array(name := f"{argument}[{case!r}]", pair, (2,))
        check_entries(name, values, values > 0, "give a force and a shortening above 0", "index")
        force, shortening = values.tolist()
        found[case] = force, shortening
    return MappingProxyType(found)


def checked_sizes(argument: str, sizes: object, cases: Mapping[str, object]) -> Mapping[str, float]:
    """Check sizes of load cases, name -> number above 0, and return them read-only."""
    given = checked_cases(argument, sizes, "size of its forces")
    for case in given:
        choice(f"{argument}: load case", case, cases)
    return MappingProxyType(
        {
            case: finite_number(f"{argument}[{case!r}]", size, above=0.0)
            for case, size in given.items()
        }
    )


def checked_pair(argument: str, given: Any, n: int, tangents: int) -> tuple[Array, Array]:
    """Check tangential and normal forces of n nodes, (q, p) or all of them in the order of S."""
    shape = (n,) if tangents == 1 else (n, 2)
    try:
        q, p = given if (pair := np.ndim(given[0]) > 0) else (None, None)
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise ModelError(
            f"{argument}: {shown(given)} is no pair; give (q, p), arrays of shapes {shape} and {(n,)}"
        ) from error
    if not pair:
        q, p = parted(finite_array(argument, given, ((tangents + 1) * n,)), tangents + 1)
    return finite_array(f"{argument} q", q, shape), finite_array(f"{argument} p", p, (n,))


def runs(names: Sequence[str] | Names) -> list[slice]:
    """The nodes of each contact, from the name of the contact of each node."""
    starts = [i for i in range(len(names)) if i == 0 or names[i] != names[i - 1]]
    return [slice(start, end) for start, end in pairwise([*starts, len(names)])]


def arc_length(points: Array, frames: Array, contact: Names | None) -> Array:
    """(N,) coordinates along a tangent that all nodes share and rise along, else arc length from the first node's, contacts one spacing apart.

    ModelError if they do not rise.
    """
    pieces = [slice(None)] if contact is None else runs(contact)
    x = points @ frames[0, 0]
    if (frames != frames[0]).any() or (len(pieces) > 1 and (np.diff(x) <= 0).any()):
        end = 0.0
        for number, piece in enumerate(pieces):
            p = points[piece]
            lengths = np.hypot(*np.diff(p, axis=0).T)
            step = float(lengths.mean()) if len(lengths) else 1.0
            first = float(frames[0, 0] @ p[0])
            start = end + step if number else first * (abs(first) > SAME_POINT * lengths.sum())
            x[piece] = start + np.r_[0.0, np.cumsum(lengths)]
            end = float(x[piece][-1])
    if (falls := np.diff(x) <= 0).any():
        i = int(falls.argmax())
        raise ModelError(
            f"x: x[{i + 1}] = {x[i + 1]:g} does not exceed x[{i}] = {x[i]:g}; order the nodes along the interface"
        )
    return np.asarray(x)


def symmetrised(name: str, matrix: Array) -> Array:
    """The symmetric part of a matrix that is symmetric up to rounding."""
    asymmetry = [
        float(np.abs(row - column).max()) for row, column in zip(matrix, matrix.T, strict=True)
    ]  # no copy of what fills the memory
    if max(asymmetry) > CONDENSATION * max(matrix.max(), -matrix.min()):
        i = int(np.argmax(asymmetry))
        j = int(np.abs(matrix[i] - matrix[:, i]).argmax())
        raise ModelError(
            f"{name}: not symmetric, {name}[{i}, {j}] = {matrix[i, j]:g} but {name}[{j}, {i}] = {matrix[j, i]:g}; "
            "give the stiffness of the relative motion, in the same order for rows and columns"
        )
    mean = matrix + matrix.T
    mean /= 2
    mean.flags.writeable = False
    return mean


def check_semi_definite(name: str, S: Array) -> None:
    """Check that S has no negative eigenvalue beyond rounding; error messages call it `name`."""
    scale = np.abs(S).max()
    if scale == 0:
        return
    slack = CONDENSATION * len(S)
    # a Cholesky factorisation of the slightly shifted matrix decides at a tenth of the cost of the
    # eigenvalues
    try:
        factor = S / scale
        factor[np.diag_indices_from(S)] += slack
        for start in range(0, len(S), _BLOCK):  # in place, as three copies would fill the memory
            block, done = slice(start, start + _BLOCK), slice(start)
            factor[start:, block] -= factor[start:, done] @ factor[block, done].T
            factor[start:, block] = np.linalg.solve(
                np.linalg.cholesky(factor[block, block]), factor[start:, block].T
            ).T
    except np.linalg.LinAlgError:
        lowest = np.linalg.eigvalsh(S / scale)[0]
        raise ModelError(
            f"{name} has the negative eigenvalue {lowest * scale:g} (largest entry {scale:g}); "
            "an elastic interface stores energy, so S must be positive semi-definite: check signs, the order of the nodes, and that it was computed "
            "with 16 digits (float32 has 7)"
        ) from None


def in_series(S: Array, own: Array, R: Array, give: Array) -> tuple[Array, Array, Array]:
    """Stiffness `(1 + S G)^-1 S` and reactions `(1 + S G)^-1 R` with a spring in series with each motion; and what it adds to the compliance.

    S (M, M), R (M, k), compliances `give` (M,) of the springs, the diagonal of G, and sizes `own`
    (M,) of S of each motion, > 0. In the factors of `S = F F^T` the inverse is that of `1 + F^T G
    F`: no spring is too stiff or too soft for it, and rigid motions stay free. The added
    compliance, `R^T (G^-1 + S)^-1 R`, is twice the energy that least squares of the strains of
    bodies and springs leave.
    """
    root = np.sqrt(own)
    values, vectors = np.linalg.eigh(S / np.outer(root, root))
    strained = values > RIGID
    sizes, V = np.sqrt(values[strained]), vectors[:, strained]
    F = root[:, None] * V * sizes
    spring = np.sqrt(give)[:, None]
    rows, loads = (
        np.vstack([spring * F, np.eye(F.shape[1])]),
        np.vstack([spring * R, np.zeros((F.shape[1], R.shape[1]))]),
    )
    falling = np.argsort(
        -np.abs(rows).max(axis=1, initial=0.0), kind="stable"
    )  # so the factors lose least
    Q, factor = np.linalg.qr(rows[falling])
    strain = np.linalg.solve(factor, Q.T @ loads[falling])
    half, left = np.linalg.solve(factor.T, F.T), loads - rows @ strain
    return half.T @ half, R - F @ strain, left.T @ left


def overlapping(S: Array, R: Array, L: Array, D: Array) -> tuple[Array, Array]:
    """Bonded reactions R (M, k) and compliance L (k, k) of load cases with overlaps D (N, k), too.

    An overlap stores the energy of the closed contact that holds it; the displacement of its load
    case is the one that gives this energy back.
    """
    held, p = S[:, -len(D) :] @ D, R[-len(D) :]
    return R + held, L - D.T @ p - p.T @ D - D.T @ held[-len(D) :]


def following(S: Array, opened: Booleans, bonded: Sequence[tuple[Array, Array]]) -> Array | None:
    """(M, M) compliance of open nodes, which follow the others without force, zero elsewhere.

    None if the others, or nothing where all are open, do not hold them.
    """
    out = np.tile(opened, len(S) // len(opened))
    values, vectors = np.linalg.eigh(S[np.ix_(out, out)])
    held = values > _HELD * max(values[-1], np.finfo(float).tiny)
    loads = [joined(*pair) for pair in bonded]
    driven = [
        r[out] @ vectors[:, ~held] / (np.abs(r).max() or 1.0) for r in loads
    ]  # a way aside that no load takes does not matter
    if (
        max(
            np.abs(part).max(initial=0.0)
            for part in (*driven, vectors[-int(opened.sum()) :, ~held])
        )
        > _HELD
    ):
        return None
    give = np.zeros_like(S)
    give[np.ix_(out, out)] = (vectors[:, held] / values[held]) @ vectors[:, held].T
    return give
