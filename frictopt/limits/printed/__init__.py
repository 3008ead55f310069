"""The problems that users print, solve and extend, as cvxpy expressions.

`models.py` has the problems in the symbols of the paper; `listing.py` is the problem of one answer,
with its values. `user_rows.py` turns rows and objectives of users into rows of the arrays.
`last_resort.py` solves the printed problem by plain cvxpy if no answer of the arrays passes its
checks. Apart from this last resort, only models that users extend need cvxpy, which is slow to
import.
"""
