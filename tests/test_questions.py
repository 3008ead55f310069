"""The page of questions and contacts, each cell of its table asked of a small contact."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from studies.validation.fuzz.embedded import embedded
from systems import CYCLE, FIRST_PAIR, system

F = 0.6
PAIR = replace(system(*FIRST_PAIR), compliance=10.0 * np.eye(2), width=[1.0, 1.0])
B = 0.2 * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
A = np.array([[2.0, -0.5, 0.0], [-0.5, 2.0, -0.5], [0.0, -0.5, 2.0]])
LOADS = {"mean": ([0, 0, 0], [1, -0.3, 1]), "cyclic": ([0.5, 0.2, 0.5], [0.1, 0, 0])}
OPEN = fo.ContactSystem.from_blocks(A, B, A, [0.0, 1.0, 2.0], LOADS, width=[1.0] * 3, compliance=10.0 * np.eye(2))
SOLIDS = [replace(embedded(flat, np.random.default_rng(13))[0], compliance=10.0 * np.eye(2), width=[1.0] * flat.nodes) for flat in (PAIR, OPEN)]
CONTACTS = {"plane": [PAIR], "space": SOLIDS[:1], "with open nodes": [OPEN, SOLIDS[1]]}
CONTACTS["with a shear strength"] = [contact.with_shear_strength(0.4) for contact in (PAIR, SOLIDS[0])]


@cache
def limit_of(column):
    """The shakedown limit of each contact of a column."""
    return [fo.shakedown_limit(contact, CYCLE, F) for contact in CONTACTS[column]]


PAGE = Path(__file__).parent.parent / "docs" / "questions.md"
HEAD, _, *ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")
]


def _deep_profile(contact):
    model = fo.DesignModel(contact, CYCLE, profile=True)
    return model.solve(F, [model.profile >= 0, model.profile <= 1])


ASKED = {
    "onset": lambda s, lam, steps: fo.onset(s, CYCLE, F),
    "shakedown_limit": lambda s, lam, steps: fo.shakedown_limit(s, CYCLE, F),
    "ShakedownLimit.least_slip": lambda s, lam, steps: fo.shakedown_limit(s, CYCLE, F).least_slip(1.2 * lam),
    "guaranteed_limit": lambda s, lam, steps: fo.guaranteed_limit(s, CYCLE, F),
    "GuaranteedLimit.verify": lambda s, lam, steps: fo.guaranteed_limit(s, CYCLE, F).verify(starts=1, moved=0),
    "GuaranteedLimit.after_overload": lambda s, lam, steps: fo.guaranteed_limit(s, CYCLE, F).after_overload(),
    "gross_slip": lambda s, lam, steps: fo.gross_slip(s, CYCLE, F),
    "safe_slip": lambda s, lam, steps: fo.safe_slip(s, CYCLE, F, 0.5 * lam),
    "starts.safe_vertices": lambda s, lam, steps: fo.starts.safe_vertices(s, CYCLE, F, 0.5 * lam, np.ones((1, *s.slip_shape))),
    "required_friction": lambda s, lam, steps: fo.required_friction(s, CYCLE, 0.5 * lam),
    "safe_region": lambda s, lam, steps: fo.safe_region(s, {"mean": 1.0}, ["cyclic", [{"mean": 0.1}]], F),
    "reference.order_preserving": lambda s, lam, steps: fo.reference.order_preserving(s),
    "DesignModel.solve": lambda s, lam, steps: _deep_profile(s),
    "march": lambda s, lam, steps: fo.march(s, CYCLE, F, 1.2 * lam, cycles=1, **steps),
    "steady_state": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps),
    "SteadyState.loop": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps).loop("cyclic"),
    "SteadyState.by_contact": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps).by_contact(),
    "SteadyState.fretting_table": lambda s, lam, steps: fo.steady_state(s, CYCLE, F, 1.2 * lam, **steps).fretting_table(),
    "dissipation_study": lambda s, lam, steps: fo.dissipation_study(s, CYCLE, F, [0.5 * lam], fo.starts.random_slips(s, [0.01], 1), progress=False),
    "dissipation_range": lambda s, lam, steps: fo.dissipation_range(s, CYCLE, F, 0.5 * lam, **steps),
    "backbone_curve": lambda s, lam, steps: fo.backbone_curve(s, CYCLE, F, [0.5 * lam], **steps),
    "report": lambda s, lam, steps: fo.report(s, CYCLE, F, [0.5 * lam], **steps),
    "limit_after_protocol": lambda s, lam, steps: fo.limit_after_protocol(s, CYCLE, F, scan=1, tolerance=0.5, **steps),
    "least_excursion": lambda s, lam, steps: fo.least_excursion(s, CYCLE, F, 0.5 * lam, excursion={"mean": 0.5}, **steps),
    "wear": lambda s, lam, steps: fo.wear(s, CYCLE, F, 1.2 * lam, coefficient=1e-3, cycles=1, progress=False, **steps),
    "starts.assembled_slip": lambda s, lam, steps: fo.starts.assembled_slip(s, CYCLE, F, **steps),
    "starts.random_slips": lambda s, lam, steps: fo.starts.random_slips(s, [0.01], 1),
}


def test_the_table_has_all_questions():
    assert HEAD == ["question", *CONTACTS] and [row[0].strip("`") for row in ROWS] == list(ASKED)


@pytest.mark.usefixtures("few_starts")
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].strip("`"))
def test_each_cell_says_what_a_contact_answers(row):
    name, *cells = row
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
            engine = getattr(ask(contact, limit.load_factor, {"steps": 2} if in_space else {}), "engine", None)
            assert not isinstance(engine, str) or column == "with open nodes" or cell == {"path": "exact path", "newton": "increments"}[engine]
