"""A limit between two proven numbers, by products with one matrix.

- `cones.py`: the contact law at all corners as cones of the residual shear, and the matrix of the
  pressures that this shear changes.
- `bounds.py`: the largest load factor that a rough state proves to be safe, and the smallest that
  rough multipliers prove not to be safe.
- `search.py`: the first-order method that finds such states and multipliers.
- `judged.py`: a state and multipliers as a solution of the exact program, which judges them.
"""
