"""Searches for the open nodes of the best limit, and for the order in which nodes open and close.

`set_search.py` searches sets of open nodes: `loose_nodes.py` bounds many sets at once, and
`likely_sets.py` has the sets that are tried first. `order_search.py` searches orders.
"""
