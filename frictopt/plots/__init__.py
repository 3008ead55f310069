"""Pictures of results, behind their `.plot()`; matplotlib comes with the extra `figures` and is imported with the first picture."""

from .draw import plot_study

__all__ = ["plot_study"]
