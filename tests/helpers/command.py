"""The command `frictopt`, run in this process."""

from frictopt.__main__ import main

__all__ = ["main"]
