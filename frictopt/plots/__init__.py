"""Functions that draw values at nodes, and meshes of bodies. None of them knows a class of results.

- `along.py`: lines, bands and circles over the nodes of contacts in the plane.
- `face.py`: maps of faces in space, with arrows of slips.
- `bodies.py`: meshes of bodies in the plane and in space.
- `style.py`: colours, axes, legends, arrows, and the names of units; `draw` draws a result by the
  picture that is registered for its class.

The `pictures.py` of each folder says in a few lines what is drawn of its results. matplotlib comes
with the extra `figures`.
"""
