"""The program of a question about states of rest, as arrays, and its solution.

- `question.py`: a question as data: all its arrays, the units of its unknowns, the corners that
  matter, and the check of its answers.
- `rest_program.py`: the arrays of a program, and its unknowns; `assembled.py`: the programs of the
  questions, with the rows of the contact law.
- `solution.py`: the solution of a program, what its multipliers prove, and the slip mechanism that
  they form.
- `rest_slips.py`: the sets of slips of states of rest and of steady cycles, and how far they go.
"""
