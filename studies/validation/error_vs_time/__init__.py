"""Error against run time of every computation; see `study` for how to run it."""
