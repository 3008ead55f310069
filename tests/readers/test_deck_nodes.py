"""Tables, texts and errors name nodes of a job by their numbers in the deck.

Nodes of two bodies lie at x = 0 and x = 1. Their numbers neither rise nor follow each other.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag

import frictopt as fo

DECK = {12: (0.0, 0.0), 70: (0.0, 0.0), 5: (1.0, 0.0), 66: (1.0, 0.0)}
# Rows of the deck of the nodes of body 1, 70 and 66, and of body 2, 12 and 5.
PAIRS = np.array([[1, 0], [3, 2]])
BAR = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2)) + np.kron(np.eye(2), np.diag([1.0, 0.5]))
CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 0.2}, {"Q": -0.2}])


def job():
    labels = [[number, direction] for number in (70, 66, 12, 5) for direction in (1, 2)]
    return fo.readers.MatrixJob(block_diag(BAR, BAR + 5 * np.eye(4)), labels, DECK)


def condensed(**changes):
    of = job()
    loads = {"P": of.force([1, 3], nodal=[0.0, -1.0]), "Q": of.force([3], nodal=[1.0, 0.0])}
    arguments = {"pairs": PAIRS, "unknowns": of.unknowns, "points": of.points, **changes}
    return fo.condense(of.K, loads, normals=[0.0, 1.0], **arguments)


def numbers_by_place(table):
    return dict(zip(table["x"], table["deck_node"], strict=True))


def test_tables_of_a_job_have_the_numbers_of_its_deck():
    system = condensed()
    steady = fo.steady_state(system, CYCLE, 0.1, load_factor=1.0, progress=False)
    limit = fo.shakedown_limit(system, CYCLE, friction=0.1)
    tables = {
        "system": system.to_frame(),
        "steady": steady.to_frame(),
        "fretting": steady.fretting_table(),
        "states": steady.states().to_frame(),
        "slip": limit.to_frame(),
    }
    for name, table in tables.items():
        assert numbers_by_place(table) == {0.0: 70, 1.0: 66}, name
    # The load acts at x = 1.
    assert numbers_by_place(limit.mechanism) == {1.0: 66}
    events = fo.onset(system, CYCLE, friction=0.1).to_frame()
    slips = events[events["event"] == "slip"]
    assert set(slips["deck_node"]) == {66}
    assert events["deck_node"].isna().equals(events["node"].isna())


def test_texts_of_a_job_name_the_numbers_of_its_deck():
    system = condensed()
    limit = fo.shakedown_limit(system, CYCLE, friction=[0.1, 0.0])
    assert "node 1 (66 in the deck) has no friction" in limit.reason
    sheet = fo.report(
        system, CYCLE, friction=0.1, limits={"slip range": 1e-3}, pages=2, progress=False
    )
    assert sheet.verdicts["where"].tolist() == ["contact, node 1 (66 in the deck) at (1, 0)"]
    assert "(66 in the deck)" in " ".join(str(sheet).split())


def test_numbers_of_the_deck_survive_files_and_changes_of_the_system(tmp_path):
    system = condensed()
    system.save(tmp_path / "system.npz")
    fo.shakedown_limit(system, CYCLE, friction=0.1).save(tmp_path / "limit.npz")
    for same in (
        fo.ContactSystem.load(tmp_path / "system.npz"),
        fo.results.load(tmp_path / "limit.npz").system,
        system.with_gap([0.0, 0.1]),
        system.with_contact_stiffness(normal=3.0),
        system.with_interference({"fit": 0.1}),
    ):
        assert same.deck_node.tolist() == [70, 66]
    unnumbered = fo.ContactSystem(system.S, system.points, system.bonded)
    unnumbered.save(tmp_path / "unnumbered.npz")
    assert fo.ContactSystem.load(tmp_path / "unnumbered.npz").deck_node is None


def test_coordinates_that_are_not_the_points_of_a_job_have_no_numbers():
    """Rows of a part, or of other coordinates, may be other nodes."""
    points = job().points
    for others in (points + 0.0, points[:], np.array(points)):
        system = condensed(points=others)
        assert system.deck_node is None
        assert "deck_node" not in system.to_frame()


TWICE = job().unknowns.copy()
TWICE[0, 1] = TWICE[1, 1]
ERRORS = {
    "pair 1 is node 66 at (1, 0) twice": {"pairs": [[1, 0], [3, 3]]},
    "is given twice, to nodes [12, 70]": {"unknowns": TWICE},
    "nodes 5 and 66 lie on each other at (1, 0), next to the contact": {"pairs": PAIRS[:1]},
    "of node 70 of body 1, follows from other pairs or from supports": {"held": [0, 1, 4, 5]},
}


@pytest.mark.parametrize("message", ERRORS)
def test_errors_of_a_job_name_the_numbers_of_its_deck(message):
    with pytest.raises(fo.ModelError) as error:
        condensed(**ERRORS[message])
    assert message in str(error.value)


def test_a_number_in_the_deck_is_a_whole_number_for_each_node():
    system = condensed()
    for numbers in ([1], [1.5, 2.0], [-1, 2]):
        with pytest.raises(fo.ModelError, match="deck_node: "):
            fo.ContactSystem(system.S, system.points, system.bonded, deck_node=numbers)


def test_nodes_of_a_deck_of_calculix_are_at_their_places():
    """The deck is read again here, as plain text."""
    of = fo.readers.read_calculix("tests/data/flat")
    pairs = of.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    system = fo.condense(
        of.K, {"P": of.force("N_TOP", pressure=1.0)}, pairs, [0.0, 1.0], of.unknowns, of.points
    )
    text = Path("tests/data/flat.inp").read_text().split("*NODE")[1].split("\n", 1)[1]
    listed = {}
    for line in text.split("*")[0].splitlines():
        number, x, y, *_ = line.split(",")
        listed[int(number)] = (float(x), float(y))
    places = [listed[number] for number in system.deck_node.tolist()]
    assert np.allclose(places, system.points, rtol=0, atol=1e-12)
