"""Thousands of random contacts; see `study` for how to run them."""
