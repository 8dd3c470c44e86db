"""The assembled system, and what an engine is."""
