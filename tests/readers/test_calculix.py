"""Decks of CalculiX, run by `ccx`.

Its matrices with forces by the package are compared with assembly by scikit-fem, with other decks,
and with the displacements and modes by CalculiX.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.calculix import Block, displacements, equation, glued, lines, node_set, run
from helpers.components import joined

pytestmark = pytest.mark.ccx

CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])


def plane(**section):
    """A punch on a block, body 1 free: blocks, numbers of the pairs, deck."""
    blocks = [
        Block(1, lines((0, 3, 3), (0, 2, 2)), 1000.0, 0.3, "UP", **section),
        Block(101, lines((-1, 4, 5), (-2, 0, 2)), 500.0, 0.2, "LOW", **section),
    ]
    return contact(*blocks, 1)


def space():
    """The same in space."""
    return contact(
        Block(1, lines((0, 3, 3), (0, 2, 2), (0, 2, 2)), 1000.0, 0.3, "UP"),
        Block(501, lines((-1, 4, 5), (-1, 3, 4), (-2, 0, 2)), 500.0, 0.2, "LOW"),
        2,
    )


def contact(upper, lower, axis):
    one = upper.on(axis, 0)
    under = {tuple(point): int(n) for point, n in zip(lower.points, lower.numbers, strict=True)}
    two = [under[tuple(upper.points[n - upper.first])] for n in one]
    sets = {
        "CU": one,
        "CL": two,
        "TOP": upper.on(axis, 2),
        "BOT": lower.on(axis, -2),
        "SIDE": upper.on(0, 0),
    }
    deck = (
        upper.deck()
        + lower.deck()
        + "".join(node_set(*pair) for pair in sets.items())
        + f"*BOUNDARY\nBOT, 1, {axis + 1}\n"
    )
    return (upper, lower), list(zip(one.tolist(), two, strict=True)), deck


def condensed(job, **loads):
    """The job condensed under forces, its pairs in the order in which they are returned too."""
    pairs = job.pairs("CU", "CL")
    d = job.points.shape[1]
    loads = {
        "P": {"where": "TOP", "traction": -np.eye(d)[-1]},
        "Q": {"where": "TOP", "traction": np.eye(d)[0]},
    } | loads
    forces = {name: job.force(**load) for name, load in loads.items()}
    system = fo.condense(
        job.K, forces, pairs, np.eye(d)[-1], job.unknowns, job.points, generalised=job.generalised
    )
    return system, [tuple(map(int, pair)) for pair in job.deck.numbers[pairs]]


def on_top(blocks, axis, traction):
    """Nodal forces of a uniform traction on the top, by the areas of its cells."""
    upper = blocks[0]
    widths = [np.convolve(np.diff(line), [0.5, 0.5]) for line in upper.lines[:axis]]
    shares = widths[0] if axis == 1 else np.outer(widths[1], widths[0]).ravel()
    return [
        (int(n), k + 1, t * share)
        for n, share in zip(upper.on(axis, 2), shares, strict=True)
        for k, t in enumerate(traction)
    ]


def agree(job, blocks, equations, axis):
    """Check stiffness and reactions of a job against multipliers."""
    system, pairs = condensed(job)
    loads = [
        on_top(blocks, axis, traction) for traction in (-np.eye(axis + 1)[-1], np.eye(axis + 1)[0])
    ]
    S, R = glued(blocks, job.deck.numbers[job.nodes("BOT")], pairs, equations, loads)
    assert np.abs(system.S - S).max() < 1e-9 * np.abs(S).max()
    for name, r in zip("PQ", R.T, strict=True):
        assert np.abs(joined(*system.bonded[name]) - r).max() < 1e-9 * np.abs(r).max()
    return system


def moves_as_one(top, direction):
    return [[(int(n), direction, 1.0), (int(top[0]), direction, -1.0)] for n in top[1:]]


def test_nodes_that_follow_others_hold_no_body(tmp_path):
    """The block may rise: it is held along x only, and the top of the punch moves as one along y."""
    blocks, _, deck = plane()
    rules = "".join(equation(*terms) for terms in moves_as_one(blocks[0].on(1, 2), 2))
    job = fo.readers.read_calculix(run(tmp_path, deck.replace("BOT, 1, 2", "BOT, 1, 1") + rules)[0])
    loads = {"P": np.eye(len(job.labels))[0]}
    with pytest.raises(fo.ModelError, match=r"supports: the body at .* can still move along y;"):
        fo.condense(job.K, loads, job.pairs("CU", "CL"), [0.0, 1.0], job.unknowns, job.points)


def test_loads_that_the_deck_cannot_place_are_refused_by_name(tmp_path):
    blocks, _, deck = space()
    top = blocks[0].on(2, 2)
    (tmp_path / "plain.inp").write_text(deck)
    job = fo.readers.read_calculix(
        run(tmp_path, deck + equation((top[0], 3, 1.0), (top[1], 3, -1.0)))[0],
        deck=tmp_path / "plain.inp",
    )
    with pytest.raises(
        fo.ModelError,
        match=rf"force: it acts on node {top[0]}, direction 3, .*give the deck of the same job",
    ):
        job.force("TOP", pressure=1.0)
    job, _ = run(tmp_path, deck + f"*MPC\nPLANE, {top[0]}, {top[3]}, {top[8]}, {top[5]}\n")
    with pytest.raises(
        fo.ModelError, match=r"the code itself wrote nan, as CalculiX does for \*MPC"
    ):
        fo.readers.read_calculix(job)


def test_a_plane_job_is_per_unit_depth_whatever_its_thickness(tmp_path):
    answers = []
    for i, thickness in enumerate(("", "1.", "2.", "10.")):
        blocks, _, deck = plane(thickness=thickness)
        system = agree(
            fo.readers.read_calculix(run(tmp_path, deck, name=f"job{i}")[0]), blocks, [], 1
        )
        gapped = system.with_gap([0.0, 1e-3, 1e-3, 0.0])
        limit = fo.shakedown_limit(system, CYCLE, 0.5)
        bounded = fo.shakedown_limit(system, CYCLE, 0.5, slip_bound=1e-3)
        answers.append(
            [
                limit.load_factor,
                limit.largest_slip,
                fo.shakedown_limit(gapped, CYCLE, 0.5).load_factor,
                bounded.load_factor,
            ]
        )
    assert np.allclose(answers, answers[0], rtol=1e-7)


def test_plane_stress_is_refused_with_the_constants_that_give_it_in_plane_strain(tmp_path):
    job, _ = run(tmp_path, plane(kind="CPS4", thickness="1.")[2])
    with pytest.raises(
        fo.ModelError,
        match=r"elements CPS4 have displacements along z.*E \(1 \+ 2 nu\) / \(1 \+ nu\)\^2 .* nu / \(1 \+ nu\)",
    ):
        fo.readers.read_calculix(job)
    E, nu = 1000.0, 0.3
    block = Block(
        1, lines((0, 3, 3), (0, 2, 2)), E * (1 + 2 * nu) / (1 + nu) ** 2, nu / (1 + nu), "B"
    )
    found = fo.readers.read_calculix(run(tmp_path, block.deck(), name="strain")[0])
    # Uniform stress: forces of plane stress, by hand.
    u = np.array([[0.3, 0.1], [0.2, -0.4]]) @ found.points.T
    e = np.array([0.3, -0.4, 0.15])
    xx, yy, xy = E / (1 - nu**2) * np.array([e[0] + nu * e[1], e[1] + nu * e[0], (1 - nu) * e[2]])
    force = (found.K @ u.T.ravel()[np.argsort(found.unknowns.ravel())]).reshape(-1)
    right = found.points[:, 0] == 3
    assert force[found.unknowns[right]].sum(axis=0) == pytest.approx([2 * xx, 2 * xy])
    assert force[found.unknowns[found.points[:, 1] == 2]].sum(axis=0) == pytest.approx(
        [3 * xy, 3 * yy]
    )


@pytest.mark.parametrize("scene", [plane, space])
@pytest.mark.parametrize("last", [False, True])
def test_a_node_of_no_element_may_stand_anywhere(tmp_path, scene, last):
    blocks, _, deck = scene()
    start = deck.rindex("*ELEMENT") if last else 0
    job, _ = run(tmp_path, deck[:start] + "*NODE\n7777, 50., 50., 0.\n" + deck[start:])
    agree(fo.readers.read_calculix(job), blocks, [], 1 if scene is plane else 2)


def test_without_a_density_there_is_no_matrix(tmp_path):
    job, output = run(tmp_path, plane()[2].replace("*DENSITY\n1.\n", ""))
    assert "no density" in output
    with pytest.raises(fo.ModelError, match=r"no '.*job\.sti'; CalculiX writes it .*\*DENSITY"):
        fo.readers.read_calculix(job)


def test_bricks_with_incompatible_modes_are_stiff_as_in_a_static_step(tmp_path):
    """CalculiX gives each brick three nodes that are not in the deck. The displacement of glued
    bodies under forces by the package is that of CalculiX under its own forces."""
    blocks, pairs, deck = space()
    deck = deck.replace("C3D8", "C3D8I")
    job = fo.readers.read_calculix(run(tmp_path, deck)[0])
    assert len(job.generalised) == 9 * sum(len(block.elements) for block in blocks)
    system, _ = condensed(job)
    ties = "".join(equation((a, k, 1.0), (b, k, -1.0)) for a, b in pairs for k in (1, 2, 3))
    for name, traction in (("P", [0.0, 0.0, -1.0]), ("Q", [1.0, 0.0, 0.0])):
        forces = [(n, k, float(f)) for n, k, f in on_top(blocks, 2, traction) if f]
        moved = displacements(
            tmp_path, deck + ties, "*CLOAD\n" + "".join(f"{n}, {k}, {f!r}\n" for n, k, f in forces)
        )
        work = sum(f * moved[n][k - 1] for n, k, f in forces)
        case = list(system.bonded).index(name)
        # CalculiX prints seven digits.
        assert system.compliance[case, case] == pytest.approx(work, rel=1e-5)


def test_a_shell_beside_solids_is_refused_by_name(tmp_path):
    (upper, _), _, deck = space()
    corners = [int(n) for n in upper.on(2, 2)[[0, 1, 5, 4]]]
    deck += f"*ELEMENT, TYPE=S4, ELSET=SKIN\n9000, {', '.join(map(str, corners))}\n*SHELL SECTION, ELSET=SKIN, MATERIAL=UP\n0.1\n"
    with pytest.raises(fo.ModelError, match="shells"):
        condensed(fo.readers.read_calculix(run(tmp_path, deck)[0]))
