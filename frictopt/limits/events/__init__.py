"""Nodes that open and close in each cycle.

`lift_off.py` has the question of a given order of openings and closings, and `ordered.py` its
program and solution. `search/order_search.py` finds orders.
"""
