"""Numerical studies of the paper's scene, one a file: each computes tables and writes them with their provenance."""
