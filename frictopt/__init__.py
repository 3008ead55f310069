"""frictopt decides whether a frictional contact will stop slipping.

A finite-element model of two bodies is condensed to its interface (`PunchOnHalfPlane`,
`ContactModel` -> `ContactSystem`); for a load cycle (`LoadCycle`) and a coefficient of friction,
linear programs give the shakedown limit, the guaranteed limit and safe residual slips, and exact
paths give the steady state that a transient reaches.

Contacts, loads and questions stand here, as `__init__.pyi` lists them. The parts of a
finite-element model are in `fem`, the readers of meshes and matrices in `readers`. Each room of the
package is imported when one of its names is first used.
"""

import lazy_loader

__version__ = "0.3.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
