"""The page of questions and contacts, each cell of its table asked of a small contact."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from helpers.public_names.asked import ASKED, F
from helpers.systems import CYCLE, FIRST_PAIR, system
from studies.validation.fuzz.embedded import embedded

PAIR = replace(system(*FIRST_PAIR), compliance=10.0 * np.eye(2), width=[1.0, 1.0])
B = 0.2 * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
A = np.array([[2.0, -0.5, 0.0], [-0.5, 2.0, -0.5], [0.0, -0.5, 2.0]])
LOADS = {"mean": ([0, 0, 0], [1, -0.3, 1]), "cyclic": ([0.5, 0.2, 0.5], [0.1, 0, 0])}
OPEN = fo.ContactSystem.from_blocks(
    A, B, A, [0.0, 1.0, 2.0], LOADS, width=[1.0] * 3, compliance=10.0 * np.eye(2)
)
SOLIDS = [
    replace(
        embedded(flat, np.random.default_rng(13))[0],
        compliance=10.0 * np.eye(2),
        width=[1.0] * flat.nodes,
    )
    for flat in (PAIR, OPEN)
]
CONTACTS = {"plane": [PAIR], "space": SOLIDS[:1], "with open nodes": [OPEN, SOLIDS[1]]}
CONTACTS["with a shear strength"] = [
    contact.with_shear_strength(0.4) for contact in (PAIR, SOLIDS[0])
]


@cache
def limit_of(column):
    """The shakedown limit of each contact of a column."""
    return [fo.shakedown_limit(contact, CYCLE, F) for contact in CONTACTS[column]]


PAGE = Path(__file__).parents[2] / "docs" / "questions.md"
HEAD, _, *ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("|")
]


def test_the_table_has_all_questions():
    assert HEAD == ["question", *CONTACTS, "command"] and [
        row[0].strip("`") for row in ROWS
    ] == list(ASKED)


@pytest.mark.usefixtures("few_starts")
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].strip("`"))
def test_each_cell_says_what_a_contact_answers(row):
    name, *cells, _ = row
    ask, refused = ASKED[name.strip("`")], ""
    for column, cell in zip(CONTACTS, cells, strict=True):
        alternative = re.match(r"refused: `(\w+)`", cell)
        for contact, limit in zip(CONTACTS[column], limit_of(column), strict=True):
            in_space = contact.tangents == 2
            assert limit.open.any() == (column == "with open nodes")
            if alternative or (in_space and refused):
                refused = refused if alternative is None else alternative.group(1)
                with pytest.raises(fo.ModelError, match=refused):
                    ask(contact, limit.load_factor, {})
                continue
            engine = getattr(
                ask(contact, limit.load_factor, {"steps": 2} if in_space else {}), "engine", None
            )
            assert (
                not isinstance(engine, str)
                or column == "with open nodes"
                or cell == {"path": "exact path", "newton": "increments"}[engine]
            )
