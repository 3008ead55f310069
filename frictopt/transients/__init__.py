"""Transients and steady states: the exact path of the plane, increments of friction in the plane and in space."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
