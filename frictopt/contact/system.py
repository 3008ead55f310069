"""The discrete contact problem: the interface's stiffness, its bonded reactions and its gap."""

from __future__ import annotations

# One file because the whole package shares this type: its data, their shapes, and its copies.
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    ROUNDING,
    Array,
    Integers,
    Loads,
    PerNode,
    Plotted,
    Shown,
    Table,
    checked_cases,
    checked_contact,
    checked_loads,
    finite_array,
    finite_number,
    frame,
    free_motions,
    frozen,
    kept,
    real_array,
    shown,
    whole,
    whole_array,
)
from ..base.checks import Names, by_contact, checked_units, flag, per_node
from ..errors import ModelError
from . import files
from .components import amplitudes_of, arc_length, joined, parted
from .given_parts import (
    checked_bolts,
    checked_bonded,
    checked_frames,
    checked_gap,
    checked_sizes,
    checked_strength,
    checked_stretch,
    compliances,
    positive,
)
from .stiffness import check_semi_definite, in_series, overlapping, symmetrised


@kept
@dataclass(frozen=True, eq=False, repr=False)
class ContactSystem(Shown, Plotted):
    """N node pairs of two elastic bodies, condensed to their interface.

    Flicek et al. 2015, section 2.

    Each pair has one normal and t tangents, t = 1 in the plane and 2 in space. The reactions `r =
    [q, p]` of body 2 on body 1 follow from the relative motion `u = [v, w - gap]` of body 1 with
    respect to body 2::

        q = q^w + A v + B^T (w - gap)         along the tangents
        p = p^w + B v + C (w - gap)           normal, compression positive

    with the slip `v`, the gap `w`, and the bonded reactions `q^w, p^w` of the glued interface,
    which are linear in the loads. Slips and shear forces are (N,) in the plane and (N, 2) in space.
    In the plane forces are per unit depth, and the tangent is the normal turned by -90 degrees.
    Theory, eq. (1).

    Parameters
    ----------
    S
        (M, M) stiffness `[[A, B^T], [B, C]]`, M = (t + 1) N, force per length; symmetric and
        positive semi-definite. Its unknowns are ordered by component: first v of all nodes (v along
        the first tangent, then along the second one), then w.
    points
        (N, t + 1) coordinates of the nodes, length. In the plane they follow each other along the
        tangents, one contact after the other.
    bonded
        Load case name -> the bonded reactions under the unit load, force: `(q, p)`, or all of them
        in the order of S, (M,).
    gap
        (N,) initial gap `g0 >= 0`, length; None for a complete contact (no gap).
    frames
        (N, t + 1, t + 1) directions of each pair: its rows are the tangents and the normal, which
        points from body 2 into body 1. None: the axes.
    contact
        (N,) name of the contact that each node belongs to; the nodes of one contact follow each
        other. For this and the following parameters, None means that the value is unknown.
    deck_node
        (N,) number that the node of body 1 has in its deck. `condense` takes it from the points of
        a job. Tables have it in a column. Texts name it beside the number of the node in this
        system, which counts from 0.
    width
        (N,) tributary lengths (areas in space) > 0; a reaction divided by its width is a mean
        traction.
    E_star
        Contact modulus of the bodies, `1/E_star = sum of (1 - nu^2)/E`, force per area. It serves
        only as the unit of dimensionless results.
    compliance
        (cases, cases) compliance of the load cases on the glued bodies, in the order of `bonded`.
        Only `displacements` uses it. Entry (j, k) is the displacement of load case j under the unit
        load k. This is the work of the unit load j on the motion due to the unit load k.
    bolts
        Load case name of a locked bolt -> (force, shortening), both above 0: the force to which the
        bolt is tightened, and the length by which its unit amplitude shortens it. The work of the
        unit load of a locked bolt is minus the tension times the shortening, see `tension`.
    load_size
        Load case name -> size of its unit load, force, > 0: the absolute values of its tractions
        and of its forces per volume, integrated, plus the sizes of its forces on nodes and points.
        The displacement of the load case divided by its size is a length: the mean motion, along
        the load, of the loaded surface, volume or points. `condense` of a model computes it.
    shear_strength
        (N,) largest size of the shear force at each node, force, > 0: the strength of the surface
        times the area. inf: friction alone bounds it. See `with_shear_strength`, also for the
        functions that support it.
    stretch
        Ratio, in the shape of slips, > 0: the slips of this system are the true slips times
        `stretch`, and its shear forces are the true shear forces divided by `stretch`. The ratio is
        1 unless friction differs along the tangents, see `with_orthotropic_friction`.
    units
        Names of the units of force and length, such as "N, mm", for the axes of pictures and
        `attrs["units"]` of tables. They do not affect any number.
    axisymmetric
        Whether the bodies are axisymmetric. Forces, works and widths are then totals over the
        circumference, otherwise per unit depth in the plane. This affects only the names of units.
    thickness
        Thickness of plane bodies whose forces, works and widths are totals over it; None: they are
        per unit depth. This affects only the names of units.

    Attributes
    ----------
    nodes, tangents, slip_shape
        Number N of node pairs; number t of tangents of each pair; shape of the slips of all nodes,
        (N,) or (N, 2).
    stiffness_scale
        Mean of the diagonal of S (1 if S is zero): the scale that turns mean forces into the scale
        of slips.
    own_stiffness
        (M,) diagonal of S. An entry that is zero up to rounding is replaced by the largest entry of
        its node. If all entries of a node are zero, they are replaced by `stiffness_scale`.

    Raises
    ------
    ModelError
        Wrong shape or type, entries not finite, S not symmetric or not positive semi-definite up to
        rounding (rounding asymmetry is removed), negative gap, frames that are not orthonormal,
        nodes in the plane that are not in their order, no load case, a contact in several pieces,
        width not positive, a compliance that is not symmetric.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(
    ...     np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]}
    ... )
    >>> node
    ContactSystem(nodes=1, tangents=2, loads=['P', 'Q', 'R'], gap=False)
    >>> node.reaction({"P": 2.0, "Q": 0.3, "R": 0.4})[0].tolist()
    [[0.3, 0.4]]
    """

    S: Array
    points: Array
    bonded: Mapping[str, Any]
    _: KW_ONLY
    gap: Array = field(default_factory=lambda: frozen([]))
    frames: Array = field(default_factory=lambda: frozen([]))
    contact: Names | None = None
    deck_node: Integers | None = None
    width: Array | None = None
    E_star: float | None = None
    compliance: Array | None = None
    bolts: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    load_size: Mapping[str, float] = field(default_factory=dict)
    shear_strength: Array = field(default_factory=lambda: frozen([]))
    stretch: Array = field(default_factory=lambda: frozen([]))
    units: str | None = None
    axisymmetric: bool = False
    thickness: float | None = None
    nodes: int = field(init=False)
    tangents: int = field(init=False)
    slip_shape: tuple[int, ...] = field(init=False)
    stiffness_scale: float = field(init=False)
    own_stiffness: Array = field(init=False)

    def __post_init__(self) -> None:
        points = finite_array("points", self.points, (None, None))
        n, axes = points.shape
        if n == 0:
            raise ModelError("points: no nodes; a contact needs at least one node pair")
        if axes not in (2, 3):
            raise ModelError(
                f"points: shape {points.shape}; give (N, 2) in the plane or (N, 3) in space"
            )
        tangents = axes - 1
        slip_shape = (n,) if tangents == 1 else (n, tangents)
        self._check_stiffness(n, tangents)
        gap = checked_gap(self.gap, n)
        bonded = checked_bonded("bonded", self.bonded, n, tangents)
        vars(self).update(
            points=points,
            bonded=bonded,
            gap=gap,
            nodes=n,
            tangents=tangents,
            slip_shape=slip_shape,
            frames=checked_frames(self.frames, n, axes),
            bolts=checked_bolts(self.bolts, bonded),
            load_size=checked_sizes(self.load_size, bonded),
            shear_strength=checked_strength("shear_strength", self.shear_strength, n),
            stretch=checked_stretch(self.stretch, slip_shape),
            units=checked_units(self.units),
            axisymmetric=flag("axisymmetric", self.axisymmetric),
        )
        if self.axisymmetric and tangents == 2:
            raise ModelError("axisymmetric: True for a contact in space; leave it out")
        self._check_optional_parts()
        if tangents == 1:
            _ = self.x  # refuses nodes that are not in their order

    def _check_stiffness(self, n: int, tangents: int) -> None:
        """Check S of n nodes, and keep what follows from it."""
        axes = tangents + 1
        S = symmetrised("S", finite_array("S", self.S, (axes * n, axes * n)))
        check_semi_definite(S)
        scale = float(np.trace(S) / len(S)) or 1.0
        own_stiffness = _own_stiffness(S, axes, scale)
        vars(self).update(S=S, stiffness_scale=scale, own_stiffness=own_stiffness)

    def _check_optional_parts(self) -> None:
        """Check the parts that may be None."""
        n = self.nodes
        if self.contact is not None:
            vars(self).update(contact=checked_contact(self.contact, n))
        if self.thickness is not None:
            vars(self).update(thickness=finite_number("thickness", self.thickness, above=0.0))
        if self.deck_node is not None:
            numbers = whole_array("deck_node", self.deck_node, (n,), least=0, most=10**12)
            vars(self).update(deck_node=whole(numbers))
        if self.width is not None:
            remedy = "give the length or area that the node collects, > 0"
            vars(self).update(width=positive("width", self.width, (n,), remedy))
        if self.E_star is not None:
            vars(self).update(E_star=finite_number("E_star", self.E_star, above=0.0))
        if self.compliance is not None:
            cases = len(self.bonded)
            compliance = finite_array("compliance", self.compliance, (cases, cases))
            vars(self).update(compliance=symmetrised("compliance", compliance))

    @classmethod
    def from_blocks(
        cls,
        A: ArrayLike,
        B: ArrayLike,
        C: ArrayLike,
        x: ArrayLike,
        bonded: Mapping[str, tuple[ArrayLike, ArrayLike]],
        gap: Any = None,
        **parts: Any,
    ) -> Self:
        """A contact in the plane on a straight line.

        A, B, C are the (N, N) blocks of its stiffness, x (N,) the coordinates of its nodes on the
        line. For all other arguments, such as `width` and `units`, see `ContactSystem`.

        Examples
        --------
        >>> import frictopt as fo
        >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 1], [0, 0])}
        >>> fo.ContactSystem.from_blocks(
        ...     [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads
        ... )
        ContactSystem(nodes=2, x=0 .. 1, loads=['P', 'Q'], gap=False)
        """
        line = finite_array("x", x, (None,))
        n = len(line)
        if n == 0:
            raise ModelError("x: no nodes; a contact needs at least one node pair")
        A = symmetrised("A", finite_array("A", A, (n, n)))
        B = finite_array("B", B, (n, n))
        C = symmetrised("C", finite_array("C", C, (n, n)))
        points = np.column_stack([line, np.zeros(n)])
        return cls(np.block([[A, B.T], [B, C]]), points, bonded, gap=gap, **parts)

    def _answer(self) -> Mapping[str, object]:
        answer: dict[str, object] = {"nodes": self.nodes}
        if self.tangents == 1:
            answer["x"] = f"{self.x[0]:g} .. {self.x[-1]:g}"
        else:
            answer["tangents"] = self.tangents
        if self.contact is not None:
            contacts = list(dict.fromkeys(self.contact.tolist()))
            if len(contacts) > 1:
                answer["contacts"] = contacts
        answer["loads"] = sorted(self.bonded)
        answer["gap"] = bool(self.gap.any())
        if self.capped:
            answer["shear_strength"] = True
        if self.orthotropic:
            answer["orthotropic"] = True
        if self.axisymmetric:
            answer["axisymmetric"] = True
        if self.units is not None:
            answer["units"] = self.units
        return answer

    def to_frame(self) -> Table:
        """A pandas DataFrame with one row for each node.

        Its columns are node, deck_node (if known), x (in the plane), gap, contact (if known),
        point, normal, and width (if known).
        """
        columns: dict[str, ArrayLike] = {"node": np.arange(self.nodes)}
        if self.deck_node is not None:
            columns["deck_node"] = self.deck_node
        if self.tangents == 1:
            columns["x"] = self.x
        columns["gap"] = self.gap
        if self.contact is not None:
            columns["contact"] = self.contact
        for name, vectors in (("point", self.points), ("normal", self.normals)):
            for axis, column in zip("xyz", vectors.T, strict=False):
                columns[f"{name}_{axis}"] = column
        if self.width is not None:
            columns["width"] = self.width
        return frame(columns, units=self.units)

    @property
    def x(self) -> Array:
        """(N,) coordinates along the interface in the plane, rising, length; ModelError in space.

        On a straight line it is the coordinate along the tangent. Otherwise it is the arc length,
        one contact after the other.
        """
        if self.tangents != 1:
            raise ModelError("x: a contact in space has no arc length; use `points`")
        return frozen(arc_length(self.points, self.frames, self.contact))

    @property
    def per_depth(self) -> bool:
        """Whether forces, works and widths are per unit depth: in plane strain and stress."""
        return self.tangents == 1 and not self.axisymmetric and self.thickness is None

    @property
    def capped(self) -> bool:
        """True if some node has a `shear_strength`."""
        return bool(np.isfinite(self.shear_strength).any())

    @property
    def orthotropic(self) -> bool:
        """True if friction differs along the tangents, see `with_orthotropic_friction`."""
        return bool((self.stretch != 1).any())

    @property
    def normals(self) -> Array:
        """(N, t + 1) normals, from body 2 into body 1."""
        return self.frames[:, -1]

    @property
    def A(self) -> Array:
        """(t N, t N) block of S: shear forces due to unit slips, ordered by component."""
        return self.S[: -self.nodes, : -self.nodes]

    @property
    def B(self) -> Array:
        """(N, t N) block of S: normal forces due to unit slips."""
        return self.S[-self.nodes :, : -self.nodes]

    @property
    def C(self) -> Array:
        """(N, N) block of S: normal forces due to unit gaps."""
        return self.S[-self.nodes :, -self.nodes :]

    def reaction(self, loads: Loads) -> tuple[Array, Array]:
        """Bonded reactions `(q^w, p^w)` under a sum of load cases, name -> amplitude.

        ModelError for unknown load cases or amplitudes that are not finite.
        """
        bonded = reactions(self, [checked_loads("loads", loads)])[0]
        return parted(bonded, self.tangents + 1)

    def closed_reaction(self, loads: Loads) -> tuple[Array, Array]:
        """Reactions `(q, p)` with every gap pressed shut and no slip (v = w = 0)."""
        closed = joined(*self.reaction(loads)) - self.pressing_shut(self.gap)
        return parted(closed, self.tangents + 1)

    @cached_property
    def rigid_motions(self) -> Array:
        """(M, k) relative motions that strain nothing, orthonormal.

        They are the slides, turns and lifts of bodies that no support guides. A soft body beside a
        stiff one does not count as free.
        """
        return frozen(free_motions(self.S, self.own_stiffness))

    @cached_property
    def opening(self) -> Array:
        """(M,) the initial gap as a motion: no slip, then the gap."""
        return joined(np.zeros(self.slip_shape), self.gap)

    def pressing_shut(self, gap: Array) -> Array:
        """(M,) amounts by which bonded reactions fall when the load presses a gap (N,) shut."""
        if not gap.any():
            return np.zeros((self.tangents + 1) * self.nodes)
        return self.S[:, -self.nodes :] @ gap

    @cached_property
    def _reactions(self) -> Array:
        """(M, cases) bonded reactions."""
        return np.column_stack([joined(*pair) for pair in self.bonded.values()])

    def displacements(self, amplitudes: ArrayLike, slip: ArrayLike, gap: ArrayLike) -> Array:
        """(..., cases) displacements of all load cases at states of the contact. Theory, "Joints".

        The displacements are in the order of `bonded`. If a load case consists of forces, its
        displacement is the work of its unit load. For a single force this is the displacement of
        its point along the force, for a pressure the mean displacement times the area. The
        displacement of a load case of moved supports is minus their force. The displacement of an
        interference is minus the force that presses it shut. With these definitions the work of
        friction is the total area of the loops of amplitude against displacement.

        Parameters
        ----------
        amplitudes, slip, gap
            (..., cases) amplitudes of the load cases; slip v, (..., N) or (..., N, 2), and gap w,
            (..., N), length. ModelError for other shapes, and for a system without `compliance`.

        Examples
        --------
        >>> import frictopt as fo
        >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks(
        ...     [[2.0]], [[0.0]], [[2.0]], [0.0], loads, compliance=[[3, 0], [0, 4]]
        ... )
        >>> node.displacements(
        ...     [1.0, 0.5], slip=[-0.25], gap=[0.0]
        ... ).tolist()  # glued 0.5 x 4, and the slip that the force "Q" pushes
        [3.0, 2.25]
        """
        if self.compliance is None:
            raise ModelError(
                "compliance: not known; `condense` finds it, or give that of the load cases on "
                "the glued bodies to the system"
            )
        loads = real_array("amplitudes", amplitudes)
        v = real_array("slip", slip)
        w = real_array("gap", gap)
        shapes = v.shape[v.ndim - len(self.slip_shape) :], w.shape[-1:], loads.shape[-1:]
        if shapes != (self.slip_shape, (self.nodes,), (len(self.bonded),)):
            raise ModelError(
                f"amplitudes, slip, gap: shapes {loads.shape}, {v.shape}, {w.shape}; give (..., "
                f"{len(self.bonded)}), (..., {self.slip_shape}), (..., {self.nodes})"
            )
        return loads @ self.compliance - joined(v, w - self.gap) @ self._reactions

    def tension(self, case: str, amplitudes: ArrayLike, slip: ArrayLike, gap: ArrayLike) -> Array:
        """(...,) tension of the locked bolt of a load case at states of the contact, force.

        Theory, eq. (25).

        The states are given as for `displacements`. The tension is linear in loads, slip and gap.
        ModelError for a load case without a locked bolt, and for the errors of `displacements`.

        Examples
        --------
        >>> import frictopt as fo
        >>> loads, L = {"bolt": ([0.0], [2.0]), "pull": ([0.0], [-1.0])}, [[-0.2, 0.0], [0.0, 0.0]]
        >>> node = fo.ContactSystem.from_blocks(
        ...     [[1.0]], [[0.0]], [[40.0]], [0.0], loads, compliance=L, bolts={"bolt": (2.0, 0.1)}
        ... )
        >>> node.tension(
        ...     "bolt", [[1.0, 0.0], [1.0, 4.0]], slip=[[0.0]] * 2, gap=[[0.0], [0.05]]
        ... ).round(9).tolist()  # closed, open
        [2.0, 3.0]
        """
        if case not in self.bolts:
            raise ModelError(
                f"case: {shown(case)} is no locked bolt, {sorted(self.bolts)} are; the tension of "
                "a bolt that is not locked is its force times the amplitude, for all other loads"
            )
        _, shortening = self.bolts[case]
        number = list(self.bonded).index(case)
        displacement = self.displacements(amplitudes, slip, gap)[..., number]
        return -displacement / shortening

    def with_bonded(self, cases: Mapping[str, ArrayLike]) -> Self:
        """Copy with load cases added or replaced, name -> bonded reactions, as in `ContactSystem`.

        The compliance of the copy is not known.
        """
        checked_round(self, "add load cases to the system that it was made of")
        added = checked_bonded("cases", cases, self.nodes, self.tangents)
        return replace(
            self,
            bonded={**self.bonded, **added},
            compliance=None,
            load_size=_without(self.load_size, added),
        )

    def with_interference(self, cases: Mapping[str, PerNode]) -> Self:
        """Copy with interferences: load case name -> overlap of the unassembled bodies, length.

        An overlap is >= 0, one number, (N,), or one per contact by its name.

        An amplitude of the load case multiplies the overlap. An overlap acts as a negative gap, so
        its bonded reactions are `(B^T d, C d)`. If the system has a load case of this name, the
        reactions of the overlap are added to its reactions. ModelError for overlaps that are
        negative or not finite, for a bad name, and for the name of a locked bolt.

        Examples
        --------
        >>> import frictopt as fo
        >>> node = fo.ContactSystem.from_blocks(
        ...     [[1.0]], [[0.5]], [[2.0]], [0.0], {"Q": ([1.0], [0.0])}
        ... )
        >>> node.with_interference({"fit": 0.1}).bonded["fit"][1].tolist()
        [0.2]
        """
        overlaps = {}
        for case, overlap in checked_cases("cases", cases, "overlap").items():
            if case in self.bolts:
                raise ModelError(
                    f"cases: {case!r} is a locked bolt, whose load case is its shortening; "
                    "give the overlap another load case"
                )
            remedy = "give overlaps >= 0, and an opening as a gap"
            overlaps[case] = per_node(f"cases[{case!r}]", overlap, self, remedy)

        names = list({**self.bonded, **overlaps})
        known = len(self.bonded)
        added = (0, len(names) - known)
        compliance = np.zeros((known, known)) if self.compliance is None else self.compliance
        D = np.column_stack([overlaps.get(name, np.zeros(self.nodes)) for name in names])
        R, L = overlapping(
            self.S, np.pad(self._reactions, ((0, 0), added)), np.pad(compliance, added), D
        )
        return replace(
            self,
            bonded=dict(zip(names, R.T, strict=True)),
            compliance=None if self.compliance is None else L,
            load_size=_without(self.load_size, overlaps),
        )

    def with_gap(self, gap: Any) -> Self:
        """Copy with another initial gap, (N,) or None."""
        return replace(self, gap=gap)

    def with_shear_strength(self, strength: PerNode) -> Self:
        """Copy whose surfaces shear off: at each node `|q| <= strength * width`.

        The strength does not depend on the pressure, and acts beside friction. Theory, eq. (35).

        `shakedown_limit` (without events), `gross_slip`, `march`, `steady_state` and functions that
        follow such transients support a shear strength. Transients are then computed in increments,
        also in the plane. All other functions raise an error for a system with a shear strength.

        Parameters
        ----------
        strength
            Largest shear traction, force per length^2, one number, (N,), or one per contact by its
            name, > 0. inf: friction alone bounds the shear.

        Raises
        ------
        ModelError
            No `width`; a strength of another shape, or not positive.

        Examples
        --------
        >>> import frictopt as fo
        >>> node = fo.ContactSystem.from_blocks(
        ...     [[1.0]],
        ...     [[0.0]],
        ...     [[2.0]],
        ...     [0.0],
        ...     {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])},
        ...     width=[0.5],
        ... )
        >>> cycle = fo.LoadCycle({"P": 4.0}, [{"Q": 1.0}, {"Q": -1.0}])
        >>> [
        ...     round(fo.shakedown_limit(each, cycle, friction=0.5).load_factor, 9)
        ...     for each in (node, node.with_shear_strength(2.5))
        ... ]
        [2.0, 1.25]
        """
        width = checked_width(self, "a strength acts on it")
        checked = checked_strength("strength", by_contact("strength", strength, self), self.nodes)
        return replace(self, shear_strength=checked * width)

    def with_orthotropic_friction(self, ratio: PerNode) -> Self:
        """Copy for friction that differs along the two tangents. Theory, eq. (36).

        The coefficient is f along the first tangent and `ratio` times f along the second.

        Friction bounds the shear force by an ellipse, and slip is normal to it (Michalowski & Mroz
        1978). The second tangent of the copy is stretched: its slips v2 are the slips of the joint
        times `ratio`, and its shear forces q2 are the shear forces of the joint divided by `ratio`.
        The work does not change. In these coordinates the ellipse is the circle `|q| <= f p`, and
        friction opposes slip.

        So all functions work with the copy, if `friction` is f along the first tangent. Loads,
        works, pressures, gaps, stiffness, damping and the sets of slipping and open nodes are equal
        to the values of the joint. Arrays and columns contain the stretched slips and shear forces.
        The slips of the joint are `slip / system.stretch`, its shear forces are `q *
        system.stretch`. Sizes of slips (`slip_bound`, `largest_slip`, `sliding_distance`) are also
        stretched, and a shear strength holds along the first tangent. `by_contact`,
        `fretting_table`, `recover` and pictures of slips show the slips of the joint. Add load
        cases and springs before you call this method.

        Parameters
        ----------
        ratio
            Friction along the second tangent divided by friction along the first, one number or
            (N,), > 0. `system.frames` has both tangents.

        Raises
        ------
        ModelError
            The contact is in the plane or already orthotropic, or the ratio has another shape or is
            not positive.

        Examples
        --------
        >>> import numpy as np
        >>> import frictopt as fo
        >>> node = fo.ContactSystem(
        ...     np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "X": [1, 0, 0], "Y": [0, 1, 0]}
        ... )
        >>> rolled, pushes = (
        ...     node.with_orthotropic_friction(0.5),
        ...     ({"X": 1.0}, {"Y": 1.0}, {"X": 0.6, "Y": 0.4}),
        ... )
        >>> cycles = [
        ...     fo.LoadCycle({"P": 2.0}, [push, {case: -force for case, force in push.items()}])
        ...     for push in pushes
        ... ]
        >>> [
        ...     round(fo.shakedown_limit(rolled, cycle, friction=0.3).load_factor, 9)
        ...     for cycle in cycles
        ... ]
        [0.6, 0.3, 0.6]
        """
        checked_round(self, "give one ratio to the system that it was made of")
        if self.tangents == 1:
            raise ModelError(
                "ratio: a contact in the plane has one tangent; give its friction, one or one per "
                "node"
            )
        second = per_node("ratio", ratio, self)
        second = positive("ratio", second, (self.nodes,), "give a ratio above 0")
        stretch = np.column_stack([np.ones(self.nodes), second])
        scale = joined(1 / stretch, np.ones(self.nodes))
        bonded = {name: scale * joined(*pair) for name, pair in self.bonded.items()}
        return replace(self, S=scale[:, None] * self.S * scale, bonded=bonded, stretch=stretch)

    def with_contact_stiffness(
        self, *, tangential: PerNode = np.inf, normal: PerNode = np.inf
    ) -> Self:
        """Copy with springs in series with each node, along its tangents and its normal.

        The springs model the asperities of real surfaces. They act between the bodies and the
        contact. Slip and gap of the copy are the slip and gap of the contact itself, without the
        deformation of the springs. Without springs, the corner of a complete contact is singular.
        With springs, the limits of such a contact converge as the mesh is refined. Theory,
        "Joints".

        Parameters
        ----------
        tangential, normal
            Stiffness of the surface, force per length^3, one number, (N,), or one per contact by
            its name. The springs of a node have this stiffness times its `width`. inf: rigid.

        Raises
        ------
        ModelError
            The system has no `width`; the stiffness has another shape, is not positive, or is below
            1e-150; or some but not all springs are 1e18 times softer than the bodies.

        Examples
        --------
        >>> import frictopt as fo
        >>> node = fo.ContactSystem.from_blocks(
        ...     [[1.0]],
        ...     [[0.0]],
        ...     [[2.0]],
        ...     [0.0],
        ...     {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])},
        ...     width=[0.5],
        ... )
        >>> soft = node.with_contact_stiffness(
        ...     tangential=2.0
        ... )  # half the width: as stiff as the bodies
        >>> (
        ...     soft.A.round(9).tolist(),
        ...     soft.C.round(9).tolist(),
        ...     soft.bonded["Q"][0].round(9).tolist(),
        ... )
        ([[0.5]], [[2.0]], [0.5])
        """
        checked_round(self, "add springs to the system that it was made of")
        width = checked_width(self, "the springs of a node act on it")
        springs = compliances(
            by_contact("tangential", tangential, self),
            by_contact("normal", normal, self),
            width,
            self.tangents,
        )
        if not springs.any():
            return self
        softness = springs * self.own_stiffness
        # Largest ratio of the softness of springs to the softness of the bodies, if springs are
        # rigid in other directions. Beyond it rounding hides the forces that the bodies carry.
        softest = 1e18
        if softness.max() > softest * max(softness.min(), 1.0):
            is_normal = softness.argmax() >= self.tangents * self.nodes
            raise ModelError(
                f"{'normal' if is_normal else 'tangential'}: {softness.max():.1e} times softer "
                f"than the bodies, while others are not; give at most {softest:g} times"
            )
        S, R, added = in_series(self.S, self.own_stiffness, self._reactions, springs)
        compliance = None if self.compliance is None else self.compliance + added
        bonded = dict(zip(self.bonded, R.T, strict=True))
        return replace(self, S=S, bonded=bonded, compliance=compliance)

    def save(self, path: str | Path) -> None:
        """Write an npz archive of plain arrays (no pickle) under exactly the given name.

        ModelError if the file cannot be written, or has the ending of another format, such as
        `.csv`.
        """
        files.write(path, self)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a system from an archive that `save` wrote.

        ModelError if it is missing or damaged.
        """
        return cls(**files.read(path, cls))


def _own_stiffness(S: Array, axes: int, scale: float) -> Array:
    """(M,) diagonal of S; entries that are rounding become the largest of the node, or `scale`."""
    diagonal = np.diag(S).reshape(axes, -1)
    largest = diagonal.max(axis=0)
    largest = np.where(largest > 0, largest, scale)
    return frozen(np.where(diagonal > ROUNDING * largest, diagonal, largest).ravel())


def _without(sizes: Mapping[str, float], names: Mapping[str, object]) -> dict[str, float]:
    """The sizes of all load cases except those in `names`."""
    return {name: size for name, size in sizes.items() if name not in names}


def reactions(system: ContactSystem, loads: Sequence[Loads]) -> Array:
    """(K, M) bonded reactions of K sums of load cases, ordered by component.

    ModelError if `system` is no contact system, or lacks a load case.
    """
    known = checked_system(system).bonded
    unknown = {name for load in loads for name in load} - set(known)
    if unknown:
        raise ModelError(f"load case {min(unknown)!r}: unknown; this system has {sorted(known)}")
    return amplitudes_of(loads, known) @ system._reactions.T


def checked_system(system: object) -> ContactSystem:
    """Check that `system` is a contact system."""
    if not isinstance(system, ContactSystem):
        remedy = "the condense() of a scene or a model makes one"
        if hasattr(system, "condense"):
            remedy = "call its .condense(), which makes one"
        raise ModelError(f"system: a {type(system).__name__}; give a ContactSystem ({remedy})")
    return system


def checked_width(system: ContactSystem, why: str) -> Array:
    """The widths of the nodes; without them the error says `why` they are needed."""
    if system.width is None:
        raise ModelError(
            f"width: not known, and {why}; give it, as `condense(..., width=job.areas(pairs[:, "
            "1]))`"
        )
    return system.width


def checked_round(system: object, remedy: str) -> ContactSystem:
    """Check that friction of a contact system is the same along all tangents."""
    checked = checked_system(system)
    if checked.orthotropic:
        raise ModelError(
            f"system: its friction is orthotropic, so its second tangent is stretched; {remedy}"
        )
    return checked
