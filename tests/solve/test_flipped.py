"""The dual of programs of balances.

Its answers are the answers of the program, by solvers that take the program without this step.
"""

import numpy as np
import pytest
from scipy.sparse import csr_array

from frictopt.solve.arrays import Arrays, polish
from frictopt.solve.flipped import flipped
from frictopt.solve.solvers import run
from helpers.cases import few


def balance(rng, nodes, equations, free=1, extra=2):
    """A program with a solution.

    It has cones of own unknowns, some moved by a load >= 0, more cones, unknowns without a cone,
    and equations.
    """
    width = 3 * nodes + 1 + free
    load, heads = 3 * nodes, 3 * np.arange(nodes)
    cones = np.zeros((3 * nodes, width))
    cones[np.arange(3 * nodes), np.arange(3 * nodes)] = rng.uniform(
        0.3, 2.0, 3 * nodes
    ) * rng.choice([-1, 1], 3 * nodes)
    cones[::6, load] = rng.normal(size=len(heads[::2]))
    sign = -np.eye(1, width, load)
    more, ties = rng.normal(size=(3 * extra, width)), rng.normal(size=(equations, width))
    inside = np.zeros(3 * nodes + 3 * extra)
    for head in range(0, len(inside), 3):
        tail = rng.normal(size=2)
        inside[head : head + 3] = np.r_[np.linalg.norm(tail) * rng.choice([1.0, 1.5]), tail]
    x = rng.normal(size=width)
    x[load] = rng.uniform(0.5, 1.0)
    rows = np.vstack([ties, sign, cones, more])
    slack = np.r_[np.zeros(equations), x[load], inside]
    sizes = np.r_[1, np.full(nodes + extra, 3)]
    program = Arrays(
        csr_array(rows), np.zeros((0, width)), rows @ x + slack, np.zeros(width), equations, sizes
    )
    multipliers = program.admissible(rng.normal(size=len(rows)))
    multipliers[program.cones[-1][:, 0]] += 0.3
    return Arrays(
        program.sparse, program.block, program.right, -rows.T @ multipliers, equations, sizes
    )


@pytest.mark.parametrize("seed", few(range(8)))
@pytest.mark.parametrize("solver", ["INTERIOR_POINT", "CLARABEL"])
def test_a_balance_has_the_same_answer_by_its_dual(seed, solver):
    rng = np.random.default_rng(seed)
    program = balance(
        rng, int(rng.integers(6, 20)), int(rng.integers(3, 6)), free=seed % 3, extra=seed % 2
    )
    dual = flipped(program)
    assert dual.arrays.sparse.shape[1] == program.zero + 3 * (seed % 2)
    assert dual.arrays.zero == seed % 3
    status, *found = run(dual.arrays, solver, -np.inf)
    _, *known = run(program, "CLARABEL", -np.inf)
    x, y = dual.back(*polish(dual.arrays, *found))
    assert status == "optimal" and program.off(x, y) < 1e-8
    assert program.cost @ x == pytest.approx(program.cost @ known[0], rel=1e-7, abs=1e-7)


def test_a_program_of_many_equations_or_without_cones_stays_as_it_is():
    rng = np.random.default_rng(0)
    assert flipped(balance(rng, 4, 11)) is None
    program = balance(rng, 8, 2)
    assert (
        flipped(
            Arrays(
                program.sparse,
                program.block,
                program.right,
                program.cost,
                2,
                np.ones(len(program.right) - 2, dtype=int),
            )
        )
        is None
    )
