"""Joints from files: a deck with its contacts, loads and steps, or a joint file in TOML.

The input is a file, and the result is a `Joint`: a `ContactModel`, its friction, its load cases,
and the states at the ends of the steps, from which load cycles are made.

- `read_joint.py`: `read_joint`, for decks and joint files
- `joint.py`: `Joint` with its system and load cycles
- `deck_conditions.py`: what a deck has apart from its mesh: materials, contacts, bolts, loads
- `states.py`: the loads in force at the end of each step, as amplitudes of load cases
- `deck_model.py`: the `ContactModel` of these conditions and the mesh
- `refused.py`: keywords that are refused, and keywords without effect

To read another keyword, write a method `_read_<keyword>` in `deck_conditions.py`. To refuse a
keyword, add it to `refused.py`. Then list the keyword in `docs/formats.md`.
"""
