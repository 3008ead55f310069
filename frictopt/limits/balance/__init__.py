"""The balance of the bodies, for gross slip and for single faces.

`statics.py` has the programs of one corner and of one face, and the motions of bodies in words.
`self_stress.py` has the load at which transients slide off.
"""
