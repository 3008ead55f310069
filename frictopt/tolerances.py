"""Every tolerance of the package: three primary numbers, one for the arithmetic, one for the data and one for the answers, and products of them.

All are dimensionless. Only the compiled kernel (`path/kernel.py`) has copies, because its machine code does not follow an edit of another file.
"""

ROUNDING = 1e-12
"""Rounding of the arithmetic: a sum of some hundred terms of size one, in double precision, is right to about this much."""

CONDENSATION = 1e-10
"""Rounding of the data: the entries of a condensed stiffness are right to this share of the largest one."""

RESIDUAL = 1e-9
"""Largest residual of an answer: of a state in the contact law and the balance of energy, of a limit in its two proofs."""

# --- contact ---

SIMULTANEOUS = RESIDUAL  # events this close, relative, count as simultaneous: their times are answers

UNIT_LENGTH = 10 * CONDENSATION  # a given normal is of length 1 to this much: it has ten digits or more

# --- fem ---

FREE_MOTION = CONDENSATION  # a rigid motion is free if its forces, over the stiffness of the nodes it moves, are smaller: rounding of the stiffness
SYMMETRY = 10 * CONDENSATION  # asymmetry of a given stiffness, over its largest entry: other codes write ten digits or more
EQUILIBRIUM = 1e3 * CONDENSATION  # error of equilibrium, over the forces, above which a condensation is refused: far above its rounding
SAME_POINT = 10 * CONDENSATION  # two nodes coincide within this share of the body's size: coordinates have ten digits or more

# --- path ---

PERIODIC = RESIDUAL / 10  # change of slip over a cycle, over the slip scale, that counts as none: a part of the residual of a steady state
SAFE = RESIDUAL / 10  # excess over the friction bound, in force scales, of a safe slip: a part of the same residual
RESTART = RESIDUAL / 10  # residual of a state that a path may restart from: the cycle from there adds its own
REPEATED = ROUNDING / 10  # change over a cycle from which on the limit is reached, whatever the factor by which the changes shrink
AFFINE_FIT = 1e3 * RESIDUAL  # deviation of a state from the linear map fitted to all states: the fit divides by small differences
NO_DRIVE = ROUNDING / 1e3  # change of the bonded reactions, over the force scale, that moves nothing: it changes their last digit
DISTINCT = 1e3 * RESIDUAL  # two solutions of a rate problem differ by more: each has errors up to the residual
PIVOT = 10 * ROUNDING  # pivots of Lemke's tableau up to this count as zero: a pivot adds its rounding to that of the entries
