"""Statics of a load, in sentences: what friction cannot stop, and what the mean load does to a contact from which no transient can start."""

from contextlib import suppress
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base import CONDENSATION, COUNTS, RIGID, ROUNDING, Array, Booleans
from ..contact import (
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    joined,
    lengths,
    most_shear,
)
from ..contact.diagnosis import counted, in_contact, open_nodes, settled
from ..errors import NoContinuation, SolverError

_WITHIN, _PROJECTIONS = (
    0.99,
    50,
)  # of the friction, so that a projection comes to lie within it; at most
# of the largest size of a motion, which one of negative work has; without one there is none, up to
# rounding
_FOUND = 0.5
_SAFE = "the mean load presses all nodes and none slips under it"
_RANGES = 4  # ranges of x that a text names
_EVEN = 0.5  # a motion whose mean is at least so large a part of it is a slide, else a turn


class _Motion(NamedTuple):
    """A rigid motion of size up to 1, and how far it is from one in which no forces within friction have work without bound."""

    phi: Array
    residual: float


def rigid_motions(S: Array, own: Array) -> Array:
    """(M, k) relative motions that strain nothing, orthonormal, zeros without rounding: the slides, turns and lifts of bodies that no support guides.

    `own` (M,) are the sizes of S at its nodes (`own_stiffness`), so that a soft body beside a stiff
    one is not taken for a free one.
    """
    from scipy.linalg import (
        solve_triangular,
    )  # here, for loads that the closed contact bears need no motions
    from scipy.linalg.lapack import dpstrf

    root = np.sqrt(own)
    factor, order, rank, _ = dpstrf(
        S / np.outer(root, root), tol=RIGID
    )  # where pivots are rounding, the others follow what is left
    motions = np.eye(len(S), len(S) - rank, -rank)
    motions[:rank] = solve_triangular(factor[:rank, :rank], -factor[:rank, rank:])
    return without_rounding(np.linalg.qr(motions[np.argsort(order)] / root[:, None])[0])


def nodal_motions(V: Array) -> Array:
    """(M, k) a basis of the motions V (M, k) in which each of k chosen entries is 1 in one motion and 0 in the others.

    The entries are chosen by pivoting, so that no other entry is large. Entries that are rounding
    are 0.
    """
    from scipy.linalg import qr

    chosen = qr(V.T, mode="r", pivoting=True)[1][: V.shape[1]]
    motions = without_rounding(np.linalg.solve(V[chosen].T, V.T).T)
    motions[chosen] = np.eye(V.shape[1])
    return motions


def without_rounding(motions: Array) -> Array:
    """Motions (M, k) with 0 for entries that are rounding beside the largest entry of their motion."""
    size = np.abs(motions)
    return np.where(size > CONDENSATION * size.max(axis=0, initial=0.0), motions, 0.0)


class Statics:
    """The rigid motions of the bodies, and which loads contact forces within friction can balance in them, whatever the bodies' compliance.

    A motion phi = (v, w) that strains nothing, S phi = 0, has the work `phi . r = phi . r^w` with
    the reactions of every state. Where `w >= f |v|` at all nodes, contact forces have no negative
    work in it (`p >= 0`, `|q| <= f p`). So a load with `phi . r^w < 0` has no state: this proves
    gross sliding, turning over or lift-off, whatever the slip and the history.

    Where slip changes no pressure, B = 0, all states have the pressures p of the load, and v need
    not lift the bodies that supports press: a motion with `A v = 0` and `v . q^w + sum of f p |v| <
    0` is the proof.

    A node whose surface has a strength c may slip by s more than its lift opens, `w + f s >= f
    |v|`: its forces then take back c s at most.
    """

    def __init__(self, system: ContactSystem, friction: Array) -> None:
        self._system, self._friction = system, friction

    @cached_property
    def _motions(self) -> Array:
        return rigid_motions(self._system.S, self._system.own_stiffness)

    @cached_property
    def _slides(self) -> Array | None:
        """(M, k) slides that strain nothing where slip changes no pressure; else None."""
        S, n = self._system.S, self._system.nodes
        size = np.sqrt(np.diag(S).clip(0.0))
        if (np.abs(S[-n:, :-n]) > ROUNDING * np.outer(size[-n:], size[:-n])).any():
            return None
        slides = rigid_motions(S[:-n, :-n], self._system.own_stiffness[:-n])
        return np.vstack([slides, np.zeros((n, slides.shape[1]))])

    def _shifts(self, V: Array) -> Array:
        """(M, k) those of some motions that move all nodes alike which move at all."""
        alike = (
            self._system.frames.transpose(1, 0, 2).reshape(len(V), -1)
            * (np.abs(V).max(axis=1) > COUNTS)[:, None]
        )
        basis, size, _ = np.linalg.svd(alike, full_matrices=False)
        basis = basis[:, size > CONDENSATION]
        within = V.T @ basis
        _, apart, ways = np.linalg.svd(basis - V @ within, full_matrices=False)
        return np.asarray(np.linalg.qr(V @ (within @ ways[apart <= CONDENSATION].T))[0])

    @cached_property
    def _strong(self) -> Booleans:
        """(N,) nodes that a strength bounds besides friction."""
        return np.isfinite(self._system.shear_strength) & (self._friction > 0)

    def _sheared_off(self, phi: Array) -> float:
        """Largest work that strengths take back in a motion: where it slips by more than its lift opens."""
        *v, w = phi.reshape(-1, self._system.nodes)[:, self._strong]
        more = np.linalg.norm(v, axis=0) - w / self._friction[self._strong]
        return float(more.clip(0.0) @ self._system.shear_strength[self._strong])

    def _balances(self, V: Array, pressed: bool, load: Array) -> bool:
        """Whether projections on either condition in turn find forces within friction that balance a load."""
        f, r = self._friction, load.reshape(-1, self._system.nodes)
        less = _WITHIN * f
        for _ in range(_PROJECTIONS):
            q, p, size = r[:-1], r[-1], np.linalg.norm(r[:-1], axis=0)
            if (size <= most_shear(self._system, f, p)).all():
                return True
            nearest = (
                p
                if pressed
                else np.where(size <= less * p, p, np.maximum(p + less * size, 0.0) / (1 + less**2))
            )
            bound = _WITHIN * most_shear(self._system, f, nearest)
            r = np.vstack([q * np.minimum(1.0, bound / np.where(size > 0, size, 1.0)), nearest])
            r = r + (V @ (V.T @ (load - r.ravel()))).reshape(r.shape)
        return False

    def _driven(self, V: Array, pressed: bool, load: Array) -> Array | None:
        """The motion (M,) of size 1 with the least work, where it is negative."""
        if not V.size or self._balances(V, pressed, load):
            return None
        import cvxpy as cp  # here, for loads that friction bears need no program

        from ..solve.chain import Chain

        n, f, c, strong = (
            self._system.nodes,
            self._friction,
            self._system.shear_strength,
            self._strong & (not pressed),
        )
        scale, share = float(np.abs(load).max()) or 1.0, cp.Variable(V.shape[1], name="share")
        *v, w = (part @ share for part in V.reshape(-1, n, V.shape[1]))
        lift = cp.Variable(n, name="lift") if pressed else w
        work, opens = (
            (V.T @ load / scale) @ share + (load[-n:] / scale @ lift if pressed else 0.0),
            lift,
        )
        rows = [cp.SOC(cp.Constant(1.0), share)]
        if strong.any():
            more = cp.Variable(n, name="more", nonneg=True)
            work, opens = (
                work + (np.where(strong, c, 0.0) / scale) @ more,
                lift + cp.multiply(f * strong, more),
            )
            rows.append(lift >= 0)
        rows.append(cp.SOC(opens, cp.multiply((1 + COUNTS) * f, cp.vstack(v))))

        def claimed() -> _Motion:
            phi = V @ share.value
            needed = f * np.linalg.norm(phi[:-n].reshape(-1, n), axis=0)
            phi[-n:] = needed if pressed else phi[-n:]
            return _Motion(phi, float((np.where(strong, 0.0, needed) - phi[-n:]).max()))

        with suppress(SolverError):
            phi = Chain(cp.Problem(cp.Minimize(work), rows), {}).solve(claimed)[0].phi
            if phi @ phi > _FOUND and phi @ load + self._sheared_off(phi) < -COUNTS * np.abs(
                phi
            ) @ np.abs(load):
                return phi
        return None

    def told(self, name: str, load: Array) -> str | None:
        """What a load (M,) that has no state does to the bodies, as a sentence that names it; None where it is not proven that it has none."""
        n, gap = self._system.nodes, self._system.gap
        if (
            not gap.any()
            and (
                np.linalg.norm(load[:-n].reshape(-1, n), axis=0)
                <= most_shear(self._system, self._friction, load[-n:])
            ).all()
        ):
            return None  # the closed contact rests
        asked: list[tuple[Array, bool, Array]] = [(self._motions, False, load)]
        if (
            self._slides is not None
            and (rest := settled(self._system, load[-n:] - self._system.C @ gap)) is not None
        ):
            asked.append((self._slides, True, np.r_[load[:-n], self._within_strength(rest[1])]))
        for motions, pressed, forces in asked:
            for V in (
                (self._shifts(motions), motions) if motions.size else ()
            ):  # a body that may slide and turn is said to slide
                if (phi := self._driven(V, pressed, forces)) is not None:
                    return self._sentence(name, forces, phi)
        return None

    def slides_off(self, name: str, forces: Array) -> str | None:
        """What a load does to bodies that may slide without opening the contact, as a sentence that names it; None where friction holds them.

        `forces` (M,) are the reactions to the load if nothing slips any more. Self-stress, such as
        that of a press fit, is in their pressures alone: statics does not know it. Slip may change
        the pressures, so this proves nothing unless no state is found besides.
        """
        _, opens, turn = np.linalg.svd(self._motions[-self._system.nodes :], full_matrices=False)
        sliding = self._motions @ turn[opens <= CONDENSATION].T
        pressed = forces.copy()
        pressed[-self._system.nodes :] = self._within_strength(
            forces[-self._system.nodes :].clip(0.0)
        )
        phi = self._driven(sliding, True, pressed)
        return None if phi is None else self._sentence(name, pressed, phi)

    def _within_strength(self, p: Array) -> Array:
        """(N,) normal forces, as far as friction grows with them."""
        return np.minimum(
            p,
            np.where(
                self._strong,
                self._system.shear_strength / np.where(self._strong, self._friction, 1.0),
                np.inf,
            ),
        )

    def _sentence(self, name: str, load: Array, phi: Array) -> str:
        """What moves, where to, and the forces: those of the load and of friction in units of the mean slip."""
        n, taken = self._system.nodes, self._sheared_off(phi)
        back = joined(self._system.stretch, np.ones(n))
        phi, load = (phi / back).reshape(-1, n), (load * back).reshape(-1, n)
        sizes = np.linalg.norm(phi[:-1], axis=0)
        moves = np.abs(phi).max(axis=0) > COUNTS * np.abs(phi).max()
        where, mean = (
            "" if moves.all() else f" at {counted(self._system, moves)}",
            float(sizes[moves].mean()),
        )
        demand, holds = (
            float(part) / (mean or 1.0)
            for part in (-np.sum(phi[:-1] * load[:-1]), phi[-1] @ load[-1] + taken)
        )
        if mean <= COUNTS * np.abs(phi).max() or demand <= 0 or holds < -COUNTS * demand:
            return f"the body lifts off or turns over{where}: no pressure with friction up to f p balances {name}; hold it, or press it"
        along = np.einsum("an,nak->nk", phi[:-1], self._system.frames[:, :-1])[moves].mean(axis=0)
        size = float(np.linalg.norm(along))
        held = f"the {max(holds, 0.0):.4g} of friction{' and strength' * self._system.capped}"
        if size <= _EVEN * mean:
            forces = f"drives it with {demand:.4g} per mean slip, above {held}"
            return f"the body turns as a whole{where}: {name} {forces}; hold it, or press it"
        way = ", ".join(f"{part:g}" for part in (along / size).round(6) + 0.0)
        forces = f"has the shear force {demand:.4g} along ({way}), above {held if self._system.capped else f'f P = {max(holds, 0.0):.4g}'}"
        return f"the body slides as a whole{where}: {name} {forces}; hold it, or press it"


def check_sliding(system: ContactSystem, friction: Array, loads: dict[str, Array]) -> None:
    """Check that contact forces can balance each load, by name its bonded reactions (M,); else NoContinuation names the motion, see `Statics`."""
    statics = Statics(system, friction)
    for name, load in loads.items():
        if text := statics.told(name, load):
            raise NoContinuation(text)


def mean_load_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> str:
    """What is wrong with the mean load and how to correct it, or that nothing is wrong: sentences joined by "; ", without a full stop.

    Whether it is zero or pulls the bodies apart, which nodes it leaves open or without pressure,
    whether it makes a body slide, turn or lift off as a whole, and which nodes are beyond their
    friction bound while nothing slips.
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    glued_q, glued_p = system.reaction(checked_cycle(cycle).mean)
    if not glued_p.any():
        what = "has no normal reactions" if glued_q.any() else "is zero"
        return f"the mean load {what}, and nothing presses the bodies together: give `cycle.mean` a load that does"
    if glued_p.sum() <= CONDENSATION * np.abs(glued_p).sum():
        return _pulls(glued_p)
    if moved := Statics(system, f).told("the mean load", joined(glued_q, glued_p)):
        return moved  # whatever opens
    q, p = cycle.mean_reaction(system)
    floor, shear = (
        CONDENSATION * float(np.abs(np.r_[glued_q.ravel(), glued_p]).mean()),
        lengths(q, p),
    )
    if (p < -floor).any():
        return _opens(system, p, floor)
    bare, smooth, beyond = (
        np.abs(p) <= floor,
        (f == 0) & (shear > floor),
        shear > most_shear(system, f, p) + floor,
    )
    texts = list[str]()
    if bare.any():
        texts.append(
            f"{_share(system, bare)} carry no pressure under the mean load if nothing slips"
        )
    if smooth.any():
        texts.append(
            f"{_share(system, smooth)} have no friction and slip under the shear of the mean load"
        )
    if not texts and beyond.any():
        bound, more = (
            ("bound of friction or strength", "more of the lower one")
            if system.capped
            else ("friction bound f p", "more friction")
        )
        return f"the mean load presses all nodes, but {_share(system, beyond)} exceed their {bound} and slip: {more}, or less shear"
    return "; ".join(texts) or _SAFE


def unscaled_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> str:
    """The same of what the load factor leaves as it is: of the mean load, or of it with the first `fixed` part that is not safe if nothing slips."""
    if checked_cycle(cycle).fixed is None:
        return mean_load_diagnosis(system, cycle, friction)
    for k, loads in enumerate(cycle.unscaled):
        text = mean_load_diagnosis(system, LoadCycle(loads, cycle.corners), friction)
        if text != _SAFE:
            return text.replace("the mean load", f"the mean load with fixed[{k}]")
    return "with each of the fixed parts the mean load presses all nodes and none slips"


def _pulls(p: Array) -> str:
    pulls = (
        "pulls the bodies apart"
        if p.sum() < -CONDENSATION * np.abs(p).sum()
        else "does not press the bodies together"
    )
    return (
        f"the mean load {pulls}: its normal reactions sum to {p.sum():.3g}, and compression must be positive; "
        "turn the sign of the load, or press the contact; normals of your own must point from body 2 into body 1"
    )


def _opens(system: ContactSystem, p: Array, floor: float) -> str:
    opened = open_nodes(system, p)
    if opened is None:
        return f"the mean load would pull at {_share(system, p < -floor)} if the contact were closed: press it there"
    gaps = int((opened & (system.gap > 0)).sum())
    initial = f", {gaps} of them with an initial gap that the load does not close" if gaps else ""
    return (
        f"{_share(system, opened)} are open under the mean load alone if nothing slips{initial}: the contact is incomplete; press these nodes "
        "if they are to carry load"
    )


def _share(system: ContactSystem, which: np.ndarray) -> str:
    """Number and contacts of the nodes, or where there is one contact their positions, as a text."""
    numbers = np.flatnonzero(which)
    if in_contact(system, numbers):
        return counted(system, np.asarray(which))
    if system.tangents == 2:
        low, high = (pick(system.points[numbers], axis=0) for pick in (np.min, np.max))
        where = (
            f"{name} = {a:.4g}" + (f" .. {b:.4g}" if b > a else "")
            for name, a, b in zip("xyz", low, high, strict=True)
        )
        return f"{len(numbers)} of {system.nodes} nodes ({', '.join(where)})"
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    ranges = [
        f"{system.x[run[0]]:.4g}" + (f" .. {system.x[run[-1]]:.4g}" if len(run) > 1 else "")
        for run in runs[:_RANGES]
    ]
    more = ", ..." if len(runs) > _RANGES else ""
    return f"{len(numbers)} of {system.nodes} nodes (x = {', '.join(ranges)}{more})"
