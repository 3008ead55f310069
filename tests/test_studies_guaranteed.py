"""The study of the guaranteed limit at quick size: facts of the theory that hold on any mesh."""

import numpy as np
import pytest

from frictopt.reference import two_node_limits
from studies import guaranteed

pytestmark = pytest.mark.slow

STUDY = guaranteed.STUDY


@pytest.mark.parametrize("name", ["guaranteed_friction", "guaranteed_corner", "guaranteed_bound"])
def test_the_guaranteed_limit_is_not_above_the_shakedown_limit(tables, name):
    table = tables[name]
    assert (table["guaranteed"] <= table["shakedown"]).all() and (table["guaranteed"] < 0.9 * table["shakedown"]).any()
    assert (table["x"].isna() == (table["guaranteed"] == table["shakedown"])).all()
    assert table.loc[table["friction"] < 0.9, "x"].abs().dropna().eq(1).all(), "the corner node is the first"


def slacks(contact, factor, slip):
    """(corners, senses, nodes) slack of each friction bound."""
    (q0, p0), (q1, p1) = contact.bonded["mean"], contact.bonded["cyclic"]
    q, p = (mean + factor * np.array([[-1.0], [1.0]]) * rate for mean, rate in ((q0 + contact.A @ slip, q1), (p0 + contact.B @ slip, p1)))
    return np.stack([0.6 * p + q, 0.6 * p - q], axis=1)


def test_the_plane_shows_the_limits_of_the_pair(tables):
    table, contact = tables["guaranteed_plane"], guaranteed.pair()
    limits = two_node_limits(contact.A, contact.B, *contact.bonded["mean"], *contact.bonded["cyclic"], 0.6)
    by_name = table.groupby("limit")["load_factor"].first()
    assert by_name["guaranteed limit"] == pytest.approx(limits.lambda_1, rel=1e-9)
    assert by_name["shakedown limit"] == pytest.approx(limits.lambda_2, rel=1e-9)
    assert table["load_factor"].nunique() == 4


def test_lines_are_where_a_bound_is_met_and_vertices_of_the_safe_slips_on_two_of_them(tables):
    table, contact = tables["guaranteed_plane"], guaranteed.pair()
    for (what, factor, node, sense), rows in table[table["what"].isin(["line", "mean line"])].groupby(["what", "load_factor", "node", "sense"]):
        assert len(rows) == 2
        for slip in rows[["v1", "v2"]].to_numpy():
            here = slacks(contact, factor if what == "line" else 0.0, slip)[:, 0 if sense == "forward" else 1, node]
            assert here.min() == pytest.approx(0, abs=1e-9)
    for factor, rows in table[table["what"] == "safe"].groupby("load_factor"):
        for slip in rows[["v1", "v2"]].to_numpy():
            here = slacks(contact, factor, slip)
            assert here.min() > -1e-8 and (here.min(axis=0) < 1e-8).sum() >= 2
