"""Extreme input; see `study` for how to run it."""
