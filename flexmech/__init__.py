"""Flexible linkages: moving natural frequencies, by two independent engines."""
