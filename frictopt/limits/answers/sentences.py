"""The sentences of the reasons of limits. Each stands here once, with its assumption below it.

`docs/claims.py` gives each one its source and its test. `reasons.py` and the files of the questions
choose among them, and fill in values.
"""

# Shakedown limits

NOTHING_SAFE = "no {slip} is safe at any load factor{above}{node_states}: {cause}"
"""Assumption: the limit is 0, or the rows of the program contradict each other."""
NO_FRICTION = "node {node}{contact} has no friction, and the cyclic load shears it"
"""Assumption: the limit is 0, and this node slips in the mechanism."""
NO_PRESSURE = (
    "node {node}{contact} carries no pressure under the mean load, and the cyclic load {moves} it"
)
"""Assumption: the limit is 0, and the mechanism contains only this node."""
INFINITE = (
    "the shakedown limit is infinite: every load factor{start} has a safe {slip}{cause}{below}"
)
"""Assumption: the load factor grows without bound along safe slips."""
NO_EVENTS = "; no transient at a small load factor comes to rest with nodes that open and close"
"""Assumption: without events no slip is safe, and the search of events begins with transients at
small load factors.
"""
CALL_WITH_EVENTS = "; a state of rest with nodes that open and close may exist: pass events=True"
"""Assumption: the load returns along its path, so nodes can open and close in a state of rest."""
NO_BOUND = (
    "the search finds no safe {slip} above it{node_states}; fixed and scaled loads both vary where "
    "nodes open or close, so that no bound is proven, and lower load factors may have no safe slip"
)
"""Assumption: the program contains a product of the load factor and the place of an event, and is
not convex.
"""
HIGHEST = "no {slip} is safe above it{node_states}{others}{below}"
"""Assumption: the limit is finite, above 0."""
BETWEEN = (
    "the limit is between {lower:.6g} and {upper:.6g} (gap {gap:.2g} %){node_states}: a {slip} is "
    "safe at the lower number, and none is above the upper one; {steps} steps{stopped}"
)
"""Assumption: a gap is passed; a slip proves the lower number, and a mechanism the upper one."""
STOPPED_WIDE = "; stopped with a wider gap than {gap:g}, which was asked: {remedy}"
"""Assumption: if the method stopped, its steps are used up."""
HIGHER_WITH_OTHERS_OPEN = "; with other nodes open it may be higher"
"""Assumption: some nodes stay open."""
NOT_HIGHER_WITH_OTHERS_OPEN = "; with other nodes open all through the cycle it is not higher"
"""Assumption: branch and bound has compared all sets of nodes that stay open."""
BOUND_COVERS = "; the dual bound covers them"
"""Assumption: "them" are user constraints, which the reason names."""
STATIC = (
    "; under this static load the contact may open nodes and so come to rest above the limit, at "
    "most up to the load factor at which a body slides off (bound_for_all)"
)
"""Assumption: all corners have the same load, and there are no user constraints."""
UNSAFE_BELOW = "; {node_states}no slip is safe below {least:.6g}"
"""Assumption: the least safe load factor is above 0."""
START_UNKNOWN = (
    "; rounding hides the load factor at which safe slips begin: take friction further from its "
    "critical value, or loads of similar size"
)
"""Assumption: no solver proved the least safe load factor."""
CHOSEN = (
    "no safe residual slip makes the objective larger; the load factor is the load factor of "
    "this slip, not a limit"
)
"""Assumption: the user passes an objective."""
CONTRADICTED = (
    "no residual slip that is safe at any load factor{node_states} obeys {rows}: drop or relax them"
)
"""Assumption: user constraints are among the rows that contradict each other."""
ONLY_SLIP_PRESSES = "; only residual slip presses node {node}{contact}, which governs the limit"
"""Assumption: all nodes are closed, and without slip the mean load would open this node."""
BELONGS_TO_MESH = (
    "; node {node}{contact} governs, next to open nodes, where pressure falls to zero: the limit "
    "depends on the mesh, and falls as elements shrink there"
)
"""Assumption: the node is next to open nodes, and its pressure is below the mean."""

# Contacts whose normal loads alone open and close nodes

MOVES = (
    "no state of rest exists above it, for all openings and closings: the contact is uncoupled "
    "(B = 0), so that loads alone open and close {nodes} in each cycle{below}"
)
"""Assumption: B = 0, the load factor scales shear alone, and the limit is finite, above 0."""
SLIPS_AT_ANY = (
    "slip goes on in every cycle at any load factor above 0{starts}: node {node}{contact} "
    "closes and opens under different shear loads, for any friction; "
    "steady_state gives the work of a cycle"
)
"""Assumption: B = 0, the load factor scales shear alone, and the equations of the rim have no
solution above 0.
"""
SLIPS_BUT_AT_ONE = (
    "slip goes on in every cycle at any other load factor{starts}: node {node}{contact} closes "
    "and opens under different shear loads; steady_state gives the work of a cycle"
)
"""Assumption: B = 0, the load factor scales shear alone, and the equations of the rim have a
solution at one load factor above 0.
"""
NO_STATE_OF_REST = (
    "no state of rest exists at any load factor{above}, for all openings and closings: {cause}"
)
"""Assumption: B = 0, the load factor scales shear alone, and no slip is safe in the program."""
CLOSES_OTHERWISE = "node {node}{contact} closes and opens under different shear loads"
"""Assumption: the equations of the rim have no solution at any load factor."""
TOO_LITTLE_PRESSURE = "the pressure of node {node}{contact} is too low for any cyclic load"
"""Assumption: the limit is 0, the equations of the rim have a solution, and this node governs."""
FROM_EVERY_START = ", from every start"
"""Assumption: supports hold the bodies."""
OBSERVED = (
    "; the bodies slide freely, so it is observed in transients, not proven, that every start "
    "comes to rest below it"
)
"""Assumption: nodes open and close in each cycle, and no stiffness resists some slide."""

# Uncoupled contacts whose normal loads are scaled, too

LAST_REST = (
    "no state of rest exists just above it, for all openings and closings, because the contact is "
    "uncoupled (B = 0){cause}; `intervals` has all load factors with a state of rest{below}"
)
"""Assumption: B = 0, the load factor scales normal loads, fixed loads are the same at all corners,
and the limit ends an interval of load factors with states of rest.
"""
IN_THIS_ORDER = ": the loads open and close {nodes} in each cycle"
"""Assumption: nodes come and go in the same order below and just above the limit."""
IN_ANOTHER_ORDER = (
    ": above it the loads open and close nodes in another order, with which no slip is safe"
)
"""Assumption: the order changes at the limit, and the program of the next order proves it."""
CLOSES_ABOVE = (
    ": above it node {node}{contact} closes and opens under different shear loads in each cycle"
)
"""Assumption: the order changes at the limit, and the equations of the next rim have no solution.
"""
LIFTED_OFF = ": above it the loads lift a body off"
"""Assumption: the normal problem has no solution above the limit."""

# Guaranteed limits

CRITICAL = "node {node}{contact} is {bounds}"
"""Assumption: a node is critical below the shakedown limit."""
BOTH_BOUNDS = "on its bound of forward slip at the corner {first} and of backward slip at {last}"
"""Assumption: the contact is in the plane."""
BOUNDS_IN_SPACE = "on its bound at the corners {first} and {last}, and from there it can slip {how}"
"""Assumption: the contact is in space."""
AT_EVERY_LOAD = " at every load factor just above {least:.6g}"
"""Assumption: the limit is the least safe load factor."""
UNLOADED = (
    ": a residual slip of up to {size:.3g} can unload it completely under the mean load; then any "
    "cyclic load makes it slip. If assembly and overloads leave less slip, pass a `slip_bound`: "
    "`after_overload()` has the limit with the largest slip that one overload leaves"
)
"""Assumption: the limit is 0, and the corners do not differ at load factor 0."""
WEDGED = (
    "; friction is above the critical value A/|B| of the node: it may wedge itself, so that "
    "all slip also stops above the limit"
)
"""Assumption: one slip may move the node away from all its friction bounds."""
ONLY_AT_LEAST = (
    "; {nodes} critical only at the least safe load factor {least:.6g}, which does not cause slip"
)
"""Assumption: these nodes are critical at no load factor above the least safe one."""
SAME_LIMIT = "lambda_1 is lambda_2, because {cause}: {reason}"
"""Assumption: no node is critical below lambda_2."""
LIFTING = "; starts with nodes that open and close in every cycle may slip for ever below it"
"""Assumption: the contact is coupled, and some node may open or has no friction."""

# Safe slips

SLIP_IS_SAFE = "this slip{within} keeps {closed} closed and stuck at every corner{opened}"
"""Assumption: none: the slip obeys the contact law at every corner."""
SLIP_WITH_EVENTS = (
    "this slip{within} keeps all nodes stuck while they are closed; nodes that open and close in "
    "each cycle: {count} (events)"
)
"""Assumption: none: the slip obeys the contact law at every corner."""
NO_SLIP_IS_SAFE = (
    "no residual slip{within} is safe at this load factor{node_states}; shakedown_limit gives the "
    "load factors with a safe slip; without residual slip {mean}"
)
"""Assumption: the same nodes are closed at all corners; if nodes open and close, the contact may
shake down.
"""
NOR_WITH_SOME_OPEN = (
    " with all nodes closed, or with the open nodes that the search finds ({opened}); with other "
    "nodes open a slip may be safe"
)
"""Assumption: the same nodes are closed at all corners; if nodes open and close, the contact may
shake down.
"""

NO_REST_THERE = (
    "no state of rest exists at this load factor, for all openings and closings: the contact is "
    "uncoupled (B = 0), and {cause}"
)
"""Assumption: B = 0, all nodes have friction, and nodes open and close at this load factor; there
is no slip bound and no user constraint.
"""
TOO_LITTLE_FRICTION = (
    "friction holds no slip at all instants; shakedown_limit gives the load factors with a state "
    "of rest"
)
"""Assumption: B = 0, all nodes have friction, and nodes open and close at this load factor; there
is no slip bound and no user constraint.
"""

# Required friction

NONE_NEEDED = (
    "none is needed: a residual slip{within} takes all shear off every node at every corner"
)
"""Assumption: none: the slip obeys the contact law at every corner."""
LESS_IS_NOT_SAFE = "no residual slip{within} is safe with less, {node_states}: see the mechanism"
"""Assumption: all nodes are closed, or only the nodes that the sentence counts are open; if nodes
open and close in each cycle, the search has found no state of rest with less friction, but it is
not proven that none exists.
"""
REQUIRED_BETWEEN = (
    "the least friction is between {lower:.6g} and {upper:.6g} (gap {gap:.2g} %) with all nodes "
    "closed: a residual slip is safe with the upper number, and none is with the lower one; "
    "{steps} steps{stopped}"
)
"""Assumption: a gap is passed; a slip proves the upper number, and a mechanism the lower one."""
ENOUGH_WITH_EVENTS = (
    "; with this friction nodes open and close in each cycle; with less friction the search finds "
    "no such state of rest"
)
"""Assumption: with `events=True`: `slip` is checked; for less friction, the proof covers only nodes
that stay open or closed.
"""
NOT_FROM_EVERY_START = (
    "; slip need not stop from every start, also with more: limit_after_protocol follows an "
    "assembly"
)
"""Assumption: slip changes the pressure of some node."""
NONE_IS_ENOUGH = "no friction is enough to keep all nodes closed: {why}"
"""Assumption: all nodes are closed; with open nodes, some friction may be enough."""
NONE_STOPS_IT = "no friction is enough: {why}"
"""Assumption: B = 0, all nodes have friction, and nodes open and close at this load factor; there
is no slip bound and no user constraint.
"""
LOADS_OPEN = (
    "under any residual slip{within}, the loads open one of these nodes ({where}) at some "
    "corner: press them"
)
"""Assumption: all nodes are closed; with open nodes, some friction may be enough."""

# Safe regions

SIDES = "{opened}beyond each side its mechanism slips for ever{node_states}"
"""Assumption: the same nodes are closed as at the limit under both loads."""
GAP_OF_SIDES = "; amplitudes between points and sides, up to {gap:.1e} apart, are undecided"
"""Assumption: the same nodes are closed as at the limit under both loads."""
NO_AMPLITUDES = "no amplitudes are safe: {limit}"
"""Assumption: the same nodes are closed as at the limit under both loads."""
NO_AMPLITUDES_ABOVE_ZERO = "no amplitudes above 0 are safe: {limit}"
"""Assumption: the same nodes are closed as at the limit under both loads."""
ALL_AMPLITUDES = "all amplitudes are safe: {limit}"
"""Assumption: the same nodes are closed as at the limit under both loads."""
ONE_UNLIMITED = "the amplitude of {load!r} has no limit: it shears no node beyond its bound"
"""Assumption: the same nodes are closed as at the limit under both loads."""

# Designs

BEST_DESIGN = "{opened}no design within the constraints is better{node_states}"
"""Assumption: in each scenario the nodes of `opens` stay open, and all others stay closed."""
BEST_SAFE_DESIGN = (
    "{opened}no design within the constraints that is also safe under the mean load is better"
    "{node_states}"
)
"""Assumption: in each scenario the nodes of `opens` stay open, and all others stay closed."""
OTHER_DESIGNS_OPEN = "; with other nodes open a design may be better"
"""Assumption: in each scenario the nodes of `opens` stay open, and all others stay closed."""
NO_OTHER_DESIGNS_OPEN = ", and none with other nodes open"
"""Assumption: branch and bound has compared all sets of nodes that stay open."""

# Gross slip

HELD = "supports hold the bodies, so the contact need not prevent any rigid motion"
"""Assumption: the stiffness has no rigid motion that only the contact prevents."""
UNBALANCED = "forces within {bounds} cannot balance {load}: {motion}"
"""Assumption: the system has these supports and loads. Of its stiffness, only the rigid motions
matter.
"""
ABOVE = "above it no state of rest exists, for all slips and openings: {unbalanced}"
"""Assumption: the system has these supports and loads. Of its stiffness, only the rigid motions
matter.
"""
BELOW = "; below {least:.4g} no contact forces balance {load}: {motion}"
"""Assumption: the system has these supports and loads. Of its stiffness, only the rigid motions
matter.
"""
NO_STATE = "no load factor has a state of rest, not even 0: {unbalanced}"
"""Assumption: the system has these supports and loads. Of its stiffness, only the rigid motions
matter.
"""
APART = (
    "no load factor has a state of rest: {lower} needs at least {least:.4g}, "
    "{upper} at most {largest:.4g}"
)
"""Assumption: the system has these supports and loads. Of its stiffness, only the rigid motions
matter.
"""
ALL_BALANCED = "forces within {bounds} balance the loads at all load factors{start}"
"""Assumption: forces within friction balance the loads; the contact need not reach these forces."""
SELF_STRESSED = (
    "contact forces balance themselves here, so equilibrium does not determine the pressure of "
    "the fit: {statics}"
)
"""Assumption: computed, not proven: from another start, the bodies may slide off at another load
factor.
"""
GOES_ON = "{unknown}; transients from no slip reach this load"
"""Assumption: computed, not proven: from another start, the bodies may slide off at another load
factor.
"""
STOPPED = (
    "transients from no slip were followed for {seconds:g} s, and {cycles} up to {load_factor:.4g}"
    "{end}; with more `seconds` the load factor may be larger; {unknown}"
)
"""Assumption: computed, not proven: from another start, the bodies may slide off at another load
factor.
"""
SLIDES_OFF_AT_ANY = (
    "from no slip the transient finds no continuation at any load factor ({why}); {unknown}"
)
"""Assumption: computed, not proven: from another start, the bodies may slide off at another load
factor.
"""
SLIDES_OFF_ABOVE = (
    "from no slip the transient finds no continuation above {load_factor:.4g} ({why}); {unknown}"
)
"""Assumption: computed, not proven: from another start, the bodies may slide off at another load
factor.
"""

# Fatigue bands

BAND_OF_RESTS = (
    "over all states of rest{node_states}, the largest {parameter} of the points is at least "
    "{least:.6g}, and reaches {most:.6g}"
)
"""Assumption: the stress map belongs to the contact, and nodes stay open or closed."""
BAND_OF_CYCLES = (
    "slip changes no pressure (B = 0), so that all steady cycles have the same ranges; over all of "
    "them, the largest {parameter} of the points is at least {least:.6g}, and reaches {most:.6g}"
)
"""Assumption: B = 0, supports hold the bodies, and a transient has reached a cycle that repeats."""
BAND_OF_FAMILY = (
    "over the steady cycles with the slips and ranges of that of the initial slip, the largest "
    "{parameter} of the points is at least {least:.6g}, and reaches {most:.6g}; other steady "
    "cycles may have more"
)
"""Assumption: a transient has reached a cycle that repeats; nothing is proven for other cycles."""
WEDGES = "; friction wedges, so that slips may press the contact without end; give a slip_bound"
"""Assumption: a slip that no load resists adds pressure."""
GROWS_WITH_MESH = (
    "; the points are on the face, where the larger value grows with each refinement of the mesh"
)
"""Assumption: the points are on the face, and slips are bounded by friction alone."""
OTHER_STARTS = (
    "; above the guaranteed limit, transients from some starts may never rest, and their values "
    "may be larger"
)
"""Assumption: the answer is about states of rest."""
ALLOWED = (
    "up to load factor {load_factor:.6g}, {some} state of rest{node_states} has at most "
    "{allowable:.6g} as the largest {parameter} of the points"
)
"""Assumption: the stress map belongs to the contact, and nodes stay open or closed."""
NOT_ALLOWED = (
    "under the mean load alone, {some} state of rest{node_states} has more than {allowable:.6g} as "
    "the largest {parameter} of the points"
)
"""Assumption: the stress map belongs to the contact, and nodes stay open or closed."""
RESTS_END = "; above this load factor there is no state of rest"
"""Assumption: nodes stay open or closed."""
