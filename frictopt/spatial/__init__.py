"""Contacts in three dimensions: the system, and the functions that answer the public questions about it."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
