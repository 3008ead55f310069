"""The study of sizes at quick size: what does not depend on the machine."""

import pandas as pd
import pytest

import frictopt as fo
from studies import size

pytestmark = pytest.mark.slow
STUDY = size.STUDY


@pytest.fixture
def table(tables):
    return tables["sizes"]


def test_every_size_answers_its_questions(table):
    asked = {(scene, elements): rows["question"].tolist() for (scene, elements), rows in table.groupby(["scene", "elements"])}
    always, steady = ["condense", "shakedown limit", "limit, nothing left out", "safe slip"], ["steady state below", "steady state above"]
    assert asked == {
        ("plane", 8): [*always, "guaranteed limit", *steady],
        ("plane", 16): [*always, "guaranteed limit"],
        ("space", 2): [*always, "guaranteed limit", *steady],
        ("space", 3): always,
    }
    assert (table["seconds"] > 0).all() and (table["residual"].dropna() <= 1e-9).all()


def test_nodes_unknowns_and_memory(table):
    for (scene, elements), rows in table.groupby(["scene", "elements"]):
        assert (rows["nodes"] == (elements + 1 if scene == "plane" else (elements + 1) ** 2)).all()
        assert rows["memory"].is_monotonic_increasing and rows["memory"].between(0.05, 4.0).all()
        bodies = (fo.scenes.PunchOnHalfPlane if scene == "plane" else fo.scenes.SquarePunch)(elements=elements).model().bodies.values()
        assert (rows["unknowns"] == sum(body.mesh.p.size for body in bodies)).all()


def test_exponents_are_those_of_powers():
    powers = size.SIZES.columns.keys()
    rows = [
        {**dict.fromkeys(powers, 1), "scene": "plane", "nodes": n, "unknowns": n, "question": "condense", "seconds": n**2.5} for n in (64, 128, 256)
    ]
    page = size.STUDY.summary({size.SIZES.name: pd.DataFrame(rows)})
    assert page.splitlines()[-1] == "| exponent of N |  | 2.5 |" and all(f"| {n} | {n} |" in page for n in (64, 128, 256))
