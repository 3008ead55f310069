"""Results, systems and cycles as values: copied, sent to other processes, and never changed."""

import copy
import io
import pickle

import pytest

import frictopt as fo


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_systems_cycles_and_results_can_be_copied_and_sent(punch, paper_cycle, copied):
    contact, cycle = copied(punch(16)), copied(paper_cycle)
    limit, safe = copied(fo.shakedown_limit(contact, cycle, 0.7)), copied(fo.safe_slip(contact, cycle, 0.7, 1.0))
    assert limit.load_factor == fo.shakedown_limit(punch(16), paper_cycle, 0.7).load_factor
    assert limit.problem is None and safe.problem is None and len(limit.mechanism) and safe.exists
    limit.explain(io.StringIO())


def test_results_cannot_be_changed(punch, paper_cycle):
    limit = fo.shakedown_limit(punch(16), paper_cycle, 0.7)
    with pytest.raises(AttributeError):
        limit.load_factor = 3.0
    with pytest.raises(ValueError, match="read-only"):
        limit.slip[0] = 1.0
