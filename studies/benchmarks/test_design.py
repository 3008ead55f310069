"""The best profile at the paper's size against the shakedown limit of the flat face."""

import frictopt as fo


def test_a_profile_against_the_limit(compare, system, cycle):
    def profile():
        model = fo.DesignModel(system, cycle, profile=True)
        return model.solve(0.7, [model.profile >= 0, model.profile <= 0.1])

    assert compare(profile, lambda: fo.shakedown_limit(system, cycle, 0.7), rounds=9) < 8.0
