"""Natural frequencies of the moving linkage: over crank angle and crank speed, and at positions."""
