"""The parts that all answers share, and what a limit says and proves.

`answered.py` has the base classes of answers, `shakedown_answer.py` what a limit proves about other
states, and the slip that it proves above it. `sentences.py` has the sentences of the reasons,
`reasons.py` chooses among them.
"""
