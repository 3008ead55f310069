"""The reasons of limits: the sentences that fit one answer, with their values."""

from collections.abc import Sequence

import numpy as np

from ...base import GROWN, ROUNDING, Array, LimitKind, number_of, place
from ...contact import ContactProducts, ContactSystem, lengths
from ...contact.diagnosis import in_contact
from ...transients.statics import unscaled_diagnosis
from ..events.lift_off import may_open_and_close, path_of
from ..guarantee.critical_search import NodeClaim
from ..moving.moving_areas import MovingAreas
from ..program.question import Question
from ..program.rest_program import is_held
from ..program.solution import Solved
from .answered import Proven
from .sentences import (
    AT_EVERY_LOAD,
    BELONGS_TO_MESH,
    BOTH_BOUNDS,
    BOUND_COVERS,
    BOUNDS_IN_SPACE,
    CALL_WITH_EVENTS,
    CLOSES_ABOVE,
    CLOSES_OTHERWISE,
    CRITICAL,
    FROM_EVERY_START,
    HIGHER_WITH_OTHERS_OPEN,
    HIGHEST,
    IN_ANOTHER_ORDER,
    IN_THIS_ORDER,
    INFINITE,
    LAST_REST,
    LIFTED_OFF,
    LIFTING,
    MOVES,
    NO_BOUND,
    NO_EVENTS,
    NO_FRICTION,
    NO_PRESSURE,
    NO_REST_THERE,
    NO_SLIP_IS_SAFE,
    NO_STATE_OF_REST,
    NOR_WITH_SOME_OPEN,
    NOT_HIGHER_WITH_OTHERS_OPEN,
    NOTHING_SAFE,
    OBSERVED,
    ONLY_AT_LEAST,
    ONLY_SLIP_PRESSES,
    SAME_LIMIT,
    SLIP_IS_SAFE,
    SLIP_WITH_EVENTS,
    SLIPS_AT_ANY,
    SLIPS_BUT_AT_ONE,
    START_UNKNOWN,
    STATIC,
    TOO_LITTLE_FRICTION,
    TOO_LITTLE_PRESSURE,
    UNLOADED,
    UNSAFE_BELOW,
    WEDGED,
)
from .shakedown_answer import ShakedownAnswer


def nothing_with_events(limit: ShakedownAnswer) -> str:
    """The reason that no load factor is safe, after a search of events."""
    return _nothing_safe(limit) + NO_EVENTS


def shakedown_reason(limit: ShakedownAnswer) -> str:
    """Why a shakedown limit has its value, in words."""
    grows = limit.kind is LimitKind.UNBOUNDED
    if limit._question.moves and not grows and not limit._why:
        return _reason_of_moving(limit)
    if limit._why and not grows:
        reason = limit._why
    elif not limit.load_factor > 0:
        reason = _nothing_safe(limit) + _call_with_events(limit)
    elif grows:
        cause = f"; {limit._why}" if limit._why else ""
        start, below = _start(limit)
        reason = INFINITE.format(start=start, slip=_slip(limit), cause=cause, below=below)
    elif limit._question.both_vary:
        reason = NO_BOUND.format(slip=_slip(limit), node_states=limit._question.node_states)
    else:
        node_states = limit._question.node_states
        _, below = _start(limit)
        reason = HIGHEST.format(
            slip=_slip(limit), node_states=node_states, others=_others(limit), below=below
        )
    return limit._opened + reason + governing_node(limit)


def _reason_of_moving(limit: ShakedownAnswer) -> str:
    """The reason of a limit whose normal loads alone open and close nodes."""
    question = limit._question
    assert isinstance(question, MovingAreas)
    node = question.slipping(1)
    starts = FROM_EVERY_START if is_held(question) else ""
    _, below = _start(limit)
    if limit.kind is LimitKind.NO_SAFE_SLIP:
        slips = question.slipping(0) if node is None else node
        cause = _mean_load(limit)
        if slips is not None:
            cause = CLOSES_OTHERWISE.format(**_at(question, slips))
        return NO_STATE_OF_REST.format(above="", cause=cause)
    if node is not None:
        sentence = SLIPS_BUT_AT_ONE if limit.load_factor > 0 else SLIPS_AT_ANY
        return sentence.format(starts=starts, **_at(question, node))
    if not limit.load_factor > 0:
        weak = limit._ruling
        cause = TOO_LITTLE_PRESSURE.format(**_at(question, weak))
        return NO_STATE_OF_REST.format(above=" above 0", cause=cause)
    return MOVES.format(nodes=_moving(question), below=below)


def reason_of_last_rest(limit: ShakedownAnswer, following: MovingAreas | None, lifted: bool) -> str:
    """The reason of a limit above which another order of openings and closings may follow.

    `following` is the question just above the limit, if the order changes there. `lifted` is
    whether a body lifts off there. The reason is empty if no node opens or closes near the limit.
    """
    question = limit._question
    if limit.kind is not LimitKind.FINITE:
        return ""
    _, below = _start(limit)
    if following is not None:
        node = following.slipping(1)
        node = following.slipping(0) if node is None else node
        cause = IN_ANOTHER_ORDER
        if node is not None:
            cause = CLOSES_ABOVE.format(**_at(question, node))
    elif lifted:
        cause = LIFTED_OFF
    elif isinstance(question, MovingAreas):
        cause = IN_THIS_ORDER.format(nodes=_moving(question))
    else:
        return ""
    return LAST_REST.format(cause=cause, below=below)


def _at(question: Question, node: int) -> dict[str, object]:
    """The values that a sentence about a node needs."""
    return {"node": node, "contact": in_contact(question.system, node)}


def _moving(question: MovingAreas) -> str:
    """The nodes that open and close, by their numbers; only the first and last of many."""
    nodes = np.flatnonzero(question.at_instant.touching.any(axis=0))
    contact = in_contact(question.system, nodes)
    *numbers, last = (str(node) for node in nodes.tolist())
    if not numbers:
        return f"node {last}{contact}"
    # A sentence lists up to six nodes one by one.
    if len(nodes) > 6:
        shown = ", ".join([*numbers[:2], "...", numbers[-1], last])
        return f"{len(nodes)} nodes ({shown})"
    return f"nodes {', '.join(numbers)} and {last}{contact}"


def governing_node(limit: ShakedownAnswer) -> str:
    """A warning about the node that governs a finite limit, or an empty string.

    The warning says that the limit depends on the mesh, or that only residual slip presses the
    node.
    """
    question = limit._question
    # The mechanism of a limit with a gap is rough, and may move nodes that do not govern.
    if limit.kind is not LimitKind.FINITE or limit.gap is not None:
        return ""
    node = limit._ruling
    if question.compliance is not None:
        if _is_at_mesh_border(limit, node):
            return BELONGS_TO_MESH.format(**_at(question, node))
        return ""
    if limit._rated and question.r0[:, -1, node].max() < 0:
        return ONLY_SLIP_PRESSES.format(**_at(question, node))
    return ""


def _is_at_mesh_border(limit: ShakedownAnswer, node: int) -> bool:
    """Whether a closed node is beside open nodes and carries less than the mean pressure.

    At the border of the closed nodes the pressure falls to 0, unless it peaks at an edge.
    """
    system = limit.system
    opened = limit._question.open_nodes
    if opened[node]:
        return False
    distance = np.linalg.norm(system.points - system.points[node], axis=1)
    distance[node] = np.inf
    # Nodes are neighbours within this multiple of the distance to the nearest node.
    neighbours = 1.5
    if distance[opened].min(initial=np.inf) > neighbours * distance.min():
        return False
    width = 1.0 if system.width is None else system.width
    pressure = limit.reactions[1].min(axis=0) / width
    return bool(pressure[node] <= pressure[~opened].mean())


def _slip(limit: ShakedownAnswer) -> str:
    """The kind of slip that the limit covers, in words."""
    slip = f"residual slip{within_bound(limit._question)}"
    if limit.constraints:
        slip += f" that obeys {', '.join(limit.constraints)}"
    return slip


def within_bound(question: Question) -> str:
    """The slip bound of a question, in words."""
    return "" if question.slip_bound is None else " within the slip bound"


def _mean_load(limit: ShakedownAnswer) -> str:
    """Diagnosis of the mean load, in words."""
    question = limit._question
    if isinstance(question.system, ContactProducts):
        # The diagnosis needs the stiffness itself, not only its products.
        return "see the mechanism"
    advice = "" if question.slip_bound is None else "a larger slip_bound may leave one; "
    return advice + unscaled_diagnosis(question.system, question.cycle, question.friction)


def _nothing_safe(limit: ShakedownAnswer) -> str:
    """The reason that no load factor is safe, or no load factor above 0."""
    question = limit._question
    at_zero = limit.kind is LimitKind.FINITE
    return NOTHING_SAFE.format(
        slip=_slip(limit),
        above=" above 0" if at_zero else "",
        node_states=question.node_states,
        cause=(_weak_node(limit) if at_zero else "") or _mean_load(limit),
    )


def _call_with_events(limit: ShakedownAnswer) -> str:
    """The advice to pass `events=True`, if nodes can open and close in a state of rest."""
    question = limit._question
    unknown = limit.constraints or question.slip_bound is not None or question.system.capped
    # In a state of rest with events, too, a node without friction would have to keep its slip.
    if limit.kind is LimitKind.FINITE and _slides_freely(limit):
        return ""
    # In `ContactProducts` no node can open.
    if isinstance(question.system, ContactProducts):
        return ""
    if unknown or not may_open_and_close(question, path_of(question.cycle)):
        return ""
    return CALL_WITH_EVENTS


def _weak_node(limit: ShakedownAnswer) -> str:
    """The sentence on a node that resists no cyclic load, or an empty string."""
    question = limit._question
    node = limit._ruling
    if _slides_freely(limit):
        return NO_FRICTION.format(**_at(question, node))
    sheared = _shears(limit)
    alone = set(limit.mechanism["node"]) == {node}
    if alone and np.abs(question.r0[:, -1, node]).max() <= ROUNDING * question.force:
        return NO_PRESSURE.format(**_at(question, node), moves="shears" if sheared else "lifts")
    return ""


def _shears(limit: ShakedownAnswer) -> bool:
    """Whether the node that governs a limit slips in its mechanism."""
    motion = limit._motion
    size = motion.size[:, limit._ruling].max()
    return bool(size > ROUNDING * np.abs(motion.moves).max())


def _slides_freely(limit: ShakedownAnswer) -> bool:
    """Whether the node that governs a limit has no friction, and slips."""
    return bool(limit._question.friction[limit._ruling] == 0 and _shears(limit))


def _start(limit: ShakedownAnswer) -> tuple[str, str]:
    """Two phrases: from which load factor on slips are safe, and why none is safe below it."""
    least = limit.least
    if np.isnan(least):
        return " from some on", START_UNKNOWN
    if not least > 0:
        return "", ""
    # The sentence of a finite limit already names the open nodes.
    grows = limit.kind is LimitKind.UNBOUNDED
    node_states = f"{limit._question.node_states[1:]} " if grows else ""
    below = UNSAFE_BELOW.format(node_states=node_states, least=least)
    if not limit.constraints:
        below += f": {_mean_load(limit)}"
    return f" from {least:.6g} on", below


def _others(limit: ShakedownAnswer) -> str:
    """Phrases on the states of rest that a finite limit does not cover."""
    others = ""
    if limit.best_of_all:
        others += NOT_HIGHER_WITH_OTHERS_OPEN
    elif limit.open.any() and not limit._ends_rests:
        others += HIGHER_WITH_OTHERS_OPEN
    if limit.constraints:
        others += BOUND_COVERS
    elif limit._question.static and not limit.best_of_all:
        others += STATIC
    return others


def cause_of_growth(solved: Solved) -> str:
    """Why the load may grow without end, from the slip that grows with it."""
    question = solved.question
    friction = question.friction
    # Forces up to this size count as zero.
    rounding = GROWN * question.mean_bound / question.load_unit

    def is_within_friction(q: Array, p: Array) -> bool:
        """Whether all reactions obey the friction bound and press, up to rounding."""
        sticks = (lengths(q, p) <= friction * p + rounding).all()
        return bool(sticks and (p >= -rounding).all())

    if not question.r1.any():
        return "the corners carry no load"
    if is_within_friction(question.q1, question.p1):
        return "at no node does the cyclic shear exceed f p, so the residual slip stays bounded"
    locking = ""
    slip = solved.values["slip"] / solved.values["load_factor"]
    if is_within_friction(*question.reactions_of_slip(slip)):
        locking = (
            f" and wedges the contact tighter (self-locking with f = {float(friction.max()):g})"
        )
    return (
        f"a slip that grows with the load keeps every node within its friction bound{locking}; "
        "if assembly cannot leave a slip of this size, pass slip_bound"
    )


def guaranteed_reason(
    shakedown: ShakedownAnswer, best: NodeClaim | None, uncoupled: bool, coincide: int
) -> str:
    """The reason of a guaranteed limit, and a warning about starts that the limit does not cover.

    `best` is the critical node of the limit, if any; `coincide` is the number of nodes that are
    critical only at the least safe load factor.
    """
    if best is not None:
        reason = _critical_node(shakedown, best)
    elif shakedown.kind is not LimitKind.FINITE:
        reason = shakedown_reason(shakedown)
    else:
        cause = "the contact is uncoupled (B = 0)" if uncoupled else "no node is critical below it"
        reason = SAME_LIMIT.format(cause=cause, reason=shakedown_reason(shakedown))
    if coincide:
        nodes = number_of(coincide, "node is", "nodes are")
        reason += ONLY_AT_LEAST.format(nodes=nodes, least=shakedown.least)
    load_factor = shakedown.load_factor if best is None else best.load_factor
    if uncoupled and shakedown._question.moves and not is_held(shakedown._question):
        reason += OBSERVED
    if not uncoupled and _may_lift(shakedown, load_factor):
        reason += LIFTING
    return reason


def _critical_node(shakedown: ShakedownAnswer, best: NodeClaim) -> str:
    """The corners at which the critical node is on its bound, and the consequences."""
    question = shakedown._question
    node = best.state.node
    bounds = _bounds(best, question.cycle.corner_names)
    reason = shakedown._opened + CRITICAL.format(**_at(question, node), bounds=bounds)
    if best.above is not None:
        reason += AT_EVERY_LOAD.format(least=shakedown.least)
    if shakedown.constraints:
        reason += f" (slips obey {', '.join(shakedown.constraints)})"
    if not best.load_factor > 0 and not question.fixed:
        size = np.linalg.norm(best.slip.reshape(len(best.slip), -1), axis=1).max()
        reason += UNLOADED.format(size=float(size))
    if _may_wedge(shakedown, node):
        reason += WEDGED
    return reason


def _bounds(best: NodeClaim, names: Sequence[str]) -> str:
    """The bounds that a critical node reaches, with the loads of the corners."""
    *first, last = (f"({names[corner]})" for corner in best.state.corners)
    if best.slip.ndim == 1:
        return BOTH_BOUNDS.format(first=first[0], last=last)
    how = "around" if len(first) > 1 else "to and fro"
    return BOUNDS_IN_SPACE.format(first=", ".join(first), last=last, how=how)


def _may_wedge(shakedown: ShakedownAnswer, node: int) -> bool:
    """Whether friction exceeds the critical value of a node (in space: may exceed it)."""
    system = shakedown.system
    *along, normal = (axis * system.nodes + node for axis in range(system.tangents + 1))
    coupling = np.linalg.norm(system.S[normal, along])
    softest = np.linalg.eigvalsh(system.S[np.ix_(along, along)])[0]
    return bool(shakedown.friction[node] * coupling > softest)


def _may_lift(shakedown: ShakedownAnswer, load_factor: float) -> bool:
    """Whether slip may go on below the limit, from starts after which nodes open in every cycle."""
    if not shakedown.least < load_factor < np.inf:
        return False
    if shakedown.open.any() or not shakedown.friction.all():
        return True
    question = shakedown._question
    return bool((question.r0 + load_factor * question.r1)[:, -1].min() < 0)


def safe_slip_reason(safe: Proven, exists: bool) -> str:
    """Effect of a safe slip, or why no slip is safe, in words."""
    question = safe._question
    within = within_bound(question)
    opened = int(safe.open.sum())

    if not exists:
        if isinstance(question, MovingAreas):
            return NO_REST_THERE.format(cause=_cause_of_slip(question, safe.load_factor))
        node_states = NOR_WITH_SOME_OPEN.format(opened=opened) if opened else question.node_states
        mean = unscaled_diagnosis(question.system, question.cycle, question.friction)
        return NO_SLIP_IS_SAFE.format(within=within, node_states=node_states, mean=mean)
    moving = safe.events["node"].nunique()
    if moving:
        return SLIP_WITH_EVENTS.format(within=within, count=moving)
    if opened:
        closed = f"{safe.system.nodes - opened} of {safe.system.nodes} nodes"
        return SLIP_IS_SAFE.format(within=within, closed=closed, opened=", and the others open")
    return SLIP_IS_SAFE.format(within=within, closed="every node", opened="")


def _cause_of_slip(areas: MovingAreas, load_factor: float) -> str:
    """Why no state of rest exists: a node that slips with any friction, or too little friction."""
    node = areas.slipping_at(load_factor)
    if node is None:
        return TOO_LITTLE_FRICTION
    return CLOSES_OTHERWISE.format(**_at(areas, node))


def where(system: ContactSystem, nodes: Array, most_places: int) -> str:
    """The places of some nodes, in words; only the first ones if there are many."""
    if system.tangents == 1:
        start = "x ="
        places = [f"{x:.4g}" for x in system.x[nodes]]
    else:
        start = "at"
        places = [place(point) for point in system.points[nodes]]
    if len(places) > most_places:
        places = [*places[:most_places], "..."]
    return f"{start} {', '.join(places)}"
