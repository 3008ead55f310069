"""Planted faults of `joint_files`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "joint_files/states.py",
        "a load of a later step is added to that of its place",
        old="key not in self._of_this_step",
        new="key not in self.loads",
        tests="deck_states",
    ),
    Fault(
        "joint_files/states.py",
        "OP=NEW removes the loads of every block",
        old="kinds not in self._begun",
        new="True",
        tests="deck_states",
    ),
    Fault(
        "joint_files/deck_conditions.py",
        "an amplitude counts at the begin of its step",
        old="np.interp(self._time, *self._table(block))",
        new="np.interp(0.0, *self._table(block))",
        tests="deck_states",
    ),
    Fault(
        "joint_files/deck_model.py",
        "forces on nodes are not divided by the thickness",
        old="force = self._nodal(loads) / self.thickness",
        new="force = self._nodal(loads)",
        tests="deck_states decks",
    ),
    Fault(
        "joint_files/deck_model.py",
        "a node in the middle of a face is held with one node of it",
        old="is_made @ rows.astype(int) == np.diff(is_made.indptr)",
        new="is_made @ rows.astype(int) > 0",
        tests="decks",
    ),
    Fault(
        "joint_files/joint.py",
        "a corner that is a state is on top of the mean load",
        old="change.get(case, 0.0) - base.get(case, 0.0)",
        new="change.get(case, 0.0)",
        tests="deck_states",
    ),
    Fault(
        "joint_files/deck_model.py",
        "ties move their nodes against ADJUST=NO",
        old='pair.block.parameters.get("ADJUST") != "NO"',
        new="True",
        tests="decks",
    ),
    Fault(
        "joint_files/deck_conditions.py",
        "a pair that is tied may slide",
        old='kind == "TIED"',
        new='kind == "GLUED"',
        tests="decks",
    ),
    Fault(
        "joint_files/deck_model.py",
        "ADJUST moves no nodes",
        old="Contact(*names, *pair[:2], name, gap, adjust, *rough)",
        new="Contact(*names, *pair[:2], name, gap, None, *rough)",
        tests="decks",
    ),
    Fault(
        "joint_files/states.py",
        "loads of earlier steps do not fade within a step",
        old="value * (1 - self.share)",
        new="value * (self.share < 1)",
        tests="deck_states",
    ),
    Fault(
        "joint_files/deck_conditions.py",
        "a pair that is added again stays removed",
        old="del self._in_force.removed[surfaces]",
        new="pass",
        tests="deck_states",
    ),
    Fault(
        "joint_files/deck_conditions.py",
        "the stick slope is the normal stiffness",
        old="self.stiffness[self._interaction][0] = number(slope[0])",
        new="self.stiffness[self._interaction][1] = number(slope[0])",
        tests="decks",
    ),
    Fault(
        "joint_files/deck_model.py",
        "contact nodes have the rows of the deck as numbers",
        old="self.deck.numbers[self.origin[part][single].indices]",
        new="self.origin[part][single].indices",
        tests="decks",
    ),
)
