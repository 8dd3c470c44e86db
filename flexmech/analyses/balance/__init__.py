"""Counterweights against the shaking force of a linkage, and their cost."""
