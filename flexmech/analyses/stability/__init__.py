"""Stability of the running linkage: Floquet multipliers over the crank speed."""
