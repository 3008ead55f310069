"""Condensation at the paper's size against scipy's sparse factorisation of the same matrix."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from studies.validation.error_vs_time.condensation import ORDERINGS, elimination, multiple_right_hand_sides


@pytest.fixture(scope="module")
def task(scene):
    return elimination(scene)


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_condensation_against_one_factorisation(compare, task, ordering):
    matrix, _, _ = task.blocks
    assert compare(task.ours, lambda: splu(matrix, **ORDERINGS[ordering]), rounds=5) < 1.5


def test_whole_way_against_one_factorisation(compare, scene, task):
    matrix, _, _ = task.blocks
    assert compare(scene.condense, lambda: splu(matrix, **ORDERINGS["MMD_AT_PLUS_A"]), rounds=5) < 4.0


def test_condensation_against_one_right_hand_side_for_each_unknown(compare, task):
    blocks, S = task.blocks, task.ours()

    def rival():
        return multiple_right_hand_sides(blocks, "COLAMD")

    assert np.abs(rival() - S).max() < 1e-9 * np.abs(S).max()
    assert compare(task.ours, rival, rounds=3) < 0.5
