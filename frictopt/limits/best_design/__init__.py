"""The best design: preloads and a profile of the faces with the largest shakedown limit.

`model.py` is the model that users extend, `design.py` its answer and the search of its open nodes.
`program.py` adds the design to the program of a limit.
"""
