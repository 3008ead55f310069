"""Joints from files: a deck of CalculiX or Abaqus with its contacts, loads and steps.

In comes a deck, out goes a `Joint`: a `ContactModel`, its friction, its load cases, and the states
at the ends of the steps, of which load cycles are made.

- `joint.py`: `read_joint`, and `Joint` with its systems and load cycles
- `deck_conditions.py`: a deck beside its mesh: materials, contacts, bolts, and the load of steps
- `states.py`: the loads in force at the end of each step, as amplitudes of load cases
- `deck_model.py`: conditions and mesh as a `ContactModel`
- `refused.py`: the keywords that are refused, and those without effect

To read one more keyword, write its function in `deck_conditions.py` and add it to `READ`. To refuse
one, add a row to `REFUSED`. Then list it in `docs/formats.md`.
"""
