"""Results, systems and cycles as values: copied, sent to other processes, and never changed."""

from dataclasses import replace

import numpy as np

import frictopt as fo


def test_a_mechanism_names_the_contacts_if_there_are_several(punch, paper_cycle):
    contact = punch(16)
    names = np.where(contact.x < 0, "left", "right")
    limits = [fo.shakedown_limit(replace(contact, contact=name), paper_cycle, 0.7) for name in (None, ["foot"] * contact.nodes, names)]
    *plain, named = (limit.mechanism for limit in limits)
    assert all(list(table) == ["node", "x", "corner", "loads", "direction", "share"] for table in plain)
    assert list(named) == ["node", "contact", "x", "corner", "loads", "direction", "share"] and set(named["contact"]) == {"left", "right"}
    assert ((named["x"] < 0) == (named["contact"] == "left")).all() and named.drop(columns="contact").equals(plain[1])
    assert (named["loads"] == np.array(["sigma = -1", "sigma = +1"])[named["corner"]]).all()
