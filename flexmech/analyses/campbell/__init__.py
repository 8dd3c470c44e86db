"""Campbell diagram: natural frequencies over crank speed, and critical speeds."""
