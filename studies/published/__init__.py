"""Results of others beside ours; see `study` for how to run it."""
