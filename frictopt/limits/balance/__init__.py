"""The balance of whole bodies (gross slip), and of single faces.

`statics.py` has the programs of one corner and of one face, and describes motions of bodies in
words. `self_stress.py` has the load at which transients slide off.
"""
