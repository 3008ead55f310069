"""The study of Poisson's ratio at quick size, and the jump of the guaranteed limit on tables made by hand."""

import pandas as pd
import pytest

from studies import validity


def mesh(*limits):
    return pd.DataFrame({"friction": [0.1 * k for k in range(len(limits))], "guaranteed": limits}).sample(frac=1, random_state=1)


def test_the_jump_is_the_rise_above_all_before():
    assert validity.jump(mesh(0.4, 0.5, 0.1, 0.0, 2.0, 2.2)) == pytest.approx((0.3, 0.4))
    assert validity.jump(mesh(0.0, 0.0, 0.2)) == pytest.approx((0.1, 0.2))
    assert validity.jump(mesh(0.4, 0.5, 0.1, 0.5, 0.7)) is None  # rises most from 0.1 to 0.5, and not above what was there before
