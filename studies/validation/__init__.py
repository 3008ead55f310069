"""Studies that compare the package with independent answers.

There are independent methods (`oracles`), random contacts, extreme input, and direct calls of other
packages.
"""
