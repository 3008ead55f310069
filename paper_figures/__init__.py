"""Figures of the paper's scene, one script each: `python -m paper_figures` computes missing data and draws them."""
