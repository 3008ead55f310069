"""Finite-element models of a contact, condensed to its interface.

In come meshes of scikit-fem or matrices of any code; out goes a `ContactSystem`. `model.py` has
`ContactModel`, made of bodies (`bodies.py`, `elasticity.py`), contacts (`contacts.py`, `faces.py`,
`interface.py`), supports, loads, bolts and sectors (a file each); `assembly.py` assembles it,
`condense.py` and `schur.py` condense it. `recovery.py` gives stresses back, `modes.py` modes.
`pictures.py` and `views.py` draw, `paraview.py` exports.
"""
