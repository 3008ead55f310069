"""Uncoupled contacts whose normal loads open and close nodes.

`moving_areas.py` has the question, `normal_path.py` the path of pressures under given loads, and
`path_pieces.py` this path as a function of the load factor, with the shear of the nodes that come
and go. `rest_intervals.py`, on the floor of the questions, has the limits.
"""
