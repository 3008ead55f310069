"""Figures of the paper's scene, one script each: `python -m paper_figures` computes the data they lack and draws them."""
