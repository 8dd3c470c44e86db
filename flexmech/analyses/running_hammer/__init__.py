"""What a force on the running linkage does: harmonic transfer functions of a periodic system."""
