"""Data sets of others beside frictopt; see `study` for how to run it."""
