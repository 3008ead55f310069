"""What happens at the edge of what can be asked; `study` says how to ask it."""
