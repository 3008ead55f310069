"""The discrete contact problem: the interface's stiffness, its bonded reactions and its gap."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from ..errors import ModelError
from . import storage
from .checks import Array, Names, check_name, checked_contact, checked_loads, checked_overlaps, finite_array, finite_number, frozen, real_array, shown
from .dispatch import OtherContact
from .show import Shown, frame
from .stiffness import check_semi_definite, symmetrised
from .tolerances import UNIT_LENGTH

__all__ = ["ContactSystem", "checked_kind", "checked_system"]


@dataclass(frozen=True, eq=False, repr=False)
class ContactSystem(Shown):
    """N node pairs of two elastic bodies, condensed to their interface (Flicek et al. 2015, section 2).

    The reactions `r = [q, p]` of body 2 on body 1 (per unit depth) follow from the relative motion `u = [v, w - gap]` of body 1 with
    respect to body 2::

        q = q^w + A v + B^T (w - gap)         tangential, along +x
        p = p^w + B v + C (w - gap)           normal, compression positive

    with `v` along +x, `w` opening positive, and the bonded reactions `q^w, p^w` (interface glued) linear in the loads. On a contact that is not
    straight, or on several of them, each node has its own directions: `w` along its normal, from body 2 into body 1, and `v` along its tangent,
    the normal turned by -90 degrees (normal +y, tangent +x). `x` is then the arc length, one contact after the other. Theory, eq. (1).

    Parameters
    ----------
    A, B, C
        (N, N) blocks of the stiffness `S = [[A, B^T], [B, C]]`, force per length and depth; S symmetric and positive semi-definite.
    x
        (N,) coordinates of the nodes along the interface, strictly increasing, length.
    bonded
        Load case name -> `(q, p)`, the (N,) bonded reactions under the unit load, force per depth.
    gap
        (N,) initial gap `g0 >= 0`, length; None, or empty, for a complete contact (no gap).
    E_star
        Contact modulus of the bodies, `1/E_star = sum of (1 - nu^2)/E`, force per area. It only serves as a unit of dimensionless results.
        None: not known.
    points
        (N, 2) coordinates of the nodes, length. None: not known.
    normals
        (N, 2) normals of unit length, from body 2 into body 1. None: not known.
    contact
        (N,) name of the contact that each node belongs to; the nodes of one contact follow each other. None: not known.
    width
        (N,) tributary lengths > 0: reactions over width are mean tractions. None: not known.

    Raises
    ------
    ModelError
        Wrong shape or type, entries not finite, S not symmetric or not positive semi-definite up to rounding, negative gap, x not
        increasing, no load case, normals not of unit length, a contact in several pieces, width not positive. Rounding asymmetry is removed:
        A and C are stored symmetrised.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 1], [0, 0])},
    ... )
    >>> system
    ContactSystem(nodes=2, x=0 .. 1, loads=['P', 'Q'], gap=False)
    >>> q, p = system.reaction({"P": 2.0, "Q": 0.5})
    >>> q.tolist(), p.tolist()
    ([0.5, 0.5], [2.0, 2.0])
    """

    A: Array
    B: Array
    C: Array
    x: Array
    bonded: Mapping[str, tuple[Array, Array]]
    gap: Array = field(default_factory=lambda: frozen([]))
    E_star: float | None = None
    points: Array | None = None
    normals: Array | None = None
    contact: Names | None = None
    width: Array | None = None

    def __post_init__(self) -> None:
        x = finite_array("x", self.x, (None,))
        n = len(x)
        if n == 0:
            raise ModelError("x: no nodes; a contact needs at least one node pair")
        if np.any(np.diff(x) <= 0):
            first = int(np.argmax(np.diff(x) <= 0))
            raise ModelError(f"x: x[{first + 1}] = {x[first + 1]:g} does not exceed x[{first}] = {x[first]:g}; order the nodes along the interface")
        A, B, C = (finite_array(name, getattr(self, name), (n, n)) for name in "ABC")
        A, C = symmetrised("A", A), symmetrised("C", C)
        check_semi_definite("A, B, C: S = [[A, B^T], [B, C]]", np.block([[A, B.T], [B, C]]))
        none = self.gap is None or real_array("gap", self.gap).size == 0
        gap = frozen(np.zeros(n)) if none else finite_array("gap", self.gap, (n,))
        if gap.min() < 0:
            raise ModelError(f"gap: {gap.min():g} at node {int(gap.argmin())}; the bodies cannot overlap before loading, give gap >= 0")
        E_star = None if self.E_star is None else finite_number("E_star", self.E_star, above=0.0)
        for name, value in {
            "E_star": E_star,
            "x": x,
            "A": A,
            "B": B,
            "C": C,
            "gap": gap,
            "bonded": _checked_bonded("bonded", self.bonded, n),
            "points": None if self.points is None else finite_array("points", self.points, (n, 2)),
            "normals": None if self.normals is None else _checked_normals(self.normals, n),
            "contact": None if self.contact is None else checked_contact("contact", self.contact, n),
            "width": None if self.width is None else _checked_width(self.width, n),
        }.items():
            object.__setattr__(self, name, value)

    def _answer(self) -> Mapping[str, Any]:
        names = [] if self.contact is None else list(dict.fromkeys(self.contact.tolist()))
        several = {"contacts": names} if len(names) > 1 else {}
        span = f"{self.x[0]:g} .. {self.x[-1]:g}"
        return {"nodes": self.nodes, "x": span, **several, "loads": sorted(self.bonded), "gap": bool(self.gap.any())}

    def to_frame(self) -> Any:
        """A pandas DataFrame with one row for each node: node, x, gap and, as far as they are known, contact, point, normal and width."""
        columns: dict[str, Any] = {"node": np.arange(self.nodes), "x": self.x, "gap": self.gap}
        if self.contact is not None:
            columns["contact"] = self.contact
        for name, values in (("point", self.points), ("normal", self.normals)):
            if values is not None:
                columns |= {f"{name}_{axis}": column for axis, column in zip("xy", values.T, strict=True)}
        return frame(columns if self.width is None else {**columns, "width": self.width})

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return len(self.x)

    @property
    def slip_shape(self) -> tuple[int, ...]:
        """Shape of a slip of all nodes, (N,)."""
        return (self.nodes,)

    @property
    def S(self) -> Array:
        """(2N, 2N) stiffness of the relative motion `[v, w]`."""
        return np.block([[self.A, self.B.T], [self.B, self.C]])

    @property
    def stiffness_scale(self) -> float:
        """Mean of the diagonal of S (1 if S is zero): the scale that turns mean forces into the scale of slips."""
        return float((np.trace(self.A) + np.trace(self.C)) / (2 * self.nodes)) or 1.0

    def reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Bonded reactions `(q^w, p^w)` under a sum of load cases, name -> amplitude.

        Raises
        ------
        ModelError
            A load case that the system does not have, an amplitude that is not finite.
        """
        q, p = np.zeros(self.nodes), np.zeros(self.nodes)
        for name, amplitude in checked_loads("loads", loads).items():
            if name not in self.bonded:
                raise ModelError(f"load case {name!r}: unknown; this system has {sorted(self.bonded)}")
            q = q + amplitude * self.bonded[name][0]
            p = p + amplitude * self.bonded[name][1]
        return q, p

    def closed_reaction(self, loads: Mapping[str, float]) -> tuple[Array, Array]:
        """Reactions `(q, p)` with every gap pressed shut and no slip (v = w = 0), from the bonded reactions and the initial gap."""
        q, p = self.reaction(loads)
        if not self.gap.any():
            return q, p
        return q - self.B.T @ self.gap, p - self.C @ self.gap

    def with_bonded(self, cases: Mapping[str, tuple[Any, Any]]) -> Self:
        """Copy with load cases added or replaced, name -> `(q, p)`.

        Raises
        ------
        ModelError
            Not a mapping, or a bad load case, see `ContactSystem`.
        """
        return replace(self, bonded={**self.bonded, **_checked_bonded("cases", cases, self.nodes)})

    def with_interference(self, cases: Mapping[str, Any]) -> Self:
        """Copy with load cases that are interferences, name -> overlap of the unassembled bodies, >= 0, one number or (N,), length.

        An amplitude of such a case multiplies the overlap. Its bonded reactions are those of a gap of minus the overlap, `(B^T d, C d)`.

        Raises
        ------
        ModelError
            Not a mapping, an overlap that is negative or not finite, or a bad name.

        Examples
        --------
        >>> import frictopt as fo
        >>> node = fo.ContactSystem([[1.0]], [[0.5]], [[2.0]], [0.0], {"Q": ([1.0], [0.0])})
        >>> node.with_interference({"fit": 0.1}).bonded["fit"][1].tolist()
        [0.2]
        """
        overlaps = checked_overlaps("cases", cases, self.nodes)
        return self.with_bonded({name: (self.B.T @ d, self.C @ d) for name, d in overlaps.items()})

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
        storage.write(path, {name: getattr(self, name) for name in storage.NAMES}, self.bonded, storage.FORM)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a system from an archive written by `save`, or from a folder of Matrix Market files.

        The folder holds `A.mtx`, `B.mtx`, `C.mtx` (N x N, dense or sparse), `x.mtx` and, if there are any, `gap.mtx`, `width.mtx` (N x 1),
        `points.mtx`, `normals.mtx` (N x 2) and `E_star.mtx` (1 x 1), and one `bonded.NAME.mtx` (N x 2, columns q and p) for each load case NAME;
        N is at most 20,000.

        Raises
        ------
        ModelError
            The file is missing or damaged, or its content is not a contact system.
        """
        return cls(**storage.read(path))


def checked_system(system: Any) -> ContactSystem:
    """Check that `system` is a contact system."""
    if not isinstance(system, ContactSystem):
        remedy = "call its .condense(), which makes one" if hasattr(system, "condense") else "the condense() of a scene or a model makes one"
        raise ModelError(f"system: a {type(system).__name__}; give a ContactSystem ({remedy})")
    return system


def checked_kind(system: Any) -> ContactSystem | OtherContact:
    """Check that `system` is a contact system of any kind."""
    return system if isinstance(system, OtherContact) else checked_system(system)


def _checked_normals(normals: Any, n: int) -> Array:
    checked = finite_array("normals", normals, (n, 2))
    lengths = np.hypot(*checked.T)
    if np.abs(lengths - 1).max() > UNIT_LENGTH:
        i = int(np.abs(lengths - 1).argmax())
        raise ModelError(f"normals: length {lengths[i]:g} at node {i}; give normals of length 1")
    return checked


def _checked_width(width: Any, n: int) -> Array:
    checked = finite_array("width", width, (n,))
    if checked.min() <= 0:
        raise ModelError(f"width: {checked.min():g} at node {int(checked.argmin())}; give the length that the node collects, > 0")
    return checked


def _checked_bonded(argument: str, bonded: Any, n: int) -> Mapping[str, tuple[Array, Array]]:
    if not isinstance(bonded, Mapping):
        raise ModelError(f"{argument}: a {type(bonded).__name__}; give a mapping, load case name -> (q, p)")
    if not bonded:
        raise ModelError(f"{argument}: no load case; give at least one, name -> (q, p)")
    checked = {}
    for name, pair in bonded.items():
        check_name(argument, name)
        try:
            q, p = pair
        except (TypeError, ValueError) as error:
            raise ModelError(f"{argument}[{name!r}]: {shown(pair)} is no pair; give (q, p), two arrays of length {n}") from error
        checked[name] = (finite_array(f"{argument}[{name!r}] q", q, (n,)), finite_array(f"{argument}[{name!r}] p", p, (n,)))
    return MappingProxyType(checked)
