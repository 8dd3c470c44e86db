"""Response of the running linkage to a force: transfer functions of a periodic system."""
