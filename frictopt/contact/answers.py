"""What kinds of answers there are: of a limit, and of a steady state."""

from enum import Enum


class LimitKind(Enum):
    """What kind of answer a limit is.

    Examples
    --------
    >>> import frictopt as fo
    >>> print(fo.LimitKind.UNBOUNDED.value)
    there is no largest safe load factor: check that the corners of the cycle load the contact as they should
    """

    FINITE = "the limit is finite: stay below it, and not below the least safe load factor where that is above 0"
    UNBOUNDED = "there is no largest safe load factor: check that the corners of the cycle load the contact as they should"
    NO_SAFE_SLIP = "no load factor has a safe residual slip: change the mean load, the friction or the slip bound, see the reason"

    def __repr__(self) -> str:
        return str(self)


class Outcome(Enum):
    """The long-run behaviour of a contact.

    Examples
    --------
    >>> import frictopt as fo
    >>> print(fo.Outcome.SHAKEDOWN.value)
    the contact stops slipping: its residual slip keeps every later cycle without dissipation
    """

    SHAKEDOWN = "the contact stops slipping: its residual slip keeps every later cycle without dissipation"
    CYCLIC_SLIP = "the contact slips back and forth for ever, the same in every cycle"
    RATCHETING = "the contact slips for ever and its slip drifts by the same amount in every cycle"
