"""The sentences of the reasons of limits: each stands here once, with what it assumes.

`docs/claims.py` gives each one its source and its test. `reasons.py` and the files of the questions
choose among them, and fill in values.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Sentence:
    """A sentence with placeholders for values, and the condition under which it is true."""

    text: str
    assumes: str

    def __call__(self, **values: object) -> str:
        """The sentence with its values."""
        return self.text.format(**values)


# Shakedown limits

NOTHING_SAFE = Sentence(
    "no {slip} is safe at any load factor{above}{node_states}: {cause}",
    assumes="the limit is 0, or the rows of the program contradict each other",
)
NO_FRICTION = Sentence(
    "node {node}{contact} has no friction, and the cyclic load shears it",
    assumes="the limit is 0, and this node slips in the mechanism",
)
NO_PRESSURE = Sentence(
    "node {node}{contact} carries no pressure under the mean load, and the cyclic load {moves} it",
    assumes="the limit is 0, and the mechanism contains only this node",
)
INFINITE = Sentence(
    "the shakedown limit is infinite: every load factor{start} has a safe {slip}{cause}{below}",
    assumes="the load factor grows without bound along safe slips",
)
NO_EVENTS = Sentence(
    "; no transient at a small load factor comes to rest with nodes that open and close",
    assumes="the search of events begins with such transients, and nothing is safe without events",
)
CALL_WITH_EVENTS = Sentence(
    "; a state of rest with nodes that open and close may exist: pass events=True",
    assumes="the load returns along its path, so that nodes can open and close in a state of rest",
)
NO_BOUND = Sentence(
    "the search finds no safe {slip} above it{node_states}; fixed and scaled loads both vary where "
    "nodes open or close, so that no bound is proven, and lower load factors may have no safe slip",
    assumes="a product of load factor and place is in the program, which is not convex",
)
HIGHEST = Sentence(
    "no {slip} is safe above it{node_states}{others}{below}",
    assumes="the limit is finite, above 0",
)
BETWEEN = Sentence(
    "the limit is between {lower:.6g} and {upper:.6g} (gap {gap:.2g} %){node_states}: a {slip} is "
    "safe at the lower number, and none is above the upper one; {steps} steps{stopped}",
    assumes="a gap is given; the lower number is proven by its slip, the upper one by its "
    "mechanism",
)
STOPPED_WIDE = Sentence(
    "; stopped with a wider gap than {gap:g}, which was asked: {remedy}",
    assumes="the steps of the method are used up",
)
HIGHER_WITH_OTHERS_OPEN = Sentence(
    "; with other nodes open it may be higher", assumes="some nodes stay open"
)
NOT_HIGHER_WITH_OTHERS_OPEN = Sentence(
    "; with other nodes open all through the cycle it is not higher",
    assumes="branch and bound has compared all sets of nodes that stay open",
)
BOUND_COVERS = Sentence(
    "; the dual bound covers them", assumes="there are user constraints, which are named before"
)
STATIC = Sentence(
    "; under this static load the contact may open nodes and come to rest above the limit, "
    "until a body slides off (bound_for_all)",
    assumes="all corners have the same load, and there are no user constraints",
)
UNSAFE_BELOW = Sentence(
    "; {node_states}no slip is safe below {least:.6g}",
    assumes="the least safe load factor is above 0",
)
START_UNKNOWN = Sentence(
    "; rounding hides the load factor at which safe slips begin: take friction further from its "
    "critical value, or loads of similar size",
    assumes="no solver proved the least safe load factor",
)
CHOSEN = Sentence(
    "no safe residual slip makes the objective larger; the load factor is the load factor of "
    "this slip, not a limit",
    assumes="the user has an objective",
)
CONTRADICTED = Sentence(
    "no residual slip that is safe at any load factor{node_states} obeys {rows}: drop or relax "
    "them",
    assumes="constraints of the user are among the rows that contradict each other",
)
ONLY_SLIP_PRESSES = Sentence(
    "; only residual slip presses node {node}{contact}, which governs the limit",
    assumes="all nodes are closed, and the mean load would pull this one open",
)
BELONGS_TO_MESH = Sentence(
    "; node {node}{contact} governs, next to open nodes, where pressure falls to zero: the limit "
    "depends on the mesh, and falls as elements shrink there",
    assumes="the node is next to open nodes, and its pressure is below the mean",
)

# Contacts whose normal loads alone open and close nodes

MOVES = Sentence(
    "no state of rest exists above it, for all openings and closings: the contact is uncoupled "
    "(B = 0), so that loads alone open and close {nodes} in each cycle{below}",
    assumes="B = 0, the load factor scales shear alone, and the limit is finite, above 0",
)
SLIPS_AT_ANY = Sentence(
    "slip goes on in every cycle at any load factor above 0{starts}: node {node}{contact} "
    "closes and opens under different shear loads, for any friction; "
    "steady_state gives the work of a cycle",
    assumes="B = 0, the load factor scales shear alone, and the equations of the rim have no "
    "solution above 0",
)
SLIPS_BUT_AT_ONE = Sentence(
    "slip goes on in every cycle at any other load factor{starts}: node {node}{contact} closes "
    "and opens under different shear loads; steady_state gives the work of a cycle",
    assumes="B = 0, the load factor scales shear alone, and the equations of the rim have a "
    "solution at one load factor above 0",
)
NO_STATE_OF_REST = Sentence(
    "no state of rest exists at any load factor{above}, for all openings and closings: {cause}",
    assumes="B = 0, the load factor scales shear alone, and no slip is safe in the program",
)
CLOSES_OTHERWISE = Sentence(
    "node {node}{contact} closes and opens under different shear loads",
    assumes="the equations of the rim have no solution at any load factor",
)
TOO_LITTLE_PRESSURE = Sentence(
    "the pressure of node {node}{contact} is too low for any cyclic load",
    assumes="the limit is 0, the equations of the rim have a solution, and this node governs",
)
FROM_EVERY_START = Sentence(", from every start", assumes="supports hold the bodies")
OBSERVED = Sentence(
    "; the bodies slide freely, so it is observed in transients, not proven, that every start "
    "comes to rest below it",
    assumes="nodes open and close in each cycle, and no stiffness resists some slide",
)

# Uncoupled contacts whose normal loads are scaled, too

LAST_REST = Sentence(
    "no state of rest exists just above it, for all openings and closings, because the contact is "
    "uncoupled (B = 0){cause}; `intervals` has all load factors with a state of rest{below}",
    assumes="B = 0, the load factor scales normal loads, fixed loads are the same at all corners, "
    "and the limit ends an interval of load factors with states of rest",
)
IN_THIS_ORDER = Sentence(
    ": the loads open and close {nodes} in each cycle",
    assumes="nodes come and go in the same order below and just above the limit",
)
IN_ANOTHER_ORDER = Sentence(
    ": above it the loads open and close nodes in another order, with which no slip is safe",
    assumes="the order changes at the limit, and the program of the next order proves it",
)
CLOSES_ABOVE = Sentence(
    ": above it node {node}{contact} closes and opens under different shear loads in each cycle",
    assumes="the order changes at the limit, and the equations of the next rim have no solution",
)
LIFTED_OFF = Sentence(
    ": above it the loads lift a body off",
    assumes="the normal problem has no solution above the limit",
)

# Guaranteed limits

CRITICAL = Sentence(
    "node {node}{contact} is {bounds}", assumes="a node is critical below the shakedown limit"
)
BOTH_BOUNDS = Sentence(
    "on its bound of forward slip at the corner {first} and of backward slip at {last}",
    assumes="the contact is in the plane",
)
BOUNDS_IN_SPACE = Sentence(
    "on its bound at the corners {first} and {last}, and from there it can slip {how}",
    assumes="the contact is in space",
)
AT_EVERY_LOAD = Sentence(
    " at every load factor just above {least:.6g}",
    assumes="the limit is the least safe load factor",
)
UNLOADED = Sentence(
    ": a residual slip of up to {size:.3g} can unload it completely under the mean load; then any "
    "cyclic load makes it slip. If assembly and overloads leave less slip, pass a `slip_bound`: "
    "`after_overload()` has the limit with the largest slip that one overload leaves",
    assumes="the limit is 0, and the corners do not differ at load factor 0",
)
WEDGED = Sentence(
    "; friction is above the critical value A/|B| of the node: it may wedge itself, so that "
    "all slip also stops above the limit",
    assumes="one slip may move the node away from all its friction bounds",
)
ONLY_AT_LEAST = Sentence(
    "; {nodes} critical only at the least safe load factor {least:.6g}, which does not cause slip",
    assumes="these nodes are critical at only one load factor",
)
SAME_LIMIT = Sentence(
    "lambda_1 is lambda_2, because {cause}: {reason}", assumes="no node is critical below lambda_2"
)
LIFTING = Sentence(
    "; starts with nodes that open and close in every cycle may slip for ever below it",
    assumes="the contact is coupled, and some node may open or has no friction",
)

# Safe slips

_NODES_AS_THEY_ARE = (
    "the same nodes are closed; with nodes that open and close, the contact may also shake down"
)
_ALWAYS = "none: the slip obeys the contact law at every corner"
SLIP_IS_SAFE = Sentence(
    "this slip{within} keeps {closed} closed and stuck at every corner{opened}",
    assumes=_ALWAYS,
)
SLIP_WITH_EVENTS = Sentence(
    "this slip{within} keeps all nodes stuck while they are closed; nodes that open and close in "
    "each cycle: {count} (events)",
    assumes=_ALWAYS,
)
NO_SLIP_IS_SAFE = Sentence(
    "no residual slip{within} is safe at this load factor{node_states}; shakedown_limit gives the "
    "load factors with a safe slip; without residual slip {mean}",
    assumes=_NODES_AS_THEY_ARE,
)
NOR_WITH_SOME_OPEN = Sentence(
    " with all nodes closed, or with the open nodes that the search finds ({opened}); with other "
    "nodes open a slip may be safe",
    assumes=_NODES_AS_THEY_ARE,
)

_LOADS_DECIDE = (
    "B = 0, all nodes have friction, nodes open and close at this load factor, without slip bound "
    "and constraints of the user"
)
NO_REST_THERE = Sentence(
    "no state of rest exists at this load factor, for all openings and closings: the contact is "
    "uncoupled (B = 0), and {cause}",
    assumes=_LOADS_DECIDE,
)
TOO_LITTLE_FRICTION = Sentence(
    "friction holds no slip at all instants; shakedown_limit gives the load factors with a state "
    "of rest",
    assumes=_LOADS_DECIDE,
)

# Required friction

_NODES_CLOSED = "all nodes are closed; with open nodes, friction may not be needed"
NONE_NEEDED = Sentence(
    "none is needed: a residual slip{within} takes all shear off every node at every corner",
    assumes=_ALWAYS,
)
LESS_IS_NOT_SAFE = Sentence(
    "no residual slip{within} is safe with less, {node_states}: see the mechanism",
    assumes="all nodes are closed, or the counted nodes are open; if nodes open and close in each "
    "cycle, the search has found no state of rest with less friction, which is not proven",
)
REQUIRED_BETWEEN = Sentence(
    "the least friction is between {lower:.6g} and {upper:.6g} (gap {gap:.2g} %) with all nodes "
    "closed: a residual slip is safe with the upper number, and none is with the lower one; "
    "{steps} steps{stopped}",
    assumes="a gap is given; the upper number is proven by its slip, the lower one by its "
    "mechanism",
)
ENOUGH_WITH_EVENTS = Sentence(
    "; with this friction nodes open and close in each cycle; with less friction the search finds "
    "no such state of rest",
    assumes="with `events=True`: `slip` is checked; for less friction, the proof covers only "
    "nodes that stay open or closed",
)
NOT_FROM_EVERY_START = Sentence(
    "; slip need not stop from every start, also with more: limit_after_protocol follows an "
    "assembly",
    assumes="slip changes the pressure of some node",
)
NONE_IS_ENOUGH = Sentence(
    "no friction is enough to keep all nodes closed: {why}",
    assumes=_NODES_CLOSED,
)
NONE_STOPS_IT = Sentence("no friction is enough: {why}", assumes=_LOADS_DECIDE)
LOADS_OPEN = Sentence(
    "under any residual slip{within}, the loads open one of these nodes ({where}) at some "
    "corner: press them",
    assumes=_NODES_CLOSED,
)

# Safe regions

_SAME_NODES = "the same nodes are closed: the closed nodes of the limit under both loads"
SIDES = Sentence(
    "{opened}beyond each side its mechanism slips for ever{node_states}",
    assumes=_SAME_NODES,
)
GAP_OF_SIDES = Sentence(
    "; amplitudes between points and sides, up to {gap:.1e} apart, are undecided",
    assumes=_SAME_NODES,
)
NO_AMPLITUDES = Sentence(
    "no amplitudes are safe: {limit}",
    assumes=_SAME_NODES,
)
NO_AMPLITUDES_ABOVE_ZERO = Sentence(
    "no amplitudes above 0 are safe: {limit}",
    assumes=_SAME_NODES,
)
ALL_AMPLITUDES = Sentence(
    "all amplitudes are safe: {limit}",
    assumes=_SAME_NODES,
)
ONE_UNLIMITED = Sentence(
    "the amplitude of {load!r} has no limit: it shears no node beyond its bound",
    assumes=_SAME_NODES,
)

# Designs

_NODES_OF_DESIGN = "the nodes of `opens` stay open in each scenario, all others closed"
BEST_DESIGN = Sentence(
    "{opened}no design within the constraints is better{node_states}",
    assumes=_NODES_OF_DESIGN,
)
BEST_SAFE_DESIGN = Sentence(
    "{opened}no design within the constraints that is also safe under the mean load is better"
    "{node_states}",
    assumes=_NODES_OF_DESIGN,
)
OTHER_DESIGNS_OPEN = Sentence(
    "; with other nodes open a design may be better",
    assumes=_NODES_OF_DESIGN,
)
NO_OTHER_DESIGNS_OPEN = Sentence(
    ", and none with other nodes open",
    assumes="branch and bound has compared all sets of nodes that stay open",
)

# Gross slip

_RIGID_MOTIONS = (
    "the system has these supports and loads; its stiffness matters only by its rigid motions"
)
_FOUND_NOT_PROVEN = (
    "computed, not proven: from another start, the bodies may slide off at another load factor"
)
HELD = Sentence(
    "supports hold the bodies, so the contact need not prevent any rigid motion",
    assumes="the stiffness has no rigid motion that only the contact prevents",
)
UNBALANCED = Sentence(
    "forces within {bounds} cannot balance {load}: {motion}",
    assumes=_RIGID_MOTIONS,
)
ABOVE = Sentence(
    "above it no state of rest exists, for all slips and openings: {unbalanced}",
    assumes=_RIGID_MOTIONS,
)
BELOW = Sentence(
    "; below {least:.4g} no contact forces balance {load}: {motion}",
    assumes=_RIGID_MOTIONS,
)
NO_STATE = Sentence(
    "no load factor has a state of rest, not even 0: {unbalanced}",
    assumes=_RIGID_MOTIONS,
)
APART = Sentence(
    "no load factor has a state of rest: {lower} needs at least {least:.4g}, "
    "{upper} at most {largest:.4g}",
    assumes=_RIGID_MOTIONS,
)
ALL_BALANCED = Sentence(
    "forces within {bounds} balance the loads at all load factors{start}",
    assumes="forces within friction balance the loads; the contact may or may not reach them",
)
SELF_STRESSED = Sentence(
    "contact forces balance themselves here, so equilibrium does not determine the pressure of "
    "the fit: {statics}",
    assumes=_FOUND_NOT_PROVEN,
)
GOES_ON = Sentence(
    "{unknown}; transients from no slip reach this load",
    assumes=_FOUND_NOT_PROVEN,
)
STOPPED = Sentence(
    "transients from no slip were followed for {seconds:g} s, and {cycles} up to {load_factor:.4g}"
    "{end}; with more `seconds` the load factor may be larger; {unknown}",
    assumes=_FOUND_NOT_PROVEN,
)
SLIDES_OFF_AT_ANY = Sentence(
    "from no slip the transient finds no continuation at any load factor ({why}); {unknown}",
    assumes=_FOUND_NOT_PROVEN,
)
SLIDES_OFF_ABOVE = Sentence(
    "from no slip the transient finds no continuation above {load_factor:.4g} ({why}); {unknown}",
    assumes=_FOUND_NOT_PROVEN,
)

# Fatigue bands

BAND_OF_RESTS = Sentence(
    "over all states of rest{node_states}, the largest {parameter} of the points is at least "
    "{least:.6g}, and reaches {most:.6g}",
    assumes="the stress map belongs to the contact, and nodes stay open or closed",
)
BAND_OF_CYCLES = Sentence(
    "slip changes no pressure (B = 0), so that all steady cycles have the same ranges; over all of "
    "them, the largest {parameter} of the points is at least {least:.6g}, and reaches {most:.6g}",
    assumes="B = 0, supports hold the bodies, and a transient has reached a cycle that repeats",
)
BAND_OF_FAMILY = Sentence(
    "over the steady cycles with the slips and ranges of that of the initial slip, the largest "
    "{parameter} of the points is at least {least:.6g}, and reaches {most:.6g}; other steady "
    "cycles may have more",
    assumes="a transient has reached a cycle that repeats; found, not proven for other cycles",
)
WEDGES = Sentence(
    "; friction wedges, so that slips may press the contact without end; give a slip_bound",
    assumes="a slip that no load resists adds pressure",
)
GROWS_WITH_MESH = Sentence(
    "; the points are on the face, where the larger value grows with each refinement of the mesh",
    assumes="the points are on the face, and slips are bounded by friction alone",
)
OTHER_STARTS = Sentence(
    "; above the guaranteed limit, transients from some starts may never rest, and their values "
    "may be larger",
    assumes="the answer is about states of rest",
)
ALLOWED = Sentence(
    "up to load factor {load_factor:.6g}, {some} state of rest{node_states} has at most "
    "{allowable:.6g} as the largest {parameter} of the points",
    assumes="the stress map belongs to the contact, and nodes stay open or closed",
)
NOT_ALLOWED = Sentence(
    "under the mean load alone, {some} state of rest{node_states} has more than {allowable:.6g} as "
    "the largest {parameter} of the points",
    assumes="the stress map belongs to the contact, and nodes stay open or closed",
)
RESTS_END = Sentence(
    "; above this load factor there is no state of rest",
    assumes="nodes stay open or closed",
)
