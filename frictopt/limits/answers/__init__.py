"""Base classes of all answers, and the proofs and reasons of a limit.

`answered.py` has the base classes of answers. `shakedown_answer.py` has what a limit proves about
other states, and the slip that must occur above the limit. `sentences.py` has the sentences of the
reasons, and `reasons.py` chooses among these sentences.
"""
