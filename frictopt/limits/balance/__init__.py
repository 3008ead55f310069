"""Parts of gross slip: the balance of the bodies.

`corner_statics.py` has the program of one corner, `self_stress.py` the load at which transients
slide off, and `body_motions.py` the motions of bodies in words.
"""
