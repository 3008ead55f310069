"""Tables of refused arguments, for the tests."""

from inspect import Parameter, Signature, signature

import pytest

import frictopt as fo


def refused(*rows):
    """Run a test with each row: its first arguments, and the text that the error must contain.

    Further arguments are fixtures.
    """

    def tabled(test):
        names = list(signature(test).parameters)

        def asked(said, **given):
            with pytest.raises(fo.ModelError, match=said):
                test(**given)

        asked.__signature__ = Signature(
            [Parameter(name, Parameter.KEYWORD_ONLY) for name in (*names, "said")]
        )
        asked.__module__, asked.__doc__ = test.__module__, test.__doc__
        return pytest.mark.parametrize([*names[: len(rows[0]) - 1], "said"], rows)(asked)

    return tabled
