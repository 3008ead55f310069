"""Programs that run peers: each is run alone by another Python, and imports nothing of frictopt."""
