"""The lists that grow with a public name, in one place.

A new public function or class has an entry in:

- `frictopt/__init__.pyi`: the import and `__all__`; instead, a result in `frictopt/results.py`, a
  scene in `frictopt/scenes/__init__.py`;
- one page of `docs/api`;
- `called.py`: a good call with all its arguments, to which tests give odd values and odd contacts.

A new question of contacts has one more in:

- `asked.py`: how it is asked of a small contact, and a row of `docs/questions.md`, which says for
  each kind of contact whether it answers;
- `cited.py`: the equation of the theory page that its docstring cites.

Readers have rows in `docs/formats.md`. A call that may take minutes has an entry in `CALLS` of
`tests/base/test_progress.py`, with the part of its answer that an interrupt keeps.
"""
