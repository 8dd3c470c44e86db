"""Hammer test on the running linkage: harmonic transfer functions, identified and predicted."""
