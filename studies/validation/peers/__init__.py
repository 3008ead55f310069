"""The same contacts by frictopt and by other codes; see `study` for how to run it."""
