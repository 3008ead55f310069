"""Searches for open nodes, for the order in which nodes open and close, and for ends of stresses.

`set_search.py` searches sets of open nodes: `loose_nodes.py` bounds many sets at once, and
`likely_sets.py` has the sets that are tried first. `order_search.py` searches orders.
`stress_levels.py` searches the ends of fatigue parameters, and where they reach a value.
"""
