"""Stiffness matrices, decks and meshes of other codes."""
