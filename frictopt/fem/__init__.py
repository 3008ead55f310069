"""Finite-element models of a contact, condensed to its interface."""
