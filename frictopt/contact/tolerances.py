"""Every tolerance of the package: three primary numbers, one for the arithmetic, one for the data and one for the answers, and products of them.

All are dimensionless. Only the compiled kernel (`transients/exact/kernel.py`) has copies, because its
machine code does not follow an edit of another file.
"""

ROUNDING = 1e-12
"""Rounding of the arithmetic: a sum of some hundred terms of size one, in double precision, is right to about this much."""

CONDENSATION = 1e-10
"""Rounding of the data: the entries of a condensed stiffness are right to this share of the largest one."""

RESIDUAL = 1e-9
"""Largest residual of an answer: of a state in the contact law and the balance of energy, of a limit in its two proofs."""

# --- contact ---

SIMULTANEOUS = RESIDUAL  # events this close, relative, count as simultaneous: their times are answers

# --- fem ---

FREE_MOTION = CONDENSATION  # a rigid motion is free if its forces, over the stiffness of the nodes it moves, are smaller: rounding of the stiffness
NO_STIFFNESS = ROUNDING / 10  # stiffness of an unknown, over its own, up to which nothing is left of it when others are eliminated
SYMMETRY = 10 * CONDENSATION  # asymmetry of a given stiffness, over its largest entry: other codes write ten digits or more
EQUILIBRIUM = 1e3 * CONDENSATION  # error of equilibrium, over the forces, above which a condensation is refused: far above its rounding
SAME_POINT = 10 * CONDENSATION  # two nodes coincide within this share of the body's size: coordinates have ten digits or more

ASIDE = 1e3 * CONDENSATION  # share of its distance by which the neighbourhood of a node may lie on the wrong side: rounding of the coordinates
COUNTS = 1e3 * RESIDUAL  # forces and gaps above this share of the largest ones are no errors of a state: those are of the size of the residual

PULL = CONDENSATION  # a stiffness between two nodes up to this share of the largest entry of A and B counts as none: the data have this error

# --- path ---

PERIODIC = RESIDUAL / 10  # change of slip over a cycle, over the slip scale, that counts as none: a part of the residual of a steady state
SAFE = RESIDUAL / 10  # excess over the friction bound, in force scales, of a safe slip: a part of the same residual
RESTART = RESIDUAL / 10  # residual of a state that a path may restart from: the cycle from there adds its own
REPEATED = ROUNDING / 10  # change over a cycle from which on the limit is reached, whatever the factor by which the changes shrink
AFFINE_FIT = 1e3 * RESIDUAL  # deviation of a state from the linear map fitted to all states: the fit divides by small differences
NO_DRIVE = ROUNDING / 1e3  # change of the bonded reactions, over the force scale, that moves nothing: it changes their last digit
DISTINCT = 1e3 * RESIDUAL  # two solutions of a rate problem differ by more: each has errors up to the residual
PIVOT = 10 * ROUNDING  # pivots of Lemke's tableau up to this count as zero: a pivot adds its rounding to that of the entries

INSTANT = ROUNDING / 10  # stretches of a segment shorter than this share of it lie between events that happen at once
STAYING = CONDENSATION  # motions that a cycle changes by less than this share stay as they are: the data have this error

# --- symmetry ---

ASYMMETRY = (
    ROUNDING / 10
)  # of stiffness, over that of the two nodes, of friction, gap and slip, over their largest value: a half adds nothing to the error of the whole
ASYMMETRY_OF_LOADS = ROUNDING  # the same of reactions, which do not add up from one increment to the next

# --- solve ---

BINDING = 100 * RESIDUAL  # slack below which a row is printed as binding: solvers leave more than the residual before the polish

# --- limits ---

RIGID = ROUNDING  # eigenvalues of A, each node in units of its stiffness, up to this belong to rigid sliding; condensation balances it to rounding
NO_COUPLING = ROUNDING / 10  # f B between two nodes up to this share of their own A counts as none: the closed form neglects it
NO_MARGIN = ROUNDING  # a margin this little below zero is zero: that of the slip at the shakedown limit
GROWN = (
    10 * RESIDUAL
)  # share of the mean friction bound that counts as none in a slip that grows with the load: its rows have errors up to the residual
ZERO_LOAD_FACTOR = ROUNDING  # dimensionless load factors up to this are zero
TIE = ROUNDING  # corners whose rows differ by less than this share rule together
FLOOR = 1e6 * RESIDUAL  # values count relative to themselves from this share of their unit on: below it, the error of the unit is felt
COINCIDE = 1e3 * RESIDUAL  # dimensionless load factors up to this cannot be told from zero: residuals move them so far
NO_PRESSURE = 1e3 * RESIDUAL  # rows are scaled by the pressure of their node unless it is below this share of the mean one: an answer has its error
SHARE = RESIDUAL  # parts of a mechanism below this share of it are left out of its table: they have the error of the answer
SETTLED = RESIDUAL  # change of a screening mechanism, over its size, that counts as none
SPARE = 1e3 * RESIDUAL  # share by which a screening mechanism slips more than it must, so that it is admissible before it settles
SCREENING = CONDENSATION  # relative rounding of a screening bound, which feels the errors of the data

WEIGHT = ROUNDING  # weights of slip below this share of the stresses that they are sums of are zero

# --- limits with separation ---

NOTHING_LEFT = ROUNDING / 10  # eigenvalues below this share of the largest entry of S are none once nodes are condensed out
HELD = (
    CONDENSATION  # smallest eigenvalue of the open nodes' stiffness, over the largest, with which they leave no body free: the data have this error
)
ONE_LIMIT = 1e3 * RESIDUAL  # relative distance of limit and bound up to which they are one: mixed-integer programs are solved to a part of it

# --- increments ---

AT_BOUND = RESIDUAL  # distance from a bound, in force scales, up to which a node is on it: the state has this error
LITTLE = (
    100 * RESIDUAL
)  # a node's pressure below this share of the mean one is too little to judge its slip by: its bounds have the error of an answer
NO_FORCE = RESIDUAL  # a mean normal force below this share of the largest reaction is no scale: the error of an answer is as large
NOT_CONVEX = ROUNDING  # negative eigenvalues up to this share of the largest entry are rounding

# --- load histories, required friction, safe regions, fretting ---

ONE_SIDE = 10 * RESIDUAL  # a point this close to a line, over the distance of the line from zero, is on it: both have errors up to the residual
PROVEN_FRICTION = 100 * RESIDUAL  # share between the two friction coefficients of a proof that is tried first
WIDEST_PROOF = 1e4 * RESIDUAL  # and the largest: a small node has a small part of the margin
NO_LEAST_PRESSURE = RESIDUAL  # pressure, over the force scale, that counts as none: it has the error of an answer
SAME_STATE = 100 * RESIDUAL  # distance, over the largest value, with which a cycle from a steady state comes back to it

# --- histories ---

LEVEL = 1e3 * RESIDUAL  # works of friction that differ by less, relative, are one level: each has errors up to the residual, over its slips
WORK_GAIN = 100 * RESIDUAL  # a step that gains less work, relative, is none
PARALLEL = ROUNDING  # directions of unit length that differ by less are one

# --- space ---

ORTHONORMAL = 10 * CONDENSATION  # error of the frames of the pairs up to which they are orthonormal, as for given normals
INSIDE = ROUNDING  # distance of a corner from the hull of the others, over its size, that counts as none
NEWTON = 1e-2 * ROUNDING  # dimensionless errors of the law from which on Newton's method is done
STALLED = 10 * ROUNDING  # errors from which on a Newton step that does not help is rounding
POLISHED = 1e-3 * ROUNDING  # errors of the equations of active cones that no step makes smaller
NOT_UNIQUE = ROUNDING / 10  # singular directions of these equations, over the largest: there the solution stays as it is
CARRIED = ROUNDING / 10  # excess over a circle, in mean normal forces, up to which a slip carries its load factor
BARE = 10 * RESIDUAL  # share of the mean friction bound below which a node carries nothing, and its traction ratio is rounding
SWEEP_OF_CONES = 1e5 * RESIDUAL  # violation with which a cone program of a sweep may end: it only guides the next one
SETTLED_BOUND = 1e4 * RESIDUAL  # change of the frozen bound from which on Newton's method makes the state exact
