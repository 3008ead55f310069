"""The parts that all answers share, and what a limit says and proves.

`answered.py` has the base classes of answers. `shakedown_answer.py` has what a limit proves about
other states, and the slip that must occur above the limit. `sentences.py` has the sentences of the
reasons, `reasons.py` chooses among them.
"""
