"""Equations of motion of a linkage driven by its shaft: matrices, loads and forces over time."""
