"""One link: mass, stiffness, rotation terms, bodies, component modes and readings."""
