"""Joints from files: a deck with its contacts, loads and steps, or a joint file in TOML.

In comes a file, out goes a `Joint`: a `ContactModel`, its friction, its load cases, and the states
at the ends of the steps, of which load cycles are made.

- `read_joint.py`: `read_joint`, of decks and of joint files
- `joint.py`: `Joint` with its system and load cycles
- `deck_conditions.py`: a deck beside its mesh: materials, contacts, bolts, and the load of steps
- `states.py`: the loads in force at the end of each step, as amplitudes of load cases
- `deck_model.py`: conditions and mesh as a `ContactModel`
- `refused.py`: the keywords that are refused, and those without effect

To read one more keyword, write the method of its name in `deck_conditions.py`. To refuse one, add
it to `refused.py`. Then list it in `docs/formats.md`.
"""
