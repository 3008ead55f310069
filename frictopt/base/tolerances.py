"""Tolerances, dimensionless: three numbers, and products of them.

The three are those of the arithmetic, of the data, and of the answers. Products that several files
use stand here. Only compiled files (`kernel.py`, `sweeps.py` of `transients`) have copies, as their
machine code does not follow an edit of another file.
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

It is that of a state in the contact law and the balance of energy, or of a limit in its proofs.
"""

# Events this close, relative, count as simultaneous: their times are answers.
SIMULTANEOUS = RESIDUAL

# Error of equilibrium, over the forces, above which a condensation is refused: far above its
# rounding.
EQUILIBRIUM = 1e3 * CONDENSATION

# Two nodes coincide within this share of the size of the body, if the digits of its coordinates are
# not known.
SAME_POINT = 10 * CONDENSATION

# Forces and gaps above this share of the largest ones are no errors of a state: its errors are of
# the size of the residual.
COUNTS = 1e3 * RESIDUAL

# Change of slip over a cycle, over the slip scale, that counts as none: a part of the residual of a
# steady state.
PERIODIC = RESIDUAL / 10

# Change over a cycle below which the limit is reached, whatever the factor by which the changes
# shrink.
REPEATED = ROUNDING / 10

# Change of the bonded reactions, over the force scale, that moves nothing: it changes their last
# digit.
NO_DRIVE = ROUNDING / 1e3

# Eigenvalues of A, each node in units of its stiffness, up to this belong to rigid sliding:
# condensation balances it to rounding.
RIGID = ROUNDING

# B or f B between two nodes up to this share of their own A counts as none.
NO_COUPLING = ROUNDING / 10

# Share of the mean friction bound that counts as none in a slip that grows with the load: its rows
# have this error.
GROWN = 10 * RESIDUAL

# Dimensionless load factors up to this are zero.
ZERO_LOAD_FACTOR = ROUNDING

# Values count relative to themselves above this share of their unit: below it, the error of the
# unit is felt.
FLOOR = 1e6 * RESIDUAL

# Distance, over the largest value, with which a cycle from a steady state comes back to it.
SAME_STATE = 100 * RESIDUAL

# Works of friction that differ by less, relative, are one level: each has errors up to the
# residual, over its slips.
LEVEL = 1e3 * RESIDUAL

# Error of a Newton iteration below which a step that does not help is rounding.
STALLED = 10 * ROUNDING
