"""Random contacts by the thousand; `study` says how to run them."""
