"""The command line `frictopt`: from files to limits, steady states, tables and pictures.

The input is the arguments of a shell. The output is text or JSON, files, and an exit code.

- `main.py`: runs a command; errors, interrupts and their exit codes
- `questions.py`: the list of the questions, and how each is asked of a contact in a file
- `options.py`: options of a command, from the signature and the docstring of its function
- `inputs.py`: contact, load cycle and friction from files and arguments
- `answers.py`: an answer as text, as JSON, as a table and as a picture
- `files.py`: `look`, `compare` and `check`, on files alone
- `studies.py`: `study` and `merge`

Commands import what they need when they run, so that `frictopt --help` is quick.
"""
