"""A limit between two proven numbers, by products with one matrix.

- `cones.py`: the contact law at all corners as cones of the residual shear, and the matrix of the
  pressures that this shear changes.
- `search.py`: the first-order method that finds rough states and multipliers, the largest load
  factor that a state proves to be safe, and the smallest that multipliers prove not to be safe.
- `judged.py`: a state and multipliers as a slip and a mechanism, with the error of each proof.
- `least_friction.py`: the least friction with a safe slip, by the same method.
"""
