"""Searches: for open nodes, for orders of openings and closings, for extreme stresses.

`set_search.py` searches sets of open nodes: `loose_nodes.py` bounds many sets at once, and
`likely_sets.py` has the sets that are tried first. `order_search.py` searches orders.
`stress_levels.py` finds the least and the largest values of fatigue parameters, and the load
factors at which they reach a value.
"""
