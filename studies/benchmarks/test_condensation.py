"""Condensation at the paper's size against scipy's sparse factorisation of the same stiffness.

scikit-fem assembles the stiffness.
"""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from studies.validation.error_vs_time.condensation import (
    ORDERINGS,
    assembled,
    multiple_right_hand_sides,
)


@pytest.fixture(scope="module")
def blocks(scene):
    return assembled(scene)


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_assembly_and_condensation_against_one_factorisation(compare, scene, blocks, ordering):
    # A model is condensed once, so that each run has its own, already assembled.
    models = iter([scene.model() for _ in range(10)])

    def ours():
        return next(models).condense()

    assert compare(ours, lambda: splu(blocks[0], **ORDERINGS[ordering]), rounds=5) < 2.0


def test_whole_way_against_one_factorisation(compare, scene, blocks):
    assert (
        compare(scene.condense, lambda: splu(blocks[0], **ORDERINGS["MMD_AT_PLUS_A"]), rounds=5)
        < 4.0
    )


def test_whole_way_against_one_right_hand_side_for_each_unknown(compare, scene, blocks):
    def rival():
        return multiple_right_hand_sides(blocks, "COLAMD")

    S = scene.condense().S
    assert np.abs(rival() - S).max() < 1e-9 * np.abs(S).max()
    assert compare(scene.condense, rival, rounds=3) < 0.5
