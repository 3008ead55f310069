"""Results that can be copied and sent to other processes."""

from typing import Any

__all__ = ["Portable"]


class Portable:
    """A result with a solved cvxpy `problem`, which cannot be copied or sent: copies leave it behind."""

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "problem": None}
