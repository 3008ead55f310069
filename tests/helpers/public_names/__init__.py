"""The lists that grow with a public name, in one place.

A new public function or class has an entry in:

- `frictopt/__init__.pyi`: the import and `__all__`. A part of a finite-element model has its entry
  in `frictopt/fem/__init__.pyi` instead, a reader in `frictopt/readers/__init__.pyi`, a result in
  `frictopt/results.py`, a scene in `frictopt/scenes/__init__.py`;
- one page of `docs/api`;
- `called.py`: a good call with all its arguments. Tests replace them by odd values and contacts.

A new question about contacts has further entries in:

- `asked.py`: its call for a small contact, and a row of `docs/questions.md`, which shows for each
  kind of contact whether there is an answer;
- `cited.py`: the equation of the theory page that its docstring cites.

Readers have rows in `docs/formats.md`. A call that may take minutes has an entry in `CALLS` of
`tests/base/test_progress.py`, with the part of its answer that an interrupt keeps.
"""
