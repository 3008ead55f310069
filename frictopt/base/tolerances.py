"""Three numbers that every tolerance of the package is a product of, dimensionless: for the arithmetic, for the data, and for the answers.

Products that several files use stand here. Only compiled files (`kernel.py`, `sweeps.py` of
`transients`) have copies, as their machine code does not follow an edit of another file.
"""

ROUNDING = 1e-12
"""Rounding of the arithmetic: a sum of some hundred terms of size one, in double precision, is right to about this much."""

CONDENSATION = 1e-10
"""Rounding of the data: the entries of a condensed stiffness are right to this share of the largest one."""

RESIDUAL = 1e-9
"""Largest residual of an answer: of a state in the contact law and the balance of energy, of a limit in its two proofs."""

SIMULTANEOUS = (
    RESIDUAL  # events this close, relative, count as simultaneous: their times are answers
)
EQUILIBRIUM = (
    1e3 * CONDENSATION
    # error of equilibrium, over the forces, above which a condensation is refused: far above its
    # rounding
)
SAME_POINT = (
    10 * CONDENSATION
    # two nodes coincide within this share of the body's size, if the digits of its coordinates are not
    # known
)
COUNTS = (
    1e3 * RESIDUAL
    # forces and gaps above this share of the largest ones are no errors of a state: those are of the
    # size of the residual
)
PERIODIC = (
    RESIDUAL / 10
    # change of slip over a cycle, over the slip scale, that counts as none: a part of the residual of a
    # steady state
)
REPEATED = (
    ROUNDING / 10
    # change over a cycle from which on the limit is reached, whatever the factor by which the changes
    # shrink
)
NO_DRIVE = (
    ROUNDING / 1e3
    # change of the bonded reactions, over the force scale, that moves nothing: it changes their last
    # digit
)
# eigenvalues of A, each node in units of its stiffness, up to this belong to rigid sliding;
# condensation balances it to rounding
RIGID = ROUNDING
NO_COUPLING = (
    ROUNDING / 10
)  # B or f B between two nodes up to this share of their own A counts as none
GROWN = (
    10 * RESIDUAL
    # share of the mean friction bound that counts as none in a slip that grows with the load: its rows
    # have this error
)
ZERO_LOAD_FACTOR = ROUNDING  # dimensionless load factors up to this are zero
FLOOR = (
    1e6 * RESIDUAL
    # values count relative to themselves from this share of their unit on: below it, the error of the
    # unit is felt
)
SAME_STATE = (
    100 * RESIDUAL
)  # distance, over the largest value, with which a cycle from a steady state comes back to it
LEVEL = (
    1e3 * RESIDUAL
    # works of friction that differ by less, relative, are one level: each has errors up to the
    # residual, over its slips
)
STALLED = 10 * ROUNDING  # errors from which on a Newton step that does not help is rounding
