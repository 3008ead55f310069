"""Meshes made with gmsh, for the tests."""

from contextlib import contextmanager

import pytest


@contextmanager
def gmsh_with(**options):
    gmsh = pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
    gmsh.initialize(interruptible=False)
    try:
        for name, value in {"General.Terminal": 0, **options}.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    finally:
        gmsh.finalize()
