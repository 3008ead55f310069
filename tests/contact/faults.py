"""Planted faults of `contact`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "contact/diagnosis.py",
        "all contacts are counted as the first one",
        old="names == name",
        new="names == names[0]",
        tests="diagnosis",
        within="counted",
    ),
    Fault(
        "contact/diagnosis.py",
        "nodes that the others pull open stay closed",
        old="left < -CONDENSATION",
        new="False",
        tests="diagnosis",
    ),
    Fault(
        "contact/referee.py",
        "the initial gap does not count",
        old="gap - system.gap",
        new="gap",
        tests="referee",
    ),
    Fault(
        "contact/referee.py",
        "the referee takes friction the wrong way",
        old="q + bound[:, None] * _unit(increment, slid)",
        new="q - bound[:, None] * _unit(increment, slid)",
        tests="referee",
    ),
    Fault(
        "contact/referee.py",
        "backward shear beyond the bound is lawful",
        old="size - bound",
        new="q.sum(axis=1) - bound",
        tests="referee",
    ),
    Fault(
        "contact/referee.py",
        "shear beyond the strength of a surface is lawful",
        old="contact_law(system, f).bound(p, force)",
        new="f * p",
        tests="shear_strength",
    ),
    Fault(
        "contact/law.py",
        "what does not know a shear strength takes it",
        old="checked.capped",
        new="False",
        tests="shear_strength",
    ),
    Fault(
        "contact/system.py",
        "a strength acts on no area",
        old="parts.checked_strength('strength', strength, self.nodes) * width",
        new="parts.checked_strength('strength', strength, self.nodes)",
        tests="shear_strength",
    ),
    Fault(
        "contact/system.py",
        "an ellipse stretches forces and not the stiffness",
        old="give[:, None] * self.S * give",
        new="self.S",
        tests="orthotropic",
    ),
    Fault(
        "contact/system.py",
        "friction along the second tangent by the inverse ratio",
        old="1 / stretch",
        new="stretch",
        tests="orthotropic",
    ),
    Fault(
        "contact/files.py",
        "files lose the stretch of tangents",
        old="system.orthotropic",
        new="False",
        tests="orthotropic",
    ),
    Fault(
        "contact/strip.py",
        "arrows of stretched slips",
        old="slip / system.stretch",
        new="slip",
        tests="orthotropic",
    ),
    Fault(
        "contact/files.py",
        "files lose the shear strength",
        old="system.capped",
        new="False",
        tests="shear_strength",
    ),
    Fault(
        "contact/history.py",
        "a positive phase is behind",
        old="turns[:, None] + np.radians([phase for _, phase in waves.values()])",
        new="turns[:, None] - np.radians([phase for _, phase in waves.values()])",
        tests="cycle",
    ),
    Fault(
        "contact/history.py",
        "loads in phase have many corners",
        old=(
            "-phases[0] + np.array([0.0, np.pi]) if to_and_fro else 2 * np.pi / count * np.arange(count)"
        ),
        new=(
            "-phases[0] + np.array([0.0, np.pi]) if False else 2 * np.pi / count * np.arange(count)"
        ),
        tests="cycle",
    ),
    Fault(
        "contact/history.py",
        "a history that one load closes is closed",
        old=(
            "(np.abs(points[-1] - points[0]) <= _ROUNDING * np.abs(points).max(axis=0, initial=0.0)).all"
        ),
        new=(
            "(np.abs(points[-1] - points[0]) <= _ROUNDING * np.abs(points).max(axis=0, initial=0.0)).any"
        ),
        tests="cycle::test_a_history_less_its_mean_is_what_the_load_factor_scales",
    ),
    Fault(
        "contact/system.py",
        "a load case acts the same way at all corners",
        old="load.get(name, 0.0)",
        new="abs(load.get(name, 0.0))",
        tests="cycle system",
    ),
    Fault(
        "contact/history.py",
        "the middle of a history",
        old="high / 2",
        new="high",
        tests="cycle",
    ),
    Fault(
        "contact/history.py",
        "a point at which the load turns back is left out",
        old="(back <= 0).all() and (np.abs(part[:, ~moves]) <= 1).all()",
        new="(np.abs(part[:, ~moves]) <= 1).all()",
        tests="cycle",
    ),
    Fault(
        "contact/history.py",
        "several loads jump at once in a domain",
        old="part if number % 2 == 0 else part[::-1]",
        new="part",
        tests="cycle",
    ),
    Fault(
        "contact/face.py",
        "maps fill holes",
        old="excess > 0",
        new="excess > np.inf",
        tests="plots_of_states",
    ),
    Fault(
        "contact/parts.py",
        "soft surfaces hold a free body",
        old="values > RIGID",
        new="values > -1",
        tests="contact_stiffness",
    ),
    Fault(
        "contact/parts.py",
        "the blocks of a stiffness do not see each other",
        old="factor[start:, block] -= factor[start:, done] @ factor[block, done].T",
        new="pass",
        tests="system::test_a_stiffness_of_many_nodes_is_refused_by_its_lowest_eigenvalue",
    ),
    Fault(
        "contact/parts.py",
        "springs do not know the width",
        old="checked_springs(name, k, len(width)) * width",
        new="checked_springs(name, k, len(width)) * width ** 0",
        tests="contact_stiffness",
    ),
    Fault(
        "contact/parts.py",
        "overlaps store no energy of their own",
        old="L - D.T @ p - p.T @ D - D.T @ held[-len(D):]",
        new="L - D.T @ p - p.T @ D",
        tests="compliance",
    ),
    Fault(
        "contact/system.py",
        "springs add nothing to the compliance",
        old="self.compliance + more",
        new="self.compliance + 0 * more",
        tests="compliance",
    ),
    Fault(
        "contact/frames.py",
        "tangents of a pair as elsewhere on an oblique plane",
        old="np.where(np.any(ways, axis=1, keepdims=True), ways, axis)",
        new="axis",
        tests="oblique_supports",
    ),
    Fault(
        "contact/system.py",
        "a tension is minus itself",
        old="-self.displacements(amplitudes, slip, gap)[..., list(self.bonded).index(case)]",
        new="self.displacements(amplitudes, slip, gap)[..., list(self.bonded).index(case)]",
        tests="locked_bolts",
    ),
    Fault(
        "contact/files.py",
        "an archive forgets the bolts",
        old="dict(zip(*bolts.values(), strict=True)) if bolts else {}",
        new="dict(zip(*bolts.values(), strict=True)) if False else {}",
        tests="locked_bolts",
    ),
    Fault(
        "contact/frames.py",
        "left-handed tangents",
        old="np.cross(n, first)",
        new="np.cross(first, n)",
        tests="condense_matrices models_in_space",
    ),
    Fault(
        "contact/parts.py",
        "open nodes that nothing holds",
        old=(
            "max((np.abs(part).max(initial=0.0) for part in (*driven, vectors[-int(opened.sum()):, ~held]))) > _HELD"
        ),
        new=(
            "max((np.abs(part).max(initial=0.0) for part in (*driven, vectors[-int(opened.sum()):, ~held]))) > np.inf"
        ),
        tests="open_nodes patterns slides",
    ),
    Fault(
        "contact/law.py",
        "the other root in space",
        old="root - b",
        new="root + b",
        tests="onset spatial_limits",
    ),
    Fault(
        "contact/system.py",
        "the initial gap presses",
        old="joined(*self.reaction(loads)) - self.S[:, -self.nodes:] @ self.gap",
        new="joined(*self.reaction(loads)) + self.S[:, -self.nodes:] @ self.gap",
        tests="system",
    ),
    Fault(
        "contact/strip.py",
        "ratios by the pressure alone",
        old="most_shear(system, friction, p)",
        new="most_shear(system, 1.0, p)",
        tests="plots",
    ),
    Fault(
        "contact/strip.py",
        "circles on the wrong bound",
        old="ratio[corner, nodes]",
        new="-ratio[corner, nodes]",
        tests="plots",
    ),
    Fault(
        "contact/strip.py",
        "rings of a map are all alike",
        old="for nodes, _, area in circles.values():\n    np.add.at(areas, np.ravel(nodes), area)",
        new="for nodes, _, area in circles.values():\n    areas[np.ravel(nodes)] = _ONE_NODE",
        tests=(
            "plots_spatial::test_a_limit_shows_the_ratio_at_the_first_corner_the_slip_and_the_nodes_of_the_mechanism"
        ),
    ),
    Fault(
        "contact/face.py",
        "open nodes have a residual slip",
        old="np.where(closed[:, None], slip, np.nan)",
        new="slip",
        tests=(
            "plots_spatial::test_open_nodes_are_rings_without_slip_and_those_that_carry_nothing_do_not_slip"
        ),
    ),
)
