"""Results, systems and cycles as values: copied, sent to other processes, and never changed."""

import copy
import io
import pickle
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_systems_cycles_and_results_can_be_copied_and_sent(punch, paper_cycle, copied):
    contact, cycle = copied(punch(16)), copied(paper_cycle)
    limit, safe = copied(fo.shakedown_limit(contact, cycle, 0.7)), copied(fo.safe_slip(contact, cycle, 0.7, 1.0))
    assert limit.load_factor == fo.shakedown_limit(punch(16), paper_cycle, 0.7).load_factor
    assert limit.problem is None and safe.problem is None and len(limit.mechanism) and safe.exists
    limit.explain(io.StringIO())


def test_a_mechanism_names_the_contacts_if_there_are_several(punch, paper_cycle):
    contact = punch(16)
    names = np.where(contact.x < 0, "left", "right")
    limits = [fo.shakedown_limit(replace(contact, contact=name), paper_cycle, 0.7) for name in (None, ["foot"] * contact.nodes, names)]
    *plain, named = (limit.mechanism for limit in limits)
    assert all(list(table) == ["node", "x", "corner", "direction", "share"] for table in plain)
    assert list(named) == ["node", "contact", "x", "corner", "direction", "share"] and set(named["contact"]) == {"left", "right"}
    assert ((named["x"] < 0) == (named["contact"] == "left")).all() and named.drop(columns="contact").equals(plain[1])


def test_results_cannot_be_changed(punch, paper_cycle):
    limit = fo.shakedown_limit(punch(16), paper_cycle, 0.7)
    with pytest.raises(AttributeError):
        limit.load_factor = 3.0
    with pytest.raises(ValueError, match="read-only"):
        limit.slip[0] = 1.0
