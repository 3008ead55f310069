"""A limit between two proven numbers, by products with one matrix.

- `cones.py`: the contact law at all corners as cones of the residual shear. The file has the matrix
  T, which gives the pressures that this shear causes. It turns a state into a slip, and multipliers
  into a mechanism.
- `search.py`: the first-order method that finds rough states and multipliers. From them it proves
  that one load factor is safe and a larger one is not, or finds the least friction with a safe
  slip.
"""
