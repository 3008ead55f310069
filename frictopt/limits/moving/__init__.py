"""Uncoupled contacts whose normal loads open and close nodes.

`normal_path.py` has the path of pressures and gaps, under given loads and as a function of the load
factor. `moving_areas.py` has the question, with the shear of the nodes that come and go.
`rest_intervals.py`, on the floor of the questions, has the limits.
"""
