"""Numerical studies, one a file or folder: each computes tables and writes them with their provenance."""
