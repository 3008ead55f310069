"""The study of two joints at quick size: the rows of its tables belong together, and the safe region holds what the limits say."""

import numpy as np
import pytest

import frictopt as fo
from studies import joint

STUDY = joint.STUDY


def test_the_report_sums_up_the_nodes(tables):
    nodes = tables["joint_fretting"].groupby("joint", sort=False)
    report = tables["joint_report"].set_index("joint")
    assert np.allclose(nodes["work"].sum(), report["dissipation"]) and (report["dissipation"] > 0).all()
    for name in ("slip_range", "F1", "F2", "SWT"):
        assert np.allclose(nodes[name].max(), report[f"largest_{name}"])
    assert (report["corners"] == joint.QUICK.turns).all() and (report["samples"] > 9 * report["corners"] - 10).all()
    assert (report["residual"] < 1e-9).all()


def test_friction_and_load_factor_agree(tables):
    """The history needs more friction than there is where its limit is below one, and its limit with the friction that it needs is one."""
    report = tables["joint_report"].set_index("joint")
    assert ((report["shakedown"] < 1) == (report["required_friction"] > report["friction"])).all()
    for case in joint.joints(joint.QUICK):
        cycle = fo.LoadCycle.from_history(case.history, mean=dict(case.mean))
        limit = fo.shakedown_limit(case.model.condense(), cycle, report.loc[case.name, "required_friction"])
        assert limit.load_factor == pytest.approx(1.0, abs=1e-4)


def test_the_summary_has_a_column_for_each_joint(tables):
    head, _, *lines = joint.STUDY.summary(tables).splitlines()
    assert head.split("|")[2:4] == [" dovetail ", " press fit "] and len(lines) == 9
