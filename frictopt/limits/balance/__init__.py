"""The balance of the bodies, for gross slip and for single faces.

`corner_statics.py` has the program of one corner, `self_stress.py` the load at which transients
slide off, `body_motions.py` the motions of bodies in words, and `face_statics.py` the load factor
at which one face slides in full.
"""
