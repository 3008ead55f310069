"""Planted faults of `joints`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "joints/backbone.py",
        "the motion of a load is its work",
        old="size_of(self.system, self.cycle)",
        new="1.0 ** size_of(self.system, self.cycle)",
        tests="backbone",
    ),
    Fault(
        "joints/backbone.py",
        "damping of half the loss",
        old="steady.dissipation / half / factor / (2 * np.pi)",
        new="steady.dissipation / half / factor / (4 * np.pi)",
        tests="backbone",
    ),
    Fault(
        "joints/backbone.py",
        "the displacement is the whole range",
        old=(
            "np.ptp(path.system.displacements(path.amplitudes, path.slip, path.gap) @ self.direction) / 2"
        ),
        new=(
            "np.ptp(path.system.displacements(path.amplitudes, path.slip, path.gap) @ self.direction)"
        ),
        tests="backbone",
    ),
    Fault(
        "joints/backbone.py",
        "the range holds the settled start alone",
        old="[self.load.measured(state) for state in found.steady_states]",
        new="[] and [self.load.measured(state) for state in found.steady_states]",
        tests="backbone",
    ),
    Fault(
        "joints/backbone.py",
        "the range of slip of the last contact",
        old="contacts['slip_range'].max()",
        new="contacts['slip_range'].iloc[-1]",
        tests="backbone",
    ),
    Fault(
        "joints/backbone.py",
        "works between neighbours are linear",
        old="(np.log, np.exp)",
        new="(np.positive, np.positive)",
        tests="backbone",
    ),
    Fault(
        "joints/tightening.py",
        "a bolt is tightened to its force, whatever its share",
        old="shares * [system.bolts[name][0] for name in bolts]",
        new="0.0 * shares + [system.bolts[name][0] for name in bolts]",
        tests="locked_bolts",
    ),
    Fault(
        "joints/tightening.py",
        "the glued bodies tell the shortening",
        old="root(missing, shares, jac=lambda _: glued, options={'xtol': _CLOSE})",
        new="root(lambda x: x - shares, shares, jac=lambda _: glued, options={'xtol': _CLOSE})",
        tests="locked_bolts",
    ),
    Fault(
        "joints/tightening.py",
        "a section that stays open is let pass",
        old="(pulled := missing(np.where(np.arange(len(rows)) == k, 0.0, found.x))[k]) >= 0",
        new=(
            "(pulled := missing(np.where(np.arange(len(rows)) == k, 0.0, found.x))[k]) >= 1000000000.0"
        ),
        tests="locked_bolts",
    ),
    Fault(
        "joints/wear.py",
        "a jump of first order",
        old="1.5 * first + 0.5 * second",
        new="1.0 * first + 0.0 * second",
        tests="wear",
    ),
    Fault(
        "joints/wear.py",
        "wear by normal force and way as wear by work",
        old="f * width",
        new="width",
        tests="wear",
    ),
    Fault(
        "joints/wear.py",
        "the lost depth carried nothing",
        old="state.bonded_p + p",
        new="state.bonded_p",
        tests="wear",
    ),
    Fault(
        "joints/worn_in.py",
        "the overlap of the last load alone",
        old="(first[-n:], last[-n:])",
        new="(last[-n:],)",
        tests="worn_in",
    ),
    Fault(
        "joints/worn_in.py",
        "the whole change of shear counts",
        old="2 * f",
        new="f",
        tests="worn_in",
    ),
    Fault(
        "joints/wear.py",
        "an open node presses",
        old="np.where(state.gap > 0, 0.0, p)",
        new="np.where(state.gap > 0, 1.0, p)",
        tests="wear",
    ),
    Fault(
        "joints/pictures.py",
        "the depth as pressure",
        old="history.pressure",
        new="history.depth",
        tests="wear::test_the_table_says_what_the_arrays_say",
    ),
)
