"""Histories: what follows from many transients."""

from . import results as results
from . import starts as starts
