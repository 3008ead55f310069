"""Results of others beside results of frictopt; see `study` for how to run it."""
