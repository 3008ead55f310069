"""The one place that solves cvxpy problems: solvers in order, polish, record, and printing a model by its names."""

from .solvers import LP_SOLVERS

__all__ = ["LP_SOLVERS"]
