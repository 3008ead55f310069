"""Transients in increments: their states, their cycles, and the steady state that these lead to."""
