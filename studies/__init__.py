"""Numerical studies, each in a file or a folder; each computes tables and writes them with their origin."""
