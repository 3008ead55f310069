"""Tolerances, dimensionless: three numbers, and products of them.

The three numbers are the rounding of the arithmetic, the rounding of the data, and the largest
residual of an answer. This file also has the products that several files use. Only compiled files
(`kernel.py`, `sweeps.py` of `transients`) have copies of these numbers, because their machine code
does not follow an edit of another file.
"""

ROUNDING = 1e-12
"""Rounding of the arithmetic.

A sum of some hundred terms of size one, in double precision, is right to about this much.
"""

CONDENSATION = 1e-10
"""Rounding of the data.

The entries of a condensed stiffness are right to this share of the largest one.
"""

RESIDUAL = 1e-9
"""Largest residual of an answer.

The residual of a state is its error in the contact law and in the balance of energy; the residual
of a limit is the error of its proofs.
"""

# Events whose relative distance in time is below this are simultaneous, because computed times have
# the errors of answers.
SIMULTANEOUS = RESIDUAL

# A condensation is refused if its error of equilibrium, relative to the forces, exceeds this
# number. It is far above the rounding of a condensation.
EQUILIBRIUM = 1e3 * CONDENSATION

# Nodes closer to each other than this share of the size of the body coincide, if the digits of its
# coordinates are not known.
SAME_POINT = 10 * CONDENSATION

# Forces and gaps above this share of the largest ones are real: the errors of a state are of the
# size of the residual.
COUNTS = 1e3 * RESIDUAL

# A change of slip in a cycle up to this share of the slip scale is zero. The share is below the
# largest residual, because the change is only a part of the residual of a steady state.
PERIODIC = RESIDUAL / 10

# If the change in a cycle is below this number, the steady state is reached, however slowly the
# changes decrease.
REPEATED = ROUNDING / 10

# A change of the bonded reactions up to this share of the force scale moves no node: it changes
# only their last digit.
NO_DRIVE = ROUNDING / 1e3

# Rounding may resist a free motion by up to this force, relative to the stiffness of the nodes that
# it moves: the numbers of a DMIG have ten digits.
FREE_MOTION = 10 * CONDENSATION

# Entries of B or f B between two nodes count as zero up to this share of the diagonal entries of A
# at these nodes.
NO_COUPLING = ROUNDING / 10

# In a slip that grows with the load, reactions up to this share of the mean friction bound are
# zero, because the rows of its program have this error.
GROWN = 10 * RESIDUAL

# Dimensionless load factors up to this number count as zero.
ZERO_LOAD_FACTOR = ROUNDING

# The error of a value is relative to the value, or to this share of its unit if that is larger.
FLOOR = 1e6 * RESIDUAL

# How far a proof by multipliers reaches, although multipliers have rounding errors: the proof holds
# for unknowns up to this number times their units. If a solution is only rough, the proof also
# holds for unknowns up to this number times the values of the solution.
FAR = 1e-3 / RESIDUAL

# A cycle that starts from a steady state returns to this state up to this share of the largest
# value.
SAME_STATE = 100 * RESIDUAL

# Works of friction with a smaller relative difference are equal: the error of a work is up to the
# residual times the slips.
LEVEL = 1e3 * RESIDUAL

# If the error of a Newton iteration is below this number and no longer decreases, it is rounding.
STALLED = 10 * ROUNDING
