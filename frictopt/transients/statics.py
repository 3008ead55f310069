"""Statics of a load: the motions of a body as a whole that friction cannot hold, in sentences.

`Statics` proves that a load has no state, because a body slides, turns or lifts off as a whole.
"""

from contextlib import suppress
from functools import cached_property
from hashlib import blake2b
from weakref import WeakKeyDictionary

import numpy as np

from ..base import CONDENSATION, COUNTS, ROUNDING, Array, Booleans, PerNode, free_motions, number_of
from ..contact import (
    BoundTerm,
    ContactLaw,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    contact_law,
    friction_coefficients,
    joined,
    lengths,
    most_shear,
)
from ..contact.components import null_space
from ..contact.diagnosis import counted, names_of_several, open_nodes, settled
from ..errors import NoContinuation, SolverError

# A motion is found if the square of its size exceeds this number. The program returns a motion of
# size 1, or of size 0 if no motion has negative work.
_PROVEN_MOTION = 0.5
# A motion is a slide, not a turn, if the size of its mean slip is at least this share of the mean
# size of its slips.
_EVEN = 0.5


# Digests of the pairs of friction and load for which contact forces balance the load. The digests
# are kept, because a report follows many transients under the same loads, and each proof takes as
# long as many increments.
_BALANCED: WeakKeyDictionary[ContactSystem, set[bytes]] = WeakKeyDictionary()


def nodal_motions(V: Array) -> Array:
    """(M, k) a basis of the motions V (M, k) in which each motion has an entry of its own.

    This entry is 1 in its motion and 0 in all other motions. The k entries are chosen by pivoting,
    so that no other entry is large.
    """
    from scipy.linalg import qr

    chosen = qr(V.T, mode="r", pivoting=True)[1][: V.shape[1]]
    motions = np.linalg.solve(V[chosen].T, V.T).T
    motions[chosen] = np.eye(V.shape[1])
    return motions


class Statics:
    """Loads that contact forces within friction can balance, for any compliance of the bodies.

    In a motion phi = (v, w) that strains nothing, S phi = 0, the reactions of every state do the
    work `phi . r = phi . r^w`. If `w >= f |v|` at all nodes, contact forces do no negative work in
    this motion (`p >= 0`, `|q| <= f p`). So a load with `phi . r^w < 0` has no state. This proves
    gross sliding, turning over or lift-off, whatever the slip and the history.

    If slip changes no pressure, B = 0, all states have the pressures p of the load. Then the motion
    need not lift bodies that supports press together: a motion with `A v = 0` and `v . q^w + sum of
    f p |v| < 0` is the proof.

    A node whose surface has a shear strength c may slip by s more than its lift w allows, `w + f s
    >= f |v|`. The work of its contact forces is then at least -c s. Other terms of the law are
    treated in the same way.
    """

    def __init__(self, system: ContactSystem, friction: Array) -> None:
        self._system = system
        self._friction = friction
        self._law = contact_law(system, friction)
        # The terms of the law other than friction, each with the nodes (N,) that it bounds.
        self._further_terms = [
            (np.isfinite(term.constant) & (friction > term.slope), term)
            for term in self._law.terms[1:]
        ]

    def sentence(self, name: str, load: Array) -> str | None:
        """A sentence on a load (M,) that is proven to have no state; None if this is not proven.

        `name` is the name of the load in the sentence.
        """
        n = self._system.nodes
        gap = self._system.gap
        shear = np.linalg.norm(load[:-n].reshape(-1, n), axis=0)
        bound = self._law.bound(load[-n:])
        if not gap.any() and (shear <= bound).all():
            # The closed contact is at rest.
            return None
        phi = self._proof(self._system.rigid_motions, False, load)
        if phi is not None:
            return self._sentence(name, load, phi)
        if self._slides is None:
            return None
        state = settled(self._system, load[-n:] - self._system.C @ gap)
        if state is None:
            return None
        forces = np.r_[load[:-n], self._within_terms(state[1])]
        phi = self._proof(self._slides, True, forces)
        return None if phi is None else self._sentence(name, forces, phi)

    def slides_off(self, name: str, forces: Array) -> str | None:
        """A sentence on a load that makes bodies slide without opening; None if no slide is found.

        `forces` (M,) are the reactions to the load if nothing slips any more. Their pressures are
        taken as given, because statics does not know self-stress, such as the pressures of a press
        fit. Slip may change the pressures, so this is a proof only if no state is found by other
        means.
        """
        n = self._system.nodes
        # The motions that do not open the contact.
        motions = self._system.rigid_motions
        sliding = motions @ null_space(motions[-n:], CONDENSATION)
        pressed = np.r_[forces[:-n], self._within_terms(forces[-n:].clip(0.0))]
        phi = self._with_negative_work(sliding, True, pressed)
        return None if phi is None else self._sentence(name, pressed, phi)

    @cached_property
    def _slides(self) -> Array | None:
        """(M, k) slides that strain nothing; None if slip changes pressures."""
        S = self._system.S
        n = self._system.nodes
        size = np.sqrt(np.diag(S).clip(0.0))
        if (np.abs(S[-n:, :-n]) > ROUNDING * np.outer(size[-n:], size[:-n])).any():
            return None
        slides = free_motions(S[:-n, :-n], self._system.own_stiffness[:-n])
        return np.vstack([slides, np.zeros((n, slides.shape[1]))])

    def _within_terms(self, p: Array) -> Array:
        """(N,) normal forces, cut where friction would exceed another term of the law."""
        for bounded, term in self._further_terms:
            friction = np.where(bounded, self._friction, 1.0)
            bound = term.slope * p + term.constant
            p = np.minimum(p, np.where(bounded, bound / friction, np.inf))
        return p

    def _proof(self, motions: Array, pressed: bool, forces: Array) -> Array | None:
        """A motion of negative work, or None; a slide is preferred to a turn."""
        phi = self._with_negative_work(motions, pressed, forces)
        if phi is None:
            return None
        shift = self._with_negative_work(self._shifts(motions), pressed, forces)
        return phi if shift is None else shift

    def _shifts(self, V: Array) -> Array:
        """(M, k) the motions within V in which all nodes that V moves have the same translation."""
        moves = np.abs(V).max(axis=1) > COUNTS
        # Entries of the translations along x, y (and z), (M, d).
        alike = self._system.frames.transpose(1, 0, 2).reshape(len(V), -1) * moves[:, None]
        basis, size, _ = np.linalg.svd(alike, full_matrices=False)
        basis = basis[:, size > CONDENSATION]
        within = V.T @ basis
        _, apart, directions = np.linalg.svd(basis - V @ within, full_matrices=False)
        shifts = V @ (within @ directions[apart <= CONDENSATION].T)
        return np.linalg.qr(shifts)[0]

    def _with_negative_work(self, V: Array, pressed: bool, load: Array) -> Array | None:
        """The motion (M,) within V with the least work; None if this work is not negative.

        If normal forces are known (`pressed`), nodes lift by f |v|: the work of the normal forces
        is then the work of friction.
        """
        if not V.size:
            return None
        n = self._system.nodes
        axes = self._system.tangents
        unit = np.full(n, float(np.abs(load).max()) or 1.0)
        law = self._law
        forces, motions = load, V
        if pressed:
            # Normal forces are known: friction bounds the shear forces by numbers.
            bounds = self._friction * load[-n:]
            law = ContactLaw((BoundTerm("stuck", np.zeros(n), bounds),))
            forces, motions = load[:-n], V[:-n]
        # Imported here, because most transients need no solver.
        from .balance import force_rows, nearest

        rows = force_rows(law, unit, unit, axes)
        with suppress(SolverError):
            found = nearest(rows[1:] if pressed else rows, motions, forces)
            phi = found.motion
            if pressed:
                slip = np.linalg.norm(phi.reshape(-1, n), axis=0)
                phi = np.r_[phi, self._friction * slip]
            rounding = COUNTS * np.abs(phi) @ np.abs(load)
            work_on_motion = phi @ load + self._sheared_off(phi)
            if phi @ phi > _PROVEN_MOTION and work_on_motion < -rounding:
                return phi
        return None

    def _sheared_off(self, phi: Array) -> float:
        """Largest work of shear strengths in a motion with more slip than its lift allows."""
        price = np.full(self._system.nodes, np.inf)
        for bounded, term in self._further_terms:
            share = self._friction / np.where(bounded, self._friction - term.slope, 1.0)
            price = np.where(bounded, np.minimum(price, term.constant * share), price)
        bounded = np.isfinite(price)
        *v, w = phi.reshape(-1, self._system.nodes)[:, bounded]
        extra_slip = np.linalg.norm(v, axis=0) - w / self._friction[bounded]
        return float(extra_slip.clip(0.0) @ price[bounded])

    def _sentence(self, name: str, load: Array, phi: Array) -> str:
        """Sentence about the moving body, its direction, and the forces of load and friction.

        Each force is the work in the motion, divided by the mean slip.
        """
        n = self._system.nodes
        sheared_off = self._sheared_off(phi)
        stretch = joined(self._system.stretch, np.ones(n))
        phi = (phi / stretch).reshape(-1, n)
        load = (load * stretch).reshape(-1, n)
        largest = np.abs(phi).max()
        moves = np.abs(phi).max(axis=0) > COUNTS * largest
        place = "" if moves.all() else f" at {counted(self._system, moves)}"
        mean_slip = float(np.linalg.norm(phi[:-1], axis=0)[moves].mean())
        demand = -float(np.sum(phi[:-1] * load[:-1])) / (mean_slip or 1.0)
        holds = float(phi[-1] @ load[-1] + sheared_off) / (mean_slip or 1.0)
        if mean_slip <= COUNTS * largest or demand <= 0 or holds < -COUNTS * demand:
            return (
                f"the body lifts off or turns over{place}: no pressure with friction up to f p "
                f"balances {name}; hold it, or press it"
            )

        holds = max(holds, 0.0)
        # Mean slip in x, y (and z).
        along = np.einsum("an,nak->nk", phi[:-1], self._system.frames[:, :-1])[moves].mean(axis=0)
        size = float(np.linalg.norm(along))
        held_by = "friction and strength" if self._system.capped else "friction"
        if size <= _EVEN * mean_slip:
            return (
                f"the body turns as a whole{place}: {name} drives it with {demand:.4g} per mean "
                f"slip, above the {holds:.4g} of {held_by}; hold it, or press it"
            )
        bound = f"the {holds:.4g} of {held_by}" if self._system.capped else f"f P = {holds:.4g}"
        # Adding 0.0 turns -0.0 into 0.0.
        direction = ", ".join(f"{part:g}" for part in (along / size).round(6) + 0.0)
        return (
            f"the body slides as a whole{place}: {name} has the shear force {demand:.4g} along "
            f"({direction}), above {bound}; hold it, or press it"
        )


def check_sliding(system: ContactSystem, friction: Array, loads: dict[str, Array]) -> None:
    """Check that contact forces can balance each load.

    `loads` has the bonded reactions (M,) of each load by its name. If contact forces cannot balance
    a load, NoContinuation names the motion that proves this, see `Statics`.
    """
    statics = Statics(system, friction)
    balanced = _BALANCED.setdefault(system, set())
    for name, load in loads.items():
        if _digest(friction, load) in balanced:
            continue
        sentence = statics.sentence(name, load)
        if sentence:
            raise NoContinuation(sentence)
        balanced.add(_digest(friction, load))


def _digest(friction: Array, load: Array) -> bytes:
    return blake2b(friction.tobytes() + load.tobytes(), digest_size=16).digest()


# Sentences about a mean load: its fault and a remedy, or that it has none.
#
# `mean_load_diagnosis` describes the mean load, `unscaled_diagnosis` also the fixed parts of a
# cycle.

SAFE = "the mean load presses all nodes and none slips under it"


def mean_load_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: PerNode) -> str:
    """Sentence about the mean load: its fault and the remedy, or that it has none.

    Faults are: a mean load that is zero, pulls the bodies apart, or makes a body slide, turn or
    lift off as a whole; and nodes that are open, without pressure or beyond their friction bound
    while nothing slips. Sentences are joined by "; ", without a full stop.
    """
    f = friction_coefficients(friction, system)
    glued_q, glued_p = system.reaction(checked_cycle(cycle).mean)
    if not glued_p.any():
        shear = "has no normal reactions" if glued_q.any() else "is zero"
        return (
            f"the mean load {shear}, and nothing presses the bodies together: add a load to "
            "`cycle.mean` that presses them"
        )
    rounding = CONDENSATION * np.abs(glued_p).sum()
    if glued_p.sum() <= rounding:
        pulls = "does not press the bodies together"
        if glued_p.sum() < -rounding:
            pulls = "pulls the bodies apart"
        return (
            f"the mean load {pulls}: its normal reactions sum to {glued_p.sum():.3g}, and "
            "compression must be positive; change the sign of the load, or press the contact; "
            "given normals must point from body 2 into body 1"
        )
    # A body may slide or turn as a whole whichever nodes are open, so this is checked first.
    moved = Statics(system, f).sentence("the mean load", joined(glued_q, glued_p))
    if moved:
        return moved
    q, p = cycle.mean_reaction(system)
    floor = CONDENSATION * float(np.abs(np.r_[glued_q.ravel(), glued_p]).mean())
    if (p < -floor).any():
        return _open_text(system, p, floor)
    return _closed_text(system, f, q, p, floor)


def unscaled_diagnosis(system: ContactSystem, cycle: LoadCycle, friction: PerNode) -> str:
    """The diagnosis of all loads that the load factor does not scale.

    These are the mean load and the `fixed` part of each corner. The diagnosis is for the mean load
    with the first `fixed` part that is not safe if nothing slips.
    """
    if checked_cycle(cycle).fixed is None:
        return mean_load_diagnosis(system, cycle, friction)
    for k, loads in enumerate(cycle.unscaled):
        text = mean_load_diagnosis(system, LoadCycle(loads, cycle.corners), friction)
        if text != SAFE:
            return text.replace("the mean load", f"the mean load with fixed[{k}]")
    return "with each of the fixed parts the mean load presses all nodes and none slips"


def _open_text(system: ContactSystem, p: Array, floor: float) -> str:
    """Text on a mean load that pulls at some nodes of the closed contact."""
    opened = open_nodes(system, p)
    if opened is None:
        nodes = _share(system, p < -floor)
        return f"the mean load would pull at {nodes} if the contact were closed: press it there"
    number = int((opened & (system.gap > 0)).sum())
    gaps = f", {number} of them with an initial gap that the load does not close" if number else ""
    return (
        f"{_share(system, opened)} are open under the mean load alone if no node slips{gaps}: the "
        "contact is incomplete; press these nodes if they should carry load"
    )


def _closed_text(system: ContactSystem, f: Array, q: Array, p: Array, floor: float) -> str:
    """Text on a mean load with which all nodes are closed, if nothing slips."""
    shear = lengths(q, p)
    bare = np.abs(p) <= floor
    smooth = (f == 0) & (shear > floor)
    exceeding = shear > most_shear(system, f, p) + floor
    texts = []
    if bare.any():
        nodes = _share(system, bare)
        texts.append(f"{nodes} carry no pressure under the mean load if nothing slips")
    if smooth.any():
        nodes = _share(system, smooth)
        texts.append(f"{nodes} have no friction and slip under the shear of the mean load")
    if texts:
        return "; ".join(texts)
    if not exceeding.any():
        return SAFE
    bound = "friction bound f p"
    remedy = "more friction"
    if system.capped:
        bound = "bound of friction or strength"
        remedy = "more of the lower one"
    total = np.abs((q * system.stretch).reshape(len(p), -1).sum(axis=0)).max()
    advice = ", or less shear"
    if total <= CONDENSATION * float(shear.sum()):
        advice = "; the resultant shear of the load is zero: the pressing load causes the shear"
    return (
        f"the mean load presses all nodes, but {_share(system, exceeding)} exceed their {bound} "
        f"and slip: {remedy}{advice}"
    )


def _share(system: ContactSystem, which: Booleans) -> str:
    """Number of some nodes, and their contacts or, if there is one contact, their positions."""
    numbers = np.flatnonzero(which)
    if names_of_several(system) is not None:
        return counted(system, np.asarray(which))
    places = []
    # Largest number of ranges of nodes that a sentence names.
    most_ranges = 4
    if system.tangents == 2:
        points = system.points[numbers]
        for name, low, high in zip("xyz", points.min(axis=0), points.max(axis=0), strict=True):
            end = f" .. {high:.4g}" if high > low else ""
            places.append(f"{name} = {low:.4g}{end}")
    else:
        # Nodes that follow each other make one range.
        runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
        for run in runs[:most_ranges]:
            end = f" .. {system.x[run[-1]]:.4g}" if len(run) > 1 else ""
            places.append(f"{system.x[run[0]]:.4g}{end}")
        places[0] = f"x = {places[0]}"
        if len(runs) > most_ranges:
            places.append("...")
    return f"{len(numbers)} of {number_of(system.nodes, 'node')} ({', '.join(places)})"
