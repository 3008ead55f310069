"""A limit between two proven numbers, by products with one matrix.

- `cones.py`: the contact law at all corners as cones of the residual shear, the matrix of the
  pressures that this shear changes, and a state and multipliers as a slip and a mechanism.
- `search.py`: the first-order method that finds rough states and multipliers, the largest load
  factor that a state proves to be safe, the smallest that multipliers prove not to be safe, and the
  least friction with a safe slip.
"""
