"""The discrete contact problem in three dimensions: two tangents and a normal at every node pair."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from ..contact import storage
from ..contact.checks import Array, check_name, checked_loads, choice, finite_array, frozen, real_array
from ..contact.dispatch import OtherContact
from ..contact.show import Shown
from ..contact.stiffness import check_semi_definite, symmetrised
from ..contact.tolerances import ORTHONORMAL, RIGID
from ..errors import ModelError

__all__ = ["ContactSystem3D", "checked_3d", "joined", "parted"]

_ANSWERS = {  # public question -> file of this room with the function of that name
    "march": "march",
    "onset": "first_events",
    "referee": "coulomb",
    "safe_slip": "margin",
    "shakedown_limit": "shakedown",
    "steady_state": "steady",
}
_GUARANTEE = "is not yet offered in three dimensions; use shakedown_limit, above which nothing is safe, and steady_state from several starts below it"
_REFUSED = {
    "guaranteed_limit": f"guaranteed_limit {_GUARANTEE}",
    "verify_guaranteed": f"verify_guaranteed {_GUARANTEE}",
    "safe_vertices": "safe_vertices is for plane contacts only: the safe slips of friction circles are no polytope; use safe_slip",
}
_FORM = "frictopt contact system in three dimensions 1"
_NAMES = ("S", "points", "gap", "frames")


@dataclass(frozen=True, eq=False, repr=False)
class ContactSystem3D(Shown, OtherContact):
    """N node pairs of two elastic bodies in three dimensions, condensed to their interface.

    The relative motion of body 1 with respect to body 2 at a pair is `(v1, v2, w)` along the pair's tangents and normal, `w` opening positive; the
    reaction of body 2 on body 1 is `(q1, q2, p)`, `p` compression positive. With `u = [v1, v2, w - gap]` of all nodes, first all v1::

        r = r^w + S u,   r = [q1, q2, p]

    The law is Coulomb's with a circle: `|(q1, q2)| <= f p`, and slip opposes friction. `onset`, `shakedown_limit`, `safe_slip`, `march`,
    `steady_state`, `dissipation_study` and `referee` take it as they take a `ContactSystem`; slips and shear forces are (N, 2) then.
    Theory, eq. (20).

    Parameters
    ----------
    S
        (3N, 3N) stiffness, force per length; symmetric and positive semi-definite.
    points
        (N, 3) coordinates of the node pairs, length.
    bonded
        Load case name -> r, the (3N,) bonded reactions under the unit load, force.
    gap
        (N,) initial gap >= 0, length; None, or empty, for a complete contact.
    frames
        (N, 3, 3) the pairs' directions: rows are the two tangents and the normal, which points from body 2 into body 1. None, or empty: x, y and z.

    Raises
    ------
    ModelError
        Wrong shape or type, entries not finite, S not symmetric or not positive semi-definite up to rounding, negative gap, frames that are not
        orthonormal, no load case. Rounding asymmetry is removed.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem3D(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> node
    ContactSystem3D(nodes=1, loads=['P', 'Q', 'R'], gap=False)
    >>> q, p = node.reaction({"P": 2.0, "Q": 0.3, "R": 0.4})
    >>> q.tolist(), p.tolist()
    ([[0.3, 0.4]], [2.0])
    """

    S: Array
    points: Array
    bonded: Mapping[str, Array]
    gap: Array = field(default_factory=lambda: frozen([]))
    frames: Array = field(default_factory=lambda: frozen([]))

    def __post_init__(self) -> None:
        points = finite_array("points", self.points, (None, 3))
        n = len(points)
        if n == 0:
            raise ModelError("points: no nodes; a contact needs at least one node pair")
        S = symmetrised("S", finite_array("S", self.S, (3 * n, 3 * n)))
        check_semi_definite("S", S)
        none = self.gap is None or real_array("gap", self.gap).size == 0
        gap = frozen(np.zeros(n)) if none else finite_array("gap", self.gap, (n,))
        if gap.min() < 0:
            raise ModelError(f"gap: {gap.min():g} at node {int(gap.argmin())}; the bodies cannot overlap before loading, give gap >= 0")
        straight = self.frames is None or real_array("frames", self.frames).size == 0
        frames = frozen(np.tile(np.eye(3), (n, 1, 1))) if straight else finite_array("frames", self.frames, (n, 3, 3))
        errors = np.abs(frames @ frames.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        if errors.max() > ORTHONORMAL:
            raise ModelError(f"frames: the directions of node {int(errors.argmax())} are not orthonormal; give two unit tangents and the unit normal")
        for name, value in {"S": S, "points": points, "gap": gap, "frames": frames, "bonded": _checked_bonded("bonded", self.bonded, n)}.items():
            object.__setattr__(self, name, value)

    def _answer(self) -> Mapping[str, Any]:
        return {"nodes": self.nodes, "loads": sorted(self.bonded), "gap": bool(self.gap.any())}

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return len(self.points)

    @property
    def slip_shape(self) -> tuple[int, ...]:
        """Shape of a slip of all nodes, (N, 2)."""
        return (self.nodes, 2)

    @property
    def A(self) -> Array:  # type: ignore[override]
        """(2N, 2N) block of S: shear forces `[q1, q2]` by slips `[v1, v2]`."""
        return self.S[: 2 * self.nodes, : 2 * self.nodes]

    @property
    def B(self) -> Array:  # type: ignore[override]
        """(N, 2N) block of S: pressures by slips."""
        return self.S[2 * self.nodes :, : 2 * self.nodes]

    @property
    def C(self) -> Array:  # type: ignore[override]
        """(N, N) block of S: pressures by gaps."""
        return self.S[2 * self.nodes :, 2 * self.nodes :]

    @property
    def stiffness_scale(self) -> float:
        """Mean of the diagonal of S (1 if S is zero): the scale that turns mean forces into the scale of slips."""
        return float(np.trace(self.S) / len(self.S)) or 1.0

    @property
    def own_stiffness(self) -> Array:
        """(3N,) diagonal of S; where a direction has no more than rounding, the largest of its node (the scale of all where that is zero)."""
        own = np.diag(self.S).reshape(3, self.nodes)
        most = own.max(axis=0)
        most = np.where(most > 0, most, self.stiffness_scale)
        return np.asarray(np.where(own > RIGID * most, own, most).ravel())

    @cached_property
    def rigid_motions(self) -> Array:
        """(3N, k) relative motions that strain nothing, an orthonormal basis: the slides, turns and lifts of bodies that no support guides."""
        stretch, motions = np.linalg.eigh(self.S)
        return frozen(motions[:, stretch <= RIGID * max(stretch[-1], 0.0)])

    def reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Bonded reactions, (N, 2) `q` and (N,) `p`, under a sum of load cases, name -> amplitude.

        Raises
        ------
        ModelError
            A load case that the system does not have, an amplitude that is not finite.
        """
        r = np.zeros(3 * self.nodes)
        for name, amplitude in checked_loads("loads", loads).items():
            if name not in self.bonded:
                raise ModelError(f"load case {name!r}: unknown; this system has {sorted(self.bonded)}")
            r = r + amplitude * self.bonded[name]
        return parted(r)

    def closed_reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Reactions with every gap pressed shut and no slip (v = w = 0), from the bonded reactions and the initial gap."""
        q, p = self.reaction(loads)
        if not self.gap.any():
            return q, p
        shut, pressed = parted(self.S[:, 2 * self.nodes :] @ self.gap)
        return q - shut, p - pressed

    def with_bonded(self, cases: Mapping[str, Any]) -> Self:
        """Copy with load cases added or replaced, name -> r.

        Raises
        ------
        ModelError
            Not a mapping, or a bad load case, see `ContactSystem3D`.
        """
        return replace(self, bonded={**self.bonded, **_checked_bonded("cases", cases, self.nodes)})

    def with_gap(self, gap: Any) -> Self:
        """Copy with another initial gap, (N,) or None."""
        return replace(self, gap=gap)

    def save(self, path: str | Path) -> None:
        """Write the system to a file as an npz archive of plain arrays (no pickle, not compressed) with a digest of its content.

        Raises
        ------
        ModelError
            The file cannot be written.
        """
        storage.write(path, {name: getattr(self, name) for name in _NAMES}, self.bonded, _FORM)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a system from an archive written by `save`.

        Raises
        ------
        ModelError
            The file is missing, damaged or not ours.
        """
        arrays, bonded = storage.read_archive(path, _FORM, _NAMES)
        return cls(**arrays, bonded=bonded)

    @classmethod
    def answers(cls, question: str) -> Callable[..., Any]:
        """The function of this room that answers a public question.

        Raises
        ------
        ModelError
            A question that has no answer in three dimensions; the message says why.
        """
        if choice("question", question, [*_ANSWERS, *_REFUSED]) in _REFUSED:
            raise ModelError(_REFUSED[question])
        return getattr(import_module(f"{__package__}.{_ANSWERS[question]}"), question)  # type: ignore[no-any-return]


def checked_3d(system: Any) -> ContactSystem3D:
    """Check that `system` is a contact system in three dimensions."""
    if not isinstance(system, ContactSystem3D):
        raise ModelError(f"system: a {type(system).__name__}; give a ContactSystem3D")
    return system


def joined(q: Array, p: Array) -> Array:
    """(..., 3N) values ordered by component, from (..., N, 2) tangential and (..., N) normal ones: the inverse of `parted`."""
    return np.concatenate([q[..., 0], q[..., 1], p], axis=-1)


def parted(r: Array) -> tuple[Array, Array]:
    """(..., N, 2) tangential and (..., N) normal components of (..., 3N) values ordered by component."""
    n = r.shape[-1] // 3
    return np.stack([r[..., :n], r[..., n : 2 * n]], axis=-1), r[..., 2 * n :]


def _checked_bonded(argument: str, bonded: Any, n: int) -> Mapping[str, Array]:
    if not isinstance(bonded, Mapping):
        raise ModelError(f"{argument}: a {type(bonded).__name__}; give a mapping, load case name -> r")
    if not bonded:
        raise ModelError(f"{argument}: no load case; give at least one, name -> r")
    for name in bonded:
        check_name(argument, name)
    return MappingProxyType({name: finite_array(f"{argument}[{name!r}]", r, (3 * n,)) for name, r in bonded.items()})
