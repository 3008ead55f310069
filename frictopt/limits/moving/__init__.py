"""Uncoupled contacts whose normal loads open and close nodes.

`normal_path.py` has the path of pressures and gaps: under given loads, and as a function of the
load factor. `moving_areas.py` has the question, with the shear forces of the nodes that open and
close. `limits/rest_intervals.py` has the limits.
"""
